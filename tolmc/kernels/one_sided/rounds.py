"""The loop over rounds of the one-sided kernels: a template, as :mod:`tolmc.kernels.loops` has them.

A round is one packed step of every lane, of its own length. Then each lane takes the step, or keeps its start for a shorter
one that ends at an event, or jumps; a lane that has finished takes the next sample. No lane waits for another, and what
becomes of a sample depends on nothing but the sample.
"""

from __future__ import annotations

from typing import Any

from tolmc.kernels.bare import Counts, Rows, Table
from tolmc.kernels.lanes import WIDTH
from tolmc.kernels.one_sided import clock as clocks
from tolmc.kernels.one_sided import layout as at

#: The step and the look; of a lane, of its events and of its samples.
step = look = screen = decide = take = approach = strike = settle = jump = renew = forecast = None
fetch = load = begin = state_of = store = note = None
#: The loop that the entry calls.
loop: Any = None
#: Whether :data:`strike` leaves impacts to :data:`jump`.
rubs = None
#: The whole buffer, and its rows.
everything = y_rows = end_rows = argument_rows = f0_rows = f1_rows = k_rows = coef_rows = lane_rows = None
seen0_rows = seen1_rows = sample_rows = result_rows = None
#: Of the samples that wait.
raw_rows = given_rows = start_rows = ready_rows = gap_rows = None


def rounds(
    raw: Table, given: Table, steps: int, duration: float, most: int, accuracy: float, out: Table, counts: Counts,
    record: Table, events: Table, decision: Counts, calls: Counts, work: Rows,
):  # fmt: skip
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
    out : (results.RESULTS, n) array
        The largest tilt by its tangent; what wears is the caller's. No step is done again: energy watches every sample.
    counts : (3,) int64 array
        Gets the rounds, and the rows and events of the record.
    record, events : (layout.RECORD, rows), (layout.EVENT, rows) arrays
        The motion of sample 0 step by step, both sides of every jump, and its events, unless they have no columns. What does
        not fit is counted only; a record is of one sample alone.
    """
    if raw.shape[1] == 0:
        return
    work[everything] = 0.0
    limits = (float(steps), duration, float(most), accuracy)
    loop(raw, given, raw.shape[1], limits, out, counts, record, events, decision, calls, work)


def all_rounds(raw, given, n, limits, out, counts, record, events, decision, calls, work):
    """The loop of :func:`rounds`."""
    steps, duration, most, accuracy = limits
    y, end, argument, f0, f1 = work[y_rows], work[end_rows], work[argument_rows], work[f0_rows], work[f1_rows]
    k, coef, lanes = work[k_rows], work[coef_rows], work[lane_rows]
    seen0, seen1, samples = work[seen0_rows], work[seen1_rows], work[sample_rows]
    results = work[result_rows]
    waiting = work[raw_rows], work[given_rows], work[start_rows], work[ready_rows], work[gap_rows]
    step_length, until = duration / steps, duration * (1.0 - clocks.ROUNDING)
    busy, queue = min(n, WIDTH), min(n, WIDTH)
    fetch(raw, given, n, 0, waiting)
    for lane in range(WIDTH):
        column = min(lane, n - 1)
        load(waiting, column, column, y, coef, lanes, f0, seen0, lane)
        lanes[at.BUSY * WIDTH + lane] = 1.0 if lane < n else 0.0
        decision[lane] = at.START
    look(y, coef, f1, seen1, argument, step_length)
    renew(f0, seen0, f1, seen1, decision)
    begin(y, coef, lanes, seen0, decision)
    forecast(y, f0, coef, lanes, seen0, argument, step_length, duration, decision)
    recording = record.shape[1] > 0
    if recording:
        note(record, events, counts, y, coef, lanes, seen0, False)
    while busy > 0:
        counts[0] += 1
        step(y, coef, f0, seen0, lanes, k, argument, samples, end)
        look(end, coef, f1, seen1, argument, step_length)
        suspects = screen(coef, lanes, samples, seen0, seen1, duration, decision)
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
            note(record, events, counts, y, coef, lanes, seen0, False)
        jumped, impacts = 0, 0
        for lane in range(WIDTH):
            impacts += decision[lane] == at.IMPACT
        if impacts > 0:
            approach(y, f0, coef, lanes, seen0, k, argument, samples, end, f1, seen1, step_length, decision)
            if recording and decision[0] == at.IMPACT:
                note(record, events, counts, y, coef, lanes, seen0, False)
            jumped = strike(y, coef, lanes, seen0, until, decision, calls)
        ended = 0
        for lane in range(WIDTH if called > 0 else 0):
            if calls[lane] == 0:
                continue
            pending = int(lanes[at.MODE * WIDTH + lane])
            if pending > 0:
                decision[lane], lanes[at.MODE * WIDTH + lane] = pending, 0.0
            done = decision[lane] != at.KEEP and not lanes[at.T * WIDTH + lane] < until
            if decision[lane] > at.TAKE and not done:
                if decision[lane] == at.IMPACT and not rubs:
                    settle(y, coef, lanes, lane)
                else:
                    jump(y, coef, lanes, seen0, lane, decision[lane])
                lanes[at.TRIES * WIDTH + lane] = 0.0
                jumped += 1
            status = state_of(lanes, seen0, steps, most, accuracy, lane)
            lanes[at.STATUS * WIDTH + lane] = status
            calls[lane] = 1 if done or status != at.OK else 0
            ended += calls[lane]
        if ended > 0:
            store(y, coef, lanes, duration, results, out, calls)
            for lane in range(WIDTH):
                if calls[lane] == 0:
                    continue
                if queue < n:
                    if queue % WIDTH == 0:
                        fetch(raw, given, n, queue, waiting)
                    load(waiting, queue % WIDTH, queue, y, coef, lanes, f0, seen0, lane)
                    queue += 1
                    decision[lane] = at.START
                    jumped += 1
                else:
                    lanes[at.BUSY * WIDTH + lane] = 0.0
                    busy -= 1
        if jumped > 0:
            look(y, coef, f1, seen1, argument, step_length)
            renew(f0, seen0, f1, seen1, decision)
            if ended > 0:
                begin(y, coef, lanes, seen0, decision)
            if recording and decision[0] > at.TAKE and lanes[at.BUSY * WIDTH] > 0.0:
                note(record, events, counts, y, coef, lanes, seen0, True)
        forecast(y, f0, coef, lanes, seen0, argument, step_length, duration, decision)
