"""Balance grades."""

import math

import pytest
from small_study import write

import tolmc
from tolmc.study.study import StudyError
from tolmc.tolerances.distributions import Uniform


@pytest.mark.parametrize(("grade", "speed"), [("G6.3", 6.3e-3), ("G40", 40e-3), (" G 2.5 ", 2.5e-3)])
def test_a_grade_is_the_speed_of_the_centre_of_mass(tmp_path, grade, speed):
    study = tolmc.load_study(write(tmp_path, ("[body]", f'unbalance = "{grade}"\n[body]'), ("80 rad/s", "3000 rpm")))
    found = next(d for d in study.tolerances.dimensions if d.name == "center_of_mass_x")
    assert (found.lower, found.upper) == (0.0, pytest.approx(speed / (100 * math.pi)))
    assert isinstance(found.distribution, Uniform) and found.nominal == 0.0


@pytest.mark.parametrize(
    ("grade", "change", "words"),
    [
        ('"6.3"', ("x", "x"), "is no balance grade"),
        ("6.3", ("x", "x"), "is no balance grade"),
        ('"G0"', ("x", "x"), "is no balance grade"),
        ('"G6.3"', ('spin_rate = "80 rad/s"\n', ""), r"needs a rotor that turns; give \[motion\] spin_rate"),
        ('"G6.3"', ('["0 mm", "0 mm"', '["1 mm", "0 mm"'), r"\[body\] center_of_mass off the axis both say"),
        ('"G6.3"\ncenter_of_mass_y = { tolerance = "1 mm" }', ("x", "x"), r"\[dimensions\] center_of_mass_y both say"),
    ],
)
def test_grades_that_cannot_be_used(tmp_path, grade, change, words):
    with pytest.raises(StudyError, match=words):
        tolmc.load_study(write(tmp_path, ("[body]", f"unbalance = {grade}\n[body]"), change))
