"""What friction does along a motion: slip work, heat, its moment about the axis, whirl, and what holds a driven spin.

Integrals are quadratures with the method's own weights. The time below the slip speed is linear within a step: weights of
either sign suit no jump. A motion ends where the contact forces are no longer determined (Painleve): at the first end of a step
whose margin is not positive.
"""

from __future__ import annotations

import numpy as np

from tolmc.kernels import parameters as P
from tolmc.kernels.jit import device, routine
from tolmc.kernels.lanes import WIDTH
from tolmc.kernels.results import (
    D_SLIP_WORK,
    DRIVE_POWER_MEAN,
    DRIVE_TORQUE_MEAN,
    E_SLIP_WORK,
    END_TIME,
    FRICTION_POWER_MEAN,
    FRICTION_TORQUE_MEAN,
    FRICTION_WORK,
    NO_CONTACT_FORCES,
    SLOW_SHARE,
    SPIN_END,
    STATUS,
    WHIRL_RATE_MEAN,
)
from tolmc.kernels.seen import HEAT, MARGIN, SLIP_D, SLOW, SUM_S, SUM_SIZE, SUM_TORQUE, TORQUE
from tolmc.kernels.system import System
from tolmc.kernels.watchers import Watcher

_SUMS = SUM_S - SLIP_D + 1


@device
def slow_share(first, last):
    """Share of a step in which a quantity is negative that is linear between its values ``first`` and ``last``."""
    size = abs(first) + abs(last)
    return (max(-first, 0.0) + max(-last, 0.0)) / size if size > 0.0 else 0.0


def watch(system: System) -> Watcher:
    """Watcher of the integrals up to where a lane's motion ends."""
    layout, until, at, spin_rate = system.layout, system.until, system.at, system.equations.spin_rate
    sum_rows, slow, failed = layout.block(_SUMS), layout.row(), layout.row()
    part_h, part_rows, end_rows = system.part_h, system.part_seen, system.end_seen
    until_rows = slice(until, until + WIDTH)
    heat, size, moment, whirl = (row - SLIP_D for row in (HEAT, SUM_SIZE, SUM_TORQUE, SUM_S))

    @routine
    def begin(run, block, y, coef, work):
        work[sum_rows] = 0.0
        for lane in range(WIDTH):
            work[slow + lane], work[failed + lane] = 0.0, np.inf

    @routine
    def add(seen, after, reached, until, sums, slow_steps):
        """The integrals over one step."""
        for lane in range(WIDTH):
            counts = reached <= until[lane]
            for row in range(_SUMS):
                sums[row * WIDTH + lane] += seen[(SLIP_D + row) * WIDTH + lane] if counts else 0.0
            share = slow_share(seen[SLOW * WIDTH + lane], after[SLOW * WIDTH + lane])
            slow_steps[lane] += share if counts else 0.0

    @routine
    def test(seen, reached, until, first):
        """Where the forces are not determined at an end for the first time."""
        for lane in range(WIDTH):
            fails = (reached <= until[lane]) & ~(seen[MARGIN * WIDTH + lane] > 0.0) & (first[lane] == np.inf)
            first[lane] = reached if fails else first[lane]

    @routine
    def scan(run, block, window, coef, work):
        sums, ends, slow_steps = work[sum_rows], work[until_rows], work[slow : slow + WIDTH]
        first = work[failed : failed + WIDTH]
        if window.head == 0:
            test(at(window.seen, 0), window.first + 0.0, ends, first)
        for row in range(window.head, window.tail + 1):
            here, after, reached = at(window.seen, row), at(window.seen, row + 1), window.first + row + 1.0
            add(here, after, reached, ends, sums, slow_steps)
            test(after, reached, ends, first)

    @routine
    def finish(run, block, y, coef, work):
        sums, part, end, length, ends = (
            work[sum_rows],
            work[part_rows],
            work[end_rows],
            work[part_h],
            work[until_rows],
        )
        for lane in range(WIDTH):
            if length[lane] > 0.0:
                for row in range(_SUMS):
                    sums[row * WIDTH + lane] += part[(SLIP_D + row) * WIDTH + lane]
                share = slow_share(part[SLOW * WIDTH + lane], end[SLOW * WIDTH + lane])
                work[slow + lane] += share * (length[lane] / run.step_length)
        for lane in range(min(WIDTH, run.samples - block)):
            i, span = block + lane, ends[lane] * run.step_length
            held, omega = run.raw[P.HELD, i], spin_rate(y, coef, lane, WIDTH)
            run.out[D_SLIP_WORK, i], run.out[E_SLIP_WORK, i] = sums[lane], sums[WIDTH + lane]
            run.out[FRICTION_WORK, i], run.out[SPIN_END, i] = sums[heat * WIDTH + lane], omega
            # Of a motion that is over at once the means are the values there.
            per_time = 1.0 / span if span > 0.0 else 0.0
            power, torque = per_time * sums[heat * WIDTH + lane], per_time * sums[size * WIDTH + lane]
            signed, turned = per_time * sums[moment * WIDTH + lane], per_time * sums[whirl * WIDTH + lane]
            if not span > 0.0:
                signed, turned = end[TORQUE * WIDTH + lane], end[SUM_S * WIDTH + lane]
                power, torque = end[HEAT * WIDTH + lane], abs(signed)
            run.out[FRICTION_POWER_MEAN, i], run.out[FRICTION_TORQUE_MEAN, i] = power, torque
            run.out[SLOW_SHARE, i], run.out[WHIRL_RATE_MEAN, i] = (
                work[slow + lane] / (ends[lane] if span > 0.0 else 1.0),
                turned,
            )
            drive = -held * signed
            run.out[DRIVE_TORQUE_MEAN, i], run.out[DRIVE_POWER_MEAN, i] = drive, drive * omega
            if work[failed + lane] <= ends[lane]:
                run.out[STATUS, i], run.out[END_TIME, i] = NO_CONTACT_FORCES, work[failed + lane] * run.step_length

    return Watcher(begin=begin, scan=scan, finish=finish)
