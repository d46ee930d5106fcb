"""The loop over rounds of the one-sided kernels: a template, as :mod:`tolmc.kernels.loops` has them.

A round is one packed step of every lane, of its own length. Then each lane takes the step, or keeps its start for a shorter
one that ends at an event, or jumps; a lane that has finished takes the next sample. No lane waits for another, and what
becomes of a sample depends on nothing but the sample.
"""

from __future__ import annotations

import numpy as np

from tolmc.kernels.lanes import WIDTH
from tolmc.kernels.lanes import lanes as lanes_of
from tolmc.kernels.one_sided import clock as clocks
from tolmc.kernels.one_sided import layout as at

#: The step and the look; of a lane, of its events and of its samples.
step = look = decide = reach = jump = screen = take = renew = next_steps = load = begin = state_of = store = note = None
#: Rows of the buffer, and how many there are.
rows = y_rows = end_rows = argument_rows = f0_rows = f1_rows = k_rows = coef_rows = lane_rows = None
seen0_rows = seen1_rows = log_rows = sample_rows = None


def rounds(raw, given, steps, duration, most, accuracy, out, counts, record, events):
    """Integrate every column of ``raw`` over ``duration`` (s) in steps of ``duration/steps`` or less; results into ``out``.

    Parameters
    ----------
    raw : (parameters.COUNT, n) array, SI units
    given : (layout.GIVEN, n) array, SI units
        Start and laws of contact.
    most : int
        Events after which a sample is given up.
    accuracy : float
        Penetration over c that ends a sample.
    out : (layout.RESULTS, n) array
    counts : (3,) int64 array
        Gets the rounds, and the rows and events of the record.
    record, events : (layout.RECORD, rows), (layout.EVENT, rows) arrays
        The motion of sample 0 step by step, both sides of every jump, and its events, unless they have no columns. What does
        not fit is counted only; a record is of one sample alone.
    """
    n = raw.shape[1]
    if n == 0:
        return
    work = lanes_of(rows)
    work[:] = 0.0
    y, end, argument, f0, f1 = work[y_rows], work[end_rows], work[argument_rows], work[f0_rows], work[f1_rows]
    k, coef, lanes = work[k_rows], work[coef_rows], work[lane_rows]
    seen0, seen1, log, samples = work[seen0_rows], work[seen1_rows], work[log_rows], work[sample_rows]
    decision, calls = np.empty(WIDTH, np.int64), np.empty(WIDTH, np.int64)
    limits = (float(steps), duration, float(most), accuracy)
    step_length = duration / steps
    queue = 0
    for lane in range(WIDTH):
        load(raw, given, min(queue, n - 1), y, coef, lanes, log, lane)
        lanes[at.BUSY * WIDTH + lane] = 1.0 if queue < n else 0.0
        decision[lane] = at.START
        queue += 1
    busy = min(n, WIDTH)
    look(y, coef, f1, seen1)
    renew(f0, seen0, f1, seen1, decision)
    for lane in range(WIDTH):
        begin(raw, y, coef, lanes, seen0, lane)
    next_steps(coef, lanes, seen0, step_length, duration, decision)
    recording = record.shape[1] > 0
    if recording:
        note(record, events, counts, y, coef, lanes, seen0, log, False)
    while busy > 0:
        counts[0] += 1
        step(y, coef, f0, seen0, lanes, k, argument, samples, end)
        look(end, coef, f1, seen1)
        suspects = screen(coef, lanes, samples, seen0, seen1, decision)
        if suspects > 0:
            for lane in range(WIDTH):
                if decision[lane] == at.KEEP:
                    verdict, place = decide(coef, lanes, samples, seen0, seen1, lane)
                    decision[lane] = verdict
                    if place < 0.0:
                        # An event at the start: the trial step is not taken.
                        decision[lane] = at.KEEP
                        lanes[at.MODE * WIDTH + lane] = verdict
                    elif verdict == at.KEEP:
                        coef[at.STEP * WIDTH + lane] *= place
        called = take(y, f0, seen0, end, f1, seen1, coef, lanes, samples, limits, decision, calls)
        if recording and decision[0] != at.KEEP and decision[0] != at.IMPACT and lanes[at.BUSY * WIDTH] > 0.0:
            note(record, events, counts, y, coef, lanes, seen0, log, False)
        jumped = 0
        for lane in range(WIDTH if called > 0 else 0):
            if calls[lane] == 0:
                continue
            pending = int(lanes[at.MODE * WIDTH + lane])
            if pending > 0:
                decision[lane], lanes[at.MODE * WIDTH + lane] = pending, 0.0
            done = decision[lane] != at.KEEP and not lanes[at.T * WIDTH + lane] < duration * (1.0 - clocks.ROUNDING)
            if decision[lane] > at.TAKE and not done:
                gap, rate = reach(y, f0, coef, lanes, seen0, seen1, argument, f1, decision[lane], duration, lane)
                if recording and lane == 0 and decision[lane] == at.IMPACT:
                    note(record, events, counts, y, coef, lanes, seen0, log, False)
                jump(y, coef, lanes, log, lane, decision[lane], gap, rate)
                lanes[at.TRIES * WIDTH + lane] = 0.0
                jumped += 1
            status = state_of(lanes, seen0, steps, most, accuracy, lane)
            if done or status != at.OK:
                store(y, coef, lanes, seen0, out, lane, status)
                if queue < n:
                    load(raw, given, queue, y, coef, lanes, log, lane)
                    queue += 1
                    decision[lane] = at.START
                    jumped += 1
                else:
                    lanes[at.BUSY * WIDTH + lane] = 0.0
                    busy -= 1
        if jumped > 0:
            look(y, coef, f1, seen1)
            renew(f0, seen0, f1, seen1, decision)
            for lane in range(WIDTH):
                if decision[lane] == at.START:
                    begin(raw, y, coef, lanes, seen0, lane)
            if recording and decision[0] > at.TAKE and lanes[at.BUSY * WIDTH] > 0.0:
                note(record, events, counts, y, coef, lanes, seen0, log, True)
        next_steps(coef, lanes, seen0, step_length, duration, decision)
