"""What the motion keeps besides its energy: the constraints, and the angular momentum about Z where no load turns it."""

from __future__ import annotations

import math

from tolmc.kernels.jit import device, routine
from tolmc.kernels.lanes import WIDTH
from tolmc.kernels.results import CONSTRAINT_ERROR, MOMENTUM_ERROR
from tolmc.kernels.seen import ERROR
from tolmc.kernels.system import System
from tolmc.kernels.watchers import Watcher


def constraints(system: System, windows: bool) -> Watcher:
    """Watcher of the largest constraint error left after a projection."""
    largest, until, part_h = system.layout.row(), system.until, system.part_h
    part_seen, at = system.part_seen, system.at

    @routine
    def begin(run, block, y, coef, work):
        for lane in range(WIDTH):
            work[largest + lane] = 0.0

    @device
    def look(run, step, end, coef, seen, work):
        for lane in range(WIDTH):
            error = seen[ERROR * WIDTH + lane]
            work[largest + lane] = error if error > work[largest + lane] else work[largest + lane]

    @routine
    def scan(run, block, window, coef, work):
        for row in range(window.head, window.tail + 1):
            seen, reached = at(window.seen, row), window.first + row + 1.0
            for lane in range(WIDTH):
                error = seen[ERROR * WIDTH + lane]
                counts = reached <= work[until + lane] and error > work[largest + lane]
                work[largest + lane] = error if counts else work[largest + lane]

    @routine
    def finish(run, block, y, coef, work):
        part, length = work[part_seen], work[part_h]
        for lane in range(min(WIDTH, run.samples - block)):
            error = work[largest + lane]
            if windows and length[lane] > 0.0:
                error = max(error, part[ERROR * WIDTH + lane])
            run.out[CONSTRAINT_ERROR, block + lane] = error

    return Watcher(begin, None if windows else look, scan if windows else None, finish)


def angular_momentum(system: System) -> Watcher:
    """Watcher of the momentum's change between the motion's start and end, relative to the largest it can have.

    That is sqrt(2 T I) by Cauchy and Schwarz, T the energy's scale and I the momentum of a unit turn, and the constant part.
    Whether it is conserved the run says: kernels of their own for that would be twice as many to compile.
    """
    momentum, at_start, fastest = system.equations.momentum, system.layout.row(), system.energy_scale

    @routine
    def begin(run, block, y, coef, work):
        if run.momentum:
            for lane in range(WIDTH):
                work[at_start + lane], _, _ = momentum(y, coef, lane, WIDTH)

    @routine
    def finish(run, block, y, coef, work):
        for lane in range(min(WIDTH, run.samples - block) if run.momentum else 0):
            about_z, turn, constant = momentum(y, coef, lane, WIDTH)
            change = abs(about_z - work[at_start + lane])
            scale = math.sqrt(2.0 * work[fastest + lane] * turn) + constant
            run.out[MOMENTUM_ERROR, block + lane] = change / scale if change != 0.0 else 0.0

    return Watcher(begin=begin, finish=finish)
