"""Rows of the results (row, sample), a block a watcher, and the codes that stand in them."""

from __future__ import annotations

(
    # extrema and means
    D_MAX, D_MIN, D_MEAN, D_RMS, E_MAX, E_MIN, E_MEAN, E_RMS, TILT_MAX,
    # contact loss
    LOSS_TIME,
    # energy; constraints
    ENERGY_ERROR, CONSTRAINT_ERROR,
    # the engine's own: how far a motion came
    END_TIME, STATUS,
    # pose at the end
    ORIGIN_X, ORIGIN_Y, AXIS_X, AXIS_Y, AXIS_Z,
    # the roughest step's error, how many are as rough; what is left of an extremum, or of the force where contact is lost
    ROUGHEST, AS_ROUGH, DOUBT,
    # invariants; energy; the last three are the caller's
    MOMENTUM_ERROR, ENERGY_CORRECTION, STEP_ERROR, SPIN_ERROR, HALVING_ERROR,
) = range(27)  # fmt: skip
RESULTS = 27
# The state at a loss of contact that ends a motion, in the coordinates of its formulation.
STATE = RESULTS
RESULTS += 10

OK, CONTACT_LOST, DIVERGED = 0, 1, 2  # codes in row STATUS
CONTINUE, END = 0, 1  # what a loss of contact does

# What a motion with one-sided contact has besides, and codes of what became of it, after those of all others (judge.py).
(
    D_IMPACTS, D_IMPACT_SPEED_MAX, D_IMPULSE_MAX, D_IMPULSE_TOTAL, D_CLOSED_SHARE, D_IMPACT_FORCE_MAX,
    E_IMPACTS, E_IMPACT_SPEED_MAX, E_IMPULSE_MAX, E_IMPULSE_TOTAL, E_CLOSED_SHARE, E_IMPACT_FORCE_MAX,
    FREE_SHARE, FIRST_IMPACT, IMPACT_LOSS,
) = range(RESULTS, RESULTS + 15)  # fmt: skip
RESULTS += 15
# What friction and a drive add.
(
    FRICTION_TORQUE_MAX, FRICTION_TORQUE_MEAN, FRICTION_POWER_MEAN, FRICTION_WORK, D_SLIP_WORK, E_SLIP_WORK, SLOW_SHARE,
    WHIRL_RATE_MEAN, SPIN_END, DRIVE_TORQUE_MAX, DRIVE_TORQUE_MEAN, DRIVE_POWER_MEAN,
) = range(RESULTS, RESULTS + 12)  # fmt: skip
RESULTS += 12
# What wear adds.
WEAR_RATE = RESULTS
RESULTS += 1
TOO_MANY_IMPACTS, CONTACT_UNRESOLVED, NO_CONTACT_FORCES = 9, 10, 11
