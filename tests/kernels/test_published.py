"""The paper's coordinates: kernels against their twin, motions against slope coordinates, statuses at singular sets."""

import json
import math
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from places import DATA
from scenes import FORCES, START, dimensions
from twins import published_twin, slope_twin

from tolmc import simulate, simulate_many
from tolmc.kernels import parameters as P
from tolmc.kernels import published
from tolmc.kernels.tableaux import TABLEAUX
from tolmc.mechanism.scene import Body, Joint, Loads, Motion, Scene
from tolmc.quantities import END_OUTPUTS, SCALAR_ROWS

CASES = json.loads((DATA / "trajectories.json").read_text())
SETS = {
    "psi": published.SINGULAR_PSI,
    "maximum tilt": published.SINGULAR_MAXIMUM_TILT,
    "theta": published.SINGULAR_THETA,
}
DEGREE = math.pi / 180

JOINT = Joint(0.02, 0.01, 0.02)
BODY = Body(0.5, (0.001, -0.0007, 0.004), [[4.1e-4, 2e-5, -1.2e-5], [2e-5, 3.3e-4, 3.1e-5], [-1.2e-5, 3.1e-5, 1.3e-4]])
LOADS = Loads((1.0, -9.81, -2.0), (0.4, 0.3, -0.5), (0.01, -0.02, 0.03), (2e-3, -1e-3, 3e-3))


@dataclass(frozen=True)
class Record:
    status: int
    rows: int
    q: np.ndarray
    qd: np.ndarray
    axis: np.ndarray
    contact_force: np.ndarray
    multipliers: np.ndarray
    energy: np.ndarray
    work: np.ndarray

    @property
    def origin(self):
        return self.q[:, :2]


def parameters(scene):
    p = np.zeros(P.COUNT)
    for scalar in SCALAR_ROWS:
        if scalar.row:
            p[getattr(P, scalar.row)] = scene.scalars[scalar.name]
    p[P.RADIUS] = scene.joint.effective_radius
    return p


def integrate(scene, steps, method="rk8", regular=False, start=None):
    p, rows = parameters(scene), steps + 1
    widths = {"q": (5,), "qd": (5,), "axis": (3,), "contact_force": (2,), "multipliers": (2,), "energy": (), "work": ()}
    record = {name: np.empty((rows, *width)) for name, width in widths.items()}
    record["q"][0], record["qd"][0] = published.start(p) if start is None else start
    tableau = TABLEAUX[method]
    status, valid = published.integrate(p, scene.duration / steps, tableau.matrix, tableau.b, regular, *record.values())
    return Record(status, valid, **record)


def scene_at(psi, delta, psi_rate=1.0, delta_rate=2.0, *, duration=0.05, joint=JOINT, body=BODY, loads=LOADS):
    """Start with the polar direction psi of O and half the angle delta between D and E: alpha, beta = psi -+ delta."""
    motion = Motion(psi - delta, psi + delta, psi_rate - delta_rate, psi_rate + delta_rate, 0.7, 30.0)
    return Scene(joint, body, loads, motion, duration)


def reference_scene(name):
    case = CASES[name]
    return Scene(
        Joint(case["bearing_radius"], case["journal_radius"], case["half_length"]),
        Body(case["mass"], case["center_of_mass"], case["inertia"]),
        Loads(case["gravity"], case["force"], case["force_point"], case["torque"]),
        Motion(**case["motion"]),
        case["duration"],
    )


def random_states(count, seed=1):
    """Positions and speeds on the branch (11), clear of the singular sets, with the parameters of a random body."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        points = rng.normal(size=(6, 3)) * [0.02, 0.02, 0.06]
        mass, center = 10 ** rng.uniform(-1, 1), points.mean(axis=0)
        inertia = mass * np.mean([x @ x * np.eye(3) - np.outer(x, x) for x in points], axis=0)
        loads = Loads(*(tuple(scale * rng.normal(size=3)) for scale in (9.81, 5.0, 0.02, 0.1)))
        scene = scene_at(
            rng.integers(4) * math.pi / 2 + rng.uniform(0.2, 1.3),
            rng.choice([-1, 1]) * rng.uniform(0.2, 1.3),
            *rng.normal(size=2),
            joint=Joint(0.01 * (1 + 10 ** rng.uniform(-0.5, 0.5)), 0.01, 0.01 * 10 ** rng.uniform(-0.5, 0.5)),
            body=Body(mass, tuple(center), inertia),
            loads=loads,
        )
        yield scene, parameters(scene), *published.start(parameters(scene))


def body_arguments(scene):
    return scene.body.mass, np.array(scene.body.center_of_mass), scene.body.inertia


def load_arguments(scene):
    loads = scene.loads
    return (np.array(vector) for vector in (loads.gravity, loads.force, loads.force_point, loads.torque))


def relative(value, expected):
    return np.max(np.abs(np.asarray(value) - expected)) / np.max(np.abs(expected))


def assert_agrees(record, twin, radius, tolerance):
    n = record.rows
    np.testing.assert_allclose(record.origin[:n] / radius, twin.origin[:n] / radius, rtol=0, atol=tolerance)
    np.testing.assert_allclose(record.axis[:n], twin.axis[:n], rtol=0, atol=tolerance)
    scale = np.abs(twin.contact_force).max()
    np.testing.assert_allclose(record.contact_force[:n] / scale, twin.contact_force[:n] / scale, rtol=0, atol=tolerance)


# ------------------------------------------------------------------------------------------------ equations


def test_start_puts_D_and_E_at_their_polar_angles_with_their_rates():
    for scene, p, q, qd in random_states(20):
        motion, r, L = scene.motion, p[P.RADIUS], p[P.HALF_LENGTH]
        for end, angle, rate in ((0, motion.alpha, motion.alpha_rate), (1, motion.beta, motion.beta_rate)):
            radial = r * np.array([math.cos(angle), math.sin(angle)])
            velocity = published_twin.derivative(lambda x, L=L, end=end: published_twin.ends(x, L)[end], q, qd)
            np.testing.assert_allclose(published_twin.ends(q, L)[end], radial, rtol=0, atol=1e-14 * r)
            np.testing.assert_allclose(velocity, rate * radial[::-1] * [-1, 1], rtol=0, atol=1e-12 * r)


def test_start_takes_the_branch_of_11_for_any_polar_angles():
    for alpha, beta in ((0.3, 2.0), (3.0, -3.0), (-2.0, 9.0), (7.0, 0.2)):
        p = parameters(replace(scene_at(0, 0), motion=Motion(alpha, beta, spin=0.4)))
        q, _ = published.start(p)
        root = math.sqrt(p[P.RADIUS] ** 2 - (p[P.HALF_LENGTH] * math.tan(q[3])) ** 2)
        np.testing.assert_allclose(q[:2], root * np.array([math.cos(q[2]), math.sin(q[2])]), atol=1e-15)
        assert math.isclose(q[2] + q[4], 0.4)


def test_mass_matrix_and_its_derivatives_agree_with_the_twin():
    for scene, p, q, _ in random_states(20):
        M, M_i = published.mass_matrix(q, published.body_matrix(p))

        def twin(x, scene=scene):
            return published_twin.mass_matrix(x, *body_arguments(scene))

        assert relative(M, twin(q)) < 1e-13
        assert relative(M_i, published_twin.gradient(twin, q)) < 1e-13


@settings(max_examples=100, deadline=None)
@given(
    theta=st.floats(0.01, 1.4).flatmap(lambda x: st.sampled_from([-x, x])),
    psi=st.floats(-10, 10),
    phi=st.floats(-100, 100),
    mass=st.floats(1e-3, 1e3),
    center=st.tuples(*[st.floats(-0.1, 0.1)] * 3),
    moments=st.tuples(st.floats(1e-2, 1.0), st.floats(1e-2, 1.0), st.floats(0.05, 0.95)),
)
def test_mass_matrix_is_symmetric_positive_definite_off_theta_zero(theta, psi, phi, mass, center, moments):
    a, b, share = moments
    third = abs(a - b) + share * (a + b - abs(a - b))  # the triangle inequality of principal moments
    body = Body.from_centroidal(mass, center, tuple(1e-3 * mass * np.array([a, b, third])))
    p = parameters(scene_at(0.5, 0.5, body=body))
    M, _ = published.mass_matrix(np.array([0.0, 0.0, psi, theta, phi]), published.body_matrix(p))
    np.testing.assert_array_equal(M, M.T)
    size = np.sqrt(np.diag(M))
    assert np.linalg.eigvalsh(M / np.outer(size, size))[0] > 0


def test_generalised_forces_agree_with_the_twin():
    for scene, p, q, qd in random_states(20):
        F = published.generalised_forces(q, qd, p, published.body_matrix(p))
        twin = published_twin.generalised_forces(q, qd, *body_arguments(scene), *load_arguments(scene))
        assert relative(F, twin) < 1e-12


@pytest.mark.parametrize("regular", [False, True])
def test_constraint_rows_are_those_printed_and_the_gradients_of_the_constraints(regular):
    for _, p, q, qd in random_states(20):
        r, L = p[P.RADIUS], p[P.HALF_LENGTH]
        q = q + np.array([0.1 * r, -0.2 * r, 0.1, 0.1, 0.0])  # off the constraints as well
        g, B, Bdot_qd = published.constraints(q, qd, r, L, regular)

        def residual(x, r=r, L=L):
            return published_twin.constraints(x, r, L, regular)

        def rows(x, r=r, L=L):
            return published_twin.constraint_rows(x, r, L, regular)

        assert relative(g, residual(q)) < 1e-12
        assert relative(B, rows(q)) < 1e-13
        assert relative(B, published_twin.gradient(residual, q).T) < 1e-12
        assert relative(Bdot_qd, published_twin.derivative(rows, q, qd) @ qd) < 1e-11


@pytest.mark.parametrize("regular", [False, True])
def test_accelerations_multipliers_and_contact_forces_agree_with_the_twin(regular):
    for scene, p, q, qd in random_states(20):
        r, L, body = p[P.RADIUS], p[P.HALF_LENGTH], published.body_matrix(p)
        qdd, multipliers, force, _ = published.accelerations(q, qd, p, body, regular)
        moment = published.constraint_moment(q, qd, qdd, p, body)
        N = published.contact_forces(q, force, moment, r, L)
        M = published_twin.mass_matrix(q, *body_arguments(scene))
        F = published_twin.generalised_forces(q, qd, *body_arguments(scene), *load_arguments(scene))
        expected = published_twin.solution(q, qd, M, F, r, L, regular)
        assert relative(qdd, expected[0]) < 1e-10
        assert relative(multipliers, expected[1]) < 1e-10
        assert relative(N, expected[2]) < 1e-10


def test_solve_returns_solution_and_condition_number():
    rng = np.random.default_rng(0)
    for _ in range(20):
        K, x = rng.normal(size=(7, 7)), rng.normal(size=7)
        K[0, 0] = 0.0  # needs a pivot
        solution, condition = published.solve(K, K @ x, 2, 5)
        np.testing.assert_allclose(solution, x, atol=1e-10)
        expected = np.linalg.norm(K) * np.linalg.norm(np.linalg.inv(K)[:5])
        assert math.isclose(condition, expected, rel_tol=1e-9)
    K[:, 3] = 0.0
    assert not math.isfinite(published.solve(K, x, 2, 5)[1])


def test_newton_leaves_the_branch_for_a_mirror_branch_only_under_the_published_constraints():
    _, p, q, qd = next(random_states(1))
    r, L = p[P.RADIUS], p[P.HALF_LENGTH]
    for regular in (False, True):
        mirrored = q * [-1, 1, 1, 1, 1]
        published.project(mirrored, r, L, regular)
        np.testing.assert_allclose(published.constraints(mirrored, qd, r, L, regular)[0], 0, atol=1e-14 * max(r, r * r))
        on_branch = published.retract(mirrored, qd.copy(), r, L) < 1e-10
        assert on_branch == regular


# ------------------------------------------------------------------------------------------------ motions


@pytest.mark.parametrize("regular", [False, True])
@pytest.mark.parametrize("name", CASES)
def test_reference_trajectories(name, regular):
    scene, expected = reference_scene(name), CASES[name]["expected"]
    record = integrate(scene, 1000, regular=regular)
    assert record.status == published.OK
    assert record.rows == 1001
    r = expected["effective_radius"]
    np.testing.assert_allclose(record.origin[-1] / r, np.array(expected["origin"]) / r, rtol=0, atol=1e-9)
    np.testing.assert_allclose(record.axis[-1], expected["axis"], rtol=0, atol=1e-9)
    np.testing.assert_allclose(record.contact_force[-1], expected["contact_force"], rtol=1e-9)
    np.testing.assert_allclose(record.contact_force[0], expected["contact_force_start"], rtol=1e-9)
    assert np.ptp(record.energy) < 1e-10 * np.abs(record.energy).max()


CLEAR = scene_at(40 * DEGREE, 35 * DEGREE, psi_rate=3.0, delta_rate=-2.0, duration=0.06)


@pytest.fixture(scope="module")
def clear_twin():
    return slope_twin.integrate(CLEAR.scalars, np.linspace(0, CLEAR.duration, 61))


@pytest.mark.parametrize("regular", [False, True])
def test_general_body_and_loads_agree_with_slope_coordinates(regular, clear_twin):
    record = integrate(CLEAR, 60, regular=regular)
    assert record.status == published.OK
    s = np.hypot(*record.origin.T) / CLEAR.joint.effective_radius
    assert np.abs(np.sin(2 * record.q[:, 2])).min() > 0.1
    assert s.min() > 0.1
    assert np.abs(record.q[:, 3]).min() > 0.05
    assert_agrees(record, clear_twin, CLEAR.joint.effective_radius, 1e-10)
    # The torque does work, the other loads have a potential: the twin knows the same energy.
    np.testing.assert_allclose(record.energy, clear_twin.energy, rtol=1e-10)
    for row in (0, 60):
        np.testing.assert_allclose(published.rotation(record.q[row]), clear_twin.rotation[row], rtol=0, atol=1e-10)


@pytest.mark.parametrize("regular", [False, True])
def test_constraints_and_tangency_are_kept(regular):
    record = integrate(reference_scene("general_body_unbalanced"), 300, "rk4", regular)
    assert record.status == published.OK
    p = parameters(reference_scene("general_body_unbalanced"))
    r, L = p[P.RADIUS], p[P.HALF_LENGTH]
    for q, qd in zip(record.q, record.qd, strict=True):
        g, B, _ = published.constraints(q, qd, r, L, regular)
        size = np.array([r, r * r]) if regular else r * r
        assert np.abs(g / size).max() < 1e-14
        assert np.abs(B @ qd).max() < 1e-14 * np.abs(B).max() * np.abs(qd).max()


@pytest.mark.parametrize("regular", [False, True])
@pytest.mark.parametrize(("method", "coarse", "tolerance"), [("rk4", 80, 0.1), ("rk8", 10, 0.3)])
def test_order_of_convergence(method, coarse, tolerance, regular):
    psi, delta = 10 * DEGREE, 25 * DEGREE
    motion = Motion(psi - delta, psi + delta, 0.0, 20.0, 0.0, 50.0)
    scene = replace(reference_scene("vertical_axis_free_of_transverse_load"), motion=motion, duration=0.12)
    exact = integrate(scene, 320, "rk8", regular)

    def errors(steps):
        record = integrate(scene, steps, method, regular)
        assert record.status == published.OK
        return [
            np.abs(getattr(record, name)[:: steps // 5] - getattr(exact, name)[::64]).max()
            for name in ("q", "qd", "multipliers", "contact_force")
        ]

    observed = np.log2(np.divide(errors(coarse), errors(2 * coarse)))
    np.testing.assert_allclose(observed, TABLEAUX[method].order, atol=tolerance)


def test_a_motion_continues_where_it_was_left():
    whole = integrate(CLEAR, 20)
    first = integrate(replace(CLEAR, duration=CLEAR.duration / 2), 10)
    second = integrate(replace(CLEAR, duration=CLEAR.duration / 2), 10, start=(first.q[-1].copy(), first.qd[-1].copy()))
    np.testing.assert_array_equal(second.q, whole.q[10:])
    np.testing.assert_array_equal(second.contact_force, whole.contact_force[10:])


# ------------------------------------------------------------------------------------------------ singular sets


def towards(name, distance, duration=0.02):
    """Start at a distance from a singular set, in motion across it."""
    return {
        "psi": scene_at(math.pi / 2 - distance, 0.6, psi_rate=8.0, duration=duration),
        "maximum tilt": scene_at(0.6, math.pi / 2 - distance, delta_rate=8.0, duration=duration),
        "theta": scene_at(0.6, distance, delta_rate=-8.0, duration=duration),
    }[name]


@cache
def twin_towards(name, distance, rows):
    """Of :func:`towards`, for every method that passes the set."""
    scene = towards(name, distance)
    return slope_twin.integrate(scene.scalars, np.linspace(0, scene.duration, rows))


def crossings(record, radius):
    s = record.q[:, 0] * np.cos(record.q[:, 2]) + record.q[:, 1] * np.sin(record.q[:, 2])
    changes = {"psi": np.floor(record.q[:, 2] / (math.pi / 2)), "maximum tilt": s > 0, "theta": record.q[:, 3] > 0}
    return {name: np.count_nonzero(np.diff(values.astype(float))) for name, values in changes.items()}


@pytest.mark.parametrize("method", ["rk4", "rk8"])
@pytest.mark.parametrize("regular", [False, True])
@pytest.mark.parametrize("name", SETS)
def test_steps_that_straddle_a_singular_set_pass_with_right_numbers(name, regular, method):
    scene = towards(name, 0.05)
    record = integrate(scene, {"rk4": 2000, "rk8": 50}[method], method, regular)
    assert record.status == published.OK
    radius = scene.joint.effective_radius
    assert crossings(record, radius)[name] > 0
    stride = (record.rows - 1) // 50
    sampled = replace(record, rows=51, **{k: getattr(record, k)[::stride] for k in ("q", "axis", "contact_force")})
    assert_agrees(sampled, twin_towards(name, 0.05, 51), radius, 1e-9)


@pytest.mark.parametrize("name", SETS)
def test_near_misses_are_right_or_end_with_the_status_that_names_the_set(name):
    ended = []
    for exponent in range(1, 13):
        scene = towards(name, 10.0**-exponent)
        twin = slope_twin.integrate(scene.scalars, np.linspace(0, scene.duration, 21))
        radius = scene.joint.effective_radius
        for regular in (False, True):
            record = integrate(scene, 20, regular=regular)
            assert_agrees(record, twin, radius, 1e-8)
            if record.status != published.OK:
                assert not regular
                assert record.status == SETS[name]
                assert np.all(np.isnan(record.contact_force[record.rows :]))
                ended.append(exponent)
    if name == "theta":
        assert not ended  # the constrained equations and the forces are regular there
    else:
        assert set(range(8, 13)) <= set(ended)
        assert not set(range(1, 4)) & set(ended)


@pytest.mark.parametrize(
    ("name", "scene"),
    [
        ("psi", scene_at(0.0, 0.5)),
        ("psi", scene_at(-90 * DEGREE, 0.5)),
        ("psi", scene_at(180 * DEGREE, -0.5)),
        ("maximum tilt", scene_at(0.6, 90 * DEGREE)),
    ],
)
def test_a_start_on_a_singular_set_ends_there_under_the_published_rows_alone(name, scene):
    record = integrate(scene, 10)
    assert (record.status, record.rows) == (SETS[name], 0)
    assert np.all(np.isnan(record.contact_force))
    assert integrate(scene, 10, regular=True).status == published.OK


def test_a_start_parallel_to_the_bore_is_right():
    scene = scene_at(0.6, 0.0)
    twin = slope_twin.integrate(scene.scalars, np.linspace(0, scene.duration, 51))
    for regular in (False, True):
        record = integrate(scene, 50, regular=regular)
        assert record.status == published.OK
        assert_agrees(record, twin, scene.joint.effective_radius, 1e-9)


@pytest.mark.parametrize("regular", [False, True])
def test_a_clearance_that_keeps_theta_near_zero_is_named(regular):
    scene = scene_at(0.6, 0.5, joint=Joint(0.01 + 1e-7, 0.01, 0.02))
    assert integrate(scene, 10, regular=regular).status == published.SINGULAR_THETA


@cache
def fine_steps_towards(name):
    return integrate(towards(name, 0.1, duration=0.04), 960, regular=True)


@pytest.mark.parametrize("steps", [1, 2, 3, 4, 6, 8, 12, 16, 24, 32])
@pytest.mark.parametrize("name", SETS)
def test_long_steps_are_no_worse_than_with_the_regular_pair(name, steps):
    scene, fine = towards(name, 0.1, duration=0.04), fine_steps_towards(name)
    stride = 960 // steps
    errors = []
    for regular in (False, True):
        record = integrate(scene, steps, "rk4", regular)
        if record.status != published.OK:
            assert not regular and record.status in (SETS[name], published.DIVERGED)
            return
        errors.append(
            np.abs(record.origin - fine.origin[::stride]).max() / scene.joint.effective_radius
            + relative(record.contact_force, fine.contact_force[::stride])
        )
    assert errors[0] < 3 * errors[1] + 1e-9


def test_an_absurd_step_diverges():
    scene = replace(CLEAR, duration=1e3)
    record = integrate(scene, 3)
    assert record.status == published.DIVERGED
    assert record.rows == 1


@pytest.mark.parametrize("formulation", ["published", "published-regular"])
def test_the_torques_work_counts_in_the_energy(formulation):
    """A torque changes the energy by its work, which is no error."""
    scene = Scene(JOINT, BODY, Loads((1, -9.81, -2), torque=(0.01, -0.004, 0.02)), START, 0.04)
    motions = {name: simulate(scene, step=1e-4, formulation=name) for name in (formulation, "slope")}
    assert {motion.status for motion in motions.values()} == {"ok"}
    assert np.ptp(motions[formulation].energy) > 1e-2 * np.abs(motions[formulation].energy).max()
    np.testing.assert_allclose(motions[formulation].energy, motions["slope"].energy, rtol=1e-9)
    samples = simulate_many(scene, **dimensions(scene), step=1e-4, formulation=formulation)
    assert samples.energy_error[0] < 1e-10


@pytest.mark.parametrize("formulation", ["published", "published-regular"])
def test_the_pilot_of_the_end_alone_steps_as_the_published_forms_do(formulation):
    """Motions alone have a formula that needs fewer steps in the slope form, and in no other."""
    scene, accuracy = reference_scene("paper_joint_tilted_start"), 1e-6
    end, exact = (
        simulate_many(scene, **dimensions(scene), outputs=END_OUTPUTS, **settings).loc[0]
        for settings in ({"formulation": formulation, "accuracy": accuracy}, {"step": 1e-3})
    )
    assert end.status == "ok"
    error = np.array(end[list(END_OUTPUTS)] - exact[list(END_OUTPUTS)], float)
    error[:2] /= scene.joint.effective_radius
    assert np.abs(error).max() < accuracy


@pytest.mark.slow
def test_samples_between_records_bridge_a_singular_set_that_the_steps_pass():
    """Steps that straddle psi = k pi/2 are right; so are statistics, where only a sample between two records meets the set."""
    scene = reference_scene("general_body_unbalanced")
    step = scene.duration / 2000
    motion = simulate(scene, step=step, formulation="published")
    assert motion.status == "ok"
    assert motion.time[-1] == scene.duration
    published, slope = (
        simulate_many(scene, **dimensions(scene), step=step, formulation=name).iloc[0]
        for name in ("published", "slope")
    )
    for name in FORCES:
        assert published[name] == pytest.approx(slope[name], rel=1e-8), name
