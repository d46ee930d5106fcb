"""What becomes of one lane: the earliest event of its trial step, and the jump at an event.

A trial step that passes an event is made anew, shorter, from the start that it had: Newton's iteration for the event's time is
simply the lane's next rounds. A contact that has been released is armed again once its gap has opened.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from tolmc.kernels.jit import device, routine
from tolmc.kernels.one_sided import layout as at
from tolmc.kernels.one_sided.equations import Equations
from tolmc.kernels.one_sided.events import brought_to_rest, first_fall, hermite, impulses, lowest, stays
from tolmc.kernels.one_sided.layout import WIDTH
from tolmc.kernels.one_sided.stepper import FIT_4, FIT_8, Stepper

TOUCH = 2e-15  # gap over c at which an approaching contact is at the wall: the rounding of a gap
TOGETHER = 1e-11  # gap below which another approaching contact belongs to the same impact
OPENED = 1e-11  # gap from which on a released contact is armed again
FORCE_ROUNDING = 1e-12  # of the largest force so far: a closed contact's force that counts as zero
_FAR_ABOVE = 1e6  # times the height of rest: a contact that leaves its impact with the speed for so much does not rest
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
    jump: object
    system_at: object


def build(equations: Equations, stepper: Stepper, rk4: bool) -> Lane:
    """Decisions and jumps on given equations."""
    fit = FIT_4 if rk4 else FIT_8
    looked_samples = stepper.looked_samples
    system, look_at, kick, project_lane = equations.system, equations.look, equations.kick, equations.project
    spins, works, rubs, swings = equations.spins, equations.works, equations.rubs, equations.swings
    far, unit, n_state = equations.far, equations.unit, equations.state

    @routine
    def system_at(y, coef, lane):
        return system(y, coef, lane, WIDTH)

    @routine
    def project(y, coef, on_d, on_e, lane):
        project_lane(y, coef, on_d, on_e, lane, WIDTH)

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
        least, place = lowest(c)
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
        c = polynomial(samples, seen0, seen1, quantity, -sign, lane)
        least, place = lowest(c)
        best = lanes[row * WIDTH + lane]
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

    @device
    def dot(y, coef, lane, h):
        """The power of a generalised force of unit size."""
        power = 0.0
        for c in range(4):
            power += y[(c + 4) * WIDTH + lane] * h[c]
        if spins:
            power += y[at.SPIN_RATE * WIDTH + lane] * h[4] / coef[at.KAPPA * WIDTH + lane]
        return power

    @device
    def blend(smooth, rough, share):
        """A generalised force, or what it does, with a share of its friction."""
        return (
            smooth[0] + share * (rough[0] - smooth[0]), smooth[1] + share * (rough[1] - smooth[1]),
            smooth[2] + share * (rough[2] - smooth[2]), smooth[3] + share * (rough[3] - smooth[3]),
            smooth[4] + share * (rough[4] - smooth[4]), smooth[5] + share * (rough[5] - smooth[5]),
        )  # fmt: skip

    @routine
    def held_back(y, coef, lane, b_d, b_e, on_d, on_e):
        """What impulses do in an impact with friction, which is held back where all of it would turn the sliding round.

        F.v along the force of before the impact is linear in the speeds and negative; each contact's share of its friction is
        the largest, found by bisection, that leaves it so.
        """
        mu = coef[at.MU * WIDTH + lane]
        _, pd1, pe1, a1, _, _, _, _, _, _, hd1, he1 = system_at(y, coef, lane)
        coef[at.MU * WIDTH + lane] = 0.0
        _, pd0, pe0, a0, _, _, _, _, _, _, hd0, he0 = system_at(y, coef, lane)
        coef[at.MU * WIDTH + lane] = mu
        share_d, share_e, low_d, low_e, high_d, high_e = 1.0, 1.0, 0.0, 0.0, 1.0, 1.0
        a = a1
        for _ in range(40):
            a = (
                a0[0] + share_d * (a1[0] - a0[0]), a0[1] + share_e * (a1[1] - a0[1]),
                a0[2] + share_d * (a1[2] - a0[2]), a0[3] + share_e * (a1[3] - a0[3]),
            )  # fmt: skip
            l_d, l_e, _ = impulses(a, b_d, b_e, on_d, on_e)
            pd, pe = blend(pd0, pd1, share_d), blend(pe0, pe1, share_e)
            after_d, after_e = (
                dot(y, coef, lane, hd1) - dot(y, coef, lane, hd0),
                dot(y, coef, lane, he1) - dot(y, coef, lane, he0),
            )
            for c in range(5):
                change = l_d * pd[c] + l_e * pe[c]
                after_d += (hd1[c] - hd0[c]) * change
                after_e += (he1[c] - he0[c]) * change
            turns_d, turns_e = l_d > 0.0 and after_d > 0.0, l_e > 0.0 and after_e > 0.0
            if share_d == 1.0 and share_e == 1.0 and not turns_d and not turns_e:
                break
            low_d, high_d = (low_d, share_d) if turns_d else (share_d, high_d)
            low_e, high_e = (low_e, share_e) if turns_e else (share_e, high_e)
            share_d, share_e = 0.5 * (low_d + high_d), 0.5 * (low_e + high_e)
        return (
            blend(pd0, pd1, share_d), blend(pe0, pe1, share_e), a, blend(hd0, hd1, share_d), blend(he0, he1, share_e),
        )  # fmt: skip

    @device
    def blow(y, coef, lanes, log, lane, when, on_d, on_e, back):
        """The impact itself; returns the contacts that go on touching, a violation of the law and whether anything has hit.

        ``back``: of a contact that has left the wall and falls back at once, which hits it only with a speed from above the
        height of rest.
        """
        _, pd, pe, a, acc, _, rate, q, _, _, hd, he = system_at(y, coef, lane)
        bounce = coef[at.BOUNCE * WIDTH + lane]
        # A closed contact has no speed along its normal but rounding.
        g_d = 0.0 if coef[at.CLOSED_D * WIDTH + lane] > 0.0 else rate[0]
        g_e = 0.0 if coef[at.CLOSED_E * WIDTH + lane] > 0.0 else rate[1]
        b_d, b_e = g_d + bounce * min(g_d, 0.0), g_e + bounce * min(g_e, 0.0)
        if rubs:
            pd, pe, a, hd, he = held_back(y, coef, lane, b_d, b_e, on_d, on_e)
        l_d, l_e, missed = impulses(a, b_d, b_e, on_d, on_e)
        struck(y, coef, lanes, l_d, l_e, pd, pe, hd, he, lane)
        scale, least, hits = coef[at.FORCE * WIDTH + lane], 0.0, False
        for side in range(2):
            impulse, rate_in, own = (q[0] * l_d, -g_d, a[0]) if side == 0 else (q[1] * l_e, -g_e, a[3])
            speed = rate_in / q[side] if unit else rate_in
            if back:
                least = math.sqrt(2.0 * coef[at.REST_HEIGHT * WIDTH + lane] * abs(acc[side]))
            if impulse > 0.0:
                # A contact that rests on the wall and is pressed by the other's blow has not hit it.
                lanes[(at.COUNT_D + side) * WIDTH + lane] += 1.0 if rate_in > least else 0.0
                hits = hits or rate_in > least or not back
                row = (at.SPEED_D + side) * WIDTH + lane
                lanes[row] = max(lanes[row], speed)
                row = (at.IMPULSE_D + side) * WIDTH + lane
                lanes[row] = max(lanes[row], impulse)
                lanes[(at.TOTAL_D + side) * WIDTH + lane] += impulse
                if coef[at.HERTZ * WIDTH + lane] > 0.0 and speed > 0.0:
                    # m c^2 gamma^2/A is the square of the approach speed times the mass that it carries
                    energy = coef[at.ENERGY * WIDTH + lane] * rate_in * rate_in / own
                    stiff = coef[at.HERTZ * WIDTH + lane]
                    peak_force = stiff * (5.0 * energy / (4.0 * stiff)) ** 0.6
                    row = (at.PEAK_D + side) * WIDTH + lane
                    lanes[row] = max(lanes[row], peak_force)
            log[(at.E_IMPULSE_D + side) * WIDTH + lane] = scale * impulse
            there = on_d if side == 0 else on_e
            log[(at.E_SPEED_D + side) * WIDTH + lane] = coef[at.C * WIDTH + lane] * max(speed, 0.0) if there else 0.0
            log[(at.E_D + side) * WIDTH + lane] = 1.0 if there else 0.0
        if math.isnan(lanes[at.HIT_AT * WIDTH + lane]) and hits:
            lanes[at.HIT_AT * WIDTH + lane] = when
        after_d, after_e = g_d + a[0] * l_d + a[1] * l_e, g_e + a[2] * l_d + a[3] * l_e
        small = 1e-12 * (abs(g_d) + abs(g_e))
        # Whether every contact that was hit leaves so fast that none can come to rest: no need to look again.
        height = _FAR_ABOVE * coef[at.REST_HEIGHT * WIDTH + lane]
        away_d = not on_d or after_d * after_d > height * (abs(acc[0]) + g_d * g_d + g_e * g_e)
        away_e = not on_e or after_e * after_e > height * (abs(acc[1]) + g_d * g_d + g_e * g_e)
        away = away_d and away_e and after_d * (1.0 if on_d else 0.0) >= 0.0 and after_e * (1.0 if on_e else 0.0) >= 0.0
        violated = missed > 1e-9 * (abs(g_d) + abs(g_e))
        return on_d and after_d <= small, on_e and after_e <= small, violated, hits, away

    @device
    def struck(y, coef, lanes, l_d, l_e, pd, pe, hd, he, lane):
        """Impulses change the speeds; what they take is counted: minus half the sum of the speeds times them."""
        lost = -l_d * dot(y, coef, lane, hd) - l_e * dot(y, coef, lane, he)
        kick(y, l_d, l_e, pd, pe, coef, lane, WIDTH)
        lost -= l_d * dot(y, coef, lane, hd) + l_e * dot(y, coef, lane, he)
        lanes[at.IMPACT_LOSS * WIDTH + lane] += 0.5 * lost
        if rubs:
            drive = (l_d * pd[5] + l_e * pe[5]) / coef[at.KAPPA * WIDTH + lane]
            lanes[at.DRIVE_INTEGRAL * WIDTH + lane] += drive
            lanes[at.WORK * WIDTH + lane] += drive * y[at.SPIN_RATE * WIDTH + lane]
            lanes[at.DRIVE_WORK * WIDTH + lane] += drive * y[at.SPIN_RATE * WIDTH + lane]

    @routine
    def glance(y, coef, f, seen, lane):
        look_at(y, coef, f, seen, lane, WIDTH)

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

    @routine
    def jump(y, coef, lanes, log, lane, kind, gap, rate):
        """What happens at an event: impact or release, then which contacts stay closed, until nothing changes.

        ``gap`` and ``rate`` are those of D and E at the state ``y``.
        """
        when = lanes[at.T * WIDTH + lane]
        was_d, was_e = coef[at.CLOSED_D * WIDTH + lane] > 0.0, coef[at.CLOSED_E * WIDTH + lane] > 0.0
        on_d, on_e, wrong = was_d, was_e, False
        back = kind == at.FALL_BACK_D or kind == at.FALL_BACK_E
        hits = kind == at.IMPACT or kind == at.START
        if hits:
            # A contact that has just left the wall, and is there still, takes part whatever its speed.
            armed_d, armed_e = lanes[at.ARMED_D * WIDTH + lane] > 0.0, lanes[at.ARMED_E * WIDTH + lane] > 0.0
            on_d = on_d or (gap[0] <= TOGETHER and (rate[0] < 0.0 or not armed_d))
            on_e = on_e or (gap[1] <= TOGETHER and (rate[1] < 0.0 or not armed_e))
        if back:
            on_d, on_e = on_d or kind == at.FALL_BACK_D, on_e or kind == at.FALL_BACK_E
            lanes[at.HOLD * WIDTH + lane] = 1.0
        v0, v1, v2, v3 = (
            y[4 * WIDTH + lane], y[5 * WIDTH + lane], y[6 * WIDTH + lane], y[7 * WIDTH + lane],
        )  # fmt: skip
        if on_d or on_e:
            project(y, coef, on_d, on_e, lane)
        for row in range(at.E_IMPULSE_D, at.EVENT):
            log[row * WIDTH + lane] = 0.0
        log[at.E_TIME * WIDTH + lane] = when
        can_d, can_e = on_d, on_e
        bounce = coef[at.BOUNCE * WIDTH + lane]
        settles, strikes, away = hits and bounce < 1.0, hits, False
        if hits or back:
            y[4 * WIDTH + lane], y[5 * WIDTH + lane], y[6 * WIDTH + lane], y[7 * WIDTH + lane] = v0, v1, v2, v3
            can_d, can_e, wrong, strikes, away = blow(y, coef, lanes, log, lane, when, on_d, on_e, back)
            log[at.E_KIND * WIDTH + lane] = 0.0 if strikes else 2.0
            settles = settles or (back and (bounce < 1.0 or not strikes))
        else:
            can_d, can_e = can_d and kind == at.RELEASE_E, can_e and kind == at.RELEASE_D
            log[at.E_KIND * WIDTH + lane] = 1.0
            log[at.E_D * WIDTH + lane] = 1.0 if was_d and not can_d else 0.0
            log[at.E_E * WIDTH + lane] = 1.0 if was_e and not can_e else 0.0
        d, e = False, False
        for _ in range(0 if away else 3):
            if can_d or can_e:
                project(y, coef, can_d, can_e, lane)
            _, pd, pe, a, acc, _, rate, q, _, _, hd, he = system_at(y, coef, lane)
            d, e, missed = stays(a, acc, can_d, can_e)
            wrong = wrong or missed > 1e-6 * (abs(acc[0]) + abs(acc[1]))
            l_d, l_e = forces(a, acc, d, e)
            acc_d, acc_e = acc[0] + a[0] * l_d + a[1] * l_e, acc[1] + a[2] * l_d + a[3] * l_e
            height = coef[at.REST_HEIGHT * WIDTH + lane]
            rest_d = settles and on_d and not can_d and acc_d < 0.0 and rate[0] * rate[0] < -2.0 * height * acc_d
            rest_e = settles and on_e and not can_e and acc_e < 0.0 and rate[1] * rate[1] < -2.0 * height * acc_e
            if not (rest_d or rest_e):
                break
            can_d, can_e = can_d or rest_d, can_e or rest_e
            l_d, l_e = brought_to_rest(a, rate[0], rate[1], can_d, can_e)
            struck(y, coef, lanes, l_d, l_e, pd, pe, hd, he, lane)
            # It stands for the bounces left out: with the force of a contact that is closed a little too early it comes to the
            # same impulse as they do.
            lanes[at.TOTAL_D * WIDTH + lane] += q[0] * l_d
            lanes[at.TOTAL_E * WIDTH + lane] += q[1] * l_e
        coef[at.CLOSED_D * WIDTH + lane], coef[at.CLOSED_E * WIDTH + lane] = 1.0 if d else 0.0, 1.0 if e else 0.0
        # A contact that stays open without a speed of its own has to open first.
        if on_d:
            lanes[at.ARMED_D * WIDTH + lane] = 0.0 if can_d or not strikes else 1.0
        if on_e:
            lanes[at.ARMED_E * WIDTH + lane] = 0.0 if can_e or not strikes else 1.0
        if math.isnan(lanes[at.LOST_AT * WIDTH + lane]) and not (d and e):
            lanes[at.LOST_AT * WIDTH + lane] = when
            if coef[at.BOUNCE * WIDTH + lane] < 0.0:
                lanes[at.STATUS * WIDTH + lane] = at.LOST
        if wrong:
            lanes[at.STATUS * WIDTH + lane] = at.NO_SOLUTION
        lanes[at.EVENTS * WIDTH + lane] += 1.0

    @device
    def forces(a, acc, d, e):
        """lambda of the contacts that stay closed."""
        return brought_to_rest(a, acc[0], acc[1], d, e)

    return Lane(decide, reach, jump, system_at)
