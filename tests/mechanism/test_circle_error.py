"""The estimate of the circle's error against differences between circle and exact section."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import SYMMETRIC, dimensions

from tolmc.mechanism.circle_error import section_error_estimate
from tolmc.mechanism.scene import Joint
from tolmc.simulation.ensemble import simulate_many
from tolmc.simulation.trajectory import simulate

JOINTS = [Joint(0.01 * (1 + ratio), 0.01, 0.01 * L) for ratio, L in ((1e-4, 0.5), (0.01, 2.0), (1.0, 2.0), (0.5, 20.0))]


def start(joint, section, alpha, beta):
    """Distance of D from Z and slope of the axis at the start."""
    scene = replace(SYMMETRIC, joint=replace(joint, section=section), duration=1e-6).replaced(alpha=alpha, beta=beta)
    motion = simulate(scene, step=scene.duration)
    slope = motion.axis[0, :2] / motion.axis[0, 2]
    return np.hypot(*(motion.origin[0] + joint.half_length * slope)), np.hypot(*slope)


@pytest.mark.parametrize("joint", JOINTS, ids=str)
def test_position_is_the_largest_difference_over_all_poses(joint):
    errors = []
    for half in np.linspace(0, np.pi / 2, 9):
        circle, exact = (start(joint, section, 0.3 + half, 0.3 - half)[0] for section in ("circle", "exact"))
        errors.append(1 - circle / exact)
    estimate = section_error_estimate(joint)["position"]
    assert errors[0] == pytest.approx(estimate, rel=1e-6, abs=1e-14)
    assert max(errors) == errors[0]
    assert abs(errors[-1]) < 1e-14


@pytest.mark.parametrize("joint", JOINTS, ids=str)
def test_tilt_is_the_difference_at_small_tilt(joint):
    circle, exact = (start(joint, section, 0.3 + 1e-5, 0.3 - 1e-5)[1] for section in ("circle", "exact"))
    assert 1 - circle / exact == pytest.approx(section_error_estimate(joint)["tilt"], rel=1e-4, abs=1e-9)


def test_position_of_usual_clearances_is_half_of_journal_times_clearance_over_length_squared():
    for ratio in (1e-3, 1e-6, 1e-9):
        joint = Joint(0.01 * (1 + ratio), 0.01, 0.03)
        estimate = section_error_estimate(joint)["position"]
        assert estimate == pytest.approx(0.01 * joint.approximate_radius / (2 * 0.03**2), rel=ratio)


def test_nine_out_of_ten_force_peaks_stay_below_the_estimate():
    rng = np.random.default_rng(3)
    joint = Joint(0.011, 0.01, 0.02)
    unit = np.sqrt(joint.approximate_radius / 9.81)
    parameters = dict(zip(("alpha", "beta"), -np.pi / 2 + rng.uniform(-1, 1, (2, 64)), strict=True))
    parameters |= dict(zip(("alpha_rate", "beta_rate"), rng.uniform(-0.5, 0.5, (2, 64)) / unit, strict=True))
    peaks = ["contact_force_D_max", "contact_force_E_max"]
    found = {}
    for section in ("circle", "exact"):
        scene = replace(SYMMETRIC, joint=replace(joint, section=section), duration=10 * unit)
        results = simulate_many(
            scene, **dimensions(scene), parameters=parameters, outputs=peaks, on_contact_loss="continue"
        )  # fmt: skip
        found[section] = results[peaks].where(results.status == "ok")
    error = (found["circle"] / found["exact"] - 1).abs().max(axis=1).dropna()
    estimate = section_error_estimate(joint)["contact_force"]
    assert len(error) > 40
    assert error.quantile(0.8) < estimate < 10 * error.median()
