"""First loss of contact: the instant at which a contact force turns negative.

A force that is negative at the end of a step shows it; so does a minimum between two ends, and every one that may lie below
zero is made exact. The instant is the root of min(N_D, N_E) between the end before and the first place known to be negative,
by steps of the method from that end. There a lane's motion ends, unless it is to go on two-sided.
"""

from __future__ import annotations

import math

import numpy as np

from tolmc.kernels.jit import routine, yes
from tolmc.kernels.lanes import WIDTH
from tolmc.kernels.results import CONTACT_LOST, CONTINUE, END_TIME, LOSS_TIME, OK, STATUS
from tolmc.kernels.results import STATE as LOST_STATE
from tolmc.kernels.seen import N_D, N_E, RATE_D, RATE_E, RATE_TORQUE, ROWS, SUM_D, of
from tolmc.kernels.system import System
from tolmc.kernels.watchers import Watcher
from tolmc.kernels.watchers.bends import highest_of, rise, swings
from tolmc.kernels.watchers.between import Between

_ITERATIONS = 60
# How often an earlier loss is sought before one that is found; how near the ends of the way there a force is looked at.
_LOOKS_BACK, _INSIDE = 4, 0.02
_TIGHT = 4e-16  # share of a step to which the instant is found


def watch(system: System, between: Between) -> Watcher:
    """Watcher of the loss; it ends the motion of the lanes that have one, as ``run.on_loss`` says."""
    layout, state, at = system.layout, system.equations.STATE, system.at
    time, place, sooner_rows, mark_rows = layout.row(), layout.row(), layout.block(1), layout.block(-(-ROWS // WIDTH))
    survey, (locate, look_back) = _survey(system, time, place), _locate(system, place, time)
    estimate, choose, follow = between.estimate, between.choose, between.follow
    best_rows, value_rows, place_rows, scale_rows = between.best, between.value, between.place, between.scale

    @routine
    def begin(run, block, y, coef, work):
        for lane in range(WIDTH):
            work[time + lane] = np.inf

    @routine
    def set_size(window, variable, work):
        """The size of the force, by which its minima are found exactly: the largest value at an end."""
        size = work[scale_rows]
        work[scale_rows] = 0.0
        for row in range(window.head, window.tail + 2):
            values, _ = of(at(window.seen, row), variable)
            for lane in range(WIDTH):
                value = abs(values[lane])
                size[lane] = value if (value > size[lane]) & (value < np.inf) else size[lane]

    @routine
    def near_zero(seen):
        """How many lanes have a force that is negative at an end, may be beside it, or is not known."""
        near = 0
        for lane in range(WIDTH):
            d = seen[N_D * WIDTH + lane] - rise(seen[RATE_D * WIDTH + lane])
            e = seen[N_E * WIDTH + lane] - rise(seen[RATE_E * WIDTH + lane])
            near += ~((d >= 0.0) & (e >= 0.0))
        return near

    @routine
    def mark(window, work):
        """Marks the ends near zero, and returns how many there are: most motions need no closer look."""
        marks, count = work[mark_rows], 0
        for row in range(window.head, window.tail + 2):
            near = near_zero(at(window.seen, row))
            marks[row] = near
            count += near
        return count

    @routine
    def dips(here, after, variable, per_step, reached, sooner):
        """How many lanes' force may fall below zero between two ends, before what is sought."""
        (n0, m0), (n1, m1), below = of(here, variable), of(after, variable), 0
        integral = here[(SUM_D + 2 * variable) * WIDTH :]
        for lane in range(WIDTH):
            more = swings(n0[lane], n1[lane], m0[lane], m1[lane], integral[lane] * per_step)
            below += (highest_of(-n0[lane], -n1[lane], -m0[lane], -m1[lane], more) > 0.0) & (reached <= sooner[lane])
        return below

    @routine
    def look_between(run, window, variable, coef, work):
        """Minima of one force between ends that lie below zero, before the first place known to be negative."""
        sooner, best, value, where, marks = (
            work[sooner_rows],
            work[best_rows],
            work[value_rows],
            work[place_rows],
            work[mark_rows],
        )
        count = np.int64(0)  # a literal would compile what it is handed to once more
        for lane in range(WIDTH):
            # Nothing is sought in a lane that has lost contact, nor after the end that shows it: within the interval before, a
            # force may have turned negative and positive again.
            known = np.ceil(work[place + lane]) if work[time + lane] == np.inf else 0.0
            sooner[lane] = window.first + known
            best[lane] = 0.0
        for row in range(window.head, window.tail + 1):
            if marks[row] + marks[row + 1] == 0.0:
                continue
            here, after = at(window.seen, row), at(window.seen, row + 1)
            if dips(here, after, variable, 1.0 / run.step_length, window.first + row + 1.0, sooner) > 0:
                estimate(window, row, variable, -1.0, sooner, count, work)
                count += 1
        if count > 0:
            set_size(window, variable, work)
        while count > 0 and choose(count, yes(), work) > 0:
            follow(run, window, variable, -1.0, sooner, coef, work)
            for lane in range(WIDTH):
                if value[lane] > 0.0:
                    work[place + lane] = min(work[place + lane], where[lane])
                    best[lane] = np.inf

    @routine
    def look_for(run, window, coef, work):
        survey(window, work)
        for force in range(2):
            look_between(run, window, N_D + force, coef, work)
        lost = 0
        for lane in range(WIDTH):
            lost += work[place + lane] < np.inf
        for _ in range(_LOOKS_BACK if lost > 0 else 0):
            locate(run, window, coef, work)
            if look_back(run, window, coef, work) == 0:
                break

    @routine
    def scan(run, block, window, coef, work):
        if mark(window, work) > 0:
            look_for(run, window, coef, work)

    @routine
    def finish(run, block, y, coef, work):
        for lane in range(min(WIDTH, run.samples - block)):
            when, i = work[time + lane], block + lane
            lost = when < np.inf
            run.out[LOSS_TIME, i] = when if lost else np.nan
            if lost:
                if run.out[STATUS, i] == OK or run.on_loss != CONTINUE:
                    run.out[STATUS, i] = CONTACT_LOST
                run.out[END_TIME, i] = when
                for c in range(state):
                    run.out[LOST_STATE + c, i] = y[c * WIDTH + lane]

    return Watcher(begin=begin, scan=scan, finish=finish)


def _survey(system: System, time: int, place: int):
    """First row at which a force is negative (inf: none), of lanes that have not lost contact."""
    at = system.at

    @routine
    def survey(window, work):
        for lane in range(WIDTH):
            work[place + lane] = np.inf
        for row in range(window.tail + 1, window.head - 1, -1):
            seen = at(window.seen, row)
            for lane in range(WIDTH):
                negative = min(seen[N_D * WIDTH + lane], seen[N_E * WIDTH + lane]) < 0.0 and work[time + lane] == np.inf
                work[place + lane] = row if negative else work[place + lane]

    return survey


def _locate(system: System, place: int, time: int):
    """Functions ``locate`` and ``look_back``, of the lanes that have a ``place`` (rows) known to be negative.

    ``locate(run, window, coef, work)``: time (s) of a root of min(N_D, N_E) before it. Newton's rule with the force's own rate,
    within a bracket that every trial narrows; where it leaves that, the middle. ``look_back`` puts the place where a force has
    been negative before that root, and turned positive again, in the lanes where one has (elsewhere inf: there is none), and
    returns how many these are.
    """
    layout, state, what, until = system.layout, system.equations.STATE, system.seen, system.until
    step, see, full, rubs = system.stepper.step, system.stepper.see, system.h, system.equations.RUBS
    start_rows, trial_rows, h_rows = layout.block(state), layout.block(state), layout.block(1)
    seen_rows, trial_seen = layout.block(what), layout.block(what)
    low, high, share, row_of, busy = (layout.row() for _ in range(5))
    share_rows = slice(share, share + WIDTH)
    dip_rows, found_rows, other_seen, dip_seen = (
        layout.block(1),
        layout.block(1),
        layout.block(what),
        layout.block(what),
    )
    end_rows, end_seen, part_start, part_seen, part_h = (
        system.end_state, system.end_seen, system.part_start, system.part_seen, system.part_h
    )  # fmt: skip

    @routine
    def begin_at(window, work):
        """State at the end before the place, and the bracket from there as a share of a step."""
        start = work[start_rows]
        for lane in range(WIDTH):
            where = work[place + lane]
            row = max(int(np.ceil(where)) - 1, 0) if where < np.inf else window.head
            work[row_of + lane], work[low + lane] = row, 0.0
            work[high + lane] = work[share + lane] = where - row if where < np.inf else 0.0
            work[busy + lane] = 1.0 if where < np.inf else 0.0
            for c in range(state):
                start[c * WIDTH + lane] = window.states[(row * state + c) * WIDTH + lane]

    @routine
    def narrow(first, seen, work):
        """Take the trial's force into every bracket; returns how many lanes are not done."""
        left = 0
        for lane in range(WIDTH):
            x, by_e = work[share + lane], seen[N_E * WIDTH + lane] < seen[N_D * WIDTH + lane]
            force = seen[N_E * WIDTH + lane] if by_e else seen[N_D * WIDTH + lane]
            rate = seen[RATE_E * WIDTH + lane] if by_e else seen[RATE_D * WIDTH + lane]
            work[high + lane] = x if force < 0.0 else work[high + lane]
            work[low + lane] = work[low + lane] if force < 0.0 else x
            span = work[high + lane] - work[low + lane]
            moved = x - force / (rate if rate != 0.0 else 1.0)
            moved = (
                moved if work[low + lane] < moved < work[high + lane] else 0.5 * (work[low + lane] + work[high + lane])
            )
            going = work[busy + lane] > 0.0
            # A place whose own force turns out not to be negative shows no loss after all.
            none = first and going and not force < 0.0 and x > 0.0
            work[place + lane] = np.inf if none else work[place + lane]
            going = going and not none and span > _TIGHT and abs(moved - x) > _TIGHT
            work[share + lane] = moved if going else x
            work[busy + lane] = 1.0 if going else 0.0
            left += going
        return left

    @routine
    def see_start(coef, work):
        """The forces' rates where the part of the step begins, which the step has left out."""
        seen, there = work[seen_rows], work[other_seen]
        see(work[start_rows], coef, work[h_rows], there, work)
        for m in range(RATE_D * WIDTH, (RATE_E + 1) * WIDTH):
            seen[m] = there[m]
        if rubs:
            for m in range(RATE_TORQUE * WIDTH, (RATE_TORQUE + 1) * WIDTH):
                seen[m] = there[m]

    @routine
    def locate(run, window, coef, work):
        start, trial, h, seen, seen_there = (
            work[start_rows],
            work[trial_rows],
            work[h_rows],
            work[seen_rows],
            work[trial_seen],
        )
        begin_at(window, work)
        for iteration in range(_ITERATIONS):
            for lane in range(WIDTH):
                h[lane] = work[share + lane] * run.step_length
            step(start, trial, coef, h, seen, work)
            see(trial, coef, work[full], seen_there, work)
            if narrow(iteration == 0, seen_there, work) == 0:
                break
        see_start(coef, work)
        ends, last, first, parts, lengths = (
            work[end_rows],
            work[end_seen],
            work[part_start],
            work[part_seen],
            work[part_h],
        )
        for lane in range(WIDTH):
            if work[place + lane] < np.inf:
                where = window.first + work[row_of + lane] + work[share + lane]
                work[time + lane] = where * run.step_length
                if run.on_loss != CONTINUE:
                    work[until + lane], lengths[lane] = where, h[lane]
                    for c in range(state):
                        ends[c * WIDTH + lane], first[c * WIDTH + lane] = (
                            trial[c * WIDTH + lane],
                            start[c * WIDTH + lane],
                        )
                    for c in range(what):
                        last[c * WIDTH + lane], parts[c * WIDTH + lane] = (
                            seen_there[c * WIDTH + lane],
                            seen[c * WIDTH + lane],
                        )

    @routine
    def lowest(side, run, work):
        """Where between its start and the root just found a force may dip below zero, as a share of the way there (0: nowhere).

        The minimum of the cubic.
        """
        seen, there, shares, way = work[seen_rows], work[trial_seen], work[share_rows], work[dip_rows]
        integral = seen[(SUM_D + 2 * side) * WIDTH :]
        for lane in range(WIDTH):
            share = shares[lane]
            # Of the start the rates are those of the part, of its end those of a whole step.
            n0, n1 = seen[(N_D + side) * WIDTH + lane], there[(N_D + side) * WIDTH + lane]
            m0, m1 = seen[(RATE_D + side) * WIDTH + lane], share * there[(RATE_D + side) * WIDTH + lane]
            length = share * run.step_length
            mean = integral[lane] / (length if length > 0.0 else 1.0)
            top = highest_of(-n0, -n1, -m0, -m1, swings(n0, n1, m0, m1, mean))
            a, b = 3.0 * (m0 + m1 - 2.0 * (n1 - n0)), 3.0 * (n1 - n0) - 2.0 * m0 - m1
            root = math.sqrt(max(b * b - a * m0, 0.0))
            at_lowest = -m0 / (b + root) if b + root > 0.0 else 0.5
            is_known = (work[place + lane] < np.inf) & (share > 0.0) & (top > 0.0)
            way[lane] = min(max(at_lowest, _INSIDE), 1.0 - _INSIDE) if is_known else 0.0

    @routine
    def look_back(run, window, coef, work):
        start, trial, h, shares = work[start_rows], work[trial_rows], work[h_rows], work[share_rows]
        other, there, found, way = work[other_seen], work[dip_seen], work[found_rows], work[dip_rows]
        work[found_rows] = np.inf
        for side in range(2):
            lowest(side, run, work)
            sought = 0
            for lane in range(WIDTH):
                h[lane] = way[lane] * shares[lane] * run.step_length
                sought += way[lane] > 0.0
            if sought == 0:
                continue
            step(start, trial, coef, h, other, work)
            see(trial, coef, work[full], there, work)
            for lane in range(WIDTH):
                below = (way[lane] > 0.0) & (there[(N_D + side) * WIDTH + lane] < 0.0)
                here = work[row_of + lane] + way[lane] * shares[lane]
                found[lane] = here if below & (here < found[lane]) else found[lane]
        count = 0
        for lane in range(WIDTH):
            work[place + lane] = found[lane]
            count += found[lane] < np.inf
        return count

    return locate, look_back
