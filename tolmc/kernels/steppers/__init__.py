"""Steps of a whole block of lanes, from one array of states to another.

A stepper is made for one set of equations. Its function ``step(y, end, coef, h, seen, work)`` takes one step of ``h[lane]``
from ``y`` to ``end``, projected; ``see(y, coef, h, seen, work)`` looks at ``y`` alone. What both see goes to ``seen``, as
:mod:`tolmc.kernels.seen` has it: of a motion whose forces nobody asks for only the constraint error and the torque's work.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType

from tolmc.kernels.jit import inlined, routine
from tolmc.kernels.lanes import WIDTH, Layout
from tolmc.kernels.seen import (
    ENERGY,
    ERROR,
    KINETIC,
    LATE_D,
    LATE_E,
    N_D,
    N_E,
    RATE_D,
    RATE_E,
    RATE_W2,
    SUM_D,
    W2,
    WORK,
)
from tolmc.kernels.tableaux import Tableau, weighted_sum

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
    """Where a step works: the argument of a stage, the stages' increments h y', then N_D and N_E at them."""

    argument: slice
    k: slice
    #: First row of the forces in the array of the increments.
    forces: int

    @classmethod
    def of(cls, state: int, tableau: Tableau, layout: Layout) -> Rows:
        """Rows of one stepper."""
        increments = tableau.stages * state
        return cls(layout.block(state), layout.block(increments + 3 * tableau.stages), increments)


def looker(equations: ModuleType, load: bool) -> Callable:
    """Function ``look(y, coef, h, k, argument, seen)``: the first stage, and all that is seen at ``y`` itself.

    Rates are those along the motion, by a look a little way along the first stage: no formulation needs equations for them.
    """
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


def integrals(tableau: Tableau, forces: bool, torque: bool, first: int) -> Callable:
    """Function ``integrate(h, k, seen)``: integrals over the step by the method's own weights, of its order.

    What was seen at the stages stands in k from row ``first`` on, three rows a stage; of the first stage in ``seen``.
    """
    stages, weights = tableau.stages, tableau.b

    @inlined
    def integrate(h, k, seen):
        for lane in range(WIDTH):
            if forces:
                n_d, n_e = seen[N_D * WIDTH + lane], seen[N_E * WIDTH + lane]
                d, d2 = weights[0] * n_d, weights[0] * n_d * n_d
                e, e2 = weights[0] * n_e, weights[0] * n_e * n_e
                for stage in range(1, stages):
                    if weights[stage] != 0.0:
                        n_d = k[(first + 3 * stage) * WIDTH + lane]
                        n_e = k[(first + 3 * stage + 1) * WIDTH + lane]
                        d += weights[stage] * n_d
                        d2 += weights[stage] * n_d * n_d
                        e += weights[stage] * n_e
                        e2 += weights[stage] * n_e * n_e
                seen[SUM_D * WIDTH + lane], seen[(SUM_D + 1) * WIDTH + lane] = h[lane] * d, h[lane] * d2
                seen[(SUM_D + 2) * WIDTH + lane], seen[(SUM_D + 3) * WIDTH + lane] = h[lane] * e, h[lane] * e2
                seen[LATE_D * WIDTH + lane] = k[(first + 3 * stages - 3) * WIDTH + lane]
                seen[LATE_E * WIDTH + lane] = k[(first + 3 * stages - 2) * WIDTH + lane]
        if torque:
            for lane in range(WIDTH):
                work = weights[0] * seen[WORK * WIDTH + lane]
                for stage in range(1, stages):
                    if weights[stage] != 0.0:
                        work += weights[stage] * k[(first + 3 * stage + 2) * WIDTH + lane]
                seen[WORK * WIDTH + lane] = h[lane] * work

    return integrate
