"""Where the wall will be met: the length of every lane's next step, in packed loops."""

from __future__ import annotations

import math
from collections.abc import Callable

from tolmc.kernels.jit import routine
from tolmc.kernels.one_sided import layout as at
from tolmc.kernels.one_sided.approach import time_to
from tolmc.kernels.one_sided.equations import Equations
from tolmc.kernels.one_sided.jump import TOGETHER
from tolmc.kernels.one_sided.layout import WIDTH

_TRUSTED = 0.3  # of the time to the wall: corrections up to it are believed


def build(equations: Equations) -> tuple[Callable, Callable]:
    """Routines ``aim`` and ``refine``."""
    system, multipliers, far, n_state = equations.system, equations.multipliers, equations.far, equations.state

    @routine
    def aim(coef, lanes, seen0, step_length, duration, decision):
        """Length of every lane's next step: the common one, or less, to the end or to where it will meet the wall.

        By the gaps' values, rates and second derivatives; returns how many lanes aim at the wall, whose length otherwise stands
        in CAP.
        """
        count = 0
        for lane in range(WIDTH):
            h, t = min(step_length, lanes[at.HINT * WIDTH + lane]), math.inf
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
            left = duration - lanes[at.T * WIDTH + lane]
            h = left if h >= left * (1.0 - 1e-9) else h
            # A motion that is over at its start, or at an event, goes nowhere from there.
            h = 0.0 if lanes[at.STATUS * WIDTH + lane] != 0.0 else h
            kept = decision[lane] == at.KEEP
            aims = (t < (1.0 + _TRUSTED) * h) & (not kept) & (lanes[at.BUSY * WIDTH + lane] > 0.0)
            lanes[at.CAP * WIDTH + lane] = h if aims else 0.0
            coef[at.STEP * WIDTH + lane] = coef[at.STEP * WIDTH + lane] if kept else (t if aims else h)
            lanes[at.HINT * WIDTH + lane] = lanes[at.HINT * WIDTH + lane] if kept else math.inf
            count += aims
        return count

    @routine
    def refine(y, f0, coef, lanes, argument):
        """The same of lanes that aim at the wall, by the gaps there: at the end of a way with constant accelerations.

        The accelerations at that end correct the way, as if they changed evenly.
        """
        for c in range(n_state):
            for lane in range(WIDTH):
                t = coef[at.STEP * WIDTH + lane] if lanes[at.CAP * WIDTH + lane] > 0.0 else 0.0
                bend = 0.5 * t * t * f0[(c + 4) * WIDTH + lane] if c < 4 else 0.0
                argument[c * WIDTH + lane] = y[c * WIDTH + lane] + t * f0[c * WIDTH + lane] + bend
        for lane in range(WIDTH):
            cap, t, nearest = lanes[at.CAP * WIDTH + lane], coef[at.STEP * WIDTH + lane], math.inf
            a, pd, pe, matrix, acc, gap, rate, _, _, _, hd, he = system(argument, coef, lane, WIDTH)
            l_d, l_e = multipliers(matrix, acc, coef, lane, WIDTH)
            change_d, change_e = 0.0, 0.0
            for c in range(4):
                change = a[c] + l_d * pd[c] + l_e * pe[c] - f0[(c + 4) * WIDTH + lane]
                change_d, change_e = change_d + hd[c] * change, change_e + he[c] * change
            for side in range(2):
                change = change_d if side == 0 else change_e
                own, other = (matrix[0], matrix[1]) if side == 0 else (matrix[2], matrix[3])
                g, r = gap[side] + t * t / 6.0 * change, rate[side] + 0.5 * t * change
                further = time_to(g, r, acc[side] + own * l_d + other * l_e)
                is_open = lanes[(at.ARMED_D + side) * WIDTH + lane] > 0.0
                is_open &= coef[(at.CLOSED_D + side) * WIDTH + lane] == 0.0
                met = is_open & (r < 0.0) & (abs(further) < _TRUSTED * t)
                nearest = min(nearest, t + further) if met else nearest
            t = min(cap, nearest if nearest < math.inf else t)
            coef[at.STEP * WIDTH + lane] = t if cap > 0.0 else coef[at.STEP * WIDTH + lane]

    return aim, refine
