"""Sizes as a drawing gives them, and the names of what it gives."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from small_study import TEXT, write

from tolmc import quantities
from tolmc.allocation.study_table import read_plan
from tolmc.study.drawing import deviations, size
from tolmc.study.file import load_study
from tolmc.study.study import StudyError
from tolmc.tables.dimensions import dimensions_table
from tolmc.tolerances.distributions import Scipy, Triangular

BEARING, JOURNAL, LENGTH = (line for line in TEXT.splitlines() if line.startswith(("bearing_", "journal_", "half_")))


def dimension(folder, line, old=BEARING):
    study = load_study(write(folder, (old, line)))
    name = old.split()[0]
    return next(d for d in study.tolerances.dimensions if d.name == name)


@pytest.mark.parametrize(
    ("text", "nominal", "lower", "upper"),
    [
        ("40 ±0.05 mm", 40, 39.95, 40.05),
        ("40 mm ±50 µm", 40, 39.95, 40.05),
        ("40mm +/-0.05mm", 40, 39.95, 40.05),
        ("⌀40 ±0.05 mm", 40, 39.95, 40.05),
        ("Ø 40 +0.1/-0.2 mm", 40, 39.8, 40.1),
        ("40 +0.1/0 mm", 40, 40, 40.1),
        ("40 0/-0.2 mm", 40, 39.8, 40),
        ("40 mm -0.2/+0.1 mm", 40, 39.8, 40.1),
        ("40 +0.2 / +0.1 mm", 40, 40.1, 40.2),
        ("4 +0.01/-0.02 cm", 40, 39.8, 40.1),
        ("⌀40 H7", None, 40, 40.025),
        ("40 mm", 40, None, None),
        ("⌀ 40 mm", 40, None, None),
    ],
)
def test_the_model_takes_half_of_what_the_drawing_says(tmp_path, text, nominal, lower, upper):
    found = dimension(tmp_path, f'bearing_diameter = "{text}"')
    lower, upper = (nominal if limit is None else limit for limit in (lower, upper))
    nominal = (lower + upper) / 2 if nominal is None else nominal
    assert (found.nominal, found.lower, found.upper) == pytest.approx(
        (nominal / 2e3, lower / 2e3, upper / 2e3), rel=1e-14
    )
    assert found.shown_name == "bearing_diameter"


def test_a_text_and_a_table_say_the_same(tmp_path):
    drawn = dimension(
        tmp_path, 'bearing_diameter = { size = "40 +0.1/-0.2 mm", distribution = "triangular", mode = "39.9 mm" }'
    )
    model = dimension(
        tmp_path,
        'bearing_radius = { nominal = "20 mm", tolerance = ["-0.1 mm", "0.05 mm"], distribution = "triangular",'
        ' mode = "19.95 mm" }',
    )
    assert (drawn.nominal, drawn.lower, drawn.upper) == (model.nominal, model.lower, model.upper)
    assert drawn.distribution == model.distribution == Triangular(19.95e-3)
    assert model.shown_name == "bearing_radius"


def test_everything_of_a_table_is_the_diameters(tmp_path):
    found = dimension(
        tmp_path,
        'bearing_diameter = { nominal = "40 mm", tolerance = "+0.1/-0.2 mm", distribution = "norm", lot_sd = "4 um",'
        ' arguments = { loc = "40 mm", scale = "20 um" } }\nlot_size = 5',
    )
    assert found.distribution == Scipy("norm", {"loc": 20e-3, "scale": 10e-6})
    assert found.lot_sd == pytest.approx(2e-6)
    (tmp_path / "bores.csv").write_text("d\n39.9\n40.1\n")
    measured = dimension(tmp_path, 'bearing_diameter = { data = "bores.csv", column = "d", unit = "mm" }')
    np.testing.assert_allclose(measured.distribution.values, [19.95e-3, 20.05e-3])


def test_scalars_that_have_no_drawing_may_have_a_text(tmp_path):
    study = load_study(write(tmp_path, ("[body]", 'mass = "±5 g"\nspin_rate = "+10/-20 rpm"\n[body]')))
    by_name = {d.name: d for d in study.tolerances.dimensions}
    assert (by_name["mass"].lower, by_name["mass"].upper) == pytest.approx((0.495, 0.505))
    assert by_name["spin_rate"].lower == pytest.approx(80 - 20 * math.pi / 30)
    assert by_name["mass"].shown_name == "mass"


def test_correlation_and_allocation_take_the_drawings_names(tmp_path):
    changes = (
        (BEARING, 'bearing_diameter = "40 ±0.1 mm"'),
        (LENGTH, 'bearing_length = "40 ±0.2 mm"'),
        (
            "[body]",
            "[correlation]\nbearing_diameter.bearing_length = 0.5\n"
            "[allocation.dimensions]\nbearing_diameter = { grades = { IT7 = 1 } }\n"
            'bearing_length = { narrowest = "0.1 mm", widest = "0.4 mm", cost = { variable = 1, at = "0.2 mm" } }\n[body]',
        ),
    )
    study = load_study(write(tmp_path, *changes))
    assert study.tolerances.correlation[0][2] == 0.5
    bore, length = read_plan(study).choices
    assert bore.name == "bearing_radius" and bore.widths[bore.labels.index("IT7")] == pytest.approx(12.5e-6)
    assert (length.name, length.narrowest, length.widest, length.at) == ("half_length", 5e-5, 2e-4, 1e-4)


def test_tables_speak_in_the_form_of_the_study(tmp_path):
    drawn = dimensions_table(load_study(write(tmp_path, (BEARING, 'bearing_diameter = "40 ±0.1 mm"')))).rows[0]
    model = dimensions_table(load_study(write(tmp_path))).rows[0]
    assert (drawn[0].content, drawn[3].content) == ("Bearing diameter 2 R*", "39.9 to 40.1")
    assert (model[0].content, model[3].content) == ("Bearing radius R*", "19.95 to 20.05")
    assert drawn[1].content == model[1].content == "⌀40"
    assert quantities.shown("bearing_diameter") == ("mm", 2e3)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        (
            'bearing_radius = "⌀40 ±0.1 mm"',
            ["[dimensions] bearing_radius", "⌀ is a diameter", "call it bearing_diameter"],
        ),
        ('bearing_radius = "40 H7"', ["a tolerance class is for", "call it bearing_diameter"]),
        ('bearing_diameter = "40 0.1/0.2 mm"', ["no sign", "+0.1/-0.2"]),
        (
            'bearing_diameter = "40,5 ±0.1 mm"',
            ["[dimensions] bearing_diameter", "decimal sign is a comma", "write a point"],
        ),
        ('bearing_diameter = "-40 ±0.1 mm"', ["bearing_diameter = '-40 ±0.1 mm'", "allowed"]),
        ('bearing_diameter = "40 ±0.1"', ["no unit", "40 ±0.05 mm"]),
        ('bearing_diameter = "40 ±0.1 kg"', ["[dimensions] bearing_diameter", "is not that of a length"]),
        ('bearing_diameter = { size = "40 ±0.1 mm", tolerance = "0.2 mm" }', ["tolerance is in size", "leave one out"]),
        (
            'bearing_diameter = "40 mm"\nbearing_radius = "20 mm"',
            ["bearing_diameter and bearing_radius", "leave one out"],
        ),
        ('bearing_diameter = { lower = "39 mm" }', ["[dimensions] bearing_diameter: only one limit"]),
        ('mass = "40 H7"\n' + BEARING, ["[dimensions] mass", "mass is neither"]),
    ],
)
def test_sizes_that_cannot_be_used(tmp_path, line, words):
    with pytest.raises(StudyError) as error:
        load_study(write(tmp_path, (BEARING, line)))
    for word in words:
        assert word in str(error.value)


@given(
    nominal=st.decimals(1, 1000, places=3),
    low=st.decimals(-1, 1, places=3),
    high=st.decimals(-1, 1, places=3),
    space=st.sampled_from(["", " "]),
)
def test_any_deviations_are_read_as_written(nominal, low, high, space):
    found = size("bearing_length", f"{nominal}{space}{high:+}{space}/{space}{low:+}{space}mm")
    assert found == {"nominal": f"{nominal} mm", "tolerance": [f"{value:+} mm" for value in sorted((high, low))]}
    assert deviations(f"{high:+}/{low:+} mm") == found["tolerance"]


@given(text=st.text(max_size=12))
def test_any_other_text_is_left_to_what_reads_quantities(text):
    try:
        found = size("bearing_diameter", text)
    except ValueError as error:
        assert str(error)
    else:
        assert set(found) <= {"nominal", "tolerance", "diameter"}
