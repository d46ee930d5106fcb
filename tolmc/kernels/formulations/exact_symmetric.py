"""Symmetric body on the exact section: the equations of :mod:`exact_section` in the form that blocks of lanes use.

State (c_x, c_y, cos(delta), sin(delta), sin(eps), turning rate of c, nu); lengths over L, masses over m.
"""

from __future__ import annotations

from tolmc.kernels import parameters as P
from tolmc.kernels.formulations import exact_section as section
from tolmc.kernels.jit import device

STATE = section.STATE
COEFFICIENTS = 13
TORQUE = False
RUBS = False

_CLEARANCE, _JOURNAL, _Z, _INERTIA, _GYRO, _FX, _FY, _GX, _GY, _GZ, _LENGTH, _FORCE, _ENERGY = range(COEFFICIENTS)


@device
def prepare(raw, i, coef, lane, width):
    """Coefficients of lane ``lane`` from column ``i`` of the parameters."""
    length, mass = raw[P.HALF_LENGTH, i], raw[P.MASS, i]
    journal, z = raw[P.JOURNAL_RADIUS, i], raw[P.COM_Z, i] / length
    z_force = raw[P.POINT_Z, i] / length
    per_force, per_inertia = 1.0 / (mass * length), 1.0 / (mass * length * length)
    coef[_CLEARANCE * width + lane] = (raw[P.BEARING_RADIUS, i] - journal) / length
    coef[_JOURNAL * width + lane] = journal / length
    coef[_Z * width + lane] = z
    coef[_INERTIA * width + lane] = raw[P.J_XX, i] * per_inertia
    coef[_GYRO * width + lane] = raw[P.J_ZZ, i] * raw[P.SPIN_RATE, i] * per_inertia
    for axis in range(2):
        gravity, force = raw[P.GRAVITY_X + axis, i] / length, raw[P.FORCE_X + axis, i] * per_force
        coef[(_FX + axis) * width + lane] = gravity + force
        coef[(_GX + axis) * width + lane] = z * gravity + z_force * force
    coef[_GZ * width + lane] = z * raw[P.GRAVITY_Z, i] / length + z_force * raw[P.FORCE_Z, i] * per_force
    coef[_LENGTH * width + lane] = length
    coef[_FORCE * width + lane] = mass * length
    coef[_ENERGY * width + lane] = mass * length * length


@device
def start(raw, i, y, coef, lane, width):
    """State at t = 0 from the polar angles and their rates."""
    length, journal = raw[P.HALF_LENGTH, i], raw[P.JOURNAL_RADIUS, i]
    state = section.start(
        raw[P.ALPHA, i], raw[P.BETA, i], raw[P.ALPHA_RATE, i], raw[P.BETA_RATE, i],
        (raw[P.BEARING_RADIUS, i] - journal) / length, journal / length,
    )  # fmt: skip
    for component in range(STATE):
        y[component * width + lane] = state[component]


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
    force_c, force_j, moment_c, moment_j, moment_z = 0.0, 0.0, 0.0, 0.0, 0.0
    if with_load:
        fx, fy = coef[_FX * width + lane], coef[_FY * width + lane]
        gx, gy = coef[_GX * width + lane], coef[_GY * width + lane]
        force_c, force_j = c_x * fx + c_y * fy, c_x * fy - c_y * fx
        moment_c, moment_j = c_x * gx + c_y * gy, c_x * gy - c_y * gx
        moment_z = coef[_GZ * width + lane]
    swing_rate, nu_rate, n_d, n_e, kinetic, potential, about_z, turn_z = section.symmetric(
        cos_d, sin_d, big_x, big_y, kappa, pull, x_bias, y_bias, cos2, cos_t, swing, nu,
        coef[_Z * width + lane], coef[_INERTIA * width + lane], coef[_GYRO * width + lane],
        force_c, force_j, moment_c, moment_j, moment_z,
    )  # fmt: skip
    newton, joule = coef[_FORCE * width + lane], coef[_ENERGY * width + lane]
    return (
        swing_rate, nu_rate, turn, lean, big_x, big_y, newton * n_d, newton * n_e, joule * kinetic, joule * potential,
        joule * about_z, joule * turn_z,
    )  # fmt: skip


@device
def evaluate(y, coef, lane, width, with_load):
    """(swing', nu', delta', sin(eps)', X, Y, N_D, N_E, T, V, momentum about Z, its change with swing) of one lane.

    SI units, X and Y over L.
    """
    return _from_shape(y, _shape(y, coef, lane, width), coef, lane, width, with_load)


@device
def begin(y, held, coef, lane, width, with_load):
    """The first part of a right-hand side: what the pose determines."""
    section.hold(_shape(y, coef, lane, width), held, STATE * width + lane, width)


@device
def finish(y, held, coef, h, k, first, lane, width, with_load):
    """The last: h y' into ``k[first:]``; returns N_D, N_E, |w|^2, T, V and the power of the torque (none here)."""
    swing_rate, nu_rate, turn, lean, _, big_y, n_d, n_e, kinetic, potential, _, _ = _from_shape(
        y, section.held_shape(held, STATE * width + lane, width), coef, lane, width, with_load
    )
    swing = h * y[5 * width + lane]
    k[first + lane] = -swing * y[width + lane]
    k[first + width + lane] = swing * y[lane]
    k[first + 2 * width + lane] = -h * turn * y[3 * width + lane]
    k[first + 3 * width + lane] = h * turn * y[2 * width + lane]
    k[first + 4 * width + lane] = h * lean
    k[first + 5 * width + lane] = h * swing_rate
    k[first + 6 * width + lane] = h * nu_rate
    length = coef[_LENGTH * width + lane]
    return n_d, n_e, (length * big_y) * (length * big_y), kinetic, potential, 0.0


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
    _, _, _, _, _, _, n_d, n_e, _, _, _, _ = _from_shape(
        y, section.held_shape(held, STATE * width + lane, width), coef, lane, width, with_load
    )
    return n_d, n_e


HELD, PARTS = 10, (None, begin, finish)


@device
def project(y, coef, lane, width):
    """Back to touching rims; returns the gap left over the clearance."""
    clearance, journal = coef[_CLEARANCE * width + lane], coef[_JOURNAL * width + lane]
    c_x, c_y, cos_d, sin_d, sin_e = section.project(
        y[lane], y[width + lane], y[2 * width + lane], y[3 * width + lane], y[4 * width + lane], clearance, journal
    )
    y[lane], y[width + lane], y[2 * width + lane], y[3 * width + lane] = c_x, c_y, cos_d, sin_d
    y[4 * width + lane] = sin_e
    return abs(section.gap(cos_d, sin_d, sin_e, clearance, journal)) / clearance


@device
def momentum(y, coef, lane, width):
    """Angular momentum about Z less the constant C Omega, kg m^2/s; its change with the swing, kg m^2; and |C Omega|."""
    _, _, _, _, _, _, _, _, _, _, about_z, turn = evaluate(y, coef, lane, width, False)
    return about_z, turn, abs(coef[_GYRO * width + lane]) * coef[_ENERGY * width + lane]


@device
def scale_speeds(y, factor, lane, width):
    """Multiply the speeds by ``factor``: the projection on the energy."""
    y[5 * width + lane] *= factor
    y[6 * width + lane] *= factor


@device
def motion(y, coef, lane, width):
    """(O_x, O_y, u, v, O_x', O_y', u', v', 0, 0) of one lane, SI units."""
    ox, oy, wx, wy, ux, uy, vx, vy = section.motion(
        y[lane], y[width + lane], y[2 * width + lane], y[3 * width + lane], y[4 * width + lane], y[5 * width + lane],
        y[6 * width + lane], coef[_CLEARANCE * width + lane], coef[_JOURNAL * width + lane],
    )  # fmt: skip
    length = coef[_LENGTH * width + lane]
    return (
        length * ox, length * oy, length * wx, length * wy, length * ux, length * uy, length * vx, length * vy,
        0.0, 0.0,
    )  # fmt: skip


@device
def observe(y, coef, lane, width, with_load):
    """(O_x, O_y, u, v, N_D, N_E, lambda_D, lambda_E, T, V, |w|^2) of one lane; the multipliers are the contact forces."""
    _, _, _, _, big_x, big_y, n_d, n_e, kinetic, potential, _, _ = evaluate(y, coef, lane, width, with_load)
    c_x, c_y = y[lane], y[width + lane]
    x, w = coef[_LENGTH * width + lane] * big_x, coef[_LENGTH * width + lane] * big_y
    return x * c_x, x * c_y, -w * c_y, w * c_x, n_d, n_e, n_d, n_e, kinetic, potential, w * w
