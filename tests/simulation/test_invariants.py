"""What watches a sample: invariants as columns, statistics that must not contradict each other, a pilot that gives up."""

import math
import time
import warnings
from dataclasses import replace

import numpy as np
import pytest
from scenes import CYLINDER, LOADED, PAPER_JOINT, START, SYMMETRIC, UNBALANCED, dimensions, nearly_symmetric
from twins.invariants import angular_momentum_z

from tolmc import Body, Joint, Loads, Motion, Scene, simulate, simulate_many
from tolmc.kernels import results as R
from tolmc.quantities import ALWAYS, END_OUTPUTS
from tolmc.simulation import pilot
from tolmc.simulation.integration import integrate
from tolmc.simulation.judge import INACCURATE, judged
from tolmc.simulation.packing import pack
from tolmc.simulation.pilot import plan_integration
from tolmc.simulation.plan import step_seconds

UPRIGHT = Scene(PAPER_JOINT, CYLINDER, Loads((0, 0, -9.81)), START, 0.2)
EXACT = replace(UPRIGHT, joint=replace(PAPER_JOINT, section="exact"))
FREE = replace(UPRIGHT, body=UNBALANCED, loads=Loads((0, 0, -9.81), (0, 0, 0.7), (0.01, 0.02, 0.03)))
CONSERVING = {
    "axial": UPRIGHT,
    "general": FREE,
    "symmetric body, general equations": nearly_symmetric(UPRIGHT),
    "exact": EXACT,
    "exact general": replace(FREE, joint=EXACT.joint),
    "horizontal torque": replace(FREE, loads=Loads(torque=(2e-3, -1e-3, 0))),
    "no load": replace(UPRIGHT, loads=Loads()),
}


def one(scene, **options):
    return simulate_many(scene, **dimensions(scene), **options).iloc[0]


#: Half the sum of the polar angles is cyclic there, its momentum a coordinate that no step changes.
KEPT_BY_ANY_STEP = ("axial", "exact", "no load")


@pytest.mark.parametrize("name", CONSERVING)
def test_angular_momentum_is_watched_where_no_load_turns_about_z(name):
    """Kept to rounding by short steps, to the method's order by long ones."""
    scene = CONSERVING[name]
    whole = {"accuracy": 1.0, "on_contact_loss": "continue"}  # past the instant at which a sample would end
    fine, coarse, coarser = (one(scene, step=step, **whole).momentum_error for step in (2e-4, 8e-3, 1.6e-2))
    assert fine < 1e-12
    if name in KEPT_BY_ANY_STEP:
        assert coarser < 1e-13
    else:
        assert coarser > 30 * coarse > 1e3 * fine


@pytest.mark.parametrize(
    ("formulation", "outputs"),
    [
        # With its pose, so by the equations that all tests of rk4 have in common.
        ("slope", [*ALWAYS, *END_OUTPUTS, "momentum_error"]),
        pytest.param("slope", None, marks=pytest.mark.nightly),
        ("published", None),
        ("published-regular", None),
    ],
)
def test_the_momentum_error_is_that_of_the_motion(formulation, outputs):
    """The axis's own motion, by splines through it, keeps the momentum; what a coarse one loses falls with the order."""
    scene, step = replace(UPRIGHT, duration=0.15), 0.01
    fine = simulate(scene, step=1e-4)
    momentum = angular_momentum_z(scene.body, fine.time, fine.origin, fine.axis, scene.motion.spin_rate)[20:-20]
    assert np.ptp(momentum) < 1e-9 * np.abs(momentum).max()
    options = {"formulation": formulation, "method": "rk4", "accuracy": 1.0, "on_contact_loss": "continue"}
    options["outputs"] = outputs
    errors = [one(scene, step=step / n, **options).momentum_error for n in (1, 2, 4)]
    assert 1e-9 < errors[0] < 1e-2
    assert errors[0] > 8 * errors[1] > 64 * errors[2]


@pytest.mark.parametrize("scene", [SYMMETRIC, LOADED], ids=["gravity across", "all loads"])
def test_what_is_not_conserved_is_no_column(scene):
    assert "momentum_error" not in simulate_many(scene, **dimensions(scene), step=1e-3)
    assert ("spin_error" in simulate_many(scene, **dimensions(scene), step=1e-3)) == scene.body.is_symmetric


def test_the_spin_is_watched_where_it_is_constant():
    """A constant of the slope form's equations, a result of the published ones."""
    assert one(SYMMETRIC, step=1e-3).spin_error == 0
    options = {"formulation": "published-regular", "method": "rk4", "accuracy": 1.0}
    coarse, fine = (one(SYMMETRIC, step=step, **options).spin_error for step in (1e-2, 1e-3))
    assert coarse > 1e3 * fine
    assert fine < 1e-8


def test_a_projection_on_the_energy_hides_no_error():
    """What the projection took out is what the energy would have been off by, and is judged like it."""
    body = Body.from_centroidal(0.5, (3e-4, -2e-4, 0.004), [[4e-4, 1e-5, 0], [1e-5, 4.2e-4, 0], [0, 0, 1.2e-4]])
    scene = Scene(PAPER_JOINT, body, Loads((0, -9.81, 0)), Motion(-1.92, -0.87, 2, -3, 0, 80.0), 20.0)
    projected, plain = one(scene, step=0.03, project_energy=True), one(scene, step=0.03)
    assert projected.energy_error < 1e-13
    assert plain.energy_error / 3 < projected.energy_correction < 3 * plain.energy_error
    assert plain.status == projected.status == "inaccurate"
    fine = one(scene, step=2e-3, project_energy=True)
    assert fine.status == "ok"
    assert fine.energy_correction < 1e-9
    assert "energy_correction" not in plain


def test_forces_that_contradict_each_other_are_no_result_however_large_the_largest():
    """As in motions that blew up where contact seemed to be lost: beside 2e15 N any contradiction is small.

    A mean above its rms; then a mean and an rms above the largest force of their end, below that of the other.
    """
    plan = plan_integration(SYMMETRIC, step=1e-3)
    columns = {name: np.full(3, value) for name, value in SYMMETRIC.scalars.items()}
    raw, code = pack(columns, 3)
    results = integrate(raw, plan, True, SYMMETRIC.duration, "stop", False)
    results[R.D_MEAN : R.D_RMS + 1, 1] = 1.2e6, 2.2e4
    results[R.D_MAX, 1] = 2e15
    results[R.D_MEAN : R.D_RMS + 1, 2] = 5.2e5, 6.6e5
    results[R.D_MAX, 2], results[R.E_MAX, 2] = 2.3e4, 8.2e10
    assert judged(code, results, raw, plan, forces=True).tolist() == [R.OK, INACCURATE, INACCURATE]


@pytest.mark.parametrize("factor", [1e155, 1e-165])
def test_forces_whose_squares_leave_the_range_are_not_ok(factor):
    scene = replace(SYMMETRIC, body=Body(factor, (0, 0, 0.004), factor * np.array([8.16e-4, 8.16e-4, 2.4e-4])))
    assert one(scene, step=1e-3).status in ("diverged", "inaccurate")


def test_a_diverged_motion_is_called_so_and_has_no_statistics():
    scene = replace(SYMMETRIC, motion=replace(START, spin_rate=1e6))
    row = one(scene, step=1e-4, on_contact_loss="continue")  # the wall would let go before
    assert row.status == "diverged"
    assert np.isnan(row.filter(like="contact_force").astype(float)).all()
    assert simulate(scene, step=1e-4).status.startswith("diverged")


@pytest.mark.parametrize("formulation", ["slope", "published", "published-regular"])
def test_absurd_scenes_warn_of_nothing(formulation):
    length, inertia = 0.002120382286379494, 273333.5215289062
    scene = Scene(
        Joint(0.02, 0.01, length), Body(1.0, (0, 0, 0.004), (inertia, inertia, 0.5)), Loads((0, -371.8562462310606, 0)),
        Motion(-1.5143186317046384, 1.7533841175163727, -0.11129219318751944, -0.6885649476343216, 0, 0.14425708806082496),
        0.1,
    )  # fmt: skip
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert one(scene, step=0.1, method="rk4", formulation=formulation).status != "ok"
        assert not simulate(scene, step=0.1, method="rk4", formulation=formulation).status.startswith("ok")


def test_a_pilot_that_meets_no_accuracy_says_so():
    """At one corner of this box the clearance is a rounding error: no step resolves that motion; samples are halved."""
    scene = replace(SYMMETRIC, joint=Joint(0.02, 0.0199, 0.02), duration=0.02)
    bounds = {"journal_radius": (0.0198, np.nextafter(0.02, 0.0))}
    plan = plan_integration(scene, bounds)
    assert plan.unresolved == 1
    assert plan.halving
    assert plan.pilot_error < plan.accuracy
    assert plan.steps < 10_000
    settled = plan_integration(scene, {"journal_radius": (0.0198, 0.01995)})
    assert settled.unresolved == 0
    assert not settled.halving


def test_samples_are_judged_by_how_errors_grow_along_the_pilots_motions():
    """What the roughest step leaves may add up along a motion; no sample as rough as the pilot's is refused for it."""
    joints = {"bearing_radius": 0.02, "journal_radius": np.linspace(0.0098, 0.0102, 8), "half_length": 0.02}
    plan = plan_integration(SYMMETRIC, {"journal_radius": (0.0098, 0.0102)})
    assert plan.growth > 0.0
    unknown, thrice = (
        simulate_many(SYMMETRIC, **joints, plan=replace(plan, growth=growth)).step_error for growth in (math.nan, 3.0)
    )
    assert (unknown > 0.0).all()
    np.testing.assert_allclose(thrice, unknown * (3.0 / 0.3), rtol=1e-12)
    # An error of rounding tells nothing.
    assert pilot._growth(np.array([3e-9, 1e-12]), np.array([1e-9, 1e-15]), 1e-7) == pytest.approx(3.0)
    assert pilot._growth(np.array([3e-9, 2e-9]), np.array([1e-10, 1e-8]), 1e-7) == pytest.approx(1e-7 / (2.0 * 1e-8))
    assert math.isnan(pilot._growth(np.array([1e-12]), np.array([1e-15]), 1e-7))


def test_a_pilot_has_a_bound(monkeypatch):
    """Where it is spent before a motion is resolved, the pilot says that it is not, and with which steps it came nearest."""
    body = Body.from_centroidal(80.0, (0.05, 0.0, 0.003), (1.2, 1.2, 1.0))
    scene = Scene(Joint(0.0309, 0.03, 0.04), body, Loads((0, -9.81, 0)), Motion(-1.57, -1.57, 0, 0, -1.0, 0.0), 2.0)
    taken = []

    def counted(raw, plan, *settings):
        taken.append(plan.steps)
        return integrate(raw, plan, *settings)

    monkeypatch.setattr(pilot, "integrate", counted)
    monkeypatch.setattr(pilot, "_SECONDS", 0.02)
    plan = plan_integration(scene, on_contact_loss="continue")
    assert plan.unresolved == 1 and plan.bounded and plan.halving
    assert sum(taken) * 32 * step_seconds(plan.features) <= 0.02
    assert plan.steps not in taken  # what the order of the method makes of the last error
    assert "ended at its bound" in plan.unresolved_words()
    # A tenth of a long run is more.
    longer = plan_integration(scene, on_contact_loss="continue", samples=100_000)
    assert not longer.bounded and longer.unresolved == 0 and 0.5 < plan.steps / longer.steps < 2.0


def test_where_motions_become_chaotic_the_pilot_says_when_and_what_to_do():
    """An excavator's bucket on its worn pin: all steps, however short, give other motions long before its two seconds."""
    body = Body.from_centroidal(800.0, (0.5, 0.0, 0.03), (120.0, 120.0, 100.0))
    scene = Scene(
        Joint(0.0309, 0.02997, 0.04), body, Loads((0, -9.81, 0)), Motion(-1.571, -1.571, 0, 0, -1.047, 0.0), 2.0
    )
    began = time.process_time()
    plan = plan_integration(scene, {"bearing_radius": (0.0305, 0.0315)}, samples=1000)
    assert time.process_time() - began < 30.0  # two seconds, and compilation
    assert plan.unresolved == 3 and not plan.bounded
    assert 0.1 < plan.agrees_until < 1.0
    words = plan.unresolved_words()
    assert f"chaotic after t = {plan.agrees_until:.2g} s" in words and f"fixed at {plan.steps:,}" in words
    assert "judged one by one" in words and "Shorten [motion] duration" in words
    until = replace(scene, duration=0.8 * plan.agrees_until)
    assert plan_integration(until, {"bearing_radius": (0.0305, 0.0315)}).unresolved == 0
