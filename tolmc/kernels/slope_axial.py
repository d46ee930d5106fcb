"""Symmetric body under axial load alone: the pose matters only through the angle between D and E.

State (cos(delta), sin(delta), s, d), delta half the angle from E to D: four components instead of six, and no product with
a transverse load.
"""

from __future__ import annotations

import math

from tolmc.kernels import parameters as P
from tolmc.kernels import slope_symmetric
from tolmc.kernels.jit import device

STATE = 4  # cos(delta), sin(delta), s, d
COEFFICIENTS = slope_symmetric.COEFFICIENTS
_R = COEFFICIENTS - 1

prepare = slope_symmetric.prepare


@device
def start(raw, i, y, lane, width):
    """State at t = 0 from the polar angles and their rates."""
    delta = 0.5 * (raw[P.ALPHA, i] - raw[P.BETA, i])
    y[lane], y[width + lane] = math.cos(delta), math.sin(delta)
    y[2 * width + lane] = 0.5 * (raw[P.ALPHA_RATE, i] + raw[P.BETA_RATE, i])
    y[3 * width + lane] = 0.5 * (raw[P.ALPHA_RATE, i] - raw[P.BETA_RATE, i])


@device
def evaluate(y, coef, lane, width, with_load):
    """(s', d', N_D, N_E, lambda_D, lambda_E, q, T, V) of one lane."""
    cos_d, sin_d = y[lane], y[width + lane]
    q = sin_d * sin_d
    s_rate, d_rate, n_d, n_e, lambda_d, lambda_e, kinetic, potential = slope_symmetric.dynamics(
        cos_d * cos_d, q, cos_d * sin_d, y[2 * width + lane], y[3 * width + lane], False,
        0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, coef, lane, width, with_load,
    )  # fmt: skip
    return s_rate, d_rate, n_d, n_e, lambda_d, lambda_e, q, kinetic, potential


@device
def advance(y, coef, h, k, first, lane, width, with_load):
    """h y' into ``k[first:]``; returns N_D, N_E, |w|^2 (m^2) and the power of the torque (none here)."""
    s_rate, d_rate, n_d, n_e, _, _, q, _, _ = evaluate(y, coef, lane, width, with_load)
    turn = h * y[3 * width + lane]
    k[first + lane] = -turn * y[width + lane]
    k[first + width + lane] = turn * y[lane]
    k[first + 2 * width + lane] = h * s_rate
    k[first + 3 * width + lane] = h * d_rate
    r = coef[_R * width + lane]
    return n_d, n_e, r * r * q, 0.0


@device
def project(y, coef, lane, width):
    """Back to cos^2 + sin^2 = 1; returns the error left."""
    cos_d, sin_d = y[lane], y[width + lane]
    factor = 1.0 / math.sqrt(cos_d * cos_d + sin_d * sin_d)
    cos_d, sin_d = factor * cos_d, factor * sin_d
    y[lane], y[width + lane] = cos_d, sin_d
    return 0.5 * abs(cos_d * cos_d + sin_d * sin_d - 1.0)


@device
def scale_speeds(y, factor, lane, width):
    """Multiply the speeds by ``factor``: the projection on the energy."""
    y[2 * width + lane] *= factor
    y[3 * width + lane] *= factor


@device
def observe(y, coef, lane, width, with_load):
    """(|O|, 0, |w|, 0, N_D, N_E, lambda_D, lambda_E, T, V, |w|^2) of one lane, SI units."""
    _, _, n_d, n_e, lambda_d, lambda_e, q, kinetic, potential = evaluate(y, coef, lane, width, with_load)
    r = coef[_R * width + lane]
    return (
        r * abs(y[lane]), 0.0, r * abs(y[width + lane]), 0.0,
        n_d, n_e, lambda_d, lambda_e, kinetic, potential, r * r * q,
    )  # fmt: skip
