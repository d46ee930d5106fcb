"""What becomes of one lane: the earliest event of its trial step, and the way to it.

A trial step that passes an event is made anew, shorter, from the start that it had: Newton's iteration for the event's time is
simply the lane's next rounds. A contact that has been released is armed again once its gap has opened.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from tolmc.kernels.jit import device, routine
from tolmc.kernels.one_sided import layout as at
from tolmc.kernels.one_sided.approach import time_to
from tolmc.kernels.one_sided.equations import Equations
from tolmc.kernels.one_sided.events import first_fall, hermite, lowest
from tolmc.kernels.one_sided.jump import TOGETHER
from tolmc.kernels.one_sided.layout import WIDTH
from tolmc.kernels.one_sided.stepper import FIT_4, FIT_8, Stepper
from tolmc.kernels.watchers.bends import highest

TOUCH = 2e-15  # gap over c at which an approaching contact is at the wall: the rounding of a gap
OPENED = 1e-11  # gap from which on a released contact is armed again
FORCE_ROUNDING = 1e-12  # of the largest force so far: a closed contact's force that counts as zero
TORQUE_ROUNDING = 1e-11  # of the largest force so far times the journal's radius: a torque that counts as zero
_LET_GO = 100.0  # times that: a falling force that counts as zero, still positive
_PATIENCE = 8  # trials after which an event counts as located if its gap or force is below the looser bound
_LOOSE = 1e-10
_AT_ONCE = 1e-6  # share of a step within which a released contact that turns back has not left
# A maximum that rises above both ends by no more than this share, or lies nearer to one of them than so many steps, is the
# cubic's, whose rise is right to some percent. The tilt must not pass the joint's own.
_RISE, _BESIDE = 1e-5, 2e-3
_RISE_OF_TILT, _BESIDE_OF_TILT = 1e-9, 1e-7


def build(equations: Equations, stepper: Stepper, rk4: bool) -> Callable:
    """Routine ``decide`` on given equations."""
    fit = FIT_4 if rk4 else FIT_8
    looked_samples, ends = stepper.looked_samples, stepper.ends
    far, rubs = equations.far, equations.rubs

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
            if (r1 < 0.0 and near) or lanes[(at.REST_D + side) * WIDTH + lane] < math.inf:
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
            return min(max(1.0 + time_to(g1, r1, a1) / h, 0.1), 0.999) if r1 < 0.0 else 0.5
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
    def peak(lanes, seen0, seen1, quantity, sign, row, zero, h, end, lane):
        """Take a quantity's maximum over a step into ``lanes[row]``, or say at which share of the step to look for it.

        By the cubic through values and rates at both ends. ``end``: the share of the step after which it has met the wall.
        """
        best = lanes[row * WIDTH + lane]
        n0, n1, m0, m1 = ends(seen0, seen1, quantity, h, lane)
        n0, n1, m0, m1 = sign * n0, sign * n1, sign * m0, sign * m1
        if not highest(n0, n1, m0, m1) > best:
            return 2.0
        rise = n1 - n0
        least, place = lowest((-n0, -m0, 2.0 * m0 + m1 - 3.0 * rise, 2.0 * rise - m0 - m1, 0.0, 0.0))
        value = -least
        if place > end or not value > best + 1e-11 * (abs(value) + abs(best)) + zero:
            return 2.0
        share, beside = (_RISE_OF_TILT, _BESIDE_OF_TILT) if quantity == at.S_W2 else (_RISE, _BESIDE)
        if beside < place < 1.0 - beside and value - max(n0, n1) > share * abs(value):
            return place
        lanes[row * WIDTH + lane] = value
        return 2.0

    @device
    def peaks(coef, lanes, seen0, seen1, d, e, end, lane):
        """The first share of a step at which an extremum is to be looked for, 2 where there is none."""
        first, h = 2.0, coef[at.STEP * WIDTH + lane]
        if d:
            first = min(first, peak(lanes, seen0, seen1, at.S_D, 1.0, at.BEST_D_MAX, 0.0, h, end, lane))
            first = min(first, peak(lanes, seen0, seen1, at.S_D, -1.0, at.BEST_D_MIN, 0.0, h, end, lane))
        if e:
            first = min(first, peak(lanes, seen0, seen1, at.S_E, 1.0, at.BEST_E_MAX, 0.0, h, end, lane))
            first = min(first, peak(lanes, seen0, seen1, at.S_E, -1.0, at.BEST_E_MIN, 0.0, h, end, lane))
        first = min(first, peak(lanes, seen0, seen1, at.S_W2, 1.0, at.BEST_TILT, 0.0, h, end, lane))
        if rubs:
            zero = TORQUE_ROUNDING * coef[at.ROUND * WIDTH + lane] * lanes[at.LOAD_REFERENCE * WIDTH + lane]
            first = min(first, peak(lanes, seen0, seen1, at.S_TORQUE, 1.0, at.TORQUE_MAX, zero, h, end, lane))
            first = min(first, peak(lanes, seen0, seen1, at.S_DRIVE, 1.0, at.DRIVE_MAX, zero, h, end, lane))
            first = min(first, peak(lanes, seen0, seen1, at.S_DRIVE, -1.0, at.DRIVE_MAX, zero, h, end, lane))
        return first

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
        # Extrema of the forces of closed contacts, and of the tilt, before the step's end.
        first, tried = 2.0, lanes[at.TRIES * WIDTH + lane]
        if tried < _PATIENCE:
            rest = min(min(lanes[at.REST_D * WIDTH + lane], lanes[at.REST_E * WIDTH + lane]), 0.0)
            first = peaks(coef, lanes, seen0, seen1, d, e, 1.0 + rest / coef[at.STEP * WIDTH + lane], lane)
        if first < 1.0:
            return at.KEEP, first
        if when == 1.0:
            if (when_d == 1.0 and not d) or (when_e == 1.0 and not e):
                return at.IMPACT, 1.0
            if when_d == 1.0 and when_e == 1.0:
                return at.RELEASE_BOTH, 1.0
            return (at.RELEASE_D if when_d == 1.0 else at.RELEASE_E), 1.0
        return at.TAKE, 1.0

    return decide
