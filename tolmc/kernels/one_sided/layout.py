"""Rows of every array of the one-sided kernels, by name.

Lengths inside are in units of c, the size of the clearance: r on the circle, R* - r* on the exact section; o = (X0, Y0)/c,
w = (u, v)/c, kappa = c/L, s = kappa w the slope of the axis. Forces are over m c, generalised forces belong to the speeds
(o', w', Omega/kappa), energies are over m c^2. Arrays are flat, (row, lane) with lanes last.
"""

from __future__ import annotations

from tolmc.kernels import results as R
from tolmc.kernels.lanes import WIDTH as WIDTH

# The state; a symmetric body without friction has the first eight, with friction nine.
O_X, O_Y, W_X, W_Y, OV_X, OV_Y, WV_X, WV_Y, SPIN_RATE, COS, SIN = range(11)

# What is given for each sample beside the parameters: the start, SI units, and the laws of contact. ON_D and ON_E are 1 where
# the start lies on the wall by construction; LOSS is -1, or the end (0: D, 1: E) that has just left the wall; REST is the
# height over c below which a bounce is not followed. A RESTITUTION below 0 ends the motion where it loses contact; HELD is 1
# where a drive says Omega. PHASE_1 on are the phases of what swings: the parts of the loads, and last the drive; TURNS_1 on
# are 1 where a part's axes turn with the body.
(
    START_X, START_Y, START_U, START_V, START_X_RATE, START_Y_RATE, START_U_RATE, START_V_RATE, CHI, OMEGA, TIME,
    ON_D, ON_E, LOSS, RESTITUTION, STIFFNESS, FRICTION, SLIP_SPEED, REST, HELD,
    PHASE_1, PHASE_2, PHASE_3, PHASE_4, PHASE_DRIVE, TURNS_1, TURNS_2, TURNS_3, TURNS_4,
) = range(29)  # fmt: skip
GIVEN = 29

# Coefficients that every body and section has; a body's own follow from FIRST on.
(
    CLOSED_D, CLOSED_E, KAPPA, KAPPA2, ROUND, BOUNCE, HERTZ, MU, SLIP, REST_HEIGHT, C, FORCE, ENERGY,
    FX, FY, GX, GY, GZ, OMEGA_FIXED, STEP, DRIVEN,
) = range(21)  # fmt: skip
FIRST = 21

# What is known of a lane at one instant; with friction MARGIN is positive where the closed contacts' forces are determined,
# SLOW negative where one of them slides more slowly than the slip speed, WHIRL the sum of the closed ends' polar rates; where
# something swings DRIVE_POWER is the drive's. Rates of forces and moments are those along the motion.
(
    N_D, N_E, GAP_D, GAP_E, RATE_D, RATE_E, ACC_D, ACC_E, W2, W2_RATE, N_RATE_D, N_RATE_E, KINETIC, POTENTIAL, POWER, SLIP_D,
    SLIP_E, HEAT, TORQUE, SLOW, MARGIN, WHIRL, DRIVE, TORQUE_RATE, DRIVE_RATE, DRIVE_POWER,
) = range(26)  # fmt: skip
SEEN = 26

# What is taken at every stage: the forces, and where there is friction or a torque their powers; TORQUE is the size of
# friction's moment about the axis, DRIVE the moment that holds Omega. |w|^2, W2, is taken at a step's ends alone.
S_D, S_E, S_POWER, S_SLIP_D, S_SLIP_E, S_HEAT, S_TORQUE, S_WHIRL, S_DRIVE, S_DRIVE_POWER, S_W2 = range(11)

# What a lane carries along, and sets out from at zero.
(
    T, HINT, TRIES, SAMPLE, BUSY, MODE, ARMED_D, ARMED_E, HOLD, LOAD_REFERENCE,
    BEST_D_MAX, BEST_D_MIN, BEST_E_MAX, BEST_E_MIN, BEST_TILT,
    INTEGRAL_D, INTEGRAL_E, SQUARE_D, SQUARE_E, TIME_D, TIME_E, TIME_FREE,
    WORK, ENERGY_0, ENERGY_ERROR, ENERGY_SCALE, MOMENTUM_0, PENETRATION, STATUS, EVENTS, ROUNDS,
    LOST_AT, HIT_AT, IMPACT_LOSS,
    COUNT_D, COUNT_E, SPEED_D, SPEED_E, IMPULSE_D, IMPULSE_E, TOTAL_D, TOTAL_E, PEAK_D, PEAK_E,
) = range(44)  # fmt: skip
# The same with friction.
(
    WORK_SLIP_D, WORK_SLIP_E, WORK_HEAT, TORQUE_INTEGRAL, TIME_SLOW, TORQUE_MAX, TURN, DRIVE_INTEGRAL, DRIVE_MAX, DRIVE_WORK,
) = range(44, 54)  # fmt: skip
FRICTIONLESS, RUBBING = 44, 54
# What one round's loops leave for the next ones: the time gone, the length of a step but for the wall (0 where it is not aimed
# at), whether it may come to it all the same, the time from a step's end to the wall, who takes part in an impact, who may
# stay, whether it is an impact, whether anything was struck and whether all contacts leave; and rows E_TIME to E_E of the last
# event.
(
    GONE, CAP, DOUBT, REST_D, REST_E, ON_THE_WALL_D, ON_THE_WALL_E, CAN_STAY_D, CAN_STAY_E, HITS, STRUCK, LEAVES,
) = range(54, 66)  # fmt: skip
LAST_EVENT, CARRIED = 66, 74

# What becomes of a lane after a round: the start is kept and the step shortened, or the step is taken; then an event.
KEEP, TAKE, IMPACT, RELEASE_D, RELEASE_E, RELEASE_BOTH, FALL_BACK_D, FALL_BACK_E, START = range(9)

# Beside the rows of :mod:`tolmc.kernels.results`, where motions that keep contact leave their states: what a lane has taken.
R_ROUNDS, R_EVENTS = R.STATE, R.STATE + 1

# Rows of a record along one motion.
(
    T_TIME, T_X, T_Y, T_U, T_V, T_D, T_E, T_CLOSED_D, T_CLOSED_E, T_KINETIC, T_POTENTIAL, T_WORK, T_LOSS, T_OMEGA,
) = range(14)  # fmt: skip
RECORD = 14
# Rows of an event: time, kind (0 impact, 1 release, 2 closing), impulses, approach speeds, ends that take part.
E_TIME, E_KIND, E_IMPULSE_D, E_IMPULSE_E, E_SPEED_D, E_SPEED_E, E_D, E_E = range(8)
EVENT = 8

# What becomes of a motion, by the codes of its results.
OK, DIVERGED, TOO_MANY, NO_SOLUTION, LOST = R.OK, R.DIVERGED, R.TOO_MANY_IMPACTS, R.NO_CONTACT_FORCES, R.CONTACT_LOST
PENETRATES = UNRESOLVED = R.CONTACT_UNRESOLVED
