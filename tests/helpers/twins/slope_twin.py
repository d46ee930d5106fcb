"""Plain NumPy twin: the general body in slope coordinates [X0, Y0, u, v, chi], speeds [X0', Y0', u', v', Omega].

Kane's equations in fixed axes and the constraints |D| = |E| = r, integrated by SciPy's DOP853 at a tolerance near
rounding. Slow and written for reading: it is what the compiled kernels are compared with.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from twins.vectors import cross, cross_matrix


@dataclass(frozen=True)
class Mechanism:
    """A motion's constants as vectors, from the scalars of a scene."""

    r: float
    L: float
    mass: float
    center: np.ndarray
    inertia: np.ndarray
    gravity: np.ndarray
    force: np.ndarray
    force_point: np.ndarray
    torque: np.ndarray

    @classmethod
    def from_scalars(cls, scalars: Mapping[str, float]) -> Mechanism:
        R, rj, L = (scalars[name] for name in ("bearing_radius", "journal_radius", "half_length"))
        t = (R - rj) / (L + np.sqrt(L**2 + R**2 - rj**2))

        def vector(name):
            return np.array([scalars[f"{name}_{axis}"] for axis in "xyz"])

        J = {pair: scalars[f"inertia_{pair}"] for pair in ("xx", "yy", "zz", "xy", "xz", "yz")}
        return cls(
            r=2 * L * t / (1 - t**2),
            L=L,
            mass=scalars["mass"],
            center=vector("center_of_mass"),
            inertia=np.array([[J["xx"], J["xy"], J["xz"]], [J["xy"], J["yy"], J["yz"]], [J["xz"], J["yz"], J["zz"]]]),
            gravity=vector("gravity"),
            force=vector("force"),
            force_point=vector("force_point"),
            torque=vector("torque"),
        )


def start(mechanism: Mechanism, scalars: Mapping[str, float]) -> np.ndarray:
    """State (10,) from the polar angles of D and E, their rates, chi and Omega."""
    polar = np.array([scalars["alpha"], scalars["beta"]])
    rates = np.array([scalars["alpha_rate"], scalars["beta_rate"]])
    D, E = mechanism.r * np.stack([np.cos(polar), np.sin(polar)], axis=1)
    D_rate, E_rate = mechanism.r * rates[:, None] * np.stack([-np.sin(polar), np.cos(polar)], axis=1)
    return np.concatenate(
        [
            (D + E) / 2, (D - E) / 2, [scalars["spin"]],
            (D_rate + E_rate) / 2, (D_rate - E_rate) / 2, [scalars["spin_rate"]],
        ]
    )  # fmt: skip


def body_axes(w: np.ndarray, chi: float, L: float) -> np.ndarray:
    """Rotation matrix: minimal rotation from Z to the axis, then chi about it."""
    e = np.array([*w, L]) / np.sqrt(w @ w + L**2)
    bisector = np.array([e[0], e[1], e[2] + 1]) / (1 + e[2])
    f1, f2 = np.array([1, 0, 0]) - e[0] * bisector, np.array([0, 1, 0]) - e[1] * bisector
    return np.stack([np.cos(chi) * f1 + np.sin(chi) * f2, -np.sin(chi) * f1 + np.cos(chi) * f2, e], axis=1)


def equations(mechanism: Mechanism, state: np.ndarray):
    """Accelerations (5,) of [X0, Y0, u, v] and Omega', multipliers lambda_D, lambda_E, body axes, chi'."""
    k = mechanism
    origin, w, chi = state[:2], state[2:4], state[4]
    origin_rate, w_rate, spin_rate = state[5:7], state[7:9], state[9]
    length = np.sqrt(w @ w + k.L**2)
    R = body_axes(w, chi, k.L)
    e = R[:, 2]
    stretch = w @ w_rate / length**2
    e_rate = (np.array([*w_rate, 0]) - e * (e[:2] @ w_rate)) / length
    omega = cross(e, e_rate) + spin_rate * e
    c, J = R @ k.center, R @ k.inertia @ R.T

    partial_v = np.zeros((5, 3))
    partial_v[0, 0] = partial_v[1, 1] = 1
    partial_omega = np.zeros((5, 3))
    partial_omega[2:4] = cross_matrix(e)[:, :2].T / length  # e x (x - e_1 e), e x (y - e_2 e)
    partial_omega[4] = e

    omega_rate = cross(e, -2 * stretch * e_rate - e * (e_rate @ e_rate)) + spin_rate * e_rate
    a_C = cross(omega_rate, c) + cross(omega, cross(omega, c))
    force = k.mass * k.gravity + k.force
    moment = cross(c, k.mass * k.gravity) + cross(R @ k.force_point, k.force) + k.torque
    coupling = -k.mass * partial_v @ cross_matrix(c) @ partial_omega.T
    M = k.mass * partial_v @ partial_v.T + coupling + coupling.T + partial_omega @ J @ partial_omega.T
    bias = partial_v @ (k.mass * a_C) + partial_omega @ (J @ omega_rate + cross(omega, J @ omega))
    applied = partial_v @ force + partial_omega @ moment

    D, E = origin + w, origin - w
    D_rate, E_rate = origin_rate + w_rate, origin_rate - w_rate
    B = np.array([[*D, *D, 0], [*E, *-E, 0]]) / k.r
    centripetal = -np.array([D_rate @ D_rate, E_rate @ E_rate]) / k.r
    system = np.zeros((7, 7))
    system[:5, :5], system[:5, 5:], system[5:, :5] = M, -B.T, B
    solution = np.linalg.solve(system, np.concatenate([applied - bias, centripetal]))
    chi_rate = spin_rate + (w[0] * w_rate[1] - w[1] * w_rate[0]) / (length * (length + k.L))
    return solution[:5], solution[5:], R, chi_rate


def energy(mechanism: Mechanism, state: np.ndarray) -> float:
    """Kinetic energy and potential energy of gravity and force."""
    k = mechanism
    w, w_rate = state[2:4], state[7:9]
    R = body_axes(w, state[4], k.L)
    e = R[:, 2]
    e_rate = (np.array([*w_rate, 0]) - e * (e[:2] @ w_rate)) / np.sqrt(w @ w + k.L**2)
    omega = cross(e, e_rate) + state[9] * e
    origin, v = np.array([*state[:2], 0]), np.array([*state[5:7], 0])
    kinetic = k.mass * (v @ v / 2 + v @ cross(omega, R @ k.center))
    kinetic += omega @ R @ k.inertia @ R.T @ omega / 2
    return kinetic - k.mass * k.gravity @ (origin + R @ k.center) - k.force @ (origin + R @ k.force_point)


@dataclass(frozen=True)
class TwinTrajectory:
    time: np.ndarray  # (n,)
    origin: np.ndarray  # (n, 2)
    axis: np.ndarray  # (n, 3)
    rotation: np.ndarray  # (n, 3, 3), body to fixed axes
    contact_force: np.ndarray  # (n, 2), N_D and N_E
    multipliers: np.ndarray  # (n, 2), lambda_D and lambda_E, forces along the outward radii
    energy: np.ndarray  # (n,)
    state: np.ndarray  # (n, 10)


def integrate(scalars: Mapping[str, float], times: np.ndarray, tolerance: float = 1e-13) -> TwinTrajectory:
    """The motion of a scene (``Scene.scalars``) at the given times, the first of which is its start."""
    k = Mechanism.from_scalars(scalars)

    def rates(_, state):
        acceleration, _, _, chi_rate = equations(k, state)
        return np.concatenate([state[5:9], [chi_rate], acceleration])

    first = start(k, scalars)
    # In the size of each component, so that small bearings are as accurate as large ones.
    speed = k.r + np.abs(first[5:9]).max()
    scale = np.array([k.r] * 4 + [1.0] + [speed] * 4 + [1.0 + abs(first[9])])
    solution = solve_ivp(
        rates, (times[0], times[-1]), first, "DOP853", t_eval=times, rtol=tolerance, atol=tolerance * scale
    )
    assert solution.success, solution.message
    states = solution.y.T
    parts = [equations(k, state) for state in states]
    multipliers = np.array([part[1] for part in parts])
    ends = np.stack([states[:, :2] + states[:, 2:4], states[:, :2] - states[:, 2:4]], axis=1)
    normal = np.sqrt(1 + (np.einsum("nki,ni->nk", ends, states[:, 2:4]) / (k.r * k.L)) ** 2)
    rotation = np.array([part[2] for part in parts])
    return TwinTrajectory(
        time=solution.t,
        origin=states[:, :2],
        axis=rotation[:, :, 2],
        rotation=rotation,
        contact_force=-multipliers * normal,
        multipliers=multipliers,
        energy=np.array([energy(k, state) for state in states]),
        state=states,
    )
