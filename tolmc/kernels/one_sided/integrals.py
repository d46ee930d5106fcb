"""What a step adds to times and integrals, by the weights of the formula that made it."""

from __future__ import annotations

from collections.abc import Callable

from tolmc.kernels.jit import device, routine
from tolmc.kernels.one_sided import layout as at
from tolmc.kernels.one_sided.equations import Equations
from tolmc.kernels.one_sided.layout import WIDTH
from tolmc.kernels.tableaux import Tableau
from tolmc.kernels.watchers.friction import slow_share


@device
def closed(coef):
    """How many contacts of a block are closed."""
    count = 0
    for row in range(at.CLOSED_D, at.CLOSED_E + 1):
        for lane in range(WIDTH):
            count += coef[row * WIDTH + lane] > 0.0
    return count


def build(equations: Equations, tableau: Tableau, *, looks: bool) -> Callable:
    """Routine ``add(coef, lanes, samples, seen0, seen1)`` for steps of length ``lanes[GONE]``, 0 where none is taken.

    ``samples`` are the values at the stages, ``seen0`` and ``seen1`` those at the two ends; ``looks``: whether those at the
    formula's own places within the step are there.
    """
    stages, weights, n_samples = tableau.stages, tableau.b, equations.samples
    works, rubs, swings = equations.works, equations.rubs, equations.swings
    places, rows = (tableau.positions, tableau.samples) if looks else ((0.0, 1.0), (0, stages))
    last = len(places) - 1

    @device
    def quadrature(samples, seen, quantity, row, square, lane):
        """Mean of a quantity, or of its square, over one lane's step by the formula's weights."""
        first = seen[row * WIDTH + lane]
        total = weights[0] * (first * first if square else first)
        for stage in range(1, stages):
            if weights[stage] != 0.0:
                value = samples[(stage * n_samples + quantity) * WIDTH + lane]
                total += weights[stage] * (value * value if square else value)
        return total

    @device
    def integral(h, samples, seen, quantity, row, square, lane):
        """What a step adds to an integral; a step that is not taken, of length 0 here, may have led anywhere."""
        return h * quadrature(samples, seen, quantity, row, square, lane) if h != 0.0 else 0.0

    @device
    def excess(samples, coef, row, lane):
        """SLOW at a place within a step: the least slip of the closed ends, from their slip power, less the slip speed."""
        slip = coef[at.SLIP * WIDTH + lane]
        least = 2.0 * slip
        for side in range(2):
            force = samples[(row * n_samples + at.S_D + side) * WIDTH + lane]
            power = samples[(row * n_samples + at.S_SLIP_D + side) * WIDTH + lane]
            presses = (coef[(at.CLOSED_D + side) * WIDTH + lane] > 0.0) & (force > 0.0)
            least = min(least, power / force) if presses else least
        return least - slip

    @device
    def slow_time(h, coef, samples, seen0, seen1, lane):
        """How long a step is below the slip speed, linear between its places."""
        if h == 0.0:
            return 0.0
        before, share = seen0[at.SLOW * WIDTH + lane], 0.0
        for place in range(1, last):
            here = excess(samples, coef, rows[place], lane)
            share += (places[place] - places[place - 1]) * slow_share(before, here)
            before = here
        return h * (share + (1.0 - places[last - 1]) * slow_share(before, seen1[at.SLOW * WIDTH + lane]))

    @device
    def add_friction(coef, lanes, samples, seen0, seen1):
        for lane in range(WIDTH):
            h = lanes[at.GONE * WIDTH + lane]
            lanes[at.WORK_SLIP_D * WIDTH + lane] += integral(h, samples, seen0, at.S_SLIP_D, at.SLIP_D, False, lane)
            lanes[at.WORK_SLIP_E * WIDTH + lane] += integral(h, samples, seen0, at.S_SLIP_E, at.SLIP_E, False, lane)
            lanes[at.WORK_HEAT * WIDTH + lane] += integral(h, samples, seen0, at.S_HEAT, at.HEAT, False, lane)
            lanes[at.TORQUE_INTEGRAL * WIDTH + lane] += integral(h, samples, seen0, at.S_TORQUE, at.TORQUE, False, lane)
            lanes[at.TURN * WIDTH + lane] += integral(h, samples, seen0, at.S_WHIRL, at.WHIRL, False, lane)
            lanes[at.DRIVE_INTEGRAL * WIDTH + lane] += integral(h, samples, seen0, at.S_DRIVE, at.DRIVE, False, lane)
            if swings:
                lanes[at.DRIVE_WORK * WIDTH + lane] += integral(
                    h, samples, seen0, at.S_DRIVE_POWER, at.DRIVE_POWER, False, lane
                )
            lanes[at.TIME_SLOW * WIDTH + lane] += slow_time(h, coef, samples, seen0, seen1, lane)
            largest = max(seen0[at.TORQUE * WIDTH + lane], seen1[at.TORQUE * WIDTH + lane])
            before = lanes[at.TORQUE_MAX * WIDTH + lane]
            lanes[at.TORQUE_MAX * WIDTH + lane] = max(before, largest) if h > 0.0 else before
            largest = max(abs(seen0[at.DRIVE * WIDTH + lane]), abs(seen1[at.DRIVE * WIDTH + lane]))
            before = lanes[at.DRIVE_MAX * WIDTH + lane]
            lanes[at.DRIVE_MAX * WIDTH + lane] = max(before, largest) if h > 0.0 else before

    @routine
    def add(coef, lanes, samples, seen0, seen1):
        if closed(coef) > 0:
            for lane in range(WIDTH):
                h = lanes[at.GONE * WIDTH + lane]
                lanes[at.INTEGRAL_D * WIDTH + lane] += integral(h, samples, seen0, at.S_D, at.N_D, False, lane)
                lanes[at.INTEGRAL_E * WIDTH + lane] += integral(h, samples, seen0, at.S_E, at.N_E, False, lane)
                lanes[at.SQUARE_D * WIDTH + lane] += integral(h, samples, seen0, at.S_D, at.N_D, True, lane)
                lanes[at.SQUARE_E * WIDTH + lane] += integral(h, samples, seen0, at.S_E, at.N_E, True, lane)
        if works:
            for lane in range(WIDTH):
                h = lanes[at.GONE * WIDTH + lane]
                lanes[at.WORK * WIDTH + lane] += integral(h, samples, seen0, at.S_POWER, at.POWER, False, lane)
        if rubs:
            add_friction(coef, lanes, samples, seen0, seen1)
        for lane in range(WIDTH):
            h = lanes[at.GONE * WIDTH + lane]
            open_d, open_e = coef[at.CLOSED_D * WIDTH + lane] == 0.0, coef[at.CLOSED_E * WIDTH + lane] == 0.0
            lanes[at.T * WIDTH + lane] += h
            lanes[at.TIME_D * WIDTH + lane] += 0.0 if open_d else h
            lanes[at.TIME_E * WIDTH + lane] += 0.0 if open_e else h
            lanes[at.TIME_FREE * WIDTH + lane] += h if open_d & open_e else 0.0

    return add
