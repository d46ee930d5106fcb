"""General body (centre of mass and inertia anywhere, any load) in slope coordinates reduced to the two circles.

State (D, E, a, b, cos chi, sin chi, Omega): as in :mod:`slope_symmetric`, with the body's turn chi about its axis and its
rate Omega. Kane's equations for the speeds (a, b, Omega), all vectors in body axes b1, b2, e:

    sum_k [m O_j.O_k + O_j.(omega_k x m r_C) + (omega_j x m r_C).O_k + omega_j.J omega_k] s_k' = Q_j - bias_j
    O_a = (JD)/2, O_b = (JE)/2, omega_a = e x (JD)/(2 l), omega_b = -e x (JE)/(2 l), O_Omega = 0, omega_Omega = e

omega_a and omega_b have no component along e, which keeps the products short. The multipliers are the equations' residual
along the radial virtual velocities (O, w) = (D, D)/(2 r) and (E, -E)/(2 r).
"""

from __future__ import annotations

import math

from tolmc.kernels import parameters as P
from tolmc.kernels.formulations import slope_symmetric
from tolmc.kernels.jit import device

STATE = 9  # D_x, D_y, E_x, E_y, a, b, cos chi, sin chi, Omega
COEFFICIENTS = 26
TORQUE = True
RUBS = False

(
    _R2, _INVERSE_R, _L, _INVERSE_RL, _MASS,
    _SX, _SY, _SZ,
    _JXX, _JYY, _JZZ, _JXY, _JXZ, _JYZ,
    _GX, _GY, _GZ, _FX, _FY, _FZ, _PX, _PY, _PZ, _TX, _TY, _TZ,
) = range(COEFFICIENTS)  # fmt: skip


@device
def prepare(raw, i, coef, lane, width):
    """Coefficients of lane ``lane`` from column ``i`` of the parameters."""
    r, length, mass = raw[P.RADIUS, i], raw[P.HALF_LENGTH, i], raw[P.MASS, i]
    coef[_R2 * width + lane] = r * r
    coef[_INVERSE_R * width + lane] = 1.0 / r
    coef[_L * width + lane] = length
    coef[_INVERSE_RL * width + lane] = 1.0 / (r * length)
    coef[_MASS * width + lane] = mass
    for axis in range(3):
        coef[(_SX + axis) * width + lane] = mass * raw[P.COM_X + axis, i]
        coef[(_GX + axis) * width + lane] = mass * raw[P.GRAVITY_X + axis, i]
        coef[(_FX + axis) * width + lane] = raw[P.FORCE_X + axis, i]
        coef[(_PX + axis) * width + lane] = raw[P.POINT_X + axis, i]
        coef[(_TX + axis) * width + lane] = raw[P.TORQUE_X + axis, i]
    for entry in range(6):
        coef[(_JXX + entry) * width + lane] = raw[P.J_XX + entry, i]


@device
def start(raw, i, y, coef, lane, width):
    """State at t = 0 from the polar angles, their rates, the spin and its rate."""
    r, alpha, beta = raw[P.RADIUS, i], raw[P.ALPHA, i], raw[P.BETA, i]
    y[lane] = r * math.cos(alpha)
    y[width + lane] = r * math.sin(alpha)
    y[2 * width + lane] = r * math.cos(beta)
    y[3 * width + lane] = r * math.sin(beta)
    y[4 * width + lane] = raw[P.ALPHA_RATE, i]
    y[5 * width + lane] = raw[P.BETA_RATE, i]
    y[6 * width + lane] = math.cos(raw[P.SPIN, i])
    y[7 * width + lane] = math.sin(raw[P.SPIN, i])
    y[8 * width + lane] = raw[P.SPIN_RATE, i]


@device
def _dot(ax, ay, az, bx, by, bz):
    return ax * bx + ay * by + az * bz


@device
def _cross(ax, ay, az, bx, by, bz):
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@device
def _pose(y, coef, lane, width):
    """|w|^2, 1/(L^2 + |w|^2), its root and 1/(1 + e_z)."""
    u, v, length = (
        0.5 * (y[lane] - y[2 * width + lane]),
        0.5 * (y[width + lane] - y[3 * width + lane]),
        coef[_L * width + lane],
    )
    w2 = u * u + v * v
    inverse2 = 1.0 / (length * length + w2)
    inverse = math.sqrt(inverse2)
    return w2, inverse2, inverse, 1.0 / (1.0 + length * inverse)


@device
def _from_pose(y, posed, coef, lane, width, with_load):
    """What :func:`evaluate` returns, from what the pose determines."""
    w2, inverse2, inverse, fold = posed
    dx, dy, ex, ey = y[lane], y[width + lane], y[2 * width + lane], y[3 * width + lane]
    a, b = y[4 * width + lane], y[5 * width + lane]
    cos_chi, sin_chi, spin = y[6 * width + lane], y[7 * width + lane], y[8 * width + lane]
    length, mass = coef[_L * width + lane], coef[_MASS * width + lane]
    sx, sy, sz = coef[_SX * width + lane], coef[_SY * width + lane], coef[_SZ * width + lane]
    jxx, jyy, jzz = coef[_JXX * width + lane], coef[_JYY * width + lane], coef[_JZZ * width + lane]
    jxy, jxz, jyz = coef[_JXY * width + lane], coef[_JXZ * width + lane], coef[_JYZ * width + lane]

    u, v = 0.5 * (dx - ex), 0.5 * (dy - ey)
    axis_x, axis_y, axis_z = u * inverse, v * inverse, length * inverse
    # Frame of the smallest rotation from Z to e, turned by chi: rows of b1, b2 in fixed axes.
    f1x, f1y, f1z = 1.0 - axis_x * axis_x * fold, -axis_x * axis_y * fold, -axis_x
    f2x, f2y, f2z = f1y, 1.0 - axis_y * axis_y * fold, -axis_y
    b1x, b1y, b1z = (
        cos_chi * f1x + sin_chi * f2x,
        cos_chi * f1y + sin_chi * f2y,
        cos_chi * f1z + sin_chi * f2z,
    )
    b2x, b2y, b2z = (
        cos_chi * f2x - sin_chi * f1x,
        cos_chi * f2y - sin_chi * f1y,
        cos_chi * f2z - sin_chi * f1z,
    )

    # Partial velocities in body axes; e x w has the components (-w.b2, w.b1, 0).
    oa1, oa2, oa3 = (
        0.5 * (dx * b1y - dy * b1x),
        0.5 * (dx * b2y - dy * b2x),
        0.5 * (dx * axis_y - dy * axis_x),
    )
    ob1, ob2, ob3 = (
        0.5 * (ex * b1y - ey * b1x),
        0.5 * (ex * b2y - ey * b2x),
        0.5 * (ex * axis_y - ey * axis_x),
    )
    wa1, wa2 = -oa2 * inverse, oa1 * inverse
    wb1, wb2 = ob2 * inverse, -ob1 * inverse
    # omega_j x m r_C
    ca1, ca2, ca3 = wa2 * sz, -wa1 * sz, wa1 * sy - wa2 * sx
    cb1, cb2, cb3 = wb2 * sz, -wb1 * sz, wb1 * sy - wb2 * sx
    # J omega_j
    ja1, ja2, ja3 = jxx * wa1 + jxy * wa2, jxy * wa1 + jyy * wa2, jxz * wa1 + jyz * wa2
    jb1, jb2, jb3 = jxx * wb1 + jxy * wb2, jxy * wb1 + jyy * wb2, jxz * wb1 + jyz * wb2
    o_aa = _dot(oa1, oa2, oa3, oa1, oa2, oa3)
    o_bb = _dot(ob1, ob2, ob3, ob1, ob2, ob3)
    o_ab = _dot(oa1, oa2, oa3, ob1, ob2, ob3)
    m_aa = mass * o_aa + 2.0 * _dot(oa1, oa2, oa3, ca1, ca2, ca3) + wa1 * ja1 + wa2 * ja2
    m_bb = mass * o_bb + 2.0 * _dot(ob1, ob2, ob3, cb1, cb2, cb3) + wb1 * jb1 + wb2 * jb2
    m_ab = mass * o_ab + _dot(oa1, oa2, oa3, cb1, cb2, cb3) + _dot(ca1, ca2, ca3, ob1, ob2, ob3) + wa1 * jb1 + wa2 * jb2
    m_as = oa2 * sx - oa1 * sy + ja3  # e x m r_C = (-s_y, s_x, 0)
    m_bs = ob2 * sx - ob1 * sy + jb3

    # Velocity terms: O'' and omega' without the unknown accelerations.
    w1, w2_rate, w3 = a * wa1 + b * wb1, a * wa2 + b * wb2, spin
    e1, e2 = w2_rate, -w1  # e' = omega x e in body axes
    rho = (u * 0.5 * (b * ey - a * dy) + v * 0.5 * (a * dx - b * ex)) * inverse2
    a2, b2 = a * a, b * b
    po_x, po_y = -0.5 * (dx * a2 + ex * b2), -0.5 * (dy * a2 + ey * b2)
    pw_x, pw_y = -0.5 * (dx * a2 - ex * b2), -0.5 * (dy * a2 - ey * b2)
    bo1, bo2, bo3 = po_x * b1x + po_y * b1y, po_x * b2x + po_y * b2y, po_x * axis_x + po_y * axis_y
    pw1, pw2 = (pw_x * b1x + pw_y * b1y) * inverse, (pw_x * b2x + pw_y * b2y) * inverse
    # omega' = e x (w''/l - 2 rho e') + Omega e'
    bw1 = -(pw2 - 2.0 * rho * e2) + spin * e1
    bw2 = (pw1 - 2.0 * rho * e1) + spin * e2

    h1 = jxx * w1 + jxy * w2_rate + jxz * w3
    h2 = jxy * w1 + jyy * w2_rate + jyz * w3
    h3 = jxz * w1 + jyz * w2_rate + jzz * w3
    g1, g2, g3 = _cross(w1, w2_rate, w3, h1, h2, h3)
    q1, q2, q3 = _cross(w1, w2_rate, w3, sx, sy, sz)
    c1, c2, c3 = _cross(w1, w2_rate, w3, q1, q2, q3)
    t1, t2, t3 = _cross(bw1, bw2, 0.0, sx, sy, sz)
    f1, f2, f3 = mass * bo1 + t1 + c1, mass * bo2 + t2 + c2, mass * bo3 + t3 + c3
    s1, s2, s3 = _cross(sx, sy, sz, bo1, bo2, bo3)
    n1 = s1 + jxx * bw1 + jxy * bw2 + g1
    n2 = s2 + jxy * bw1 + jyy * bw2 + g2
    n3 = s3 + jxz * bw1 + jyz * bw2 + g3
    potential, power = 0.0, 0.0
    if with_load:
        gx, gy, gz = coef[_GX * width + lane], coef[_GY * width + lane], coef[_GZ * width + lane]
        fx, fy, fz = coef[_FX * width + lane], coef[_FY * width + lane], coef[_FZ * width + lane]
        px, py, pz = coef[_PX * width + lane], coef[_PY * width + lane], coef[_PZ * width + lane]
        tx, ty, tz = coef[_TX * width + lane], coef[_TY * width + lane], coef[_TZ * width + lane]
        gb1, gb2, gb3 = (
            _dot(gx, gy, gz, b1x, b1y, b1z),
            _dot(gx, gy, gz, b2x, b2y, b2z),
            _dot(gx, gy, gz, axis_x, axis_y, axis_z),
        )
        fb1, fb2, fb3 = (
            _dot(fx, fy, fz, b1x, b1y, b1z),
            _dot(fx, fy, fz, b2x, b2y, b2z),
            _dot(fx, fy, fz, axis_x, axis_y, axis_z),
        )
        tb1, tb2, tb3 = (
            _dot(tx, ty, tz, b1x, b1y, b1z),
            _dot(tx, ty, tz, b2x, b2y, b2z),
            _dot(tx, ty, tz, axis_x, axis_y, axis_z),
        )
        inverse_mass = 1.0 / mass
        mg1, mg2, mg3 = _cross(sx * inverse_mass, sy * inverse_mass, sz * inverse_mass, gb1, gb2, gb3)
        mf1, mf2, mf3 = _cross(px, py, pz, fb1, fb2, fb3)
        f1, f2, f3 = f1 - gb1 - fb1, f2 - gb2 - fb2, f3 - gb3 - fb3
        n1, n2, n3 = n1 - mg1 - mf1 - tb1, n2 - mg2 - mf2 - tb2, n3 - mg3 - mf3 - tb3
        origin = 0.5 * ((dx + ex) * (gx + fx) + (dy + ey) * (gy + fy))
        lever = _dot(sx, sy, sz, gb1, gb2, gb3) * inverse_mass + _dot(px, py, pz, fb1, fb2, fb3)
        potential = -(origin + lever)
        power = w1 * tb1 + w2_rate * tb2 + w3 * tb3

    r_a = -(_dot(oa1, oa2, oa3, f1, f2, f3) + wa1 * n1 + wa2 * n2)
    r_b = -(_dot(ob1, ob2, ob3, f1, f2, f3) + wb1 * n1 + wb2 * n2)
    r_s = -n3
    # The spin's row is eliminated first: J_zz > 0 for every body on a journal.
    inverse_jzz = 1.0 / jzz
    k_a, k_b = m_as * inverse_jzz, m_bs * inverse_jzz
    n_aa, n_ab, n_bb = m_aa - k_a * m_as, m_ab - k_a * m_bs, m_bb - k_b * m_bs
    v_a, v_b = r_a - k_a * r_s, r_b - k_b * r_s
    inverse_det = 1.0 / (n_aa * n_bb - n_ab * n_ab)
    a_rate = (v_a * n_bb - v_b * n_ab) * inverse_det
    b_rate = (v_b * n_aa - v_a * n_ab) * inverse_det
    spin_rate = (r_s - m_as * a_rate - m_bs * b_rate) * inverse_jzz

    # Whole residual force at O and moment about O, then its radial parts.
    oo1, oo2, oo3 = oa1 * a_rate + ob1 * b_rate, oa2 * a_rate + ob2 * b_rate, oa3 * a_rate + ob3 * b_rate
    ww1, ww2, ww3 = wa1 * a_rate + wb1 * b_rate, wa2 * a_rate + wb2 * b_rate, spin_rate
    t1, t2, t3 = _cross(ww1, ww2, ww3, sx, sy, sz)
    s1, s2, s3 = _cross(sx, sy, sz, oo1, oo2, oo3)
    f1, f2, f3 = f1 + mass * oo1 + t1, f2 + mass * oo2 + t2, f3 + mass * oo3 + t3
    n1 = n1 + s1 + jxx * ww1 + jxy * ww2 + jxz * ww3
    n2 = n2 + s2 + jxy * ww1 + jyy * ww2 + jyz * ww3
    # (n x e)/l has the components (n2, -n1, 0)/l; the horizontal parts of the residual at D and at E:
    m1, m2 = n2 * inverse, -n1 * inverse
    rd1, rd2, re1, re2 = f1 + m1, f2 + m2, f1 - m1, f2 - m2
    rd_x, rd_y = rd1 * b1x + rd2 * b2x + f3 * axis_x, rd1 * b1y + rd2 * b2y + f3 * axis_y
    re_x, re_y = re1 * b1x + re2 * b2x + f3 * axis_x, re1 * b1y + re2 * b2y + f3 * axis_y
    half_inverse_r = 0.5 * coef[_INVERSE_R * width + lane]
    lambda_d = half_inverse_r * (dx * rd_x + dy * rd_y)
    lambda_e = half_inverse_r * (ex * re_x + ey * re_y)
    slant = w2 * coef[_INVERSE_RL * width + lane]
    normal = math.sqrt(1.0 + slant * slant)

    chi_rate = spin + (u * 0.5 * (a * dx - b * ex) + v * 0.5 * (a * dy - b * ey)) * inverse2 * fold
    kinetic = 0.5 * (m_aa * a2 + m_bb * b2 + jzz * spin * spin + 2.0 * (m_ab * a * b + (m_as * a + m_bs * b) * spin))
    return (
        a_rate, b_rate, spin_rate, chi_rate, -lambda_d * normal, -lambda_e * normal, lambda_d, lambda_e, w2,
        kinetic, potential, power,
        (m_aa + m_ab) * a + (m_ab + m_bb) * b + (m_as + m_bs) * spin + axis_z * (m_as * a + m_bs * b + jzz * spin),
        m_aa + 2.0 * m_ab + m_bb + axis_z * (2.0 * (m_as + m_bs) + axis_z * jzz),
    )  # fmt: skip


@device
def evaluate(y, coef, lane, width, with_load):
    """(a', b', Omega', chi', N_D, N_E, lambda_D, lambda_E, |w|^2, T, V, power, momentum about Z, that of a unit turn).

    Of one lane, SI units. A unit turn about Z has the speeds a = b = 1, Omega = e_z.
    """
    return _from_pose(y, _pose(y, coef, lane, width), coef, lane, width, with_load)


@device
def begin(y, held, coef, lane, width, with_load):
    """The first part of a right-hand side: what the pose determines."""
    slope_symmetric.hold(_pose(y, coef, lane, width), held, STATE * width + lane, width)


@device
def finish(y, held, coef, h, k, first, lane, width, with_load):
    """The last: h y' into ``k[first:]``; returns N_D, N_E, |w|^2, T, V and the power of the torque."""
    a_rate, b_rate, spin_rate, chi_rate, n_d, n_e, _, _, w2, kinetic, potential, power, _, _ = _from_pose(
        y, slope_symmetric.held_pose(held, STATE * width + lane, width), coef, lane, width, with_load
    )
    a, b = h * y[4 * width + lane], h * y[5 * width + lane]
    k[first + lane] = -a * y[width + lane]
    k[first + width + lane] = a * y[lane]
    k[first + 2 * width + lane] = -b * y[3 * width + lane]
    k[first + 3 * width + lane] = b * y[2 * width + lane]
    k[first + 4 * width + lane] = h * a_rate
    k[first + 5 * width + lane] = h * b_rate
    k[first + 6 * width + lane] = -h * chi_rate * y[7 * width + lane]
    k[first + 7 * width + lane] = h * chi_rate * y[6 * width + lane]
    k[first + 8 * width + lane] = h * spin_rate
    return n_d, n_e, w2, kinetic, potential, power


@device
def rate_of_w2(y, k, coef, lane, width):
    """The rate of |w|^2, over a step, with h y' in ``k``."""
    u, u_rate = y[lane] - y[2 * width + lane], k[lane] - k[2 * width + lane]
    v, v_rate = y[width + lane] - y[3 * width + lane], k[width + lane] - k[3 * width + lane]
    return 0.5 * (u * u_rate + v * v_rate)


@device
def sense(y, held, coef, lane, width, with_load):
    """N_D, N_E in place of the last part."""
    _, _, _, _, n_d, n_e, _, _, _, _, _, _, _, _ = _from_pose(
        y, slope_symmetric.held_pose(held, STATE * width + lane, width), coef, lane, width, with_load
    )
    return n_d, n_e


HELD, PARTS = 4, (begin, finish)


@device
def project(y, coef, lane, width):
    """Back to |D| = |E| = r and cos^2 + sin^2 = 1; the velocities are tangent as they stand. Returns the error left."""
    dx, dy, ex, ey = y[lane], y[width + lane], y[2 * width + lane], y[3 * width + lane]
    cos_chi, sin_chi = y[6 * width + lane], y[7 * width + lane]
    r2 = coef[_R2 * width + lane]
    to_d = math.sqrt(r2 / (dx * dx + dy * dy))
    to_e = math.sqrt(r2 / (ex * ex + ey * ey))
    to_1 = 1.0 / math.sqrt(cos_chi * cos_chi + sin_chi * sin_chi)
    dx, dy, ex, ey = to_d * dx, to_d * dy, to_e * ex, to_e * ey
    y[lane], y[width + lane], y[2 * width + lane], y[3 * width + lane] = dx, dy, ex, ey
    y[6 * width + lane], y[7 * width + lane] = to_1 * cos_chi, to_1 * sin_chi
    return 0.5 * max(abs(dx * dx + dy * dy - r2), abs(ex * ex + ey * ey - r2)) / r2


@device
def momentum(y, coef, lane, width):
    """Angular momentum about Z, kg m^2/s; that of a unit turn about Z, kg m^2; and 0: no part is left out."""
    _, _, _, _, _, _, _, _, _, _, _, _, about_z, turn = evaluate(y, coef, lane, width, False)
    return about_z, turn, 0.0


@device
def scale_speeds(y, factor, lane, width):
    """Multiply the speeds by ``factor``: the projection on the energy."""
    y[4 * width + lane] *= factor
    y[5 * width + lane] *= factor
    y[8 * width + lane] *= factor


@device
def motion(y, coef, lane, width):
    """(O_x, O_y, u, v, O_x', O_y', u', v', chi, Omega) of one lane, SI units."""
    dx, dy, ex, ey = 0.5 * y[lane], 0.5 * y[width + lane], 0.5 * y[2 * width + lane], 0.5 * y[3 * width + lane]
    a, b = y[4 * width + lane], y[5 * width + lane]
    return (
        dx + ex, dy + ey, dx - ex, dy - ey, -a * dy - b * ey, a * dx + b * ex, b * ey - a * dy, a * dx - b * ex,
        math.atan2(y[7 * width + lane], y[6 * width + lane]), y[8 * width + lane],
    )  # fmt: skip


@device
def observe(y, coef, lane, width, with_load):
    """(O_x, O_y, u, v, N_D, N_E, lambda_D, lambda_E, T, V, |w|^2) of one lane."""
    _, _, _, _, n_d, n_e, lambda_d, lambda_e, w2, kinetic, potential, _, _, _ = evaluate(
        y, coef, lane, width, with_load
    )
    dx, dy, ex, ey = y[lane], y[width + lane], y[2 * width + lane], y[3 * width + lane]
    return (
        0.5 * (dx + ex), 0.5 * (dy + ey), 0.5 * (dx - ex), 0.5 * (dy - ey),
        n_d, n_e, lambda_d, lambda_e, kinetic, potential, w2,
    )  # fmt: skip
