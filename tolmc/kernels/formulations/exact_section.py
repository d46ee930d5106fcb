"""Exact section: the bearing's rims touch the tilted journal (README, "Model").

Lengths are in units of the half-length L and masses in units of the body's mass, so both are 1 here. R and r are
the radii of bearing and journal, J(x, y) = (-y, x), the axis is parallel to (s, 1), D = O + s and E = O - s.

The journal's section by the plane of a rim is an ellipse about D with support function r q, q(n)^2 = 1 + (s.n)^2.
It touches the rim in the direction n that minimises the gap (R - n.D)/q - r. Minimum and contact (gap = 0) give
D = R n - (r/q) (n + (s.n) s), and E likewise. Both rims are touched in the poses

    O = X c,  s = Y Jc,    X = A cos(delta),  Y = mu sin(delta),    tan(eps) = Y sin(delta)
    A = R - r cos(eps),  kappa = 1 + r sin(eps),  mu = A/kappa

so that O.s = 0 and |D| = |E| as on the paper's circle, whose radius takes the place of A and mu. The contacts lie
in the directions n_D = c cos(delta) + Jc sin(delta) and n_E = c cos(delta) - Jc sin(delta); eps is the inclination
of the contact forces to the planes of the rims. The polar angle eta of D against c grows with delta, so that every
pair of polar angles of D and E has exactly one such pose.

A rim never touches the journal at two points. The second one would be the mirror image of the first in the
ellipse's minor axis, and closer to the rim only if s.n and s.D had different signs; at D they are
Y sin(delta) >= 0 and Y^2, at E their negatives.

The constraints' rows (gradients of -q gap) in (O', s') are (n_D, kappa n_D) and (n_E, -kappa n_E). The motions
that keep both contacts have two speeds, the turning rate of c ("swing") and nu:

    X' = -kappa sin(delta) nu,  Y' = cos(delta) nu,  delta' = nu/lambda,  lambda = mu (kappa - g)/(kappa + g)
    sin(eps)' = 2 kappa cos(eps)^3 sin(delta) cos(delta) nu/(kappa - g)
    g = r sin(eps) cos(eps)^2 cos(delta)^2 < kappa

c, (cos(delta), sin(delta)) and sin(eps) are integrated along with the speeds: neither a minimum nor a
trigonometric function is ever computed, and :func:`project` removes what the error of a step adds to |c| = 1,
cos^2 + sin^2 = 1 and tan(eps) = Y sin(delta). A circle of radius rho is the case X = rho cos(delta),
Y = rho sin(delta), kappa = 1, delta' = nu/rho of the same equations.

R - r enters as ``clearance``, and the formulas keep its relative precision however small it is.
"""

from __future__ import annotations

import math

from tolmc.kernels.jit import device
from tolmc.kernels.roots import inverse_root

STATE = 7  # c_x, c_y, cos(delta), sin(delta), sin(eps), turning rate of c, nu

# Newton within a bracket: 4 iterations reach rounding on usual bearings, 10 at L/r = 0.02 with R/r = 11.
_START_ITERATIONS = 12


@device
def shape(cos_d, sin_d, sin_e, nu, clearance, journal):
    """(X, Y, kappa, 1/(kappa cos(eps)), delta', sin(eps)', X'', Y'', cos(theta)^2, cos(theta)), X'' and Y'' for nu' = 0.

    clearance = (R - r)/L, journal = r/L, theta the tilt; a = A (1 + cos(eps)) cancels nothing. What a caller does not use is
    not computed.
    """
    cos_e2 = 1.0 - sin_e * sin_e
    sec_e = inverse_root(cos_e2)
    cos_e = cos_e2 * sec_e
    lift = journal * sin_e
    kappa = 1.0 + lift
    fold = 1.0 + cos_e
    a = clearance * fold + lift * sin_e
    g = lift * cos_e2 * (cos_d * cos_d)
    gain, rest = kappa - g, kappa * fold
    a_gain = a * gain
    inverse = 1.0 / (a_gain * rest)
    mu = a * a_gain * inverse
    speed = rest * inverse * nu  # nu/(a (kappa - g))
    turn = (kappa + g) * rest * speed
    lean = (kappa + kappa) * a * speed * ((cos_e * cos_e2) * (sin_d * cos_d))
    opened, turned, y = kappa * cos_d, turn * nu, mu * sin_d
    cos_t = inverse_root(1.0 + y * y)
    return (
        mu * opened, y, kappa, (a_gain * fold) * (inverse * sec_e), turn, lean,
        -(journal * lean * nu * sin_d + opened * turned), -sin_d * turned, cos_t * cos_t, cos_t,
    )  # fmt: skip


@device
def rate_of_w2(sin_d, sin_e, sin_d_rate, sin_e_rate, clearance, journal):
    """Rate of Y^2, Y = (clearance + journal (1 - cos(eps))) sin(delta)/kappa."""
    cos_e = math.sqrt(1.0 - sin_e * sin_e)
    fold, kappa = 1.0 + cos_e, 1.0 + journal * sin_e
    inverse = 1.0 / (kappa * fold * cos_e)
    mu = (clearance * fold + journal * sin_e * sin_e) * cos_e * inverse
    bend = fold * inverse * (sin_e - mu * cos_e)
    return 2.0 * mu * sin_d * (mu * sin_d_rate + journal * sin_e_rate * sin_d * bend)


@device
def hold(shaped, held, at, width):
    """What :func:`shape` has, to rows from ``at`` on."""
    (
        held[at], held[at + width], held[at + 2 * width], held[at + 3 * width], held[at + 4 * width],
        held[at + 5 * width], held[at + 6 * width], held[at + 7 * width], held[at + 8 * width], held[at + 9 * width],
    ) = shaped  # fmt: skip


@device
def held_shape(held, at, width):
    """The same again."""
    return (
        held[at], held[at + width], held[at + 2 * width], held[at + 3 * width], held[at + 4 * width],
        held[at + 5 * width], held[at + 6 * width], held[at + 7 * width], held[at + 8 * width], held[at + 9 * width],
    )  # fmt: skip


@device
def contact_forces(cos_d, sin_d, kappa, pull, o_c, o_j, s_c, s_j):
    """N_D, N_E from what the equations of motion of O and s leave over (inertia less forces), along c and Jc.

    The residual of O is -(N_D n_D + N_E n_E) cos(eps), that of s -(N_D n_D - N_E n_E) kappa cos(eps);
    pull = 1/(kappa cos(eps)).
    """
    half = -0.5 * pull
    both, difference = (kappa * cos_d) * o_c + s_j * sin_d, (kappa * sin_d) * o_j + s_c * cos_d
    return half * (both + difference), half * (both - difference)


@device
def symmetric(
    cos_d, sin_d, x, y, kappa, pull, x_bias, y_bias, cos2, cos_t, swing, nu,
    z, inertia, gyro, force_c, force_j, moment_c, moment_j, moment_z,
):  # fmt: skip
    """Body symmetric about its axis: (swing', nu', N_D, N_E, T, V, momentum about Z, its change with swing).

    x ... cos_t come from :func:`shape`. z = z_C/L, inertia = A/(m L^2), gyro = C Omega/(m L^2); force_c,
    force_j are the components of the resultant over m L along c and Jc; moment_c, moment_j, moment_z those of
    the sum of z_i F_i over m L^2 along c, Jc and Z, z_i the height on the axis where F_i acts. Contact forces
    in units of m L/s^2, positive when the wall pushes; T, without the constant C Omega^2/2, and V in units of
    m L^2/s^2, the momentum, without the constant C Omega, in units of m L^2/s. What a caller does not use is not
    computed.

    Lagrange's equations in the angle of c, X and the tilt theta: tan(theta) = Y, e = (sin(theta) Jc, cos(theta)).
    """
    sin_t = y * cos_t
    # X' and theta' for nu = 1, then the accelerations of O and e for swing' = nu' = 0.
    x_1, tilt_1 = -kappa * sin_d, cos2 * cos_d
    x_rate, tilt_rate = x_1 * nu, tilt_1 * nu
    tilt_rate2, swing2 = tilt_rate * tilt_rate, swing * swing
    tilt_bias = cos2 * y_bias - (y + y) * tilt_rate2
    a_c, a_j = x_bias - x * swing2, (x_rate + x_rate) * swing
    half_e_c = -cos_t * (tilt_rate * swing)
    e_c = half_e_c + half_e_c
    e_j = cos_t * tilt_bias - sin_t * (tilt_rate2 + swing2)
    e_m = tilt_bias - sin_t * cos_t * swing2  # along the meridian (cos(theta) Jc, -sin(theta))

    # Inertia less forces: of O along c and Jc, of e along c and the meridian.
    o_c = a_c + z * e_c - force_c
    o_j = a_j + z * e_j - force_j
    r_c = inertia * e_c + z * a_c + gyro * tilt_rate - moment_c
    r_m = inertia * e_m + cos_t * (z * a_j - moment_j) + sin_t * (moment_z + gyro * swing)

    z_sin, z_cos, i_sin = z * sin_t, z * cos_t, inertia * sin_t
    m_11 = x * x + i_sin * sin_t
    m_22 = x_1 * x_1 + inertia * (tilt_1 * tilt_1)
    m_12 = z_cos * (x * tilt_1) - z_sin * x_1
    load_1, load_2 = sin_t * r_c - x * o_j, -x_1 * o_c - tilt_1 * r_m
    inverse = 1.0 / (m_11 * m_22 - m_12 * m_12)
    swing_rate = (m_22 * load_1 - m_12 * load_2) * inverse
    nu_rate = (m_11 * load_2 - m_12 * load_1) * inverse

    x_2, tilt_2, x_swing = x_1 * nu_rate, tilt_1 * nu_rate, x * swing_rate
    o_c += x_2 - z_sin * swing_rate
    o_j += x_swing + z_cos * tilt_2
    r_c += z * x_2 - i_sin * swing_rate
    r_m += inertia * tilt_2 + z_cos * x_swing
    n_d, n_e = contact_forces(cos_d, sin_d, kappa, pull, o_c, o_j, cos_t * r_c, cos2 * r_m)

    kinetic = 0.5 * (m_11 * swing2 + m_22 * nu * nu) + m_12 * swing * nu
    potential = -x * force_c - sin_t * moment_j - cos_t * moment_z
    # cos(theta) - 1 = -sin(theta)^2/(1 + cos(theta))
    about_z = m_11 * swing + m_12 * nu - gyro * sin_t * sin_t / (1.0 + cos_t)
    return swing_rate, nu_rate, n_d, n_e, kinetic, potential, about_z, m_11


@device
def _cross(a_x, a_y, a_z, b_x, b_y, b_z):
    return a_y * b_z - a_z * b_y, a_z * b_x - a_x * b_z, a_x * b_y - a_y * b_x


@device
def _times(j_11, j_22, j_33, j_12, j_13, j_23, x, y, z):
    """Symmetric matrix times vector."""
    return j_11 * x + j_12 * y + j_13 * z, j_12 * x + j_22 * y + j_23 * z, j_13 * x + j_23 * y + j_33 * z


@device
def _turned(cos_p, sin_p, x, y):
    return cos_p * x - sin_p * y, sin_p * x + cos_p * y


@device
def general(
    cos_d, sin_d, x, y, kappa, pull, x_bias, y_bias, cos2, cos_t, swing, nu, cos_p, sin_p, spin,
    com_x, com_y, com_z, j_xx, j_yy, j_zz, j_xy, j_xz, j_yz,
    gravity_c, gravity_j, gravity_z, force_c, force_j, force_z, at_x, at_y, at_z,
    torque_c, torque_j, torque_z, with_load,
):  # fmt: skip
    """Any body: (swing', nu', Omega', phi', N_D, N_E, T, V, power of the torque, momentum about Z, that of a unit turn).

    cos_p, sin_p belong to phi = chi - (polar angle of c), the body's turn about e in the frame (c, d, e) with
    d = (cos(theta) Jc, -sin(theta)); spin = Omega. com = r_C/L and j = J/(m L^2) about O in body axes;
    gravity/L, force/(m L), torque/(m L^2) by their components along c, Jc and Z; at = the force's point over
    L in body axes. Units of the results as in :func:`symmetric`, T with the spin.

    Kane's equations for swing, nu and Omega; in that frame omega = (-theta', -sin(theta) swing, Omega).
    """
    sin_t = y * cos_t
    x_1, tilt_1 = -kappa * sin_d, cos2 * cos_d
    x_rate, tilt_rate = x_1 * nu, tilt_1 * nu
    tilt_bias = cos2 * y_bias - 2.0 * y * tilt_rate * tilt_rate

    # The body in the frame.
    s_c, s_d = _turned(cos_p, sin_p, com_x, com_y)
    s_e = com_z
    j_ce, j_de = _turned(cos_p, sin_p, j_xz, j_yz)
    cos_2p, sin_2p = cos_p * cos_p - sin_p * sin_p, 2.0 * cos_p * sin_p
    mean = 0.5 * (j_xx + j_yy)
    deviation, j_cd = _turned(cos_2p, sin_2p, 0.5 * (j_xx - j_yy), j_xy)
    j_cc, j_dd = mean + deviation, mean - deviation

    # Accelerations for swing' = nu' = Omega' = 0 and what they leave over: force (f) and moment about O (n).
    phi_rate = spin - cos_t * swing
    a_c, a_j = x_bias - x * swing * swing, 2.0 * x_rate * swing
    a_d, a_e = cos_t * a_j, sin_t * a_j
    w_c, w_d = -tilt_rate, -sin_t * swing
    b_c, b_d = phi_rate * w_d - tilt_bias, tilt_rate * (phi_rate - cos_t * swing)
    h_c, h_d, h_e = _times(j_cc, j_dd, j_zz, j_cd, j_ce, j_de, w_c, w_d, spin)
    n_c, n_d, n_e = _cross(w_c, w_d, spin, h_c, h_d, h_e)
    h_c, h_d, h_e = _times(j_cc, j_dd, j_zz, j_cd, j_ce, j_de, b_c, b_d, 0.0)
    l_c, l_d, l_e = _cross(s_c, s_d, s_e, a_c, a_d, a_e)
    n_c, n_d, n_e = n_c + h_c + l_c, n_d + h_d + l_d, n_e + h_e + l_e
    f_c, f_d, f_e = _cross(w_c, w_d, spin, s_c, s_d, s_e)
    f_c, f_d, f_e = _cross(w_c, w_d, spin, f_c, f_d, f_e)
    l_c, l_d, l_e = _cross(b_c, b_d, 0.0, s_c, s_d, s_e)
    f_c, f_d, f_e = f_c + l_c + a_c, f_d + l_d + a_d, f_e + l_e + a_e
    potential, power = 0.0, 0.0
    if with_load:
        g_d, g_e = cos_t * gravity_j - sin_t * gravity_z, sin_t * gravity_j + cos_t * gravity_z
        k_d, k_e = cos_t * force_j - sin_t * force_z, sin_t * force_j + cos_t * force_z
        t_d, t_e = cos_t * torque_j - sin_t * torque_z, sin_t * torque_j + cos_t * torque_z
        p_c, p_d = _turned(cos_p, sin_p, at_x, at_y)
        f_c, f_d, f_e = f_c - gravity_c - force_c, f_d - g_d - k_d, f_e - g_e - k_e
        l_c, l_d, l_e = _cross(s_c, s_d, s_e, gravity_c, g_d, g_e)
        n_c, n_d, n_e = n_c - l_c - torque_c, n_d - l_d - t_d, n_e - l_e - t_e
        l_c, l_d, l_e = _cross(p_c, p_d, at_z, force_c, k_d, k_e)
        n_c, n_d, n_e = n_c - l_c, n_d - l_d, n_e - l_e
        potential = -(
            x * (gravity_c + force_c)
            + (s_c * gravity_c + s_d * g_d + s_e * g_e)
            + (p_c * force_c + p_d * k_d + at_z * k_e)
        )
        power = w_c * torque_c + w_d * t_d + spin * t_e

    # Mass matrix and load for the virtual velocities X Jc, -sin(theta) d; x_1 c, -tilt_1 c; and e.
    m_11 = x * x + sin_t * sin_t * (2.0 * x * s_c + j_dd)
    m_22 = x_1 * x_1 + tilt_1 * tilt_1 * j_cc
    m_12 = tilt_1 * (x * (cos_t * s_e - sin_t * s_d) + sin_t * j_cd) - x_1 * sin_t * s_e
    m_13 = x * cos_t * s_c - sin_t * j_de
    m_23 = -x_1 * s_d - tilt_1 * j_ce
    load_1 = sin_t * n_d - x * (cos_t * f_d + sin_t * f_e)
    load_2 = tilt_1 * n_c - x_1 * f_c

    # Omega' is eliminated first: j_zz > 0 for every body on a journal.
    inverse = 1.0 / j_zz
    k_1, k_2 = m_13 * inverse, m_23 * inverse
    r_11, r_12, r_22 = m_11 - k_1 * m_13, m_12 - k_1 * m_23, m_22 - k_2 * m_23
    load_1, load_2 = load_1 + k_1 * n_e, load_2 + k_2 * n_e
    inverse_det = 1.0 / (r_11 * r_22 - r_12 * r_12)
    swing_rate = (r_22 * load_1 - r_12 * load_2) * inverse_det
    nu_rate = (r_11 * load_2 - r_12 * load_1) * inverse_det
    spin_rate = -n_e * inverse - k_1 * swing_rate - k_2 * nu_rate

    # What all accelerations leave over is carried by the contacts.
    a_c, a_d, a_e = x_1 * nu_rate, cos_t * x * swing_rate, sin_t * x * swing_rate
    b_c, b_d = -tilt_1 * nu_rate, -sin_t * swing_rate
    l_c, l_d, l_e = _cross(b_c, b_d, spin_rate, s_c, s_d, s_e)
    f_c, f_d, f_e = f_c + a_c + l_c, f_d + a_d + l_d, f_e + a_e + l_e
    h_c, h_d, _ = _times(j_cc, j_dd, j_zz, j_cd, j_ce, j_de, b_c, b_d, spin_rate)
    l_c, l_d, _ = _cross(s_c, s_d, s_e, a_c, a_d, a_e)
    n_c, n_d = n_c + h_c + l_c, n_d + h_d + l_d
    normal_d, normal_e = contact_forces(
        cos_d, sin_d, kappa, pull, f_c, cos_t * f_d + sin_t * f_e, cos_t * n_d, -cos2 * n_c
    )

    kinetic = (
        0.5 * (m_11 * swing * swing + m_22 * nu * nu + j_zz * spin * spin)
        + m_12 * swing * nu
        + (m_13 * swing + m_23 * nu) * spin
    )
    # A turn about Z has swing = 1, nu = 0, Omega = cos(theta).
    about_z = m_11 * swing + m_12 * nu + m_13 * spin + cos_t * (m_13 * swing + m_23 * nu + j_zz * spin)
    turn = m_11 + cos_t * (2.0 * m_13 + cos_t * j_zz)
    return swing_rate, nu_rate, spin_rate, phi_rate, normal_d, normal_e, kinetic, potential, power, about_z, turn


@device
def _closed(sin_e, sin_d2, clearance, journal):
    """One Newton step of sin(eps) to tan(eps) = Y sin(delta): kappa sin(eps) = A cos(eps) sin(delta)^2."""
    cos_e = math.sqrt(1.0 - sin_e * sin_e)
    lift = journal * sin_e
    kappa, fold = 1.0 + lift, 1.0 + cos_e
    a = clearance * fold + lift * sin_e  # A (1 + cos(eps))
    miss = sin_e * kappa * fold - a * cos_e * sin_d2
    slope = (kappa + lift) * fold * cos_e + (a * sin_e - lift * fold * cos_e) * sin_d2
    return sin_e - miss * cos_e / slope


@device
def project(c_x, c_y, cos_d, sin_d, sin_e, clearance, journal):
    """The pose (first five components of the state) brought back to rounding; the speeds are tangent as they are.

    c and delta keep their directions; two Newton steps undo any error of sin(eps) that a usable step makes.
    """
    inverse_c, inverse_d = inverse_root(c_x * c_x + c_y * c_y), inverse_root(cos_d * cos_d + sin_d * sin_d)
    cos_d, sin_d = cos_d * inverse_d, sin_d * inverse_d
    sin_e = _closed(sin_e, sin_d * sin_d, clearance, journal)
    sin_e = _closed(sin_e, sin_d * sin_d, clearance, journal)
    return c_x * inverse_c, c_y * inverse_c, cos_d, sin_d, sin_e


@device
def gap(cos_d, sin_d, sin_e, clearance, journal):
    """Distance of either rim from the journal's surface, in units of L; 0 to rounding once projected."""
    x, y, _, _, _, _, _, _, _, _ = shape(cos_d, sin_d, sin_e, 0.0, clearance, journal)
    tan_e = y * sin_d
    q = math.sqrt(1.0 + tan_e * tan_e)
    return (clearance - x * cos_d - y * sin_d - journal * tan_e * tan_e / (1.0 + q)) / q


@device
def motion(c_x, c_y, cos_d, sin_d, sin_e, swing, nu, clearance, journal):
    """(O_x, O_y, u, v, O_x', O_y', u', v')/L of O = X c and w = Y Jc; X' = -kappa sin(delta) nu, Y' = cos(delta) nu."""
    x, y, kappa, _, _, _, _, _, _, _ = shape(cos_d, sin_d, sin_e, nu, clearance, journal)
    x_rate, y_rate = -kappa * sin_d * nu, cos_d * nu
    return (
        x * c_x, x * c_y, -y * c_y, y * c_x, x_rate * c_x - x * swing * c_y, x_rate * c_y + x * swing * c_x,
        -y_rate * c_y - y * swing * c_x, y_rate * c_x - y * swing * c_y,
    )  # fmt: skip


@device
def start(alpha, beta, alpha_rate, beta_rate, clearance, journal):
    """State from the polar angles of D and E (rad) and their rates.

    D = X c + Y Jc and E = X c - Y Jc, so c bisects the angle between D and E, and half of that angle, eta,
    satisfies tan(delta) = kappa tan(eta). With sin(delta)^2 = kappa sin(eps)/(A cos(eps)) this is one
    equation for sin(eps); its root lies between 0 (axis parallel to the bore) and the sine of the largest
    tilt.
    """
    mid, eta = 0.5 * (alpha + beta), 0.5 * (alpha - beta)
    cos_h, sin_h = math.cos(eta), math.sin(eta)
    cos_h2, sin_h2 = cos_h * cos_h, sin_h * sin_h
    bearing = clearance + journal
    squares = clearance * (bearing + journal)  # R^2 - r^2
    half = clearance / (1.0 + math.sqrt(1.0 + squares))
    low, high = 0.0, 2.0 * half / (1.0 + half * half)
    # First guess: contacts in the directions of D and E, which is exact at both ends of the bracket.
    tan_e = sin_h2 * squares / (bearing + journal * math.sqrt(1.0 + sin_h2 * sin_h2 * squares))
    sin_e = tan_e / math.sqrt(1.0 + tan_e * tan_e)
    for _ in range(_START_ITERATIONS):
        cos_e = math.sqrt(1.0 - sin_e * sin_e)
        kappa = 1.0 + journal * sin_e
        a = clearance + journal * sin_e * sin_e / (1.0 + cos_e)
        spread = cos_h2 + kappa * kappa * sin_h2
        miss = sin_e * spread - sin_h2 * kappa * cos_e * a
        slope = (
            spread
            + sin_h2 * journal * (2.0 * sin_e * kappa - a * cos_e)
            + sin_h2 * kappa * sin_e * (a / cos_e - journal)
        )
        low, high = (sin_e, high) if miss < 0.0 else (low, sin_e)
        moved = sin_e - miss / slope
        sin_e = moved if low <= moved <= high else 0.5 * (low + high)

    kappa = 1.0 + journal * sin_e
    inverse = 1.0 / math.sqrt(cos_h2 + kappa * kappa * sin_h2)
    c_x, c_y, cos_d, sin_d, sin_e = project(
        math.cos(mid), math.sin(mid), cos_h * inverse, kappa * sin_h * inverse, sin_e, clearance, journal
    )
    x, y, kappa, _, _, _, _, _, _, _ = shape(cos_d, sin_d, sin_e, 0.0, clearance, journal)
    # eta = atan2(Y, X)
    nu = 0.5 * (alpha_rate - beta_rate) * (x * x + y * y) / (x * cos_d + kappa * y * sin_d)
    return c_x, c_y, cos_d, sin_d, sin_e, 0.5 * (alpha_rate + beta_rate), nu
