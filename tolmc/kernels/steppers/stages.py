"""A step stage by stage: a stage's argument, a sum over those before, is compiled for each, the right-hand side once.

With the sums goes the first part of a right-hand side, if it is short: they wait for memory, it for arithmetic, and so they
overlap. All in one loop would be too long for a processor to see the next lanes: a step of a motion alone would take a sixth
more.
"""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType

from tolmc.kernels.jit import chain, device, inlined, no, routine, yes
from tolmc.kernels.lanes import WIDTH, Layout
from tolmc.kernels.steppers import Rows, Stepper, adder, closing, integrals, looker, loops, rater
from tolmc.kernels.sums import weighted_sum
from tolmc.kernels.tableaux import Tableau


def build(tableau: Tableau, equations: ModuleType, load: bool, forces: bool, layout: Layout) -> Stepper:
    """Stepper by ``tableau``."""
    rows, close = Rows.of(equations, tableau, layout), closing(tableau, equations)
    argument_rows, k_rows, sums = rows.argument, rows.k, rows.sums * WIDTH
    look, rate, integrate = looker(equations, load), rater(equations, load), integrals(tableau, equations, forces, rows)
    is_summed, sum_rows = forces or equations.TORQUE, slice(sums, k_rows.stop - k_rows.start)
    stages = chain(_all_stages(tableau, equations, load, forces, sums), _pair)

    @routine
    def through_stages(y, end, coef, h, k, argument, seen, sums_up):
        if is_summed:
            k[sum_rows] = 0.0
        stages(y, k, argument, coef, h, sums_up)
        close(y, end, coef, k, seen)

    @routine
    def finish(h, coef, k, seen):
        integrate(h, coef, k, seen)

    @device
    def step(y, end, coef, h, seen, work):
        k, argument = work[k_rows], work[argument_rows]
        if forces:
            look(y, coef, h, k, argument, seen)
        through_stages(y, end, coef, h, k, argument, seen, yes())
        if is_summed:
            finish(h, coef, k, seen)

    @device
    def go(y, end, coef, h, seen, work):
        k, argument = work[k_rows], work[argument_rows]
        if forces:
            look(y, coef, h, k, argument, seen)
        through_stages(y, end, coef, h, k, argument, seen, no())

    @device
    def see(y, coef, h, seen, work):
        k, argument = work[k_rows], work[argument_rows]
        look(y, coef, h, k, argument, seen)
        rate(y, k, coef, argument, seen)

    return Stepper(tableau, step, go, see)


def _all_stages(tableau: Tableau, equations: ModuleType, load: bool, forces: bool, sums: int) -> list[Callable]:
    """The stages but the first, which with forces is a look."""
    add = adder(equations, forces)
    alone = _rest(equations, load, None)
    watched = _rest(equations, load, add)
    if forces:
        watched = _either(watched, alone)

    def stage(number: int) -> Callable:
        row, first = tableau.rows[number], number * equations.STATE * WIDTH
        is_watched = (forces or equations.TORQUE) and number in tableau.weights
        return _stage(
            equations, load, row, first, watched if is_watched else alone, tableau.weights.get(number, 0.0), sums
        )

    return [stage(number) for number in range(1 if forces else 0, tableau.stages)]


@device
def _nothing(y, held, coef, lane, width, with_load):
    """No part goes with the sums."""


def _stage(
    equations: ModuleType, load: bool, row: dict[int, float], first: int, rest: Callable, weight: float, sums: int
) -> Callable:
    """A stage in as many loops as its right-hand side has parts."""
    state, begin, argument_at = equations.STATE, equations.PARTS[0] or _nothing, weighted_sum(row)
    size = state * WIDTH

    @device
    def stage(y, k, argument, coef, h, sums_up):
        for lane in range(WIDTH):
            for c in range(state):
                argument[c * WIDTH + lane] = argument_at(y, k, size, c * WIDTH + lane)
            begin(argument, argument, coef, lane, WIDTH, load)
        rest(argument, coef, h, k[first : first + size], weight, k[sums:], sums_up)

    return stage


def _rest(equations: ModuleType, load: bool, add: Callable | None) -> Callable:
    """Function of a stage's parts but the first, and what they add to the sums."""
    _, *between, last = equations.PARTS
    go_on, is_watched = loops(between, load), add is not None

    # On its own, for LLVM to see arrays and not parts of one: two written and three read, whose overlaps it checks.
    @routine
    def rest(argument, coef, h, k, weight, sums, sums_up):
        go_on(argument, argument, coef)
        for lane in range(WIDTH):
            found = last(argument, argument, coef, h[lane], k, 0, lane, WIDTH, load)
            if is_watched:
                add(found, sums, weight, lane)

    return rest


def _either(watched: Callable, alone: Callable) -> Callable:
    """Function that sums up, or not, as is said at run time."""

    @device
    def either(argument, coef, h, k, weight, sums, sums_up):
        if sums_up:
            watched(argument, coef, h, k, weight, sums, sums_up)
        else:
            alone(argument, coef, h, k, weight, sums, sums_up)

    return either


def _pair(first: Callable, second: Callable) -> Callable:
    @inlined
    def both(y, k, argument, coef, h, sums_up):
        first(y, k, argument, coef, h, sums_up)
        second(y, k, argument, coef, h, sums_up)

    return both
