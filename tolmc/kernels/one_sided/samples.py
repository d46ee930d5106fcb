"""Samples and lanes: a sample goes into a lane, its results come out, and one motion's record is written along the way."""

from __future__ import annotations

import math
from typing import NamedTuple

from tolmc.kernels import parameters as P
from tolmc.kernels.jit import device, routine
from tolmc.kernels.one_sided import layout as at
from tolmc.kernels.one_sided.clock import MOST_ROUNDS
from tolmc.kernels.one_sided.equations import Equations
from tolmc.kernels.one_sided.jump import TOGETHER, Jump
from tolmc.kernels.one_sided.layout import WIDTH


class Samples(NamedTuple):
    """Routines of one lane."""

    load: object
    begin: object
    state_of: object
    store: object
    note: object


def build(equations: Equations, at_event: Jump) -> Samples:
    """The way in and out of one kind of scene."""
    jump, look_at, touch = at_event.jump, equations.look, equations.touch
    prepare, start, spins, rubs = equations.prepare, equations.start, equations.spins, equations.rubs
    momentum, carried = equations.momentum, at.RUBBING if equations.rubs else at.FRICTIONLESS

    @routine
    def momentum_of(y, coef, lane):
        spin = y[at.SPIN_RATE * WIDTH + lane] if spins else coef[at.OMEGA_FIXED * WIDTH + lane]
        return momentum(y, spin, coef, lane, WIDTH)

    @routine
    def glance(y, coef, f, seen, lane):
        look_at(y, coef, f, seen, lane, WIDTH)

    @routine
    def least_gap(y, coef, lane):
        """Of the two."""
        ox, oy, wx, wy = (
            y[at.O_X * WIDTH + lane],
            y[at.O_Y * WIDTH + lane],
            y[at.W_X * WIDTH + lane],
            y[at.W_Y * WIDTH + lane],
        )
        sx, sy = coef[at.KAPPA * WIDTH + lane] * wx, coef[at.KAPPA * WIDTH + lane] * wy
        _, _, _, _, gap_d, _ = touch(ox + wx, oy + wy, 0.0, 0.0, sx, sy, 0.0, 0.0, coef, lane, WIDTH)
        _, _, _, _, gap_e, _ = touch(ox - wx, oy - wy, 0.0, 0.0, -sx, -sy, 0.0, 0.0, coef, lane, WIDTH)
        return min(gap_d, gap_e)

    @routine
    def load(raw, given, i, y, coef, lanes, f0, seen0, lane):
        """Sample ``i`` into a lane: its start, and which contacts are closed there."""
        prepare(raw, given, i, coef, lane, WIDTH)
        start(given, i, y, coef, lane, WIDTH)
        for row in range(carried):
            lanes[row * WIDTH + lane] = 0.0
        for row in (at.BEST_D_MAX, at.BEST_D_MIN, at.BEST_E_MAX, at.BEST_E_MIN, at.BEST_TILT):
            lanes[row * WIDTH + lane] = -math.inf
        lanes[at.T * WIDTH + lane], lanes[at.HINT * WIDTH + lane] = given[at.TIME, i], math.inf
        lanes[at.SAMPLE * WIDTH + lane], lanes[at.BUSY * WIDTH + lane] = i, 1.0
        lanes[at.ARMED_D * WIDTH + lane], lanes[at.ARMED_E * WIDTH + lane] = 1.0, 1.0
        lanes[at.HIT_AT * WIDTH + lane] = math.nan
        on_d, on_e, loss = given[at.ON_D, i], given[at.ON_E, i], given[at.LOSS, i]
        lanes[at.LOST_AT * WIDTH + lane] = math.nan if on_d > 0.0 and on_e > 0.0 else -1.0
        coef[at.CLOSED_D * WIDTH + lane], coef[at.CLOSED_E * WIDTH + lane] = on_d, on_e
        push = abs(coef[at.FX * WIDTH + lane]) + abs(coef[at.FY * WIDTH + lane])
        lanes[at.LOAD_REFERENCE * WIDTH + lane] = 1e-3 * push
        kind = at.START if loss < 0.0 else (at.RELEASE_D if loss == 0.0 else at.RELEASE_E)
        if on_d > 0.0 or on_e > 0.0 or least_gap(y, coef, lane) <= TOGETHER:
            glance(y, coef, f0, seen0, lane)
            jump(y, coef, lanes, seen0, lane, kind)
        lanes[at.EVENTS * WIDTH + lane] = 0.0

    @routine
    def begin(raw, y, coef, lanes, seen0, lane):
        """The energy from which a lane's balance starts, and its angular momentum about Z."""
        lanes[at.MOMENTUM_0 * WIDTH + lane], _, _ = momentum_of(y, coef, lane)
        kinetic = seen0[at.KINETIC * WIDTH + lane]
        balance = kinetic + seen0[at.POTENTIAL * WIDTH + lane]
        balance += lanes[at.IMPACT_LOSS * WIDTH + lane] - lanes[at.WORK * WIDTH + lane]
        lanes[at.ENERGY_0 * WIDTH + lane] = balance
        loads = raw[P.LOAD_ENERGY, int(lanes[at.SAMPLE * WIDTH + lane])] / coef[at.ENERGY * WIDTH + lane]
        lanes[at.ENERGY_SCALE * WIDTH + lane] = max(kinetic, loads)

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

    @device
    def store_friction(lanes, out, joule, slip, i, lane):
        out[at.R_SLIP_D, i] = slip * lanes[at.WORK_SLIP_D * WIDTH + lane]
        out[at.R_SLIP_E, i] = slip * lanes[at.WORK_SLIP_E * WIDTH + lane]
        out[at.R_HEAT, i] = joule * lanes[at.WORK_HEAT * WIDTH + lane]
        out[at.R_TORQUE, i] = joule * lanes[at.TORQUE_INTEGRAL * WIDTH + lane]
        out[at.R_TORQUE_MAX, i] = joule * lanes[at.TORQUE_MAX * WIDTH + lane]
        out[at.R_SLOW, i], out[at.R_TURN, i] = lanes[at.TIME_SLOW * WIDTH + lane], lanes[at.TURN * WIDTH + lane]
        out[at.R_DRIVE, i] = joule * lanes[at.DRIVE_INTEGRAL * WIDTH + lane]
        out[at.R_DRIVE_WORK, i] = joule * lanes[at.DRIVE_WORK * WIDTH + lane]
        out[at.R_DRIVE_MAX, i] = joule * lanes[at.DRIVE_MAX * WIDTH + lane]

    @routine
    def store(y, coef, lanes, seen0, out, lane, status):
        """Results of a lane's sample."""
        i = int(lanes[at.SAMPLE * WIDTH + lane])
        newton, joule, c = coef[at.FORCE * WIDTH + lane], coef[at.ENERGY * WIDTH + lane], coef[at.C * WIDTH + lane]
        out[at.R_STATUS, i], out[at.R_END, i] = status, lanes[at.T * WIDTH + lane]
        out[at.R_ROUNDS, i], out[at.R_EVENTS, i] = lanes[at.ROUNDS * WIDTH + lane], lanes[at.EVENTS * WIDTH + lane]
        for side in range(2):
            high, low = (at.BEST_D_MAX, at.BEST_D_MIN) if side == 0 else (at.BEST_E_MAX, at.BEST_E_MIN)
            touched = lanes[(at.TIME_D + side) * WIDTH + lane] > 0.0
            out[at.R_D_MAX + 2 * side, i] = newton * lanes[high * WIDTH + lane] if touched else math.nan
            # No force of a closed contact is negative: what is left below zero is the root's rounding.
            out[at.R_D_MIN + 2 * side, i] = newton * max(-lanes[low * WIDTH + lane], 0.0) if touched else math.nan
            impulses = lanes[(at.TOTAL_D + side) * WIDTH + lane]
            out[at.R_INTEGRAL_D + side, i] = newton * (lanes[(at.INTEGRAL_D + side) * WIDTH + lane] + impulses)
            out[at.R_SQUARE_D + side, i] = newton * newton * lanes[(at.SQUARE_D + side) * WIDTH + lane]
            out[at.R_TIME_D + side, i] = lanes[(at.TIME_D + side) * WIDTH + lane]
            out[at.R_COUNT_D + side, i] = lanes[(at.COUNT_D + side) * WIDTH + lane]
            out[at.R_SPEED_D + side, i] = c * lanes[(at.SPEED_D + side) * WIDTH + lane]
            out[at.R_IMPULSE_D + side, i] = newton * lanes[(at.IMPULSE_D + side) * WIDTH + lane]
            out[at.R_TOTAL_D + side, i] = newton * lanes[(at.TOTAL_D + side) * WIDTH + lane]
            # The peak of Hertz' force, K (5 m gamma^2/(4 K))^0.6.
            energy, stiff = lanes[(at.PEAK_D + side) * WIDTH + lane], coef[at.HERTZ * WIDTH + lane]
            out[at.R_PEAK_D + side, i] = stiff * (1.25 * energy / stiff) ** 0.6 if stiff > 0.0 else 0.0
            out[at.R_CLOSED_D + side, i] = coef[(at.CLOSED_D + side) * WIDTH + lane]
        out[at.R_TIME_FREE, i] = lanes[at.TIME_FREE * WIDTH + lane]
        lost = lanes[at.LOST_AT * WIDTH + lane]
        out[at.R_LOST_AT, i], out[at.R_HIT_AT, i] = lost if lost >= 0.0 else math.nan, lanes[at.HIT_AT * WIDTH + lane]
        out[at.R_IMPACT_LOSS, i] = joule * lanes[at.IMPACT_LOSS * WIDTH + lane]
        error = lanes[at.ENERGY_ERROR * WIDTH + lane]
        out[at.R_ENERGY_ERROR, i] = error / lanes[at.ENERGY_SCALE * WIDTH + lane] if error != 0.0 else 0.0
        about_z, turn, constant = momentum_of(y, coef, lane)
        change = abs(about_z - lanes[at.MOMENTUM_0 * WIDTH + lane])
        # The largest it can have with the energy there is, by Cauchy and Schwarz.
        largest = math.sqrt(2.0 * lanes[at.ENERGY_SCALE * WIDTH + lane] * turn) + constant
        out[at.R_MOMENTUM_ERROR, i] = change / largest if change != 0.0 else 0.0
        out[at.R_PENETRATION, i] = lanes[at.PENETRATION * WIDTH + lane]
        kappa = coef[at.KAPPA * WIDTH + lane]
        u, v = kappa * y[at.W_X * WIDTH + lane], kappa * y[at.W_Y * WIDTH + lane]
        e_z = 1.0 / math.sqrt(1.0 + u * u + v * v)
        out[at.R_X, i], out[at.R_Y, i] = c * y[at.O_X * WIDTH + lane], c * y[at.O_Y * WIDTH + lane]
        out[at.R_AXIS_X, i], out[at.R_AXIS_Y, i], out[at.R_AXIS_Z, i] = u * e_z, v * e_z, e_z
        out[at.R_TILT, i] = math.atan(kappa * math.sqrt(max(lanes[at.BEST_TILT * WIDTH + lane], 0.0)))
        if spins:
            out[at.R_OMEGA, i] = y[at.SPIN_RATE * WIDTH + lane]
        else:
            out[at.R_OMEGA, i] = coef[at.OMEGA_FIXED * WIDTH + lane]
        if rubs:
            store_friction(lanes, out, joule, newton * c, i, lane)

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

    return Samples(load, begin, state_of, store, note)
