"""Loads and drives that swing: closed forms, what they must agree with, and what must hold for any of them."""

import math
from dataclasses import replace

import numba as nb
import numpy as np
import pytest
from one_sided_rows import row_of, some_of
from scenes import PAPER_JOINT, SYMMETRIC, UNBALANCED, dimensions
from small_study import write
from twins.newton_euler import SlidingBody

import tolmc

DISC = tolmc.Body(1.0, (0, 0, 0), (2e-3, 2e-3, 1e-3))
WEIGHT = (0, -9.81, 0)
BOTTOM = -math.pi / 2
FLAT = tolmc.Motion(BOTTOM, BOTTOM)
START = tolmc.Motion(-1.9, -1.2, 2.0, -3.0, spin=0.4, spin_rate=30.0)
ROUGH = replace(PAPER_JOINT, friction=0.1, slip_speed=0.1)
ENDS = ("origin_x_end", "origin_y_end", "axis_x_end", "axis_y_end", "spin_end")
#: A little of everything that may swing.
SHAKEN = tolmc.Loads(
    WEIGHT, (1, 0, 0.5), (0.001, 0.002, 0.01), (1e-3, 0, 2e-3),
    force_terms=[tolmc.Harmonic((1, 0.5, 0.3), 12, 0.4), tolmc.Harmonic((0.5, -1, 0.2), 7, 1.0, "body")],
    torque_terms=[tolmc.Harmonic((0.01, 0.02, -0.01), 9, 0.2), tolmc.Harmonic((0.01, 0.005, 0.01), 15, 2.0, "body")],
)  # fmt: skip


# Closed forms


@pytest.mark.parametrize("mode", ["both ends together", "end against end"])
def test_a_journal_at_the_bottom_swings_as_the_linear_one_does(mode):
    """From rest, x = p/(w0^2 - w^2) (sin w t - w/w0 sin w0 t), but for what falls with the amplitude squared."""
    r, length, duration, frequency = PAPER_JOINT.effective_radius, PAPER_JOINT.half_length, 0.4, 3.0
    w, together = 2 * math.pi * frequency, mode == "both ends together"
    inertia = DISC.mass * r * r if together else DISC.inertia[0, 0] * (r / length) ** 2
    w0 = math.sqrt(DISC.mass * 9.81 * r / inertia)
    lever = r if together else r / length

    def miss(amplitude):
        load = amplitude * inertia / lever
        given = {"force_terms": tolmc.Harmonic((load, 0, 0), frequency)} if together else {
            "torque_terms": tolmc.Harmonic((0, load, 0), frequency)}  # fmt: skip
        scene = tolmc.Scene(PAPER_JOINT, DISC, tolmc.Loads(WEIGHT, **given), FLAT, duration)
        row = row_of(scene, step=duration / 200)
        assert row.status == "ok"
        angle = amplitude / (w0**2 - w**2) * (math.sin(w * duration) - w / w0 * math.sin(w0 * duration))
        moved = row.origin_x_end if together else length * row.axis_x_end / row.axis_z_end
        return abs(moved / (r * angle) - 1)

    misses = [miss(amplitude) for amplitude in (20.0, 10.0, 5.0)]
    assert misses[0] < 0.05
    assert np.divide(misses[:2], misses[1:]) == pytest.approx(4.0, rel=0.05)


def test_a_drive_that_swings_gives_the_body_its_turn():
    """Without friction its torque is C Omega' and its power C Omega Omega'."""
    swing, mean, duration, inertia = tolmc.Oscillation(0.6, 4.0, 0.5), 5.0, 0.3, DISC.inertia[2, 2]
    w = 2 * math.pi * swing.frequency
    scene = tolmc.Scene(
        PAPER_JOINT, DISC, tolmc.Loads(WEIGHT, drive=swing), replace(FLAT, spin_rate=mean), duration
    )  # fmt: skip
    row, motion = row_of(scene, step=duration / 100), tolmc.simulate(scene, step=duration / 100)
    start, end = (mean + w * swing.amplitude * math.cos(w * t + swing.phase) for t in (0.0, duration))
    assert row.status == "ok"
    assert motion.spin_rate[[0, -1]] == pytest.approx([start, end], rel=1e-9)
    assert row.drive_torque_max == pytest.approx(inertia * swing.amplitude * w * w, rel=1e-8)
    assert row.drive_torque_mean == pytest.approx(inertia * (end - start) / duration, rel=1e-9)
    assert row.drive_power_mean == pytest.approx(0.5 * inertia * (end**2 - start**2) / duration, rel=1e-9)


# What must be the same


def test_a_swing_of_no_size_holds_the_speed():
    loads = tolmc.Loads(WEIGHT, drive="constant speed")
    for body in (SYMMETRIC.body, UNBALANCED):
        scene = tolmc.Scene(ROUGH, body, loads, START, 0.1)
        held = row_of(scene, step=1e-3)
        still = row_of(replace(scene, loads=replace(loads, drive=tolmc.Oscillation(0.0, 7.0))), step=1e-3)
        numbers = [name for name in held.index if isinstance(held[name], float) and "error" not in name]
        # Of the symmetric body two kernels seek the extrema, each in its own way.
        extrema = [name for name in numbers if name.endswith(("_max", "_min"))]
        for names, allowed in (
            (numbers, 1e-11) if body is UNBALANCED else ([*set(numbers) - set(extrema)], 1e-10),
            (extrema, 1e-6),
        ):
            found, expected = (row[list(names)].astype(float).to_numpy() for row in (still, held))
            assert found == pytest.approx(expected, rel=allowed, abs=1e-13, nan_ok=True)


def test_a_part_of_no_frequency_is_a_constant_load():
    force, torque, point = (1.0, 0.3, 0.5), (1e-3, 2e-3, -2e-3), (0.001, 0.002, 0.01)
    scene = tolmc.Scene(ROUGH, UNBALANCED, tolmc.Loads(WEIGHT, force, point, torque), START, 0.1)
    terms = {
        "force_terms": tolmc.Harmonic(force, 0.0, math.pi / 2),
        "torque_terms": tolmc.Harmonic(torque, 0.0, math.pi / 2),
    }
    constant = row_of(scene, step=1e-3)
    swinging = row_of(replace(scene, loads=tolmc.Loads(WEIGHT, force_point=point, **terms)), step=1e-3)
    for name in (*ENDS, "friction_work", "contact_force_D_max"):
        assert swinging[name] == pytest.approx(constant[name], rel=1e-11)
    assert swinging.energy_error < 1e-12


def test_axes_that_turn_with_the_body_are_fixed_ones_that_swing_at_its_speed():
    """While the journal stays parallel to the bore the body's axes turn at the spin rate alone."""
    spin = 25.0
    turning = tolmc.Harmonic((2.0, 0, 0), 0.0, math.pi / 2, "body")
    fixed = [
        tolmc.Harmonic((2.0, 0, 0), spin / (2 * math.pi), math.pi / 2),
        tolmc.Harmonic((0, 2.0, 0), spin / (2 * math.pi)),
    ]
    rows = [
        row_of(
            tolmc.Scene(ROUGH, DISC, tolmc.Loads(WEIGHT, drive="constant speed", force_terms=terms),
                        tolmc.Motion(-1.9, -1.9, spin_rate=spin), 0.2),
            step=5e-4,  # at which a maximum between two steps' ends is found to the tenth digit
        )
        for terms in (turning, fixed)
    ]  # fmt: skip
    for name in ("origin_x_end", "origin_y_end", "friction_work", "contact_force_D_max", "drive_torque_mean"):
        assert rows[0][name] == pytest.approx(rows[1][name], rel=1e-9)


# What must hold for any motion


@pytest.mark.parametrize(
    ("what", "section"),
    [
        ("symmetric body, drive", "circle"),
        pytest.param("symmetric body, drive", "exact", marks=pytest.mark.slow),
        ("general body, drive and loads", "circle"),
        ("general body, loads", "circle"),
        # The only motions of this kernel, which takes long to compile: test_uncompiled.py has it.
        pytest.param("general body, drive and loads", "exact", marks=pytest.mark.nightly),
        pytest.param("general body, loads", "exact", marks=pytest.mark.nightly),
    ],
)
def test_energy_is_balanced_and_the_order_is_eight(what, section):
    body = SYMMETRIC.body if what.startswith("symmetric") else UNBALANCED
    loads = SHAKEN if "loads" in what else tolmc.Loads(WEIGHT)
    if "drive" in what:
        loads = replace(loads, drive=tolmc.Oscillation(0.5, 3.0, 0.3))
    joint = replace(ROUGH, section=section, restitution=0.5)
    scene = tolmc.Scene(joint, body, loads, START, 0.1)
    names = [*ENDS[: 4 if "drive" in what else 5], "friction_work"]
    outputs = [*names, "impacts_D", "energy_error", "constraint_error"]
    steps = 8, 16, 48 if nb.config.DISABLE_JIT else 320
    rows = [some_of(scene, outputs, step=scene.duration / n) for n in steps]
    assert all(row.status == "ok" and row.impacts_D == 0 for row in rows)
    ends = [np.array([row[name] for name in names]) / np.abs([rows[-1][name] for name in names]) for row in rows]
    coarse, fine = (np.abs(end - ends[-1]).max() for end in ends[:2])
    assert math.log2(coarse / fine) > 7.3
    assert rows[-1].energy_error < 1e-12
    assert rows[-1].constraint_error < 1e-12
    if not nb.config.DISABLE_JIT:
        assert row_of(scene).energy_error < 1e-9


@pytest.mark.parametrize(
    "what", ["friction", "friction and drive", "friction and loads that swing", "loads that swing"]
)
def test_the_general_body_moves_as_newton_and_euler_have_it(what):
    joint = replace(PAPER_JOINT, friction=0.1 if "friction" in what else 0.0, slip_speed=0.02)
    loads = SHAKEN if "loads" in what else tolmc.Loads(WEIGHT)
    if "drive" in what:
        loads = replace(loads, drive="constant speed")
    scene = tolmc.Scene(joint, UNBALANCED, loads, START, 0.08)
    row, expected = row_of(scene, step=scene.duration / 200), SlidingBody(scene).end()
    assert row.status == "ok"
    for name, value in expected.items():
        if name in row:
            assert row[name] == pytest.approx(value, rel=1e-8, abs=1e-12), name


def test_impacts_keep_the_balance_of_energy():
    joint = replace(ROUGH, restitution=0.5)
    loads = replace(SHAKEN, force_terms=[tolmc.Harmonic((0, 12.0, 0), 20)], drive=tolmc.Oscillation(0.5, 3.0))
    row = row_of(tolmc.Scene(joint, UNBALANCED, loads, START, 0.2), step=2.5e-4)
    assert row.status == "ok"
    assert row.impacts_D > 0
    assert row.energy_error < 1e-11


def test_what_swings_may_carry_a_tolerance():
    loads = tolmc.Loads(WEIGHT, force_terms=tolmc.Harmonic((1.0, 0, 0), 5.0), drive=tolmc.Oscillation(0.5, 3.0))
    scene = tolmc.Scene(ROUGH, DISC, loads, FLAT, 0.1)
    for name in loads.scalars:
        values = scene.scalars[name] + np.linspace(0.0, 0.1, 5)
        samples = tolmc.simulate_many(scene, **dimensions(scene), parameters={name: values}, step=1e-3)
        assert (samples.status == "ok").all()
        assert samples.friction_work.nunique() == (1 if name == "force_term_1_z" else 5), name
    below = tolmc.simulate_many(scene, **dimensions(scene), parameters={"drive_frequency": [-1.0]}, step=1e-3)
    assert below.status[0] == "body invalid"


@pytest.mark.slow
def test_a_run_with_what_swings_goes_on_with_the_same_bits(tmp_path):
    swing = (
        '[loads]\ndrive = { amplitude = "30 deg", frequency = 5 }\n'
        'force_terms = [ { amplitude = [0, 1, 0], frequency = 9, axes = "body" } ]\n'
    )
    few = ("samples = 3000", "samples = 48\nmodel_error = false")
    study = tolmc.load_study(write(tmp_path, ("[loads]", swing), few, ('"0.1 s"', '"0.02 s"')))
    whole = tolmc.run(study, samples=64)
    tolmc.run(study, out=tmp_path / "run")
    longer = tolmc.resume(tmp_path / "run", extend=16)
    numbers = whole.samples.select_dtypes(float)
    np.testing.assert_array_equal(longer.samples[list(numbers)].to_numpy(), numbers.to_numpy())
    assert (whole.samples.status == "ok").all()


@pytest.mark.parametrize("options", [{"formulation": "published"}, {"on_contact_loss": "continue"}, {"halving": True}])
def test_what_loads_that_swing_have_no_use_for_is_refused(options):
    scene = replace(SYMMETRIC, loads=replace(SYMMETRIC.loads, force_terms=tolmc.Harmonic((1, 0, 0), 5.0)))
    with pytest.raises(ValueError, match="loads that swing"):
        tolmc.simulate_many(scene, **dimensions(scene), **options)


# Bad input


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: tolmc.Harmonic((1, 0), 5.0), "Harmonic: amplitude"),
        (lambda: tolmc.Harmonic((1, 0, 0), -5.0), "frequency = -5.0 Hz is out of range; allowed: >= 0"),
        (lambda: tolmc.Harmonic((1, 0, 0), 5.0, axes="shaft"), "axes = 'shaft' is unknown; allowed: fixed, body"),
        (lambda: tolmc.Oscillation(0.5, math.inf), "Oscillation: frequency = inf"),
        (lambda: tolmc.Oscillation(0.5, -1.0), "frequency = -1.0 Hz is out of range"),
        (
            lambda: tolmc.Loads(force_terms=[tolmc.Harmonic((1, 0, 0), 5.0)] * 3),
            "force_terms has 3 terms; allowed: at most 2",
        ),
        (
            lambda: tolmc.Loads(drive="swing"),
            "drive = 'swing' is unknown; allowed: free, constant speed, or an Oscillation",
        ),
    ],
)
def test_what_cannot_swing_is_named(make, words):
    with pytest.raises(ValueError, match=words):
        make()


def test_a_part_that_swings_must_be_one():
    with pytest.raises(TypeError, match=r"force_terms = .* must be tolmc.Harmonic"):
        tolmc.Loads(force_terms=[(1, 0, 0)])
