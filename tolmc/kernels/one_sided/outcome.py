"""Results of the lanes that have come to their samples' ends, in packed loops."""

from __future__ import annotations

import math
from collections.abc import Callable

from tolmc.kernels.jit import device, routine
from tolmc.kernels.one_sided import layout as at
from tolmc.kernels.one_sided.equations import Equations
from tolmc.kernels.one_sided.layout import WIDTH


def build(equations: Equations) -> Callable:
    """Routine ``store(y, coef, lanes, results, out, ended)``.

    SI results of all lanes into ``results`` (layout.RESULTS, lane), and of those that have ``ended`` into the columns of their
    samples in ``out``; what became of them stands in STATUS.
    """
    spins, rubs, momentum = equations.spins, equations.rubs, equations.momentum
    rows = at.RESULTS if rubs else at.R_CLOSED_E + 1

    @routine
    def motion(y, coef, lanes, results):
        """Where it ended, and what its invariants say."""
        for lane in range(WIDTH):
            spin = y[at.SPIN_RATE * WIDTH + lane] if spins else coef[at.OMEGA_FIXED * WIDTH + lane]
            results[at.R_OMEGA * WIDTH + lane] = spin
            error, scale = lanes[at.ENERGY_ERROR * WIDTH + lane], lanes[at.ENERGY_SCALE * WIDTH + lane]
            results[at.R_ENERGY_ERROR * WIDTH + lane] = error / scale if error != 0.0 else 0.0
            about_z, turn, constant = momentum(y, spin, coef, lane, WIDTH)
            change = abs(about_z - lanes[at.MOMENTUM_0 * WIDTH + lane])
            # The largest it can have with the energy there is, by Cauchy and Schwarz.
            largest = math.sqrt(2.0 * scale * turn) + constant
            results[at.R_MOMENTUM_ERROR * WIDTH + lane] = change / largest if change != 0.0 else 0.0
            c, kappa = coef[at.C * WIDTH + lane], coef[at.KAPPA * WIDTH + lane]
            u, v = kappa * y[at.W_X * WIDTH + lane], kappa * y[at.W_Y * WIDTH + lane]
            e_z = 1.0 / math.sqrt(1.0 + u * u + v * v)
            results[at.R_X * WIDTH + lane] = c * y[at.O_X * WIDTH + lane]
            results[at.R_Y * WIDTH + lane] = c * y[at.O_Y * WIDTH + lane]
            results[at.R_AXIS_X * WIDTH + lane], results[at.R_AXIS_Y * WIDTH + lane] = u * e_z, v * e_z
            results[at.R_AXIS_Z * WIDTH + lane] = e_z

    @routine
    def statistics(coef, lanes, results):
        for lane in range(WIDTH):
            results[at.R_STATUS * WIDTH + lane] = lanes[at.STATUS * WIDTH + lane]
            results[at.R_END * WIDTH + lane] = lanes[at.T * WIDTH + lane]
            results[at.R_ROUNDS * WIDTH + lane] = lanes[at.ROUNDS * WIDTH + lane]
            results[at.R_EVENTS * WIDTH + lane] = lanes[at.EVENTS * WIDTH + lane]
            results[at.R_TIME_FREE * WIDTH + lane] = lanes[at.TIME_FREE * WIDTH + lane]
            lost, hit = lanes[at.LOST_AT * WIDTH + lane], lanes[at.HIT_AT * WIDTH + lane]
            results[at.R_LOST_AT * WIDTH + lane] = lost if lost >= 0.0 else math.nan
            results[at.R_HIT_AT * WIDTH + lane] = hit
            results[at.R_PENETRATION * WIDTH + lane] = lanes[at.PENETRATION * WIDTH + lane]
            joule = coef[at.ENERGY * WIDTH + lane]
            results[at.R_IMPACT_LOSS * WIDTH + lane] = joule * lanes[at.IMPACT_LOSS * WIDTH + lane]
            tilt = max(lanes[at.BEST_TILT * WIDTH + lane], 0.0)
            results[at.R_TILT * WIDTH + lane] = coef[at.KAPPA * WIDTH + lane] * math.sqrt(tilt)

    @routine
    def forces(coef, lanes, results):
        """Of both ends."""
        for lane in range(WIDTH):
            newton, c = coef[at.FORCE * WIDTH + lane], coef[at.C * WIDTH + lane]
            for side in range(2):
                high = lanes[(at.BEST_D_MAX + 2 * side) * WIDTH + lane]
                low = lanes[(at.BEST_D_MIN + 2 * side) * WIDTH + lane]
                time = lanes[(at.TIME_D + side) * WIDTH + lane]
                results[(at.R_D_MAX + 2 * side) * WIDTH + lane] = newton * high if time > 0.0 else math.nan
                # No force of a closed contact is negative: what is left below zero is the root's rounding.
                results[(at.R_D_MIN + 2 * side) * WIDTH + lane] = newton * max(-low, 0.0) if time > 0.0 else math.nan
                impulses = lanes[(at.TOTAL_D + side) * WIDTH + lane]
                integral = lanes[(at.INTEGRAL_D + side) * WIDTH + lane] + impulses
                results[(at.R_INTEGRAL_D + side) * WIDTH + lane] = newton * integral
                square = lanes[(at.SQUARE_D + side) * WIDTH + lane]
                results[(at.R_SQUARE_D + side) * WIDTH + lane] = newton * newton * square
                results[(at.R_TIME_D + side) * WIDTH + lane] = time
                results[(at.R_COUNT_D + side) * WIDTH + lane] = lanes[(at.COUNT_D + side) * WIDTH + lane]
                results[(at.R_SPEED_D + side) * WIDTH + lane] = c * lanes[(at.SPEED_D + side) * WIDTH + lane]
                results[(at.R_IMPULSE_D + side) * WIDTH + lane] = newton * lanes[(at.IMPULSE_D + side) * WIDTH + lane]
                results[(at.R_TOTAL_D + side) * WIDTH + lane] = newton * impulses
                results[(at.R_PEAK_D + side) * WIDTH + lane] = lanes[(at.PEAK_D + side) * WIDTH + lane]
                results[(at.R_CLOSED_D + side) * WIDTH + lane] = coef[(at.CLOSED_D + side) * WIDTH + lane]

    @routine
    def friction(coef, lanes, results):
        for lane in range(WIDTH):
            joule = coef[at.ENERGY * WIDTH + lane]
            slip = coef[at.FORCE * WIDTH + lane] * coef[at.C * WIDTH + lane]
            results[at.R_SLIP_D * WIDTH + lane] = slip * lanes[at.WORK_SLIP_D * WIDTH + lane]
            results[at.R_SLIP_E * WIDTH + lane] = slip * lanes[at.WORK_SLIP_E * WIDTH + lane]
            results[at.R_HEAT * WIDTH + lane] = joule * lanes[at.WORK_HEAT * WIDTH + lane]
            results[at.R_TORQUE * WIDTH + lane] = joule * lanes[at.TORQUE_INTEGRAL * WIDTH + lane]
            results[at.R_TORQUE_MAX * WIDTH + lane] = joule * lanes[at.TORQUE_MAX * WIDTH + lane]
            results[at.R_SLOW * WIDTH + lane] = lanes[at.TIME_SLOW * WIDTH + lane]
            results[at.R_TURN * WIDTH + lane] = lanes[at.TURN * WIDTH + lane]
            results[at.R_DRIVE * WIDTH + lane] = joule * lanes[at.DRIVE_INTEGRAL * WIDTH + lane]
            results[at.R_DRIVE_WORK * WIDTH + lane] = joule * lanes[at.DRIVE_WORK * WIDTH + lane]
            results[at.R_DRIVE_MAX * WIDTH + lane] = joule * lanes[at.DRIVE_MAX * WIDTH + lane]

    @device
    def hertz(energy, stiffness):
        """The peak of Hertz' force, K (5 m gamma^2/(4 K))^0.6."""
        return stiffness * (1.25 * energy / stiffness) ** 0.6 if stiffness > 0.0 else 0.0

    @routine
    def store(y, coef, lanes, results, out, ended):
        motion(y, coef, lanes, results)
        statistics(coef, lanes, results)
        forces(coef, lanes, results)
        if rubs:
            friction(coef, lanes, results)
        for lane in range(WIDTH):
            if ended[lane]:
                i = int(lanes[at.SAMPLE * WIDTH + lane])
                for row in range(rows):
                    out[row, i] = results[row * WIDTH + lane]
                out[at.R_TILT, i] = math.atan(results[at.R_TILT * WIDTH + lane])
                for row in (at.R_PEAK_D, at.R_PEAK_E):
                    out[row, i] = hertz(results[row * WIDTH + lane], coef[at.HERTZ * WIDTH + lane])

    return store
