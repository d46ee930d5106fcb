"""A step whose stages have their argument and right-hand side in one loop over the lanes.

Sums wait for memory, right-hand sides for arithmetic; in one loop they overlap, and a step takes a tenth less. For equations
short enough to be compiled once a stage: those of a symmetric body.
"""

from __future__ import annotations

from types import ModuleType

from tolmc.kernels.jit import device, inlined, routine
from tolmc.kernels.lanes import WIDTH, Layout
from tolmc.kernels.steppers import Rows, Stepper, adder, closing, integrals, looker
from tolmc.kernels.tableaux import Tableau, weighted_sum


def build(tableau: Tableau, equations: ModuleType, load: bool, forces: bool, layout: Layout) -> Stepper:
    """Stepper by ``tableau`` for short equations."""
    rows, close = Rows.of(equations, tableau, layout), closing(tableau, equations)
    argument_rows, k_rows = rows.argument, rows.k
    look, integrate = looker(equations, load), integrals(tableau, equations, forces, rows)
    stages = _in_order([_stage(tableau, equations, load, forces, number, rows)
                        for number in range(1 if forces else 0, tableau.stages)])  # fmt: skip

    @routine
    def through_stages(y, end, coef, h, k, argument, seen):
        stages(y, k, argument, coef, h)
        close(y, end, coef, k, seen)

    @routine
    def finish(h, coef, k, seen):
        integrate(h, coef, k, seen)

    @inlined
    def step(y, end, coef, h, seen, work):
        k, argument = work[k_rows], work[argument_rows]
        if forces:
            look(y, coef, h, k, argument, seen)
        through_stages(y, end, coef, h, k, argument, seen)
        if forces:
            finish(h, coef, k, seen)

    @inlined
    def see(y, coef, h, seen, work):
        look(y, coef, h, work[k_rows], work[argument_rows], seen)

    return Stepper(tableau, step, see)


def _stage(tableau: Tableau, equations: ModuleType, load: bool, forces: bool, number: int, rows: Rows):
    """One stage: its argument's sum over the stages before, its right-hand side, and the forces where they have a weight."""
    state, advance, argument_at = equations.STATE, equations.advance, weighted_sum(tableau.rows[number])
    size, sums, weight = state * WIDTH, rows.sums * WIDTH, tableau.weights.get(number, 0.0)
    watched = [stage for stage in sorted(tableau.weights) if stage > 0] if forces else []
    is_watched, begins, is_last = number in watched, number == min(watched, default=0), number == tableau.stages - 1
    add = adder(equations, forces, begins=begins, is_last=is_last)

    @device
    def stage(y, k, argument, coef, h):
        for lane in range(WIDTH):
            for c in range(state):
                argument[c * WIDTH + lane] = argument_at(y, k, size, c * WIDTH + lane)
            found = advance(argument, coef, h[lane], k, number * size, lane, WIDTH, load)
            if is_watched:
                add(found, k, sums, weight, lane)

    return stage


def _in_order(stages):
    """One function that calls all stages."""
    first, *others = stages
    if not others:
        return first
    rest = _in_order(others)

    @inlined
    def in_order(y, k, argument, coef, h):
        first(y, k, argument, coef, h)
        rest(y, k, argument, coef, h)

    return in_order
