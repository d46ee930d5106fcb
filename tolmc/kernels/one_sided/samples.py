"""Samples and lanes: the next samples wait, prepared in packed loops; one goes into each lane that has finished its own.

Along the way one motion's record is written.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from tolmc.kernels import parameters as P
from tolmc.kernels.jit import routine
from tolmc.kernels.one_sided import layout as at
from tolmc.kernels.one_sided.clock import MOST_ROUNDS
from tolmc.kernels.one_sided.equations import Equations
from tolmc.kernels.one_sided.jump import TOGETHER, Jump
from tolmc.kernels.one_sided.layout import WIDTH


class Samples(NamedTuple):
    """Routines: ``fetch`` and ``begin`` of a block, the others of one lane; and how many rows the samples that wait take.

    Those are parameters, what is given, states at the start, coefficients, and the smaller gap.
    """

    rows: tuple[int, ...]
    fetch: object
    load: object
    begin: object
    state_of: object
    note: object


def build(equations: Equations, at_event: Jump) -> Samples:
    """The way into the lanes of one kind of scene."""
    jump, look_at, reach, momentum = at_event.jump, equations.look, equations.reach, equations.momentum
    prepare, start, orient, spins, rubs = (
        equations.prepare, equations.start, equations.orient, equations.spins, equations.rubs
    )  # fmt: skip
    carried, n_state, n_coef = at.RUBBING if rubs else at.FRICTIONLESS, equations.state, equations.coefficients
    # Without what swings no motion asks for more.
    raw_rows, given_rows = (P.COUNT, at.GIVEN) if equations.swings else (P.LOAD_ENERGY + 1, at.PHASE_1)

    @routine
    def glance(y, coef, f, seen, lane):
        look_at(y, coef, f, seen, lane, WIDTH)

    @routine
    def copy(source, rows, first, count, out):
        """Columns ``first`` on of so many rows."""
        for row in range(rows):
            for column in range(count):
                out[row * WIDTH + column] = source[row, first + column]

    @routine
    def prepare_all(raw, given, coef):
        for column in range(WIDTH):
            prepare(raw, given, coef, column, WIDTH)

    @routine
    def start_all(given, y, coef, gap):
        for column in range(WIDTH):
            start(given, y, coef, column, WIDTH)
        for column in range(WIDTH):
            orient(y, given, column, WIDTH)
        for column in range(WIDTH):
            _, _, gaps, _, _ = reach(y, 0.0, 0.0, 0.0, 0.0, coef, column, WIDTH)
            gap[column] = min(gaps[0], gaps[1])

    @routine
    def fetch(raw, given, n, first, waiting):
        """Samples ``first`` on of ``n``, as many as there are of a block, into the columns of those that wait."""
        raw_, given_, y, coef, gap = waiting
        count = min(WIDTH, n - first)
        copy(raw, raw_rows, first, count, raw_)
        copy(given, given_rows, first, count, given_)
        prepare_all(raw_, given_, coef)
        start_all(given_, y, coef, gap)

    @routine
    def load(waiting, column, i, y, coef, lanes, f0, seen0, lane):
        """Sample ``i``, which waits in ``column``, into a lane, and which contacts are closed there."""
        raw, given, start_y, start_coef, gap = waiting
        to, wait = y[lane:], start_y[column:]
        for row in range(n_state):
            to[row * WIDTH] = wait[row * WIDTH]
        own_coef, wait = coef[lane:], start_coef[column:]
        for row in range(n_coef):
            own_coef[row * WIDTH] = wait[row * WIDTH]
        own, laws = lanes[lane:], given[column:]
        for row in range(carried):
            own[row * WIDTH] = 0.0
        for row in (at.BEST_D_MAX, at.BEST_D_MIN, at.BEST_E_MAX, at.BEST_E_MIN, at.BEST_TILT):
            own[row * WIDTH] = -math.inf
        own[at.T * WIDTH], own[at.HINT * WIDTH] = laws[at.TIME * WIDTH], math.inf
        own[at.SAMPLE * WIDTH], own[at.BUSY * WIDTH] = i, 1.0
        own[at.ARMED_D * WIDTH], own[at.ARMED_E * WIDTH] = 1.0, 1.0
        own[at.HIT_AT * WIDTH] = math.nan
        own[at.ENERGY_SCALE * WIDTH] = raw[column:][P.LOAD_ENERGY * WIDTH] / own_coef[at.ENERGY * WIDTH]
        on_d, on_e, loss = laws[at.ON_D * WIDTH], laws[at.ON_E * WIDTH], laws[at.LOSS * WIDTH]
        own[at.LOST_AT * WIDTH] = math.nan if on_d > 0.0 and on_e > 0.0 else -1.0
        own_coef[at.CLOSED_D * WIDTH], own_coef[at.CLOSED_E * WIDTH] = on_d, on_e
        push = abs(own_coef[at.FX * WIDTH]) + abs(own_coef[at.FY * WIDTH])
        own[at.LOAD_REFERENCE * WIDTH] = 1e-3 * push
        kind = at.START if loss < 0.0 else (at.RELEASE_D if loss == 0.0 else at.RELEASE_E)
        if on_d > 0.0 or on_e > 0.0 or gap[column] <= TOGETHER:
            glance(y, coef, f0, seen0, lane)
            jump(y, coef, lanes, seen0, lane, kind)
        own[at.EVENTS * WIDTH] = 0.0

    @routine
    def begin(y, coef, lanes, seen0, decision):
        """Of the lanes that begin: the energy from which the balance starts, and the angular momentum about Z."""
        for lane in range(WIDTH):
            begins = decision[lane] == at.START
            spin = y[at.SPIN_RATE * WIDTH + lane] if spins else coef[at.OMEGA_FIXED * WIDTH + lane]
            about_z, _, _ = momentum(y, spin, coef, lane, WIDTH)
            before = lanes[at.MOMENTUM_0 * WIDTH + lane]
            lanes[at.MOMENTUM_0 * WIDTH + lane] = about_z if begins else before
            kinetic, before = seen0[at.KINETIC * WIDTH + lane], lanes[at.ENERGY_0 * WIDTH + lane]
            balance = kinetic + seen0[at.POTENTIAL * WIDTH + lane]
            balance += lanes[at.IMPACT_LOSS * WIDTH + lane] - lanes[at.WORK * WIDTH + lane]
            lanes[at.ENERGY_0 * WIDTH + lane] = balance if begins else before
            scale = lanes[at.ENERGY_SCALE * WIDTH + lane]
            lanes[at.ENERGY_SCALE * WIDTH + lane] = max(kinetic, scale) if begins else scale

    @routine
    def state_of(lanes, seen0, steps, most, accuracy, lane):
        """OK, or why the lane cannot go on."""
        if lanes[at.STATUS * WIDTH + lane] != 0.0:
            return int(lanes[at.STATUS * WIDTH + lane])
        energy = seen0[at.KINETIC * WIDTH + lane] + seen0[at.POTENTIAL * WIDTH + lane]
        if not abs(energy) < math.inf or not lanes[at.ENERGY_ERROR * WIDTH + lane] < math.inf:
            return at.DIVERGED
        if rubs and seen0[at.MARGIN * WIDTH + lane] <= 0.0:
            return at.NO_SOLUTION
        if not lanes[at.PENETRATION * WIDTH + lane] <= accuracy:
            return at.PENETRATES
        if lanes[at.EVENTS * WIDTH + lane] > most:
            return at.TOO_MANY
        if lanes[at.ROUNDS * WIDTH + lane] > MOST_ROUNDS * (steps + lanes[at.EVENTS * WIDTH + lane]):
            return at.UNRESOLVED
        return at.OK

    @routine
    def note(record, events, counts, y, coef, lanes, seen0, event):
        """A row of the record from lane 0, and an event; what does not fit is counted all the same."""
        row = counts[1]
        if row < record.shape[1]:
            c, kappa, joule = coef[at.C * WIDTH], coef[at.KAPPA * WIDTH], coef[at.ENERGY * WIDTH]
            record[at.T_TIME, row] = lanes[at.T * WIDTH]
            record[at.T_X, row], record[at.T_Y, row] = c * y[at.O_X * WIDTH], c * y[at.O_Y * WIDTH]
            record[at.T_U, row], record[at.T_V, row] = kappa * y[at.W_X * WIDTH], kappa * y[at.W_Y * WIDTH]
            record[at.T_D, row] = coef[at.FORCE * WIDTH] * seen0[at.N_D * WIDTH]
            record[at.T_E, row] = coef[at.FORCE * WIDTH] * seen0[at.N_E * WIDTH]
            record[at.T_CLOSED_D, row], record[at.T_CLOSED_E, row] = (
                coef[at.CLOSED_D * WIDTH],
                coef[at.CLOSED_E * WIDTH],
            )
            record[at.T_KINETIC, row] = joule * seen0[at.KINETIC * WIDTH]
            record[at.T_POTENTIAL, row] = joule * seen0[at.POTENTIAL * WIDTH]
            record[at.T_WORK, row], record[at.T_LOSS, row] = (
                joule * lanes[at.WORK * WIDTH],
                joule * lanes[at.IMPACT_LOSS * WIDTH],
            )
            if spins:
                record[at.T_OMEGA, row] = y[at.SPIN_RATE * WIDTH]
            else:
                record[at.T_OMEGA, row] = coef[at.OMEGA_FIXED * WIDTH]
        counts[1] += 1
        if event:
            if counts[2] < events.shape[1]:
                for entry in range(at.EVENT):
                    events[entry, counts[2]] = lanes[(at.LAST_EVENT + entry) * WIDTH]
            counts[2] += 1

    return Samples((raw_rows, given_rows, n_state, n_coef, 1), fetch, load, begin, state_of, note)
