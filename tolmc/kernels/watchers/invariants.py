"""What the motion keeps besides its energy: the constraints, and the angular momentum about Z where no load turns it."""

from __future__ import annotations

import math

from tolmc.kernels.jit import piece, routine
from tolmc.kernels.lanes import WIDTH
from tolmc.kernels.results import CONSTRAINT_ERROR, MOMENTUM_ERROR
from tolmc.kernels.system import System
from tolmc.kernels.watchers import Watcher


def constraints(system: System) -> Watcher:
    """Watcher of the largest constraint error left after a projection."""
    largest, error_rows, open_motion = system.layout.row(), system.stepper.error, system.open_motion

    @routine
    def begin(run, block, step, y, end, coef, work):
        for lane in range(WIDTH):
            work[largest + lane] = 0.0

    @piece
    def look(run, block, step, y, end, coef, work):
        error = work[error_rows]
        for lane in range(WIDTH):
            counts = work[open_motion + lane] > 0.0 and error[lane] > work[largest + lane]
            work[largest + lane] = error[lane] if counts else work[largest + lane]

    @routine
    def finish(run, block, step, y, end, coef, work):
        for lane in range(min(WIDTH, run.raw.shape[1] - block)):
            run.out[CONSTRAINT_ERROR, block + lane] = work[largest + lane]

    return Watcher(begin, look, finish)


def angular_momentum(system: System) -> Watcher:
    """Watcher of the momentum's change between the motion's start and end, relative to the largest it can have.

    That is sqrt(2 T I) by Cauchy and Schwarz, T the energy's scale and I the momentum of a unit turn, and the constant part.
    """
    momentum, at_start, fastest = system.equations.momentum, system.layout.row(), system.energy_scale

    @routine
    def begin(run, block, step, y, end, coef, work):
        for lane in range(WIDTH):
            work[at_start + lane], _, _ = momentum(y, coef, lane, WIDTH)

    @routine
    def finish(run, block, step, y, end, coef, work):
        for lane in range(min(WIDTH, run.raw.shape[1] - block)):
            about_z, turn, constant = momentum(y, coef, lane, WIDTH)
            change = abs(about_z - work[at_start + lane])
            scale = math.sqrt(2.0 * work[fastest + lane] * turn) + constant
            run.out[MOMENTUM_ERROR, block + lane] = change / scale if change != 0.0 else 0.0

    return Watcher(begin=begin, finish=finish)
