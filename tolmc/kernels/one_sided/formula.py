"""A formula's way through its stages: arguments of all lanes, right-hand sides, and the end.

Coordinates are integrated twice. With x' = v, v' = f and k_j = h f_j the formula's own sums are

    v_i = v + sum_j a_ij k_j,   x_i = x + h (c_i v + sum_j (A A)_ij k_j)

so that no stage keeps h x'; and since the free body's accelerations depend on neither o nor o', a block that flies needs these
at the end alone.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from tolmc.kernels.jit import inlined, once, routine
from tolmc.kernels.one_sided import layout as at
from tolmc.kernels.one_sided.equations import Equations
from tolmc.kernels.one_sided.layout import WIDTH
from tolmc.kernels.tableaux import CLASSICAL, DORMAND_PRINCE, Tableau, weighted_sum

_ZERO = 1e-13  # entries of A A below it are what the coefficients' rounding leaves of zeros


class Formula(NamedTuple):
    """Routines over a block of lanes; ``size`` numbers are what a stage keeps.

    ``step(in_flight, y, f0, coef, h, k, argument, samples, end)``: a step of every lane from ``y``, with rates ``f0``, to
    ``end``; values at the stages into ``samples`` (stage, quantity, lane). ``midpoint(x, v, h, k, out_x, out_v)``: coordinates
    and speeds in the middle of that step, where the formula has a continuous extension.
    """

    stages: int
    size: int
    step: object
    midpoint: object


@once
def evaluator(equations: Equations) -> Callable:
    """Routine ``evaluate(in_flight, argument, coef, h, k, samples)``: one stage of every lane's step of length ``h``.

    h times the speeds' rates into ``k``, and what the statistics want.
    """
    advance, fly = equations.advance, equations.fly

    @routine
    def evaluate(in_flight, argument, coef, h, k, samples):
        if in_flight:
            for lane in range(WIDTH):
                fly(argument, coef, h[lane], k, lane, WIDTH)
        else:
            for lane in range(WIDTH):
                advance(argument, coef, h[lane], k, samples, lane, WIDTH)

    return evaluate


@once
def build(equations: Equations, rk4: bool) -> Formula:
    """One formula on given equations; it stands in a kernel once, whoever asks for it."""
    tableau = CLASSICAL if rk4 else DORMAND_PRINCE
    stages, n_state = tableau.stages, equations.state
    speeds = at.OV_X * WIDTH
    size, stride = n_state * WIDTH - speeds, equations.samples * WIDTH
    evaluate = evaluator(equations)
    argument_of = _arguments(tableau, size)
    midpoint = _argument(tableau, tableau.midpoint, size) if rk4 else None

    @routine
    def step(in_flight, y, f0, coef, h, k, argument, samples, end):
        for c in range(at.OV_X, n_state):
            for lane in range(WIDTH):
                k[(c - at.OV_X) * WIDTH + lane] = h[lane] * f0[c * WIDTH + lane]
        first = at.W_X * WIDTH if in_flight else 0
        x, v, of_speeds = y[first:speeds], y[speeds + first :], k[first:]
        there_x, there_v = argument[first:speeds], argument[speeds + first :]
        for stage in range(1, stages):
            argument_of(stage, x, v, h, of_speeds, there_x, there_v)
            row, place = stage * size, stage * stride
            evaluate(in_flight, argument, coef, h, k[row : row + size], samples[place : place + stride])
        argument_of(stages, y[:speeds], y[speeds:], h, k, end[:speeds], end[speeds:])

    return Formula(stages, size, step, midpoint)


def _arguments(tableau: Tableau, size: int) -> Callable:
    """Function of the argument of stage ``stage``, from the second; of the end as one stage more."""
    rows = [*tableau.rows, tableau.weights]

    def from_stage(number: int) -> Callable:
        here = _argument(tableau, rows[number], size)
        if number == tableau.stages:

            @inlined
            def argument(stage, x, v, h, k, out_x, out_v):
                here(x, v, h, k, out_x, out_v)

        else:
            later = from_stage(number + 1)

            @inlined
            def argument(stage, x, v, h, k, out_x, out_v):
                if stage == number:
                    here(x, v, h, k, out_x, out_v)
                else:
                    later(stage, x, v, h, k, out_x, out_v)

        return argument

    return from_stage(1)


def _argument(tableau: Tableau, row: dict[int, float], size: int) -> Callable:
    """Routine of the coordinates and speeds that one row of the formula leads to."""
    single = np.array([row.get(j, 0.0) for j in range(tableau.stages)])
    double = {j: float(value) for j, value in enumerate(single @ tableau.matrix) if abs(value) > _ZERO}
    speed_at, coordinate_at = weighted_sum(row), weighted_sum(double, float(single.sum()))

    @routine
    def argument(x, v, h, k, out_x, out_v):
        for c in range(len(x) // WIDTH):
            for lane in range(WIDTH):
                m = c * WIDTH + lane
                out_x[m] = x[m] + h[lane] * coordinate_at(v, k, size, m)
        for m in range(len(v)):
            out_v[m] = speed_at(v, k, size, m)

    return argument
