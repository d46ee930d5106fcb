"""Plain NumPy twin of the paper's formulation, q = [X0, Y0, psi, theta, phi].

Poses, constraints and the equations (13)-(33) as printed are written down; every derivative beyond them is a complex
step or a quarter turn, exact to rounding, so no differentiated formula of the kernels is repeated here.
"""

from __future__ import annotations

import numpy as np

TINY = 1e-30


def derivative(function, q, direction):
    """Derivative of ``function`` at q along ``direction``."""
    return function(q + 1j * TINY * direction).imag / TINY


def gradient(function, q):
    """Derivatives by each q_i, stacked in front."""
    return np.array([derivative(function, q, unit) for unit in np.eye(len(q))])


def rotation(q):
    c, s = np.cos(q[2:]), np.sin(q[2:])
    zero, one = 0 * c[0], 1 + 0 * c[0]
    psi = np.array([[c[0], -s[0], zero], [s[0], c[0], zero], [zero, zero, one]])
    theta = np.array([[one, zero, zero], [zero, c[1], -s[1]], [zero, s[1], c[1]]])
    phi = np.array([[c[2], -s[2], zero], [s[2], c[2], zero], [zero, zero, one]])
    return psi @ theta @ phi


def point(q, body_point):
    """Fixed-axes position of a body point."""
    return np.array([q[0], q[1], 0 * q[0]]) + rotation(q) @ body_point


def ends(q, L):
    """D and E: where the axis crosses Z = L and Z = -L, (2, 2)."""
    axis = rotation(q)[:, 2]
    offset = L * axis[:2] / axis[2]
    return np.array([q[:2] + offset, q[:2] - offset])


def rotation_rate(q, direction):
    """Derivative along ``direction``; R is linear in cos q_i and sin q_i, so quarter turns give it exactly."""
    total = 0
    for i in (2, 3, 4):
        forward, backward = q.copy(), q.copy()
        forward[i], backward[i] = q[i] + np.pi / 2, q[i] - np.pi / 2
        total = total + direction[i] * (rotation(forward) - rotation(backward)) / 2
    return total


def transformation(q):
    """T with (v_O, omega) = T qd in body axes: omega from the skew part of R^T dR/dt."""
    R = rotation(q)
    columns = []
    for i, unit in enumerate(np.eye(5)):
        skew = R.T @ rotation_rate(q, unit)
        linear = R.T @ np.eye(3)[i] if i < 2 else np.zeros(3)
        columns.append(np.concatenate([linear, [skew[2, 1], skew[0, 2], skew[1, 0]]]))
    return np.array(columns).T


def mass_matrix(q, mass, center, inertia):
    x, y, z = center
    S = mass * np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    T = transformation(q)
    return T.T @ np.block([[mass * np.eye(3), S.T], [S, inertia]]) @ T


def generalised_forces(q, qd, mass, center, inertia, gravity, force, force_point, torque):
    """F of (32)."""

    def work(position):
        return mass * gravity @ point(position, center) + force @ point(position, force_point)

    T = transformation(q)
    P = gradient(work, q) + T[3:].T @ (rotation(q).T @ torque)
    M_i = gradient(lambda position: mass_matrix(position, mass, center, inertia), q)
    return P + 0.5 * np.einsum("ijk,j,k", M_i, qd, qd) - np.einsum("i,ijk,k", qd, M_i, qd)


def constraints(q, r, L, regular):
    X, Y, psi, theta, _ = q
    if regular:
        return np.array([X * np.sin(psi) - Y * np.cos(psi), (X**2 + Y**2 + (L * np.tan(theta)) ** 2 - r**2) / 2])
    cos2, sin2 = np.cos(theta) ** 2, np.sin(theta) ** 2
    return np.array(
        [
            (X**2 * cos2 - r**2 * np.cos(psi) ** 2 * cos2 + L**2 * np.cos(psi) ** 2 * sin2) / 2,
            (Y**2 * cos2 - r**2 * np.sin(psi) ** 2 * cos2 + L**2 * np.sin(psi) ** 2 * sin2) / 2,
        ]
    )


def constraint_rows(q, r, L, regular):
    """B: the rows (13) as printed, or the gradients of the regular pair."""
    X, Y, psi, theta, _ = q
    zero = 0 * X
    if regular:
        slope = L**2 * np.tan(theta) / np.cos(theta) ** 2
        along = X * np.cos(psi) + Y * np.sin(psi)
        return np.array([[np.sin(psi), -np.cos(psi), along, zero, zero], [X, Y, zero, slope, zero]])
    cos2 = np.cos(theta) ** 2
    reach = r**2 * cos2 - L**2 * np.sin(theta) ** 2
    turn, tilt = np.sin(2 * psi) / 2, np.sin(2 * theta) / 2
    return np.array(
        [
            [X * cos2, zero, turn * reach, tilt * (-(X**2) + (r**2 + L**2) * np.cos(psi) ** 2), zero],
            [zero, Y * cos2, -turn * reach, tilt * (-(Y**2) + (r**2 + L**2) * np.sin(psi) ** 2), zero],
        ]
    )


def solution(q, qd, M, F, r, L, regular):
    """Accelerations (5,), multipliers (2,), and contact forces (2,) by mapping B^T lambda to the outward radii."""
    B = constraint_rows(q, r, L, regular)
    Bdot = derivative(lambda position: constraint_rows(position, r, L, regular), q, qd)
    x = np.linalg.solve(np.block([[M, -B.T], [B, np.zeros((2, 2))]]), np.concatenate([F, -Bdot @ qd]))
    multipliers = x[5:]
    D, E = ends(q, L)
    by_q = gradient(lambda position: ends(position, L), q)  # (5, end, 2)
    outward = np.einsum("qei,ei->qe", by_q, np.array([D, E]) / r)
    radial = np.linalg.lstsq(outward, B.T @ multipliers)[0]
    axis = rotation(q)[:, 2]
    sines = np.array([D @ axis[:2], E @ axis[:2]]) / (r * axis[2])
    return x[:5], multipliers, -radial * np.sqrt(1 + sines**2)
