"""Steps of a whole block of lanes, from one array of states to another.

A stepper is made for one set of equations. Its function ``step(y, end, coef, h, seen, work)`` takes one step of ``h[lane]``
from ``y`` to ``end``, projected; ``go`` does the same for its end alone; ``see(y, coef, h, seen, work)`` looks at ``y`` alone.
What they see goes to ``seen``, as :mod:`tolmc.kernels.seen` has it: of a motion whose forces nobody asks for only the
constraint error and the torque's work. The forces' rates of change, of a step of ``h[lane]``, only a look sees: they cost as
much as one more stage.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from types import ModuleType

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
    SUM_D2,
    SUM_E,
    SUM_E2,
    SUM_S,
    SUM_SIZE,
    SUM_TORQUE,
    TORQUE,
    W2,
    WORK,
)
from tolmc.kernels.sums import weighted_sum
from tolmc.kernels.tableaux import Tableau

#: What is summed up over the stages: rows of ``seen`` from SUM_D on, with friction also those from SLIP_D on.
SUMS, RUBBING = LATE_E - SUM_D + 1, SUM_S - SLIP_D + 1
#: Share of a step over which rates are taken: their error is 1e-5 of a quantity's change, of rounding 1e-11 of the terms
#: that make it. Where a large spin makes forces the small difference of large terms, 2^-20 left 1e-6 of an extremum.
NUDGE = 2.0**-17


@dataclass(frozen=True)
class Stepper:
    """A step, the same without sums, and a look."""

    tableau: Tableau
    step: Callable
    go: Callable
    see: Callable


@dataclass(frozen=True)
class Rows:
    """Where a step works: the argument of a stage; the stages' increments h y', and after them what is summed up over them.

    Sums, and not what each stage has seen: all that a step works with so stays in the first-level cache.
    """

    argument: slice
    k: slice
    #: Row of the first sum in the array of the increments.
    sums: int

    @classmethod
    def of(cls, equations: ModuleType, tableau: Tableau, layout: Layout) -> Rows:
        """Rows of one stepper."""
        increments = tableau.stages * equations.STATE
        argument = layout.block(equations.STATE + equations.HELD)
        return cls(argument, layout.block(increments + SUMS + (RUBBING if equations.RUBS else 0)), increments)


def adder(equations: ModuleType, forces: bool) -> Callable:
    """Function ``add(found, sums, weight, lane)``: what a right-hand side has found of one lane, to the sums over the stages.

    Of the last stage the forces themselves stay in place.
    """
    torque, rubs = equations.TORQUE, equations.RUBS

    @device
    def add_forces(n_d, n_e, sums, weight, lane):
        d, e = weight * n_d, weight * n_e
        sums[lane] += d
        sums[WIDTH + lane] += d * n_d
        sums[2 * WIDTH + lane] += e
        sums[3 * WIDTH + lane] += e * n_e
        sums[(LATE_D - SUM_D) * WIDTH + lane], sums[(LATE_E - SUM_D) * WIDTH + lane] = n_d, n_e

    if rubs:

        @device
        def add(found, sums, weight, lane):
            n_d, n_e, slip_d, slip_e, heat, moment, s = found
            add_forces(n_d, n_e, sums, weight, lane)
            first, turned = SUMS * WIDTH + lane, weight * moment
            sums[first] += weight * slip_d
            sums[first + WIDTH] += weight * slip_e
            sums[first + 2 * WIDTH] += weight * heat
            sums[first + 3 * WIDTH] += turned
            sums[first + 4 * WIDTH] += turned if moment > 0.0 else -turned
            sums[first + 5 * WIDTH] += weight * s

    else:

        @device
        def add(found, sums, weight, lane):
            n_d, n_e, _, _, _, power = found
            if forces:
                add_forces(n_d, n_e, sums, weight, lane)
            if torque:
                sums[(WORK - SUM_D) * WIDTH + lane] += weight * power

    return add


def loops(parts: Sequence[Callable | None], load: bool) -> Callable:
    """Function ``run(y, held, coef)``: parts of a right-hand side, each that there is in a loop over the lanes of its own.

    A processor looks some hundred operations ahead. In a longer loop it does not see from one group of lanes to the next, and
    waits wherever a root or a division stands in the way; so parts end with these, and the next begins with what is known.
    """
    if not parts:

        @inlined
        def nothing(y, held, coef):
            pass

        return nothing
    part, others = parts[0], loops(parts[1:], load)
    if part is None:
        return others

    @inlined
    def run(y, held, coef):
        for lane in range(WIDTH):
            part(y, held, coef, lane, WIDTH, load)
        others(y, held, coef)

    return run


def looker(equations: ModuleType, load: bool) -> Callable:
    """Function ``look(y, coef, h, k, argument, seen)``: the first stage, and what is seen at ``y``; of rates |w|^2's alone."""
    if equations.RUBS:
        return _rubbing_looker(equations, load)
    prepare, finish = loops(equations.PARTS[:-1], load), equations.PARTS[-1]
    torque, rate_of_w2 = equations.TORQUE, equations.rate_of_w2

    # Loops by themselves: with more arrays in one, LLVM's alias checks exceed their limit and the loop is scalar.
    @routine
    def look(y, coef, h, k, argument, seen):
        prepare(y, argument, coef)
        for lane in range(WIDTH):
            n_d, n_e, w2, kinetic, potential, power = finish(y, argument, coef, h[lane], k, 0, lane, WIDTH, load)
            seen[N_D * WIDTH + lane], seen[N_E * WIDTH + lane], seen[W2 * WIDTH + lane] = n_d, n_e, w2
            seen[KINETIC * WIDTH + lane], seen[ENERGY * WIDTH + lane] = kinetic, kinetic + potential
            if torque:
                seen[WORK * WIDTH + lane] = power
        for lane in range(WIDTH):
            seen[RATE_W2 * WIDTH + lane] = rate_of_w2(y, k, coef, lane, WIDTH)

    return look


def rater(equations: ModuleType, load: bool) -> Callable:
    """Function ``rate(y, k, coef, argument, seen)``: the rates of the forces, with friction of its moment, after a look.

    Those along the motion, by a look a little way along the first stage: no formulation needs equations for them.
    """
    state, prepare, sense = equations.STATE, loops(equations.PARTS[:-1], load), equations.sense
    rubs = equations.RUBS

    @routine
    def rate(y, k, coef, argument, seen):
        for m in range(state * WIDTH):
            argument[m] = y[m] + NUDGE * k[m]
        prepare(argument, argument, coef)
        for lane in range(WIDTH):
            found = sense(argument, argument, coef, lane, WIDTH, load)
            seen[RATE_D * WIDTH + lane] = (found[0] - seen[N_D * WIDTH + lane]) / NUDGE
            seen[RATE_E * WIDTH + lane] = (found[1] - seen[N_E * WIDTH + lane]) / NUDGE
            if rubs:
                seen[RATE_TORQUE * WIDTH + lane] = (found[2] - seen[TORQUE * WIDTH + lane]) / NUDGE

    return rate


def _rubbing_looker(equations: ModuleType, load: bool) -> Callable:
    """The same with what rubs: its powers stand at first where their integrals over the step will."""
    begin, go_on, finish = equations.PARTS
    at_end, units, rate_of_w2 = equations.at_end, equations.units, equations.rate_of_w2

    @routine
    def look(y, coef, h, k, argument, seen):
        for lane in range(WIDTH):
            begin(y, argument, coef, lane, WIDTH, load)
        for lane in range(WIDTH):
            besides = go_on(y, argument, coef, lane, WIDTH, load)
            w2, kinetic, potential, slow, margin = at_end(argument, besides, y, coef, lane, WIDTH)
            seen[W2 * WIDTH + lane], seen[KINETIC * WIDTH + lane] = w2, kinetic
            seen[ENERGY * WIDTH + lane] = kinetic + potential
            seen[SLOW * WIDTH + lane], seen[MARGIN * WIDTH + lane] = slow, margin
        for lane in range(WIDTH):
            watt, slip, turn, _ = units(coef, lane, WIDTH)
            n_d, n_e, slip_d, slip_e, heat, moment, s = finish(y, argument, coef, h[lane], k, 0, lane, WIDTH, load)
            seen[N_D * WIDTH + lane], seen[N_E * WIDTH + lane] = n_d, n_e
            seen[SLIP_D * WIDTH + lane], seen[SLIP_E * WIDTH + lane] = slip * slip_d, slip * slip_e
            seen[HEAT * WIDTH + lane], seen[TORQUE * WIDTH + lane] = watt * heat, turn * moment
            seen[SUM_S * WIDTH + lane] = s
        for lane in range(WIDTH):
            seen[RATE_W2 * WIDTH + lane] = rate_of_w2(y, k, coef, lane, WIDTH)

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


def integrals(tableau: Tableau, equations: ModuleType, forces: bool, rows: Rows) -> Callable:
    """Function ``integrate(h, coef, k, seen)``: integrals over the step by the method's own weights, of its order.

    The sums over the stages stand in k; of the first stage, with forces, what was seen stands in ``seen``.
    """
    if equations.RUBS:
        return _rubbing_integrals(tableau, equations, rows)
    begun, torque, first = tableau.b[0], equations.TORQUE, rows.sums * WIDTH
    add_up = _force_integrals(tableau, rows)

    @inlined
    def integrate(h, coef, k, seen):
        if forces:
            add_up(h, k, seen)
        if torque:
            for lane in range(WIDTH):
                work = k[first + (WORK - SUM_D) * WIDTH + lane]
                if forces:
                    work += begun * seen[WORK * WIDTH + lane]
                seen[WORK * WIDTH + lane] = h[lane] * work

    return integrate


def _force_integrals(tableau: Tableau, rows: Rows) -> Callable:
    begun, first = tableau.b[0], rows.sums * WIDTH

    @inlined
    def add_up(h, k, seen):
        for lane in range(WIDTH):
            n_d, n_e, at = seen[N_D * WIDTH + lane], seen[N_E * WIDTH + lane], first + lane
            d, e = begun * n_d, begun * n_e
            seen[SUM_D * WIDTH + lane] = h[lane] * (d + k[at])
            seen[SUM_D2 * WIDTH + lane] = h[lane] * (d * n_d + k[at + WIDTH])
            seen[SUM_E * WIDTH + lane] = h[lane] * (e + k[at + 2 * WIDTH])
            seen[SUM_E2 * WIDTH + lane] = h[lane] * (e * n_e + k[at + 3 * WIDTH])
            seen[LATE_D * WIDTH + lane] = k[at + (LATE_D - SUM_D) * WIDTH]
            seen[LATE_E * WIDTH + lane] = k[at + (LATE_E - SUM_D) * WIDTH]

    return add_up


def _rubbing_integrals(tableau: Tableau, equations: ModuleType, rows: Rows) -> Callable:
    """The same with N |v| at both ends, the heat, the moment and its size, and s.

    What friction and drive do together: the heat, with the other sign, and where the spin is held the moment times that.
    """
    begun, units, first = tableau.b[0], equations.units, (rows.sums + SUMS) * WIDTH
    add_up = _force_integrals(tableau, rows)

    @inlined
    def integrate(h, coef, k, seen):
        add_up(h, k, seen)
        for lane in range(WIDTH):
            watt, slip, turn, held = units(coef, lane, WIDTH)
            heat, moment, at = seen[HEAT * WIDTH + lane], seen[TORQUE * WIDTH + lane], first + lane
            heat = h[lane] * (begun * heat + watt * k[at + 2 * WIDTH])
            turned = h[lane] * (begun * moment + turn * k[at + 3 * WIDTH])
            seen[SLIP_D * WIDTH + lane] = h[lane] * (begun * seen[SLIP_D * WIDTH + lane] + slip * k[at])
            seen[SLIP_E * WIDTH + lane] = h[lane] * (begun * seen[SLIP_E * WIDTH + lane] + slip * k[at + WIDTH])
            seen[HEAT * WIDTH + lane], seen[SUM_TORQUE * WIDTH + lane] = heat, turned
            seen[WORK * WIDTH + lane] = held * turned - heat
            seen[SUM_SIZE * WIDTH + lane] = h[lane] * (begun * abs(moment) + turn * k[at + 4 * WIDTH])
            seen[SUM_S * WIDTH + lane] = h[lane] * (begun * seen[SUM_S * WIDTH + lane] + k[at + 5 * WIDTH])

    return integrate
