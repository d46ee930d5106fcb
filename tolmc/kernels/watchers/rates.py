"""Rates of change of the contact forces, and with friction of its moment, at the ends of steps.

Through the values at an end and at three ends on either side, and through the means over the steps between, goes a polynomial
of degree 12: the means, which the method's weights know to its order, are worth as much as values twice as dense. Its slope is
the rate wherever the polynomial of degree 8, of two steps on either side, says the same. Elsewhere, and where a motion begins
and ends, the rate is the motion's own, for one look more.
"""

from __future__ import annotations

from tolmc.kernels.interpolation import slope_through
from tolmc.kernels.jit import device, routine
from tolmc.kernels.lanes import WIDTH
from tolmc.kernels.seen import N_D, N_E, RATE_D, RATE_E, RATE_TORQUE, REACH, SUM_D, SUM_E, SUM_TORQUE, SUPPORT, TORQUE
from tolmc.kernels.system import System
from tolmc.kernels.watchers import Watcher

#: By how much two polynomials' slopes may differ, as a share of the sizes at an end and the two beside. The paper's joint in 48
#: steps: 3e-4 of the largest force, while the better one errs by 9e-5; in 64 steps 4e-5 and 5e-6, in 128 1e-7 and 2e-9.
_ALIKE = 1e-3

_BEST, _FEWER = slope_through(2 * REACH + 1, REACH), slope_through(2 * REACH - 1, REACH - 1)
# By symmetry the slope goes by differences: of the values one, two, three ends ahead and back, and of the means.
_N1, _N2, _N3, _M1, _M2, _M3 = (float(_BEST[at]) for at in (4, 5, 6, 10, 11, 12))
_D1, _D2, _E1, _E2 = (float(_BEST[at] - _FEWER[less]) for at, less in ((4, 3), (5, 4), (10, 7), (11, 8)))


def watch(system: System) -> Watcher:
    """Watcher that puts rates into the windows, before the others look at them."""
    layout, state, what, at, until = system.layout, system.equations.STATE, system.seen, system.at, system.until
    see, full, stride, rubs = system.stepper.see, system.h, system.seen * WIDTH, system.equations.RUBS
    variables = 3 if rubs else 2
    slope_rows, apart_rows, seen_rows = layout.block(variables), layout.block(variables), layout.block(what)

    @device
    def slope_of(seen, value, integral, per_step, lane):
        """The slope of one variable in the middle of seven ends, and whether it is to be trusted."""
        n, m = value * WIDTH + lane, integral * WIDTH + lane
        before, here, after = seen[n + 2 * stride], seen[n + 3 * stride], seen[n + 4 * stride]
        n1, m1 = after - before, per_step * (seen[m + 3 * stride] - seen[m + 2 * stride])
        n2, m2 = seen[n + 5 * stride] - seen[n + stride], per_step * (seen[m + 4 * stride] - seen[m + stride])
        n3, m3 = seen[n + 6 * stride] - seen[n], per_step * (seen[m + 5 * stride] - seen[m])
        slope = _N1 * n1 + _N2 * n2 + _N3 * n3 + _M1 * m1 + _M2 * m2 + _M3 * m3
        apart = _D1 * n1 + _D2 * n2 + _N3 * n3 + _E1 * m1 + _E2 * m2 + _M3 * m3
        return slope, abs(apart) <= _ALIKE * (abs(before) + abs(here) + abs(after))

    @routine
    def differentiate(seen, per_step, until, begun, slopes, apart):
        """Slopes of all variables; ``apart`` is 1 where they are not to be trusted. Returns how often, while motions go on."""
        count = 0
        for lane in range(WIDTH):
            slopes[lane], trusted = slope_of(seen, N_D, SUM_D, per_step, lane)
            apart[lane] = 0.0 if trusted else 1.0
            count += (not trusted) & (until[lane] >= begun)
        for lane in range(WIDTH):
            slopes[WIDTH + lane], trusted = slope_of(seen, N_E, SUM_E, per_step, lane)
            apart[WIDTH + lane] = 0.0 if trusted else 1.0
            count += (not trusted) & (until[lane] >= begun)
        if rubs:
            for lane in range(WIDTH):
                slopes[2 * WIDTH + lane], trusted = slope_of(seen, TORQUE, SUM_TORQUE, per_step, lane)
                apart[2 * WIDTH + lane] = 0.0 if trusted else 1.0
                count += (not trusted) & (until[lane] >= begun)
        return count

    @routine
    def put(slopes, here):
        for lane in range(WIDTH):
            here[RATE_D * WIDTH + lane], here[RATE_E * WIDTH + lane] = slopes[lane], slopes[WIDTH + lane]
            if rubs:
                here[RATE_TORQUE * WIDTH + lane] = slopes[2 * WIDTH + lane]

    @routine
    def put_own(own, apart, here):
        """The motion's own rates where the slopes are not to be trusted."""
        for lane in range(WIDTH):
            d, e = RATE_D * WIDTH + lane, RATE_E * WIDTH + lane
            here[d] = own[d] if apart[lane] > 0.0 else here[d]
            here[e] = own[e] if apart[WIDTH + lane] > 0.0 else here[e]
            if rubs:
                t = RATE_TORQUE * WIDTH + lane
                here[t] = own[t] if apart[2 * WIDTH + lane] > 0.0 else here[t]

    @routine
    def scan(run, block, window, coef, work):
        slopes, apart, own, ends = work[slope_rows], work[apart_rows], work[seen_rows], work[until : until + WIDTH]
        begun, per_step = window.first + window.head + 0.0, 1.0 / run.step_length
        # Of a later window the first ends have their rates; at the last end of a motion the look has seen them.
        for row in range(0 if begun == 0.0 else SUPPORT - 1, window.last + (window.last < window.end)):
            first, doubted = row - REACH, WIDTH
            if (first >= 0) & (first + 2 * REACH <= window.end):
                doubted = differentiate(window.seen[first * stride :], per_step, ends, begun, slopes, apart)
                put(slopes, at(window.seen, row))
            else:
                work[apart_rows] = 1.0
            if doubted > 0:
                see(window.states[row * state * WIDTH : (row + 1) * state * WIDTH], coef, work[full], own, work)
                put_own(own, apart, at(window.seen, row))

    return Watcher(scan=scan)
