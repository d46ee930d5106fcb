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

from tolmc.kernels.jit import fma, inlined, routine
from tolmc.kernels.once import once
from tolmc.kernels.one_sided import layout as at
from tolmc.kernels.one_sided.equations import Equations
from tolmc.kernels.one_sided.layout import WIDTH
from tolmc.kernels.tableaux import CLASSICAL, DORMAND_PRINCE, Tableau

_ZERO = 1e-13  # entries of A A below it are what the coefficients' rounding leaves of zeros


class Formula(NamedTuple):
    """Routines over a block of lanes, which work in ``k``, so many ``rows``.

    ``step(in_flight, y, f0, coef, h, k, argument, samples, end)``: a step of every lane from ``y``, with rates ``f0``, to
    ``end``; values at the stages into ``samples`` (stage, quantity, lane). ``midpoint(y, k, out)``: the state in the
    middle of that step, where the formula has a continuous extension.
    """

    stages: int
    rows: int
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
    # A stage's numbers; after those of all stages, and of one more, the steps' lengths, once for each coordinate.
    size, stride = (n_state - at.OV_X) * WIDTH, equations.samples * WIDTH
    lengths_first = (stages + 1) * size
    evaluate, argument_of = evaluator(equations), _arguments(tableau, n_state, at.O_X)
    argument_in_flight = _arguments(tableau, n_state, at.W_X)
    to_midpoint = _argument(tableau, tableau.midpoint, n_state, at.O_X) if rk4 else None

    @routine
    def midpoint(y, k, out):
        to_midpoint(y, k[lengths_first:], k, out)

    @routine
    def step(in_flight, y, f0, coef, h, k, argument, samples, end):
        for c in range(at.OV_X, n_state):
            for lane in range(WIDTH):
                k[(c - at.OV_X) * WIDTH + lane] = h[lane] * f0[c * WIDTH + lane]
        lengths = k[lengths_first:]
        for c in range(at.OV_X):
            for lane in range(WIDTH):
                lengths[c * WIDTH + lane] = h[lane]
        for stage in range(1, stages):
            if in_flight:
                argument_in_flight(stage, y, lengths, k, argument)
            else:
                argument_of(stage, y, lengths, k, argument)
            row, place = stage * size, stage * stride
            evaluate(in_flight, argument, coef, h, k[row : row + size], samples[place : place + stride])
        argument_of(stages, y, lengths, k, end)

    return Formula(stages, lengths_first // WIDTH + at.OV_X, step, midpoint)


def _arguments(tableau: Tableau, n_state: int, first: int) -> Callable:
    """Function of the argument of stage ``stage``, from the second; of the end as one stage more."""
    rows = [*tableau.rows, tableau.weights]

    def from_stage(number: int) -> Callable:
        here = _argument(tableau, rows[number], n_state, first)
        if number == tableau.stages:

            @inlined
            def argument(stage, y, h, k, out):
                here(y, h, k, out)

        else:
            later = from_stage(number + 1)

            @inlined
            def argument(stage, y, h, k, out):
                if stage == number:
                    here(y, h, k, out)
                else:
                    later(stage, y, h, k, out)

        return argument

    return from_stage(1)


def _argument(tableau: Tableau, row: dict[int, float], n_state: int, first: int) -> Callable:
    """Routine of the state that one row of the formula leads to: coordinates and their speeds from row ``first`` on."""
    single = np.array([row.get(j, 0.0) for j in range(tableau.stages)])
    double, share, speeds = single @ tableau.matrix, float(single.sum()), at.OV_X * WIDTH
    speed_at, coordinate_at = _sum(single, n_state), _sum(np.where(abs(double) > _ZERO, double, 0.0), n_state)

    @routine
    def argument(y, h, k, out):
        for m in range(first * WIDTH, speeds):
            out[m] = fma(h[m], coordinate_at(share * y[speeds + m], k, m), y[m])
        for m in range(speeds + first * WIDTH, n_state * WIDTH):
            out[m] = speed_at(y[m], k, m - speeds)

    return argument


def _sum(weights: np.ndarray, n_state: int) -> Callable:
    """Device function of total + sum_j weights[j] k_j, element m; to the same bits in whichever loop."""
    columns = np.flatnonzero(weights)
    values, terms, size = weights[columns], len(columns), (n_state - at.OV_X) * WIDTH

    @inlined
    def total_of(total, k, m):
        for t in range(terms):
            total = fma(values[t], k[columns[t] * size + m], total)
        return total

    return total_of
