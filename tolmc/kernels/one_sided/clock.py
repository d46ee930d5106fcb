"""What every lane does after a round, in packed loops: see whether something happened, take the step."""

from __future__ import annotations

import math
from typing import NamedTuple

from tolmc.kernels.jit import device, routine
from tolmc.kernels.one_sided import integrals
from tolmc.kernels.one_sided import layout as at
from tolmc.kernels.one_sided.approach import AT_HAND, at_hand
from tolmc.kernels.one_sided.equations import Equations
from tolmc.kernels.one_sided.lane import OPENED, TORQUE_ROUNDING, TOUCH
from tolmc.kernels.one_sided.layout import WIDTH
from tolmc.kernels.one_sided.stepper import Stepper, replacer
from tolmc.kernels.tableaux import CLASSICAL, DORMAND_PRINCE
from tolmc.kernels.watchers.bends import highest

#: Rounds for each step and event after which a lane is given up; usual are one and two.
MOST_ROUNDS = 64
#: Of the duration: a motion that lacks no more of it is at its end.
ROUNDING = 4e-16
#: Shortenings of one step after which a lane is given up.
MOST_TRIES = 60


class Clock(NamedTuple):
    """Routines over a block of lanes."""

    screen: object
    take: object
    renew: object


def build(equations: Equations, stepper: Stepper, rk4: bool) -> Clock:
    """The loops of one kind of scene."""
    looked_samples, ends = stepper.looked_samples, stepper.ends
    rubs, far = equations.rubs, equations.far
    replace_state, replace_seen = replacer(equations.state), replacer(equations.seen)
    add = integrals.build(equations, CLASSICAL if rk4 else DORMAND_PRINCE, looks=True)

    @device
    def may_peak(seen0, seen1, quantity, h, best, coef, lanes, lane):
        """Whether a torque's size may have a new maximum within a step."""
        zero = TORQUE_ROUNDING * coef[at.ROUND * WIDTH + lane] * lanes[at.LOAD_REFERENCE * WIDTH + lane]
        n0, n1, m0, m1 = ends(seen0, seen1, quantity, h, lane)
        either = max(highest(n0, n1, m0, m1), highest(-n0, -n1, -m0, -m1))
        return either > max(best, max(abs(n0), abs(n1))) + zero

    @device
    def foresee(coef, lanes, seen0, seen1, duration):
        """Time from the end of every step to the wall, for contacts that come next to it there; infinite for others."""
        for lane in range(WIDTH):
            h = coef[at.STEP * WIDTH + lane]
            left = duration - lanes[at.T * WIDTH + lane] - h
            for side in range(2):
                g0, g1 = seen0[(at.GAP_D + side) * WIDTH + lane], seen1[(at.GAP_D + side) * WIDTH + lane]
                r0, r1 = seen0[(at.RATE_D + side) * WIDTH + lane], seen1[(at.RATE_D + side) * WIDTH + lane]
                a0, a1 = seen0[(at.ACC_D + side) * WIDTH + lane], seen1[(at.ACC_D + side) * WIDTH + lane]
                armed = lanes[(at.ARMED_D + side) * WIDTH + lane] > 0.0
                armed &= coef[(at.CLOSED_D + side) * WIDTH + lane] == 0.0
                rest = at_hand(g0, r0, a0, g1, r1, a1, h, far)
                lanes[(at.REST_D + side) * WIDTH + lane] = rest if armed & (rest <= left) else math.inf

    @routine
    def screen(coef, lanes, samples, seen0, seen1, duration, decision):
        """TAKE for lanes in whose step nothing happens, IMPACT for those that have just come to the wall at its end.

        KEEP for those to be looked at; returns how many those are.
        """
        count = 0
        foresee(coef, lanes, seen0, seen1, duration)
        for lane in range(WIDTH):
            open_d, open_e = coef[at.CLOSED_D * WIDTH + lane] == 0.0, coef[at.CLOSED_E * WIDTH + lane] == 0.0
            h = coef[at.STEP * WIDTH + lane]
            suspect, meets, slackens = False, False, False
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
                # The ends are taken without looking.
                _, last, up, down = ends(seen0, seen1, side, h, lane)
                least = highest(-s0, -last, -up, -down)
                extremum = (highest(s0, last, up, down) > best_high) | (least > best_low)
                g0, g1 = seen0[(at.GAP_D + side) * WIDTH + lane], seen1[(at.GAP_D + side) * WIDTH + lane]
                r0, r1 = seen0[(at.RATE_D + side) * WIDTH + lane], seen1[(at.RATE_D + side) * WIDTH + lane]
                # Below both tangents of a gap that dips no gap can be as long as it is convex.
                depth = g0 * r1 - g1 * r0 + r0 * r1 * h
                here = lanes[(at.REST_D + side) * WIDTH + lane] < math.inf
                meets |= here
                # A force that may fall to zero on the way from the step's end to the wall.
                slackens |= (not is_open) & (last + 2.0 * AT_HAND * down <= 0.0)
                at_wall = (g1 <= TOUCH) | ((r0 < 0.0) & (r1 > 0.0) & (depth < 0.02 * (g0 + g1) * (r1 - r0)))
                suspect |= (is_open & at_wall & (not here)) | (
                    (not is_open) & ((min(bottom - beyond, -least) < 0.0) | extremum)
                )
            w0, w1 = seen0[at.W2_RATE * WIDTH + lane], seen1[at.W2_RATE * WIDTH + lane]
            tilt = lanes[at.BEST_TILT * WIDTH + lane]
            tilt = max(tilt, seen0[at.W2 * WIDTH + lane])
            lanes[at.BEST_TILT * WIDTH + lane] = tilt
            suspect |= (w0 > 0.0) & (w1 < 0.0) & (seen0[at.W2 * WIDTH + lane] + w0 * h > tilt)
            if rubs:
                best = lanes[at.TORQUE_MAX * WIDTH + lane]
                suspect |= may_peak(seen0, seen1, at.S_TORQUE, h, best, coef, lanes, lane)
                best = lanes[at.DRIVE_MAX * WIDTH + lane]
                suspect |= may_peak(seen0, seen1, at.S_DRIVE, h, best, coef, lanes, lane)
            rest = min(lanes[at.REST_D * WIDTH + lane], lanes[at.REST_E * WIDTH + lane])
            falls_first = slackens & (rest > 0.0)
            meets &= not falls_first
            for side in range(2):
                row = (at.REST_D + side) * WIDTH + lane
                lanes[row] = math.inf if falls_first else lanes[row]
            tries = lanes[at.TRIES * WIDTH + lane]
            suspect &= (tries < MOST_TRIES) & (lanes[at.BUSY * WIDTH + lane] > 0.0)
            meets &= (not suspect) & (lanes[at.BUSY * WIDTH + lane] > 0.0)
            decision[lane] = at.KEEP if suspect else (at.IMPACT if meets else at.TAKE)
            count += suspect
        return count

    @routine
    def take(y, f0, seen0, end, f1, seen1, coef, lanes, samples, limits, decision, calls):
        """Lanes that take their step: state, time, integrals, energy.

        Those that need more than that are told in ``calls``; returns how many they are.
        """
        replace_state(y, end, decision, at.TAKE)
        replace_state(f0, f1, decision, at.TAKE)
        for lane in range(WIDTH):
            lanes[at.GONE * WIDTH + lane] = coef[at.STEP * WIDTH + lane] if decision[lane] != at.KEEP else 0.0
        add(coef, lanes, samples, seen0, seen1)
        for lane in range(WIDTH):
            taken = decision[lane] != at.KEEP
            open_d, open_e = coef[at.CLOSED_D * WIDTH + lane] == 0.0, coef[at.CLOSED_E * WIDTH + lane] == 0.0
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
        replace_seen(seen0, seen1, decision, at.TAKE)
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
        replace_state(f0, f1, decision, at.IMPACT)
        replace_seen(seen0, seen1, decision, at.IMPACT)

    return Clock(screen, take, renew)
