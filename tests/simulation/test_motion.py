"""Motions against independent numbers: reference trajectories, quadratures, conserved quantities, and the NumPy twins."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import (
    CYLINDER,
    LOADED,
    NEXT_TO_NO_LOAD,
    PAPER_JOINT,
    REFERENCES,
    START,
    SYMMETRIC,
    UNBALANCED,
    dimensions,
    nearly_symmetric,
)  # fmt: skip
from scipy.integrate import cumulative_simpson
from twins import slope_twin
from twins.invariants import FreeSymmetricBody, angular_momentum_z

from tolmc import Body, Joint, Loads, Motion, Scene, simulate, simulate_many
from tolmc.quantities import END_OUTPUTS

AXIAL = Scene(PAPER_JOINT, CYLINDER, Loads((0, 0, -9.81)), START, 0.2)
everyone = pytest.mark.parametrize("name", REFERENCES)
#: Without any load other kernels are compiled, which do but leave it out.
with_and_without_load = pytest.mark.parametrize(
    "loads", [NEXT_TO_NO_LOAD, pytest.param(Loads(), marks=pytest.mark.nightly)], ids=["next to no load", "no load"]
)


def ends(scene, trajectory):
    """D and E along a trajectory, (n, 2) each, in units of r."""
    w = scene.joint.half_length * trajectory.axis[:, :2] / trajectory.axis[:, 2:]
    return [(trajectory.origin + sign * w) / scene.joint.effective_radius for sign in (1, -1)]


def largest_difference(scene, a, b):
    """Of origin/r, axis, and contact force relative to the largest, over all rows of two motions."""
    largest = np.abs(b.contact_force).max()
    return max(
        np.abs(a.origin - b.origin).max() / scene.joint.effective_radius,
        np.abs(a.axis - b.axis).max(),
        np.abs(a.contact_force - b.contact_force).max() / largest if largest else 0.0,
    )


# Reference trajectories


@everyone
@pytest.mark.parametrize(("step", "tolerance"), [(1e-3, 1e-8), (None, 1e-6)])
def test_reference_trajectories(name, step, tolerance):
    scene, expected = REFERENCES[name].scene, REFERENCES[name].expected
    motion = simulate(scene, step=step)
    assert motion.status == "ok"
    np.testing.assert_allclose(
        motion.origin[-1] / scene.joint.effective_radius,
        np.divide(expected["origin"], expected["effective_radius"]),
        rtol=0,
        atol=tolerance,
    )
    np.testing.assert_allclose(motion.axis[-1], expected["axis"], rtol=0, atol=tolerance)
    np.testing.assert_allclose(motion.contact_force[-1], expected["contact_force"], rtol=0, atol=tolerance)
    np.testing.assert_allclose(motion.contact_force[0], expected["contact_force_start"], rtol=0, atol=1e-13)


@everyone
@pytest.mark.slow
def test_the_twin_agrees_with_the_references(name):
    """What the kernels are compared with below is itself right."""
    scene, expected = REFERENCES[name].scene, REFERENCES[name].expected
    twin = slope_twin.integrate(scene.scalars, np.array([0, scene.duration]))
    np.testing.assert_allclose(twin.axis[-1], expected["axis"], rtol=0, atol=1e-9)
    np.testing.assert_allclose(twin.contact_force[-1], expected["contact_force"], rtol=0, atol=1e-8)


@everyone
def test_a_trajectory_has_a_row_a_step_and_ends_at_the_duration(name):
    scene = REFERENCES[name].scene
    motion = simulate(scene, step=0.9e-3)
    steps = len(motion.time) - 1
    assert motion.time[0] == 0
    assert motion.time[-1] == scene.duration
    np.testing.assert_allclose(np.diff(motion.time), scene.duration / steps, rtol=1e-9)
    assert scene.duration / steps <= 0.9e-3 < scene.duration / (steps - 1)
    for values, shape in (
        (motion.origin, (2,)), (motion.axis, (3,)), (motion.contact_force, (2,)), (motion.multipliers, (2,)),
        (motion.tilt, ()), (motion.energy, ()),
    ):  # fmt: skip
        assert values.shape == (steps + 1, *shape)
        assert np.isfinite(values).all()
    np.testing.assert_allclose(np.linalg.norm(motion.axis, axis=1), 1, atol=1e-15)
    for end in ends(scene, motion):
        np.testing.assert_allclose(np.linalg.norm(end, axis=1), 1, atol=1e-14)
    np.testing.assert_allclose(
        motion.tilt, np.arctan2(np.hypot(motion.axis[:, 0], motion.axis[:, 1]), motion.axis[:, 2]), rtol=0, atol=1e-14
    )


# Order


GENERAL = REFERENCES["general_body_unbalanced"].scene
ORDER = {
    # name: scene, steps of rk4 and of rk8 over half a second, where the error is neither coarse nor rounding
    "paper joint": (REFERENCES["paper_joint_tilted_start"].scene, 1024, 48),
    "general body": (GENERAL.replaced(spin_rate=30.0), 1024, 96),
    "vertical axis": (REFERENCES["vertical_axis_free_of_transverse_load"].scene, 1024, 32),
}


@pytest.mark.parametrize(
    ("name", "method", "order", "allowed"),
    [
        *((name, "rk8", 8, 0.3) for name in ORDER),
        # Of the general body the tests of the formulations have rk4's steps.
        *(
            pytest.param(name, "rk4", 4, 0.1, marks=pytest.mark.nightly if name == "general body" else ())
            for name in ORDER
        ),
    ],
)
def test_order_of_convergence(name, method, order, allowed):
    """Errors of the state and of the multipliers, root mean square over sixteen times."""
    scene, *steps = ORDER[name]
    scene, n = replace(scene, duration=0.5), steps[method == "rk8"]

    def sampled(steps, method):
        motion = simulate(scene, step=scene.duration / steps, method=method)
        assert len(motion.time) == steps + 1
        rows = slice(None, None, steps // 16)
        state = np.hstack([motion.origin[rows] / scene.joint.effective_radius, motion.axis[rows]])
        return state, motion.multipliers[rows]

    fine = sampled(4096, "rk8")
    coarse, half = (
        [np.sqrt(np.mean((a - b) ** 2)) for a, b in zip(sampled(steps, method), fine, strict=True)]
        for steps in (n, 2 * n)
    )
    np.testing.assert_allclose(np.log2(np.divide(coarse, half)), order, rtol=0, atol=allowed)


def end_alone(scene, steps):
    """Origin/r and axis at the end of the motion where nothing else is asked for."""
    joint = scene.joint
    columns = {name: [getattr(joint, name)] for name in ("bearing_radius", "journal_radius", "half_length")}
    ends = simulate_many(scene, **columns, step=scene.duration / steps, outputs=END_OUTPUTS)
    assert ends.status[0] == "ok"
    values = np.array(ends.loc[0, list(END_OUTPUTS)], float)
    values[:2] /= joint.effective_radius
    return values


@everyone
def test_motions_alone_end_at_the_references(name):
    scene, expected = REFERENCES[name].scene, REFERENCES[name].expected
    exact = [*np.divide(expected["origin"], expected["effective_radius"]), *expected["axis"]]
    np.testing.assert_allclose(end_alone(scene, 200), exact, rtol=0, atol=2e-11)


@pytest.mark.parametrize("name", ["paper joint", "vertical axis"])
def test_order_of_convergence_of_motions_alone(name):
    """They are those whose contact forces are looked at, but for rounding."""
    scene = replace(ORDER[name][0], duration=0.5)
    fine = simulate(scene, step=scene.duration / 4096)
    exact = np.hstack([fine.origin[-1] / scene.joint.effective_radius, fine.axis[-1]])
    coarse, half = (np.linalg.norm(end_alone(scene, steps) - exact) for steps in (24, 48))
    assert np.log2(coarse / half) == pytest.approx(8, abs=0.5)
    watched = simulate(scene, step=scene.duration / 24)
    watched_end = np.hstack([watched.origin[-1] / scene.joint.effective_radius, watched.axis[-1]])
    np.testing.assert_allclose(watched_end, end_alone(scene, 24), rtol=0, atol=1e-13)


# What stays constant


def integrable(loads=NEXT_TO_NO_LOAD, theta_0=0.3):
    """The integrable motion of the README: r = 10 mm, L = 50 mm, no load, from a turning point of beta - alpha."""
    joint = Joint(0.01 + 0.01 * np.sqrt(1.04), 0.01, 0.05)
    spin_rate = 50 + 20 * np.cos(np.arctan(0.2 * np.sin(theta_0)))
    motion = Motion(-theta_0, theta_0, alpha_rate=20, beta_rate=20, spin_rate=spin_rate)
    return Scene(joint, Body(1.0, (0, 0, 0), (2e-3, 2e-3, 1e-3)), loads, motion, 0.5)


def test_the_period_of_the_integrable_motion_by_quadrature():
    assert FreeSymmetricBody(integrable()).period() == pytest.approx(0.23084196480, abs=5e-12)


@with_and_without_load
@pytest.mark.parametrize("body", [lambda scene: scene, nearly_symmetric], ids=["symmetric", "general"])
def test_the_integrable_motion_keeps_its_period(body, loads):
    """At quarter periods beta - alpha is zero: what is left of it, over its rate there, is the error in time."""
    scene, quadrature = body(integrable(loads)), FreeSymmetricBody(integrable())
    for periods in (0.25, 1.25, 5.25):
        duration = periods * quadrature.period()
        motion = simulate(replace(scene, duration=duration), step=1e-3)
        D, E = ends(scene, motion)
        sine = D[-1, 0] * E[-1, 1] - D[-1, 1] * E[-1, 0]
        assert abs(sine / (2 * float(quadrature.rate(0)))) / periods < 1e-9


@everyone
@pytest.mark.slow
def test_energy_is_kept(name):
    scene = REFERENCES[name].scene
    motion = simulate(scene, step=1e-3)
    kinetic_scale = np.ptp(motion.energy + scene.body.mass * 9.81 * motion.origin[:, 1]) + abs(motion.energy[0])
    assert np.ptp(motion.energy) < 1e-10 * kinetic_scale
    twin = slope_twin.integrate(scene.scalars, motion.time[::100])
    assert np.abs(np.diff(motion.energy[::100] - twin.energy)).max() < 1e-10 * kinetic_scale


@pytest.mark.parametrize(
    "scene",
    [REFERENCES["vertical_axis_free_of_transverse_load"].scene, integrable(), AXIAL],
    ids=["vertical", "free", "paper joint"],
)
def test_angular_momentum_about_the_bearing_axis_is_kept(scene):
    motion = simulate(scene, step=5e-4)
    momentum = angular_momentum_z(scene.body, motion.time, motion.origin, motion.axis, scene.motion.spin_rate)[20:-20]
    assert np.ptp(momentum) < 1e-10 * np.abs(momentum).max()


def test_a_transverse_load_changes_the_angular_momentum_about_the_bearing_axis():
    """The rate of L_Z is the moment of the weight: what the test above measures is not constant by construction."""
    scene = SYMMETRIC
    motion = simulate(scene, step=5e-4)
    momentum = angular_momentum_z(scene.body, motion.time, motion.origin, motion.axis, scene.motion.spin_rate)
    x_C = motion.origin[:, 0] + scene.body.center_of_mass[2] * motion.axis[:, 0]
    moment = -scene.body.mass * 9.81 * x_C
    gained = cumulative_simpson(moment, x=motion.time, initial=0)
    np.testing.assert_allclose((momentum - momentum[0])[20:-20], gained[20:-20], rtol=0, atol=1e-8 * np.ptp(gained))


@pytest.mark.parametrize("name", ["paper_joint_tilted_start", "vertical_axis_free_of_transverse_load"])
def test_the_general_equations_keep_the_spin_of_a_symmetric_body(name):
    """Only a constant Omega makes the motion of the general equations that of the symmetric ones, where it is a parameter."""
    scene = REFERENCES[name].scene
    symmetric, general = simulate(scene, step=1e-3), simulate(nearly_symmetric(scene), step=1e-3)
    assert largest_difference(scene, general, symmetric) < 1e-10
    np.testing.assert_allclose(general.energy - general.energy[0], 0, atol=1e-10 * abs(general.energy[0]))


# One motion, three sets of equations


@pytest.mark.parametrize(
    "scene",
    [SYMMETRIC, AXIAL, integrable(), pytest.param(integrable(Loads()), marks=pytest.mark.nightly)],
    ids=["transverse load", "axial load", "next to no load", "no load"],
)
def test_special_equations_agree_with_the_general_ones(scene):
    """Less is computed where the body is symmetric, and less still under axial load; the numbers are the same."""
    scenes = scene, replace(scene, loads=Loads((1e-300, *scene.loads.gravity[1:]))), nearly_symmetric(scene)
    motions = [simulate(s, step=5e-4) for s in scenes]
    for other in motions[1:]:
        assert largest_difference(scene, motions[0], other) < 1e-11
        np.testing.assert_allclose(motions[0].multipliers, other.multipliers, rtol=0, atol=1e-11)
        np.testing.assert_allclose(motions[0].energy, other.energy, rtol=1e-12)
    assert_equal_statistics(*scenes)


def test_a_motion_without_load_has_the_statistics_of_one_next_to_it():
    assert_equal_statistics(integrable(), integrable(Loads()))


def assert_equal_statistics(*scenes):
    first, *others = (simulate_many(s, **dimensions(s), step=5e-4, on_contact_loss="continue").iloc[0] for s in scenes)
    for other in others:
        assert other.status == first.status
        for name in (name for name in first.index if name.startswith(("contact_force", "tilt_max"))):
            assert other[name] == pytest.approx(first[name], rel=1e-10, abs=1e-12)


# Through the sets where the paper's coordinates break


def crossings(scene, motion):
    """How often a motion crosses theta = 0, X0 = Y0 = 0 and psi = k pi/2."""
    D, E = ends(scene, motion)
    sine, cosine = D[:, 0] * E[:, 1] - D[:, 1] * E[:, 0], np.sum(D * E, axis=1)
    crossed = sine[:-1] * sine[1:] <= 0
    clear = np.hypot(*motion.origin.T) > 0.05 * scene.joint.effective_radius
    quarter = (motion.origin[:-1] * motion.origin[1:] <= 0).any(axis=1) & clear[1:] & clear[:-1]
    return {
        "theta": np.sum(crossed & (cosine[1:] > 0)),
        "maximum tilt": np.sum(crossed & (cosine[1:] < 0)),
        "psi": np.sum(quarter),
    }


PASSES = {
    # name: alpha, beta, their rates at the start
    "theta": (-1.9, -1.5, 6.0, -6.0),
    "maximum tilt": (-3.0, 0.0, -20.0, 20.0),
    "psi": (-1.2, -0.6, -9.0, -7.0),
}


@pytest.mark.parametrize(
    "body", [CYLINDER, pytest.param(UNBALANCED, marks=pytest.mark.slow)], ids=["symmetric", "general"]
)
@pytest.mark.parametrize("name", PASSES)
def test_motion_passes_the_singular_sets_of_the_papers_coordinates(name, body):
    alpha, beta, alpha_rate, beta_rate = PASSES[name]
    scene = Scene(PAPER_JOINT, body, Loads((0, -9.81, 0)), Motion(alpha, beta, alpha_rate, beta_rate, 0.7, 40.0), 0.15)
    motion = simulate(scene, step=2.5e-4)
    assert crossings(scene, motion)[name] >= 1
    assert largest_difference(scene, motion, slope_twin.integrate(scene.scalars, motion.time)) < 1e-9


@pytest.mark.parametrize(
    "body", [CYLINDER, pytest.param(UNBALANCED, marks=pytest.mark.slow)], ids=["symmetric", "general"]
)
@pytest.mark.parametrize("difference", [0.0, 1e-9, np.pi, np.pi - 1e-9])
@pytest.mark.parametrize("rate", [0.0, 3.0])
def test_motion_starts_on_the_singular_sets(difference, rate, body):
    """Axis parallel to the bore, or at maximum tilt, exactly and nearly; psi = k pi/2 as well."""
    motion = Motion(-np.pi / 2, -np.pi / 2 + difference, 2.0, 2.0 + rate, 0.7, 40.0)
    scene = Scene(PAPER_JOINT, body, Loads((0.5, -9.81, 1.0)), motion, 0.1)
    result = simulate(scene, step=2.5e-4)
    assert largest_difference(scene, result, slope_twin.integrate(scene.scalars, result.time)) < 1e-9


# Loads


LOADS = {
    "oblique gravity": Loads((3.0, -9.0, 2.0)),
    "force on the axis": Loads((0, -9.81, 0), (2.0, -1.0, 0.5), (0, 0, 0.03)),
    "force at O": Loads((0, -9.81, 0), (2.0, -1.0, 0.5)),
    "force off the axis": Loads((0, -9.81, 0), (2.0, -1.0, 0.5), (0.01, 0.005, 0.03)),
    "torque along the bearing": Loads((0, -9.81, 0), torque=(0, 0, -4e-3)),
    "torque across": Loads((0, -9.81, 0), torque=(3e-3, 5e-3, 0)),
    "all": LOADED.loads,
}


@pytest.mark.parametrize("body", [CYLINDER, UNBALANCED], ids=["symmetric", "general"])
@pytest.mark.parametrize("loads", LOADS.values(), ids=LOADS)
def test_loads_against_the_twin(loads, body):
    scene = Scene(PAPER_JOINT, body, loads, START, 0.15)
    motion = simulate(scene, step=5e-4)
    twin = slope_twin.integrate(scene.scalars, motion.time[::10])
    thinned = replace(
        motion, **{name: getattr(motion, name)[::10] for name in ("origin", "axis", "contact_force", "energy")}
    )
    assert largest_difference(scene, thinned, twin) < 1e-9
    change, expected = thinned.energy - thinned.energy[0], twin.energy - twin.energy[0]
    np.testing.assert_allclose(change, expected, rtol=0, atol=1e-11)


def test_gravity_is_a_force_at_the_centre_of_mass():
    gravity = np.array([1.0, -9.81, 2.0])
    for body in (CYLINDER, UNBALANCED):
        scene = Scene(PAPER_JOINT, body, Loads(gravity), START, 0.2)
        forced = replace(scene, loads=Loads(force=body.mass * gravity, force_point=body.center_of_mass))
        assert largest_difference(scene, simulate(forced, step=5e-4), simulate(scene, step=5e-4)) < 1e-11


def test_the_work_of_a_torque_is_the_energy_gained():
    """Integral of torque . omega along the twin's motion, by Gauss-Legendre panels, against the energies at the ends."""
    scene = replace(LOADED, duration=0.2)
    nodes, weights = np.polynomial.legendre.leggauss(8)
    edges = np.linspace(0, scene.duration, 21)
    times = (edges[:-1, None] + (nodes + 1) / 2 * np.diff(edges)[:, None]).ravel()
    twin = slope_twin.integrate(scene.scalars, np.concatenate([[0], times]))
    w, w_rate, spin_rate = twin.state[1:, 2:4], twin.state[1:, 7:9], twin.state[1:, 9]
    e, length = twin.axis[1:], np.sqrt(np.sum(w**2, axis=1) + scene.joint.half_length**2)
    e_rate = (np.pad(w_rate, ((0, 0), (0, 1))) - e * np.sum(e[:, :2] * w_rate, axis=1)[:, None]) / length[:, None]
    omega = np.cross(e, e_rate) + spin_rate[:, None] * e
    work = np.sum(np.tile(weights, 20) * np.diff(edges).repeat(8) / 2 * (omega @ scene.loads.torque))
    motion = simulate(scene, step=5e-4)
    assert motion.energy[-1] - motion.energy[0] == pytest.approx(work, rel=1e-9)
    assert simulate_many(scene, **dimensions(scene), step=5e-4).energy_error[0] < 1e-10


# Symmetries of the model


@given(st.floats(-7, 7), st.sampled_from([SYMMETRIC, LOADED]))
@settings(max_examples=20)
def test_turning_the_whole_scene_about_the_bearing_turns_the_motion(angle, scene):
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    loads, start = scene.loads, scene.motion
    turned = replace(
        scene,
        loads=Loads(
            turn @ loads.gravity,
            None if loads.force is None else turn @ loads.force,
            loads.force_point,
            None if loads.torque is None else turn @ loads.torque,
        ),
        # chi is measured from the frame of the smallest rotation, which does not turn with the scene.
        motion=replace(start, alpha=start.alpha + angle, beta=start.beta + angle, spin=start.spin + angle),
    )
    a, b = simulate(scene, step=1e-3), simulate(turned, step=1e-3)
    np.testing.assert_allclose(b.origin, a.origin @ turn[:2, :2].T, rtol=0, atol=1e-12)
    np.testing.assert_allclose(b.axis, a.axis @ turn.T, rtol=0, atol=1e-10)
    np.testing.assert_allclose(b.contact_force, a.contact_force, rtol=0, atol=1e-9)


@given(st.floats(-4, 4), st.floats(-4, 4), st.sampled_from([SYMMETRIC, LOADED]))
@settings(max_examples=20)
def test_the_motion_does_not_depend_on_the_units(length_power, mass_power, scene):
    """Lengths times k, times times sqrt(k), masses times n under the same gravity: forces times n."""
    k, n = 10**length_power, 10**mass_power
    s, time = scene.scalars, np.sqrt(k)
    factor = {
        "bearing_radius": k, "journal_radius": k, "half_length": k, "mass": n,
        **{f"center_of_mass_{a}": k for a in "xyz"},
        **{f"inertia_{a}": n * k**2 for a in ("xx", "yy", "zz", "xy", "xz", "yz")},
        "alpha_rate": 1 / time, "beta_rate": 1 / time, "spin_rate": 1 / time,
    }  # fmt: skip
    if scene.loads.force is not None:
        for axis in "xyz":
            factor |= {f"force_{axis}": n, f"force_point_{axis}": k, f"torque_{axis}": n * k}
    scaled = replace(scene, duration=scene.duration * time).replaced(
        **{name: s[name] * f for name, f in factor.items()}
    )
    a, b = simulate(scene, step=1e-3), simulate(scaled, step=1e-3 * time)
    np.testing.assert_allclose(b.axis, a.axis, rtol=0, atol=1e-10)
    np.testing.assert_allclose(b.contact_force / n, a.contact_force, rtol=0, atol=1e-9)


# Projection on the energy


@everyone
def test_project_energy_keeps_the_energy_where_the_step_alone_does_not(name):
    scene = REFERENCES[name].scene
    step = scene.duration / 25
    plain, projected = (
        simulate_many(scene, **dimensions(scene), step=step, project_energy=p, accuracy=1.0).iloc[0] for p in (False, True)
    )  # fmt: skip
    assert plain.energy_error > 1e-11
    assert projected.energy_error < 1e-13
    fine = simulate(scene, step=1e-4)
    motion = simulate(scene, step=step, project_energy=True)
    assert np.ptp(motion.energy) < 1e-13 * np.abs(motion.energy).max()
    assert np.abs(motion.axis[-1] - fine.axis[-1]).max() < 1e-3


def test_project_energy_counts_the_work_of_a_torque():
    row = simulate_many(LOADED, **dimensions(LOADED), step=2e-3, project_energy=True).iloc[0]
    plain = simulate_many(LOADED, **dimensions(LOADED), step=1e-4).iloc[0]
    assert row.contact_force_D_max == pytest.approx(plain.contact_force_D_max, rel=1e-6)
    assert row.energy_error < 1e-10


@pytest.mark.slow
def test_energy_over_a_million_steps():
    """17 minutes of the paper's joint at 1 ms."""
    scene = replace(REFERENCES["paper_joint_tilted_start"].scene, duration=1000.0)
    for project, allowed in ((True, 1e-10), (False, 1e-9)):
        row = simulate_many(
            scene, **dimensions(scene), step=1e-3, outputs=["energy_error", "constraint_error"], project_energy=project
        ).iloc[0]
        assert row.energy_error < allowed
        assert row.constraint_error < 1e-12
