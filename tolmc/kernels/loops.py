"""The loops of the kernels, over blocks of lanes and over steps, with names that stand for the parts of one kernel.

These functions are templates: :mod:`engine` makes an entry of each with the parts of its own in place of the names below.
"""

from __future__ import annotations

import numpy as np

from tolmc.kernels.lanes import WIDTH, Run, lanes, no, yes
from tolmc.kernels.results import DIVERGED, END_TIME, MOMENTUM_ERROR, OK, STATUS

#: Of the equations.
prepare = start = observe_lane = None
state = torque = None
#: The step, the watchers' functions, the projection on the energy.
step_once = begin = look = finish = project_energy = None
#: Rows of the buffer, and how many there are.
rows = y_rows = end_rows = coef_rows = h_rows = sum_rows = target_rows = correction_rows = None
open_forces = open_motion = bad_step = None


def integrate(raw, steps, duration, on_loss, project_energy, force_step, force_at, ignore_step, out):
    """Every column of ``raw``, block by block: its results to ``out``."""
    run = Run(raw, steps, duration, duration / steps, on_loss, project_energy, force_step, force_at, ignore_step, out)
    work = lanes(rows)
    y, end, coef, h = work[y_rows], work[end_rows], work[coef_rows], work[h_rows]
    n = raw.shape[1]
    for block in range(0, n, WIDTH):
        for lane in range(WIDTH):
            i = min(block + lane, n - 1)
            prepare(raw, i, coef, lane, WIDTH)
            start(raw, i, y, coef, lane, WIDTH)
            h[lane] = run.step_length
        for lane in range(WIDTH):
            work[open_forces + lane], work[open_motion + lane], work[bad_step + lane] = 1.0, 1.0, -1.0
        begin(run, block, 0, y, end, coef, work)
        for step in range(steps):
            step_once(y, end, coef, h, work, yes())
            look(run, block, step, y, end, coef, work)
            y, end = end, y
        # How far each lane came; the watchers amend it.
        for lane in range(min(WIDTH, n - block)):
            i = block + lane
            out[STATUS, i], out[END_TIME, i], out[MOMENTUM_ERROR, i] = OK, duration, 0.0
            if work[bad_step + lane] >= 0.0:
                out[STATUS, i], out[END_TIME, i] = DIVERGED, (work[bad_step + lane] + 1.0) * run.step_length
        finish(run, block, steps, y, end, coef, work)


def trace(raw, steps, duration, on_energy, states, coef):
    """The states of column 0 of ``raw`` at the ends of all steps; the block's lanes all carry the same motion."""
    work = lanes(rows)
    y, end, h, sums = work[y_rows], work[end_rows], work[h_rows], work[sum_rows]
    target, correction = work[target_rows], work[correction_rows]
    for column in range(1):  # a literal 0 would compile the equations once more
        for lane in range(WIDTH):
            prepare(raw, column, coef, lane, WIDTH)
            start(raw, column, y, coef, lane, WIDTH)
    for lane in range(WIDTH):
        h[lane], correction[lane] = duration / steps, 0.0
        _, _, _, _, _, _, _, _, kinetic, potential, _ = observe_lane(y, coef, lane)
        target[lane] = kinetic + potential
    for c in range(state):
        states[0, c] = y[c * WIDTH]
    for step in range(steps):
        step_once(y, end, coef, h, work, no())
        if on_energy:
            if torque:
                for lane in range(WIDTH):
                    target[lane] += sums[4 * WIDTH + lane]
            project_energy(end, coef, target, correction)
        y, end = end, y
        for c in range(state):
            states[step + 1, c] = y[c * WIDTH]


def observe(states, coef, out):
    """What the equations observe in every row of ``states``."""
    y = np.empty(state * WIDTH)
    for row in range(states.shape[0]):
        for c in range(state):
            y[c * WIDTH] = states[row, c]
        for lane in range(1):  # as above
            values = observe_lane(y, coef, lane)
            for j in range(11):
                out[j, row] = values[j]
