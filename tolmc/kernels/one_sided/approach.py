"""The rest of the way to an impact: a short step of the classical formula, in all lanes that come to the wall at once.

A trial step ends where the wall was foretold to be, before it or behind; what is left of the way, within
:data:`AT_HAND` of the step, is too short for the formula of order 8 to be of use: with four evaluations of the equations its
error is (rest/T)^5/120 for motions that change in times of T.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from tolmc.kernels.jit import device, fma, routine, strict
from tolmc.kernels.one_sided import formula as formulas
from tolmc.kernels.one_sided import integrals
from tolmc.kernels.one_sided import layout as at
from tolmc.kernels.one_sided.equations import Equations
from tolmc.kernels.one_sided.events import hermite
from tolmc.kernels.one_sided.layout import WIDTH
from tolmc.kernels.one_sided.stepper import Stepper, replacer
from tolmc.kernels.tableaux import CLASSICAL

#: Of a step: an impact no further from its end is reached by a step of the classical formula.
AT_HAND = 1e-2
_AT_HAND_FROM_AFAR = 1e-3  # the same from where the gap's second derivative foretells nothing
_STEEP = 0.02  # gap times its second derivative over the square of its rate, up to which the wall is met steeply


@strict
def time_to(g, r, a):
    """Time to the wall, or back to it, of a gap that is next to nothing and closes."""
    return 2.0 * g / (math.sqrt(max(fma(-2.0 * a, g, r * r), 0.0)) - r)


@device
def at_hand(g0, r0, a0, g1, r1, a1, h, far):
    """Time from the end of a step to the wall, below 0 behind it; infinite unless the wall is next to the end.

    From the gap, its rate and its second derivative at both ends.
    """
    share = AT_HAND if g0 < far else _AT_HAND_FROM_AFAR
    near = (r1 < 0.0) & (abs(g1) <= share * h * abs(r1)) & (abs(g1) * abs(a1) <= _STEEP * r1 * r1)
    _, _, _, cubic, _, _ = hermite(g1, -r1, a1, g0, -r0, a0, h)
    cubic = cubic if g0 < far else 0.0
    rest = time_to(g1, r1, a1)
    # The cubic term goes backwards from the end, in steps.
    back = -rest / h
    rest -= cubic * back * back * back / (r1 + a1 * rest)
    return rest if near else math.inf


def build(equations: Equations, stepper: Stepper) -> Callable:
    """Routine ``approach``: lanes whose decision is IMPACT go to the wall, and stand there with ``seen0`` of it."""
    n_state, look, classical = equations.state, stepper.look, formulas.build(equations, True).step
    flies, replace_seen = not equations.works, replacer(equations.seen)
    add = integrals.build(equations, CLASSICAL, looks=False)

    @routine
    def onto_the_wall(y, end, f1, lanes, seen1, decision):
        """To the root of the gap at the step's end, by what is seen there."""
        for lane in range(WIDTH):
            hits, dt = decision[lane] == at.IMPACT, math.inf
            for side in range(2):
                g, r = seen1[(at.GAP_D + side) * WIDTH + lane], seen1[(at.RATE_D + side) * WIDTH + lane]
                a = seen1[(at.ACC_D + side) * WIDTH + lane]
                near = (lanes[(at.REST_D + side) * WIDTH + lane] < math.inf) & (r < 0.0)
                dt = min(dt, time_to(g, r, a)) if near else dt
            dt = dt if hits & (dt < math.inf) else 0.0
            for side in range(2):
                r, a = seen1[(at.RATE_D + side) * WIDTH + lane], seen1[(at.ACC_D + side) * WIDTH + lane]
                seen1[(at.GAP_D + side) * WIDTH + lane] += dt * (r + 0.5 * dt * a)
                seen1[(at.RATE_D + side) * WIDTH + lane] = r + dt * a
            lanes[at.GONE * WIDTH + lane] += dt
            for c in range(n_state):
                before = y[c * WIDTH + lane]
                bend = 0.5 * dt * dt * f1[(c + 4) * WIDTH + lane] if c < 4 else 0.0
                there = end[c * WIDTH + lane] + dt * f1[c * WIDTH + lane] + bend
                y[c * WIDTH + lane] = there if hits else before

    @routine
    def extrema(coef, lanes, seen0, seen1, decision):
        """The forces of closed contacts at the end of the way, and the tilt's maximum along it."""
        for lane in range(WIDTH):
            hits, rest = decision[lane] == at.IMPACT, lanes[at.GONE * WIDTH + lane]
            for side in range(2):
                force = seen1[(at.N_D + side) * WIDTH + lane]
                ends = hits & (coef[(at.CLOSED_D + side) * WIDTH + lane] > 0.0)
                high = (at.BEST_D_MAX + 2 * side) * WIDTH + lane
                low = (at.BEST_D_MIN + 2 * side) * WIDTH + lane
                lanes[high] = max(lanes[high], force) if ends else lanes[high]
                lanes[low] = max(lanes[low], -force) if ends else lanes[low]
            tilt, rise, fall = (
                seen1[at.W2 * WIDTH + lane],
                seen0[at.W2_RATE * WIDTH + lane],
                seen1[at.W2_RATE * WIDTH + lane],
            )
            peaks = (rest > 0.0) & (rise > 0.0) & (fall < 0.0)
            top = seen0[at.W2 * WIDTH + lane] + 0.5 * rest * rise * rise / (rise - fall)
            tilt = max(tilt, top) if peaks else tilt
            best = lanes[at.BEST_TILT * WIDTH + lane]
            lanes[at.BEST_TILT * WIDTH + lane] = max(best, tilt) if hits else best

    @routine
    def approach(y, f0, coef, lanes, seen0, k, argument, samples, end, f1, seen1, step_length, decision):
        for lane in range(WIDTH):
            rest = min(lanes[at.REST_D * WIDTH + lane], lanes[at.REST_E * WIDTH + lane])
            lanes[at.GONE * WIDTH + lane] = rest if (decision[lane] == at.IMPACT) & (rest < math.inf) else 0.0
        h = lanes[at.GONE * WIDTH : (at.GONE + 1) * WIDTH]
        classical(flies and integrals.closed(coef) == 0, y, f0, coef, h, k, argument, samples, end)
        look(end, coef, f1, seen1, argument, step_length)
        onto_the_wall(y, end, f1, lanes, seen1, decision)
        add(coef, lanes, samples, seen0, seen1)
        extrema(coef, lanes, seen0, seen1, decision)
        replace_seen(seen0, seen1, decision, at.IMPACT)

    return approach
