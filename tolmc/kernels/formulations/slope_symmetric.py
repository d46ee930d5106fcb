"""Body symmetric about its axis, in slope coordinates reduced to the motions that keep contact.

o = (X0, Y0)/r and w = (u, v)/r satisfy |o|^2 + |w|^2 = 1 and o.w = 0: with sigma and delta half the sum and half the
difference of the polar angles of D and E, o = cos(delta) (cos(sigma), sin(sigma)) and w = sin(delta) (-sin(sigma),
cos(sigma)). Every velocity that keeps contact has two speeds, s = sigma' and d = delta':

    o' = J (s o + d w),  w' = J (s w + d o),  J(x, y) = (-y, x)

The spin Omega is constant and the spin angle plays no part. Lagrange's equations for the momenta P_s = a11 s + a12 d and
P_d = a12 s + a22 d, divided by m r^2, with p = |o|^2, q = |w|^2, h = o x w = sin(2 delta)/2, kappa = r^2/L^2,
y = 1/(1 + kappa q), n = sqrt(y) = cos(tilt), B = A/(m L^2), Z = z_C/L, Gamma = C Omega/(m L^2):

    a11 = p + B q y,  a22 = q + B p y^2,  a12 = Z n (p y + q)
    P_s' = Q_sigma + h d Gamma n y
    P_d' = Q_delta + h (a11_q s^2 + 2 a12_q s d + a22_q d^2 - s Gamma n y)
    a11_q = B y^2 - 1,  a22_q = 1 - B y^2 (1 + 2 kappa p y),  2 a12_q = Z kappa n y (q - 3 p y)

Momenta and not speeds: a right-hand side takes a fifth less arithmetic, and at equal steps the error is a third. The
spin's own part of P_s, Gamma (n - 1)/kappa, is left out: at small clearance it would drown the rest. No difference of
nearly equal numbers is left at any clearance.

The axes X and Y are turned so that G_y = 0, G = sum z_i F_i the moment of the loads' resultants (F_y = 0 where G = 0).
"""

from __future__ import annotations

import math

from tolmc.kernels import parameters as P
from tolmc.kernels.jit import device
from tolmc.kernels.roots import inverse_root

STATE = 6  # o_x, o_y, w_x, w_y, P_s, P_d
COEFFICIENTS = 18
TORQUE = False
RUBS = False

# Rows of the coefficients: kappa, 2 kappa, B, Z, kappa Z, Gamma, F/(m r), G_x/(m r L) and G_z/(m r^2), kappa times these two,
# m r/2, m r^2, half of that, r, and the cosine and sine of the turn of the axes.
(
    KAPPA, KAPPA_2, B, Z, KAPPA_Z, GAMMA, FX, FY, GX, GZ, KAPPA_GX, KAPPA_GZ,
    HALF_FORCE, ENERGY, HALF_ENERGY, R, COS, SIN,
) = range(COEFFICIENTS)  # fmt: skip

_TINY = 1e-140  # below it a vector has no direction: the squares of its components are no longer full numbers


@device
def prepare(raw, i, coef, lane, width):
    """Coefficients of lane ``lane`` from column ``i`` of the parameters."""
    r, length, mass = raw[P.RADIUS, i], raw[P.HALF_LENGTH, i], raw[P.MASS, i]
    z, z_force = raw[P.COM_Z, i], raw[P.POINT_Z, i] / mass
    per_inertia = 1.0 / (mass * length * length)
    kappa = (r / length) ** 2
    coef[KAPPA * width + lane], coef[KAPPA_2 * width + lane] = kappa, 2.0 * kappa
    coef[B * width + lane] = raw[P.J_XX, i] * per_inertia
    coef[Z * width + lane], coef[KAPPA_Z * width + lane] = z / length, kappa * z / length
    coef[GAMMA * width + lane] = raw[P.J_ZZ, i] * raw[P.SPIN_RATE, i] * per_inertia
    fx = (raw[P.GRAVITY_X, i] + raw[P.FORCE_X, i] / mass) / r
    fy = (raw[P.GRAVITY_Y, i] + raw[P.FORCE_Y, i] / mass) / r
    gx = (z * raw[P.GRAVITY_X, i] + z_force * raw[P.FORCE_X, i]) / (r * length)
    gy = (z * raw[P.GRAVITY_Y, i] + z_force * raw[P.FORCE_Y, i]) / (r * length)
    moment, force = math.sqrt(gx * gx + gy * gy), math.sqrt(fx * fx + fy * fy)
    cos_t, sin_t = 1.0, 0.0
    if moment > _TINY:
        cos_t, sin_t = gx / moment, gy / moment
    elif force > _TINY:
        cos_t, sin_t = fx / force, fy / force
    coef[FX * width + lane], coef[FY * width + lane] = cos_t * fx + sin_t * fy, cos_t * fy - sin_t * fx
    gz = (z * raw[P.GRAVITY_Z, i] + z_force * raw[P.FORCE_Z, i]) / (r * r)
    coef[GX * width + lane], coef[KAPPA_GX * width + lane] = moment, kappa * moment
    coef[GZ * width + lane], coef[KAPPA_GZ * width + lane] = gz, kappa * gz
    coef[HALF_FORCE * width + lane] = 0.5 * mass * r
    coef[ENERGY * width + lane], coef[HALF_ENERGY * width + lane] = mass * r * r, 0.5 * mass * r * r
    coef[R * width + lane] = r
    coef[COS * width + lane], coef[SIN * width + lane] = cos_t, sin_t


@device
def start(raw, i, y, coef, lane, width):
    """State at t = 0 from the polar angles and their rates."""
    cos_m, sin_m, cos_d, sin_d = raw[P.COS_MEAN, i], raw[P.SIN_MEAN, i], raw[P.COS_HALF, i], raw[P.SIN_HALF, i]
    cos_t, sin_t = coef[COS * width + lane], coef[SIN * width + lane]
    cos_s, sin_s = cos_m * cos_t + sin_m * sin_t, sin_m * cos_t - cos_m * sin_t
    y[lane], y[width + lane] = cos_d * cos_s, cos_d * sin_s
    y[2 * width + lane], y[3 * width + lane] = -sin_d * sin_s, sin_d * cos_s
    y[4 * width + lane], y[5 * width + lane] = momenta(raw, i, cos_d, sin_d, coef, lane, width)


@device
def momenta(raw, i, cos_d, sin_d, coef, lane, width):
    """P_s and P_d at t = 0 from the rates of the polar angles."""
    s = 0.5 * (raw[P.ALPHA_RATE, i] + raw[P.BETA_RATE, i])
    d = 0.5 * (raw[P.ALPHA_RATE, i] - raw[P.BETA_RATE, i])
    p, q, inertia = cos_d * cos_d, sin_d * sin_d, coef[B * width + lane]
    y = 1.0 / (1.0 + coef[KAPPA * width + lane] * q)
    a12 = coef[Z * width + lane] * math.sqrt(y) * (p * y + q)
    return (p + inertia * q * y) * s + a12 * d, a12 * s + (q + inertia * p * y * y) * d


@device
def reduced(
    posed,
    momentum_s,
    momentum_d,
    gamma,
    transverse,
    f_o,
    f_w,
    jf_o,
    jf_w,
    ox,
    wx,
    oy,
    wy,
    coef,
    lane,
    width,
    with_load,
):
    """The equations without friction, from what :func:`of_pose` has, the momenta and Gamma.

    (s, d, P_s', P_d', v_s, v_d, S_0, D_0, T, V): s' = (a22 v_s - a12 v_d)/det and d' = (a11 v_d - a12 v_s)/det; with S, D =
    (lambda_D +- lambda_E)/(m r), the residuals of the equations of motion along the radii,

        S = h (d' (B y^2 - 1) - Z kappa n q y s') + S_0,  D = h (s' (1 - B y) - Z kappa n q y d') + D_0
        S_0 = Gamma n q y s - d^2 (p + B q y^2 (1 + 2 kappa p y)) - s^2 (p + B q y^2) - 2 Z n y s d
              - f.o - n y g.w + kappa n q y g_z
        D_0 = Gamma n p y d - 2 s d (q + B p y^2) - Z n (d^2 (p + q y (1 + 3 kappa p y)) + s^2) - f.w - n g.o

    T without the constant C Omega^2/2; T, V over m r^2. The last are n, B y, B y^2 - 1, Z kappa n q y, and a11, a22, a12 with
    the inverse of their determinant. The forces enter by f.o, f.w and the turned f.Jo, f.Jw with f = F/(m r); the pose itself
    only by its products with G_x; without ``transverse`` load both play no part. What a caller does not use is not computed.
    """
    p, q, h, n = posed
    inertia, z = coef[B * width + lane], coef[Z * width + lane]
    y = n * n
    py, ny, zn = p * y, n * y, z * n
    iy = inertia * y
    iy2 = iy * y
    a11, a22, a12 = p + iy * q, q + iy2 * p, zn * (py + q)
    inverse = 1.0 / (a11 * a22 - a12 * a12)
    s = (a22 * momentum_s - a12 * momentum_d) * inverse
    d = (a11 * momentum_d - a12 * momentum_s) * inverse

    force_s, force_d, tip = 0.0, 0.0, 0.0
    load_sum, load_difference, potential = 0.0, 0.0, 0.0
    if with_load:
        axial = coef[KAPPA_GZ * width + lane]
        if transverse:
            gx = coef[GX * width + lane]
            ngx, gwx = n * gx, gx * wx
            force_s, force_d = jf_o - ngx * wy, jf_w - ngx * oy
            load_sum, load_difference = f_o + ny * (gwx - q * axial), f_w + ngx * ox
            potential = -(f_o + n * (coef[GZ * width + lane] + gwx))
            axial += coef[KAPPA_GX * width + lane] * wx
        else:
            load_sum = -ny * (q * axial)
            potential = -n * coef[GZ * width + lane]
        tip = ny * axial

    twist, kzny = gamma * ny, coef[KAPPA_Z * width + lane] * ny
    bow = kzny * q
    stretch = 1.0 + coef[KAPPA_2 * width + lane] * py
    a11_q, a12_q2, a22_q = iy2 - 1.0, kzny * (q - (py + py + py)), 1.0 - iy2 * stretch
    hd, s2, d2, s_pull, d_pull = h * d, s * s, d * d, a11_q * s, a22_q * (d * d)
    drift = a12_q2 * d - twist
    pull = s_pull + drift
    rate_s, rate_d = force_s + hd * twist, force_d + h * (s * pull + (d_pull - tip))
    v_s, v_d = force_s - hd * (pull + s_pull), force_d + h * (s * (s_pull - twist) - (d_pull + tip))

    zny = z * ny
    iqy2, qy = iy2 * q, q * y
    outward = twist * q - (zny + zny) * d - s * (p + iqy2)
    total = s * outward - d2 * (p + iqy2 * stretch) - load_sum
    difference = d * (twist * p - (s + s) * a22) - zn * (d2 * (p + qy * (1.5 * stretch - 0.5)) + s2) - load_difference
    kinetic = 0.5 * (s * momentum_s + d * momentum_d)
    return (
        s, d, rate_s, rate_d, v_s, v_d, total, difference, kinetic, potential,
        (n, iy, a11_q, bow, a11, a22, a12, inverse),
    )  # fmt: skip


@device
def dynamics(
    posed, momentum_s, momentum_d, transverse, f_o, f_w, jf_o, jf_w, ox, wx, oy, wy, coef, lane, width, with_load
):
    """(s, d, P_s', P_d', N_D, N_E, lambda_D, lambda_E, T, V), SI units, from what :func:`reduced` takes.

    N = -lambda sqrt(1 + kappa q^2), the same factor at both ends because D.e_h = -E.e_h.
    """
    s, d, rate_s, rate_d, v_s, v_d, total, difference, kinetic, potential, elements = reduced(
        posed, momentum_s, momentum_d, coef[GAMMA * width + lane], transverse,
        f_o, f_w, jf_o, jf_w, ox, wx, oy, wy, coef, lane, width, with_load,
    )  # fmt: skip
    _, q, h, _ = posed
    _, iy, a11_q, bow, a11, a22, a12, inverse = elements
    s_rate, d_rate, hi = v_s * a22 - v_d * a12, v_d * a11 - v_s * a12, h * inverse
    total += hi * (d_rate * a11_q - bow * s_rate)
    difference += hi * (s_rate * (1.0 - iy) - bow * d_rate)
    half = coef[HALF_FORCE * width + lane]
    normal = -half * math.sqrt(1.0 + coef[KAPPA * width + lane] * q * q)
    inward_d, inward_e = total + difference, total - difference
    kinetic = coef[HALF_ENERGY * width + lane] * (s * momentum_s + d * momentum_d)
    return (
        s, d, rate_s, rate_d, normal * inward_d, normal * inward_e, half * inward_d, half * inward_e,
        kinetic, coef[ENERGY * width + lane] * potential,
    )  # fmt: skip


@device
def of_pose(p, q, h, coef, lane, width):
    """What a pose determines: p, q, h, n."""
    return p, q, h, inverse_root(1.0 + coef[KAPPA * width + lane] * q)


@device
def pose(y, coef, lane, width):
    """What the pose of one lane determines."""
    ox, oy, wx, wy = y[lane], y[width + lane], y[2 * width + lane], y[3 * width + lane]
    return of_pose(ox * ox + oy * oy, wx * wx + wy * wy, ox * wy - oy * wx, coef, lane, width)


@device
def hold(posed, held, at, width):
    """What a pose determines, to rows from ``at`` on."""
    held[at], held[at + width], held[at + 2 * width], held[at + 3 * width] = posed


@device
def held_pose(held, at, width):
    """The same again."""
    return held[at], held[at + width], held[at + 2 * width], held[at + 3 * width]


@device
def from_pose(y, posed, coef, lane, width, with_load):
    """What :func:`evaluate` returns, from what :func:`pose` has."""
    ox, oy, wx, wy = y[lane], y[width + lane], y[2 * width + lane], y[3 * width + lane]
    fx, fy = coef[FX * width + lane], coef[FY * width + lane]
    s, d, rate_s, rate_d, n_d, n_e, lambda_d, lambda_e, kinetic, potential = dynamics(
        posed, y[4 * width + lane], y[5 * width + lane], True,
        fx * ox + fy * oy, fx * wx + fy * wy, fy * ox - fx * oy, fy * wx - fx * wy,
        ox, wx, oy, wy, coef, lane, width, with_load,
    )  # fmt: skip
    return s, d, rate_s, rate_d, n_d, n_e, lambda_d, lambda_e, kinetic, potential, posed[1]


@device
def evaluate(y, coef, lane, width, with_load):
    """(s, d, P_s', P_d', N_D, N_E, lambda_D, lambda_E, T, V, q) of one lane."""
    return from_pose(y, pose(y, coef, lane, width), coef, lane, width, with_load)


@device
def turn(k, first, half_d, half_e, ox, oy, wx, wy, lane, width):
    """h o' and h w' from h/2 times the angular speeds of D = o + w and E = o - w, which are s + d and s - d.

    J (s o + d w) takes eight products, this four: products and sums are not the same units of a processor.
    """
    dx, dy, ex, ey = half_d * (ox + wx), half_d * (oy + wy), half_e * (ox - wx), half_e * (oy - wy)
    k[first + lane], k[first + width + lane] = -(dy + ey), dx + ex
    k[first + 2 * width + lane], k[first + 3 * width + lane] = ey - dy, dx - ex


@device
def begin(y, held, coef, lane, width, with_load):
    """The first part of a right-hand side: what the pose determines."""
    hold(pose(y, coef, lane, width), held, STATE * width + lane, width)


@device
def finish(y, held, coef, h, k, first, lane, width, with_load):
    """The last: h y' into ``k[first:]``; returns N_D, N_E, |w|^2, T, V and the power of the torque (none here)."""
    s, d, rate_s, rate_d, n_d, n_e, _, _, kinetic, potential, q = from_pose(
        y, held_pose(held, STATE * width + lane, width), coef, lane, width, with_load
    )
    ox, oy, wx, wy = y[lane], y[width + lane], y[2 * width + lane], y[3 * width + lane]
    turn(k, first, 0.5 * h * (s + d), 0.5 * h * (s - d), ox, oy, wx, wy, lane, width)
    k[first + 4 * width + lane] = h * rate_s
    k[first + 5 * width + lane] = h * rate_d
    r = coef[R * width + lane]
    return n_d, n_e, r * r * q, kinetic, potential, 0.0


@device
def rate_of_w2(y, k, coef, lane, width):
    """The rate of |w|^2, over a step, with h y' in ``k``."""
    wx, wy, r = y[2 * width + lane], y[3 * width + lane], coef[R * width + lane]
    return 2.0 * r * r * (wx * k[2 * width + lane] + wy * k[3 * width + lane])


@device
def sense(y, held, coef, lane, width, with_load):
    """N_D, N_E in place of the last part."""
    _, _, _, _, n_d, n_e, _, _, _, _, _ = from_pose(
        y, held_pose(held, STATE * width + lane, width), coef, lane, width, with_load
    )
    return n_d, n_e


HELD, PARTS = 4, (begin, finish)


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
def momentum(y, coef, lane, width):
    """Angular momentum about Z less the constant C Omega, kg m^2/s; that of a unit turn about Z, kg m^2; and |C Omega|.

    C Omega (n - 1) = -C Omega kappa q y/(1 + n).
    """
    ox, oy, wx, wy = y[lane], y[width + lane], y[2 * width + lane], y[3 * width + lane]
    return momentum_about_z(ox * ox + oy * oy, wx * wx + wy * wy, y[4 * width + lane], coef, lane, width)


@device
def momentum_about_z(p, q, momentum_s, coef, lane, width):
    """:func:`momentum` from the invariants of the pose and P_s."""
    kappa, gamma, joule = coef[KAPPA * width + lane], coef[GAMMA * width + lane], coef[ENERGY * width + lane]
    y = 1.0 / (1.0 + kappa * q)
    turned = joule * (momentum_s - gamma * q * y / (1.0 + math.sqrt(y)))
    return turned, joule * (p + coef[B * width + lane] * q * y), joule * abs(gamma) / kappa


@device
def scale_speeds(y, factor, lane, width):
    """Multiply the speeds, and so the momenta, by ``factor``: the projection on the energy."""
    y[4 * width + lane] *= factor
    y[5 * width + lane] *= factor


@device
def motion(y, coef, lane, width):
    """(O_x, O_y, u, v, O_x', O_y', u', v', 0, 0) of one lane, SI units, in the axes of the scene."""
    s, d, _, _, _, _, _, _, _, _, _ = evaluate(y, coef, lane, width, False)
    r = coef[R * width + lane]
    cos_t, sin_t = r * coef[COS * width + lane], r * coef[SIN * width + lane]
    ox, oy, wx, wy = y[lane], y[width + lane], y[2 * width + lane], y[3 * width + lane]
    ux, uy, vx, vy = -(s * oy + d * wy), s * ox + d * wx, -(s * wy + d * oy), s * wx + d * ox
    return (
        cos_t * ox - sin_t * oy, sin_t * ox + cos_t * oy, cos_t * wx - sin_t * wy, sin_t * wx + cos_t * wy,
        cos_t * ux - sin_t * uy, sin_t * ux + cos_t * uy, cos_t * vx - sin_t * vy, sin_t * vx + cos_t * vy, 0.0, 0.0,
    )  # fmt: skip


@device
def observe(y, coef, lane, width, with_load):
    """(O_x, O_y, u, v, N_D, N_E, lambda_D, lambda_E, T, V, |w|^2) of one lane, SI units, in the axes of the scene."""
    _, _, _, _, n_d, n_e, lambda_d, lambda_e, kinetic, potential, q = evaluate(y, coef, lane, width, with_load)
    r = coef[R * width + lane]
    cos_t, sin_t = r * coef[COS * width + lane], r * coef[SIN * width + lane]
    ox, oy, wx, wy = y[lane], y[width + lane], y[2 * width + lane], y[3 * width + lane]
    return (
        cos_t * ox - sin_t * oy, sin_t * ox + cos_t * oy, cos_t * wx - sin_t * wy, sin_t * wx + cos_t * wy,
        n_d, n_e, lambda_d, lambda_e, kinetic, potential, r * r * q,
    )  # fmt: skip
