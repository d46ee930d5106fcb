"""Steps of a whole block of lanes, from one array of states to another.

A stepper is made for one set of equations. Its function ``step(y, end, coef, h, seen, work)`` takes one step of ``h[lane]``
from ``y`` to ``end``, projected; ``see(y, coef, h, seen, work)`` looks at ``y`` alone. What both see goes to ``seen``, as
:mod:`tolmc.kernels.seen` has it: of a motion whose forces nobody asks for only the constraint error and the torque's work.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType

import numpy as np

from tolmc.kernels.jit import device, inlined, routine
from tolmc.kernels.lanes import WIDTH, Layout
from tolmc.kernels.seen import (
    ENERGY,
    ERROR,
    HEAT,
    KINETIC,
    LATE_D,
    LATE_E,
    MARGIN,
    N_D,
    N_E,
    RATE_D,
    RATE_E,
    RATE_TORQUE,
    RATE_W2,
    SLIP_D,
    SLIP_E,
    SLOW,
    SUM_D,
    SUM_S,
    SUM_SIZE,
    SUM_TORQUE,
    TORQUE,
    W2,
    WORK,
)
from tolmc.kernels.tableaux import Tableau, weighted_sum

#: What is sampled at a stage: N_D, N_E and a power; with friction also what rubs, in the order of :func:`rub_integrals`.
SAMPLES, RUBBING = 3, 5
#: Share of a step over which rates are taken: their error is 1e-6 of a quantity's change, of rounding 1e-10 of it.
NUDGE = 2.0**-20


@dataclass(frozen=True)
class Stepper:
    """A step and a look."""

    tableau: Tableau
    step: Callable
    see: Callable


@dataclass(frozen=True)
class Rows:
    """Where a step works: the argument of a stage, the stages' increments h y', then what is sampled at them."""

    argument: slice
    k: slice
    #: First row of the samples in the array of the increments, and how many there are a stage.
    samples: int
    per_stage: int

    @classmethod
    def of(cls, equations: ModuleType, tableau: Tableau, layout: Layout) -> Rows:
        """Rows of one stepper."""
        increments, per_stage = tableau.stages * equations.STATE, SAMPLES + (RUBBING if equations.RUBS else 0)
        argument = layout.block(equations.STATE)
        return cls(argument, layout.block(increments + per_stage * tableau.stages), increments, per_stage)


def sampler(equations: ModuleType, forces: bool) -> Callable:
    """Function ``sample(found, k, row, lane)``: what a right-hand side has found of one lane, as far as anyone sums it up."""
    torque = equations.TORQUE

    if equations.RUBS:

        @device
        def sample(found, k, row, lane):
            n_d, n_e, _, _, _, power, slip_d, slip_e, heat, moment, s, _, _ = found
            k[row + lane], k[row + WIDTH + lane], k[row + 2 * WIDTH + lane] = n_d, n_e, power
            k[row + 3 * WIDTH + lane], k[row + 4 * WIDTH + lane], k[row + 5 * WIDTH + lane] = slip_d, slip_e, heat
            k[row + 6 * WIDTH + lane], k[row + 7 * WIDTH + lane] = moment, s

    else:

        @device
        def sample(found, k, row, lane):
            n_d, n_e, _, _, _, power = found
            if forces:
                k[row + lane], k[row + WIDTH + lane] = n_d, n_e
            if torque:
                k[row + 2 * WIDTH + lane] = power

    return sample


def looker(equations: ModuleType, load: bool) -> Callable:
    """Function ``look(y, coef, h, k, argument, seen)``: the first stage, and all that is seen at ``y`` itself.

    Rates are those along the motion, by a look a little way along the first stage: no formulation needs equations for them.
    """
    if equations.RUBS:
        return _rubbing_looker(equations, load)
    state, advance, observe, torque = equations.STATE, equations.advance, equations.observe, equations.TORQUE

    # Loops by themselves: with more arrays in one, LLVM's alias checks exceed their limit and the loop is scalar.
    @routine
    def look(y, coef, h, k, argument, seen):
        for lane in range(WIDTH):
            n_d, n_e, w2, kinetic, potential, power = advance(y, coef, h[lane], k, 0, lane, WIDTH, load)
            seen[N_D * WIDTH + lane], seen[N_E * WIDTH + lane], seen[W2 * WIDTH + lane] = n_d, n_e, w2
            seen[KINETIC * WIDTH + lane], seen[ENERGY * WIDTH + lane] = kinetic, kinetic + potential
            if torque:
                seen[WORK * WIDTH + lane] = power
        for m in range(state * WIDTH):
            argument[m] = y[m] + NUDGE * k[m]
        for lane in range(WIDTH):
            _, _, _, _, n_d, n_e, _, _, _, _, w2 = observe(argument, coef, lane, WIDTH, load)
            seen[RATE_D * WIDTH + lane] = (n_d - seen[N_D * WIDTH + lane]) / NUDGE
            seen[RATE_E * WIDTH + lane] = (n_e - seen[N_E * WIDTH + lane]) / NUDGE
            seen[RATE_W2 * WIDTH + lane] = (w2 - seen[W2 * WIDTH + lane]) / NUDGE

    return look


def _rubbing_looker(equations: ModuleType, load: bool) -> Callable:
    """The same with what rubs: its powers stand at first where their integrals over the step will."""
    state, advance, sense = equations.STATE, equations.advance, equations.sense

    @routine
    def look(y, coef, h, k, argument, seen):
        for lane in range(WIDTH):
            n_d, n_e, w2, kinetic, potential, power, slip_d, slip_e, heat, moment, s, slow, margin = advance(
                y, coef, h[lane], k, 0, lane, WIDTH, load
            )
            seen[N_D * WIDTH + lane], seen[N_E * WIDTH + lane], seen[W2 * WIDTH + lane] = n_d, n_e, w2
            seen[KINETIC * WIDTH + lane], seen[ENERGY * WIDTH + lane] = kinetic, kinetic + potential
            seen[WORK * WIDTH + lane], seen[TORQUE * WIDTH + lane] = power, moment
            seen[SLIP_D * WIDTH + lane], seen[SLIP_E * WIDTH + lane], seen[HEAT * WIDTH + lane] = slip_d, slip_e, heat
            seen[SUM_S * WIDTH + lane], seen[SLOW * WIDTH + lane], seen[MARGIN * WIDTH + lane] = s, slow, margin
        for m in range(state * WIDTH):
            argument[m] = y[m] + NUDGE * k[m]
        for lane in range(WIDTH):
            n_d, n_e, w2, moment = sense(argument, coef, lane, WIDTH, load)
            seen[RATE_D * WIDTH + lane] = (n_d - seen[N_D * WIDTH + lane]) / NUDGE
            seen[RATE_E * WIDTH + lane] = (n_e - seen[N_E * WIDTH + lane]) / NUDGE
            seen[RATE_W2 * WIDTH + lane] = (w2 - seen[W2 * WIDTH + lane]) / NUDGE
            seen[RATE_TORQUE * WIDTH + lane] = (moment - seen[TORQUE * WIDTH + lane]) / NUDGE

    return look


def closing(tableau: Tableau, equations: ModuleType) -> Callable:
    """Function ``close(y, end, coef, k, seen)``: the step's end from all stages, projected, and the constraint error left."""
    state, project, step_end = equations.STATE, equations.project, weighted_sum(tableau.weights)
    size = state * WIDTH

    @inlined
    def close(y, end, coef, k, seen):
        for lane in range(WIDTH):
            for c in range(state):
                end[c * WIDTH + lane] = step_end(y, k, size, c * WIDTH + lane)
            seen[ERROR * WIDTH + lane] = project(end, coef, lane, WIDTH)

    return close


def integrals(tableau: Tableau, forces: bool, torque: bool, rows: Rows) -> Callable:
    """Function ``integrate(h, k, seen)``: integrals over the step by the method's own weights, of its order.

    What was seen at the stages stands in k, that of the first stage in ``seen``.
    """
    stages, weights, first, each = tableau.stages, tableau.b, rows.samples, rows.per_stage

    @inlined
    def integrate(h, k, seen):
        for lane in range(WIDTH):
            if forces:
                n_d, n_e = seen[N_D * WIDTH + lane], seen[N_E * WIDTH + lane]
                d, d2 = weights[0] * n_d, weights[0] * n_d * n_d
                e, e2 = weights[0] * n_e, weights[0] * n_e * n_e
                for stage in range(1, stages):
                    if weights[stage] != 0.0:
                        n_d = k[(first + each * stage) * WIDTH + lane]
                        n_e = k[(first + each * stage + 1) * WIDTH + lane]
                        d += weights[stage] * n_d
                        d2 += weights[stage] * n_d * n_d
                        e += weights[stage] * n_e
                        e2 += weights[stage] * n_e * n_e
                seen[SUM_D * WIDTH + lane], seen[(SUM_D + 1) * WIDTH + lane] = h[lane] * d, h[lane] * d2
                seen[(SUM_D + 2) * WIDTH + lane], seen[(SUM_D + 3) * WIDTH + lane] = h[lane] * e, h[lane] * e2
                seen[LATE_D * WIDTH + lane] = k[(first + each * (stages - 1)) * WIDTH + lane]
                seen[LATE_E * WIDTH + lane] = k[(first + each * (stages - 1) + 1) * WIDTH + lane]
        if torque:
            for lane in range(WIDTH):
                work = weights[0] * seen[WORK * WIDTH + lane]
                for stage in range(1, stages):
                    if weights[stage] != 0.0:
                        work += weights[stage] * k[(first + each * stage + 2) * WIDTH + lane]
                seen[WORK * WIDTH + lane] = h[lane] * work

    return integrate


def rub_integrals(tableau: Tableau, rows: Rows) -> Callable:
    """Function ``integrate(h, k, seen)``: the same of N |v| at both ends, the heat, the moment and its size, and s."""
    columns = np.array([stage for stage, weight in enumerate(tableau.b) if stage > 0 and weight != 0.0])
    weights, terms, begun = np.array(tableau.b)[columns], len(columns), tableau.b[0]
    first, each = rows.samples + SAMPLES, rows.per_stage

    @device
    def mean(k, begins, quantity, lane):
        total = begun * begins
        for t in range(terms):
            total += weights[t] * k[(first + each * columns[t] + quantity) * WIDTH + lane]
        return total

    # Short loops one after the other: LLVM unrolls the sum of a long one too late to pack it.
    @routine
    def integrate(h, k, seen):
        for lane in range(WIDTH):
            seen[SLIP_D * WIDTH + lane] = h[lane] * mean(k, seen[SLIP_D * WIDTH + lane], 0, lane)
        for lane in range(WIDTH):
            seen[SLIP_E * WIDTH + lane] = h[lane] * mean(k, seen[SLIP_E * WIDTH + lane], 1, lane)
        for lane in range(WIDTH):
            seen[HEAT * WIDTH + lane] = h[lane] * mean(k, seen[HEAT * WIDTH + lane], 2, lane)
        for lane in range(WIDTH):
            moment = begun * seen[TORQUE * WIDTH + lane]
            size = begun * abs(seen[TORQUE * WIDTH + lane])
            for t in range(terms):
                there = k[(first + each * columns[t] + 3) * WIDTH + lane]
                moment += weights[t] * there
                size += weights[t] * abs(there)
            seen[SUM_TORQUE * WIDTH + lane], seen[SUM_SIZE * WIDTH + lane] = h[lane] * moment, h[lane] * size
        for lane in range(WIDTH):
            seen[SUM_S * WIDTH + lane] = h[lane] * mean(k, seen[SUM_S * WIDTH + lane], 4, lane)

    return integrate
