"""Body symmetric about its axis, in slope coordinates reduced to the motions that keep contact.

o = (X0, Y0)/r and w = (u, v)/r satisfy |o|^2 + |w|^2 = 1 and o.w = 0: with sigma and delta half the sum and half the
difference of the polar angles of D and E, o = cos(delta) (cos(sigma), sin(sigma)) and w = sin(delta) (-sin(sigma),
cos(sigma)). Every velocity that keeps contact has two speeds, s = sigma' and d = delta':

    o' = J (s o + d w),  w' = J (s w + d o),  J(x, y) = (-y, x)

The spin Omega is constant and the spin angle plays no part. Lagrange's equations, divided by m r^2, with p = |o|^2,
q = |w|^2, h = o x w = sin(2 delta)/2, kappa = r^2/L^2, y = 1/(1 + kappa q), n = sqrt(y) = cos(tilt), B = A/(m L^2),
Z = z_C/L, Gamma = C Omega/(m L^2):

    a11 = p + B q y,  a22 = q + B p y^2,  a12 = Z n (p y + q)
    a11 s' + a12 d' = Q_sigma - 2 h d (a11_q s + a12_q d - Gamma n y/2)
    a12 s' + a22 d' = Q_delta + 2 h ((a11_q s^2 - a22_q d^2)/2 - Gamma n y s/2)
    a11_q = B y^2 - 1,  a22_q = 1 - B y^2 (1 + 2 kappa p y),  a12_q = Z kappa n y (q - 3 p y)/2

No difference of nearly equal numbers is left at any clearance. y and the determinant share one division; with the square
root of 1 + kappa q that is all the slow arithmetic of an evaluation.
"""

from __future__ import annotations

import math

from tolmc.kernels import parameters as P
from tolmc.kernels.jit import device

STATE = 6  # o_x, o_y, w_x, w_y, s, d
COEFFICIENTS = 12

# Rows of the coefficients: kappa, B, Z, Gamma, F/(m r), G/(m r L) and G_z/(m r^2) with G = sum z_i F_i, m r, m r^2, r.
_KAPPA, _B, _Z, _GAMMA, _FX, _FY, _GX, _GY, _GZ, _FORCE, _ENERGY, _R = range(COEFFICIENTS)


@device
def prepare(raw, i, coef, lane, width):
    """Coefficients of lane ``lane`` from column ``i`` of the parameters."""
    r, length, mass = raw[P.RADIUS, i], raw[P.HALF_LENGTH, i], raw[P.MASS, i]
    z, z_force = raw[P.COM_Z, i], raw[P.POINT_Z, i] / mass
    per_inertia = 1.0 / (mass * length * length)
    coef[_KAPPA * width + lane] = (r / length) ** 2
    coef[_B * width + lane] = raw[P.J_XX, i] * per_inertia
    coef[_Z * width + lane] = z / length
    coef[_GAMMA * width + lane] = raw[P.J_ZZ, i] * raw[P.SPIN_RATE, i] * per_inertia
    for axis in range(2):
        gravity, force = raw[P.GRAVITY_X + axis, i], raw[P.FORCE_X + axis, i]
        coef[(_FX + axis) * width + lane] = (gravity + force / mass) / r
        coef[(_GX + axis) * width + lane] = (z * gravity + z_force * force) / (r * length)
    coef[_GZ * width + lane] = (z * raw[P.GRAVITY_Z, i] + z_force * raw[P.FORCE_Z, i]) / (r * r)
    coef[_FORCE * width + lane] = mass * r
    coef[_ENERGY * width + lane] = mass * r * r
    coef[_R * width + lane] = r


@device
def start(raw, i, y, lane, width):
    """State at t = 0 from the polar angles and their rates."""
    sigma = 0.5 * (raw[P.ALPHA, i] + raw[P.BETA, i])
    delta = 0.5 * (raw[P.ALPHA, i] - raw[P.BETA, i])
    y[lane] = math.cos(delta) * math.cos(sigma)
    y[width + lane] = math.cos(delta) * math.sin(sigma)
    y[2 * width + lane] = -math.sin(delta) * math.sin(sigma)
    y[3 * width + lane] = math.sin(delta) * math.cos(sigma)
    y[4 * width + lane] = 0.5 * (raw[P.ALPHA_RATE, i] + raw[P.BETA_RATE, i])
    y[5 * width + lane] = 0.5 * (raw[P.ALPHA_RATE, i] - raw[P.BETA_RATE, i])


@device
def dynamics(p, q, h, s, d, transverse, jf_o, jf_w, jg_o, jg_w, f_o, f_w, g_o, g_w, coef, lane, width, with_load):
    """(s', d', N_D, N_E, lambda_D, lambda_E, T, V) from the invariants p, q, h of a pose and the speeds.

    The loads enter by their products with the pose, f_o = f.o, jf_o = f.Jo and so on with f = F/(m r), g = G/(m r L);
    without ``transverse`` load they play no part. With S, D = (lambda_D +- lambda_E)/(m r), the residuals of the equations
    of motion along the radii,

        S = h (d' (B y^2 - 1) - Z kappa n q y s') - d^2 (p + B q y^2 (1 + 2 kappa p y)) - s^2 (p + B q y^2)
            + Gamma n q y s - 2 Z n y s d - f.o - n y g.w + kappa n q y g_z
        D = h (s' (1 - B y) - Z kappa n q y d') - 2 s d (q + B p y^2) + Gamma n p y d
            - Z n (d^2 (p + q y (1 + 3 kappa p y)) + s^2) - f.w - n g.o

    and N = -lambda sqrt(1 + kappa q^2), the same factor at both ends because D.e_h = -E.e_h. T without the constant
    C Omega^2/2. N, J; what a caller does not use is not computed.
    """
    kappa, inertia, z = coef[_KAPPA * width + lane], coef[_B * width + lane], coef[_Z * width + lane]
    gamma = coef[_GAMMA * width + lane]
    stretch = 1.0 + kappa * q
    root = math.sqrt(stretch)
    stretch2 = stretch * stretch
    b11, b22, b12 = p * stretch + inertia * q, q * stretch2 + inertia * p, z * (p + q * stretch)
    det = b11 * b22 - b12 * b12
    inverse = 1.0 / (stretch * det)
    y = inverse * det
    n = root * y
    y2, ny = y * y, n * y
    a11, a22, a12 = b11 * y, b22 * y2, b12 * ny
    inverse_det = inverse * (stretch2 * stretch2)

    py, iy2 = p * y, inertia * y2
    bend = 2.0 * kappa * py
    twist = 0.5 * gamma * ny
    a11_q, a22_q, a12_q = iy2 - 1.0, 1.0 - iy2 - iy2 * bend, 0.5 * z * kappa * ny * (q - 3.0 * py)
    h2, s2, d2 = 2.0 * h, s * s, d * d
    v_s = -h2 * d * (a11_q * s + a12_q * d - twist)
    v_d = h2 * (0.5 * (a11_q * s2 - a22_q * d2) - twist * s)
    load_sum, load_difference, potential = 0.0, 0.0, 0.0
    if with_load:
        axial = coef[_GZ * width + lane]
        knyh = kappa * ny * h
        if transverse:
            v_s += jf_o + n * jg_w
            v_d += jf_w + n * jg_o - knyh * (g_w + axial)
            load_sum = f_o + ny * g_w - kappa * ny * q * axial
            load_difference = f_w + n * g_o
            potential = -(f_o + n * (g_w + axial))
        else:
            v_d -= knyh * axial
            load_sum = -kappa * ny * q * axial
            potential = -n * axial
    s_rate = (v_s * a22 - v_d * a12) * inverse_det
    d_rate = (v_d * a11 - v_s * a12) * inverse_det

    qy = q * y
    bow = z * kappa * n * qy
    total = (
        h * (d_rate * a11_q - bow * s_rate)
        - d2 * (p + inertia * qy * y * (1.0 + bend))
        - s2 * (p + inertia * qy * y)
        + s * (gamma * n * qy - 2.0 * z * ny * d)
        - load_sum
    )
    difference = (
        h * (s_rate * (1.0 - inertia * y) - bow * d_rate)
        - 2.0 * s * d * (q + iy2 * p)
        + gamma * n * py * d
        - z * n * (d2 * (p + qy * (1.0 + 1.5 * bend)) + s2)
        - load_difference
    )
    half = 0.5 * coef[_FORCE * width + lane]
    lambda_d, lambda_e = half * (total + difference), half * (total - difference)
    normal = math.sqrt(1.0 + kappa * q * q)
    joule = coef[_ENERGY * width + lane]
    kinetic = joule * (0.5 * (a11 * s2 + a22 * d2) + a12 * s * d)
    return s_rate, d_rate, -lambda_d * normal, -lambda_e * normal, lambda_d, lambda_e, kinetic, joule * potential


@device
def evaluate(y, coef, lane, width, with_load):
    """(s', d', N_D, N_E, lambda_D, lambda_E, q, T, V) of one lane."""
    ox, oy, wx, wy = y[lane], y[width + lane], y[2 * width + lane], y[3 * width + lane]
    fx, fy = coef[_FX * width + lane], coef[_FY * width + lane]
    gx, gy = coef[_GX * width + lane], coef[_GY * width + lane]
    q = wx * wx + wy * wy
    s_rate, d_rate, n_d, n_e, lambda_d, lambda_e, kinetic, potential = dynamics(
        ox * ox + oy * oy, q, ox * wy - oy * wx, y[4 * width + lane], y[5 * width + lane], True,
        fy * ox - fx * oy, fy * wx - fx * wy, gy * ox - gx * oy, gy * wx - gx * wy,
        fx * ox + fy * oy, fx * wx + fy * wy, gx * ox + gy * oy, gx * wx + gy * wy, coef, lane, width, with_load,
    )  # fmt: skip
    return s_rate, d_rate, n_d, n_e, lambda_d, lambda_e, q, kinetic, potential


@device
def advance(y, coef, h, k, first, lane, width, with_load):
    """h y' into ``k[first:]``; returns N_D, N_E, |w|^2 (m^2) and the power of the torque (none here)."""
    s_rate, d_rate, n_d, n_e, _, _, q, _, _ = evaluate(y, coef, lane, width, with_load)
    ox, oy, wx, wy = y[lane], y[width + lane], y[2 * width + lane], y[3 * width + lane]
    s, d = h * y[4 * width + lane], h * y[5 * width + lane]
    k[first + lane] = -(s * oy + d * wy)
    k[first + width + lane] = s * ox + d * wx
    k[first + 2 * width + lane] = -(s * wy + d * oy)
    k[first + 3 * width + lane] = s * wx + d * ox
    k[first + 4 * width + lane] = h * s_rate
    k[first + 5 * width + lane] = h * d_rate
    r = coef[_R * width + lane]
    return n_d, n_e, r * r * q, 0.0


@device
def _to_unit(square):
    """1/sqrt(square) near 1 by two Newton steps: without a division and a root, and exact for the drift of a usable step.

    What a coarser step leaves shows in the constraint error: 1e-12 from a drift of 1e-3, 2e-5 from one of 5e-2.
    """
    factor = 1.5 - 0.5 * square
    return factor * (1.5 - 0.5 * square * factor * factor)


@device
def project(y, coef, lane, width):
    """Back to |o + w| = |o - w| = 1; the velocities are tangent as they stand. Returns the constraint error left."""
    ox, oy, wx, wy = y[lane], y[width + lane], y[2 * width + lane], y[3 * width + lane]
    dx, dy, ex, ey = ox + wx, oy + wy, ox - wx, oy - wy
    to_d, to_e = 0.5 * _to_unit(dx * dx + dy * dy), 0.5 * _to_unit(ex * ex + ey * ey)
    ox, oy, wx, wy = to_d * dx + to_e * ex, to_d * dy + to_e * ey, to_d * dx - to_e * ex, to_d * dy - to_e * ey
    y[lane], y[width + lane], y[2 * width + lane], y[3 * width + lane] = ox, oy, wx, wy
    return 0.5 * abs(ox * ox + oy * oy + wx * wx + wy * wy - 1.0) + abs(ox * wx + oy * wy)


@device
def scale_speeds(y, factor, lane, width):
    """Multiply the speeds by ``factor``: the projection on the energy."""
    y[4 * width + lane] *= factor
    y[5 * width + lane] *= factor


@device
def observe(y, coef, lane, width, with_load):
    """(O_x, O_y, u, v, N_D, N_E, lambda_D, lambda_E, T, V, |w|^2) of one lane, SI units."""
    _, _, n_d, n_e, lambda_d, lambda_e, q, kinetic, potential = evaluate(y, coef, lane, width, with_load)
    r = coef[_R * width + lane]
    return (
        r * y[lane], r * y[width + lane], r * y[2 * width + lane], r * y[3 * width + lane],
        n_d, n_e, lambda_d, lambda_e, kinetic, potential, r * r * q,
    )  # fmt: skip
