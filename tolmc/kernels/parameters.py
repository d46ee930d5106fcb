"""Rows of the parameter array (row, sample): every physical scalar of a sample stands in the sample's own column.

The last rows are no scalars of the scene. LOAD_ENERGY (J) is the size of its potential energy's variation: the scale of energy
errors where the body hardly moves. COS_MEAN to SIN_HALF belong to half the sum and half the difference of the start angles, for
the symmetric slope forms: taken once for a scene whose angles do not vary, they save each motion half a step's time. HELD, the
plan's, is 1 where a drive holds the spin rate of a motion with friction.
"""

from __future__ import annotations

(
    RADIUS, HALF_LENGTH, MASS,
    COM_X, COM_Y, COM_Z,
    J_XX, J_YY, J_ZZ, J_XY, J_XZ, J_YZ,
    GRAVITY_X, GRAVITY_Y, GRAVITY_Z,
    FORCE_X, FORCE_Y, FORCE_Z, POINT_X, POINT_Y, POINT_Z,
    TORQUE_X, TORQUE_Y, TORQUE_Z,
    ALPHA, BETA, ALPHA_RATE, BETA_RATE, SPIN, SPIN_RATE,
    BEARING_RADIUS, JOURNAL_RADIUS,
    LOAD_ENERGY,
    COS_MEAN, SIN_MEAN, COS_HALF, SIN_HALF,
    RESTITUTION, CONTACT_STIFFNESS, FRICTION, SLIP_SPEED, WEAR_COEFFICIENT,
    ORIGIN_X, ORIGIN_Y, SLOPE_X, SLOPE_Y, ORIGIN_RATE_X, ORIGIN_RATE_Y, SLOPE_RATE_X, SLOPE_RATE_Y,
    FORCE_TERM_1_X, FORCE_TERM_1_Y, FORCE_TERM_1_Z, FORCE_TERM_1_FREQUENCY, FORCE_TERM_1_PHASE,
    FORCE_TERM_2_X, FORCE_TERM_2_Y, FORCE_TERM_2_Z, FORCE_TERM_2_FREQUENCY, FORCE_TERM_2_PHASE,
    TORQUE_TERM_1_X, TORQUE_TERM_1_Y, TORQUE_TERM_1_Z, TORQUE_TERM_1_FREQUENCY, TORQUE_TERM_1_PHASE,
    TORQUE_TERM_2_X, TORQUE_TERM_2_Y, TORQUE_TERM_2_Z, TORQUE_TERM_2_FREQUENCY, TORQUE_TERM_2_PHASE,
    DRIVE_AMPLITUDE, DRIVE_FREQUENCY, DRIVE_PHASE,
    HELD,
) = range(74)  # fmt: skip

COUNT = 74
