"""Where the wall will be met: the length of every lane's next step, in packed loops.

By the gaps' values, rates and second derivatives; where a step is so long that these foretell little, by the gaps along a way
with constant accelerations; and by the equations at the end of that way.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from tolmc.kernels.jit import routine, strict
from tolmc.kernels.one_sided import layout as at
from tolmc.kernels.one_sided.approach import time_to
from tolmc.kernels.one_sided.equations import Equations
from tolmc.kernels.one_sided.integrals import closed
from tolmc.kernels.one_sided.jump import TOGETHER
from tolmc.kernels.one_sided.layout import WIDTH

_TRUSTED = 0.3  # of the time to the wall: corrections up to it are believed
_FAR_MOVED = 0.2  # of the clearance: what an end may move in a step for the gap's second derivative to foretell it
_MOST = 4  # corrections on the way with constant accelerations


class Forecast(NamedTuple):
    """Routines: ``forecast`` is all; its parts, in their order, are ``aim``, ``search`` and ``refine``."""

    forecast: object
    aim: object
    search: object
    refine: object


def build(equations: Equations) -> Forecast:
    """The forecast on given equations."""
    system, multipliers, reach, free = equations.system, equations.multipliers, equations.reach, equations.free
    far, n_state, glimpsed = equations.far, equations.state, equations.glimpsed

    @routine
    def aim(y, f0, coef, lanes, seen0, step_length, duration, decision):
        """Length of every lane's next step: the common one, or less, to the end or to where it will meet the wall.

        Returns how many lanes aim at the wall or may do so, whose length otherwise stands in CAP, and how many are of the
        second kind: in DOUBT, at their full length.
        """
        count, doubts = 0, 0
        for lane in range(WIDTH):
            h, t = min(step_length, lanes[at.HINT * WIDTH + lane]), math.inf
            left = duration - lanes[at.T * WIDTH + lane]
            h = left if h >= left * (1.0 - 1e-9) else h
            # A motion that is over at its start, or at an event, goes nowhere from there.
            h = 0.0 if lanes[at.STATUS * WIDTH + lane] != 0.0 else h
            doubt = False
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
                met = falling if r <= 0.0 else rising
                foretold = is_open & (square > 0.0) & (met > 0.0) & ((r < 0.0) | (a < 0.0)) & (g < far)
                t = min(t, met) if foretold else t
                sign = 1.0 - 2.0 * side
                ux = abs(y[at.OV_X * WIDTH + lane] + sign * y[at.WV_X * WIDTH + lane])
                uy = abs(y[at.OV_Y * WIDTH + lane] + sign * y[at.WV_Y * WIDTH + lane])
                ax = abs(f0[at.OV_X * WIDTH + lane] + sign * f0[at.WV_X * WIDTH + lane])
                ay = abs(f0[at.OV_Y * WIDTH + lane] + sign * f0[at.WV_Y * WIDTH + lane])
                dx, dy, least = h * (ux + 0.5 * h * ax), h * (uy + 0.5 * h * ay), max(g, _FAR_MOVED)
                doubt |= is_open & (dx * dx + dy * dy > least * least)
            goes = (decision[lane] != at.KEEP) & (lanes[at.BUSY * WIDTH + lane] > 0.0)
            aims = (t < (1.0 + _TRUSTED) * h) & goes
            doubt &= goes & (not aims)
            lanes[at.CAP * WIDTH + lane] = h if aims | doubt else 0.0
            lanes[at.DOUBT * WIDTH + lane] = 1.0 if doubt else 0.0
            kept = decision[lane] == at.KEEP
            coef[at.STEP * WIDTH + lane] = coef[at.STEP * WIDTH + lane] if kept else (t if aims else h)
            lanes[at.HINT * WIDTH + lane] = lanes[at.HINT * WIDTH + lane] if kept else math.inf
            count += aims | doubt
            doubts += doubt
        return count, doubts

    @routine
    def go(y, f0, coef, lanes, argument):
        """Every lane that aims to the end of its way with constant accelerations."""
        for c in range(n_state):
            for lane in range(WIDTH):
                t = coef[at.STEP * WIDTH + lane] if lanes[at.CAP * WIDTH + lane] > 0.0 else 0.0
                bend = 0.5 * t * t * f0[(c + 4) * WIDTH + lane] if c < 4 else 0.0
                argument[c * WIDTH + lane] = y[c * WIDTH + lane] + t * f0[c * WIDTH + lane] + bend

    @routine
    def search(f0, coef, lanes, argument):
        """Back from the end of that way, of lanes in doubt that have passed the wall there; returns how many those are."""
        count = 0
        for lane in range(WIDTH):
            ax, ay, bx, by = accelerations(f0, lane)
            _, _, gap, rate, acc = reach(argument, ax, ay, bx, by, coef, lane, WIDTH)
            t, nearest = coef[at.STEP * WIDTH + lane], math.inf
            for side in range(2):
                is_open = lanes[(at.ARMED_D + side) * WIDTH + lane] > 0.0
                is_open &= coef[(at.CLOSED_D + side) * WIDTH + lane] == 0.0
                back = time_to(gap[side], rate[side], acc[side])
                beyond = is_open & (gap[side] < 0.0) & (rate[side] < 0.0) & (-back < t)
                nearest = min(nearest, back) if beyond else nearest
            # Less is left to the equations.
            moves = (lanes[at.DOUBT * WIDTH + lane] > 0.0) & (nearest < -0.5 * _TRUSTED * t)
            coef[at.STEP * WIDTH + lane] = t + nearest if moves else t
            lanes[at.DOUBT * WIDTH + lane] = 1.0 if moves else 0.0
            count += moves
        return count

    @strict
    def accelerations(f0, lane):
        return (
            f0[at.OV_X * WIDTH + lane], f0[at.OV_Y * WIDTH + lane], f0[at.WV_X * WIDTH + lane], f0[at.WV_Y * WIDTH + lane],
        )  # fmt: skip

    @strict
    def correct(argument, f0, now, coef, lanes, lane):
        """A lane's step by the accelerations ``now`` at the end of its way, as if they had changed evenly."""
        before = accelerations(f0, lane)
        jx, jy, kx, ky = now[0] - before[0], now[1] - before[1], now[2] - before[2], now[3] - before[3]
        d, e, gap, rate, acc = reach(argument, now[0], now[1], now[2], now[3], coef, lane, WIDTH)
        cap, t, nearest = lanes[at.CAP * WIDTH + lane], coef[at.STEP * WIDTH + lane], math.inf
        for side in range(2):
            (nx, ny, lever, _), sign = d if side == 0 else e, 1.0 - 2.0 * side
            change = -(nx * (jx + sign * lever * kx) + ny * (jy + sign * lever * ky))
            g, r = gap[side] + t * t / 6.0 * change, rate[side] + 0.5 * t * change
            further = time_to(g, r, acc[side])
            is_open = lanes[(at.ARMED_D + side) * WIDTH + lane] > 0.0
            is_open &= coef[(at.CLOSED_D + side) * WIDTH + lane] == 0.0
            met = is_open & (r < 0.0) & (abs(further) < _TRUSTED * t)
            nearest = min(nearest, t + further) if met else nearest
        t = min(cap, nearest if nearest < math.inf else t)
        coef[at.STEP * WIDTH + lane] = t if cap > 0.0 else coef[at.STEP * WIDTH + lane]

    @routine
    def refine(f0, coef, lanes, argument):
        """The step of lanes that aim at the wall by the equations at the end of their way, ``argument``."""
        if glimpsed and closed(coef) == 0:
            for lane in range(WIDTH):
                ax, ay, bx, by, _, _, _ = free(argument, coef[at.OMEGA_FIXED * WIDTH + lane], coef, lane, WIDTH)
                correct(argument, f0, (ax, ay, bx, by), coef, lanes, lane)
        else:
            for lane in range(WIDTH):
                a, pd, pe, matrix, acc, _, _, _, _, _, _, _ = system(argument, coef, lane, WIDTH)
                l_d, l_e = multipliers(matrix, acc, coef, lane, WIDTH)
                now = (
                    a[0] + l_d * pd[0] + l_e * pe[0], a[1] + l_d * pd[1] + l_e * pe[1],
                    a[2] + l_d * pd[2] + l_e * pe[2], a[3] + l_d * pd[3] + l_e * pe[3],
                )  # fmt: skip
                correct(argument, f0, now, coef, lanes, lane)

    @routine
    def forecast(y, f0, coef, lanes, seen0, argument, step_length, duration, decision):
        """Length of every lane's next step."""
        aims, doubts = aim(y, f0, coef, lanes, seen0, step_length, duration, decision)
        if aims > 0:
            go(y, f0, coef, lanes, argument)
            for _ in range(_MOST):
                if doubts > 0:
                    doubts = search(f0, coef, lanes, argument)
                    if doubts > 0:
                        go(y, f0, coef, lanes, argument)
            refine(f0, coef, lanes, argument)

    return Forecast(forecast, aim, search, refine)
