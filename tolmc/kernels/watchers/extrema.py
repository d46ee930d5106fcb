"""Extrema, means and root mean squares of the contact forces, and the largest tilt.

Means are quadratures with the method's own weights. Extrema are maxima over continuous time: the stages sample every step, a
polynomial through the samples finds candidates, the two best of each quantity are kept with the state at the start of their
step, and at the end a step of the very length of the candidate's time gives the exact value, a second, short one its slope.

A candidate is (value, position in its step as a share of it, number of the step, length of the step), four rows of ``slots``.
"""

from __future__ import annotations

import math

import numpy as np

from tolmc.kernels import parameters as P
from tolmc.kernels.jit import inlined, piece, routine
from tolmc.kernels.lanes import WIDTH, no, yes
from tolmc.kernels.peaks import QUANTITIES, peaks_of
from tolmc.kernels.results import (
    CONTACT_LOST,
    CONTINUE,
    D_MAX,
    D_MEAN,
    D_MIN,
    D_RMS,
    END,
    END_TIME,
    LOSS_TIME,
    OK,
    RERUN,
    RERUN_AT,
    RERUN_FORCE,
    STATUS,
    TILT_MAX,
)
from tolmc.kernels.system import System
from tolmc.kernels.watchers import Watcher

SLOTS = 2  # candidates kept of each quantity
PROBE = 0.1  # length of the step that is laid around a candidate, as a share of the step
ESTIMATE_ERROR = 4e-3  # of the polynomials' maxima, relative to the quantity's size; measured at most 1e-3 at 1e-6
REFINEMENTS = 4  # a candidate is looked at again while its maximum lies outside the short step

_SLOT, _QUANTITY = 4 * WIDTH, SLOTS * 4 * WIDTH  # numbers from one candidate, one quantity, to the next


def watch(system: System) -> Watcher:
    """Watcher of the force statistics, within the gates that the watcher of contact loss shuts; it follows that one."""
    layout, state = system.layout, system.equations.STATE
    sample_rows, sum_rows, h_rows = system.stepper.samples, system.stepper.sums, system.h
    open_forces, open_motion, part = system.open_forces, system.open_motion, system.part
    part_h, part_state = system.part_h, system.part_state
    slot_rows, state_rows = layout.block(QUANTITIES * SLOTS * 4), layout.block(QUANTITIES * SLOTS * state)
    flag_rows, integral_rows = layout.block(QUANTITIES), layout.block(4)
    best_rows, position_rows, probe_rows = layout.block(1), layout.block(1), layout.block(1)
    estimate = peaks_of(system.stepper.tableau).estimate
    screen, keep = _screen(system), _keep(state)
    refine = _refine(system, slot_rows, state_rows, probe_rows)

    @routine
    def begin(run, block, step, y, end, coef, work):
        slots, states, integrals, probe = work[slot_rows], work[state_rows], work[integral_rows], work[probe_rows]
        integrals[:] = 0.0
        slots[:] = 0.0
        probe[:] = PROBE * run.step_length
        for place in range(QUANTITIES * SLOTS):
            for lane in range(WIDTH):
                slots[place * _SLOT + lane] = -np.inf
            for m in range(state * WIDTH):
                states[place * state * WIDTH + m] = y[m]

    @piece
    def look(run, block, step, y, end, coef, work):
        samples, sums, h = work[sample_rows], work[sum_rows], work[h_rows]
        slots, states, integrals, flags = work[slot_rows], work[state_rows], work[integral_rows], work[flag_rows]
        best, position = work[best_rows], work[position_rows]
        news = screen(samples, slots, flags)
        for quantity in range(QUANTITIES):
            if (news >> quantity) & 1 == 0:
                continue
            estimate(samples, quantity, best, position)
            gate = open_motion if quantity == 4 else open_forces
            last, moving = step == run.steps - 1, work[gate : gate + WIDTH]
            keep(y, h, float(step), last, best, position, flags, moving, slots, states, quantity)
        for row in range(4):
            for lane in range(WIDTH):
                integrals[row * WIDTH + lane] += sums[row * WIDTH + lane] if work[open_forces + lane] > 0.0 else 0.0

    @routine
    def finish(run, block, step, y, end, coef, work):
        samples, sums = work[sample_rows], work[sum_rows]
        slots, states, integrals, flags = work[slot_rows], work[state_rows], work[integral_rows], work[flag_rows]
        best, position, moving = work[best_rows], work[position_rows], work[part : part + WIDTH]
        parts = 0
        for lane in range(WIDTH):
            parts += moving[lane] > 0.0
        if parts > 0:
            for row in range(4):
                for lane in range(WIDTH):
                    integrals[row * WIDTH + lane] += sums[row * WIDTH + lane] if moving[lane] > 0.0 else 0.0
            flags[:] = 1.0
            for quantity in range(QUANTITIES if run.on_loss == END else 4):
                estimate(samples, quantity, best, position)
                keep(
                    work[part_state],
                    work[part_h],
                    0.0,
                    parts > 0,
                    best,
                    position,
                    flags,
                    moving,
                    slots,
                    states,
                    quantity,
                )
        refine(run.step_length, coef, work)
        settle(run, block, slots, integrals, work)

    settle = _settle(system)
    return Watcher(begin, look, finish)


def _screen(system: System):
    """In which quantities (bits) any lane may have a new extremum in a step; ``flags`` (quantity, lane) say which lanes.

    An extremum between the samples lies beyond them by a tenth of their range at most as long as it is a single one; twice
    that is allowed for. Most steps of a motion have no candidate, and looking closer costs more than the step itself.
    """
    peaks = peaks_of(system.stepper.tableau)
    of_step, range_of = peaks.of_step, peaks.range_of

    @routine
    def screen(samples, slots, flags):
        news = 0
        for variable in range(3):
            above = 2 * variable
            top_floor = above * _QUANTITY + _SLOT
            bottom_floor = top_floor + _QUANTITY if variable < 2 else top_floor
            high, low = 0, 0
            for lane in range(WIDTH):
                s0, s1, s2, s3, s4 = of_step(samples, above, lane)
                top, bottom = range_of(s0, s1, s2, s3, s4)
                beyond = 0.2 * (top - bottom)
                is_high = top + beyond > slots[top_floor + lane]
                is_low = beyond - bottom > slots[bottom_floor + lane]
                # Kept for each lane: what becomes of one must not depend on its neighbours.
                flags[above * WIDTH + lane] = 1.0 if is_high else 0.0
                if variable < 2:
                    flags[(above + 1) * WIDTH + lane] = 1.0 if is_low else 0.0
                high += is_high
                low += is_low
            if high > 0:
                news |= 1 << above
            if low > 0 and variable < 2:
                news |= 2 << above
        return news

    return screen


def _keep(state: int):
    """Put a step's candidate among the two best of its quantity, with the state at the step's start."""

    @routine
    def keep(y, h, number, last, best, position, flags, moving, slots, states, quantity):
        first = quantity * _QUANTITY
        second = first + _SLOT
        state1 = quantity * SLOTS * state * WIDTH
        state2 = state1 + state * WIDTH
        news = 0
        for lane in range(WIDTH):
            # A maximum at the very start of a step belongs to the step before, one far beyond the end to the next: else the two
            # places would go to one and the same maximum.
            usable = moving[lane] > 0.0 and flags[quantity * WIDTH + lane] > 0.0
            usable = usable and (position[lane] > 0.0 or number == 0.0) and (position[lane] < 1.3 or last)
            position[lane] = min(position[lane], 1.0)
            best[lane] = best[lane] if usable else -np.inf
            news += best[lane] > slots[second + lane]
        if news == 0:
            return
        for lane in range(WIDTH):
            value = best[lane]
            lead = value > slots[first + lane]
            follow = value > slots[second + lane]
            slots[second + lane] = slots[first + lane] if lead else (value if follow else slots[second + lane])
            slots[first + lane] = value if lead else slots[first + lane]
            slots[second + WIDTH + lane] = (
                slots[first + WIDTH + lane] if lead else (position[lane] if follow else slots[second + WIDTH + lane])
            )
            slots[first + WIDTH + lane] = position[lane] if lead else slots[first + WIDTH + lane]
            slots[second + 2 * WIDTH + lane] = (
                slots[first + 2 * WIDTH + lane] if lead else (number if follow else slots[second + 2 * WIDTH + lane])
            )
            slots[first + 2 * WIDTH + lane] = number if lead else slots[first + 2 * WIDTH + lane]
            slots[second + 3 * WIDTH + lane] = (
                slots[first + 3 * WIDTH + lane] if lead else (h[lane] if follow else slots[second + 3 * WIDTH + lane])
            )
            slots[first + 3 * WIDTH + lane] = h[lane] if lead else slots[first + 3 * WIDTH + lane]
            position[lane] = 2.0 if lead else (1.0 if follow else 0.0)
        for c in range(state):
            for lane in range(WIDTH):
                a, b, new = state1 + c * WIDTH + lane, state2 + c * WIDTH + lane, y[c * WIDTH + lane]
                states[b] = states[a] if position[lane] == 2.0 else (new if position[lane] == 1.0 else states[b])
                states[a] = new if position[lane] == 2.0 else states[a]

    return keep


def _refine(system: System, slot_rows: slice, state_rows: slice, probe_rows: slice):
    """Replace the kept estimates of extrema by the motion's own; the better one comes first.

    The runner-up counts only where its estimate could not be told from the best one's. What is left to do is gathered from all
    quantities and lanes into full groups of lanes: the coefficients and the state at the start of the candidate's step, a step
    up to the candidate, and a short one around it whose samples give the vertex.
    """
    equations, layout, step_once = system.equations, system.layout, system.stepper.step
    state, coefficients, sample_rows = equations.STATE, equations.COEFFICIENTS, system.stepper.samples
    until_forces, until_motion = system.until_forces, system.until_motion
    start_rows, at_rows, end_rows = layout.block(state), layout.block(state), layout.block(state)
    coef_rows, first_rows = layout.block(coefficients), layout.block(1)
    vertex = peaks_of(system.stepper.tableau).vertex

    @inlined
    def gather(slots, tasks):
        """Candidates worth refining, (quantity, slot, lane) as one number; the others' value becomes -inf."""
        count = 0
        for quantity in range(QUANTITIES):
            best = quantity * _QUANTITY
            opposite = (quantity ^ 1 if quantity < 4 else 4) * _QUANTITY
            for slot in range(SLOTS):
                where = best + slot * _SLOT
                for lane in range(WIDTH):
                    margin = ESTIMATE_ERROR * (abs(slots[best + lane]) + abs(slots[opposite + lane]))
                    if slots[where + lane] > -np.inf and (
                        slot == 0 or slots[where + lane] > slots[best + lane] - margin
                    ):
                        tasks[count] = (quantity * SLOTS + slot) * WIDTH + lane
                        count += 1
                    else:
                        slots[where + lane] = -np.inf
        return count

    @routine
    def refine(step_length, coef, work):
        slots, states, samples, probe = work[slot_rows], work[state_rows], work[sample_rows], work[probe_rows]
        start, at, end = work[start_rows], work[at_rows], work[end_rows]
        group_coef, first = work[coef_rows], work[first_rows]
        tasks = np.empty(QUANTITIES * SLOTS * WIDTH, np.int64)
        count = gather(slots, tasks)
        for task in tasks[:count]:
            where = task // WIDTH * _SLOT + task % WIDTH
            place = slots[where + WIDTH] * slots[where + 3 * WIDTH]
            # From here on the place of the short step's start, s, stands for the position.
            slots[where + WIDTH] = max(place - 0.5 * probe[0], 0.0)
        for attempt in range(REFINEMENTS):
            left = 0
            for group in range(0, count, WIDTH):
                for lane in range(WIDTH):
                    task = tasks[min(group + lane, count - 1)]
                    slot, source = task // WIDTH, task % WIDTH
                    first[lane] = slots[slot * _SLOT + WIDTH + source]
                    for c in range(coefficients):
                        group_coef[c * WIDTH + lane] = coef[c * WIDTH + source]
                    for c in range(state):
                        start[c * WIDTH + lane] = states[(slot * state + c) * WIDTH + source]
                step_once(start, at, group_coef, first, work, no())
                step_once(at, end, group_coef, probe, work, yes())
                for lane in range(min(WIDTH, count - group)):
                    task = tasks[group + lane]
                    quantity = task // WIDTH // SLOTS
                    where = task // WIDTH * _SLOT + task % WIDTH
                    number, length = slots[where + 2 * WIDTH], slots[where + 3 * WIDTH]
                    # An estimate may lie beyond its step's ends; only the ends of the statistics bind.
                    after = 0.5 * step_length if length == step_length else 0.0
                    before = 0.5 * step_length if number > 0.0 else 0.0
                    until = until_forces if quantity < 4 else until_motion
                    ends = work[until + task % WIDTH] - number * step_length
                    last = max(min(length + after, ends), length)
                    back, forth = (-before - first[lane]) / probe[lane], (last - first[lane]) / probe[lane]
                    value, move = vertex(samples, quantity, lane, back, forth)
                    found = first[lane] + move * probe[lane]
                    done = move <= back or move >= forth or -0.1 <= move <= 1.1 or attempt == REFINEMENTS - 1
                    slots[where] = value
                    slots[where + WIDTH] = found / step_length if done else max(found - 0.5 * probe[lane], -before)
                    if not done:
                        tasks[left] = task
                        left += 1
            count = left
            if count == 0:
                break
        for quantity in range(QUANTITIES):
            best = quantity * _QUANTITY
            second = best + _SLOT
            for lane in range(WIDTH):
                if slots[second + lane] > slots[best + lane]:
                    for row in range(3):
                        slots[best + row * WIDTH + lane] = slots[second + row * WIDTH + lane]

    return refine


def _settle(system: System):
    """Statistics of a block's lanes into the results, and losses of contact that only the refined extrema show."""
    until_forces = system.until_forces

    @inlined
    def late_loss(run, i, slots, lane):
        """The samples did not show it: contact is lost in the step that this place lies in."""
        for quantity in (1, 3):
            first = quantity * _QUANTITY
            if slots[first + lane] > 0.0:
                place = slots[first + 2 * WIDTH + lane] + slots[first + WIDTH + lane]
                number = min(max(math.floor(place), 0.0), run.steps - 1.0)
                earlier = run.out[STATUS, i] == OK or number < run.out[RERUN_FORCE, i]
                if run.ignore_step[i] >= run.steps:
                    run.out[STATUS, i] = CONTACT_LOST
                    run.out[END_TIME, i], run.out[LOSS_TIME, i] = place * run.step_length, place * run.step_length
                elif earlier:
                    run.out[STATUS, i], run.out[RERUN_FORCE, i], run.out[RERUN_AT, i] = RERUN, number, place - number

    @inlined
    def settle(run, block, slots, integrals, work):
        for lane in range(min(WIDTH, run.raw.shape[1] - block)):
            i = block + lane
            span = work[until_forces + lane]
            if run.out[STATUS, i] == OK:
                late_loss(run, i, slots, lane)
            for end_plane in range(2):
                first = 2 * end_plane * _QUANTITY
                second = first + _QUANTITY
                run.out[D_MAX + 4 * end_plane, i] = slots[first + lane]
                run.out[D_MIN + 4 * end_plane, i] = -slots[second + lane]
                if run.out[STATUS, i] == CONTACT_LOST and run.on_loss != CONTINUE and span > 0.0:
                    # Until contact is lost no force is negative: what is left below zero is the root's rounding.
                    run.out[D_MIN + 4 * end_plane, i] = max(-slots[second + lane], 0.0)
                if span > 0.0:
                    run.out[D_MEAN + 4 * end_plane, i] = integrals[2 * end_plane * WIDTH + lane] / span
                    run.out[D_RMS + 4 * end_plane, i] = math.sqrt(integrals[(2 * end_plane + 1) * WIDTH + lane] / span)
                else:
                    # Contact is lost at the start: the statistics are those of that instant.
                    run.out[D_MEAN + 4 * end_plane, i] = slots[first + lane]
                    run.out[D_RMS + 4 * end_plane, i] = abs(slots[first + lane])
            tilt = slots[4 * _QUANTITY + lane]
            run.out[TILT_MAX, i] = math.atan(math.sqrt(max(tilt, 0.0)) / run.raw[P.HALF_LENGTH, i])

    return settle
