"""Many motions with one-sided contact at once: every lane with its own clock and its own events.

A round is one packed step of every lane, of its own length. Then each lane takes the step, or keeps its start for a shorter
one that ends at an event, or jumps; a lane that has finished takes the next sample. No lane waits for another, and what
becomes of a sample depends on nothing but the sample.
"""

from __future__ import annotations

import numpy as np

from tolmc.kernels.jit import device, kernel, routine
from tolmc.kernels.one_sided import clock as clocks
from tolmc.kernels.one_sided import jump as jumps
from tolmc.kernels.one_sided import lane as one_lane
from tolmc.kernels.one_sided import layout as at
from tolmc.kernels.one_sided import samples as ways
from tolmc.kernels.one_sided import stepper as steppers
from tolmc.kernels.one_sided.buffers import borrowed
from tolmc.kernels.one_sided.equations import EQUATIONS
from tolmc.kernels.one_sided.layout import WIDTH


@device
def _buffer(rows):
    """Room for ``rows`` rows of lanes that begins on a cache line."""
    buffer = np.empty(rows * WIDTH + 7)
    skip = (-(buffer.ctypes.data // 8)) % 8
    return buffer[skip : skip + rows * WIDTH]


def build(equations, rk4: bool):
    """The loop over rounds of one kind of scene."""
    stepper = steppers.build(equations, rk4)
    step, look = stepper.step, stepper.look
    decide, reach = one_lane.build(equations, stepper, rk4)
    at_event = jumps.build(equations)
    jump = at_event.jump
    screen, take, renew, next_steps = clocks.build(equations, stepper, rk4)
    load, begin, state_of, store, note = ways.build(equations, at_event)
    n_state, n_coef, stages = equations.state, equations.coefficients, stepper.stages
    # Rows of the buffer: states and rates, then what is known of the lanes.
    kept = (stages + 1) * equations.samples
    first = (stages + 6) * n_state
    looks = first + n_coef + at.CARRIED
    last = looks + 2 * at.SEEN + at.EVENT + kept

    @routine
    def rounds(raw, given, steps, duration, most, accuracy, out, counts, record, events):
        """Integrate every column; ``counts`` (rounds of all lanes, rows and events of the record of sample 0)."""
        n = raw.shape[1]
        room = _buffer(last)
        room[:] = 0.0
        y, end, argument = (
            borrowed(room, 0, n_state),
            borrowed(room, n_state, n_state),
            borrowed(room, 2 * n_state, n_state),
        )
        f0, f1 = borrowed(room, 3 * n_state, n_state), borrowed(room, 4 * n_state, n_state)
        k = borrowed(room, 5 * n_state, (stages + 1) * n_state)
        coef, lanes = borrowed(room, first, n_coef), borrowed(room, first + n_coef, at.CARRIED)
        seen0, seen1 = borrowed(room, looks, at.SEEN), borrowed(room, looks + at.SEEN, at.SEEN)
        log, samples = borrowed(room, looks + 2 * at.SEEN, at.EVENT), borrowed(room, last - kept, kept)
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
        room[0] = 0.0  # it is alive until here

    return rounds


ROUNDS = {(*kind, rk4): build(equations, rk4) for kind, equations in EQUATIONS.items() for rk4 in (False, True)}
_CIRCLE, _CIRCLE_4 = ROUNDS[False, False, False, False], ROUNDS[False, False, False, True]
_CIRCLE_RUBS, _CIRCLE_RUBS_4 = ROUNDS[False, False, True, False], ROUNDS[False, False, True, True]
_CIRCLE_ANY, _CIRCLE_ANY_4 = ROUNDS[False, True, False, False], ROUNDS[False, True, False, True]
_CIRCLE_ANY_RUBS, _CIRCLE_ANY_RUBS_4 = ROUNDS[False, True, True, False], ROUNDS[False, True, True, True]
_EXACT, _EXACT_4 = ROUNDS[True, False, False, False], ROUNDS[True, False, False, True]
_EXACT_RUBS, _EXACT_RUBS_4 = ROUNDS[True, False, True, False], ROUNDS[True, False, True, True]
_EXACT_ANY, _EXACT_ANY_4 = ROUNDS[True, True, False, False], ROUNDS[True, True, False, True]
_EXACT_ANY_RUBS, _EXACT_ANY_RUBS_4 = ROUNDS[True, True, True, False], ROUNDS[True, True, True, True]


@kernel
def integrate(raw, given, steps, duration, most, accuracy, out, counts, record, events, exact, general, rubs, rk4):
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
    exact, general, rubs, rk4 : None or 1
        What is compiled in: the exact section, any body, friction, rk4 in place of rk8.
    """
    if exact is None:
        if general is None:
            if rubs is None:
                if rk4 is None:
                    _CIRCLE(raw, given, steps, duration, most, accuracy, out, counts, record, events)
                else:
                    _CIRCLE_4(raw, given, steps, duration, most, accuracy, out, counts, record, events)
            elif rk4 is None:
                _CIRCLE_RUBS(raw, given, steps, duration, most, accuracy, out, counts, record, events)
            else:
                _CIRCLE_RUBS_4(raw, given, steps, duration, most, accuracy, out, counts, record, events)
        elif rubs is None:
            if rk4 is None:
                _CIRCLE_ANY(raw, given, steps, duration, most, accuracy, out, counts, record, events)
            else:
                _CIRCLE_ANY_4(raw, given, steps, duration, most, accuracy, out, counts, record, events)
        elif rk4 is None:
            _CIRCLE_ANY_RUBS(raw, given, steps, duration, most, accuracy, out, counts, record, events)
        else:
            _CIRCLE_ANY_RUBS_4(raw, given, steps, duration, most, accuracy, out, counts, record, events)
    elif general is None:
        if rubs is None:
            if rk4 is None:
                _EXACT(raw, given, steps, duration, most, accuracy, out, counts, record, events)
            else:
                _EXACT_4(raw, given, steps, duration, most, accuracy, out, counts, record, events)
        elif rk4 is None:
            _EXACT_RUBS(raw, given, steps, duration, most, accuracy, out, counts, record, events)
        else:
            _EXACT_RUBS_4(raw, given, steps, duration, most, accuracy, out, counts, record, events)
    elif rubs is None:
        if rk4 is None:
            _EXACT_ANY(raw, given, steps, duration, most, accuracy, out, counts, record, events)
        else:
            _EXACT_ANY_4(raw, given, steps, duration, most, accuracy, out, counts, record, events)
    elif rk4 is None:
        _EXACT_ANY_RUBS(raw, given, steps, duration, most, accuracy, out, counts, record, events)
    else:
        _EXACT_ANY_RUBS_4(raw, given, steps, duration, most, accuracy, out, counts, record, events)
