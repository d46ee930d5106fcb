"""General body on the exact section: the equations of :mod:`exact_section` in the form that blocks of lanes use.

State (c_x, c_y, cos(delta), sin(delta), sin(eps), turning rate of c, nu, cos(phi), sin(phi), Omega) with phi = chi - angle
of c; lengths over L, masses over m.
"""

from __future__ import annotations

import math

from tolmc.kernels import parameters as P
from tolmc.kernels.formulations import exact_section as section
from tolmc.kernels.jit import device

STATE = section.STATE + 3
COEFFICIENTS = 26
TORQUE = True
RUBS = False

(
    _CLEARANCE, _JOURNAL, _LENGTH, _FORCE, _ENERGY,
    _COM_X, _COM_Y, _COM_Z, _J_XX, _J_YY, _J_ZZ, _J_XY, _J_XZ, _J_YZ,
    _GX, _GY, _GZ, _FX, _FY, _FZ, _AT_X, _AT_Y, _AT_Z, _TX, _TY, _TZ,
) = range(COEFFICIENTS)  # fmt: skip


@device
def prepare(raw, i, coef, lane, width):
    """Coefficients of lane ``lane`` from column ``i`` of the parameters."""
    length, mass, journal = raw[P.HALF_LENGTH, i], raw[P.MASS, i], raw[P.JOURNAL_RADIUS, i]
    per_length, per_force, per_inertia = 1.0 / length, 1.0 / (mass * length), 1.0 / (mass * length * length)
    coef[_CLEARANCE * width + lane] = (raw[P.BEARING_RADIUS, i] - journal) * per_length
    coef[_JOURNAL * width + lane] = journal * per_length
    coef[_LENGTH * width + lane] = length
    coef[_FORCE * width + lane] = mass * length
    coef[_ENERGY * width + lane] = mass * length * length
    for axis in range(3):
        coef[(_COM_X + axis) * width + lane] = raw[P.COM_X + axis, i] * per_length
        coef[(_GX + axis) * width + lane] = raw[P.GRAVITY_X + axis, i] * per_length
        coef[(_FX + axis) * width + lane] = raw[P.FORCE_X + axis, i] * per_force
        coef[(_AT_X + axis) * width + lane] = raw[P.POINT_X + axis, i] * per_length
        coef[(_TX + axis) * width + lane] = raw[P.TORQUE_X + axis, i] * per_inertia
    for entry in range(6):
        coef[(_J_XX + entry) * width + lane] = raw[P.J_XX + entry, i] * per_inertia


@device
def start(raw, i, y, coef, lane, width):
    """State at t = 0 from the polar angles, their rates, the spin and its rate."""
    length, journal = raw[P.HALF_LENGTH, i], raw[P.JOURNAL_RADIUS, i]
    state = section.start(
        raw[P.ALPHA, i], raw[P.BETA, i], raw[P.ALPHA_RATE, i], raw[P.BETA_RATE, i],
        (raw[P.BEARING_RADIUS, i] - journal) / length, journal / length,
    )  # fmt: skip
    for component in range(section.STATE):
        y[component * width + lane] = state[component]
    phi = raw[P.SPIN, i] - 0.5 * (raw[P.ALPHA, i] + raw[P.BETA, i])
    y[7 * width + lane], y[8 * width + lane] = math.cos(phi), math.sin(phi)
    y[9 * width + lane] = raw[P.SPIN_RATE, i]


@device
def _shape(y, coef, lane, width):
    return section.shape(
        y[2 * width + lane], y[3 * width + lane], y[4 * width + lane], y[6 * width + lane],
        coef[_CLEARANCE * width + lane], coef[_JOURNAL * width + lane],
    )  # fmt: skip


@device
def _from_shape(y, shaped, coef, lane, width, with_load):
    """What :func:`evaluate` returns, from what :func:`exact_section.shape` has."""
    c_x, c_y = y[lane], y[width + lane]
    cos_d, sin_d = y[2 * width + lane], y[3 * width + lane]
    swing, nu = y[5 * width + lane], y[6 * width + lane]
    big_x, big_y, kappa, pull, turn, lean, x_bias, y_bias, cos2, cos_t = shaped
    gx, gy = coef[_GX * width + lane], coef[_GY * width + lane]
    fx, fy = coef[_FX * width + lane], coef[_FY * width + lane]
    tx, ty = coef[_TX * width + lane], coef[_TY * width + lane]
    swing_rate, nu_rate, spin_rate, phi_rate, n_d, n_e, kinetic, potential, power, about_z, turn_z = section.general(
        cos_d, sin_d, big_x, big_y, kappa, pull, x_bias, y_bias, cos2, cos_t, swing, nu,
        y[7 * width + lane], y[8 * width + lane], y[9 * width + lane],
        coef[_COM_X * width + lane], coef[_COM_Y * width + lane], coef[_COM_Z * width + lane],
        coef[_J_XX * width + lane], coef[_J_YY * width + lane], coef[_J_ZZ * width + lane],
        coef[_J_XY * width + lane], coef[_J_XZ * width + lane], coef[_J_YZ * width + lane],
        c_x * gx + c_y * gy, c_x * gy - c_y * gx, coef[_GZ * width + lane],
        c_x * fx + c_y * fy, c_x * fy - c_y * fx, coef[_FZ * width + lane],
        coef[_AT_X * width + lane], coef[_AT_Y * width + lane], coef[_AT_Z * width + lane],
        c_x * tx + c_y * ty, c_x * ty - c_y * tx, coef[_TZ * width + lane],
        with_load,
    )  # fmt: skip
    newton, joule = coef[_FORCE * width + lane], coef[_ENERGY * width + lane]
    return (
        swing_rate, nu_rate, spin_rate, phi_rate, turn, lean, big_x, big_y,
        newton * n_d, newton * n_e, joule * kinetic, joule * potential, joule * power, joule * about_z, joule * turn_z,
    )  # fmt: skip


@device
def evaluate(y, coef, lane, width, with_load):
    """(swing', nu', Omega', phi', delta', sin(eps)', X, Y, N_D, N_E, T, V, power, momentum about Z, that of a unit turn).

    Of one lane; SI units, X and Y over L.
    """
    return _from_shape(y, _shape(y, coef, lane, width), coef, lane, width, with_load)


@device
def begin(y, held, coef, lane, width, with_load):
    """The first part of a right-hand side: what the pose determines."""
    section.hold(_shape(y, coef, lane, width), held, STATE * width + lane, width)


@device
def finish(y, held, coef, h, k, first, lane, width, with_load):
    """The last: h y' into ``k[first:]``; returns N_D, N_E, |w|^2, T, V and the power of the torque."""
    swing_rate, nu_rate, spin_rate, phi_rate, turn, lean, _, big_y, n_d, n_e, kinetic, potential, power, _, _ = (
        _from_shape(y, section.held_shape(held, STATE * width + lane, width), coef, lane, width, with_load)
    )
    swing = h * y[5 * width + lane]
    k[first + lane] = -swing * y[width + lane]
    k[first + width + lane] = swing * y[lane]
    k[first + 2 * width + lane] = -h * turn * y[3 * width + lane]
    k[first + 3 * width + lane] = h * turn * y[2 * width + lane]
    k[first + 4 * width + lane] = h * lean
    k[first + 5 * width + lane] = h * swing_rate
    k[first + 6 * width + lane] = h * nu_rate
    k[first + 7 * width + lane] = -h * phi_rate * y[8 * width + lane]
    k[first + 8 * width + lane] = h * phi_rate * y[7 * width + lane]
    k[first + 9 * width + lane] = h * spin_rate
    length = coef[_LENGTH * width + lane]
    return n_d, n_e, (length * big_y) * (length * big_y), kinetic, potential, power


@device
def rate_of_w2(y, k, coef, lane, width):
    """The rate of |w|^2, over a step, with h y' in ``k``."""
    length = coef[_LENGTH * width + lane]
    return length * length * section.rate_of_w2(
        y[3 * width + lane], y[4 * width + lane], k[3 * width + lane], k[4 * width + lane],
        coef[_CLEARANCE * width + lane], coef[_JOURNAL * width + lane],
    )  # fmt: skip


@device
def sense(y, held, coef, lane, width, with_load):
    """N_D, N_E in place of the last part."""
    _, _, _, _, _, _, _, _, n_d, n_e, _, _, _, _, _ = _from_shape(
        y, section.held_shape(held, STATE * width + lane, width), coef, lane, width, with_load
    )
    return n_d, n_e


HELD, PARTS = 10, (None, begin, finish)


@device
def project(y, coef, lane, width):
    """Back to touching rims and cos^2 + sin^2 = 1; returns the gap left over the clearance."""
    clearance, journal = coef[_CLEARANCE * width + lane], coef[_JOURNAL * width + lane]
    c_x, c_y, cos_d, sin_d, sin_e = section.project(
        y[lane], y[width + lane], y[2 * width + lane], y[3 * width + lane], y[4 * width + lane], clearance, journal
    )
    cos_p, sin_p = y[7 * width + lane], y[8 * width + lane]
    to_1 = 1.0 / math.sqrt(cos_p * cos_p + sin_p * sin_p)
    y[lane], y[width + lane], y[2 * width + lane], y[3 * width + lane] = c_x, c_y, cos_d, sin_d
    y[4 * width + lane], y[7 * width + lane], y[8 * width + lane] = sin_e, to_1 * cos_p, to_1 * sin_p
    return abs(section.gap(cos_d, sin_d, sin_e, clearance, journal)) / clearance


@device
def momentum(y, coef, lane, width):
    """Angular momentum about Z, kg m^2/s; that of a unit turn about Z, kg m^2; and 0: no part is left out."""
    _, _, _, _, _, _, _, _, _, _, _, _, _, about_z, turn = evaluate(y, coef, lane, width, False)
    return about_z, turn, 0.0


@device
def scale_speeds(y, factor, lane, width):
    """Multiply the speeds by ``factor``: the projection on the energy."""
    y[5 * width + lane] *= factor
    y[6 * width + lane] *= factor
    y[9 * width + lane] *= factor


@device
def motion(y, coef, lane, width):
    """(O_x, O_y, u, v, O_x', O_y', u', v', chi, Omega) of one lane, SI units."""
    ox, oy, wx, wy, ux, uy, vx, vy = section.motion(
        y[lane], y[width + lane], y[2 * width + lane], y[3 * width + lane], y[4 * width + lane], y[5 * width + lane],
        y[6 * width + lane], coef[_CLEARANCE * width + lane], coef[_JOURNAL * width + lane],
    )  # fmt: skip
    length = coef[_LENGTH * width + lane]
    chi = math.atan2(y[8 * width + lane], y[7 * width + lane]) + math.atan2(y[width + lane], y[lane])
    return (
        length * ox, length * oy, length * wx, length * wy, length * ux, length * uy, length * vx, length * vy,
        chi, y[9 * width + lane],
    )  # fmt: skip


@device
def observe(y, coef, lane, width, with_load):
    """(O_x, O_y, u, v, N_D, N_E, lambda_D, lambda_E, T, V, |w|^2) of one lane; the multipliers are the contact forces."""
    _, _, _, _, _, _, big_x, big_y, n_d, n_e, kinetic, potential, _, _, _ = evaluate(y, coef, lane, width, with_load)
    c_x, c_y = y[lane], y[width + lane]
    x, w = coef[_LENGTH * width + lane] * big_x, coef[_LENGTH * width + lane] * big_y
    return x * c_x, x * c_y, -w * c_y, w * c_x, n_d, n_e, n_d, n_e, kinetic, potential, w * w
