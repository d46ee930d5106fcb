"""Exact section: geometry against brute force, dynamics against the twin, motions against the reference."""

import itertools
import json
import math
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest
from from_python import called
from places import DATA
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar
from twins import section_twin as twin

from tolmc.kernels.formulations import exact_section
from tolmc.mechanism import geometry

_PIECES = ("shape", "symmetric", "general", "project", "gap", "start")
section = SimpleNamespace(**{name: called(getattr(exact_section, name)) for name in _PIECES})

REFERENCE = json.loads((DATA / "exact_section.json").read_text())

# Clearance ratio (R - r)/r and slenderness L/r, beyond anything that is built.
SHAPES = list(itertools.product((1e-9, 0.05, 1.0, 10.0), (0.02, 1.0, 1e4)))


def _scaled(ratio, slenderness):
    """clearance, journal in units of L."""
    return ratio / slenderness, 1 / slenderness


def _pose(state, clearance, journal):
    """O and s of a state."""
    x, y, *_ = section.shape(*state[2:5], 0.0, clearance, journal)
    return x * np.array(state[:2]), y * np.array([-state[1], state[0]])


@dataclass(frozen=True)
class SymmetricMotion:
    """A body symmetric about its axis under gravity, L = m = 1."""

    clearance: float
    journal: float
    z: float
    inertia: float
    gyro: float
    gravity: np.ndarray

    @classmethod
    def of(cls, case):
        length, mass = case["half_length"], case["mass"]
        return cls(
            (case["bearing_radius"] - case["journal_radius"]) / length,
            case["journal_radius"] / length,
            case["center_of_mass"][2] / length,
            case["inertia"][0][0] / (mass * length**2),
            case["inertia"][2][2] * case["motion"]["spin_rate"] / (mass * length**2),
            np.array(case["gravity"]) / length,
        )

    def evaluate(self, state):
        """Rates of the state, contact forces, energy."""
        c_x, c_y, cos_d, sin_d, sin_e, swing, nu = state
        x, y, kappa, pull, turn, lean, *bias = section.shape(cos_d, sin_d, sin_e, nu, self.clearance, self.journal)
        f_c, f_j = self.gravity[:2] @ [c_x, c_y], self.gravity[:2] @ [-c_y, c_x]
        swing_rate, nu_rate, n_d, n_e, kinetic, potential, _, _ = section.symmetric(
            cos_d, sin_d, x, y, kappa, pull, *bias, swing, nu, self.z, self.inertia, self.gyro,
            f_c, f_j, self.z * f_c, self.z * f_j, self.z * self.gravity[2],
        )  # fmt: skip
        rates = [-swing * c_y, swing * c_x, -turn * sin_d, turn * cos_d, lean, swing_rate, nu_rate]
        return rates, np.array([n_d, n_e]), kinetic + potential

    def integrate(self, state, duration):
        return solve_ivp(
            lambda _, state: self.evaluate(state)[0], (0, duration), state, "DOP853",
            rtol=1e-12, atol=1e-14, max_step=duration / 100, dense_output=True,
        )  # fmt: skip


def _start(case, motion):
    angles = [case["motion"][name] for name in ("alpha", "beta", "alpha_rate", "beta_rate")]
    return np.array(section.start(*angles, motion.clearance, motion.journal))


# Geometry


def test_twin_gap_is_the_least_distance_over_the_rim():
    rng = np.random.default_rng(1)
    bearing = twin.Bearing(R=0.02, r=0.01, L=0.02)
    for _ in range(5):
        q = np.concatenate([rng.normal(size=2) * 4e-3, rng.normal(size=2) * 4e-3])
        e_h = q[2:] / math.hypot(*q[2:], bearing.L)
        for gap, p in zip(twin.gaps(bearing, q), (q[:2] + q[2:], q[:2] - q[2:]), strict=True):
            grid = np.linspace(0, 2 * np.pi, 721)
            best = grid[np.argmin([twin.rim_distance(phi, p, e_h, bearing.R) for phi in grid])]
            found = minimize_scalar(
                twin.rim_distance, bounds=(best - 0.02, best + 0.02), args=(p, e_h, bearing.R),
                method="bounded", options={"xatol": 1e-12},
            )  # fmt: skip
            assert gap == pytest.approx(found.fun - bearing.r, abs=1e-16)


def test_twin_rows_are_the_gradients_of_the_gaps():
    bearing = twin.Bearing(R=0.02, r=0.01, L=0.02)
    q = np.array([2e-3, -4e-3, 5e-3, 3e-3])
    gradients = np.array([twin.gaps(bearing, q + 1e-20j * unit).imag for unit in np.eye(4)]).T / 1e-20
    np.testing.assert_allclose(twin.rows(bearing, q), gradients, rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize(("ratio", "slenderness"), SHAPES)
def test_start_touches_each_rim_at_one_point_in_the_given_directions(ratio, slenderness):
    rng = np.random.default_rng(2)
    clearance, journal = _scaled(ratio, slenderness)
    bearing = clearance + journal
    phi = np.linspace(0, 2 * np.pi, 20_001)
    rim = bearing * np.array([np.cos(phi), np.sin(phi)])
    for alpha, beta in [*rng.uniform(-4, 4, (5, 2)), (0.3, 0.3 + 1e-9), (0.3, 0.3 + np.pi - 1e-9)]:
        state = section.start(alpha, beta, 0.0, 0.0, clearance, journal)
        origin, s = _pose(state, clearance, journal)
        e_h = s / math.hypot(*s, 1)
        c, half = np.array(state[:2]), np.array([-state[3] * state[1], state[3] * state[0]])
        for angle, p, n in ((alpha, origin + s, c * state[2] + half), (beta, origin - s, c * state[2] - half)):
            distance = math.hypot(*p)
            np.testing.assert_allclose(p, distance * np.array([np.cos(angle), np.sin(angle)]), atol=1e-14 * distance)
            w = bearing * n - p
            assert math.sqrt(w @ w - (w @ e_h) ** 2) - journal == pytest.approx(0, abs=1e-14 * bearing)
            w = rim - p[:, None]
            gaps = np.sqrt((w**2).sum(axis=0) - (e_h @ w) ** 2) - journal
            assert gaps.min() > -1e-14 * bearing
            elsewhere = n @ rim < bearing * math.cos(0.3)
            assert gaps[elsewhere].min() > 1e-3 * clearance
        assert section.gap(*state[2:5], clearance, journal) == pytest.approx(0, abs=1e-15 * clearance)


@pytest.mark.parametrize(("ratio", "slenderness"), SHAPES)
def test_largest_tilt_and_parallel_axis_are_those_of_equations_1_to_3(ratio, slenderness):
    dimensions = 1 + ratio, 1.0, slenderness
    clearance, journal = (dimensions[0] - 1) / slenderness, 1 / slenderness
    opposite = section.start(0.4, 0.4 + np.pi, 0.0, 0.0, clearance, journal)
    origin, s = _pose(opposite, clearance, journal)
    assert math.hypot(*s) * slenderness == pytest.approx(geometry.effective_radius(*dimensions), rel=4e-15)
    assert math.atan(math.hypot(*s)) == pytest.approx(geometry.tilt_angle(*dimensions), rel=4e-15)
    assert math.hypot(*origin) < 1e-15 * math.hypot(*s)
    origin, s = _pose(section.start(0.4, 0.4, 0.0, 0.0, clearance, journal), clearance, journal)
    assert math.hypot(*origin) == pytest.approx(clearance, rel=2e-15)
    assert math.hypot(*s) == 0


@pytest.mark.parametrize(("ratio", "slenderness"), SHAPES)
def test_rates_and_accelerations_are_derivatives_along_the_motion(ratio, slenderness):
    clearance, journal = _scaled(ratio, slenderness)
    step = 1e-5
    for delta in (0.3, 1.4, 2.5, 4.0):
        guess = section.start(delta, -delta, 0.0, 0.0, clearance, journal)[4]

        def at(delta, guess=guess):
            for _ in range(8):
                pose = section.project(1.0, 0.0, math.cos(delta), math.sin(delta), guess, clearance, journal)
                guess = pose[4]
            x, y, kappa, *_ = section.shape(*pose[2:], 1.0, clearance, journal)
            return np.array([x, y, guess, kappa * pose[3], pose[2]]), pose

        here, pose = at(delta)
        *_, turn, lean, x_bias, y_bias, _, _ = section.shape(*pose[2:], 1.0, clearance, journal)
        # Fourth-order differences of X, Y, sin(eps), kappa sin(delta) and cos(delta) by the time, at nu = 1.
        rates = sum(w * at(delta + k * step)[0] for w, k in ((8, 1), (-8, -1), (-1, 2), (1, -2)))
        rates *= turn / (12 * step)
        scale = np.array([1, 1, max(abs(lean), 1e-12), abs(turn), abs(turn)])
        expected = np.array([-here[3], here[4], lean, -x_bias, y_bias])
        np.testing.assert_allclose(rates / scale, expected / scale, rtol=1e-7, atol=1e-7)


def test_projection_restores_the_pose_and_keeps_the_directions():
    clearance, journal = 0.5, 0.5
    state = np.array(section.start(0.4, -1.3, 0.0, 0.0, clearance, journal))
    moved = state[:5] * np.array([1 + 1e-4, 1 + 1e-4, 1 - 1e-4, 1 - 1e-4, 1 + 1e-3])
    assert abs(section.gap(*moved[2:], clearance, journal)) > 1e-5
    np.testing.assert_allclose(section.project(*moved, clearance, journal), state[:5], rtol=1e-14)


# Dynamics


def _random_case(seed, symmetric):
    rng = np.random.default_rng(seed)
    bearing = twin.Bearing(R=0.01 * (1 + 10 ** rng.uniform(-2, 0.5)), r=0.01, L=0.02 * 4 ** rng.uniform(-1, 1))
    mass, half = 0.5, rng.normal(size=(3, 3)) * 0.02
    spread = half @ half.T
    center = rng.uniform(-0.01, 0.01, 3)
    point, torque = rng.uniform(-0.02, 0.02, 3), rng.normal(size=3) * 0.01
    if symmetric:
        spread, torque = np.diag([4e-4, 4e-4, 1e-4]), np.zeros(3)
        center[:2] = point[:2] = 0
    inertia = mass * (np.trace(spread) * np.eye(3) - spread + center @ center * np.eye(3) - np.outer(center, center))
    body = twin.Body(mass, center, inertia, rng.normal(size=3) * 10, rng.normal(size=3), point, torque)
    angles = *rng.uniform(-3, 3, 2), *rng.normal(size=2) * 10
    return bearing, body, angles, rng.uniform(-3, 3), rng.normal() * 30


def _components(c_x, c_y, vector):
    return c_x * vector[0] + c_y * vector[1], c_x * vector[1] - c_y * vector[0], vector[2]


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("symmetric", [True, False])
def test_accelerations_contact_forces_and_energy_agree_with_the_twin(seed, symmetric):
    bearing, body, angles, chi, spin = _random_case(seed, symmetric)
    q, q_rate = twin.start(bearing, *angles)
    expected, forces = twin.accelerations(bearing, body, q, q_rate, chi, spin)

    L, mass = bearing.L, body.mass
    state = section.start(*angles, (bearing.R - bearing.r) / L, bearing.r / L)
    c_x, c_y, cos_d, sin_d, sin_e, swing, nu = state
    c, j = np.array([c_x, c_y]), np.array([-c_y, c_x])
    x, y, kappa, pull, _, _, x_bias, y_bias, *tilt = section.shape(
        cos_d, sin_d, sin_e, nu, (bearing.R - bearing.r) / L, bearing.r / L
    )
    x_rate, y_rate = -kappa * sin_d * nu, cos_d * nu
    np.testing.assert_allclose(L * np.concatenate([x * c, y * j]), q, atol=1e-14 * L)
    velocity = np.concatenate([x_rate * c + x * swing * j, y_rate * j - y * swing * c])
    np.testing.assert_allclose(L * velocity, q_rate, atol=1e-13 * np.abs(q_rate).max())

    pose = cos_d, sin_d, x, y, kappa, pull, x_bias, y_bias, *tilt, swing, nu
    phi = chi - 0.5 * (angles[0] + angles[1])
    inertia = body.inertia / (mass * L**2)
    swing_rate, nu_rate, spin_rate, phi_rate, n_d, n_e, kinetic, potential, power, _, _ = section.general(
        *pose, math.cos(phi), math.sin(phi), spin, *(body.center / L),
        *np.diag(inertia), inertia[0, 1], inertia[0, 2], inertia[1, 2],
        *_components(c_x, c_y, body.gravity / L), *_components(c_x, c_y, body.force / (mass * L)),
        *(body.force_point / L), *_components(c_x, c_y, body.torque / (mass * L**2)), True,
    )  # fmt: skip
    x_acc, y_acc = x_bias - kappa * sin_d * nu_rate, y_bias + cos_d * nu_rate
    acceleration = np.concatenate(
        [
            (x_acc - x * swing**2) * c + (x * swing_rate + 2 * x_rate * swing) * j,
            (y_acc - y * swing**2) * j - (y * swing_rate + 2 * y_rate * swing) * c,
        ]
    )
    np.testing.assert_allclose(L * acceleration, expected[:4], atol=1e-12 * np.abs(expected[:4]).max())
    assert spin_rate == pytest.approx(expected[4], abs=1e-11 * max(1, abs(expected[4])))
    np.testing.assert_allclose(mass * L * np.array([n_d, n_e]), forces, atol=1e-12 * np.abs(forces).max())
    energy = twin.energy(bearing, body, q, q_rate, chi, spin)
    assert mass * L**2 * (kinetic + potential) == pytest.approx(energy, rel=1e-12)
    tilt_rate = y_rate / (1 + y * y)
    assert phi_rate == pytest.approx(spin - swing / math.hypot(1, y), rel=1e-14, abs=1e-14)
    omega = -tilt_rate * np.array([c_x, c_y, 0]) + swing * np.array([0, 0, 1])
    omega += phi_rate * np.array([-y * c_y, y * c_x, 1]) / math.hypot(1, y)
    assert mass * L**2 * power == pytest.approx(omega @ body.torque, abs=1e-12 * np.abs(omega).max())

    if symmetric:
        load = mass * body.gravity + body.force
        moment = body.center[2] * mass * body.gravity + body.force_point[2] * body.force
        compact = section.symmetric(
            *pose, body.center[2] / L, inertia[0, 0], inertia[2, 2] * spin,
            *_components(c_x, c_y, load / (mass * L))[:2], *_components(c_x, c_y, moment / (mass * L**2)),
        )  # fmt: skip
        whole = swing_rate, nu_rate, n_d, n_e, kinetic - 0.5 * inertia[2, 2] * spin**2, potential
        np.testing.assert_allclose(compact[:6], whole, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("name", REFERENCE)
def test_reference_motion(name):
    case, expected = REFERENCE[name], REFERENCE[name]["expected"]
    motion = SymmetricMotion.of(case)
    length, newton = case["half_length"], case["mass"] * case["half_length"]
    state = _start(case, motion)
    origin, s = _pose(state, motion.clearance, motion.journal)
    radii = [length * math.hypot(*p) for p in (origin + s, origin - s)]
    np.testing.assert_allclose(radii, expected["start_radius"], rtol=1e-12)
    np.testing.assert_allclose(newton * motion.evaluate(state)[1], expected["contact_force_start"], rtol=1e-9)

    solution = motion.integrate(state, case["duration"])
    end = solution.y[:, -1]
    origin, s = _pose(end, motion.clearance, motion.journal)
    np.testing.assert_allclose(
        origin * length / expected["effective_radius"],
        np.array(expected["origin"]) / expected["effective_radius"],
        atol=1e-8,
    )
    np.testing.assert_allclose(np.array([*s, 1]) / math.hypot(*s, 1), expected["axis"], atol=1e-8)
    np.testing.assert_allclose(newton * motion.evaluate(end)[1], expected["contact_force"], rtol=1e-8)

    times = np.linspace(0, case["duration"], 1001)
    forces = newton * np.array([motion.evaluate(state)[1] for state in solution.sol(times).T])
    for end_name, column in (("D", 0), ("E", 1)):
        for extreme, sign in (("max", -1), ("min", 1)):

            def signed(t, column=column, sign=sign):
                return sign * newton * motion.evaluate(solution.sol(t))[1][column]

            k = np.argmin(sign * forces[:, column])
            found = minimize_scalar(
                signed, bounds=times[[max(k - 1, 0), min(k + 1, 1000)]], method="bounded", options={"xatol": 1e-9}
            )
            best = sign * min(found.fun, signed(times[k]))
            assert best == pytest.approx(expected[f"contact_force_{end_name}_{extreme}"], rel=1e-8)


def test_energy_is_conserved_and_the_redundant_state_stays_on_the_constraints():
    case = REFERENCE["exact_paper_joint"]
    motion = SymmetricMotion.of(case)
    state = _start(case, motion)
    solution = motion.integrate(state, case["duration"])
    energies = np.array([motion.evaluate(state)[2] for state in solution.y.T])
    assert np.abs(energies - energies[0]).max() < 1e-12 * np.linalg.norm(motion.gravity)
    gaps = [section.gap(*state[2:5], motion.clearance, motion.journal) for state in solution.y.T]
    assert np.abs(gaps).max() < 1e-11 * motion.clearance


def _circle(cos_d, sin_d, nu, radius):
    """What :func:`section.shape` gives, for a circle."""
    turn = nu / radius
    pull = math.hypot(1, radius * sin_d * sin_d)
    cos2 = 1 / (1 + (radius * sin_d) ** 2)
    return radius * cos_d, radius * sin_d, 1.0, pull, -cos_d * turn * nu, -sin_d * turn * nu, cos2, math.sqrt(cos2)


def test_difference_from_the_circle_vanishes_with_the_clearance():
    """As clearance squared for the position, so as the clearance itself relative to accelerations and contact forces."""
    journal, alpha, beta = 0.5, -1.9, -0.9
    body = 0.2, 2.0, 5.0, -9.0, -490.0, -1.8, -98.0, 0.0  # z, inertia, gyro and loads along c and Jc
    differences = []
    for clearance in 0.02 / 2.0 ** np.arange(5):
        half = clearance / (1 + math.sqrt(1 + clearance * (clearance + 2 * journal)))
        radius = 2 * half / (1 - half * half)
        *_, cos_d, sin_d, sin_e, swing, nu = section.start(alpha, beta, 2.0, -3.0, clearance, journal)
        x, y, kappa, pull, _, _, *bias = section.shape(cos_d, sin_d, sin_e, nu, clearance, journal)
        exact = section.symmetric(cos_d, sin_d, x, y, kappa, pull, *bias, swing, nu, *body)
        cos_d, sin_d, nu = math.cos(0.5 * (alpha - beta)), math.sin(0.5 * (alpha - beta)), 2.5 * radius
        x_c, y_c, *rest = _circle(cos_d, sin_d, nu, radius)
        circle = section.symmetric(cos_d, sin_d, x_c, y_c, *rest, swing, nu, *body)
        differences.append([x - x_c, y - y_c, *(exact[i] / circle[i] - 1 for i in (0, 2, 3))])
    slopes = np.log2(np.divide(differences[:-1], differences[1:]))
    np.testing.assert_allclose(slopes[-1], [2, 2, 1, 1, 1], atol=0.02)
