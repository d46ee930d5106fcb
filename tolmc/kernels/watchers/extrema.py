"""Extrema, means and root mean squares of the contact forces, the largest tilt, and with friction its largest moment.

Means are quadratures with the method's own weights. Extrema are maxima over continuous time: values at the ends of steps are
exact, and every maximum between ends that may lie above the largest value known is made exact.
"""

from __future__ import annotations

import math

import numpy as np

from tolmc.kernels import parameters as P
from tolmc.kernels.jit import device, no, routine
from tolmc.kernels.lanes import WIDTH
from tolmc.kernels.results import (
    CONTINUE,
    D_MAX,
    D_MEAN,
    D_MIN,
    D_RMS,
    DRIVE_TORQUE_MAX,
    FRICTION_TORQUE_MAX,
    LOSS_TIME,
    TILT_MAX,
)
from tolmc.kernels.seen import N_D, N_E, RATE_W2, ROWS, SUM_D, TORQUE, W2, of
from tolmc.kernels.system import System
from tolmc.kernels.watchers import Watcher
from tolmc.kernels.watchers.bends import highest_of, rise, swings
from tolmc.kernels.watchers.between import Between

# Maxima are sought of N_D, -N_D, N_E, -N_E, |w|^2; -|w|^2, which nobody asks for, has its place; then of friction's moment
# about the axis either way, of which the larger counts.
QUANTITIES, QUANTITIES_RUBBING, UNASKED, MOMENT = 5, 8, 5, 6


def watch(system: System, between: Between) -> Watcher:
    """Watcher of the statistics up to where a lane's motion ends."""
    layout, until, part_h, at = system.layout, system.until, system.part_h, system.at
    rubs, count_all = system.equations.RUBS, QUANTITIES_RUBBING if system.equations.RUBS else QUANTITIES
    asked, variables = (1 << count_all) - 1 & ~(1 << UNASKED), 4 if rubs else 3
    top_rows, largest, integrals = layout.block(max(count_all, UNASKED + 1)), layout.row(), layout.block(4)
    mask_rows, length_row, ended = layout.block(-(-ROWS // WIDTH)), layout.row(), layout.row()
    end_rows, part_rows = system.end_seen, system.part_seen
    estimate, choose, follow = between.estimate, between.choose, between.follow
    halve, estimate_last = between.halve, between.estimate_last
    best_rows, value_rows, scale_rows = between.best, between.value, between.scale
    doubt_rows, unsure = between.doubt, between.unsure
    until_rows = slice(until, until + WIDTH)

    @routine
    def begin(run, block, y, coef, work):
        work[integrals] = 0.0
        work[top_rows] = -np.inf
        last = run.samples - 1
        for lane in range(WIDTH):
            work[largest + lane], work[length_row + lane] = 0.0, run.raw[P.HALF_LENGTH, min(block + lane, last)]

    @routine
    def take(seen, reached, until, tops, big):
        """Values at one end of a step, where a lane's motion has reached it."""
        for lane in range(WIDTH):
            d, e, w2 = seen[N_D * WIDTH + lane], seen[N_E * WIDTH + lane], seen[W2 * WIDTH + lane]
            counts = reached <= until[lane]
            tops[lane] = d if counts & (d > tops[lane]) else tops[lane]
            tops[WIDTH + lane] = -d if counts & (-d > tops[WIDTH + lane]) else tops[WIDTH + lane]
            tops[2 * WIDTH + lane] = e if counts & (e > tops[2 * WIDTH + lane]) else tops[2 * WIDTH + lane]
            tops[3 * WIDTH + lane] = -e if counts & (-e > tops[3 * WIDTH + lane]) else tops[3 * WIDTH + lane]
            tops[4 * WIDTH + lane] = w2 if counts & (w2 > tops[4 * WIDTH + lane]) else tops[4 * WIDTH + lane]
            if rubs:
                moment = abs(seen[TORQUE * WIDTH + lane])
                moment = moment if counts & (moment > tops[MOMENT * WIDTH + lane]) else tops[MOMENT * WIDTH + lane]
                tops[MOMENT * WIDTH + lane] = tops[(MOMENT + 1) * WIDTH + lane] = moment
            size = max(abs(d), abs(e))
            big[lane] = size if counts & (size > big[lane]) else big[lane]

    @routine
    def add(seen, reached, until, sums):
        """The integrals over one step."""
        for lane in range(WIDTH):
            d, d2, e, e2 = (
                seen[SUM_D * WIDTH + lane],
                seen[(SUM_D + 1) * WIDTH + lane],
                seen[(SUM_D + 2) * WIDTH + lane],
                seen[(SUM_D + 3) * WIDTH + lane],
            )
            counts = reached <= until[lane]
            sums[lane] += d if counts else 0.0
            sums[WIDTH + lane] += d2 if counts else 0.0
            sums[2 * WIDTH + lane] += e if counts else 0.0
            sums[3 * WIDTH + lane] += e2 if counts else 0.0

    @device
    def exceeds(seen, row, quantity, tops, lane):
        """Whether a lane's maximum or minimum of one variable, beside an end, may be beyond those known."""
        value, beside = seen[row * WIDTH + lane], rise(seen[(row + 3) * WIDTH + lane])
        most, least = tops[quantity * WIDTH + lane], tops[(quantity + 1) * WIDTH + lane]
        return (value + beside > most) | (beside - value > least)

    @routine
    def near_tops(seen, tops):
        """Of which variables an end is so near those known in any lane that an interval beside it may be beyond, a bit each."""
        d, e, w, t = 0, 0, 0, 0
        for lane in range(WIDTH):
            d += exceeds(seen, N_D, 0, tops, lane)
            e += exceeds(seen, N_E, 2, tops, lane)
            w += seen[W2 * WIDTH + lane] + rise(seen[RATE_W2 * WIDTH + lane]) > tops[4 * WIDTH + lane]
            if rubs:
                t += exceeds(seen, TORQUE, MOMENT, tops, lane)
        return (1 if d > 0 else 0) + (2 if e > 0 else 0) + (4 if w > 0 else 0) + (8 if t > 0 else 0)

    @device
    def row_of(variable):
        """The row of a variable in what is seen; its rate stands three rows after."""
        return variable if variable < 3 else TORQUE

    @routine
    def promising(here, after, variable, per_step, begun, until, tops):
        """Whether an interval may hold the largest (bit 0), the smallest (bit 1) value of one variable in any lane."""
        (n0, m0), (n1, m1), up, down = of(here, row_of(variable)), of(after, row_of(variable)), 0, 0
        most, least = tops[2 * variable * WIDTH : (2 * variable + 1) * WIDTH], tops[(2 * variable + 1) * WIDTH :]
        is_force = variable <= N_E
        integral = here[(SUM_D + 2 * (variable if is_force else N_E)) * WIDTH :]
        for lane in range(WIDTH):
            counts = begun < until[lane]
            more = is_force & swings(n0[lane], n1[lane], m0[lane], m1[lane], integral[lane] * per_step)
            up += (highest_of(n0[lane], n1[lane], m0[lane], m1[lane], more) > most[lane]) & counts
            down += (highest_of(-n0[lane], -n1[lane], -m0[lane], -m1[lane], more) > least[lane]) & counts
        return (1 if up > 0 else 0) + (2 if down > 0 else 0)

    @routine
    def mask_of(here, after, near, per_step, begun, until, tops):
        """Of which quantities an interval may hold the maximum in any lane, a bit each."""
        mask = 0
        for variable in range(variables):
            if (near >> variable) & 1:
                mask |= promising(here, after, variable, per_step, begun, until, tops) << 2 * variable
        return mask & asked

    @routine
    def climb(run, window, quantity, bit, ends_here, coef, work):
        """The exact maximum of one quantity."""
        variable, sign = row_of(quantity // 2), -1.0 if quantity % 2 == 1 else 1.0
        masks, tops = work[mask_rows], work[top_rows]
        top = tops[quantity * WIDTH : (quantity + 1) * WIDTH]
        best, value, scale, ends = work[best_rows], work[value_rows], work[scale_rows], work[until_rows]
        doubt = work[doubt_rows]
        for lane in range(WIDTH):
            best[lane] = top[lane]
            scale[lane] = work[largest + lane] if quantity < 4 else top[lane]
        count = np.int64(0)  # as a literal it would compile what it is handed to once more
        for row in range(window.head, window.tail + 1):
            if int(masks[row]) & bit:
                estimate(window, row, variable, sign, ends, count, work)
                count += 1
        if ends_here:
            estimate_last(run, window, variable, sign, ends, count, work)
            count += 1
        while count > 0 and choose(count, no(), work) > 0:
            follow(run, window, variable, sign, ends, coef, work)
            for lane in range(WIDTH):
                best[lane] = max(best[lane], value[lane])
                work[unsure + lane] = max(work[unsure + lane], doubt[lane] if quantity < 4 else 0.0)
        for lane in range(WIDTH):
            top[lane] = best[lane]
            if rubs and quantity >= MOMENT:
                tops[MOMENT * WIDTH + lane] = tops[(MOMENT + 1) * WIDTH + lane] = best[lane]

    @routine
    def scan(run, block, window, coef, work):
        tops, big, sums, masks, ends = (
            work[top_rows],
            work[largest : largest + WIDTH],
            work[integrals],
            work[mask_rows],
            work[until_rows],
        )
        if window.head == 0:
            take(at(window.seen, 0), window.first + 0.0, ends, tops, big)
        for row in range(window.head, window.tail + 1):
            take(at(window.seen, row + 1), window.first + row + 1.0, ends, tops, big)
            add(at(window.seen, row), window.first + row + 1.0, ends, sums)
        for lane in range(WIDTH):
            # 1 in the lanes whose motion has ended within a step: what is seen there counts too.
            work[ended + lane] = 1.0 if work[part_h][lane] > 0.0 else 0.0
        take(work[end_rows], 0.5, work[ended : ended + WIDTH], tops, big)
        ending, news, per_step = 0, 0, 1.0 / run.step_length
        for lane in range(WIDTH):
            ending += (work[ended + lane] > 0.0) & (ends[lane] > window.first + window.head)
        before = near_tops(at(window.seen, window.head), tops)
        for row in range(window.head, window.tail + 1):
            here, after, mask = at(window.seen, row), at(window.seen, row + 1), 0
            beyond = near_tops(after, tops)
            if before | beyond:
                mask = mask_of(here, after, before | beyond, per_step, window.first + row + 0.0, ends, tops)
            masks[row] = mask
            news, before = news | mask, beyond
        if ending > 0:
            halve(coef, work)
        sought = asked if ending > 0 else news
        for quantity in range(count_all):
            if (sought >> quantity) & 1:
                climb(run, window, quantity, 1 << quantity, ending > 0, coef, work)

    @routine
    def finish(run, block, y, coef, work):
        tops, sums, part, length, ends = (
            work[top_rows],
            work[integrals],
            work[part_rows],
            work[part_h],
            work[until_rows],
        )
        for lane in range(WIDTH):
            for row in range(4):
                sums[row * WIDTH + lane] += part[(SUM_D + row) * WIDTH + lane] if length[lane] > 0.0 else 0.0
        for lane in range(min(WIDTH, run.samples - block)):
            i, span = block + lane, ends[lane] * run.step_length
            per_time = 1.0 / span
            for side in range(2):
                highest, lowest = tops[2 * side * WIDTH + lane], -tops[(2 * side + 1) * WIDTH + lane]
                # Where contact is lost the smallest force is the root itself, found to rounding.
                if run.on_loss != CONTINUE and run.out[LOSS_TIME, i] > 0.0 and abs(lowest) <= 1e-12 * highest:
                    lowest = 0.0
                mean, square = highest, highest * highest
                if span > 0.0:
                    mean, square = (
                        per_time * sums[2 * side * WIDTH + lane],
                        per_time * sums[(2 * side + 1) * WIDTH + lane],
                    )
                run.out[D_MAX + 4 * side, i], run.out[D_MIN + 4 * side, i] = highest, lowest
                run.out[D_MEAN + 4 * side, i], run.out[D_RMS + 4 * side, i] = mean, math.sqrt(max(square, 0.0))
            if rubs:
                run.out[FRICTION_TORQUE_MAX, i] = tops[MOMENT * WIDTH + lane]
                run.out[DRIVE_TORQUE_MAX, i] = run.raw[P.HELD, i] * tops[MOMENT * WIDTH + lane]
            run.out[TILT_MAX, i] = math.atan(math.sqrt(tops[4 * WIDTH + lane]) / work[length_row + lane])

    return Watcher(begin=begin, scan=scan, finish=finish)
