"""Scenes: what is accepted, what is refused and in which words, and the values that reach the kernels."""

from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scenes import CYLINDER, LOADED, PAPER_JOINT, START, SYMMETRIC, UNBALANCED

import tolmc
from tolmc import Body, Harmonic, Joint, Loads, Motion, Oscillation, Scene, quantities
from tolmc.quantities import SCALARS

GRAVITY = (0.0, -9.81, 0.0)


def refuses(error, words, make):
    """``make()`` raises ``error`` with every one of ``words`` in its message."""
    with pytest.raises(error) as caught:
        make()
    for word in words:
        assert word in str(caught.value), f"{word!r} is not in {str(caught.value)!r}"


# Joint


def test_joint_gives_the_geometry_of_the_paper():
    joint = Joint(2.0, 1.0, 2.0)
    assert joint.tilt_angle == tolmc.tilt_angle(2.0, 1.0, 2.0)
    assert joint.effective_radius == tolmc.effective_radius(2.0, 1.0, 2.0)
    assert joint.approximate_radius == 1.0
    assert joint.section == "circle"


@pytest.mark.parametrize("name", ["bearing_radius", "journal_radius", "half_length"])
@pytest.mark.parametrize("value", [0.0, -1e-3, float("nan"), float("inf")])
def test_joint_dimensions_are_positive_and_finite(name, value):
    dimensions = {"bearing_radius": 0.02, "journal_radius": 0.01, "half_length": 0.02, name: value}
    refuses(ValueError, ["Joint", name, repr(value), "finite number > 0"], lambda: Joint(**dimensions))


def test_joint_needs_a_clearance():
    refuses(
        ValueError, ["Joint", "journal_radius = 0.02", "bearing_radius = 0.02", "clearance"], lambda: Joint(0.02, 0.02, 1)
    )  # fmt: skip


def test_joint_refuses_an_unknown_section_and_words_for_numbers():
    refuses(ValueError, ["section", "'oval'", "circle", "exact"], lambda: Joint(2, 1, 2, "oval"))
    refuses(TypeError, ["Joint", "journal_radius", "'1 mm'", "SI"], lambda: Joint(2, "1 mm", 2))


# Body


def test_body_takes_three_moments_or_a_matrix():
    assert Body(1, inertia=(3, 2, 4)) == Body(1, inertia=np.diag([3.0, 2, 4]))
    assert hash(Body(1, inertia=(3, 2, 4))) == hash(Body(1, inertia=np.diag([3.0, 2, 4])))
    assert Body(1, inertia=(3, 2, 4)) != Body(1, inertia=(3, 2, 3))


def test_body_keeps_its_own_inertia():
    matrix = np.diag([3.0, 2.0, 4.0])
    body = Body(1, inertia=matrix)
    matrix[0, 0] = 99
    assert body.inertia[0, 0] == 3
    with pytest.raises(ValueError, match="read-only"):
        body.inertia[0, 0] = 5


@pytest.mark.parametrize("mass", [0, -1, float("nan")])
def test_body_mass_is_positive(mass):
    refuses(ValueError, ["Body", "mass", repr(mass), "> 0"], lambda: Body(mass, inertia=(1, 1, 1)))


def test_body_refuses_what_is_no_matrix_of_inertia():
    refuses(ValueError, ["inertia", "symmetric"], lambda: Body(1, inertia=[[2, 0.1, 0], [0, 2, 0], [0, 0, 2]]))
    refuses(ValueError, ["inertia", "(2, 2)"], lambda: Body(1, inertia=np.eye(2)))
    refuses(ValueError, ["inertia", "finite"], lambda: Body(1, inertia=(1, np.nan, 1)))
    refuses(TypeError, ["inertia", "kg m^2", "'heavy'"], lambda: Body(1, inertia="heavy"))
    refuses(ValueError, ["center_of_mass", "(x, y, z)", "(0, 0)"], lambda: Body(1, (0, 0), (1, 1, 1)))


@pytest.mark.parametrize("inertia", [(-1, 2, 2), (1, 1, 3), (0, 0, 0), [[1, 2, 0], [2, 1, 0], [0, 0, 1]]])
def test_body_refuses_moments_that_no_body_has(inertia):
    refuses(ValueError, ["centre of mass", "sum of the other two", "from_centroidal"], lambda: Body(1, inertia=inertia))


def test_inertia_is_about_the_point_in_the_middle_plane():
    """Moments that would do about the centre of mass are too small about O."""
    refuses(ValueError, ["from_centroidal"], lambda: Body(1, (0, 0, 1), (0.1, 0.1, 0.1)))
    assert Body.from_centroidal(1, (0, 0, 1), (0.1, 0.1, 0.1)).inertia[0, 0] == pytest.approx(1.1)


def test_a_point_mass_and_a_thin_rod_are_bodies():
    assert np.trace(Body.from_centroidal(2, (0.3, 0.1, 0.2), (0, 0, 0)).inertia) == pytest.approx(2 * 2 * 0.14)
    assert Body(1, (0, 0, 0.1), (0.02, 0.02, 0)).inertia[2, 2] == 0


@given(st.lists(st.floats(-2, 2), min_size=3, max_size=3), st.integers(0, 2**31))
def test_from_centroidal_agrees_with_a_cloud_of_points(center, seed):
    points = np.random.default_rng(seed).normal(size=(20, 3))
    points += np.array(center) - points.mean(axis=0)

    def inertia(about):
        d = points - about
        return 0.1 * ((d**2).sum() * np.eye(3) - d.T @ d)

    body = Body.from_centroidal(2.0, center, inertia(np.array(center)))
    np.testing.assert_allclose(body.inertia, inertia(np.zeros(3)), atol=1e-12)
    np.testing.assert_allclose(body.centroidal_inertia, inertia(np.array(center)), atol=1e-12)


def test_solid_cylinder():
    """m (3 a^2 + h^2)/12 across, m a^2/2 along."""
    body = Body.solid_cylinder(2.0, 0.3, 0.8)
    np.testing.assert_allclose(body.inertia, np.diag([2 * (3 * 0.09 + 0.64) / 12] * 2 + [2 * 0.09 / 2]), rtol=1e-15)
    moved = Body.solid_cylinder(2.0, 0.3, 0.8, (0, 0, 0.5))
    np.testing.assert_allclose(moved.inertia - body.inertia, np.diag([0.5, 0.5, 0]), atol=1e-15)
    refuses(ValueError, ["radius", "-0.3", "> 0"], lambda: Body.solid_cylinder(2.0, -0.3, 0.8))
    refuses(ValueError, ["length", "0", "> 0"], lambda: Body.solid_cylinder(2.0, 0.3, 0))


@pytest.mark.parametrize(
    ("body", "symmetric"),
    [
        (CYLINDER, True),
        (Body.solid_cylinder(1, 0.1, 0.2, (0, 0, -0.3)), True),
        (Body(1, (0, 0, 0), (2, 2, 1)), True),
        (Body(1, (0, 0, 0), (2, 2.0000001, 1)), False),
        (Body(1, (1e-12, 0, 0), (2, 2, 1)), False),
        (Body(1, (0, -1e-12, 0), (2, 2, 1)), False),
        (Body(1, (0, 0, 0), [[2, 1e-9, 0], [1e-9, 2, 0], [0, 0, 1]]), False),
        (Body(1, (0, 0, 0), [[2, 0, 1e-9], [0, 2, 0], [1e-9, 0, 1]]), False),
        (UNBALANCED, False),
    ],
)
def test_symmetry_about_the_journal_axis_is_recognised(body, symmetric):
    assert body.is_symmetric is symmetric


# Loads, Motion, Scene


def test_loads_refuse_a_point_without_force_and_bad_vectors():
    refuses(ValueError, ["force_point", "without force"], lambda: Loads(force_point=(0, 0, 1)))
    refuses(ValueError, ["gravity[y]", "nan", "finite"], lambda: Loads((0, np.nan, 0)))
    refuses(ValueError, ["torque", "three numbers", "3"], lambda: Loads(torque=3))
    refuses(TypeError, ["force[z]", "'1 N'"], lambda: Loads(force=(0, 0, "1 N")))


def test_absent_loads_stay_absent():
    loads = Loads(GRAVITY)
    assert (loads.force, loads.force_point, loads.torque) == (None, None, None)
    assert Loads(np.array(GRAVITY)) == loads


@pytest.mark.parametrize("name", ["alpha", "beta", "alpha_rate", "beta_rate", "spin", "spin_rate"])
def test_motion_is_finite(name):
    refuses(ValueError, ["Motion", name, "inf", "finite"], lambda: Motion(**{"alpha": 0, "beta": 0, name: np.inf}))


@pytest.mark.parametrize("duration", [0, -1, float("nan"), float("inf")])
def test_duration_is_positive(duration):
    refuses(ValueError, ["Scene", "duration", repr(duration), "> 0"], lambda: replace(SYMMETRIC, duration=duration))


def test_a_scene_refuses_parts_in_the_wrong_place():
    parts = (PAPER_JOINT, CYLINDER, Loads(), START)
    for index, name in enumerate(("joint", "body", "loads", "motion")):
        wrong = list(parts)
        wrong[index] = 3.0
        refuses(TypeError, ["Scene", name, "3.0"], lambda wrong=wrong: Scene(*wrong, 1.0))


def test_parts_are_frozen():
    for part in (PAPER_JOINT, CYLINDER, Loads(), START, SYMMETRIC):
        with pytest.raises(FrozenInstanceError):
            part.mass = 1.0


def test_scalars_name_every_number_of_a_scene():
    scalars = LOADED.scalars
    assert tuple(scalars) == SCALARS
    assert scalars["bearing_radius"] == 0.02
    assert [scalars[f"center_of_mass_{axis}"] for axis in "xyz"] == [0.001, -0.0007, 0.004]
    assert [scalars[f"inertia_{name}"] for name in ("xx", "yy", "zz", "xy", "xz", "yz")] == [
        4.1e-4, 3.3e-4, 1.3e-4, 2e-5, -1.2e-5, 3.1e-5,
    ]  # fmt: skip
    assert [scalars[f"force_point_{axis}"] for axis in "xyz"] == [0.01, -0.02, 0.03]
    assert [scalars[name] for name in (*quantities.START, *quantities.SPIN)] == [-1.92, -0.87, 2.0, -3.0, 0.7, 40.0]


def test_absent_loads_are_zero_scalars():
    scalars = SYMMETRIC.scalars
    assert all(scalars[f"{load}_{axis}"] == 0 for load in ("force", "force_point", "torque") for axis in "xyz")


#: Between them two scenes have every scalar: one starts on the wall, one flies and is shaken.
FLYING = replace(
    LOADED,
    loads=replace(
        LOADED.loads,
        force_terms=[Harmonic((1.0, 2.0, 3.0), 5.0, 0.1), Harmonic((4.0, 5.0, 6.0), 7.0, 0.2, "body")],
        torque_terms=[Harmonic((0.1, 0.2, 0.3), 8.0, 0.3), Harmonic((0.4, 0.5, 0.6), 9.0, 0.4)],
        drive=Oscillation(0.5, 2.0, 0.5),
    ),
    joint=replace(LOADED.joint, restitution=0.5, contact_stiffness=1e9),
    motion=Motion.free((1e-3, 2e-3), (0.1, -0.2), (0.01, 0.02), (1.0, -2.0), 0.7, 40.0),
)


@pytest.mark.parametrize("name", SCALARS)
def test_replaced_changes_one_scalar_and_nothing_else(name):
    flies = (*quantities.CONTACT, *quantities.FREE_START, *quantities.SWINGING, *quantities.DRIVE)
    scene = FLYING if name in flies else LOADED
    value = scene.scalars[name] * 1.01
    changed = scene.replaced(**{name: value}).scalars
    assert changed[name] == value
    assert {k: v for k, v in changed.items() if k != name} == {k: v for k, v in scene.scalars.items() if k != name}


@pytest.mark.parametrize(
    ("scene", "name"),
    [
        (LOADED, "restitution"),
        (LOADED, "contact_stiffness"),
        (LOADED, "slope_x"),
        (LOADED, "force_term_1_x"),
        (LOADED, "drive_phase"),
        (FLYING, "alpha"),
        (FLYING, "beta_rate"),
    ],
)
def test_a_scalar_that_a_scene_lacks_cannot_be_replaced(scene, name):
    with pytest.raises(ValueError, match=f"Scene: {name} varies"):
        scene.replaced(**{name: 0.5})


def test_replaced_with_nothing_is_the_scene():
    for scene in (SYMMETRIC, LOADED, replace(SYMMETRIC, joint=Joint(2, 1, 2, "exact"))):
        assert scene.replaced() == scene


def test_replaced_brings_an_absent_load():
    assert SYMMETRIC.replaced(force_y=2.0).loads.force == (0, 2.0, 0)
    assert SYMMETRIC.replaced(torque_z=2.0).loads.torque == (0, 0, 2.0)
    assert SYMMETRIC.replaced(mass=1.0).loads == SYMMETRIC.loads


def test_replaced_checks_again():
    refuses(ValueError, ["unknown scalar 'weight'", "mass"], lambda: SYMMETRIC.replaced(weight=1.0))
    refuses(ValueError, ["clearance"], lambda: SYMMETRIC.replaced(journal_radius=0.03))
    refuses(ValueError, ["inertia"], lambda: SYMMETRIC.replaced(inertia_zz=1.0))
