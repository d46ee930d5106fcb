"""Friction and the drive: reference motions, closed forms, and what must hold for any motion that slides."""

import math
from dataclasses import replace

import numba as nb
import numpy as np
import pytest
from one_sided_rows import CASES, bore, row_of, scene_of, some_of
from scenes import NEXT_TO_NO_LOAD, PAPER_JOINT, SYMMETRIC, UNBALANCED, dimensions

import tolmc

ROUGH = {name: case for name, case in CASES.items() if case["friction"]}
MU, SLIP = 0.15, 0.02
DISC = tolmc.Body(1.0, (0, 0, 0), (2e-3, 2e-3, 1e-3))
HELD = tolmc.Loads((0, -9.81, 0), drive="constant speed")


@pytest.mark.parametrize(("name", "fine"), [(name, fine) for name in ROUGH for fine in (False, True)])
def test_a_reference_motion_is_met(name, fine):
    case = ROUGH[name]
    scene, expected = scene_of(case), case["expected"]
    row = row_of(scene, step=scene.duration / 800 if fine else None)
    assert row.status == "ok"
    allowed = max(1e-8 if fine else 1e-6, 10 * case["agreement"])
    radius = scene.joint.effective_radius
    assert row.origin_x_end / radius == pytest.approx(expected["origin"][0] / radius, abs=allowed)
    assert row.origin_y_end / radius == pytest.approx(expected["origin"][1] / radius, abs=allowed)
    assert [row[f"axis_{axis}_end"] for axis in "xyz"] == pytest.approx(expected["axis"], abs=allowed)
    assert row.spin_end == pytest.approx(expected["spin_rate"], rel=allowed)
    for output in ("friction_work", "slip_work_D", "slip_work_E", "contact_force_D_mean", "contact_force_E_mean"):
        assert row[output] == pytest.approx(expected[output], rel=1e-5)
    # What impacts lose depends on the height at which bounces are left out.
    assert row.impact_energy_loss == pytest.approx(expected["impact_energy_loss"], rel=1e-5)
    assert row.energy_error <= (1e-12 if fine else 1e-9)


# Closed forms, each missed by the size of the regularisation, (slip speed / slip)^2


def journal(
    duration, slip_speed, *, loads=None, section="circle", spin=0.0, rate=0.0, place=-math.pi / 2, tilted=False
):
    """A journal at a place of the wall, parallel to the bore or, ``tilted``, across it, that turns and whirls there."""
    joint = replace(PAPER_JOINT, section=section, friction=MU, slip_speed=slip_speed)
    other = place + math.pi if tilted else place
    motion = tolmc.Motion(place, other, rate, rate, spin_rate=spin)
    return tolmc.Scene(joint, DISC, loads or NEXT_TO_NO_LOAD, motion, duration)


def clearance(section):
    return PAPER_JOINT.effective_radius if section == "circle" else PAPER_JOINT.approximate_radius


def vanishes(miss):
    """Errors that fall with the square of the slip speed, from a size that the regularisation explains."""
    errors = np.array([np.abs(miss(SLIP / 2**k)).max() for k in range(3)])
    assert errors[0] < 1e-2
    assert errors[:2] / errors[1:] == pytest.approx(4.0, rel=0.1)


@pytest.mark.parametrize("section", ["circle", "exact"])
def test_steady_slip_has_its_attitude_torque_and_force(section):
    """-phi from the load's direction, tan phi = mu, N_D + N_E = W cos phi, torque W r* mu/sqrt(1 + mu^2)."""
    c, weight, spin, duration = clearance(section), 9.81, 60.0, 0.01
    attitude = -math.pi / 2 - math.atan(MU)
    torque = weight * PAPER_JOINT.journal_radius * MU / math.sqrt(1 + MU**2)

    def miss(slip_speed):
        scene = journal(duration, slip_speed, loads=HELD, section=section, spin=spin, place=attitude)
        row = row_of(scene, step=duration / 40)
        assert row.status == "ok"
        assert row.drive_torque_mean == pytest.approx(row.friction_torque_mean, rel=1e-12)
        assert row.drive_power_mean == pytest.approx(spin * row.drive_torque_mean, rel=1e-12)
        force = row.contact_force_D_mean + row.contact_force_E_mean
        return np.array([
            math.atan2(row.origin_y_end, row.origin_x_end) + 2 * math.pi * (row.origin_y_end > 0) - attitude,
            row.friction_torque_mean / torque - 1, force / (weight * math.cos(math.atan(MU))) - 1,
            math.hypot(row.origin_x_end, row.origin_y_end) / c - 1,
        ])  # fmt: skip

    vanishes(miss)


@pytest.mark.parametrize("section", ["circle", "exact"])
@pytest.mark.parametrize("way", [-1.0, 1.0], ids=["backward", "forward"])
def test_whirl_without_load_follows_the_slip_law(section, way):
    """w = w0/(1 -+ mu w0 t), and C Omega - m c r* alpha' is constant."""
    w0, spin, duration, radius = 20.0, 200.0, 0.05, PAPER_JOINT.journal_radius
    c, law = clearance(section), 1.0 + way * MU * w0 * duration
    turn, last = way * math.log(law) / (way * MU), w0 / law

    def miss(slip_speed):
        scene = journal(duration, slip_speed, section=section, spin=spin, rate=way * w0)
        row = row_of(scene, step=duration / 100)
        assert row.status == "ok"
        spun = spin + DISC.mass * c * radius * way * (last - w0) / DISC.inertia[2, 2]
        return np.array([row.whirl_rate_mean * duration / turn - 1, row.spin_end / spun - 1])

    vanishes(miss)


@pytest.mark.parametrize("section", ["circle", pytest.param("exact", marks=pytest.mark.slow)])
def test_backward_whirl_ends_rolling(section):
    """At w_r = r*(C Omega0 + m c r* w0)/(c (C + m r*^2)), whatever the slip speed."""
    w0, spin, radius, c = 40.0, 80.0, PAPER_JOINT.journal_radius, clearance(section)
    inertia = DISC.inertia[2, 2]
    rolls = radius * (inertia * spin + DISC.mass * c * radius * w0) / (c * (inertia + DISC.mass * radius**2))
    row = row_of(journal(0.4, 1e-3, section=section, spin=spin, rate=-w0), step=2e-4)
    assert row.status == "ok"
    assert row.spin_end == pytest.approx(c / radius * rolls, rel=1e-6)
    assert 0.0 < row.slow_share < 1.0
    before = inertia * spin**2 + DISC.mass * (c * w0) ** 2
    lost = 0.5 * (before - (inertia * (c / radius) ** 2 + DISC.mass * c * c) * rolls**2)
    assert row.friction_work == pytest.approx(lost, rel=1e-6)


@pytest.mark.parametrize(
    ("section", "tilted", "ratio"),
    [
        ("circle", False, PAPER_JOINT.journal_radius / PAPER_JOINT.effective_radius),
        ("exact", False, PAPER_JOINT.journal_radius / PAPER_JOINT.approximate_radius),
        ("circle", True, PAPER_JOINT.journal_radius / PAPER_JOINT.effective_radius),
        ("exact", True, 0.9186429820),
    ],
)
def test_rolling_without_slip_stays(section, tilted, ratio):
    spin, duration = 30.0, 0.05
    scene = journal(duration, 1e-3, section=section, spin=spin, rate=-ratio * spin, tilted=tilted)
    row = row_of(scene, step=duration / 200)
    assert row.status == "ok"
    assert row.whirl_rate_mean == pytest.approx(-ratio * spin, rel=1e-9)
    assert row.spin_end == pytest.approx(spin, rel=1e-9)
    assert row.slow_share == 1.0
    assert row.friction_work <= 1e-12


# What must hold for any motion


@pytest.mark.parametrize(
    ("section", "body"),
    [
        pytest.param("circle", SYMMETRIC.body, id="circle-symmetric"),
        pytest.param("circle", UNBALANCED, id="circle-general"),
        pytest.param("exact", SYMMETRIC.body, id="exact-symmetric"),
        # The longest to compile of all kernels, and of no other test: test_uncompiled.py has it.
        pytest.param("exact", UNBALANCED, id="exact-general", marks=pytest.mark.nightly),
    ],
)
@pytest.mark.parametrize("drive", ["free", "constant speed"])
def test_energy_is_balanced_and_the_order_is_eight(section, body, drive):
    motion = tolmc.Motion(-1.9, -1.2, 2.0, -3.0, spin_rate=30.0)
    joint = replace(PAPER_JOINT, section=section, friction=0.1, slip_speed=0.1, restitution=0.5)
    scene = tolmc.Scene(joint, body, tolmc.Loads((0, -9.81, 0), drive=drive), motion, 0.1)
    names = ["origin_x_end", "origin_y_end", "axis_x_end", "axis_y_end", "friction_work", "spin_end"]
    outputs = [*names, "impacts_D", "energy_error", "constraint_error"]
    steps = 6, 12, 32 if nb.config.DISABLE_JIT else 320
    rows = [some_of(scene, outputs, step=scene.duration / n) for n in steps]
    assert all(row.status == "ok" and row.impacts_D == 0 for row in rows)
    ends = [np.array([row[name] for name in names]) / np.abs([rows[-1][name] for name in names]) for row in rows]
    coarse, fine = (np.abs(end - ends[-1]).max() for end in ends[:2])
    assert math.log2(coarse / fine) > 7.3
    assert rows[-1].energy_error < 1e-12
    assert rows[-1].constraint_error < 1e-12
    if drive != "free":
        assert rows[-1].spin_end == 30.0


def test_a_held_spin_is_that_of_a_body_with_a_large_inertia():
    """A journal that stays parallel to the bore has no gyroscopic moment that would tell the two apart."""
    joint = replace(PAPER_JOINT, friction=0.2, slip_speed=0.01)
    heavy = tolmc.Body(1.0, (0, 0, 0), (2e3, 2e3, 1e3))
    flat = tolmc.Motion(-1.9, -1.9, spin_rate=40.0)
    held = row_of(tolmc.Scene(joint, DISC, HELD, flat, 0.05), step=1e-4)
    free = row_of(tolmc.Scene(joint, heavy, tolmc.Loads((0, -9.81, 0)), flat, 0.05), step=1e-4)
    for name in ("origin_x_end", "origin_y_end", "friction_work", "friction_torque_max", "whirl_rate_mean"):
        assert held[name] == pytest.approx(free[name], rel=1e-5)


def test_friction_that_is_absent_changes_no_bit():
    columns = dimensions(SYMMETRIC) | {"bearing_radius": bore(SYMMETRIC, 64)}
    without = tolmc.simulate_many(SYMMETRIC, **columns, step=1e-3)
    named = replace(SYMMETRIC, joint=replace(SYMMETRIC.joint, friction=0.0, slip_speed="5 mm/s"))
    absent = tolmc.simulate_many(named, **columns, step=1e-3)
    assert list(absent) == list(without)
    numbers = [name for name in without if without[name].dtype == float]
    np.testing.assert_array_equal(absent[numbers].to_numpy(), without[numbers].to_numpy())


@pytest.mark.parametrize("drive", ["free", "constant speed"])
def test_impacts_keep_the_balance_of_energy(drive):
    scene = scene_of(CASES["falls_from_the_side"] | {"friction": 0.1, "slip_speed": 1e-2})
    row = row_of(replace(scene, loads=replace(scene.loads, drive=drive)), step=scene.duration / 800)
    assert row.status == "ok"
    assert row.impacts_D > 0
    assert row.energy_error < 1e-11
    if drive != "free":
        assert row.spin_end == scene.motion.spin_rate


@pytest.mark.parametrize("place", [math.pi, -0.3], ids=["at the start", "later"])
def test_without_restitution_a_sample_ends_where_it_loses_contact(place):
    joint = replace(PAPER_JOINT, friction=0.1)
    scene = tolmc.Scene(joint, DISC, tolmc.Loads((0, -9.81, 0)), tolmc.Motion(place, place, 50.0, 50.0), 0.2)
    if place == math.pi:
        scene = replace(scene, motion=tolmc.Motion(0.5 * math.pi, 0.5 * math.pi))
    followed = row_of(replace(scene, joint=replace(scene.joint, restitution=0.5)), step=1e-4)
    row = row_of(scene, step=1e-4)
    assert row.status == "contact lost"
    assert row.contact_loss_time == row.status_time == followed.contact_loss_time
    assert (row.status_time == 0.0) == (place == math.pi)
    assert "impacts_D" not in row
    motion = tolmc.simulate(scene, step=1e-4)
    assert motion.time[-1] == pytest.approx(row.status_time, rel=1e-12)  # by the one-sided kernel


def test_simulate_shows_the_spin_that_friction_changes():
    scene = scene_of(ROUGH["friction_keeps_contact"])
    motion = tolmc.simulate(scene)
    assert motion.status == "ok"
    assert motion.spin_rate[0] == 80.0
    assert motion.spin_rate[-1] == pytest.approx(62.87704546364217, rel=1e-7)
    assert motion.energy[0] - motion.energy[-1] == pytest.approx(0.13760286618662035, rel=1e-6)


def test_friction_may_carry_a_tolerance():
    scene = scene_of(ROUGH["friction_keeps_contact"])
    columns = {name: np.full(40, value) for name, value in dimensions(scene).items()}
    friction = np.linspace(0.0, 0.2, 40)
    samples = tolmc.simulate_many(scene, **columns, parameters={"friction": friction}, step=1e-3)
    assert (np.diff(samples.friction_work) > 0).all()
    assert samples.friction_work[0] == 0.0
    broken = tolmc.simulate_many(scene, **columns, parameters={"slip_speed": np.linspace(0, 1e-2, 40)}, step=1e-3)
    assert broken.status[0] == "body invalid"


# Bad input


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"friction": -0.1}, "friction = -0.1 is out of range; allowed: 0"),
        ({"friction": math.nan}, "friction = nan"),
        ({"friction": 0.1, "slip_speed": 0.0}, "slip_speed = 0.0 is out of range; allowed: a finite number > 0"),
        ({"friction": 0.1, "slip_speed": "1 mm"}, "slip_speed"),
        ({"friction": 0.1, "slip_speed": "-1 mm/s"}, "slip_speed = -0.001"),
    ],
)
def test_a_law_of_friction_out_of_range_is_refused(given, words):
    with pytest.raises(ValueError, match=f"Joint: {words}"):
        replace(PAPER_JOINT, **given)


def test_a_slip_speed_carries_its_unit():
    assert replace(PAPER_JOINT, friction=0.1).slip_speed == 1e-3
    assert replace(PAPER_JOINT, friction=0.1, slip_speed="2 mm/s").slip_speed == 2e-3


def test_what_friction_has_no_use_for_is_refused():
    rough = replace(SYMMETRIC, joint=replace(SYMMETRIC.joint, friction=0.1))
    for options in ({"formulation": "published"}, {"on_contact_loss": "continue"}, {"halving": True}):
        with pytest.raises(ValueError, match="friction"):
            tolmc.simulate_many(rough, **dimensions(rough), **options)
    with pytest.raises(ValueError, match="drive = 'fast' is unknown"):
        tolmc.Loads(drive="fast")
    point = tolmc.Body(1.0, (0, 0, 0), (1.0, 1.0, 0.0))
    with pytest.raises(ValueError, match="no spin dynamics under friction"):
        tolmc.simulate_many(replace(rough, body=point), **dimensions(rough))


# Where no forces solve the contact


@pytest.mark.parametrize("restitution", [None, 0.5])
@pytest.mark.parametrize("place", [(-0.03, 0.002), (-0.01, 0.0)])
def test_a_contact_without_forces_has_a_status_from_its_closed_form_on(place, restitution):
    """A journal that lies parallel at the bottom and turns with Omega > 0: O's acceleration per unit normal force is

        1/m + (x_C^2 + mu x_C (r* + y_C))/I_C

    with the moment of inertia I_C about the centre of mass; where it is not positive no force keeps the wall (Painleve).
    """
    x, y = place
    body = tolmc.Body.from_centroidal(2.0, (x, y, 0.0), (1e-4, 1e-4, 1e-4))
    critical = (1e-4 / body.mass + x * x) / (-x * (PAPER_JOINT.journal_radius + y))
    statuses = []
    for mu in (0.99 * critical, 1.01 * critical):
        joint = replace(PAPER_JOINT, friction=mu, slip_speed=1e-6, restitution=restitution)
        start = tolmc.Motion(-math.pi / 2, -math.pi / 2, spin_rate=1.0)
        row = row_of(tolmc.Scene(joint, body, tolmc.Loads((0, -9.81, 0)), start, 1e-7), step=1e-8)
        statuses.append(row.status)
    assert statuses == ["ok", "no contact forces"]


@pytest.mark.parametrize("section", ["circle", "exact"])
def test_extrema_fall_with_the_step(section):
    """Of forces, moment and tilt, wherever in a step they lie; the kernels of the two sections seek them in their own ways."""
    joint = replace(PAPER_JOINT, friction=0.05, section=section)
    scene = tolmc.Scene(joint, DISC, tolmc.Loads((0, -9.81, 0)), tolmc.Motion(-2.2, -1.4, spin_rate=30.0), 0.5)
    columns = {"journal_radius": joint.journal_radius * np.linspace(0.99, 1.01, 64)}
    sizes = {"bearing_radius": np.full(64, joint.bearing_radius), "half_length": np.full(64, joint.half_length)}
    coarse, fine = (tolmc.simulate_many(scene, **sizes, **columns, step=scene.duration / n) for n in (100, 1600))
    assert coarse.status.eq("ok").all()
    extrema = [name for name in coarse if name.endswith(("_max", "_min")) and not name.startswith("drive")]
    assert len(extrema) == 6
    for name in extrema:
        found, expected = coarse[name].to_numpy(), fine[name].to_numpy()
        assert found == pytest.approx(expected, abs=1e-6 * np.abs(expected).max()), name


@pytest.mark.parametrize("name", ["friction_and_impacts", "falls_from_the_side"])
def test_the_time_below_the_slip_speed_is_seen_within_steps(name):
    """The pilot's steps are long for it: the slip passes through the slip speed and back within one."""
    scene = scene_of(CASES[name] | {"friction": 0.3, "slip_speed": 1e-2})
    scene = replace(scene, duration=0.15, motion=replace(scene.motion, spin_rate=3.0))
    found, finer = (some_of(scene, ("slow_share",), step=step).slow_share for step in (None, scene.duration / 2000))
    assert finer > 0.05
    assert found == pytest.approx(finer, abs=3e-4)


def test_a_sample_with_friction_does_not_depend_on_its_neighbours():
    """The last lanes of a block fly on with nobody on the wall beside them: nothing that they have seen there is left."""
    rng, n = np.random.default_rng(3), 64
    motion = tolmc.Motion.free((0.001, 0.002), (0.1, -0.05), (0.3, 0.4), (3.0, 5.0), spin_rate=60.0)
    joint = replace(PAPER_JOINT, restitution=0.5, friction=0.1, slip_speed=1e-2)
    scene = tolmc.Scene(joint, SYMMETRIC.body, tolmc.Loads((0, -9.81, 0)), motion, 0.08)
    bores, columns = (
        rng.uniform(0.0199, 0.0201, n),
        {"restitution": rng.uniform(0, 1, n), "spin_rate": rng.normal(0, 100, n)},
    )

    def rows(chosen):
        sizes = dimensions(scene) | {"bearing_radius": bores[chosen]}
        varied = {name: column[chosen] for name, column in columns.items()}
        return tolmc.simulate_many(scene, **sizes, parameters=varied, step=2e-4)

    whole = rows(np.arange(n))
    assert whole.status.eq("ok").all()
    numbers = [name for name in whole if whole[name].dtype == float]
    for chosen in (np.arange(n)[::-1], np.arange(32, 64), np.array([63])):
        np.testing.assert_array_equal(rows(chosen)[numbers].to_numpy(), whole[numbers].to_numpy()[chosen])
