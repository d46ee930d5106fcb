"""Any body and load, free to move: mass matrix, its inverse, and the forces that depend on pose and speeds.

Kane's equations for the speeds (o', w', sigma), sigma = Omega/kappa, all vectors by their components in the frame (f1, f2, e)
of the smallest rotation from Z to e (README, "Model"), in which the body is turned by chi. Lengths of the body over L, J over
m L^2:

    omega = kappa W,   W = sum_k W_k w_k' + e sigma,   W_k = n e x (x_k - (e.x_k) e)
    M_ok = x_h.(W_k x r_C),  M_kl = W_k.J W_l,  M_oo = I
    omega'_0/kappa = -2 rho W_w + Omega W_w x e,   a_C0 = omega'_0/kappa x r_C + omega x (W x r_C)
    f_o = (F - a_C0)_h,   f_k = W_k.(moment about O - J omega'_0/kappa - omega x J W)

o is eliminated first (its block is I), then sigma: what is left is 2 x 2.
"""

from __future__ import annotations

import math

from tolmc.kernels import parameters as P
from tolmc.kernels.jit import device
from tolmc.kernels.one_sided import layout as at

SPINS = True
SWINGS = False
STATE = 11
COEFFICIENTS = at.FIRST + 22

(
    _RX, _RY, _RZ, _JXX, _JYY, _JZZ, _JXY, _JXZ, _JYZ,
    _AX, _AY, _AZ, _KX, _KY, _KZ, _PX, _PY, _PZ, _TX, _TY, _TZ, _UNUSED,
) = range(at.FIRST, at.FIRST + 22)  # fmt: skip


@device
def prepare(raw, given, coef, lane, width):
    """Coefficients of lane ``lane``; those of the joint are there already."""
    mass, length = raw[P.MASS * width + lane], raw[P.HALF_LENGTH * width + lane]
    c = coef[at.C * width + lane]
    for axis in range(3):
        coef[(_RX + axis) * width + lane] = raw[(P.COM_X + axis) * width + lane] / length
        coef[(_AX + axis) * width + lane] = raw[(P.GRAVITY_X + axis) * width + lane] / c
        coef[(_KX + axis) * width + lane] = raw[(P.FORCE_X + axis) * width + lane] / (mass * c)
        coef[(_PX + axis) * width + lane] = raw[(P.POINT_X + axis) * width + lane] / length
        coef[(_TX + axis) * width + lane] = raw[(P.TORQUE_X + axis) * width + lane] / (mass * c * length)
    for entry in range(6):
        coef[(_JXX + entry) * width + lane] = raw[(P.J_XX + entry) * width + lane] / (mass * length * length)


@device
def orient(y, given, lane, width):
    """The part of the start that belongs to the turn about the axis."""
    chi = given[at.CHI * width + lane]
    y[at.COS * width + lane], y[at.SIN * width + lane] = math.cos(chi), math.sin(chi)


@device
def _cross(ax, ay, az, bx, by, bz):
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@device
def _times(j, x, y, z):
    xx, yy, zz, xy, xz, yz = j
    return xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z


@device
def _body(y, coef, lane, width):
    """(e_x, e_y, n, rho, F11, F12, F22, r_C, J, W_w, p): pose, frame, and the body in it."""
    wx, wy = y[at.W_X * width + lane], y[at.W_Y * width + lane]
    vx, vy = y[at.WV_X * width + lane], y[at.WV_Y * width + lane]
    cos, sin = y[at.COS * width + lane], y[at.SIN * width + lane]
    kappa, kappa2 = coef[at.KAPPA * width + lane], coef[at.KAPPA2 * width + lane]
    n2 = 1.0 / (1.0 + kappa2 * (wx * wx + wy * wy))
    n = math.sqrt(n2)
    rho = kappa2 * n2 * (wx * vx + wy * vy)
    e_x, e_y = kappa * n * wx, kappa * n * wy
    fold = 1.0 / (1.0 + n)
    f11, f12, f22 = 1.0 - e_x * e_x * fold, -e_x * e_y * fold, 1.0 - e_y * e_y * fold
    rx, ry = coef[_RX * width + lane], coef[_RY * width + lane]
    r = (cos * rx - sin * ry, sin * rx + cos * ry, coef[_RZ * width + lane])
    px, py = coef[_PX * width + lane], coef[_PY * width + lane]
    p = (cos * px - sin * py, sin * px + cos * py, coef[_PZ * width + lane])
    jxx, jyy, jxy = coef[_JXX * width + lane], coef[_JYY * width + lane], coef[_JXY * width + lane]
    jxz, jyz = coef[_JXZ * width + lane], coef[_JYZ * width + lane]
    cos2, sin2 = cos * cos - sin * sin, 2.0 * cos * sin
    mean, half = 0.5 * (jxx + jyy), 0.5 * (jxx - jyy)
    deviation = cos2 * half - sin2 * jxy
    j = (
        mean + deviation, mean - deviation, coef[_JZZ * width + lane],
        sin2 * half + cos2 * jxy, cos * jxz - sin * jyz, sin * jxz + cos * jyz,
    )  # fmt: skip
    w1, w2 = -n * (f12 * vx + f22 * vy), n * (f11 * vx + f12 * vy)
    return e_x, e_y, n, rho, f11, f12, f22, r, j, w1, w2, p


@device
def _in_frame(x, y, z, e_x, e_y, n, f11, f12, f22):
    """A vector of fixed axes by its components along f1, f2, e."""
    return f11 * x + f12 * y - e_x * z, f12 * x + f22 * y - e_y * z, e_x * x + e_y * y + n * z


@device
def free(y, spin, coef, lane, width):
    """As :func:`solve`, of the forces that act without contact, and what it needs for others."""
    none = (0.0, 0.0, 0.0)
    return moved(y, spin, None, none, none, none, none, coef, lane, width)


@device
def moved(y, spin, spun, force, turned_force, torque, turned_torque, coef, lane, width):
    """:func:`free` where Omega/kappa changes at the rate ``spun`` (None: as it will, or not at all), under more loads.

    Forces over m c at the force's point and torques over m c L: by their components in fixed axes, and those that turn with the
    body in the frame.
    """
    e_x, e_y, n, rho, f11, f12, f22, r, j, w1, w2, p = _body(y, coef, lane, width)
    kappa = coef[at.KAPPA * width + lane]
    r1, r2, r3 = r
    w3 = spin / kappa
    # Velocity terms.
    b1, b2 = -2.0 * rho * w1 + spin * w2, -2.0 * rho * w2 - spin * w1
    q1, q2, q3 = _cross(w1, w2, w3, r1, r2, r3)
    c1, c2, c3 = _cross(w1, w2, w3, q1, q2, q3)
    d1, d2, d3 = _cross(b1, b2, 0.0, r1, r2, r3)
    a1, a2, a3 = -(d1 + kappa * c1), -(d2 + kappa * c2), -(d3 + kappa * c3)
    h1, h2, h3 = _times(j, w1, w2, w3)
    g1, g2, g3 = _cross(w1, w2, w3, h1, h2, h3)
    h1, h2, h3 = _times(j, b1, b2, 0.0)
    n1, n2, n3 = -(h1 + kappa * g1), -(h2 + kappa * g2), -(h3 + kappa * g3)
    # Loads.
    g1, g2, g3 = _in_frame(
        coef[_AX * width + lane], coef[_AY * width + lane], coef[_AZ * width + lane], e_x, e_y, n, f11, f12, f22
    )
    k1, k2, k3 = _in_frame(
        coef[_KX * width + lane] + force[0], coef[_KY * width + lane] + force[1], coef[_KZ * width + lane] + force[2],
        e_x, e_y, n, f11, f12, f22,
    )  # fmt: skip
    t1, t2, t3 = _in_frame(
        coef[_TX * width + lane] + torque[0], coef[_TY * width + lane] + torque[1], coef[_TZ * width + lane] + torque[2],
        e_x, e_y, n, f11, f12, f22,
    )  # fmt: skip
    k1, k2, k3 = k1 + turned_force[0], k2 + turned_force[1], k3 + turned_force[2]
    t1, t2, t3 = t1 + turned_torque[0], t2 + turned_torque[1], t3 + turned_torque[2]
    m1, m2, m3 = _cross(r1, r2, r3, g1, g2, g3)
    l1, l2, l3 = _cross(p[0], p[1], p[2], k1, k2, k3)
    a1, a2, a3 = a1 + g1 + k1, a2 + g2 + k2, a3 + g3 + k3
    n1, n2, n3 = n1 + m1 + l1 + t1, n2 + m2 + l2 + t2, n3 + m3 + l3 + t3
    fx, fy = f11 * a1 + f12 * a2 + e_x * a3, f12 * a1 + f22 * a2 + e_y * a3
    # W_u = n (-f12, f11, 0), W_v = n (-f22, f12, 0)
    gx, gy = n * (f11 * n2 - f12 * n1), n * (f12 * n2 - f22 * n1)

    # The mass matrix without its block for o, which is I.
    u1, u2, v1, v2 = -n * f12, n * f11, -n * f22, n * f12
    uu1, uu2, uu3 = _cross(u1, u2, 0.0, r1, r2, r3)
    vv1, vv2, vv3 = _cross(v1, v2, 0.0, r1, r2, r3)
    ux, uy = f11 * uu1 + f12 * uu2 + e_x * uu3, f12 * uu1 + f22 * uu2 + e_y * uu3
    vx, vy = f11 * vv1 + f12 * vv2 + e_x * vv3, f12 * vv1 + f22 * vv2 + e_y * vv3
    sx, sy = f12 * r1 - f11 * r2, f22 * r1 - f12 * r2
    ju1, ju2, ju3 = _times(j, u1, u2, 0.0)
    jv1, jv2, jv3 = _times(j, v1, v2, 0.0)
    m_uu = u1 * ju1 + u2 * ju2 - ux * ux - uy * uy
    m_uv = u1 * jv1 + u2 * jv2 - ux * vx - uy * vy
    m_vv = v1 * jv1 + v2 * jv2 - vx * vx - vy * vy
    m_us, m_vs = ju3 - ux * sx - uy * sy, jv3 - vx * sx - vy * sy
    # Where a drive holds Omega its row and column are those of an infinite inertia.
    driven = coef[at.DRIVEN * width + lane]
    inverse_ss = (1.0 - driven) / (j[2] - sx * sx - sy * sy)
    ku, kv = m_us * inverse_ss, m_vs * inverse_ss
    m_uu, m_uv, m_vv = m_uu - ku * m_us, m_uv - ku * m_vs, m_vv - kv * m_vs
    inverse = 1.0 / (m_uu * m_vv - m_uv * m_uv)
    factors = (
        ux,
        uy,
        vx,
        vy,
        sx,
        sy,
        ku,
        kv,
        inverse_ss,
        m_vv * inverse,
        -m_uv * inverse,
        m_uu * inverse,
        ju3,
        jv3,
        driven,
    )
    if spun is None:
        ax, ay, bx, by, s, hold = solve(fx, fy, gx, gy, n3, factors)
    else:
        # What the drive gives to Omega is known: its terms go to the other side.
        fx, fy = fx - sx * spun, fy - sy * spun
        gx, gy = gx - ju3 * spun, gy - jv3 * spun
        ax, ay, bx, by, s, hold = solve(fx, fy, gx, gy, n3 - j[2] * spun, factors)
        s += spun
    return ax, ay, bx, by, s, hold, factors


@device
def solve(fx, fy, gx, gy, gs, factors):
    """M^-1 times the generalised forces on o, w and Omega/kappa, and what holds Omega where a drive does."""
    ux, uy, vx, vy, sx, sy, ku, kv, inverse_ss, i_uu, i_uv, i_vv, m_us, m_vs, driven = factors
    given = gs
    gs = gs - sx * fx - sy * fy
    gx = gx - ux * fx - uy * fy - ku * gs
    gy = gy - vx * fx - vy * fy - kv * gs
    bx, by = i_uu * gx + i_uv * gy, i_uv * gx + i_vv * gy
    s = gs * inverse_ss - ku * bx - kv * by
    ax, ay = fx - ux * bx - vx * by - sx * s, fy - uy * bx - vy * by - sy * s
    return ax, ay, bx, by, s, driven * (sx * ax + sy * ay + m_us * bx + m_vs * by - given)


@device
def energies(y, spin, spins, coef, lane, width):
    """T, V and the torque's power."""
    e_x, e_y, n, _, f11, f12, f22, r, j, w1, w2, p = _body(y, coef, lane, width)
    kappa = coef[at.KAPPA * width + lane]
    ox, oy = y[at.O_X * width + lane], y[at.O_Y * width + lane]
    ux, uy = y[at.OV_X * width + lane], y[at.OV_Y * width + lane]
    w3 = spin / kappa
    q1, q2, q3 = _cross(w1, w2, w3, r[0], r[1], r[2])
    h1, h2, h3 = _times(j, w1, w2, w3)
    kinetic = 0.5 * (ux * ux + uy * uy + w1 * h1 + w2 * h2 + w3 * h3)
    kinetic += ux * (f11 * q1 + f12 * q2 + e_x * q3) + uy * (f12 * q1 + f22 * q2 + e_y * q3)
    gx, gy, gz = coef[_AX * width + lane], coef[_AY * width + lane], coef[_AZ * width + lane]
    kx, ky, kz = coef[_KX * width + lane], coef[_KY * width + lane], coef[_KZ * width + lane]
    g1, g2, g3 = _in_frame(gx, gy, gz, e_x, e_y, n, f11, f12, f22)
    k1, k2, k3 = _in_frame(kx, ky, kz, e_x, e_y, n, f11, f12, f22)
    t1, t2, t3 = _in_frame(
        coef[_TX * width + lane], coef[_TY * width + lane], coef[_TZ * width + lane], e_x, e_y, n, f11, f12, f22
    )
    arms = r[0] * g1 + r[1] * g2 + r[2] * g3 + p[0] * k1 + p[1] * k2 + p[2] * k3
    potential = -(ox * (gx + kx) + oy * (gy + ky) + arms / kappa)
    return kinetic, potential, w1 * t1 + w2 * t2 + w3 * t3


@device
def momentum(y, spin, coef, lane, width):
    """Angular momentum about Z, that of a unit turn about Z, over m c^2, and 0: no part is left out.

    A unit turn is o' = Jo, W = Z/kappa.
    """
    e_x, e_y, n, _, f11, f12, f22, r, j, w1, w2, _ = _body(y, coef, lane, width)
    per_kappa = 1.0 / coef[at.KAPPA * width + lane]
    jx, jy = -y[at.O_Y * width + lane], y[at.O_X * width + lane]
    ux, uy = y[at.OV_X * width + lane], y[at.OV_Y * width + lane]
    w3, z1, z2, z3 = spin * per_kappa, -e_x * per_kappa, -e_y * per_kappa, n * per_kappa
    q1, q2, q3 = _cross(w1, w2, w3, r[0], r[1], r[2])
    qx, qy = f11 * q1 + f12 * q2 + e_x * q3, f12 * q1 + f22 * q2 + e_y * q3
    q1, q2, q3 = _cross(z1, z2, z3, r[0], r[1], r[2])
    tx, ty = f11 * q1 + f12 * q2 + e_x * q3, f12 * q1 + f22 * q2 + e_y * q3
    h1, h2, h3 = _times(j, z1, z2, z3)
    about_z = jx * (ux + qx) + jy * (uy + qy) + ux * tx + uy * ty + w1 * h1 + w2 * h2 + w3 * h3
    unit = jx * jx + jy * jy + 2.0 * (jx * tx + jy * ty) + z1 * h1 + z2 * h2 + z3 * h3
    return about_z, unit, 0.0


@device
def turn(y, spin, h, k, first, coef, lane, width):
    """h times the rates of cos(chi) and sin(chi): chi' = Omega + kappa^2 n^2 (w x w')/(1 + n)."""
    wx, wy = y[at.W_X * width + lane], y[at.W_Y * width + lane]
    vx, vy = y[at.WV_X * width + lane], y[at.WV_Y * width + lane]
    kappa2 = coef[at.KAPPA2 * width + lane]
    n2 = 1.0 / (1.0 + kappa2 * (wx * wx + wy * wy))
    rate = h * (spin + kappa2 * n2 * (wx * vy - wy * vx) / (1.0 + math.sqrt(n2)))
    k[first + at.COS * width + lane] = -rate * y[at.SIN * width + lane]
    k[first + at.SIN * width + lane] = rate * y[at.COS * width + lane]


@device
def normalise(y, coef, lane, width):
    """Back to cos^2 + sin^2 = 1."""
    cos, sin = y[at.COS * width + lane], y[at.SIN * width + lane]
    to_1 = 1.0 / math.sqrt(cos * cos + sin * sin)
    y[at.COS * width + lane], y[at.SIN * width + lane] = to_1 * cos, to_1 * sin
