"""What a quantity does between two ends of steps: polynomials through values and rates at four ends, made exact by real steps.

The quantities are N_D, N_E and |w|^2. Through their values and rates of change at the two ends of an interval and the two ends
beside goes a polynomial of degree 7 (Hermite); with ten steps a period it errs by 2e-7 of the amplitude, with three by
3e-3. Its maximum is followed by a real step of the method to that place, where value and rate are the motion's own; the
place moves until what is left of the maximum is known (Newton's rule, then the secant's).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tolmc.kernels.interpolation import through
from tolmc.kernels.jit import device, routine
from tolmc.kernels.lanes import WIDTH
from tolmc.kernels.seen import N_E, RATE_D, ROWS, SUM_D, SUPPORT, of
from tolmc.kernels.system import System
from tolmc.kernels.watchers.bends import highest, highest_of, swings

_DEGREES = 2 * SUPPORT
_STARTS = 5  # places of an interval at which the search for its polynomial's maximum begins
_NEWTON = 3
_ATTEMPTS = 12
#: What may be left of a maximum, as a share of the quantity's size, when it is added by the parabola there.
_LEFT = 1e-9
#: By how many times the miss of a polynomial's value its curvature may be wrong: in the middle of an interval 18, where it
#: vanishes with the square of the distance to an end 2 over that square (a Hermite polynomial's error); three times as much.
_BENT, _BENT_BESIDE = 60.0, 6.0
#: How near an end of an interval a maximum is doubted that leaves half of the rate there, as a share of a step.
_NEAR = 0.1
#: How near an end of an interval the search begins at most where there is nothing but the cubic through both ends: it does not
#: know that a motion starts from rest with a force that grows.
_BESIDE = 0.1
#: Share of the rate at an end of the bracket that a trial must leave, or the secant through it is none of a parabola.
_STRAIGHT = 0.5
#: How far the polynomial may be from the motion's own value for its curvature to be trusted, as a share of the same.
_TRUSTED = 1e-3
#: By how many times its difference from the cubic, at its maximum or in the middle, the polynomial of degree 7 may err.
_MARGIN = 3.0
#: Height over mean of what is missed: that of a bump without value and rate at both ends is 15/8.
_PEAK_TO_MEAN = 1.875


@device
def value_at(term, u, lane):
    """A lane's polynomial of degree 7 at ``u`` from the interval's middle, ``term`` (power, lane) flat."""
    value = term[7 * WIDTH + lane]
    value = term[6 * WIDTH + lane] + u * value
    value = term[5 * WIDTH + lane] + u * value
    value = term[4 * WIDTH + lane] + u * value
    value = term[3 * WIDTH + lane] + u * value
    value = term[2 * WIDTH + lane] + u * value
    value = term[WIDTH + lane] + u * value
    return term[lane] + u * value


def _fits() -> np.ndarray:
    """Coefficients in (x - 1/2), lowest first, from four values and four rates; by the place of the interval among the four."""
    return np.array([through(np.arange(SUPPORT) - offset - 0.5, rates=True) for offset in range(SUPPORT - 1)])


@dataclass(frozen=True)
class Between:
    """Functions for one system.

    ``estimate(window, interval, variable, sign, until, k, work)``: the largest value of sign times the variable within an
    interval, of every lane, as candidate k. ``estimate_last(run, window, variable, sign, until, k, work)``: the same within the
    part of a step with which a lane's motion ends, of the lanes that end in the window, after ``halve(coef, work)``.
    ``choose(count, first, work)``: of every lane the best candidate above ``best`` or, with ``first``, the earliest; returns
    how many lanes have one. ``follow(run, window, variable, sign, until, coef, work)``: its exact value into ``value`` and its
    place, in rows of the window, into ``place``.
    """

    estimate: Callable
    halve: Callable
    estimate_last: Callable
    choose: Callable
    follow: Callable
    #: Rows: intervals of the candidates; the largest value known of every lane, and the size of the quantity; what was found
    #: (no candidate: -inf), where, and how much of it is not known.
    intervals: slice
    best: slice
    scale: slice
    value: slice
    place: slice
    doubt: slice
    #: Row: the most that was left of any force.
    unsure: int


def between(system: System) -> Between:
    """The functions for one system; they stand in its kernel once."""
    layout, state, what, at = system.layout, system.equations.STATE, system.seen, system.at
    step, go_there, see = system.stepper.step, system.stepper.go, system.stepper.see
    fits, full, stride = _fits(), system.h, system.seen * WIDTH
    terms, limit_row, top_row, x_row = layout.block(_DEGREES), layout.row(), layout.row(), layout.row()
    candidates, intervals = layout.block(4 * ROWS), layout.block(-(-ROWS // WIDTH))
    best, scale, value, place, doubt = (layout.block(1) for _ in range(5))
    best_row, scale_row, value_row, place_row, doubt_row = (rows.start for rows in (best, scale, value, place, doubt))
    at_row, curve_row, guess_row, low_row, high_row, before_row, rate_row, busy_row = (layout.row() for _ in range(8))
    first_row, after_row, sound_row, mean_row = (layout.row() for _ in range(4))
    # The row before which a lane's motion ends, of the candidate whose interval stands as -1.
    last_row, middle_seen = layout.row(), layout.block(what)
    part_start, part_seen, part_h, end_seen = system.part_start, system.part_seen, system.part_h, system.end_seen
    start_rows, trial_rows, h_rows = layout.block(state), layout.block(state), layout.block(1)
    step_seen, trial_seen = layout.block(what), layout.block(what)
    number_rows, most_rows = layout.block(1), layout.block(1)
    height_row, slope_row, stop_row = layout.row(), layout.row(), layout.row()

    @routine
    def fit(window, interval, variable, sign, work):
        """Terms of the polynomials of all lanes."""
        base = min(max(interval - 1, 0), window.last - SUPPORT + 1)
        offset, term = interval - base, work[terms]
        here = base * what + variable
        values, rates = window.seen[here * WIDTH :], window.seen[(here + RATE_D) * WIDTH :]
        for power in range(_DEGREES):
            fit, to = fits[offset, power], term[power * WIDTH : (power + 1) * WIDTH]
            v0, v1, v2, v3, r0, r1, r2, r3 = fit[0], fit[1], fit[2], fit[3], fit[4], fit[5], fit[6], fit[7]
            for lane in range(WIDTH):
                by_values = v0 * values[lane] + v1 * values[stride + lane]
                by_values += v2 * values[2 * stride + lane] + v3 * values[3 * stride + lane]
                by_rates = r0 * rates[lane] + r1 * rates[stride + lane]
                by_rates += r2 * rates[2 * stride + lane] + r3 * rates[3 * stride + lane]
                to[lane] = sign * (by_values + by_rates)

    @routine
    def ends_only(from_, to, sign, variable, until, reached, work):
        """Cubics in place of polynomials that are not finite, or that go through ends beyond that of a lane's motion.

        Beyond the loss of contact the two-sided motion may be anything.
        """
        term, (v0, r0), (v1, r1) = work[terms], of(from_, variable), of(to, variable)
        for lane in range(WIDTH):
            total = 0.0
            for power in range(_DEGREES):
                total += abs(term[power * WIDTH + lane])
            sound = (total < np.inf) & (reached <= until[lane])
            work[sound_row + lane] = 1.0 if sound else 0.0
            n0, n1, m0, m1 = sign * v0[lane], sign * v1[lane], sign * r0[lane], sign * r1[lane]
            # In x - 1/2.
            c0, c1 = 0.5 * (n0 + n1) + 0.125 * (m0 - m1), 1.5 * (n1 - n0) - 0.25 * (m0 + m1)
            c2, c3 = 0.5 * (m1 - m0), m0 + m1 - 2.0 * (n1 - n0)
            term[lane] = term[lane] if sound else c0
            term[WIDTH + lane] = term[WIDTH + lane] if sound else c1
            term[2 * WIDTH + lane] = term[2 * WIDTH + lane] if sound else c2
            term[3 * WIDTH + lane] = term[3 * WIDTH + lane] if sound else c3
            for power in range(4, _DEGREES):
                term[power * WIDTH + lane] = term[power * WIDTH + lane] if sound else 0.0

    @routine
    def begin_search(term, limit, x, top):
        for lane in range(WIDTH):
            x[lane], top[lane] = 0.0, -np.inf
        for number in range(_STARTS):
            for lane in range(WIDTH):
                here = limit[lane] * number / (_STARTS - 1)
                u = here - 0.5
                p = value_at(term, u, lane)
                x[lane], top[lane] = (here, p) if p > top[lane] else (x[lane], top[lane])

    @routine
    def climb(term, limit, x, curve):
        """Newton's rule for the slope, uphill; the curvature at the place."""
        for number in range(_NEWTON + 1):
            for lane in range(WIDTH):
                u = x[lane] - 0.5
                a7, a6, a5, a4 = (
                    term[7 * WIDTH + lane], term[6 * WIDTH + lane], term[5 * WIDTH + lane], term[4 * WIDTH + lane]
                )  # fmt: skip
                a3, a2, a1 = term[3 * WIDTH + lane], term[2 * WIDTH + lane], term[WIDTH + lane]
                slope = a1 + u * (
                    2.0 * a2 + u * (3.0 * a3 + u * (4.0 * a4 + u * (5.0 * a5 + u * (6.0 * a6 + u * (7.0 * a7)))))
                )
                bend = 2.0 * a2 + u * (6.0 * a3 + u * (12.0 * a4 + u * (20.0 * a5 + u * (30.0 * a6 + u * (42.0 * a7)))))
                move = -slope / bend if bend < 0.0 else (1.0 if slope > 0.0 else -1.0)
                moved = min(max(x[lane] + min(max(move, -0.25), 0.25), 0.0), limit[lane])
                x[lane] = moved if number < _NEWTON else x[lane]
                curve[lane] = bend

    @routine
    def mean_between(from_, variable, sign, limit, length, mean):
        """Mean of a force over the whole step, by the method's own weights; NaN where there is none."""
        integral = (SUM_D + 2 * variable) * WIDTH
        for lane in range(WIDTH):
            whole = (variable <= N_E) & (limit[lane] == 1.0)
            mean[lane] = sign * from_[integral + lane] / length[lane] if whole else np.nan

    @routine
    def rate(term, from_, to, variable, sign, limit, x, top, curve, sound, means, known, candidate):
        """The candidate: what the maximum may be (-inf: it is at an end), its place and its curvature.

        Whether a lane has one it says itself: what becomes of it must not depend on its neighbours.
        """
        (v0, r0), (v1, r1) = of(from_, variable), of(to, variable)
        for lane in range(WIDTH):
            t, u = x[lane], x[lane] - 0.5
            p = value_at(term, u, lane)
            n0, n1, m0, m1 = sign * v0[lane], sign * v1[lane], sign * r0[lane], sign * r1[lane]
            rise = n1 - n0
            # The rates promise a maximum, whether or not the polynomial has one.
            inside = (t > 1e-9) & (t < limit[lane] - 1e-9)
            t = t if inside else 0.5 * limit[lane]
            t = t if sound[lane] > 0.0 else min(max(t, _BESIDE * limit[lane]), (1.0 - _BESIDE) * limit[lane])
            bend = curve[lane] if inside else m1 - m0
            cubic = n0 + t * (m0 + t * (3.0 * rise - 2.0 * m0 - m1 + t * (m0 + m1 - 2.0 * rise)))
            # A force peaks as the inverse of a distance: its inverse is the smoother one where a peak is narrow.
            i0, i1 = 1.0 / (n0 if n0 > 0.0 else 1.0), 1.0 / (n1 if n1 > 0.0 else 1.0)
            s0, s1 = -m0 * i0 * i0, -m1 * i1 * i1
            fall = i1 - i0
            inverse = i0 + t * (s0 + t * (3.0 * fall - 2.0 * s0 - s1 + t * (s0 + s1 - 2.0 * fall)))
            narrow = 1.0 / (inverse if inverse > 0.0 else 1.0)
            narrow = narrow if inverse > 0.0 else np.inf
            narrow = narrow if (n0 > 0.0) & (n1 > 0.0) else cubic
            unlike = max(abs(p - cubic), abs(term[lane] - 0.5 * (n0 + n1) - 0.125 * (m0 - m1)))
            mean = means[lane]
            missed = abs(
                mean
                - term[lane]
                - term[2 * WIDTH + lane] / 12.0
                - term[4 * WIDTH + lane] / 80.0
                - term[6 * WIDTH + lane] / 448.0
            )
            unlike = _PEAK_TO_MEAN * missed if _PEAK_TO_MEAN * missed > unlike else unlike
            may_be = max(max(p, top[lane]), max(cubic, narrow)) + _MARGIN * unlike
            bound = highest_of(n0, n1, m0, m1, swings(n0, n1, m0, m1, mean))
            may_be = may_be if sound[lane] > 0.0 else max(may_be, bound)
            promises = (bound > known[lane]) & (limit[lane] > 0.0)
            candidate[lane] = may_be if promises else -np.inf
            candidate[WIDTH + lane] = t
            candidate[2 * WIDTH + lane] = bend
            candidate[3 * WIDTH + lane] = (p if sound[lane] > 0.0 else cubic) if inside else np.inf

    @routine
    def estimate(window, interval, variable, sign, until, k, work):
        term, limit, x, top = (
            work[terms],
            work[limit_row : limit_row + WIDTH],
            work[x_row : x_row + WIDTH],
            work[top_row : top_row + WIDTH],
        )
        curve, candidate = work[curve_row : curve_row + WIDTH], work[candidates][4 * k * WIDTH : 4 * (k + 1) * WIDTH]
        work[intervals][k] = interval
        from_, to = at(window.seen, interval), at(window.seen, interval + 1)
        fit(window, interval, variable, sign, work)
        reached = window.first + min(max(interval - 1, 0), window.last - SUPPORT + 1) + SUPPORT - 1.0
        ends_only(from_, to, sign, variable, until, reached, work)
        for lane in range(WIDTH):
            limit[lane] = min(max(until[lane] - (window.first + interval), 0.0), 1.0)
        begin_search(term, limit, x, top)
        climb(term, limit, x, curve)
        sound, means = work[sound_row : sound_row + WIDTH], work[mean_row : mean_row + WIDTH]
        mean_between(from_, variable, sign, limit, work[full], means)
        rate(term, from_, to, variable, sign, limit, x, top, curve, sound, means, work[best], candidate)

    @routine
    def halve(coef, work):
        """What is seen in the middle of the part of a step with which a lane's motion ends."""
        h, length = work[h_rows], work[part_h]
        for lane in range(WIDTH):
            h[lane] = 0.5 * length[lane]
        step(work[part_start], work[trial_rows], coef, h, work[step_seen], work)
        see(work[trial_rows], coef, work[full], work[middle_seen], work)

    @routine
    def estimate_last(run, window, variable, sign, until, k, work):
        """The end of the whole step is no end of the motion: beyond it the forces may do anything."""
        candidate, known, length = work[candidates][4 * k * WIDTH : 4 * (k + 1) * WIDTH], work[best], work[part_h]
        (v0, r0), (v1, r1) = of(work[part_seen], variable), of(work[middle_seen], variable)
        v2, r2 = of(work[end_seen], variable)
        work[intervals][k] = -1.0
        for lane in range(WIDTH):
            # Of the start the rates are those of the part, of the others those of a whole step.
            share, row = length[lane] / run.step_length, np.ceil(until[lane]) - 1.0 - window.first
            half = 0.5 * share
            n0, n1, n2 = sign * v0[lane], sign * v1[lane], sign * v2[lane]
            m0, m1, m2 = 0.5 * sign * r0[lane], half * sign * r1[lane], half * sign * r2[lane]
            top_1, top_2 = highest(n0, n1, m0, m1), highest(n1, n2, m1, m2)
            late = top_2 > top_1
            a, b, top = m1 if late else m0, m2 if late else m1, max(top_1, top_2)
            # Where a motion starts from rest its forces have no rate, and not seldom a minimum: not there.
            place = min(max(a / (a - b) if (a > 0.0) & (b < 0.0) else 0.5, 0.25), 0.75)
            promises = (share > 0.0) & (row >= window.head) & (top > known[lane])
            candidate[lane] = top if promises else -np.inf
            candidate[WIDTH + lane] = half * ((1.0 if late else 0.0) + place)
            candidate[2 * WIDTH + lane] = (b - a) / (half * half) if promises else -1.0
            candidate[3 * WIDTH + lane] = np.inf
            work[last_row + lane] = row if promises else 0.0

    @routine
    def choose(count, first, work):
        """The candidate of every lane that is looked at next, taken off the list."""
        candidate, interval, number_of, most, found = (
            work[candidates],
            work[intervals],
            work[number_rows],
            work[most_rows],
            0,
        )
        for lane in range(WIDTH):
            number_of[lane], most[lane] = -1.0, work[best][lane]
        for k in range(count):
            for lane in range(WIDTH):
                height = candidate[4 * k * WIDTH + lane]
                better = (height > most[lane]) & ((not first) | (number_of[lane] < 0.0))
                number_of[lane] = k if better else number_of[lane]
                most[lane] = height if better else most[lane]
        for lane in range(WIDTH):
            number = int(number_of[lane])
            if number >= 0:
                candidate[4 * number * WIDTH + lane] = -np.inf
                work[at_row + lane] = interval[number] if interval[number] >= 0.0 else work[last_row + lane]
                work[x_row + lane] = candidate[(4 * number + 1) * WIDTH + lane]
                work[curve_row + lane] = candidate[(4 * number + 2) * WIDTH + lane]
                work[guess_row + lane] = candidate[(4 * number + 3) * WIDTH + lane]
                found += 1
            else:
                work[at_row + lane], work[x_row + lane], work[curve_row + lane] = 0.0, 0.0, -1.0
                work[guess_row + lane] = 0.0
            work[busy_row + lane] = 1.0 if number >= 0 else 0.0
        return found

    @routine
    def set_out(run_step, window, work):
        """State at the row before every lane's place, and the way from there."""
        start, h = work[start_rows], work[h_rows]
        for lane in range(WIDTH):
            row = int(work[at_row + lane])
            h[lane] = work[x_row + lane] * run_step
            for c in range(state):
                start[c * WIDTH + lane] = window.states[(row * state + c) * WIDTH + lane]

    @routine
    def begin_at(window, variable, sign, work):
        """The rates at the two ends beside every lane's place."""
        for lane in range(WIDTH):
            rate = (int(work[at_row + lane]) * what + variable + 3) * WIDTH + lane
            work[before_row + lane], work[rate_row + lane] = 0.0, sign * window.seen[rate]
            work[first_row + lane], work[after_row + lane] = (
                work[rate_row + lane],
                sign * window.seen[rate + what * WIDTH],
            )

    @routine
    def learn(attempt, variable, sign, until, first, work):
        """The value at the place and what the parabola there adds; the next place. Returns how many lanes are not done.

        Newton's rule with the polynomial's curvature, then with the secant's, within a bracket on whose sides the rates differ.
        Near an end where the value still changes as it does there is no maximum, whatever the polynomial says: beyond the loss
        of contact the ends that it goes through may be anything. Nor is the secant to be trusted where it leads from a rising
        place to one that rises as much before the falling one: a force that bends the other way first. There is no maximum
        between two places with rates of one sign where the secant's lies beyond: it stands on the other side of an end that is
        nearly one itself.
        """
        (values, rates), open_ = of(work[trial_seen], variable), 0
        # Rows by number: of arrays in ``work`` LLVM does not see that they are apart, and packs no loop that has ``work`` too.
        for lane in range(WIDTH):
            work[height_row + lane], work[slope_row + lane] = sign * values[lane], sign * rates[lane]
            work[stop_row + lane] = until[lane] - first
        for lane in range(WIDTH):
            x, bend, n, m = work[x_row + lane], work[curve_row + lane], work[height_row + lane], work[slope_row + lane]
            before, was, size = work[before_row + lane], work[rate_row + lane], work[scale_row + lane]
            low = 0.0 if attempt == 0 else work[low_row + lane]
            high = min(1.0, work[stop_row + lane] - work[at_row + lane]) if attempt == 0 else work[high_row + lane]
            low, high = x if m > 0.0 else low, high if m > 0.0 else x
            apart = x - before
            secant = (m - was) / (apart if apart != 0.0 else 1.0)
            bend = secant if (attempt > 0) & (apart != 0.0) & (secant < 0.0) else bend
            # Rates at the bracket's ends, which are the interval's at first.
            begun, after = work[first_row + lane], work[after_row + lane]
            here, ahead = 0.5 if x < _NEAR else 1.0, 0.5 if x > 1.0 - _NEAR else 1.0
            here, ahead = (here, ahead) if attempt == 0 else (_STRAIGHT, _STRAIGHT)
            same = (m > 0.0) & (begun > 0.0) & (m >= here * begun) | (m < 0.0) & (after < 0.0) & (m <= ahead * after)
            same &= (attempt == 0) | ((begun > 0.0) & (after < 0.0))
            bend = 0.0 if same & (abs(m) > _LEFT * size) else bend
            moved = x - m / (bend if bend < 0.0 else -1.0)
            beyond = (m > 0.0) & (high == 1.0) & (after > 0.0) & (moved >= 1.0)
            beyond |= (m < 0.0) & (low == 0.0) & (begun < 0.0) & (moved <= 0.0)
            beyond &= (attempt > 0) & (bend < 0.0)
            moved = moved if (moved > low) & (moved < high) & (bend < 0.0) else 0.5 * (low + high)
            gain, miss = 0.0 if beyond else 0.5 * m * (moved - x), abs(n - work[guess_row + lane])
            is_known = (attempt > 0) | (miss <= _TRUSTED * size)
            busy = work[busy_row + lane] > 0.0
            # The gain is wrong by what the curvature is, which misses as the value does, next to an end by more.
            beside = max(min(x, 1.0 - x), 1e-9)
            share = (
                miss * (_BENT + _BENT_BESIDE / (beside * beside)) / abs(bend) if (attempt == 0) & (bend < 0.0) else 1.0
            )
            rest = gain * (share if share < 1.0 else 1.0)
            done = (rest <= _LEFT * size) & is_known
            found = work[value_row + lane]
            better = busy & (n > found)
            work[place_row + lane] = work[at_row + lane] + x if better else work[place_row + lane]
            found = n if better else found
            work[value_row + lane] = n + gain if busy & done & (n + gain > found) else found
            # Where the maximum turns out to be at the interval's end its value is known.
            left = rest if n + gain > work[best_row + lane] else 0.0
            work[doubt_row + lane] = left if busy else work[doubt_row + lane]
            going = busy & ~done
            work[before_row + lane], work[rate_row + lane], work[curve_row + lane] = x, m, bend
            work[low_row + lane], work[high_row + lane] = low, high
            work[first_row + lane], work[after_row + lane] = m if m > 0.0 else begun, after if m > 0.0 else m
            work[x_row + lane] = moved if going else x
            work[busy_row + lane] = 1.0 if going else 0.0
            open_ += going
        return open_

    @routine
    def follow(run, window, variable, sign, until, coef, work):
        found, where, left = work[value], work[place], work[doubt]
        for lane in range(WIDTH):
            found[lane], where[lane], left[lane] = -np.inf, np.inf, 0.0
        begin_at(window, variable, sign, work)
        for attempt in range(_ATTEMPTS):
            set_out(run.step_length, window, work)
            go_there(work[start_rows], work[trial_rows], coef, work[h_rows], work[step_seen], work)
            see(work[trial_rows], coef, work[full], work[trial_seen], work)
            if learn(attempt, variable, sign, until, window.first, work) == 0:
                break

    return Between(
        estimate, halve, estimate_last, choose, follow, intervals, best, scale, value, place, doubt, layout.row()
    )
