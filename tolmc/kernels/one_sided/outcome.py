"""Results of the lanes that have come to their samples' ends, in packed loops."""

from __future__ import annotations

import math
from collections.abc import Callable

from tolmc.kernels import results as R
from tolmc.kernels.jit import device, routine, strict
from tolmc.kernels.one_sided import layout as at
from tolmc.kernels.one_sided.equations import Equations
from tolmc.kernels.one_sided.layout import WIDTH

_SIDES = (R.D_MAX, R.D_IMPACTS), (R.E_MAX, R.E_IMPACTS)


@strict
def per(x, time):
    """x over a time: 1 where both are the same, which a product with 1/time need not be; NaN of no time."""
    return x / time if time > 0.0 else math.nan


def build(equations: Equations) -> Callable:
    """Routine ``store(y, coef, lanes, duration, results, out, ended)``.

    SI results (results.RESULTS, lane) of all lanes into ``results``, the largest tilt by its tangent, and of those that have
    ``ended`` into the columns of their samples in ``out``; what became of them stands in STATUS.
    """
    spins, rubs, swings, momentum = equations.spins, equations.rubs, equations.swings, equations.momentum
    last = R.WEAR_RATE if rubs else R.FRICTION_TORQUE_MAX

    @routine
    def motion(y, coef, lanes, results):
        """Where it ended, and what its invariants say."""
        for lane in range(WIDTH):
            spin = y[at.SPIN_RATE * WIDTH + lane] if spins else coef[at.OMEGA_FIXED * WIDTH + lane]
            error, scale = lanes[at.ENERGY_ERROR * WIDTH + lane], lanes[at.ENERGY_SCALE * WIDTH + lane]
            results[R.ENERGY_ERROR * WIDTH + lane] = error / scale if error != 0.0 else 0.0
            about_z, turn, constant = momentum(y, spin, coef, lane, WIDTH)
            change = abs(about_z - lanes[at.MOMENTUM_0 * WIDTH + lane])
            # The largest it can have with the energy there is, by Cauchy and Schwarz.
            largest = math.sqrt(2.0 * scale * turn) + constant
            results[R.MOMENTUM_ERROR * WIDTH + lane] = change / largest if change != 0.0 else 0.0
            results[R.CONSTRAINT_ERROR * WIDTH + lane] = abs(lanes[at.PENETRATION * WIDTH + lane])
            c, kappa = coef[at.C * WIDTH + lane], coef[at.KAPPA * WIDTH + lane]
            u, v = kappa * y[at.W_X * WIDTH + lane], kappa * y[at.W_Y * WIDTH + lane]
            e_z = 1.0 / math.sqrt(1.0 + u * u + v * v)
            results[R.ORIGIN_X * WIDTH + lane] = c * y[at.O_X * WIDTH + lane]
            results[R.ORIGIN_Y * WIDTH + lane] = c * y[at.O_Y * WIDTH + lane]
            results[R.AXIS_X * WIDTH + lane], results[R.AXIS_Y * WIDTH + lane] = u * e_z, v * e_z
            results[R.AXIS_Z * WIDTH + lane] = e_z

    @device
    def lasted(coef, lanes, duration, lane):
        """Time over which means are taken: where a wall without restitution loses its journal the motion ends."""
        end = lanes[at.T * WIDTH + lane]
        end = end if end > 0.0 else 1.0
        return duration if coef[at.BOUNCE * WIDTH + lane] >= 0.0 else end

    @routine
    def course(coef, lanes, duration, results):
        for lane in range(WIDTH):
            results[R.STATUS * WIDTH + lane] = lanes[at.STATUS * WIDTH + lane]
            results[R.END_TIME * WIDTH + lane] = lanes[at.T * WIDTH + lane]
            results[at.R_ROUNDS * WIDTH + lane] = lanes[at.ROUNDS * WIDTH + lane]
            results[at.R_EVENTS * WIDTH + lane] = lanes[at.EVENTS * WIDTH + lane]
            time = lasted(coef, lanes, duration, lane)
            results[R.FREE_SHARE * WIDTH + lane] = per(lanes[at.TIME_FREE * WIDTH + lane], time)
            lost, hit = lanes[at.LOST_AT * WIDTH + lane], lanes[at.HIT_AT * WIDTH + lane]
            results[R.LOSS_TIME * WIDTH + lane] = lost if lost >= 0.0 else math.nan
            results[R.FIRST_IMPACT * WIDTH + lane] = hit
            joule = coef[at.ENERGY * WIDTH + lane]
            results[R.IMPACT_LOSS * WIDTH + lane] = joule * lanes[at.IMPACT_LOSS * WIDTH + lane]
            tilt = max(lanes[at.BEST_TILT * WIDTH + lane], 0.0)
            results[R.TILT_MAX * WIDTH + lane] = coef[at.KAPPA * WIDTH + lane] * math.sqrt(tilt)

    @routine
    def contacts(coef, lanes, duration, results):
        """Forces and impacts of both ends."""
        for lane in range(WIDTH):
            newton, c, whole = (
                coef[at.FORCE * WIDTH + lane],
                coef[at.C * WIDTH + lane],
                lasted(coef, lanes, duration, lane),
            )
            for side in range(2):
                first, impacts = _SIDES[side]
                high = lanes[(at.BEST_D_MAX + 2 * side) * WIDTH + lane]
                low = lanes[(at.BEST_D_MIN + 2 * side) * WIDTH + lane]
                time, total = lanes[(at.TIME_D + side) * WIDTH + lane], lanes[(at.TOTAL_D + side) * WIDTH + lane]
                integral, square = (
                    lanes[(at.INTEGRAL_D + side) * WIDTH + lane],
                    lanes[(at.SQUARE_D + side) * WIDTH + lane],
                )
                results[first * WIDTH + lane] = newton * high if time > 0.0 else math.nan
                # No force of a closed contact is negative: what is left below zero is the root's rounding.
                results[(first + 1) * WIDTH + lane] = newton * max(-low, 0.0) if time > 0.0 else math.nan
                results[(first + 2) * WIDTH + lane] = per(newton * (integral + total), whole)
                results[(first + 3) * WIDTH + lane] = newton * math.sqrt(max(per(square, time), 0.0))
                results[impacts * WIDTH + lane] = lanes[(at.COUNT_D + side) * WIDTH + lane]
                results[(impacts + 1) * WIDTH + lane] = c * lanes[(at.SPEED_D + side) * WIDTH + lane]
                results[(impacts + 2) * WIDTH + lane] = newton * lanes[(at.IMPULSE_D + side) * WIDTH + lane]
                results[(impacts + 3) * WIDTH + lane] = newton * total
                results[(impacts + 4) * WIDTH + lane] = per(time, whole)
                # The energy of which Hertz makes the force.
                results[(impacts + 5) * WIDTH + lane] = lanes[(at.PEAK_D + side) * WIDTH + lane]

    @routine
    def friction(y, coef, lanes, duration, results):
        for lane in range(WIDTH):
            joule, whole = coef[at.ENERGY * WIDTH + lane], lasted(coef, lanes, duration, lane)
            slip = coef[at.FORCE * WIDTH + lane] * coef[at.C * WIDTH + lane]
            heat, turn = joule * lanes[at.WORK_HEAT * WIDTH + lane], lanes[at.TURN * WIDTH + lane]
            results[R.FRICTION_WORK * WIDTH + lane], results[R.FRICTION_POWER_MEAN * WIDTH + lane] = (
                heat,
                per(heat, whole),
            )
            results[R.FRICTION_TORQUE_MAX * WIDTH + lane] = joule * lanes[at.TORQUE_MAX * WIDTH + lane]
            torque = per(joule * lanes[at.TORQUE_INTEGRAL * WIDTH + lane], whole)
            results[R.FRICTION_TORQUE_MEAN * WIDTH + lane] = torque
            results[R.D_SLIP_WORK * WIDTH + lane] = slip * lanes[at.WORK_SLIP_D * WIDTH + lane]
            results[R.E_SLIP_WORK * WIDTH + lane] = slip * lanes[at.WORK_SLIP_E * WIDTH + lane]
            results[R.SLOW_SHARE * WIDTH + lane] = per(lanes[at.TIME_SLOW * WIDTH + lane], whole)
            touched = lanes[at.TIME_D * WIDTH + lane] + lanes[at.TIME_E * WIDTH + lane]
            results[R.WHIRL_RATE_MEAN * WIDTH + lane] = per(turn, touched)
            results[R.SPIN_END * WIDTH + lane] = y[at.SPIN_RATE * WIDTH + lane]
            results[R.DRIVE_TORQUE_MAX * WIDTH + lane] = joule * lanes[at.DRIVE_MAX * WIDTH + lane]
            drive = per(joule * lanes[at.DRIVE_INTEGRAL * WIDTH + lane], whole)
            power = per(joule * lanes[at.DRIVE_WORK * WIDTH + lane], whole)
            results[R.DRIVE_TORQUE_MEAN * WIDTH + lane] = drive
            results[R.DRIVE_POWER_MEAN * WIDTH + lane] = power if swings else drive * y[at.SPIN_RATE * WIDTH + lane]

    @device
    def hertz(energy, stiffness):
        """The peak of Hertz' force, K (5 m gamma^2/(4 K))^0.6."""
        return stiffness * (1.25 * energy / stiffness) ** 0.6 if stiffness > 0.0 else 0.0

    @routine
    def store(y, coef, lanes, duration, results, out, ended):
        motion(y, coef, lanes, results)
        course(coef, lanes, duration, results)
        contacts(coef, lanes, duration, results)
        if rubs:
            friction(y, coef, lanes, duration, results)
        for lane in range(WIDTH):
            if ended[lane]:
                i = int(lanes[at.SAMPLE * WIDTH + lane])
                # What no motion with impacts has stays zero.
                for row in range(at.R_EVENTS + 1):
                    out[row, i] = results[row * WIDTH + lane]
                for row in range(R.D_IMPACTS, last):
                    out[row, i] = results[row * WIDTH + lane]
                for row in (R.D_IMPACT_FORCE_MAX, R.E_IMPACT_FORCE_MAX):
                    out[row, i] = hertz(results[row * WIDTH + lane], coef[at.HERTZ * WIDTH + lane])

    return store
