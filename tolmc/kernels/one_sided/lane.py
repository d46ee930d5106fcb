"""What becomes of one lane: the earliest event of its trial step, and the way to it.

A trial step that passes an event is made anew, shorter, from the start that it had: Newton's iteration for the event's time is
simply the lane's next rounds. A contact that has been released is armed again once its gap has opened.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from tolmc.kernels.jit import device, routine
from tolmc.kernels.one_sided import layout as at
from tolmc.kernels.one_sided.equations import Equations
from tolmc.kernels.one_sided.events import first_fall, hermite, lowest
from tolmc.kernels.one_sided.jump import TOGETHER
from tolmc.kernels.one_sided.layout import WIDTH
from tolmc.kernels.one_sided.stepper import FIT_4, FIT_8, Stepper

TOUCH = 2e-15  # gap over c at which an approaching contact is at the wall: the rounding of a gap
OPENED = 1e-11  # gap from which on a released contact is armed again
FORCE_ROUNDING = 1e-12  # of the largest force so far: a closed contact's force that counts as zero
TORQUE_ROUNDING = 1e-11  # of the largest force so far times the journal's radius: a torque that counts as zero
AT_HAND = (
    1e-5  # of a step or a time of change: an impact no further from a step's end is reached by the midpoint formula
)
_LET_GO = 100.0  # times that: a falling force that counts as zero, still positive
_PATIENCE = 8  # trials after which an event counts as located if its gap or force is below the looser bound
_LOOSE = 1e-10
_AT_ONCE = 1e-6  # share of a step within which a released contact that turns back has not left
_PEAK_MARGIN = 0.02  # an extremum nearer to a step's end, in steps, is read from the polynomial through its values


@device
def at_hand(g, r, a, h):
    """Whether a closing gap is next to nothing: g/r small beside the step h, or beside r/g'' and not far from h."""
    rate = abs(r)
    near = abs(g) * abs(a) <= AT_HAND * rate * rate
    return (abs(g) <= AT_HAND * h * rate) | (near & (abs(g) <= 100.0 * AT_HAND * h * rate))


class Lane(NamedTuple):
    """Device functions for one lane."""

    decide: object
    reach: object


def build(equations: Equations, stepper: Stepper, rk4: bool) -> Lane:
    """Decisions and jumps on given equations."""
    fit = FIT_4 if rk4 else FIT_8
    looked_samples = stepper.looked_samples
    look_at, drift, far, n_state = equations.look, equations.drift, equations.far, equations.state
    flies = not equations.works
    works, rubs, swings = equations.works, equations.rubs, equations.swings

    @device
    def polynomial(samples, seen0, seen1, quantity, sign, lane):
        s0, s1, s2, s3, s4 = looked_samples(samples, seen0, seen1, quantity, lane)
        if rk4:
            return (
                sign * s0,
                sign * (fit[1, 0] * s0 + fit[1, 1] * s1 + fit[1, 2] * s2),
                sign * (fit[2, 0] * s0 + fit[2, 1] * s1 + fit[2, 2] * s2),
                0.0, 0.0, 0.0,
            )  # fmt: skip
        return (
            sign * s0,
            sign * (fit[1, 0] * s0 + fit[1, 1] * s1 + fit[1, 2] * s2 + fit[1, 3] * s3 + fit[1, 4] * s4),
            sign * (fit[2, 0] * s0 + fit[2, 1] * s1 + fit[2, 2] * s2 + fit[2, 3] * s3 + fit[2, 4] * s4),
            sign * (fit[3, 0] * s0 + fit[3, 1] * s1 + fit[3, 2] * s2 + fit[3, 3] * s3 + fit[3, 4] * s4),
            sign * (fit[4, 0] * s0 + fit[4, 1] * s1 + fit[4, 2] * s2 + fit[4, 3] * s3 + fit[4, 4] * s4),
            0.0,
        )  # fmt: skip

    @device
    def reaches(samples, seen0, seen1, quantity, lane):
        """How high and how low a quantity may go within a step."""
        s0, s1, s2, s3, s4 = looked_samples(samples, seen0, seen1, quantity, lane)
        s3, s4 = (s2, s2) if rk4 else (s3, s4)
        top, bottom = max(max(max(s0, s1), max(s2, s3)), s4), min(min(min(s0, s1), min(s2, s3)), s4)
        beyond = 0.2 * (top - bottom)
        return top + beyond, bottom - beyond

    @routine
    def hit(coef, lanes, seen0, seen1, side, lane):
        """Share of the step at whose end an open contact meets the wall; 1: now, 2: not at all, -1: from the start."""
        g0, r0, a0 = (
            seen0[(at.GAP_D + side) * WIDTH + lane],
            seen0[(at.RATE_D + side) * WIDTH + lane],
            seen0[(at.ACC_D + side) * WIDTH + lane],
        )
        g1, r1, a1 = (
            seen1[(at.GAP_D + side) * WIDTH + lane],
            seen1[(at.RATE_D + side) * WIDTH + lane],
            seen1[(at.ACC_D + side) * WIDTH + lane],
        )
        h, tries = coef[at.STEP * WIDTH + lane], lanes[at.TRIES * WIDTH + lane]
        armed = lanes[(at.ARMED_D + side) * WIDTH + lane] > 0.0
        # It leaves the wall by its acceleration, with no speed but rounding.
        drawn_off = abs(g0) <= TOGETHER and a0 > 0.0 and r0 * r0 <= 2.0 * a0 * OPENED
        if armed:
            near = abs(g1) <= TOUCH or (tries >= _PATIENCE and abs(g1) <= TOGETHER)
            if r1 < 0.0 and (near or at_hand(g1, r1, a1, h)):
                return 1.0
            if g1 > 0.0 and (drawn_off or not (r0 < 0.0 < r1)):
                return 2.0
        elif g1 >= -OPENED:
            return 2.0
        elif r0 < 0.0 and not drawn_off:
            return -1.0
        if g0 > far:
            # A dip that the tangents at both ends keep from the wall.
            if g1 > 0.0 and g0 * r1 - g1 * r0 + r0 * r1 * h >= 0.02 * (g0 + g1) * (r1 - r0):
                return 2.0
            # Nothing is foretold from there: back from the end.
            return min(max(1.0 - g1 / (r1 * h), 0.1), 0.999) if r1 < 0.0 else 0.5
        c0, c1, c2, c3, c4, c5 = hermite(g0, r0, a0, g1, r1, a1, h)
        if drawn_off or not armed:
            # With gap and rate zero: as t^3 after a release, as t^2 after another contact's blow.
            place = first_fall((max(c2, 0.0), c3, c4, c5, 0.0, 0.0))
            return place if place > _AT_ONCE else -1.0
        if abs(g0) <= TOGETHER and r0 > 0.0:
            return first_fall((c1, c2, c3, c4, c5, 0.0))
        if g1 > 0.0:
            least, place = lowest((c0, c1, c2, c3, c4, c5))
            if least <= 0.0:
                return first_fall((max(c0, 0.0), c1, c2, c3, c4, c5))
            return place if least < 0.01 * (g0 + g1) and 1e-3 < place < 0.999 else 2.0
        if g1 > -1e-3 * (abs(g0) + abs(r0) * h):
            # Near the end: from the end, to third order.
            square = max(r1 * r1 - 2.0 * a1 * g1, 0.0)
            back = 2.0 * g1 / (-r1 + math.sqrt(square)) if r1 < 0.0 else 0.0
            if 0.0 < 1.0 + back / h < 1.0:
                return 1.0 + back / h
        return first_fall((max(c0, 0.0), c1, c2, c3, c4, c5))

    @routine
    def release(coef, lanes, samples, seen0, seen1, side, lane):
        """Share of the step at which a closed contact's force has fallen to zero; 1: at its end, 2: not, -1: from the start."""
        n0, n1 = seen0[(at.N_D + side) * WIDTH + lane], seen1[(at.N_D + side) * WIDTH + lane]
        zero = FORCE_ROUNDING * lanes[at.LOAD_REFERENCE * WIDTH + lane]
        if lanes[at.TRIES * WIDTH + lane] >= _PATIENCE:
            zero *= 100.0
        c = polynomial(samples, seen0, seen1, side, 1.0, lane)
        # In a step that is next to nothing the polynomial is rounding.
        falls = c[1] + 2.0 * c[2] + 3.0 * c[3] + 4.0 * c[4] < 0.0 or n1 < 0.1 * n0
        if lanes[at.HOLD * WIDTH + lane] > 0.0 and n1 > -zero:
            return 2.0
        if -zero <= n1 <= _LET_GO * zero and falls:
            return 1.0
        if n0 <= zero and n1 < -zero:
            held = lanes[at.HOLD * WIDTH + lane] > 0.0
            if not held and c[1] <= 0.0:
                return -1.0
            # It rises before it falls, or a contact that was let go has come back at once: let go where it falls.
            place = first_fall((0.0, c[1], c[2], c[3], c[4], 0.0))
            return place if _AT_ONCE < place < 1.0 else 0.25
        if n1 < -zero:
            place = first_fall((max(c[0], 0.0), c[1], c[2], c[3], c[4], 0.0))
            return place if 0.0 < place < 1.0 else 0.5
        _, bottom = reaches(samples, seen0, seen1, side, lane)
        least, place = lowest(c) if bottom < -zero else (bottom, 0.0)
        if least < -zero and 1e-3 < place < 0.999:
            return first_fall((max(c[0], 0.0), c[1], c[2], c[3], c[4], 0.0))
        fall = -(c[1] + 2.0 * c[2] + 3.0 * c[3] + 4.0 * c[4])
        if 0.0 < n1 < fall:
            # It will reach zero within another such step: the next one goes there.
            hint = coef[at.STEP * WIDTH + lane] * n1 / fall
            lanes[at.HINT * WIDTH + lane] = min(lanes[at.HINT * WIDTH + lane], hint)
        return 2.0

    @device
    def peak(lanes, samples, seen0, seen1, quantity, sign, row, zero, lane):
        """Take a quantity's maximum over a step into ``lanes[row]``, or say at which share of the step to look for it."""
        best = lanes[row * WIDTH + lane]
        top, bottom = reaches(samples, seen0, seen1, quantity, lane)
        if not (top if sign > 0.0 else -bottom) > best:
            return 2.0
        c = polynomial(samples, seen0, seen1, quantity, -sign, lane)
        least, place = lowest(c)
        value = -least
        if not value > best + 1e-11 * (abs(value) + abs(best)) + zero:
            return 2.0
        if _PEAK_MARGIN < place < 1.0 - _PEAK_MARGIN:
            return place
        lanes[row * WIDTH + lane] = value
        return 2.0

    @routine
    def decide(coef, lanes, samples, seen0, seen1, lane):
        """KEEP and the share of the step to make anew, or TAKE, or the event at the end; a share below 0: at the start."""
        d, e = coef[at.CLOSED_D * WIDTH + lane] > 0.0, coef[at.CLOSED_E * WIDTH + lane] > 0.0
        when_d = release(coef, lanes, samples, seen0, seen1, 0, lane) if d else hit(coef, lanes, seen0, seen1, 0, lane)
        when_e = release(coef, lanes, samples, seen0, seen1, 1, lane) if e else hit(coef, lanes, seen0, seen1, 1, lane)
        # A second contact within the same instant is no event of its own before the first.
        if when_d == 1.0 and not d and not e and when_e < 1.0 and seen1[at.GAP_E * WIDTH + lane] > -TOGETHER:
            when_e = 1.0
        if when_e == 1.0 and not d and not e and when_d < 1.0 and seen1[at.GAP_D * WIDTH + lane] > -TOGETHER:
            when_d = 1.0
        slack = _LOOSE * lanes[at.LOAD_REFERENCE * WIDTH + lane]
        if d and e and when_d == 1.0 and 0.0 < when_e < 1.0 and abs(seen1[at.N_E * WIDTH + lane]) < slack:
            when_e = 1.0
        if d and e and when_e == 1.0 and 0.0 < when_d < 1.0 and abs(seen1[at.N_D * WIDTH + lane]) < slack:
            when_d = 1.0
        when = min(when_d, when_e)
        if when < 0.0:
            # The force is gone from the start, or a contact falls back at once.
            if when_d < 0.0 and when_e < 0.0 and d and e:
                return at.RELEASE_BOTH, -1.0
            if when_d < 0.0:
                return (at.RELEASE_D if d else at.FALL_BACK_D), -1.0
            return (at.RELEASE_E if e else at.FALL_BACK_E), -1.0
        if when < 1.0:
            if not d and when_d == when:
                lanes[at.ARMED_D * WIDTH + lane] = 1.0
            if not e and when_e == when:
                lanes[at.ARMED_E * WIDTH + lane] = 1.0
            return at.KEEP, when
        if when == 1.0:
            if (when_d == 1.0 and not d) or (when_e == 1.0 and not e):
                return at.IMPACT, 1.0
            if when_d == 1.0 and when_e == 1.0:
                return at.RELEASE_BOTH, 1.0
            return (at.RELEASE_D if when_d == 1.0 else at.RELEASE_E), 1.0
        # No event: extrema of the forces of closed contacts, and of the tilt.
        first = 2.0
        if lanes[at.TRIES * WIDTH + lane] < _PATIENCE:
            if d:
                first = min(first, peak(lanes, samples, seen0, seen1, 0, 1.0, at.BEST_D_MAX, 0.0, lane))
                first = min(first, peak(lanes, samples, seen0, seen1, 0, -1.0, at.BEST_D_MIN, 0.0, lane))
            if e:
                first = min(first, peak(lanes, samples, seen0, seen1, 1, 1.0, at.BEST_E_MAX, 0.0, lane))
                first = min(first, peak(lanes, samples, seen0, seen1, 1, -1.0, at.BEST_E_MIN, 0.0, lane))
            first = min(first, peak(lanes, samples, seen0, seen1, 2, 1.0, at.BEST_TILT, 0.0, lane))
            if rubs:
                zero = TORQUE_ROUNDING * coef[at.ROUND * WIDTH + lane] * lanes[at.LOAD_REFERENCE * WIDTH + lane]
                first = min(first, peak(lanes, samples, seen0, seen1, at.S_TORQUE, 1.0, at.TORQUE_MAX, zero, lane))
                first = min(first, peak(lanes, samples, seen0, seen1, at.S_DRIVE, 1.0, at.DRIVE_MAX, zero, lane))
                first = min(first, peak(lanes, samples, seen0, seen1, at.S_DRIVE, -1.0, at.DRIVE_MAX, zero, lane))
        if first < 1.0:
            return at.KEEP, first
        return at.TAKE, 1.0

    @routine
    def glance(y, coef, f, seen, lane):
        look_at(y, coef, f, seen, lane, WIDTH)

    @routine
    def glide(y, coef, f, seen0, seen, lane):
        """As :func:`glance` of a lane in flight, whose energy does not change."""
        seen[at.W2 * WIDTH + lane] = drift(y, coef, 1.0, f, 0, lane, WIDTH)
        seen[at.N_D * WIDTH + lane], seen[at.N_E * WIDTH + lane] = 0.0, 0.0
        for row in (at.KINETIC, at.POTENTIAL):
            seen[row * WIDTH + lane] = seen0[row * WIDTH + lane]

    @routine
    def reach(y, f0, coef, lanes, seen0, seen1, argument, f1, kind, duration, lane):
        """Goes the rest of the way to an impact close to the end of a step; the gaps and their rates there."""
        h, rest = coef[at.STEP * WIDTH + lane], math.inf
        for side in range(2):
            row = side * WIDTH + lane
            g, r, a = seen0[at.GAP_D * WIDTH + row], seen0[at.RATE_D * WIDTH + row], seen0[at.ACC_D * WIDTH + row]
            is_open = coef[at.CLOSED_D * WIDTH + row] == 0.0 and lanes[at.ARMED_D * WIDTH + row] > 0.0
            if is_open and r < 0.0 and at_hand(g, r, a, h):
                rest = min(rest, 2.0 * g / (math.sqrt(max(r * r - 2.0 * a * g, 0.0)) - r))
        there = kind == at.IMPACT and rest < math.inf
        rest = min(rest, duration - lanes[at.T * WIDTH + lane]) if there else 0.0
        if rest != 0.0:
            for c in range(n_state):
                argument[c * WIDTH + lane] = y[c * WIDTH + lane] + 0.5 * rest * f0[c * WIDTH + lane]
            if flies and coef[at.CLOSED_D * WIDTH + lane] == 0.0 and coef[at.CLOSED_E * WIDTH + lane] == 0.0:
                glide(argument, coef, f1, seen0, seen1, lane)
            else:
                glance(argument, coef, f1, seen1, lane)
            for c in range(n_state):
                y[c * WIDTH + lane] += rest * f1[c * WIDTH + lane]
            lanes[at.T * WIDTH + lane] += rest
            extend(coef, lanes, seen0, seen1, rest, lane)
        if kind == at.IMPACT:
            end_of_step(coef, lanes, seen0, lane)
        g_d, r_d, a_d = seen0[at.GAP_D * WIDTH + lane], seen0[at.RATE_D * WIDTH + lane], seen0[at.ACC_D * WIDTH + lane]
        g_e, r_e, a_e = seen0[at.GAP_E * WIDTH + lane], seen0[at.RATE_E * WIDTH + lane], seen0[at.ACC_E * WIDTH + lane]
        g_d, g_e = g_d + rest * (r_d + 0.5 * rest * a_d), g_e + rest * (r_e + 0.5 * rest * a_e)
        return (g_d, g_e), (r_d + rest * a_d, r_e + rest * a_e)

    @device
    def extend(coef, lanes, seen0, seen1, rest, lane):
        """Times and integrals over the rest of the way, whose middle is in ``seen1``; what its end shows to ``seen0``."""
        d, e = coef[at.CLOSED_D * WIDTH + lane] > 0.0, coef[at.CLOSED_E * WIDTH + lane] > 0.0
        lanes[at.TIME_D * WIDTH + lane] += rest if d else 0.0
        lanes[at.TIME_E * WIDTH + lane] += rest if e else 0.0
        lanes[at.TIME_FREE * WIDTH + lane] += 0.0 if d or e else rest
        lanes[at.INTEGRAL_D * WIDTH + lane] += rest * seen1[at.N_D * WIDTH + lane]
        lanes[at.INTEGRAL_E * WIDTH + lane] += rest * seen1[at.N_E * WIDTH + lane]
        if works:
            lanes[at.WORK * WIDTH + lane] += rest * seen1[at.POWER * WIDTH + lane]
        if swings:
            lanes[at.DRIVE_WORK * WIDTH + lane] += rest * seen1[at.DRIVE_POWER * WIDTH + lane]
        for row in (at.N_D, at.N_E, at.W2, at.KINETIC, at.POTENTIAL):
            seen0[row * WIDTH + lane] = 2.0 * seen1[row * WIDTH + lane] - seen0[row * WIDTH + lane]

    @device
    def end_of_step(coef, lanes, seen0, lane):
        """The forces of closed contacts and the tilt at the end of a step, for their extrema."""
        for side in range(2):
            if coef[(at.CLOSED_D + side) * WIDTH + lane] > 0.0:
                force, high = seen0[(at.N_D + side) * WIDTH + lane], at.BEST_D_MAX + 2 * side
                lanes[high * WIDTH + lane] = max(lanes[high * WIDTH + lane], force)
                lanes[(high + 1) * WIDTH + lane] = max(lanes[(high + 1) * WIDTH + lane], -force)
        tilt = at.BEST_TILT * WIDTH + lane
        lanes[tilt] = max(lanes[tilt], seen0[at.W2 * WIDTH + lane])

    return Lane(decide, reach)
