"""Friction and the drive in a study file: units, tolerances, and what they have no use for."""

import math

import pytest
from small_study import write

from tolmc.study.file import load_study
from tolmc.study.study import StudyError

FRICTION = """
[contact]
friction = 0.15
slip_speed = "2 mm/s"

[motion]"""


def load(folder, *changes):
    return load_study(write(folder, ("\n[motion]", FRICTION), *changes))


def test_friction_is_read_with_its_units_and_may_have_a_tolerance(tmp_path):
    varied = '\n[dimensions.friction]\ntolerance = 0.05\n[dimensions.slip_speed]\ntolerance = "1 mm/s"\n'
    study = load(tmp_path, ("\n[body]", f"{varied}[body]"))
    assert (study.scene.joint.friction, study.scene.joint.slip_speed) == (0.15, 2e-3)
    limits = {dimension.name: (dimension.lower, dimension.upper) for dimension in study.tolerances.dimensions}
    assert limits["friction"] == pytest.approx((0.1, 0.2))
    assert limits["slip_speed"] == pytest.approx((1e-3, 3e-3))


def test_a_drive_is_read(tmp_path):
    assert load(tmp_path).scene.loads.drive == "free"
    study = load(tmp_path, ("[loads]", '[loads]\ndrive = "constant speed"'))
    assert study.scene.loads.drive == "constant speed"


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("friction = 0.15", "friction = -0.15", "friction = -0.15: expected a plain number >= 0"),
        ('"2 mm/s"', '"0 mm/s"', "slip_speed"),
        ('"2 mm/s"', '"2 mm"', "'mm' is not that of a speed"),
        ("[loads]", '[loads]\ndrive = "motor"', "constant speed"),
        (
            "[monte_carlo]",
            '[monte_carlo]\non_contact_loss = "continue"',
            "with friction, wear, a drive or loads that swing the motion ends",
        ),
    ],
)
def test_what_cannot_be_is_named(tmp_path, old, new, complaint):
    with pytest.raises(StudyError, match=complaint):
        load(tmp_path, (old, new))


def test_outputs_of_friction_drive_and_wear_may_have_limits_with_units(tmp_path):
    limits = {
        "friction_torque_max": ("0.2 N m", 0.2), "friction_power_mean": ("5 W", 5.0), "slip_work_D": ("2 kJ", 2000.0),
        "drive_torque_mean": ("30 N mm", 0.03), "drive_power_mean": ("0.01 kW", 10.0), "slow_share": ("5 %", 0.05),
        "whirl_rate_mean": ("60 rpm", 2 * math.pi), "wear_rate": ("3.6 mm^3/h", 1e-12),
    }  # fmt: skip
    table = "".join(f'{name} = {{ max = "{text}" }}\n' for name, (text, _) in limits.items())
    study = load(tmp_path, ("[specification]\n", f"[specification]\n{table}"))
    for name, (_, value) in limits.items():
        assert study.specification[name]["max"] == pytest.approx(value, rel=1e-14), name
    wrong = table.replace("3.6 mm^3/h", "3.6 mm^3")
    with pytest.raises(StudyError, match="not that of a volume per time"):
        load(tmp_path, ("[specification]\n", f"[specification]\n{wrong}"))
