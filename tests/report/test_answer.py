"""The first line of a report says what was asked."""

import tolmc
from tolmc import quantities
from tolmc.commands.init import write_example
from tolmc.report.answer import question


def test_statistics_over_the_motion_are_said_in_words():
    assert [quantities.of(name).phrase for name in ("friction_torque_max", "drive_power_mean", "friction_work")] == [
        "largest friction torque",
        "mean drive power",
        "friction work",
    ]


def test_the_question_names_the_tolerance_classes(tmp_path):
    write_example(tmp_path / "door.toml", "hinge")
    assert question(tolmc.load_study(tmp_path / "door.toml")) == (
        "Do parts made to the limits of bearing diameter 2 R* (⌀8 H11), journal diameter 2 r* (⌀8 d11) and bearing length 2 L "
        "keep the sag at the door's edge ≤ 2.5 mm?"
    )
