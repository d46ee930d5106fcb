"""What every lane does after a round, in packed loops: see whether something happened, take the step, choose the next one."""

from __future__ import annotations

import math
from typing import NamedTuple

from tolmc.kernels.jit import device, routine
from tolmc.kernels.one_sided import layout as at
from tolmc.kernels.one_sided.equations import Equations
from tolmc.kernels.one_sided.jump import TOGETHER
from tolmc.kernels.one_sided.lane import OPENED, TORQUE_ROUNDING, TOUCH, at_hand
from tolmc.kernels.one_sided.layout import WIDTH
from tolmc.kernels.one_sided.stepper import SLOPES_4, SLOPES_8, Stepper

#: Rounds for each step and event after which a lane is given up; usual are one and two.
MOST_ROUNDS = 64
#: Of the duration: a motion that lacks no more of it is at its end.
ROUNDING = 4e-16
# Slope at a step's end, over the range of the samples, that may be zero.
_LEVEL = 0.02
#: Shortenings of one step after which a lane is given up.
MOST_TRIES = 60


class Clock(NamedTuple):
    """Routines over a block of lanes."""

    screen: object
    take: object
    renew: object
    next_steps: object


def build(equations: Equations, stepper: Stepper, rk4: bool) -> Clock:
    """The loops of one kind of scene."""
    looked_samples, quadrature, closed = stepper.looked_samples, stepper.quadrature, stepper.closed
    n_state, works, rubs, far = equations.state, equations.works, equations.rubs, equations.far
    swings, end_slopes = equations.swings, SLOPES_4 if rk4 else SLOPES_8

    @device
    def may_peak(samples, seen0, seen1, quantity, best, coef, lanes, lane):
        """Whether a torque's size may have a new maximum within a step."""
        zero = TORQUE_ROUNDING * coef[at.ROUND * WIDTH + lane] * lanes[at.LOAD_REFERENCE * WIDTH + lane]
        s0, s1, s2, s3, s4 = looked_samples(samples, seen0, seen1, quantity, lane)
        s2, s3, s4 = (s2, s2, s2) if rk4 else (s2, s3, s4)
        top, bottom = max(max(max(s0, s1), max(s2, s3)), s4), min(min(min(s0, s1), min(s2, s3)), s4)
        beyond = 0.2 * (top - bottom)
        return (max(top, -bottom) + beyond > max(best, max(abs(s0), abs(s4))) + zero) & (beyond > 0.0)

    @device
    def slopes(s0, s1, s2, s3, s4):
        """Slopes of a quantity at a step's two ends, by the polynomial through its samples."""
        up, down = end_slopes[0, 0] * s0 + end_slopes[0, 1] * s1, end_slopes[1, 0] * s0 + end_slopes[1, 1] * s1
        up, down = up + end_slopes[0, 2] * s2, down + end_slopes[1, 2] * s2
        if not rk4:
            up, down = up + end_slopes[0, 3] * s3, down + end_slopes[1, 3] * s3
            up, down = up + end_slopes[0, 4] * s4, down + end_slopes[1, 4] * s4
        return up, down

    @routine
    def screen(coef, lanes, samples, seen0, seen1, decision):
        """TAKE for lanes in whose step nothing happens, IMPACT for those that have just come to the wall at its end.

        KEEP for those to be looked at; returns how many those are.
        """
        count = 0
        for lane in range(WIDTH):
            open_d, open_e = coef[at.CLOSED_D * WIDTH + lane] == 0.0, coef[at.CLOSED_E * WIDTH + lane] == 0.0
            h = coef[at.STEP * WIDTH + lane]
            suspect, meets = False, False
            for side in range(2):
                is_open = open_d if side == 0 else open_e
                s0, s1, s2, s3, s4 = looked_samples(samples, seen0, seen1, side, lane)
                if rk4:
                    top, bottom = max(max(s0, s1), s2), min(min(s0, s1), s2)
                else:
                    top, bottom = max(max(max(s0, s1), max(s2, s3)), s4), min(min(min(s0, s1), min(s2, s3)), s4)
                beyond = 0.2 * (top - bottom)
                high, low = (at.BEST_D_MAX, at.BEST_D_MIN) if side == 0 else (at.BEST_E_MAX, at.BEST_E_MIN)
                best_high, best_low = lanes[high * WIDTH + lane], lanes[low * WIDTH + lane]
                best_high = max(best_high, s0) if not is_open else best_high
                best_low = max(best_low, -s0) if not is_open else best_low
                lanes[high * WIDTH + lane], lanes[low * WIDTH + lane] = best_high, best_low
                # The ends are taken without looking: an extremum within lies beyond them and the samples by no more than that,
                # where a sample does or the slopes at the two ends point to one, next to zero or not.
                margin = _LEVEL * (top - bottom)
                up, down = slopes(s0, s1, s2, s3, s4)
                rises, falls = (up > -margin) & (down < margin), (up < margin) & (down > -margin)
                last = s2 if rk4 else s4
                rises |= top > max(s0, last)
                falls |= bottom < min(s0, last)
                extremum = (rises & (top + beyond > best_high)) | (falls & (beyond - bottom > best_low))
                g0, g1 = seen0[(at.GAP_D + side) * WIDTH + lane], seen1[(at.GAP_D + side) * WIDTH + lane]
                r0, r1 = seen0[(at.RATE_D + side) * WIDTH + lane], seen1[(at.RATE_D + side) * WIDTH + lane]
                # Below both tangents of a gap that dips no gap can be as long as it is convex.
                depth = g0 * r1 - g1 * r0 + r0 * r1 * h
                armed = lanes[(at.ARMED_D + side) * WIDTH + lane] > 0.0
                here = is_open & armed & (r1 < 0.0) & at_hand(g1, r1, seen1[(at.ACC_D + side) * WIDTH + lane], h)
                meets |= here
                at_wall = (g1 <= TOUCH) | ((r0 < 0.0) & (r1 > 0.0) & (depth < 0.02 * (g0 + g1) * (r1 - r0)))
                suspect |= (is_open & at_wall & ~here) | (
                    ~is_open & ((bottom - beyond < 0.0) | (extremum & (beyond > 0.0)))
                )
            w0, w1 = seen0[at.W2_RATE * WIDTH + lane], seen1[at.W2_RATE * WIDTH + lane]
            tilt = lanes[at.BEST_TILT * WIDTH + lane]
            tilt = max(tilt, seen0[at.W2 * WIDTH + lane])
            lanes[at.BEST_TILT * WIDTH + lane] = tilt
            suspect |= (w0 > 0.0) & (w1 < 0.0) & (seen0[at.W2 * WIDTH + lane] + w0 * h > tilt)
            if rubs:
                best = lanes[at.TORQUE_MAX * WIDTH + lane]
                suspect |= may_peak(samples, seen0, seen1, at.S_TORQUE, best, coef, lanes, lane)
                best = lanes[at.DRIVE_MAX * WIDTH + lane]
                suspect |= may_peak(samples, seen0, seen1, at.S_DRIVE, best, coef, lanes, lane)
            tries = lanes[at.TRIES * WIDTH + lane]
            suspect &= (tries < MOST_TRIES) & (lanes[at.BUSY * WIDTH + lane] > 0.0)
            meets &= ~suspect & (lanes[at.BUSY * WIDTH + lane] > 0.0)
            decision[lane] = at.KEEP if suspect else (at.IMPACT if meets else at.TAKE)
            count += suspect
        return count

    @device
    def integral(h, samples, seen, quantity, row, square, lane):
        """What a step adds to an integral; a step that is not taken, of length 0 here, may have led anywhere."""
        return h * quadrature(samples, seen, quantity, row, square, lane) if h > 0.0 else 0.0

    @routine
    def take(y, f0, seen0, end, f1, seen1, coef, lanes, samples, limits, decision, calls):
        """Lanes that take their step: state, time, integrals, energy.

        Those that need more than that are told in ``calls``; returns how many they are.
        """
        touched = closed(coef) > 0.0
        for c in range(n_state):
            for lane in range(WIDTH):
                taken = decision[lane] != at.KEEP
                y[c * WIDTH + lane] = end[c * WIDTH + lane] if taken else y[c * WIDTH + lane]
                f0[c * WIDTH + lane] = f1[c * WIDTH + lane] if taken else f0[c * WIDTH + lane]
        for lane in range(WIDTH):
            taken = decision[lane] != at.KEEP
            h = coef[at.STEP * WIDTH + lane] if taken else 0.0
            if touched:
                lanes[at.INTEGRAL_D * WIDTH + lane] += integral(h, samples, seen0, 0, at.N_D, False, lane)
                lanes[at.INTEGRAL_E * WIDTH + lane] += integral(h, samples, seen0, 1, at.N_E, False, lane)
                lanes[at.SQUARE_D * WIDTH + lane] += integral(h, samples, seen0, 0, at.N_D, True, lane)
                lanes[at.SQUARE_E * WIDTH + lane] += integral(h, samples, seen0, 1, at.N_E, True, lane)
            if works:
                lanes[at.WORK * WIDTH + lane] += integral(h, samples, seen0, at.S_POWER, at.POWER, False, lane)
        if rubs:
            for lane in range(WIDTH):
                h = coef[at.STEP * WIDTH + lane] if decision[lane] != at.KEEP else 0.0
                lanes[at.WORK_SLIP_D * WIDTH + lane] += integral(h, samples, seen0, at.S_SLIP_D, at.SLIP_D, False, lane)
                lanes[at.WORK_SLIP_E * WIDTH + lane] += integral(h, samples, seen0, at.S_SLIP_E, at.SLIP_E, False, lane)
                lanes[at.WORK_HEAT * WIDTH + lane] += integral(h, samples, seen0, at.S_HEAT, at.HEAT, False, lane)
                lanes[at.TORQUE_INTEGRAL * WIDTH + lane] += integral(
                    h, samples, seen0, at.S_TORQUE, at.TORQUE, False, lane
                )
                lanes[at.TURN * WIDTH + lane] += integral(h, samples, seen0, at.S_WHIRL, at.WHIRL, False, lane)
                lanes[at.DRIVE_INTEGRAL * WIDTH + lane] += integral(
                    h, samples, seen0, at.S_DRIVE, at.DRIVE, False, lane
                )
                if swings:
                    lanes[at.DRIVE_WORK * WIDTH + lane] += integral(
                        h, samples, seen0, at.S_DRIVE_POWER, at.DRIVE_POWER, False, lane
                    )
                # The slip's crossing of the slip speed is linear within a step: weights of either sign suit no jump.
                first, last = seen0[at.SLOW * WIDTH + lane], seen1[at.SLOW * WIDTH + lane]
                size = abs(first) + abs(last)
                share = (max(-first, 0.0) + max(-last, 0.0)) / size if size > 0.0 else 0.0
                lanes[at.TIME_SLOW * WIDTH + lane] += h * share
                largest = max(seen0[at.TORQUE * WIDTH + lane], seen1[at.TORQUE * WIDTH + lane])
                before = lanes[at.TORQUE_MAX * WIDTH + lane]
                lanes[at.TORQUE_MAX * WIDTH + lane] = max(before, largest) if h > 0.0 else before
                largest = max(abs(seen0[at.DRIVE * WIDTH + lane]), abs(seen1[at.DRIVE * WIDTH + lane]))
                before = lanes[at.DRIVE_MAX * WIDTH + lane]
                lanes[at.DRIVE_MAX * WIDTH + lane] = max(before, largest) if h > 0.0 else before
        for lane in range(WIDTH):
            taken = decision[lane] != at.KEEP
            h = coef[at.STEP * WIDTH + lane] if taken else 0.0
            open_d, open_e = coef[at.CLOSED_D * WIDTH + lane] == 0.0, coef[at.CLOSED_E * WIDTH + lane] == 0.0
            lanes[at.T * WIDTH + lane] += h
            lanes[at.TIME_D * WIDTH + lane] += 0.0 if open_d else h
            lanes[at.TIME_E * WIDTH + lane] += 0.0 if open_e else h
            lanes[at.TIME_FREE * WIDTH + lane] += h if open_d and open_e else 0.0
            kinetic = seen1[at.KINETIC * WIDTH + lane]
            balance = kinetic + seen1[at.POTENTIAL * WIDTH + lane] - lanes[at.WORK * WIDTH + lane]
            drift = abs(balance + lanes[at.IMPACT_LOSS * WIDTH + lane] - lanes[at.ENERGY_0 * WIDTH + lane])
            worst, scale = lanes[at.ENERGY_ERROR * WIDTH + lane], lanes[at.ENERGY_SCALE * WIDTH + lane]
            # Written so that NaN is kept: a comparison with NaN is false.
            lanes[at.ENERGY_ERROR * WIDTH + lane] = drift if taken and not drift <= worst else worst
            lanes[at.ENERGY_SCALE * WIDTH + lane] = kinetic if taken and kinetic > scale else scale
            gap_d, gap_e = seen1[at.GAP_D * WIDTH + lane], seen1[at.GAP_E * WIDTH + lane]
            miss = max(-gap_d if open_d else abs(gap_d), -gap_e if open_e else abs(gap_e))
            deepest = lanes[at.PENETRATION * WIDTH + lane]
            # The end of a step before an impact may lie a little beyond the wall: it is put right there.
            inside = taken and decision[lane] != at.IMPACT
            lanes[at.PENETRATION * WIDTH + lane] = miss if inside and not miss <= deepest else deepest
            reference = lanes[at.LOAD_REFERENCE * WIDTH + lane]
            largest = max(max(seen1[at.N_D * WIDTH + lane], seen1[at.N_E * WIDTH + lane]), reference)
            lanes[at.LOAD_REFERENCE * WIDTH + lane] = largest if taken else reference
            for side in range(2):
                is_open = open_d if side == 0 else open_e
                row, opened = (at.ARMED_D + side) * WIDTH + lane, gap_d if side == 0 else gap_e
                lanes[row] = 1.0 if taken and is_open and opened > OPENED else lanes[row]
                # The end of the last step before an event is an end of closed contact too.
                force = seen1[(at.N_D + side) * WIDTH + lane]
                high, low = (at.BEST_D_MAX, at.BEST_D_MIN) if side == 0 else (at.BEST_E_MAX, at.BEST_E_MIN)
                best_high, best_low = lanes[high * WIDTH + lane], lanes[low * WIDTH + lane]
                lanes[high * WIDTH + lane] = max(best_high, force) if inside and not is_open else best_high
                lanes[low * WIDTH + lane] = max(best_low, -force) if inside and not is_open else best_low
            tilt = lanes[at.BEST_TILT * WIDTH + lane]
            lanes[at.BEST_TILT * WIDTH + lane] = max(tilt, seen1[at.W2 * WIDTH + lane]) if inside else tilt
            hold = lanes[at.HOLD * WIDTH + lane]
            lanes[at.HOLD * WIDTH + lane] = 0.0 if taken else hold
            tries = lanes[at.TRIES * WIDTH + lane]
            lanes[at.TRIES * WIDTH + lane] = 0.0 if taken else tries + 1.0
            # A step taken without a look because looking has led nowhere.
            status = lanes[at.STATUS * WIDTH + lane]
            lanes[at.STATUS * WIDTH + lane] = at.UNRESOLVED if taken & (tries >= MOST_TRIES) else status
            lanes[at.ROUNDS * WIDTH + lane] += lanes[at.BUSY * WIDTH + lane]
        for row in range(at.SEEN):
            for lane in range(WIDTH):
                here = row * WIDTH + lane
                seen0[here] = seen1[here] if decision[lane] != at.KEEP else seen0[here]
        steps, duration, most, accuracy = limits
        until, count = duration * (1.0 - ROUNDING), 0
        for lane in range(WIDTH):
            energy = seen0[at.KINETIC * WIDTH + lane] + seen0[at.POTENTIAL * WIDTH + lane]
            sound = (abs(energy) < math.inf) & (lanes[at.ENERGY_ERROR * WIDTH + lane] < math.inf)
            sound &= (lanes[at.PENETRATION * WIDTH + lane] <= accuracy) & (lanes[at.STATUS * WIDTH + lane] == 0.0)
            if rubs:
                sound &= seen0[at.MARGIN * WIDTH + lane] > 0.0
            passed = lanes[at.EVENTS * WIDTH + lane]
            sound &= (passed <= most) & (lanes[at.ROUNDS * WIDTH + lane] <= MOST_ROUNDS * (steps + passed))
            quiet = (decision[lane] <= at.TAKE) & (lanes[at.MODE * WIDTH + lane] == 0.0)
            quiet &= lanes[at.T * WIDTH + lane] < until
            needed = ~(sound & quiet) & (lanes[at.BUSY * WIDTH + lane] > 0.0)
            calls[lane] = 1 if needed else 0
            count += needed
        return count

    @routine
    def renew(f0, seen0, f1, seen1, decision):
        """What is seen after a jump, in the lanes that have jumped."""
        for c in range(n_state):
            for lane in range(WIDTH):
                jumped = decision[lane] > at.TAKE
                f0[c * WIDTH + lane] = f1[c * WIDTH + lane] if jumped else f0[c * WIDTH + lane]
        for row in range(at.SEEN):
            for lane in range(WIDTH):
                here = row * WIDTH + lane
                seen0[here] = seen1[here] if decision[lane] > at.TAKE else seen0[here]

    @routine
    def next_steps(coef, lanes, seen0, step_length, duration, decision):
        """Length of every lane's next step: the common one, or less, to the end or to where it will meet the wall."""
        for lane in range(WIDTH):
            h = min(step_length, lanes[at.HINT * WIDTH + lane])
            for side in range(2):
                # A contact that has been released and has not opened yet foretells nothing.
                is_open = lanes[(at.ARMED_D + side) * WIDTH + lane] > 0.0
                is_open &= coef[(at.CLOSED_D + side) * WIDTH + lane] == 0.0
                g, r = seen0[(at.GAP_D + side) * WIDTH + lane], seen0[(at.RATE_D + side) * WIDTH + lane]
                a = seen0[(at.ACC_D + side) * WIDTH + lane]
                # First positive root of g + r t + a t^2/2, in the form that does not cancel.
                g = 0.0 if (g < TOGETHER) & (r > 0.0) else g
                square = r * r - 2.0 * a * g
                root = math.sqrt(max(square, 0.0))
                falling, rising = 2.0 * g / (root - r), (root + r) / -a
                t = falling if r <= 0.0 else rising
                foretold = is_open & (square > 0.0) & (t > 0.0) & (t < h) & ((r < 0.0) | (a < 0.0)) & (g < far)
                h = t if foretold else h
            left = duration - lanes[at.T * WIDTH + lane]
            h = left if h >= left * (1.0 - 1e-9) else h
            # A motion that is over at its start, or at an event, goes nowhere from there.
            h = 0.0 if lanes[at.STATUS * WIDTH + lane] != 0.0 else h
            coef[at.STEP * WIDTH + lane] = coef[at.STEP * WIDTH + lane] if decision[lane] == at.KEEP else h
            lanes[at.HINT * WIDTH + lane] = lanes[at.HINT * WIDTH + lane] if decision[lane] == at.KEEP else math.inf

    return Clock(screen, take, renew, next_steps)
