"""Steps of a whole block of lanes, from one array of states to another.

A stepper is made for one set of equations. Its function ``step(y, end, coef, h, seen, work)`` takes one step of ``h[lane]``
from ``y`` to ``end``, projected; ``see(y, coef, h, seen, work)`` looks at ``y`` alone. What both see goes to ``seen``, as
:mod:`tolmc.kernels.seen` has it: of a motion whose forces nobody asks for only the constraint error and the torque's work.
"""

from __future__ import annotations

from collections.abc import Callable
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
from tolmc.kernels.tableaux import Tableau, weighted_sum

#: What is summed up over the stages: rows of ``seen`` from SUM_D on, with friction also those from SLIP_D on.
SUMS, RUBBING = LATE_E - SUM_D + 1, SUM_S - SLIP_D + 1
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
        argument = layout.block(equations.STATE)
        return cls(argument, layout.block(increments + SUMS + (RUBBING if equations.RUBS else 0)), increments)


def adder(equations: ModuleType, forces: bool, *, begins: bool, is_last: bool) -> Callable:
    """Function ``add(found, k, row, weight, lane)``: what a right-hand side has found of one lane, to the sums from ``row`` on.

    ``begins``: there is nothing yet to add to; ``is_last``: the forces are those of the last stage.
    """
    torque, rubs = equations.TORQUE, equations.RUBS

    @device
    def put(k, at, value):
        k[at] = value if begins else k[at] + value

    @device
    def add_forces(n_d, n_e, k, row, weight, lane):
        d, e = weight * n_d, weight * n_e
        put(k, row + lane, d)
        put(k, row + WIDTH + lane, d * n_d)
        put(k, row + 2 * WIDTH + lane, e)
        put(k, row + 3 * WIDTH + lane, e * n_e)
        if is_last:
            k[row + (LATE_D - SUM_D) * WIDTH + lane], k[row + (LATE_E - SUM_D) * WIDTH + lane] = n_d, n_e

    if rubs:

        @device
        def add(found, k, row, weight, lane):
            n_d, n_e, _, _, _, slip_d, slip_e, heat, moment, s, _, _ = found
            add_forces(n_d, n_e, k, row, weight, lane)
            first, turned = row + SUMS * WIDTH + lane, weight * moment
            put(k, first, weight * slip_d)
            put(k, first + WIDTH, weight * slip_e)
            put(k, first + 2 * WIDTH, weight * heat)
            put(k, first + 3 * WIDTH, turned)
            put(k, first + 4 * WIDTH, turned if moment > 0.0 else -turned)
            put(k, first + 5 * WIDTH, weight * s)

    else:

        @device
        def add(found, k, row, weight, lane):
            n_d, n_e, _, _, _, power = found
            if forces:
                add_forces(n_d, n_e, k, row, weight, lane)
            if torque:
                put(k, row + (WORK - SUM_D) * WIDTH + lane, weight * power)

    return add


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
    state, advance, sense, units = equations.STATE, equations.advance, equations.sense, equations.units

    @routine
    def look(y, coef, h, k, argument, seen):
        for lane in range(WIDTH):
            watt, slip, turn, _ = units(coef, lane, WIDTH)
            n_d, n_e, w2, kinetic, potential, slip_d, slip_e, heat, moment, s, slow, margin = advance(
                y, coef, h[lane], k, 0, lane, WIDTH, load
            )
            seen[N_D * WIDTH + lane], seen[N_E * WIDTH + lane], seen[W2 * WIDTH + lane] = n_d, n_e, w2
            seen[KINETIC * WIDTH + lane], seen[ENERGY * WIDTH + lane] = kinetic, kinetic + potential
            seen[SLIP_D * WIDTH + lane], seen[SLIP_E * WIDTH + lane] = slip * slip_d, slip * slip_e
            seen[HEAT * WIDTH + lane], seen[TORQUE * WIDTH + lane] = watt * heat, turn * moment
            seen[SUM_S * WIDTH + lane] = s
            seen[SLOW * WIDTH + lane], seen[MARGIN * WIDTH + lane] = slow, margin
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
