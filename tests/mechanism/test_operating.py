"""Operating conditions: dimensions in operation against the laws of expansion, in the scene and sample by sample."""

from dataclasses import replace

import numpy as np
import pytest

import tolmc
from tolmc.mechanism.operating import EXPANSION, Operating, closing_temperature

HOT = 80.0  # 60 K above the drawing's temperature


def scene(operating=None, **joint):
    sizes = {"bearing_radius": 0.0101, "journal_radius": 0.01, "half_length": 0.02} | joint
    return tolmc.Scene(
        tolmc.Joint(**sizes), tolmc.Body(0.5, (0, 0, 0.004), (4.08e-4, 4.08e-4, 1.2e-4)),
        tolmc.Loads(gravity=(0, -9.81, 0)), tolmc.Motion(-1.92, -0.87, spin_rate=80.0), 0.1, operating,
    )  # fmt: skip


def test_parts_grow_with_their_own_temperature_and_material():
    joint = scene(Operating(HOT, 40.0, "aluminium", 12e-6)).joint_in_operation
    assert joint.bearing_radius == pytest.approx(0.0101 * (1 + 60 * 23.6e-6), rel=1e-15)
    assert joint.half_length == pytest.approx(0.02 * (1 + 60 * 23.6e-6), rel=1e-15)
    assert joint.journal_radius == pytest.approx(0.01 * (1 + 20 * 12e-6), rel=1e-15)


def test_equal_growth_of_all_dimensions_leaves_the_tilt_as_it_is():
    drawn = scene()
    hot = scene(Operating(HOT, HOT, "steel", "steel"))
    assert hot.joint_in_operation.tilt_angle == pytest.approx(drawn.joint.tilt_angle, rel=1e-13)
    ratio = hot.joint_in_operation.effective_radius / drawn.joint.effective_radius
    assert ratio == pytest.approx(1 + 60 * EXPANSION["steel"], rel=1e-13)


def test_a_bush_in_a_stiff_housing_closes_by_six_alpha_dt_wall_in_diameter():
    joint = scene(Operating(HOT, HOT, 110e-6, 0.0, bush_wall=1e-3)).joint_in_operation
    assert 2 * (0.0101 - joint.bearing_radius) == pytest.approx(6 * 110e-6 * 60 * 1e-3, rel=1e-9)
    assert joint.half_length == 0.02


def test_wear_opens_the_clearance():
    joint = scene(Operating(bearing_wear=2e-4, journal_wear=5e-5)).joint_in_operation
    assert joint.approximate_radius == pytest.approx(1e-4 + 2.5e-4, rel=1e-12)


def test_motion_and_geometry_are_those_of_the_dimensions_in_operation():
    hot = scene(Operating(HOT, 40.0, "aluminium", "steel", bearing_wear=1e-4))
    cold = replace(hot, joint=hot.joint_in_operation, operating=None)
    sizes = {"bearing_radius": 0.0101, "journal_radius": 0.01, "half_length": 0.02}
    worn = tolmc.simulate_many(hot, **sizes)
    joint = cold.joint
    same = tolmc.simulate_many(
        cold, bearing_radius=joint.bearing_radius, journal_radius=joint.journal_radius, half_length=joint.half_length
    )
    outputs = same.columns[3:]
    assert worn["bearing_radius"].iloc[0] == 0.0101  # inputs stay the drawn ones
    np.testing.assert_array_equal(worn[outputs].iloc[0, :-1].astype(float), same[outputs].iloc[0, :-1].astype(float))
    np.testing.assert_array_equal(tolmc.simulate(hot).origin, tolmc.simulate(cold).origin)


def test_conditions_vary_from_sample_to_sample():
    temperatures = np.array([20.0, 40.0, 60.0])
    samples = tolmc.simulate_many(
        scene(Operating(journal_expansion=23.6e-6)), bearing_radius=0.0101, journal_radius=0.01, half_length=0.02,
        parameters={"journal_temperature": temperatures}, outputs=["approximate_radius"],
    )  # fmt: skip
    expected = 1e-4 - 0.01 * 23.6e-6 * (temperatures - 20.0)
    np.testing.assert_allclose(samples["approximate_radius"], expected, rtol=1e-12)


def test_a_sample_without_clearance_in_operation_has_its_status():
    samples = tolmc.simulate_many(
        scene(Operating(journal_expansion=23.6e-6)), bearing_radius=0.0101, journal_radius=0.01, half_length=0.02,
        parameters={"journal_temperature": [20.0, 1020.0]}, outputs=["tilt_angle"],
    )  # fmt: skip
    assert list(samples["status"]) == ["ok", "geometry invalid"]


def test_a_scene_names_the_temperature_at_which_the_clearance_closes():
    bush = Operating(HOT, HOT, "polyacetal", "steel", bush_wall=5e-3)
    with pytest.raises(ValueError, match=r"no clearance is left; the clearance closes at 76\.59 °C"):
        scene(bush)
    limit = closing_temperature(scene().scalars | bush.scalars)
    bore = 0.0101 - 3 * 110e-6 * (limit - 20.0) * 5e-3
    assert bore == pytest.approx(0.01 * (1 + 11.7e-6 * (limit - 20.0)), rel=1e-13)


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        ({"bearing_expansion": "unobtainium"}, "no material of the table; allowed: steel"),
        ({"bearing_temperature": -300.0}, "allowed: above -273.15 °C"),
        ({"bush_wall": -1e-3}, "bush_wall = -0.001 m is out of range"),
        ({"journal_wear": float("nan")}, "journal_wear = nan is out of range"),
    ],
)
def test_conditions_that_cannot_be(arguments, complaint):
    with pytest.raises(ValueError, match=complaint):
        Operating(**arguments)


def test_wear_that_leaves_no_journal():
    with pytest.raises(ValueError, match="leave a journal radius"):
        scene(Operating(journal_wear=0.02))
