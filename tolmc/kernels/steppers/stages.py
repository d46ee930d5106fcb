"""A step stage by stage, the equations compiled once: for those of any body, which are long, and for rk4."""

from __future__ import annotations

from types import ModuleType

from tolmc.kernels.jit import inlined, routine
from tolmc.kernels.lanes import WIDTH, Layout
from tolmc.kernels.steppers import Rows, Stepper, adder, closing, integrals, looker
from tolmc.kernels.tableaux import Tableau, weighted_sum


def build(tableau: Tableau, equations: ModuleType, load: bool, forces: bool, layout: Layout) -> Stepper:
    """Stepper by ``tableau`` for any equations."""
    state, stages, weights = equations.STATE, tableau.stages, tableau.b
    advance, torque, close = equations.advance, equations.TORQUE, closing(tableau, equations)
    size, rows, start = state * WIDTH, Rows.of(equations, tableau, layout), 1 if forces else 0
    argument_rows, k_rows, first = rows.argument, rows.k, rows.sums * WIDTH
    add, stage_argument = adder(equations, forces, begins=False, is_last=True), _arguments(tableau, size)
    look, integrate = looker(equations, load), integrals(tableau, equations, forces, rows)

    # On its own, for LLVM to see arrays and not parts of one: two written and three read, whose overlaps it checks.
    @routine
    def right_hand_sides(argument, coef, h, k, weight, sums):
        for lane in range(WIDTH):
            add(advance(argument, coef, h[lane], k, 0, lane, WIDTH, load), sums, 0, weight, lane)

    @routine
    def finish(y, end, coef, k, seen):
        close(y, end, coef, k, seen)

    @routine
    def sum_up(h, coef, k, seen):
        integrate(h, coef, k, seen)

    @routine
    def through_stages(y, end, coef, h, k, argument, seen):
        k[first:] = 0.0
        for stage in range(start, stages):
            stage_argument(stage, y, k, argument)
            here = k[stage * size : (stage + 1) * size]
            right_hand_sides(argument, coef, h, here, weights[stage], k[first:])
        finish(y, end, coef, k, seen)
        if forces or torque:
            sum_up(h, coef, k, seen)

    @inlined
    def step(y, end, coef, h, seen, work):
        k, argument = work[k_rows], work[argument_rows]
        if forces:
            look(y, coef, h, k, argument, seen)
        through_stages(y, end, coef, h, k, argument, seen)

    @inlined
    def see(y, coef, h, seen, work):
        look(y, coef, h, work[k_rows], work[argument_rows], seen)

    return Stepper(tableau, step, see)


def _arguments(tableau: Tableau, size: int):
    """Function of the argument of stage ``stage``, all lanes."""

    def up_to(number: int):
        here = _argument(tableau, number, size)
        if number == tableau.stages - 1:
            return here
        later = up_to(number + 1)

        @inlined
        def argument(stage, y, k, out):
            if stage == number:
                here(stage, y, k, out)
            else:
                later(stage, y, k, out)

        return argument

    return up_to(0)


def _argument(tableau: Tableau, number: int, size: int):
    at = weighted_sum(tableau.rows[number])

    @routine
    def argument(stage, y, k, out):
        for m in range(size):
            out[m] = at(y, k, size, m)

    return argument
