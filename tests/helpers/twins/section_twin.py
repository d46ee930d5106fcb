"""Plain NumPy twin of the exact section: q = [X0, Y0, u, v] and Omega, the gaps of the rims as constraints.

Written from the definition of the gap alone: the distance between a rim's point and the axis, minimised over
the rim, its gradients by the envelope theorem, their time derivatives by complex steps, and Kane's equations
in fixed axes with Lagrange multipliers. Nothing is shared with the kernels, neither coordinates nor formulas.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import root


@dataclass(frozen=True)
class Bearing:
    """R*, r* and L, m."""

    R: float
    r: float
    L: float


@dataclass(frozen=True)
class Body:
    """SI units; centre of mass, inertia about O and force point in body axes, loads in fixed axes."""

    mass: float
    center: np.ndarray
    inertia: np.ndarray
    gravity: np.ndarray
    force: np.ndarray
    force_point: np.ndarray
    torque: np.ndarray


def rim_distance(phi, p, e_h, R):
    """Distance from the axis of the rim's point at the angle phi; the axis passes the rim's plane at p."""
    w = R * np.array([np.cos(phi), np.sin(phi)]) - p
    return np.sqrt(w @ w - (w @ e_h) ** 2)


def _nearest(p, e_h, R):
    """w = R n - p for the rim's nearest point, by Newton from the direction of p; also for complex p."""
    phi = np.arctan2(p[1].real, p[0].real)
    for _ in range(20):
        n = np.array([np.cos(phi), np.sin(phi)])
        w, w1, w2 = R * n - p, R * np.array([-n[1], n[0]]), -R * n
        slope = w @ w1 - (w @ e_h) * (w1 @ e_h)
        phi = phi - slope / (w1 @ w1 + w @ w2 - (w1 @ e_h) ** 2 - (w @ e_h) * (w2 @ e_h))
    return R * np.array([np.cos(phi), np.sin(phi)]) - p


def gaps(bearing: Bearing, q) -> np.ndarray:
    """g_D, g_E."""
    e_h = q[2:] / np.sqrt(q[2:] @ q[2:] + bearing.L**2)
    rims = (_nearest(p, e_h, bearing.R) for p in (q[:2] + q[2:], q[:2] - q[2:]))
    return np.array([np.sqrt(w @ w - (w @ e_h) ** 2) for w in rims]) - bearing.r


def rows(bearing: Bearing, q) -> np.ndarray:
    """Gradients of g_D and g_E by q, shape (2, 4)."""
    length = np.sqrt(q[2:] @ q[2:] + bearing.L**2)
    e_h = q[2:] / length
    turn = (np.eye(2) - np.outer(e_h, e_h)) / length
    result = []
    for sign in (1, -1):
        w = _nearest(q[:2] + sign * q[2:], e_h, bearing.R)
        s = np.sqrt(w @ w - (w @ e_h) ** 2)
        by_p, by_e = (-w + (w @ e_h) * e_h) / s, -(w @ e_h) * w / s
        result.append(np.concatenate([by_p, sign * by_p + by_e @ turn]))
    return np.array(result)


def start(bearing: Bearing, alpha, beta, alpha_rate, beta_rate):
    """q (4,) and its rate from the polar angles of D and E and their rates."""
    d, e = (np.array([np.cos(angle), np.sin(angle)]) for angle in (alpha, beta))
    d1, e1 = np.array([-d[1], d[0]]), np.array([-e[1], e[0]])
    clearance = bearing.R - bearing.r

    def q(distances):
        D, E = clearance * distances[0] * d, clearance * distances[1] * e
        return np.concatenate([D + E, D - E]) / 2

    found = root(lambda x: gaps(bearing, q(x)) / clearance, [1.0, 1.0], tol=1e-14)
    D, E = clearance * found.x[0] * d1 * alpha_rate, clearance * found.x[1] * e1 * beta_rate
    tangential = np.concatenate([D + E, D - E]) / 2
    radial = np.array([np.concatenate([d, d]), np.concatenate([e, -e])]).T / 2
    B = rows(bearing, q(found.x))
    return q(found.x), tangential - radial @ np.linalg.solve(B @ radial, B @ tangential)


def rotation(q, chi, L) -> np.ndarray:
    """Body axes as columns: the smallest rotation from Z to the axis, then chi about it."""
    e = np.array([q[2], q[3], L]) / np.sqrt(q[2:] @ q[2:] + L**2)
    bisector = (e + np.array([0, 0, 1])) / (1 + e[2])
    f1, f2 = np.array([1, 0, 0]) - e[0] * bisector, np.array([0, 1, 0]) - e[1] * bisector
    return np.stack([np.cos(chi) * f1 + np.sin(chi) * f2, np.cos(chi) * f2 - np.sin(chi) * f1, e], axis=1)


def _velocities(q, q_rate, L):
    e = np.array([q[2], q[3], L]) / np.sqrt(q[2:] @ q[2:] + L**2)
    w_rate = np.array([*q_rate[2:], 0.0])
    length = np.sqrt(q[2:] @ q[2:] + L**2)
    return e, length, (w_rate - e * (e @ w_rate)) / length


def accelerations(bearing: Bearing, body: Body, q, q_rate, chi, spin_rate):
    """Accelerations of q and Omega (5,) and the contact forces N_D, N_E."""
    e, length, e_rate = _velocities(q, q_rate, bearing.L)
    R = rotation(q, chi, bearing.L)
    c, J = R @ body.center, R @ body.inertia @ R.T
    omega = np.cross(e, e_rate) + spin_rate * e
    stretch = (q[2:] @ q_rate[2:]) / length**2
    omega_rate = np.cross(e, -2 * stretch * e_rate - e * (e_rate @ e_rate)) + spin_rate * e_rate

    v, w = np.zeros((5, 3)), np.zeros((5, 3))
    v[0, 0] = v[1, 1] = 1
    for k in range(2):
        w[2 + k] = np.cross(e, np.eye(3)[k]) / length
    w[4] = e
    coupling = body.mass * v @ np.cross(w, c).T
    M = body.mass * v @ v.T + coupling + coupling.T + w @ J @ w.T
    a_c = np.cross(omega_rate, c) + np.cross(omega, np.cross(omega, c))
    force = body.mass * (body.gravity - a_c) + body.force
    moment = np.cross(c, body.mass * body.gravity) + np.cross(R @ body.force_point, body.force) + body.torque
    moment = moment - J @ omega_rate - np.cross(omega, J @ omega)

    step = 1e-20
    B = rows(bearing, q)
    B_rate = rows(bearing, q + 1j * step * q_rate).imag / step
    B = np.hstack([B, np.zeros((2, 1))])
    solution = np.linalg.solve(
        np.block([[M, -B.T], [B, np.zeros((2, 2))]]),
        np.concatenate([v @ force + w @ moment, -B_rate @ q_rate]),
    )
    return solution[:5], solution[5:]


def energy(bearing: Bearing, body: Body, q, q_rate, chi, spin_rate) -> float:
    """Kinetic energy and potential energy of gravity and force."""
    e, _, e_rate = _velocities(q, q_rate, bearing.L)
    R = rotation(q, chi, bearing.L)
    omega, origin, v = np.cross(e, e_rate) + spin_rate * e, np.array([*q[:2], 0]), np.array([*q_rate[:2], 0])
    kinetic = body.mass * (v @ v / 2 + v @ np.cross(omega, R @ body.center))
    kinetic += omega @ R @ body.inertia @ R.T @ omega / 2
    potential = -body.mass * body.gravity @ (origin + R @ body.center) - body.force @ (origin + R @ body.force_point)
    return kinetic + potential
