"""The paper's own formulation: q = [X0, Y0, psi, theta, phi], equations (11)-(33), in fixed time steps.

M(q) qdd = F + B^T lambda with B qdd = -Bdot qd, where the rows B are one of two choices:

- published: equation (13), half the time derivative of (12);
- regular: the gradients of X0 sin(psi) - Y0 cos(psi) = 0 and (X0^2 + Y0^2 + L^2 tan^2(theta) - r^2)/2 = 0.

With s = X0 cos(psi) + Y0 sin(psi) and t = L tan(theta) both describe the branch (11), which is
O = s (cos psi, sin psi), s^2 + t^2 = r^2; (12) has mirror branches besides. theta is signed, and so is s, the root
in (11): (s, psi, theta, phi) and (-s, psi + pi, -theta, phi - pi) are one pose.

Where the formulation breaks: on the branch the rows (13) are cos(psi) and sin(psi) times rows that become parallel
with s, so psi = k pi/2 and s = 0 (maximum tilt) multiply errors by the inverse distance. Near theta = 0 the columns
of psi and phi in M become one, which multiplies errors where theta stays small. What is returned is right all the
same, because

- every Runge-Kutta stage is evaluated on the branch (11), reached in closed form by :func:`motion.retract`. There both
  choices of rows span one space, so a singular set amplifies rounding and nothing else, whatever the step;
- the amplification is measured at every stage, and beyond :data:`motion.CONDITION_LIMIT` the motion ends with the status of
  the nearest singular set.

The parameters p of a motion are a vector in the order of :mod:`tolmc.kernels.parameters`: SI units, inertia about O
in body axes, loads in fixed axes, force point in body axes.
"""

from __future__ import annotations

import numpy as np

from tolmc.kernels import parameters as P
from tolmc.kernels.jit import kernel


@kernel
def start(p):
    """Position q (5,) and speeds qd (5,) from alpha, beta, their rates, the spin chi and the spin rate Omega.

    The axis meets the circles at D (polar angle alpha) and E (beta), so that psi = (alpha + beta)/2,
    s = r cos(delta) and L tan(theta) = r sin(delta) with delta = (beta - alpha)/2, brought to s >= 0 as (11) has
    it. phi = chi - psi and phi_dot = Omega - psi_dot cos(theta).
    """
    r, L = p[P.RADIUS], p[P.HALF_LENGTH]
    half_turns = np.pi * np.rint((p[P.BETA] - p[P.ALPHA]) / (2 * np.pi))
    delta, psi = 0.5 * (p[P.BETA] - p[P.ALPHA]) - half_turns, 0.5 * (p[P.BETA] + p[P.ALPHA]) - half_turns
    delta_rate, psi_rate = 0.5 * (p[P.BETA_RATE] - p[P.ALPHA_RATE]), 0.5 * (p[P.BETA_RATE] + p[P.ALPHA_RATE])
    s, s_rate = r * np.cos(delta), -r * np.sin(delta) * delta_rate
    theta = np.arctan(r / L * np.sin(delta))
    q, qd = np.empty(5), np.empty(5)
    q[0], q[1] = s * np.cos(psi), s * np.sin(psi)
    q[2], q[3], q[4] = psi, theta, p[P.SPIN] - psi
    qd[0], qd[1] = s_rate * np.cos(psi) - q[1] * psi_rate, s_rate * np.sin(psi) + q[0] * psi_rate
    qd[2], qd[3] = psi_rate, s / L * delta_rate * np.cos(theta) ** 2
    qd[4] = p[P.SPIN_RATE] - psi_rate * np.cos(theta)
    return q, qd


@kernel
def rotation(q):
    """[R] = Rz(psi) Rx(theta) Rz(phi), body to fixed axes, (3, 3)."""
    c_psi, s_psi = np.cos(q[2]), np.sin(q[2])
    c_theta, s_theta = np.cos(q[3]), np.sin(q[3])
    c_phi, s_phi = np.cos(q[4]), np.sin(q[4])
    R = np.empty((3, 3))
    R[0, 0], R[0, 1] = c_psi * c_phi - s_psi * c_theta * s_phi, -c_psi * s_phi - s_psi * c_theta * c_phi
    R[1, 0], R[1, 1] = s_psi * c_phi + c_psi * c_theta * s_phi, -s_psi * s_phi + c_psi * c_theta * c_phi
    R[2, 0], R[2, 1] = s_theta * s_phi, s_theta * c_phi
    R[0, 2], R[1, 2], R[2, 2] = s_psi * s_theta, -c_psi * s_theta, c_theta
    return R


@kernel
def transformation(q):
    """T (6, 5), with (v_O, omega) = T qd in body axes, and its derivatives dT/dq_i, (5, 6, 5)."""
    R = rotation(q)
    c_psi, s_psi = np.cos(q[2]), np.sin(q[2])
    c_theta, s_theta = np.cos(q[3]), np.sin(q[3])
    c_phi, s_phi = np.cos(q[4]), np.sin(q[4])
    T, dT = np.zeros((6, 5)), np.zeros((5, 6, 5))
    for k in range(3):
        T[k, 0], T[k, 1], T[3 + k, 2] = R[0, k], R[1, k], R[2, k]
        dT[2, k, 0], dT[2, k, 1] = -R[1, k], R[0, k]
        dT[3, k, 0], dT[3, k, 1] = s_psi * R[2, k], -c_psi * R[2, k]
    T[3, 3], T[4, 3], T[5, 4] = c_phi, -s_phi, 1.0
    dT[3, 3, 2], dT[3, 4, 2], dT[3, 5, 2] = c_theta * s_phi, c_theta * c_phi, -s_theta
    for j in range(2):
        dT[4, 0, j], dT[4, 1, j] = R[j, 1], -R[j, 0]
    dT[4, 3, 2], dT[4, 4, 2] = R[2, 1], -R[2, 0]
    dT[4, 3, 3], dT[4, 4, 3] = -s_phi, -c_phi
    return T, dT


@kernel
def body_matrix(p):
    """[[m I, S^T], [S, J]] of (16) and (17), (6, 6)."""
    m = p[P.MASS]
    body = np.zeros((6, 6))
    body[0, 0] = body[1, 1] = body[2, 2] = m
    body[3, 1], body[3, 2], body[4, 2] = -m * p[P.COM_Z], m * p[P.COM_Y], -m * p[P.COM_X]
    body[4, 0], body[5, 0], body[5, 1] = m * p[P.COM_Z], -m * p[P.COM_Y], m * p[P.COM_X]
    body[3, 3], body[4, 4], body[5, 5] = p[P.J_XX], p[P.J_YY], p[P.J_ZZ]
    body[4, 3], body[5, 3], body[5, 4] = p[P.J_XY], p[P.J_XZ], p[P.J_YZ]
    for i in range(6):
        for j in range(i):
            body[j, i] = body[i, j]
    return body


@kernel
def mass_matrix(q, body):
    """M = T^T [[m I, S^T], [S, J]] T, (5, 5), and M_i = dM/dq_i, (5, 5, 5)."""
    T, dT = transformation(q)
    momentum = np.zeros((6, 5))
    for i in range(6):
        for j in range(6):
            for k in range(5):
                momentum[i, k] += body[i, j] * T[j, k]
    M, dM = np.zeros((5, 5)), np.zeros((5, 5, 5))
    for j in range(5):
        for k in range(j + 1):
            for i in range(6):
                M[j, k] += T[i, j] * momentum[i, k]
                for n in range(2, 5):  # X0 and Y0 do not appear in M
                    dM[n, j, k] += dT[n, i, j] * momentum[i, k] + dT[n, i, k] * momentum[i, j]
            M[k, j] = M[j, k]
            for n in range(2, 5):
                dM[n, k, j] = dM[n, j, k]
    return M, dM


@kernel
def applied_wrench(q, p):
    """Force and moment about O of gravity, the force at the body point and the torque, body axes, (6,)."""
    R = rotation(q)
    weight, force, wrench = np.zeros(3), np.zeros(3), np.zeros(6)
    for k in range(3):
        for i in range(3):
            weight[k] += R[i, k] * p[P.MASS] * p[P.GRAVITY_X + i]
            force[k] += R[i, k] * p[P.FORCE_X + i]
            wrench[3 + k] += R[i, k] * p[P.TORQUE_X + i]
        wrench[k] = weight[k] + force[k]
    for k in range(3):
        k1, k2 = (k + 1) % 3, (k + 2) % 3
        wrench[3 + k] += p[P.COM_X + k1] * weight[k2] - p[P.COM_X + k2] * weight[k1]
        wrench[3 + k] += p[P.POINT_X + k1] * force[k2] - p[P.POINT_X + k2] * force[k1]
    return wrench


@kernel
def generalised_forces(q, qd, p, body):
    """F = P + (qd^T M_i qd)_i / 2 - Mdot qd of (32), with P = T^T wrench and Mdot = sum qd_i M_i, (5,)."""
    T, _ = transformation(q)
    _, dM = mass_matrix(q, body)
    wrench = applied_wrench(q, p)
    F = np.zeros(5)
    for i in range(5):
        for j in range(6):
            F[i] += T[j, i] * wrench[j]
        for j in range(5):
            for k in range(5):
                F[i] += (0.5 * dM[i, j, k] - dM[k, i, j]) * qd[j] * qd[k]
    return F


@kernel
def constraints(q, qd, r, L, regular):
    """Residuals g (2,), rows B = dg/dq (2, 5), Bdot qd (2,): half of (12) with (13), or the regular pair."""
    X, Y, X_rate, Y_rate, psi_rate, theta_rate = q[0], q[1], qd[0], qd[1], qd[2], qd[3]
    c_psi, s_psi = np.cos(q[2]), np.sin(q[2])
    g, B, Bdot_qd = np.empty(2), np.zeros((2, 5)), np.empty(2)
    if regular:
        tangent = np.tan(q[3])
        stretch = L * L * (1 + tangent * tangent)
        g[0] = X * s_psi - Y * c_psi
        B[0, 0], B[0, 1], B[0, 2] = s_psi, -c_psi, X * c_psi + Y * s_psi
        Bdot_qd[0] = 2 * (X_rate * c_psi + Y_rate * s_psi) * psi_rate - g[0] * psi_rate**2
        g[1] = 0.5 * (X * X + Y * Y + (L * tangent) ** 2 - r * r)
        B[1, 0], B[1, 1], B[1, 3] = X, Y, stretch * tangent
        Bdot_qd[1] = X_rate**2 + Y_rate**2 + stretch * (1 + 3 * tangent * tangent) * theta_rate**2
        return g, B, Bdot_qd
    cos2, sin2 = np.cos(q[3]) ** 2, np.sin(q[3]) ** 2
    sin_2theta, cos_2theta = np.sin(2 * q[3]), np.cos(2 * q[3])
    reach, span = r * r * cos2 - L * L * sin2, r * r + L * L
    for i in range(2):
        x, x_rate = q[i], qd[i]
        direction2, sign = (c_psi * c_psi, 1.0) if i == 0 else (s_psi * s_psi, -1.0)
        turn, turn_rate = sign * np.sin(2 * q[2]), 2 * sign * np.cos(2 * q[2]) * psi_rate
        tilt = span * direction2 - x * x
        g[i] = 0.5 * (x * x * cos2 - direction2 * reach)
        B[i, i] = x * cos2
        B[i, 2] = 0.5 * turn * reach
        B[i, 3] = 0.5 * sin_2theta * tilt
        Bdot_qd[i] = (
            x_rate**2 * cos2
            + 0.5 * turn_rate * reach * psi_rate
            - (2 * x * x_rate + turn * span * psi_rate) * sin_2theta * theta_rate
            + cos_2theta * tilt * theta_rate**2
        )
    return g, B, Bdot_qd


@kernel
def solve(K, rhs, constrained, leading):
    """Solution x of K x = rhs, and the condition number of its leading entries.

    Gauss-Jordan elimination with complete pivoting, within the first ``constrained`` rows before the others: pivots of
    M first would form B M^-1 B^T, which squares the condition number and so hides it beyond 1e8. The condition
    number is |K| times the norm of the leading rows of the inverse (Frobenius norms).
    """
    n = rhs.size
    work, column = np.zeros((n, 2 * n + 1)), np.zeros(n, np.int64)  # [K | rhs | I]; the unknown of each pivot row
    free = np.ones(n, np.bool_)
    norm2, inverse_norm2 = 0.0, 0.0
    for i in range(n):
        for j in range(n):
            work[i, j] = K[i, j]
            norm2 += K[i, j] ** 2
        work[i, n], work[i, n + 1 + i] = rhs[i], 1.0
    for k in range(n):
        pivot, largest = k, -1.0
        for i in range(k, constrained if k < constrained else n):
            for j in range(n):
                if free[j] and abs(work[i, j]) > largest:
                    pivot, column[k], largest = i, j, abs(work[i, j])
        free[column[k]] = False
        for j in range(2 * n + 1):
            work[k, j], work[pivot, j] = work[pivot, j], work[k, j]
        inverse = 1.0 / work[k, column[k]]
        for j in range(2 * n + 1):
            work[k, j] *= inverse
        for i in range(n):
            factor = work[i, column[k]]
            if i != k:
                for j in range(2 * n + 1):
                    work[i, j] -= factor * work[k, j]
    x = np.empty(n)
    for k in range(n):
        x[column[k]] = work[k, n]
        if column[k] < leading:
            for j in range(n + 1, 2 * n + 1):
                inverse_norm2 += work[k, j] ** 2
    return x, np.sqrt(norm2 * inverse_norm2)


@kernel
def accelerations(q, qd, p, body, regular):
    """Accelerations qdd (5,), multipliers lambda (2,), constraint forces B^T lambda (5,), condition number of (33).

    The equations are scaled first (unit diagonal of M, unit rows of B), which frees the condition number of units.
    The two rows of (13) keep their relative size: that one of them vanishes has to show. The multipliers are left
    out of the condition number, as they grow where (13) degenerates while B^T lambda does not.
    """
    M, _ = mass_matrix(q, body)
    F = generalised_forces(q, qd, p, body)
    _, B, Bdot_qd = constraints(q, qd, p[P.RADIUS], p[P.HALF_LENGTH], regular)
    scale = np.zeros(7)
    for i in range(5):
        scale[i] = 1.0 / np.sqrt(M[i, i])
        for row in range(2):
            scale[5 + row] += (B[row, i] * scale[i]) ** 2
    if not regular:
        scale[5] = scale[6] = max(scale[5], scale[6])
    scale[5], scale[6] = 1.0 / np.sqrt(scale[5]), 1.0 / np.sqrt(scale[6])
    K, rhs = np.zeros((7, 7)), np.empty(7)  # [[B, 0], [M, B^T]] for (qdd, -lambda)
    for row in range(2):
        for i in range(5):
            K[row, i] = K[2 + i, 5 + row] = B[row, i] * scale[i] * scale[5 + row]
        rhs[row] = -Bdot_qd[row] * scale[5 + row]
    for i in range(5):
        for j in range(5):
            K[2 + i, j] = M[i, j] * scale[i] * scale[j]
        rhs[2 + i] = F[i] * scale[i]
    x, condition = solve(K, rhs, 2, 5)
    x *= scale
    qdd, multipliers, force = x[:5].copy(), -x[5:], np.empty(5)
    for i in range(5):
        force[i] = B[0, i] * multipliers[0] + B[1, i] * multipliers[1]
    return qdd, multipliers, force, condition


@kernel
def constraint_moment(q, qd, qdd, p, body):
    """Moment about O of the contact forces, body axes, (3,): rate of angular momentum less applied moment."""
    T, dT = transformation(q)
    V, V_rate, momentum = np.zeros(6), np.zeros(6), np.zeros(6)
    for i in range(6):
        for j in range(5):
            V[i] += T[i, j] * qd[j]
            V_rate[i] += T[i, j] * qdd[j]
            for k in range(2, 5):
                V_rate[i] += qd[k] * dT[k, i, j] * qd[j]
    for i in range(6):
        for j in range(6):
            momentum[i] += body[i, j] * V[j]
    wrench, moment = applied_wrench(q, p), np.empty(3)
    for k in range(3):
        k1, k2 = (k + 1) % 3, (k + 2) % 3
        moment[k] = V[3 + k1] * momentum[3 + k2] - V[3 + k2] * momentum[3 + k1] - wrench[3 + k]
        moment[k] += V[k1] * momentum[k2] - V[k2] * momentum[k1]
        for j in range(6):
            moment[k] += body[3 + k, j] * V_rate[j]
    return moment


@kernel
def contact_forces(q, force, moment, r, L):
    """N_D, N_E (2,) from the constraint forces B^T lambda (5,) and their moment about O (3,).

    B^T lambda are the generalised forces of lambda_D, lambda_E along the outward radii at D = s a + t b and
    E = s a - t b, with a = (cos psi, sin psi), b = (sin psi, -cos psi). Those along a and with theta give
    (lambda_D + lambda_E) (s, t)/r, that along b (lambda_D - lambda_E) t/r. What is left, (lambda_D - lambda_E) s/r,
    does work when the axis tilts towards a; this motion is sin(theta) psi_dot, so q lacks it at theta = 0, and the
    force is taken from the moment instead.

    The wall's force is normal to the journal: N = -lambda sqrt(1 + (D . e_h/(r e_z))^2), and D . e_h/e_z is t^2/L,
    at E -t^2/L.
    """
    c_psi, s_psi = np.cos(q[2]), np.sin(q[2])
    s, t = q[0] * c_psi + q[1] * s_psi, L * np.tan(q[3])
    along, across = force[0] * c_psi + force[1] * s_psi, force[0] * s_psi - force[1] * c_psi
    tilting = force[3] * np.cos(q[3]) ** 2 / L
    turning = (moment[0] * np.sin(q[4]) + moment[1] * np.cos(q[4])) * np.cos(q[3]) / L
    total, difference = (along * s + tilting * t) / r, (across * t + turning * s) / r
    normal = np.sqrt(1 + (t * t / (r * L)) ** 2)
    N = np.empty(2)
    N[0], N[1] = -0.5 * (total + difference) * normal, -0.5 * (total - difference) * normal
    return N


@kernel
def total_energy(q, qd, p, body):
    """Kinetic energy and the potential energy of gravity and of the force at the body point, J."""
    M, _ = mass_matrix(q, body)
    R = rotation(q)
    total = 0.0
    for i in range(5):
        for j in range(5):
            total += 0.5 * qd[i] * M[i, j] * qd[j]
    for i in range(3):
        center = point = q[i] if i < 2 else 0.0
        for k in range(3):
            center += R[i, k] * p[P.COM_X + k]
            point += R[i, k] * p[P.POINT_X + k]
        total -= p[P.MASS] * p[P.GRAVITY_X + i] * center + p[P.FORCE_X + i] * point
    return total


@kernel
def torque_power(q, qd, p):
    """Power of the constant torque, W: torque . omega, omega = psi' Z + theta' (cos psi, sin psi, 0) + phi' e."""
    c_psi, s_psi, s_theta = np.cos(q[2]), np.sin(q[2]), np.sin(q[3])
    x, y, z = p[P.TORQUE_X], p[P.TORQUE_Y], p[P.TORQUE_Z]
    about_axis = x * s_psi * s_theta - y * c_psi * s_theta + z * np.cos(q[3])
    return qd[2] * z + qd[3] * (x * c_psi + y * s_psi) + qd[4] * about_axis
