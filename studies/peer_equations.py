"""Equations of the joint with a symmetric body, in the forms that suit other people's integrators.

Canonical form. The ends D, E of the axis stay on circles of radius r at the polar angles alpha, beta, so that
sigma = (alpha + beta)/2 and delta = (alpha - beta)/2 are coordinates without constraints. With Omega constant (Routh), all
divided by m r^2, and q = sin^2 delta, n = cos(tilt) = (1 + q r^2/L^2)^(-1/2), y = n^2, K = 1 + r^2/L^2:

    T  = 1/2 a11 sigma'^2 + a12 sigma' delta' + 1/2 a22 delta'^2 + n C Omega/(m r^2) sigma'
    a11 = 1 - q + (1 - y) A/(m r^2)     a22 = q + y (K y - 1) A/(m r^2)     a12 = (z_C/L) n ((y - 1) L^2/r^2 + y + q)
    V  = (g/r) (cos delta sin sigma + (z_C/L) n sin delta cos sigma)          gravity (0, -g, 0)

Regular at every pose. Instead of the angles, the cosines and sines of alpha, beta and alpha - beta are integrated: plain
products are cheaper to a Taylor integrator than its sine and cosine.

Cartesian form: D and E themselves and their rates, accelerations along the circles from a 2x2 system (README, Model).

Slope form: M v' = F + B^T lambda, B v' = b in [X0, Y0, u, v, chi] as matrices (README, Model).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable

from tolmc.mechanism import geometry
from tolmc.mechanism.scene import Scene

Samples = Mapping[str, np.ndarray]

FLAGS = {"error_model": "numpy", "fastmath": {"contract", "nsz", "arcp"}}
#: For plain arithmetic that heyoka's expressions, NumPy arrays and compiled code share.
for_numbers_and_expressions = register_jitable(forceinline=True, **FLAGS)


class Coefficients(NamedTuple):
    """Dimensionless numbers of a sample, and the products of them that stand before a variable in the equations.

    A Taylor integrator multiplies a variable by a number in one operation an order, by an expression in as many as the order.
    """

    A: object  # A/(m r^2)
    s: object  # L^2/r^2
    z: object  # z_C/L
    C: object  # C Omega/(m r^2)
    g: object  # g/r
    inverse_s: object
    one_A: object  # 1 + A
    A_K: object  # A (1 + 1/s)
    A_s: object  # A/s
    A_K_s: object  # 2 A (1 + 1/s)/s
    z_s: object  # z s
    z_1s: object  # z (1 + s)
    z_half: object  # z/2
    z_K: object  # 3/2 z (1 + 1/s)
    C_s: object  # C/(2 s)
    z_g: object  # z g


@for_numbers_and_expressions
def unpacked(p):
    """Coefficients from an array of them."""
    return Coefficients(
        p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], p[8], p[9], p[10], p[11], p[12], p[13], p[14], p[15]
    )


def coefficients(scene: Scene, samples: Samples) -> Coefficients:
    """Coefficients of each sample, arrays (n,), for a symmetric body under gravity along -Y."""
    body, (gx, gy, gz), motion = scene.body, scene.loads.gravity, scene.motion
    if not body.is_symmetric or gx or gz or gy > 0 or scene.loads.force or scene.loads.torque:
        raise ValueError("peers: the scene must have a symmetric body and gravity (0, -g, 0) as its only load.")
    r = effective_radius(samples)
    L = np.asarray(samples["half_length"], float)
    A, C = body.inertia[0, 0] / (body.mass * r * r), body.inertia[2, 2] * motion.spin_rate / (body.mass * r * r)
    s, z, g = (L / r) ** 2, body.center_of_mass[2] / L, -gy / r
    K = 1 + 1 / s
    return Coefficients(
        A=A, s=s, z=z, C=C, g=g, inverse_s=1 / s, one_A=1 + A, A_K=A * K, A_s=A / s, A_K_s=2 * A * K / s,
        z_s=z * s, z_1s=z * (1 + s), z_half=z / 2, z_K=1.5 * z * K, C_s=C / (2 * s), z_g=z * g,
    )  # fmt: skip


def effective_radius(samples: Samples) -> np.ndarray:
    """r of each sample, m."""
    return geometry.effective_radius(samples["bearing_radius"], samples["journal_radius"], samples["half_length"])


@for_numbers_and_expressions
def mass_matrix(q, n, k):
    """a11, a12, a22."""
    y = n * n
    a11 = k.one_A - q - k.A * y
    a12 = n * (k.z_1s * y - k.z_s + k.z * q)
    a22 = q + k.A_K * (y * y) - k.A * y
    return a11, a12, a22


@for_numbers_and_expressions
def mass_derivatives(n, k):
    """Derivatives of a11, a12, a22 and of n C Omega/(m r^2) with respect to q."""
    y = n * n
    y2 = y * y
    a11 = k.A_s * y2 - 1.0
    a12 = n * (k.z_half + k.z * y - k.z_K * y2)
    a22 = 1.0 - k.A_K_s * (y * y2) + k.A_s * y2
    return a11, a12, a22, -k.C_s * (n * y)


@for_numbers_and_expressions
def solve_symmetric(a11, a12, a22, b1, b2):
    """Solution of the symmetric 2x2 system; elimination takes fewer products than the determinant."""
    t = a12 / a11
    x2 = (b2 - t * b1) / (a22 - t * a12)
    return b1 / a11 - t * x2, x2


@for_numbers_and_expressions
def load_terms(x, n, k):
    """-dV/dsigma, -dV/ddelta."""
    cos_cos, sin_sin = 0.5 * (x[0] + x[2]), 0.5 * (x[2] - x[0])  # cos delta cos sigma, sin delta sin sigma
    return k.z_g * (n * sin_sin) - k.g * cos_cos, k.g * sin_sin - k.z_g * ((n * (n * n)) * cos_cos)


@for_numbers_and_expressions
def canonical_rates(x, n, k):
    """Time derivative of x = (cos alpha, sin alpha, cos beta, sin beta, cos 2 delta, sin 2 delta, p_sigma, p_delta).

    n is (1 + q r^2/L^2)^(-1/2): left to the caller, because each library has its own cheapest way.
    """
    cos_a, sin_a, cos_b, sin_b, cos_2d, sin_2d, p1, p2 = x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7]
    q = 0.5 - 0.5 * cos_2d
    a11, a12, a22 = mass_matrix(q, n, k)
    d11, d12, d22, dC = mass_derivatives(n, k)
    v1, v2 = solve_symmetric(a11, a12, a22, p1 - k.C * n, p2)
    load1, load2 = load_terms(x, n, k)
    alpha_rate, beta_rate = v1 + v2, v1 - v2
    p2_rate = sin_2d * (v1 * (0.5 * (d11 * v1) + d12 * v2 + dC) + 0.5 * (d22 * (v2 * v2))) + load2
    return (
        -sin_a * alpha_rate, cos_a * alpha_rate, -sin_b * beta_rate, cos_b * beta_rate,
        -sin_2d * (2.0 * v2), cos_2d * (2.0 * v2), load1, p2_rate,
    )  # fmt: skip


@for_numbers_and_expressions
def radial_forces(x, n, k):
    """Radial parts of N_D, N_E over m r: the multipliers of |D| = r and |E| = r with the other sign."""
    cos_2d, sin_2d = x[4], x[5]
    q = 0.5 - 0.5 * cos_2d
    a11, a12, a22 = mass_matrix(q, n, k)
    d11, d12, d22, dC = mass_derivatives(n, k)
    v1, v2 = solve_symmetric(a11, a12, a22, x[6] - k.C * n, x[7])
    load1, load2 = load_terms(x, n, k)
    b1 = load1 - sin_2d * v2 * (d11 * v1 + d12 * v2 + dC)
    b2 = load2 + sin_2d * (v1 * (0.5 * d11 * v1 + dC) - 0.5 * d22 * v2 * v2)
    w1, w2 = solve_symmetric(a11, a12, a22, b1, b2)
    y = n * n
    K = 1.0 + k.inverse_s
    cos_sin, sin_cos = 0.5 * (x[1] + x[3]), 0.5 * (x[1] - x[3])  # cos delta sin sigma, sin delta cos sigma
    total = (
        k.g * (cos_sin + k.z * n * y * sin_cos)
        + 0.5 * sin_2d * (w2 * (k.A_s * y * y - 1.0) + k.z * n * (y - 1.0) * w1)
        + v2 * v2 * (q - 1.0 + k.A * y * (2.0 * K * y * y - (3.0 + 2.0 * k.inverse_s) * y + 1.0))
        + v1 * v1 * (q - 1.0 + k.A * y * (y - 1.0))
        + k.C * n * (1.0 - y) * v1
        - 2.0 * k.z * n * y * v1 * v2
    )
    difference = (
        k.g * (sin_cos + k.z * n * cos_sin)
        + 0.5 * sin_2d * (w1 * (1.0 - k.A_s * y) + k.z * n * (y - 1.0) * w2)
        + 2.0 * v1 * v2 * (k.A * y * (1.0 - K * y) - q)
        + k.C * n * (K * y - 1.0) * v2
        + k.z * n * (v2 * v2 * (3.0 * (1.0 + k.s) * y * y - (5.0 * k.s + 3.0) * y + 2.0 * k.s - 1.0 + q) - v1 * v1)
    )
    return -0.5 * (total + difference), -0.5 * (total - difference)


@for_numbers_and_expressions
def contact_forces(x, k):
    """N_D, N_E over m r."""
    q = 0.5 - 0.5 * x[4]
    force_D, force_E = radial_forces(x, 1.0 / math.sqrt(1.0 + k.inverse_s * q), k)
    oblique = math.sqrt(1.0 + k.inverse_s * (q * q))  # the wall pushes perpendicular to the axis, not radially
    return oblique * force_D, oblique * force_E


def canonical_start(scene: Scene, k: Coefficients) -> np.ndarray:
    """State x (8, n) at time 0."""
    motion = scene.motion
    a, b = motion.alpha, motion.beta
    v1, v2 = (motion.alpha_rate + motion.beta_rate) / 2, (motion.alpha_rate - motion.beta_rate) / 2
    q = np.sin((a - b) / 2) ** 2
    n = (1 + k.inverse_s * q) ** -0.5
    a11, a12, a22 = mass_matrix(q, n, k)
    angles = np.array([np.cos(a), np.sin(a), np.cos(b), np.sin(b), np.cos(a - b), np.sin(a - b)])
    momenta = np.array([a11 * v1 + a12 * v2 + k.C * n, a12 * v1 + a22 * v2])
    return np.concatenate([np.broadcast_to(angles[:, None], (6, momenta.shape[1])), momenta])


def pose(x: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Origin/r and axis (n, 5) of the states x (8 or more, n), with s = L^2/r^2."""
    D, E = x[0:2], x[2:4]
    w = (D - E) / 2
    length = np.sqrt(s + (w * w).sum(axis=0))
    return np.concatenate([(D + E) / 2, w / length, [np.sqrt(s) / length]]).T


class CartesianCoefficients(NamedTuple):
    """Dimensionless numbers of a sample: L/r, z_C/r, A/(m r^2), C Omega/(m r^2), g/r."""

    L: object
    z: object
    A: object
    C: object
    g: object


def cartesian_coefficients(k: Coefficients) -> CartesianCoefficients:
    """The numbers of the Cartesian form."""
    return CartesianCoefficients(np.sqrt(k.s), k.z * np.sqrt(k.s), k.A, k.C, k.g)


def cartesian_start(scene: Scene, k: Coefficients) -> np.ndarray:
    """(D, E, D', E')/r at time 0, shape (8, n)."""
    motion = scene.motion
    angles, rates = np.array([motion.alpha, motion.beta]), np.array([motion.alpha_rate, motion.beta_rate])
    unit = np.array([np.cos(angles), np.sin(angles)])
    turned = np.array([-unit[1], unit[0]]) * rates
    state = np.concatenate([unit.T.ravel(), turned.T.ravel()])
    return np.repeat(state[:, None], len(k.s), axis=1)


def cartesian_rates(x, inverse_length, k):
    """Time derivative of x = (D, E, D', E')/r; inverse_length(w^2 + L^2) is the library's x^(-1/2)."""
    Dx, Dy, Ex, Ey, Dx1, Dy1, Ex1, Ey1 = x
    u, v, u1, v1 = 0.5 * (Dx - Ex), 0.5 * (Dy - Ey), 0.5 * (Dx1 - Ex1), 0.5 * (Dy1 - Ey1)
    inverse = inverse_length(u * u + v * v + k.L * k.L)
    square = inverse * inverse
    ex, ey, ez = u * inverse, v * inverse, k.L * inverse
    rho = (u * u1 + v * v1) * square
    ex1, ey1, ez1 = u1 * inverse - rho * ex, v1 * inverse - rho * ey, -rho * ez
    bend = ex1 * ex1 + ey1 * ey1 + ez1 * ez1
    # Loads and velocity terms on O and on w.
    fOx, fOy = k.z * (2.0 * rho * ex1 + ex * bend), k.z * (2.0 * rho * ey1 + ey * bend) - k.g
    fwx = inverse * (k.z * (k.g * (ex * ey)) + 2.0 * k.A * rho * ex1 - k.C * (ey1 * ez - ez1 * ey))
    fwy = inverse * (k.z * (k.g * (ey * ey) - k.g) + 2.0 * k.A * rho * ey1 - k.C * (ez1 * ex - ex1 * ez))
    # Centripetal accelerations of O and w, and what M makes of them.
    D2, E2 = Dx1 * Dx1 + Dy1 * Dy1, Ex1 * Ex1 + Ey1 * Ey1
    ax, ay, bx, by = (
        -0.5 * (Dx * D2 + Ex * E2), -0.5 * (Dy * D2 + Ey * E2), -0.5 * (Dx * D2 - Ex * E2), -0.5 * (Dy * D2 - Ey * E2)
    )  # fmt: skip
    k1, k2 = k.z * inverse, k.A * square
    along_a, along_b = ex * ax + ey * ay, ex * bx + ey * by
    Pax, Pay, Pbx, Pby = ax - ex * along_a, ay - ey * along_a, bx - ex * along_b, by - ey * along_b
    Ox, Oy = fOx - ax - k1 * Pbx, fOy - ay - k1 * Pby
    wx, wy = fwx - k1 * Pax - k2 * Pbx, fwy - k1 * Pay - k2 * Pby
    # The 2x2 system for the accelerations along the circles.
    cross, dot = Dx * Ey - Dy * Ex, Dx * Ex + Dy * Ey
    c2 = 0.25 * (cross * cross * square)
    DD, EE = 0.25 * (1.0 + (2.0 * k1 + k2) * (1.0 - c2)), 0.25 * (1.0 + (k2 - 2.0 * k1) * (1.0 - c2))
    tau_D, tau_E = solve_symmetric(
        DD, 0.25 * (dot - k2 * (dot - c2)), EE,
        0.5 * (Dx * (Oy + wy) - Dy * (Ox + wx)), 0.5 * (Ex * (Oy - wy) - Ey * (Ox - wx)),
    )  # fmt: skip
    return (
        Dx1, Dy1, Ex1, Ey1,
        -tau_D * Dy - Dx * D2, tau_D * Dx - Dy * D2, -tau_E * Ey - Ex * E2, tau_E * Ex - Ey * E2,
    )  # fmt: skip


class Constants(NamedTuple):
    """Mass, z_C, A, C, L, r and the load at the centre of mass of one sample, SI units."""

    m: float
    z: float
    A: float
    C: float
    L: float
    r: float
    force: np.ndarray


def constants(scene: Scene, samples: Samples) -> list[Constants]:
    """Constants of each sample."""
    body = scene.body
    A, C = float(body.inertia[0, 0]), float(body.inertia[2, 2])
    force = body.mass * np.array(scene.loads.gravity)
    pairs = zip(samples["half_length"], effective_radius(samples), strict=True)
    return [Constants(body.mass, body.center_of_mass[2], A, C, float(L), float(r), force) for L, r in pairs]


def slope_equations(q, v, k):
    """M (5, 5), F (5,), B (2, 5), b (2,) of M v' = F + B^T lambda, B v' = b; q = (X0, Y0, u, v, chi), v = (q', Omega)."""
    w, w_rate = q[2:4], v[2:4]
    squared = w[0] * w[0] + w[1] * w[1] + k.L * k.L
    length = np.sqrt(squared)
    e, e_z = w / length, k.L / length
    rho = (w[0] * w_rate[0] + w[1] * w_rate[1]) / squared
    e_rate, e_z_rate = w_rate / length - rho * e, -rho * e_z
    bend = -2 * rho * e_rate - e * (e_rate[0] ** 2 + e_rate[1] ** 2 + e_z_rate**2)
    turn = np.array([e_rate[1] * e_z - e_z_rate * e[1], e_z_rate * e[0] - e_rate[0] * e_z])
    along = k.force[0] * e[0] + k.force[1] * e[1] + k.force[2] * e_z
    P = np.eye(2) - np.outer(e, e)
    M = np.zeros((5, 5))
    M[0, 0] = M[1, 1] = k.m
    M[0:2, 2:4] = M[2:4, 0:2] = (k.m * k.z / length) * P
    M[2:4, 2:4] = (k.A / squared) * P
    M[4, 4] = k.C
    F = np.zeros(5)
    F[0:2] = k.force[0:2] - (k.m * k.z) * bend
    F[2:4] = (k.z * (k.force[0:2] - along * e) + (2 * k.A * rho) * e_rate - (k.C * v[4]) * turn) / length
    D, E = q[0:2] + w, q[0:2] - w
    D_rate, E_rate = v[0:2] + w_rate, v[0:2] - w_rate
    B = np.zeros((2, 5))
    B[0, 0:2] = B[0, 2:4] = D / k.r
    B[1, 0:2] = E / k.r
    B[1, 2:4] = -E / k.r
    b = -np.array([D_rate[0] ** 2 + D_rate[1] ** 2, E_rate[0] ** 2 + E_rate[1] ** 2]) / k.r
    return M, F, B, b


def chi_rate(q, v, k):
    """chi' = Omega + (u v' - v u')/(l (l + L))."""
    length = np.sqrt(q[2] * q[2] + q[3] * q[3] + k.L * k.L)
    return v[4] + (q[2] * v[3] - q[3] * v[2]) / (length * (length + k.L))


def slope_start(scene: Scene, k: Constants) -> np.ndarray:
    """(q, v) at time 0."""
    motion = scene.motion
    angles, rates = np.array([motion.alpha, motion.beta]), np.array([motion.alpha_rate, motion.beta_rate])
    ends = k.r * np.array([np.cos(angles), np.sin(angles)])
    end_rates = k.r * rates * np.array([-np.sin(angles), np.cos(angles)])
    half = 0.5 * np.array([[1.0, 1.0], [1.0, -1.0]])
    q, v = ((half @ values.T).ravel() for values in (ends, end_rates))
    return np.concatenate([q, [motion.spin], v, [motion.spin_rate]])


def accelerations(y, k):
    """v' and multipliers of the state y = (q, v)."""
    M, F, B, b = slope_equations(y[:5], y[5:10], k)
    matrix = np.block([[M, -B.T], [B, np.zeros((2, 2))]])
    solution = np.linalg.solve(matrix, np.concatenate([F, b]))
    return solution[:5], solution[5:]


def canonical_state(y: np.ndarray, r: np.ndarray, k: Coefficients) -> np.ndarray:
    """Canonical state (8, ...) of slope states y = (q, v, ...) (10 or more, ...); r in m."""
    D, E = y[0:2] + y[2:4], y[0:2] - y[2:4]
    D_rate, E_rate = y[5:7] + y[7:9], y[5:7] - y[7:9]
    (ca, sa), (cb, sb) = D / np.hypot(*D), E / np.hypot(*E)
    alpha_rate, beta_rate = (ca * D_rate[1] - sa * D_rate[0]) / r, (cb * E_rate[1] - sb * E_rate[0]) / r
    v1, v2 = (alpha_rate + beta_rate) / 2, (alpha_rate - beta_rate) / 2
    cos_2d, sin_2d = ca * cb + sa * sb, sa * cb - ca * sb
    q = 0.5 - 0.5 * cos_2d
    n = (1 + k.inverse_s * q) ** -0.5
    a11, a12, a22 = mass_matrix(q, n, k)
    return np.array([ca, sa, cb, sb, cos_2d, sin_2d, a11 * v1 + a12 * v2 + k.C * n, a12 * v1 + a22 * v2])
