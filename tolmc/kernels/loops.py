"""The loops of the kernels, over blocks of lanes and over steps, with names that stand for the parts of one kernel.

These functions are templates: :mod:`engine` makes an entry of each with the parts of its own in place of the names below, and
of the loops over blocks that it calls a piece.
"""

from __future__ import annotations

from typing import Any

from tolmc.kernels.bare import Rows, Table
from tolmc.kernels.lanes import WIDTH, Run
from tolmc.kernels.results import AS_ROUGH, DIVERGED, DOUBT, END_TIME, MOMENTUM_ERROR, OK, ROUGHEST, STATUS
from tolmc.kernels.seen import REACH, STEPS, WORK, Window

#: Of the equations.
prepare = start = observe_lane = None
state = torque = None
#: How much is seen at the end of a step, and the view of it in a window.
what = at = None
#: The step and the look, the watchers' functions, the projection on the energy.
step_once = see = begin = look = scan = finish = project_energy = None
#: The loop over blocks that an entry calls.
blocks: Any = None
#: Rows of the buffer.
y_rows = end_rows = coef_rows = h_rows = seen_rows = target_rows = correction_rows = None
until = bad_step = end_state = end_seen = part_h = None


def integrate(
    raw: Table, steps: int, duration: float, on_loss: int, project_energy: bool, momentum: bool, out: Table, work: Rows
):
    """Every column of ``raw``, block by block: its results to ``out``. Nothing is seen of the forces."""
    blocks(Run(raw, raw.shape[1], steps, duration, duration / steps, on_loss, project_energy, momentum, out), work)


def integrate_blocks(run, work):
    """The loop of :func:`integrate`."""
    raw, out, steps = run.raw, run.out, run.steps
    y, end, coef, h, seen = work[y_rows], work[end_rows], work[coef_rows], work[h_rows], work[seen_rows]
    n = run.samples
    for block in range(0, n, WIDTH):
        for lane in range(WIDTH):
            i = min(block + lane, n - 1)
            prepare(raw, i, coef, lane, WIDTH)
            start(raw, i, y, coef, lane, WIDTH)
            h[lane] = run.step_length
        for lane in range(WIDTH):
            work[until + lane], work[bad_step + lane] = steps, -1.0
        begin(run, block, y, coef, work)
        for step in range(steps):
            step_once(y, end, coef, h, seen, work)
            look(run, step, end, coef, seen, work)
            y, end = end, y
        for lane in range(min(WIDTH, n - block)):
            i = block + lane
            out[STATUS, i], out[END_TIME, i], out[MOMENTUM_ERROR, i] = OK, run.duration, 0.0
            out[ROUGHEST, i], out[AS_ROUGH, i], out[DOUBT, i] = 0.0, 0.0, 0.0
            if work[bad_step + lane] >= 0.0:
                out[STATUS, i], out[END_TIME, i] = DIVERGED, work[bad_step + lane] * run.step_length
        finish(run, block, y, coef, work)


def watch(
    raw: Table, steps: int, duration: float, on_loss: int, project_energy: bool, momentum: bool, out: Table,
    work: Rows, states: Rows, seen: Rows,
):  # fmt: skip
    """The same with all that is seen of the forces, window by window; a block ends where all its lanes' motions have.

    A motion of fewer steps goes on until the polynomials between its ends have the ends that they need.
    """
    run = Run(raw, raw.shape[1], steps, duration, duration / steps, on_loss, project_energy, momentum, out)
    blocks(run, work, states, seen)


def watch_blocks(run, work, states, seen):
    """The loop of :func:`watch`."""
    raw, out, steps = run.raw, run.out, run.steps
    coef, h, ends, seen_there, length = work[coef_rows], work[h_rows], work[end_state], work[end_seen], work[part_h]
    n, total = run.samples, max(steps, 2 * REACH)
    for block in range(0, n, WIDTH):
        y = states[: state * WIDTH]
        for lane in range(WIDTH):
            i = min(block + lane, n - 1)
            prepare(raw, i, coef, lane, WIDTH)
            start(raw, i, y, coef, lane, WIDTH)
            h[lane], length[lane] = run.step_length, 0.0
            work[until + lane], work[bad_step + lane] = steps, -1.0
        for m in range(state * WIDTH):
            ends[m] = y[m]
        for m in range(what * WIDTH):
            seen_there[m] = 0.0
        begin(run, block, y, coef, work)
        first, row, head = 0, 0, 0
        while True:
            for _ in range(min(STEPS, total - first - row)):
                y, end = (
                    states[row * state * WIDTH : (row + 1) * state * WIDTH],
                    states[(row + 1) * state * WIDTH : (row + 2) * state * WIDTH],
                )
                step_once(y, end, coef, h, at(seen, row), work)
                look(run, first + row, end, coef, at(seen, row), work)
                row += 1
            is_last = first + row == total
            if is_last:
                see(states[row * state * WIDTH : (row + 1) * state * WIDTH], coef, h, at(seen, row), work)
            known = row if is_last else row - 1
            last = known if is_last else known - REACH
            tail = steps - first - 1 if is_last else last - 2
            scan(run, block, Window(states, seen, first, head, tail, last, known), coef, work)
            going = 0
            for lane in range(WIDTH):
                going += work[until + lane] > first + tail + 1
            if is_last or going == 0:
                break
            for m in range((row - tail + 1) * state * WIDTH):
                states[m] = states[tail * state * WIDTH + m]
            for m in range((row - tail) * what * WIDTH):
                seen[m] = seen[tail * what * WIDTH + m]
            first, row, head = first + tail, row - tail, 1
        for lane in range(WIDTH):
            if work[until + lane] >= steps and length[lane] == 0.0:
                for c in range(state):
                    ends[c * WIDTH + lane] = states[((steps - first) * state + c) * WIDTH + lane]
                for c in range(what):
                    seen_there[c * WIDTH + lane] = seen[((steps - first) * what + c) * WIDTH + lane]
        for lane in range(min(WIDTH, n - block)):
            i = block + lane
            out[STATUS, i], out[END_TIME, i], out[MOMENTUM_ERROR, i] = OK, run.duration, 0.0
            if work[bad_step + lane] >= 0.0:
                out[STATUS, i], out[END_TIME, i] = DIVERGED, work[bad_step + lane] * run.step_length
        finish(run, block, ends, coef, work)


def trace(raw: Table, steps: int, duration: float, on_energy: bool, states: Table, coef: Rows, work: Rows):
    """The states of column 0 of ``raw`` at the ends of all steps; the block's lanes all carry the same motion."""
    blocks(raw, steps, duration, on_energy, states, coef, work)


def trace_block(raw, steps, duration, on_energy, states, coef, work):
    """The loop of :func:`trace`."""
    y, end, h, seen = work[y_rows], work[end_rows], work[h_rows], work[seen_rows]
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
        step_once(y, end, coef, h, seen, work)
        if on_energy:
            if torque:
                for lane in range(WIDTH):
                    target[lane] += seen[WORK * WIDTH + lane]
            project_energy(end, coef, target, correction)
        y, end = end, y
        for c in range(state):
            states[step + 1, c] = y[c * WIDTH]


def observe(states: Table, coef: Rows, out: Table, y: Rows):
    """What the equations observe in every row of ``states``."""
    blocks(states, states.shape[0], coef, out, y)


def observe_rows(states, count, coef, out, y):
    """The loop of :func:`observe`."""
    for row in range(count):
        for c in range(state):
            y[c * WIDTH] = states[row, c]
        for lane in range(1):  # as above
            values = observe_lane(y, coef, lane)
            for j in range(11):
                out[j, row] = values[j]
