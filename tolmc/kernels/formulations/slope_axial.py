"""Symmetric body under axial load alone: the pose matters only through the angle between D and E.

State (cos(delta), sin(delta), P_s, P_d), delta half the angle from E to D: four components instead of six, and no product with
a transverse load.
"""

from __future__ import annotations

import math

from tolmc.kernels import parameters as P
from tolmc.kernels.formulations import slope_symmetric
from tolmc.kernels.jit import device

STATE = 4  # cos(delta), sin(delta), P_s, P_d
COEFFICIENTS = slope_symmetric.COEFFICIENTS
TORQUE = False
RUBS = False

prepare = slope_symmetric.prepare


@device
def start(raw, i, y, coef, lane, width):
    """State at t = 0 from the polar angles and their rates."""
    cos_d, sin_d = raw[P.COS_HALF, i], raw[P.SIN_HALF, i]
    y[lane], y[width + lane] = cos_d, sin_d
    y[2 * width + lane], y[3 * width + lane] = slope_symmetric.momenta(raw, i, cos_d, sin_d, coef, lane, width)


@device
def _pose(y, coef, lane, width):
    cos_d, sin_d = y[lane], y[width + lane]
    return slope_symmetric.of_pose(cos_d * cos_d, sin_d * sin_d, cos_d * sin_d, coef, lane, width)


@device
def _from_pose(y, posed, coef, lane, width, with_load):
    """What :func:`evaluate` returns, from what the pose determines."""
    s, d, rate_s, rate_d, n_d, n_e, lambda_d, lambda_e, kinetic, potential = slope_symmetric.dynamics(
        posed, y[2 * width + lane], y[3 * width + lane], False,
        0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, coef, lane, width, with_load,
    )  # fmt: skip
    return s, d, rate_s, rate_d, n_d, n_e, lambda_d, lambda_e, kinetic, potential, posed[1]


@device
def evaluate(y, coef, lane, width, with_load):
    """(s, d, P_s', P_d', N_D, N_E, lambda_D, lambda_E, T, V, q) of one lane."""
    return _from_pose(y, _pose(y, coef, lane, width), coef, lane, width, with_load)


@device
def begin(y, held, coef, lane, width, with_load):
    """The first part of a right-hand side: what the pose determines."""
    slope_symmetric.hold(_pose(y, coef, lane, width), held, STATE * width + lane, width)


@device
def finish(y, held, coef, h, k, first, lane, width, with_load):
    """The last: h y' into ``k[first:]``; returns N_D, N_E, |w|^2, T, V and the power of the torque (none here)."""
    posed = slope_symmetric.held_pose(held, STATE * width + lane, width)
    _, d, rate_s, rate_d, n_d, n_e, _, _, kinetic, potential, q = _from_pose(y, posed, coef, lane, width, with_load)
    turn = h * d
    k[first + lane] = -turn * y[width + lane]
    k[first + width + lane] = turn * y[lane]
    k[first + 2 * width + lane] = h * rate_s
    k[first + 3 * width + lane] = h * rate_d
    r = coef[slope_symmetric.R * width + lane]
    return n_d, n_e, r * r * q, kinetic, potential, 0.0


@device
def rate_of_w2(y, k, coef, lane, width):
    """The rate of |w|^2, over a step, with h y' in ``k``."""
    r = coef[slope_symmetric.R * width + lane]
    return 2.0 * r * r * y[width + lane] * k[width + lane]


@device
def sense(y, held, coef, lane, width, with_load):
    """N_D, N_E in place of the last part."""
    posed = slope_symmetric.held_pose(held, STATE * width + lane, width)
    _, _, _, _, n_d, n_e, _, _, _, _, _ = _from_pose(y, posed, coef, lane, width, with_load)
    return n_d, n_e


HELD, PARTS = slope_symmetric.HELD, (begin, finish)


@device
def project(y, coef, lane, width):
    """Back to cos^2 + sin^2 = 1; returns the error left."""
    cos_d, sin_d = y[lane], y[width + lane]
    factor = 1.0 / math.sqrt(cos_d * cos_d + sin_d * sin_d)
    cos_d, sin_d = factor * cos_d, factor * sin_d
    y[lane], y[width + lane] = cos_d, sin_d
    return 0.5 * abs(cos_d * cos_d + sin_d * sin_d - 1.0)


@device
def momentum(y, coef, lane, width):
    """As :func:`slope_symmetric.momentum`."""
    cos_d, sin_d = y[lane], y[width + lane]
    return slope_symmetric.momentum_about_z(cos_d * cos_d, sin_d * sin_d, y[2 * width + lane], coef, lane, width)


@device
def scale_speeds(y, factor, lane, width):
    """Multiply the speeds, and so the momenta, by ``factor``: the projection on the energy."""
    y[2 * width + lane] *= factor
    y[3 * width + lane] *= factor


@device
def motion(y, coef, lane, width):
    """(O_x, O_y, u, v, O_x', O_y', u', v', 0, 0) of one lane, SI units, in axes in which O lies along X."""
    s, d, _, _, _, _, _, _, _, _, _ = evaluate(y, coef, lane, width, False)
    r = coef[slope_symmetric.R * width + lane]
    cos_d, sin_d = r * y[lane], r * y[width + lane]
    return cos_d, 0.0, 0.0, sin_d, -d * sin_d, s * cos_d, -s * sin_d, d * cos_d, 0.0, 0.0


@device
def observe(y, coef, lane, width, with_load):
    """(|O|, 0, |w|, 0, N_D, N_E, lambda_D, lambda_E, T, V, |w|^2) of one lane, SI units."""
    _, _, _, _, n_d, n_e, lambda_d, lambda_e, kinetic, potential, q = evaluate(y, coef, lane, width, with_load)
    r = coef[slope_symmetric.R * width + lane]
    return (
        r * abs(y[lane]), 0.0, r * abs(y[width + lane]), 0.0,
        n_d, n_e, lambda_d, lambda_e, kinetic, potential, r * r * q,
    )  # fmt: skip
