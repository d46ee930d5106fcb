"""The symmetric body of :mod:`slope_symmetric` with friction at both rims, free to spin or driven.

With kappa_1 = r/L, q' = sqrt(1 + kappa q^2), rho = r*/(r q') and e = kappa_1 n h, the contact points slide along the axis and
around it with

    v_e = e (s + rho (s - d)),  v_b = -(s + d) n q' - Omega r*/r     at D,
    v_e = -e (s + rho (s + d)), v_b = -(s - d) n q' - Omega r*/r     at E

in units of r, and the friction per unit normal force is F = -mu v/sqrt(|v|^2 + slip^2) (regularised Coulomb). By the same
virtual velocities it works on s, d and Omega; along the radii it adds, at D and at E, to the residuals S and D

    -F_e e rho q/h + F_b g,  F_e e (q - rho p)/h + F_b g   and   -F_e e rho q/h - F_b g,  -F_e e (q - rho p)/h + F_b g,

g = kappa n q h/q'. The normal forces that the motion would have without friction are therefore those that it has times a matrix
K, which is 1 without friction: N_0 = K N. The matrix of the contacts' accelerations is A = A_0 K, A_0 that without friction.
"""

from __future__ import annotations

import math

from tolmc.kernels import parameters as P
from tolmc.kernels.formulations import slope_symmetric as plain
from tolmc.kernels.jit import device
from tolmc.kernels.roots import inverse_root

STATE, SPIN = 7, 6  # o_x, o_y, w_x, w_y, P_s, P_d, Omega r*/r
COEFFICIENTS = plain.COEFFICIENTS + 8
TORQUE = True
RUBS = True

# rho* = r*/r, C/(m L^2 rho*), -m r^2 rho*^2/C where the spin is free, -Omega where a drive holds it, mu, the square of the slip
# speed over r, r/L, and 1/(B - Z^2).
_ROUND, _GYRO, _SPUN, _HELD, _MU, _SLIP, _KAPPA_1, _INVERSE_B = range(plain.COEFFICIENTS, COEFFICIENTS)

# What the parts of a right-hand side hold for the next, in rows after the state's: of the pose, of the speeds, of the forces.
_POSE, _NORMAL, _SLIDE, _PRESS, HELD = STATE, STATE + 4, STATE + 5, STATE + 16, 22

_LEAST = 1e-36  # least square of a slip speed over r: det K, which may be as small, still has an inverse


@device
def prepare(raw, i, coef, lane, width):
    """Coefficients of lane ``lane`` from column ``i`` of the parameters."""
    plain.prepare(raw, i, coef, lane, width)
    r, length, mass = raw[P.RADIUS, i], raw[P.HALF_LENGTH, i], raw[P.MASS, i]
    spin, held, round_ = raw[P.J_ZZ, i], raw[P.HELD, i], raw[P.JOURNAL_RADIUS, i] / r
    coef[_ROUND * width + lane], coef[_GYRO * width + lane] = round_, spin / (mass * length * length * round_)
    coef[_SPUN * width + lane] = -mass * (r * round_) ** 2 / spin if spin > 0.0 and held == 0.0 else 0.0
    coef[_HELD * width + lane] = -held * raw[P.SPIN_RATE, i]
    coef[_MU * width + lane] = raw[P.FRICTION, i]
    coef[_SLIP * width + lane] = max((raw[P.SLIP_SPEED, i] / r) ** 2, _LEAST)
    coef[_KAPPA_1 * width + lane] = r / length
    coef[_INVERSE_B * width + lane] = 1.0 / (coef[plain.B * width + lane] - coef[plain.Z * width + lane] ** 2)


@device
def start(raw, i, y, coef, lane, width):
    """State at t = 0 from the polar angles, their rates and the spin rate."""
    plain.start(raw, i, y, coef, lane, width)
    y[SPIN * width + lane] = raw[P.SPIN_RATE, i] * coef[_ROUND * width + lane]


@device
def pressed(p, q, k1, coef, lane, width):
    """(a_DD, a_EE, a_DE) of A_0 = G M^-1 G^T by the equations in o and w, both rows of unit size; k1 = Z n.

    With s = P^-1 f_w - k1 f_o for f = (D, D): a_w = (1 + kappa q)(s - i_2 (w.s) w)/(B - Z^2), a_o = f_o - k1 P a_w; at E the
    same with -w, and so with -k1, in place of w.
    """
    kappa, z2 = coef[plain.KAPPA * width + lane], coef[plain.Z * width + lane] ** 2
    g = 1.0 + kappa * q
    i1, i2 = g * coef[_INVERSE_B * width + lane], z2 * kappa / (coef[plain.B * width + lane] * g - z2)
    ky = kappa / g
    own, ws = 1.0 - k1 + kappa * q * q, q * (1.0 - k1) + kappa * q * q
    other = (1.0 - k1) * (p - q) - kappa * q * q
    wa = i1 * ws * (1.0 - i2 * q)
    da, ea = i1 * (own - i2 * ws * q), i1 * (other + i2 * ws * q)
    a_dd = 1.0 + (1.0 - k1) * da + k1 * ky * q * wa
    a_de = p - q - (1.0 + k1) * ea - k1 * ky * q * wa
    own, ws = 1.0 + k1 + kappa * q * q, q * (1.0 + k1) + kappa * q * q
    wa = i1 * ws * (1.0 - i2 * q)
    a_ee = 1.0 + (1.0 + k1) * i1 * (own - i2 * ws * q) - k1 * ky * q * wa
    return a_dd, a_ee, a_de


@device
def pose(y, coef, lane, width):
    """What the pose alone determines, and 1/q'."""
    posed = plain.pose(y, coef, lane, width)
    q = posed[1]
    return posed, inverse_root(1.0 + coef[plain.KAPPA * width + lane] * q * q)


@device
def slide(y, posed, inverse_normal, coef, lane, width, with_load):
    """What the speeds determine, and the normal forces over both slip speeds, times det K.

    (s, d, P_s' and P_d' without friction, v_D and v_E along the axis and around it, near, further, around); (sqrt(|v|^2 +
    slip^2) at D and E, the unknowns, 1/det K, q'/2); (T, V over m r^2, k1, the elements of K).
    """
    ox, oy, wx, wy = y[lane], y[width + lane], y[2 * width + lane], y[3 * width + lane]
    turn = y[SPIN * width + lane]
    fx, fy = coef[plain.FX * width + lane], coef[plain.FY * width + lane]
    p, q, h, _ = posed
    kappa, kappa_1, round_ = (
        coef[plain.KAPPA * width + lane],
        coef[_KAPPA_1 * width + lane],
        coef[_ROUND * width + lane],
    )
    kq = kappa * q
    s, d, rate_s, rate_d, v_s, v_d, total, difference, kinetic, potential, elements = plain.reduced(
        posed, y[4 * width + lane], y[5 * width + lane], coef[_GYRO * width + lane] * turn, True,
        fx * ox + fy * oy, fx * wx + fy * wy, fy * ox - fx * oy, fy * wx - fx * wy,
        ox, wx, oy, wy, coef, lane, width, with_load,
    )  # fmt: skip
    n, iy, a11_q, bow, a11, a22, a12, inverse = elements
    normal = (1.0 + kq * q) * inverse_normal
    rho, kn, nh = round_ * inverse_normal, kappa_1 * n, n * h
    e, over = kn * h, nh * inverse_normal
    further, around, half = e * rho, n * normal, 0.5 * normal
    near = e + further
    by_s, by_d = near * s, further * d
    ve_d, ve_e = by_s - by_d, -(by_s + by_d)
    by_s, by_d = -around * s - turn, around * d
    vb_d, vb_e = by_s - by_d, by_s + by_d
    slip, size = coef[_SLIP * width + lane], coef[_MU * width + lane] * half
    swift_d, swift_e = math.sqrt(ve_d * ve_d + vb_d * vb_d + slip), math.sqrt(ve_e * ve_e + vb_e * vb_e + slip)

    # What generalised forces add to S + D and to S - D; with their parts along the radii (p + q = 1) what such friction does.
    hi, level, cross = h * inverse, 1.0 - iy, bow * a12
    sum_s, sum_d = -bow * a22 - a11_q * a12, a11_q * a11 + cross
    gap_s, gap_d = level * a22 + cross, -bow * a11 - level * a12
    plus_s, plus_d = hi * (sum_s + gap_s), hi * (sum_d + gap_d)
    minus_s, minus_d = hi * (sum_s - gap_s), hi * (sum_d - gap_d)
    own, other, g = kn * (rho - q), kn * (q + rho * (q - p)), (kq + kq) * over
    up_s, up_d, down_s, down_d = plus_s * near, plus_d * further, minus_s * near, minus_d * further
    # With N over sqrt(|v|^2 + slip^2) for the unknowns no division stands between the speeds and K, whose columns have these
    # roots for a factor: the signs by which the forces are determined stay as they are.
    k_dd = swift_d - size * (ve_d * (own + up_s - up_d) - vb_d * (around * (plus_s + plus_d) + g))
    k_ed = size * (vb_d * (around * (minus_s + minus_d)) - ve_d * (other + down_s - down_d))
    k_de = size * (vb_e * (around * (plus_s - plus_d)) - ve_e * (other - up_s - up_d))
    k_ee = swift_e - size * (ve_e * (own - down_s - down_d) - vb_e * (around * (minus_s - minus_d) - g))
    plus = total + difference + plus_s * v_s + plus_d * v_d
    minus = total - difference + minus_s * v_s + minus_d * v_d
    return (
        (s, d, rate_s, rate_d, ve_d, vb_d, ve_e, vb_e, near, further, around),
        (swift_d, swift_e, k_de * minus - k_ee * plus, k_ed * plus - k_dd * minus, 1.0 / (k_dd * k_ee - k_de * k_ed), half),
        (kinetic, potential, coef[plain.Z * width + lane] * n, k_dd, k_de, k_ed, k_ee),
    )  # fmt: skip


@device
def rub(sliding, pressing, coef, lane, width):
    """What friction does: (P_s', P_d', its force around the axis over m r, N_D, N_E, |v_D|^2, |v_E|^2, its power over m r^2).

    From what :func:`slide` has.
    """
    _, _, rate_s, rate_d, ve_d, vb_d, ve_e, vb_e, near, further, around = sliding
    swift_d, swift_e, n_d, n_e, per_k, half = pressing
    force, newton = -coef[_MU * width + lane] * half * per_k, 2.0 * coef[plain.HALF_FORCE * width + lane] * half * per_k
    rub_d, rub_e = force * n_d, force * n_e
    e_d, e_e, b_d, b_e = rub_d * ve_d, rub_e * ve_e, rub_d * vb_d, rub_e * vb_e
    pull = b_d + b_e
    v2_d, v2_e = ve_d * ve_d + vb_d * vb_d, ve_e * ve_e + vb_e * vb_e
    return (
        rate_s + near * (e_d - e_e) - around * pull, rate_d + around * (b_e - b_d) - further * (e_d + e_e), pull,
        newton * n_d * swift_d, newton * n_e * swift_e, v2_d, v2_e, rub_d * v2_d + rub_e * v2_e,
    )  # fmt: skip


@device
def begin(y, held, coef, lane, width, with_load):
    """The first part of a right-hand side: what the pose determines."""
    posed, inverse_normal = pose(y, coef, lane, width)
    plain.hold(posed, held, _POSE * width + lane, width)
    held[_NORMAL * width + lane] = inverse_normal


@device
def go_on(y, held, coef, lane, width, with_load):
    """The second: what the speeds determine; returns what :func:`slide` has besides."""
    posed = plain.held_pose(held, _POSE * width + lane, width)
    sliding, pressing, besides = slide(y, posed, held[_NORMAL * width + lane], coef, lane, width, with_load)
    at = _SLIDE * width + lane
    (
        held[at], held[at + width], held[at + 2 * width], held[at + 3 * width], held[at + 4 * width], held[at + 5 * width],
        held[at + 6 * width], held[at + 7 * width], held[at + 8 * width], held[at + 9 * width], held[at + 10 * width],
    ) = sliding  # fmt: skip
    at = _PRESS * width + lane
    (
        held[at], held[at + width], held[at + 2 * width], held[at + 3 * width], held[at + 4 * width], held[at + 5 * width]
    ) = pressing  # fmt: skip
    return besides


@device
def _rub(held, coef, lane, width):
    at = _SLIDE * width + lane
    sliding = (
        held[at], held[at + width], held[at + 2 * width], held[at + 3 * width], held[at + 4 * width], held[at + 5 * width],
        held[at + 6 * width], held[at + 7 * width], held[at + 8 * width], held[at + 9 * width], held[at + 10 * width],
    )  # fmt: skip
    at = _PRESS * width + lane
    pressing = (
        held[at], held[at + width], held[at + 2 * width], held[at + 3 * width], held[at + 4 * width], held[at + 5 * width]
    )  # fmt: skip
    return rub(sliding, pressing, coef, lane, width)


@device
def finish(y, held, coef, h, k, first, lane, width, with_load):
    """The last: h y' into ``k[first:]``; returns N_D, N_E, the slip powers, the heat, friction's moment about the axis and s.

    Slip powers N |v|, heat and moment are in the units of :func:`units`: the sums over a step take them once.
    """
    rate_s, rate_d, pull, n_d, n_e, v2_d, v2_e, loss = _rub(held, coef, lane, width)
    s, d = held[_SLIDE * width + lane], held[(_SLIDE + 1) * width + lane]
    ox, oy, wx, wy = y[lane], y[width + lane], y[2 * width + lane], y[3 * width + lane]
    plain.turn(k, first, 0.5 * h * (s + d), 0.5 * h * (s - d), ox, oy, wx, wy, lane, width)
    k[first + 4 * width + lane] = h * rate_s
    k[first + 5 * width + lane] = h * rate_d
    k[first + SPIN * width + lane] = h * (coef[_SPUN * width + lane] * pull)
    return n_d, n_e, n_d * math.sqrt(v2_d), n_e * math.sqrt(v2_e), -loss, -pull, s


@device
def sense(y, held, coef, lane, width, with_load):
    """N_D, N_E and friction's moment about the axis in place of the last part."""
    _, _, pull, n_d, n_e, _, _, _ = _rub(held, coef, lane, width)
    return n_d, n_e, -coef[plain.ENERGY * width + lane] * coef[_ROUND * width + lane] * pull


PARTS = begin, go_on, finish


@device
def at_end(held, besides, y, coef, lane, width):
    """|w|^2, T, V, by how much the slower contact exceeds the slip speed, and the margin by which the forces are determined."""
    kinetic, potential, k1, k_dd, k_de, k_ed, k_ee = besides
    kinetic, potential = energies(kinetic, potential, y[SPIN * width + lane], coef, lane, width)
    p, q, r = held[_POSE * width + lane], held[(_POSE + 1) * width + lane], coef[plain.R * width + lane]
    at = (_SLIDE + 4) * width + lane
    ve_d, vb_d, ve_e, vb_e = held[at], held[at + width], held[at + 2 * width], held[at + 3 * width]
    slow = math.sqrt(min(ve_d * ve_d + vb_d * vb_d, ve_e * ve_e + vb_e * vb_e)) - math.sqrt(coef[_SLIP * width + lane])
    a_dd, a_ee, a_de = pressed(p, q, k1, coef, lane, width)
    margin = min(a_dd * k_dd + a_de * k_ed, a_de * k_de + a_ee * k_ee)
    margin = min(margin, (a_dd * a_ee - a_de * a_de) * (k_dd * k_ee - k_de * k_ed))
    return r * r * q, kinetic, potential, slow, margin


@device
def energies(kinetic, potential, turn, coef, lane, width):
    """T and V, J, that of the spin with them."""
    joule = coef[plain.ENERGY * width + lane]
    inertia = coef[_GYRO * width + lane] / (coef[plain.KAPPA * width + lane] * coef[_ROUND * width + lane])
    kinetic += 0.5 * inertia * turn * turn
    return joule * kinetic, joule * potential


@device
def units(coef, lane, width):
    """Of one lane the units of powers (m r^2), slip powers (r) and moments (m r r*); and -Omega where a drive holds it."""
    joule = coef[plain.ENERGY * width + lane]
    return (
        joule,
        coef[plain.R * width + lane],
        joule * coef[_ROUND * width + lane],
        coef[_HELD * width + lane],
    )


project = plain.project
rate_of_w2 = plain.rate_of_w2
momentum = plain.momentum


@device
def scale_speeds(y, factor, lane, width):
    """Multiply the speeds, and so the momenta, by ``factor``."""
    plain.scale_speeds(y, factor, lane, width)
    y[SPIN * width + lane] *= factor


@device
def spin_rate(y, coef, lane, width):
    """Omega of one lane."""
    return y[SPIN * width + lane] / coef[_ROUND * width + lane]


@device
def motion(y, coef, lane, width):
    """(O_x, O_y, u, v, O_x', O_y', u', v', 0, Omega) of one lane, SI units, in the axes of the scene."""
    x, z, u, v, x_rate, z_rate, u_rate, v_rate, _, _ = plain.motion(y, coef, lane, width)
    return x, z, u, v, x_rate, z_rate, u_rate, v_rate, 0.0, spin_rate(y, coef, lane, width)


@device
def observe(y, coef, lane, width, with_load):
    """(O_x, O_y, u, v, N_D, N_E, lambda_D, lambda_E, T, V, |w|^2) of one lane, SI units, in the axes of the scene."""
    posed, inverse_normal = pose(y, coef, lane, width)
    sliding, pressing, besides = slide(y, posed, inverse_normal, coef, lane, width, with_load)
    _, _, _, n_d, n_e, _, _, _ = rub(sliding, pressing, coef, lane, width)
    q, r = posed[1], coef[plain.R * width + lane]
    kinetic, potential = energies(besides[0], besides[1], y[SPIN * width + lane], coef, lane, width)
    per_normal = -1.0 / math.sqrt(1.0 + coef[plain.KAPPA * width + lane] * q * q)
    cos_t, sin_t = r * coef[plain.COS * width + lane], r * coef[plain.SIN * width + lane]
    ox, oy, wx, wy = y[lane], y[width + lane], y[2 * width + lane], y[3 * width + lane]
    return (
        cos_t * ox - sin_t * oy, sin_t * ox + cos_t * oy, cos_t * wx - sin_t * wy, sin_t * wx + cos_t * wy,
        n_d, n_e, per_normal * n_d, per_normal * n_e, kinetic, potential, r * r * q,
    )  # fmt: skip
