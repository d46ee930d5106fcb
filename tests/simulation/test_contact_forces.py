"""Contact forces: extremes over continuous time, means as integrals, the loss of contact and what it does."""

import json
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from places import DATA, HELPERS
from scenes import (
    CYLINDER,
    DIMENSIONS,
    FORCES,
    LOADED,
    NEXT_TO_NO_LOAD,
    PAPER_JOINT,
    REFERENCES,
    START,
    SYMMETRIC,
    cylinders,
    dimensions,
    nearly_symmetric,
    row,
    split,
    unbalanced_bodies,
)  # fmt: skip
from scipy.interpolate import BarycentricInterpolator
from scipy.optimize import brentq, minimize_scalar
from twins import slope_twin

import tolmc
from tolmc import Body, Loads, Motion, Scene, simulate, simulate_many
from tolmc.quantities import ALWAYS, END_OUTPUTS
from tolmc.simulation.pilot import plan_integration

everyone = pytest.mark.parametrize("name", REFERENCES)
GENERAL = REFERENCES["general_body_unbalanced"].scene
ENSEMBLES = {"symmetric": cylinders, "general": unbalanced_bodies}


def one(scene, **options):
    """Statistics of a single scene."""
    return simulate_many(scene, **dimensions(scene), **options).iloc[0]


def largest_force(frame):
    return np.maximum(frame.contact_force_D_max, frame.contact_force_E_max)


def extreme(times, values, sign):
    """Maximum of ``sign * values`` over continuous time: polynomial of degree 8 through the neighbours of the largest."""
    values = sign * values
    best = int(np.argmax(values))
    first = min(max(best - 4, 0), len(times) - 9)
    x = np.arange(9.0)
    polynomial = BarycentricInterpolator(x, values[first : first + 9])
    bounds = (max(best - first - 1, 0), min(best - first + 1, 8))
    inside = minimize_scalar(lambda x: -polynomial(x), bounds=bounds, method="bounded", options={"xatol": 1e-9})
    return sign * max(-inside.fun, values[best])


# References and the twin


@everyone
@pytest.mark.parametrize(("step", "tolerance"), [(1e-3, 1e-8), (None, 1e-6)])
def test_statistics_of_the_reference_trajectories(name, step, tolerance):
    expected = REFERENCES[name].expected
    result = one(REFERENCES[name].scene, step=step)
    assert result.status == "ok"
    assert np.isnan(result.contact_loss_time)
    for output in ("tilt_angle", "effective_radius", *(n for n in FORCES if n in expected)):
        assert result[output] == pytest.approx(expected[output], rel=0, abs=tolerance), output


SCENES = {
    "paper joint": replace(REFERENCES["paper_joint_tilted_start"].scene, duration=0.3),
    "unbalanced": replace(GENERAL, duration=0.3),
    "all loads": replace(LOADED, duration=0.2),
}


@pytest.mark.slow
@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_statistics_against_the_twin(scene):
    """Extremes on 1500 points, means and mean squares by Gauss-Legendre panels, of an integration at 1e-13."""
    nodes, weights = np.polynomial.legendre.leggauss(6)
    edges = np.linspace(0, scene.duration, 41)
    quadrature = (edges[:-1, None] + (nodes + 1) / 2 * np.diff(edges)[:, None]).ravel()
    uniform = np.linspace(0, scene.duration, 1500)
    times, back = np.unique(np.concatenate([uniform, quadrature]), return_inverse=True)
    twin = slope_twin.integrate(scene.scalars, times)
    weight = np.tile(weights, 40) / 80
    result = one(scene, step=5e-4, on_contact_loss="continue")
    for column, side in enumerate("DE"):
        force = twin.contact_force[back, column]
        sampled, at_nodes = force[:1500], force[1500:]
        expected = {
            "max": extreme(uniform, sampled, 1),
            "min": extreme(uniform, sampled, -1),
            "mean": weight @ at_nodes,
            "rms": np.sqrt(weight @ at_nodes**2),
        }
        for kind, value in expected.items():
            assert result[f"contact_force_{side}_{kind}"] == pytest.approx(value, rel=0, abs=1e-9), (side, kind)
    tilt = np.arccos(np.minimum(twin.axis[back][:1500, 2], 1))
    assert result.tilt_max == pytest.approx(extreme(uniform, tilt, 1), abs=1e-9)


# Extremes are over continuous time


@pytest.mark.parametrize("ensemble", ENSEMBLES.values(), ids=ENSEMBLES)
def test_halving_the_step_does_not_move_the_statistics_of_random_samples(ensemble):
    """400 motions; what the finer step finds within its steps the coarser one has found within its own."""
    samples, scene = ensemble(400, 5), replace(SYMMETRIC, duration=0.2)
    coarse, fine = (simulate_many(scene, **split(samples), step=h, on_contact_loss="continue") for h in (1e-3, 5e-4))
    well_resolved = fine.energy_error < 1e-12
    assert well_resolved.sum() > 300
    scale = largest_force(fine)
    for name in FORCES:
        moved = np.abs(coarse[name] - fine[name])[well_resolved] / scale[well_resolved]
        assert moved.max() < 1e-7, name
    assert np.abs(coarse.tilt_max / fine.tilt_max - 1)[well_resolved].max() < 1e-7


@pytest.mark.parametrize("method", ["rk8", pytest.param("rk4", marks=pytest.mark.slow)])
@pytest.mark.parametrize("accuracy", [1e-5, 1e-7, 1e-9])
def test_the_planned_step_gives_peaks_within_the_stated_accuracy(accuracy, method):
    """300 samples between the corners that the pilot looked at: half its step moves no statistic by more."""
    rng = np.random.default_rng(3)
    samples = {
        name: SYMMETRIC.scalars[name] * rng.uniform(0.98, 1.02, 300)
        for name in (*DIMENSIONS, "mass", "gravity_y", "alpha", "beta", "alpha_rate", "beta_rate", "spin_rate")
    }
    bounds = {name: (column.min(), column.max()) for name, column in samples.items()}
    scene = replace(SYMMETRIC, duration=0.4)
    plan = plan_integration(scene, bounds, accuracy=accuracy, method=method)
    coarse, fine = (
        simulate_many(scene, **split(samples), step=scene.duration / n, method=method, accuracy=accuracy)
        for n in (plan.steps, 2 * plan.steps)
    )
    assert (coarse.status == "ok").all()
    assert coarse.energy_error.max() <= accuracy
    for name in FORCES:
        assert (np.abs(coarse[name] - fine[name]) / largest_force(fine)).max() < accuracy, name
    assert np.abs(coarse.tilt_max - fine.tilt_max).max() < accuracy


@pytest.mark.parametrize("method", ["rk8", pytest.param("rk4", marks=pytest.mark.slow)])
def test_peaks_and_means_converge_with_the_order_of_the_method(method):
    """Halving the step divides the error of a statistic by about as much as that of the state, over 200 motions."""
    samples, scene = cylinders(200, 8), replace(SYMMETRIC, duration=0.2)
    steps, order = {"rk8": (16, 8), "rk4": (200, 4)}[method]

    def errors(n):
        result = simulate_many(
            scene, **split(samples), step=scene.duration / n, method=method, on_contact_loss="continue", accuracy=1.0,
            outputs=[*ALWAYS, *END_OUTPUTS],
        )  # fmt: skip
        error = (result - fine)[[*FORCES, *END_OUTPUTS]].abs()
        error[list(FORCES)] = error[list(FORCES)].div(largest_force(fine), axis=0)
        return error.median()

    fine = simulate_many(
        scene, **split(samples), step=1e-4, on_contact_loss="continue", outputs=[*ALWAYS, *END_OUTPUTS]
    ).drop(columns=["status"])
    coarse, half = errors(steps), errors(2 * steps)
    for name in FORCES:
        assert half[name] < coarse[name] / 2 ** (order - 1), name


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_statistics_do_not_depend_on_where_the_steps_fall(scene):
    results = [one(scene, step=scene.duration / n, on_contact_loss="continue") for n in (230, 307, 351, 499)]
    for name in (*FORCES, "tilt_max"):
        values = [result[name] for result in results]
        assert np.ptp(values) < 1e-9, name


@pytest.mark.parametrize("duration", [1e-3, 4e-3, 9e-3, 16e-3])
def test_extremes_at_the_start_and_at_the_end(duration):
    """In a motion too short to turn round the extremes are its ends."""
    scene = replace(SYMMETRIC, duration=duration)
    for steps in (4, 7):
        motion, result = simulate(scene, step=duration / steps), one(scene, step=duration / steps)
        dense = simulate(scene, step=duration / 400)
        for column, side in enumerate("DE"):
            force = dense.contact_force[:, column]
            for kind, pick in (("max", np.max), ("min", np.min)):
                value = result[f"contact_force_{side}_{kind}"]
                assert value == pytest.approx(pick(force), abs=1e-6)
                assert pick([value, *motion.contact_force[:, column]]) == pytest.approx(value, abs=1e-12)


@pytest.mark.parametrize("ensemble", ENSEMBLES.values(), ids=ENSEMBLES)
def test_the_statistics_of_a_sample_are_in_order(ensemble):
    result = simulate_many(replace(SYMMETRIC, duration=0.1), **split(ensemble(400, 6)), step=1e-3)
    result = result[(result.status == "ok") | (result.contact_loss_time > 0)]
    assert len(result) > 250
    for side in "DE":
        top, bottom, mean, rms = (result[f"contact_force_{side}_{kind}"] for kind in ("max", "min", "mean", "rms"))
        assert (bottom <= mean * (1 + 1e-12) + 1e-12).all()
        assert (mean <= top * (1 + 1e-12) + 1e-12).all()
        assert (np.abs(mean) <= rms * (1 + 1e-12)).all()
        assert (bottom >= -1e-7 * top).all(), "a force is negative, yet contact is said to hold"
    assert (result.tilt_max <= result.tilt_angle * (1 + 1e-9)).all()


# Rest and steady motion, where the forces are known


@pytest.mark.parametrize("angle", np.linspace(-3, 3, 7))
@pytest.mark.parametrize("step", [1e-3, None])
def test_a_shaft_at_rest_carries_its_weight(angle, step):
    """N_D + N_E = m g, N_D - N_E = m g z_C/L, at the lowest place under gravity in any transverse direction."""
    gravity = 9.81 * np.array([np.cos(angle), np.sin(angle), 0])
    scene = Scene(PAPER_JOINT, CYLINDER, Loads(gravity), Motion(angle, angle), 0.2)
    weight, lever = CYLINDER.mass * 9.81, CYLINDER.center_of_mass[2] / PAPER_JOINT.half_length
    for s in (scene, nearly_symmetric(scene)):
        result = one(s, step=step)
        assert result.status == "ok"
        for kind in ("max", "min", "mean", "rms"):
            assert result[f"contact_force_D_{kind}"] == pytest.approx(weight * (1 + lever) / 2, rel=1e-9)
            assert result[f"contact_force_E_{kind}"] == pytest.approx(weight * (1 - lever) / 2, rel=1e-9)
        assert result.tilt_max < 1e-7


@pytest.mark.parametrize("offset", [1e-3, 1e-6, 1e-9, 1e-12])
def test_small_oscillations_about_rest_are_accurate_motions(offset):
    """However little moves: the energy error is judged against the loads, not against the little that moves."""
    scene = Scene(PAPER_JOINT, CYLINDER, Loads((0, -9.81, 0)), Motion(-np.pi / 2 + offset, -np.pi / 2), 0.2)
    assert one(scene, step=1e-3).status == "ok"
    assert plan_integration(scene).steps < 1000


def test_a_vertical_shaft_leans_against_both_ends():
    """At rest at maximum tilt the couple of the contact forces carries the weight's: 2 N L/cos(psi) = m g z_C sin(psi)."""
    psi = PAPER_JOINT.tilt_angle
    result = one(Scene(PAPER_JOINT, CYLINDER, Loads((0, 0, -9.81)), Motion(0.3, 0.3 + np.pi), 0.1), step=1e-3)
    force = (
        CYLINDER.mass * 9.81 * CYLINDER.center_of_mass[2] * np.sin(psi) * np.cos(psi) / (2 * PAPER_JOINT.half_length)
    )
    assert result.contact_force_D_mean == pytest.approx(force, rel=1e-9)
    assert result.contact_force_E_mean == pytest.approx(force, rel=1e-9)
    assert result.tilt_max == pytest.approx(psi, rel=1e-9)


@pytest.mark.parametrize(
    "loads", [NEXT_TO_NO_LOAD, pytest.param(Loads(), marks=pytest.mark.nightly)], ids=["next to no load", "no load"]
)
def test_steady_precession_at_maximum_tilt(loads):
    """2 N L/cos(psi) = nu (A nu cos(psi) - C Omega) sin(psi): the couple turns the angular momentum at the rate nu."""
    body, nu, spin = Body(0.5, (0, 0, 0), (4e-4, 4e-4, 1.2e-4)), 30.0, -40.0
    scene = Scene(PAPER_JOINT, body, loads, Motion(0.3, 0.3 + np.pi, nu, nu, 0, spin), 0.05)
    psi, L = PAPER_JOINT.tilt_angle, PAPER_JOINT.half_length
    force = nu * (4e-4 * nu * np.cos(psi) - 1.2e-4 * spin) * np.sin(psi) * np.cos(psi) / (2 * L)
    for s in (scene, nearly_symmetric(scene)):
        motion = simulate(s, step=5e-4)
        np.testing.assert_allclose(motion.contact_force, force, rtol=1e-9)
        np.testing.assert_allclose(motion.tilt, psi, rtol=1e-9)


def test_no_load_and_no_motion_give_no_force():
    for motion in (Motion(0.3, 0.3), Motion(0.3, 1.2, spin_rate=100), Motion(0.3, 0.3 + np.pi, spin_rate=100)):
        scene = Scene(PAPER_JOINT, CYLINDER, Loads(), motion, 0.1)
        for step in (1e-2, None):
            result = one(scene, step=step)
            assert result.status == "ok"
            assert all(abs(result[name]) < 1e-12 for name in FORCES)


def test_results_depend_neither_on_workers_nor_on_what_is_integrated_next():
    scene = replace(SYMMETRIC, duration=0.15)
    samples, others = cylinders(300, 5), cylinders(300, 6)
    result = simulate_many(scene, **split(samples), step=1e-3)
    kept = result.copy(deep=True)
    simulate_many(scene, **split(others), step=1e-3)
    pd.testing.assert_frame_equal(result, kept)
    for workers in (2, 3):
        pd.testing.assert_frame_equal(simulate_many(scene, **split(samples), step=1e-3, workers=workers), kept)
    few = simulate_many(scene, **split(samples, slice(7, 12)), step=1e-3)
    pd.testing.assert_frame_equal(few, kept[7:12].reset_index(drop=True))


# Loss of contact


def losing(count=4):
    """Scenes that lose contact some time after their start: spinning unbalanced bodies, and rolling shafts."""
    found = {}
    for label, ensemble in ENSEMBLES.items():
        samples, scene = ensemble(300, 5), replace(SYMMETRIC, duration=0.15)
        result = simulate_many(scene, **split(samples), step=1e-3)
        lost = np.flatnonzero((result.status == "contact lost") & (result.contact_loss_time > 0.01))
        found |= {f"{label} {i}": row(scene, samples, i) for i in lost[:count]}
    return found


def twin_loss_time(scene):
    """First root of min(N_D, N_E) along the twin's motion."""

    def smaller(times):
        return slope_twin.integrate(scene.scalars, times).contact_force.min(axis=1)

    times = np.linspace(0, scene.duration, 601)
    after = np.argmax(smaller(times) < 0)
    nodes = np.linspace(times[after - 1], times[after], 9)
    at_nodes = smaller(np.concatenate([[0], nodes]))[1:]
    x = np.linspace(0, 1, 9)
    root = brentq(BarycentricInterpolator(x, at_nodes), 0, 1, xtol=1e-14)
    return nodes[0] + root * (nodes[-1] - nodes[0])


@pytest.mark.slow
def test_the_time_of_contact_loss_is_a_root():
    scenes = losing(2)
    assert len(scenes) == 4
    for name, scene in scenes.items():
        expected = twin_loss_time(scene)
        for step in (1e-3, 5e-4):
            result = one(scene, step=step)
            assert result.status == "contact lost"
            assert result.contact_loss_time == pytest.approx(expected, rel=0, abs=1e-10), (name, step)
            assert result.status_time == result.contact_loss_time


@pytest.mark.parametrize("ensemble", ENSEMBLES.values(), ids=ENSEMBLES)
def test_the_time_of_contact_loss_does_not_depend_on_the_step(ensemble):
    samples, scene = ensemble(400, 5), replace(SYMMETRIC, duration=0.15)
    coarse, fine = (simulate_many(scene, **split(samples), step=h) for h in (1e-3, 5e-4))
    resolved = fine.energy_error < 1e-12
    assert (coarse.contact_loss_time.isna() == fine.contact_loss_time.isna())[resolved].all()
    lost = fine.contact_loss_time.notna() & resolved
    assert lost.sum() > 10
    assert np.abs(coarse.contact_loss_time - fine.contact_loss_time)[lost].max() < 1e-9


def test_what_a_loss_of_contact_does():
    """stop, or end: the sample up to the loss. continue: the two-sided model goes on."""
    for scene in losing(3).values():
        stop, go_on, end = (
            one(scene, step=5e-4, on_contact_loss=choice, outputs=[*ALWAYS, *END_OUTPUTS])
            for choice in ("stop", "continue", "end")
        )
        time = stop.contact_loss_time
        until = one(
            replace(scene, duration=time), step=5e-4, on_contact_loss="continue", outputs=[*ALWAYS, *END_OUTPUTS]
        )
        dense = simulate(scene, step=1e-4)
        for result in (stop, go_on, end):
            assert result.status == "contact lost"
            assert result.contact_loss_time == time
        for name in FORCES:
            assert stop[name] == pytest.approx(until[name], abs=1e-8), name
            assert end[name] == stop[name]
        assert min(stop.contact_force_D_min, stop.contact_force_E_min) == pytest.approx(0, abs=1e-8)
        for column, side in enumerate("DE"):
            force = dense.contact_force[:, column]
            assert go_on[f"contact_force_{side}_min"] == pytest.approx(force.min(), abs=1e-3 * np.ptp(force))
            assert go_on[f"contact_force_{side}_max"] == pytest.approx(force.max(), abs=1e-3 * np.ptp(force))
            assert go_on[f"contact_force_{side}_mean"] == pytest.approx(
                np.trapezoid(force, dense.time) / scene.duration, abs=1e-5 * np.ptp(force)
            )
        assert min(go_on.contact_force_D_min, go_on.contact_force_E_min) < 0
        assert go_on.tilt_max == pytest.approx(dense.tilt.max(), rel=1e-4)
        np.testing.assert_allclose([go_on.axis_x_end, go_on.axis_y_end, go_on.axis_z_end], dense.axis[-1], atol=1e-8)
        for result in (stop, end):
            for name in ("tilt_max", *END_OUTPUTS):
                assert result[name] == pytest.approx(until[name], abs=1e-8), name
        assert simulate(scene, step=5e-4).status.startswith("contact lost at t = ")


def test_samples_that_keep_contact_are_the_same_whatever_a_loss_does():
    samples, scene = cylinders(200, 5), replace(SYMMETRIC, duration=0.1)
    stop, go_on, end = (
        simulate_many(scene, **split(samples), step=1e-3, on_contact_loss=choice)
        for choice in ("stop", "continue", "end")
    )
    kept = stop.status == "ok"
    assert 100 < kept.sum() < 200
    for other in (go_on, end):
        assert (other.status == stop.status).all()
        assert other[kept].equals(stop[kept])


def test_contact_lost_from_the_start():
    """A shaft set free on the ceiling: the statistics are those of the instant at which it falls."""
    scene = Scene(PAPER_JOINT, CYLINDER, Loads((0, -9.81, 0)), Motion(np.pi / 2 + 0.1, np.pi / 2), 0.1)
    start = simulate(scene, step=1e-3).contact_force[0]
    assert (start < 0).all()
    for choice in ("stop", "end"):
        result = one(scene, step=1e-3, on_contact_loss=choice)
        assert result.status == "contact lost"
        assert result.contact_loss_time == 0
        for kind in ("max", "min", "mean"):
            assert result[f"contact_force_D_{kind}"] == pytest.approx(start[0], rel=1e-12), kind
            assert result[f"contact_force_E_{kind}"] == pytest.approx(start[1], rel=1e-12), kind
        assert result.contact_force_D_rms == pytest.approx(-start[0], rel=1e-12)
        assert result.contact_force_E_rms == pytest.approx(-start[1], rel=1e-12)


def test_extrema_end_with_the_statistics():
    """Contact is lost where N_D dips below zero for an instant: the dip is not the minimum, wherever a step ends."""
    scene = GENERAL.replaced(
        bearing_radius=0.02002721988435161, gravity_y=-9.386423731024957, alpha_rate=-0.5777115544620308,
        spin_rate=30.748329858421627,
    )  # fmt: skip
    scene = replace(scene, duration=0.4)
    time = one(scene, step=1e-3).contact_loss_time
    assert 0.3 < time < 0.4
    until = simulate(replace(scene, duration=time), step=1e-3)
    dip = simulate(replace(scene, duration=time + 1e-3), step=1e-4).contact_force.min()
    assert dip < -1e-4
    for steps in range(100, 180, 3):
        result = one(scene, step=scene.duration / steps)
        assert result.status == "contact lost"
        assert result.contact_loss_time == pytest.approx(time, abs=1e-7)
        assert 0 <= min(result.contact_force_D_min, result.contact_force_E_min) < 1e-9
        for k, side in enumerate("DE"):
            assert result[f"contact_force_{side}_max"] == pytest.approx(until.contact_force[:, k].max(), rel=1e-3)


@pytest.mark.parametrize("steps", [8, 20, 75, 300])
def test_grazing_losses_are_found_and_near_misses_are_not(steps):
    """A shaft rocking so far that a force falls to just above or just below zero."""

    def lowest(alpha_rate):
        scene = replace(SYMMETRIC, motion=replace(START, alpha_rate=alpha_rate), duration=0.15)
        result = one(scene, step=scene.duration / steps, on_contact_loss="continue", accuracy=1.0)
        return min(result.contact_force_D_min, result.contact_force_E_min), result

    assert lowest(0.0)[0] > 0 > lowest(30.0)[0]
    limit = brentq(lambda rate: lowest(rate)[0], 0.0, 30.0, xtol=1e-13)
    for distance in (1e-2, 1e-4, 1e-6, 1e-8):
        assert lowest(limit - distance)[1].status == "ok"
        assert lowest(limit + distance)[1].status == "contact lost"


@pytest.mark.slow
def test_no_sample_takes_for_ever():
    """Steps so coarse that the samples within a step and the motion disagree on whether a force turns negative."""
    program = """
from dataclasses import replace
from scenes import SYMMETRIC, cylinders, split, unbalanced_bodies
from tolmc import simulate_many
for ensemble in (cylinders, unbalanced_bodies):
    for step in (0.05, 0.03, 0.02, 0.01):
        samples = ensemble(4000, 1)
        result = simulate_many(replace(SYMMETRIC, duration=0.5), **split(samples), step=step)
        assert len(result) == 4000
"""
    subprocess.run([sys.executable, "-c", program], cwd=HELPERS, check=True, timeout=120)


def test_results_are_apart_from_the_callers_arrays():
    radii = np.full(3, PAPER_JOINT.bearing_radius)
    result = simulate_many(SYMMETRIC, bearing_radius=radii, journal_radius=0.01, half_length=0.02, step=1e-3)
    radii[:] = 0.0
    assert (result.bearing_radius == PAPER_JOINT.bearing_radius).all()


# Given steps


def test_a_spike_that_is_passed_again_and_again_counts_as_often():
    """Eleven steps as rough as the roughest, each off by 6e-6: the largest force is off by 1.7e-3."""
    joint = tolmc.Joint(0.003667146893093928, 0.0006747180904625004, 2.745679927745515, section="exact")
    body = Body(0.5, (0.0, 0.0, -0.006317768443353234), np.diag((0.000408, 0.000408, 0.00012)))
    motion = Motion(
        -0.23588775057716224, -0.22140986237742422, -41.129545094767465, -2.224579379840245, spin_rate=5.516951163486831
    )
    scene = Scene(joint, body, Loads((0.0, 0.0, -2.395651220449453)), motion, 0.08358421204555022)
    coarse, fine = (one(scene, step=scene.duration / steps) for steps in (213, 3408))
    assert fine.status == "ok"
    assert coarse.contact_force_D_max != pytest.approx(fine.contact_force_D_max, rel=1e-3)
    assert coarse.status == "inaccurate"
    assert coarse.step_error > 1e-4


EXTREMA = json.loads((DATA / "extrema.json").read_text())


@pytest.mark.parametrize("name", EXTREMA)
@pytest.mark.parametrize("halving", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_statistics_at_given_steps_are_right_or_flagged(name, halving):
    """Motions whose extrema lie between coarse steps, spike within one, or graze zero; an integration of DOP853's has them."""
    case = EXTREMA[name]
    joint = tolmc.Joint(*(case[dimension] for dimension in DIMENSIONS), section=case["section"])
    loads = Loads(case["gravity"], case["force"], case["force_point"], case["torque"])
    body = Body(case["mass"], case["center_of_mass"], case["inertia"])
    scene = Scene(joint, body, loads, Motion(**case["motion"]), case["duration"])
    found, expected = one(scene, step=scene.duration / case["steps"], halving=halving), case["expected"]
    if found.status == "inaccurate":
        assert name in ("energy_blind_733", "late_loss_937", "gap_accuracy_2008")
        return
    lost = expected["contact_loss_time"]
    assert found.status == ("ok" if lost is None else "contact lost")
    largest = max(expected["contact_force_D_max"], expected["contact_force_E_max"])
    for force in FORCES:
        assert found[force] == pytest.approx(expected[force], rel=0, abs=1e-4 * largest)
    if lost is not None:
        assert found.contact_loss_time == pytest.approx(lost, rel=1e-6)
