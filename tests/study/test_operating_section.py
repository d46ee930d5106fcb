"""The [operating] table: temperatures with their scale, materials by name, conditions with a tolerance."""

import pytest
from small_study import write

from tolmc.mechanism.operating import EXPANSION
from tolmc.study.file import load_study
from tolmc.study.study import StudyError

OPERATING = """
[operating]
bearing_temperature = "80 °C"
journal_temperature = "313.15 K"
bearing_expansion = "polyacetal"
journal_expansion = 12e-6
bush_wall = "2 mm"
bearing_wear = "0.1 mm"

[motion]"""


def load(folder, *changes):
    return load_study(write(folder, ("\n[motion]", OPERATING), *changes))


def test_conditions_are_read_with_their_units(tmp_path):
    operating = load(tmp_path).scene.operating
    assert operating.bearing_temperature == 80.0
    assert operating.journal_temperature == pytest.approx(40.0)
    assert operating.bearing_expansion == EXPANSION["polyacetal"]
    assert operating.journal_expansion == 12e-6
    assert (operating.bush_wall, operating.bearing_wear, operating.journal_wear) == (0.002, 1e-4, 0.0)


def test_conditions_carry_tolerances(tmp_path):
    varied = (
        '\n[dimensions.bearing_temperature]\ntolerance = ["-10 K", "30 K"]\n[dimensions.journal_wear]\nlower = "0 mm"\n'
    )
    study = load(tmp_path, ("\n[body]", f'{varied}upper = "0.2 mm"\ndistribution = "uniform"\n[body]'))
    limits = {dimension.name: (dimension.lower, dimension.upper) for dimension in study.tolerances.dimensions}
    assert limits["bearing_temperature"] == (70.0, 110.0)
    assert limits["journal_wear"] == (0.0, 2e-4)


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ('"polyacetal"', '"polyacetaal"', "did you mean 'polyacetal'"),
        ('"80 °C"', '"80 mm"', "'mm' is not that of a temperature"),
        ('"2 mm"', '"-2 mm"', "bush_wall = '-2 mm': expected a length >= 0"),
        ('"2 mm"', '"2 m"', "the clearance closes at"),
    ],
)
def test_conditions_that_cannot_be_say_so(tmp_path, old, new, complaint):
    with pytest.raises(StudyError, match=complaint):
        load(tmp_path, (old, new))


@pytest.mark.parametrize("value", ["{}", "[]", "[12e-6]", "true", "1979-05-27"])
def test_an_expansion_of_another_kind_is_refused_in_words(tmp_path, value):
    with pytest.raises(StudyError, match=r"\[operating\] journal_expansion"):
        load(tmp_path, ("journal_expansion = 12e-6", f"journal_expansion = {value}"))
