"""Outputs of a study's own: what expressions mean, and what they may not be."""

import json
import math
import pickle

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from small_study import GEOMETRY, write

import tolmc
from tolmc import quantities
from tolmc.analysis.model import study_model
from tolmc.runs.compare import compare_runs
from tolmc.study.derived import read_outputs
from tolmc.study.fields import Faults
from tolmc.study.study import StudyError
from tolmc.tables.run import run_blocks
from tolmc.tables.table import Note

ROWS = {
    "tilt_angle": np.array([0.1, 0.2]),
    "contact_force_D_max": np.array([3.0, 4.0]),
    "bearing_radius": np.array([0.02, 0.021]),
}
SCALARS = {**dict.fromkeys(quantities.SCALARS, 1.0), "mass": 0.5, "journal_radius": 0.01}


def value(expression, name="mine", unit=None):
    (derived,) = read_outputs({name: {"value": expression, **({"unit": unit} if unit else {})}})
    return derived.values(ROWS, SCALARS)


@pytest.mark.parametrize(
    ("name", "expression", "expected", "unit"),
    [
        ("sag_1", "800 mm * sin(tilt_angle)", 0.8 * np.sin([0.1, 0.2]), "m"),
        ("weight_1", "mass * 9.81 m/s^2", [4.905, 4.905], "N"),
        ("ratio_1", "contact_force_D_max / (mass * 9.81 m/s^2)", np.array([3, 4]) / 4.905, "1"),
        ("play_1", "bearing_diameter - 2*journal_radius", [0.02, 0.022], "m"),
        ("moment_1", "contact_force_D_max * 30mm", [0.09, 0.12], "N m"),
        ("wide_1", "max(bearing_radius, 20.5 mm) + 1e-1 cm", [0.0215, 0.022], "m"),
        ("turned_1", "tilt_angle + 90 deg", np.array([0.1, 0.2]) + math.pi / 2, "rad"),
        ("angle_1", "atan2(1 mm, 2 mm)", [math.atan(0.5)] * 2, "rad"),
        ("area_root_1", "sqrt(bearing_radius**2)", [0.02, 0.021], "m"),
        ("negative_1", "-tilt_angle", [-0.1, -0.2], "rad"),
    ],
)
def test_expressions_have_values_and_units(name, expression, expected, unit):
    np.testing.assert_allclose(value(expression, name), expected, rtol=1e-14)
    assert quantities.unit(name) == unit


def test_a_unit_says_what_the_dimension_leaves_open():
    value("contact_force_D_max * 1 mm", "work_2", "J")
    assert quantities.unit("work_2") == "J"
    value("tilt_angle / 2", "half_2", "deg")
    assert quantities.unit("half_2") == "rad"


@pytest.mark.parametrize(
    ("expression", "words"),
    [
        ("tilt_angel * 2", ["'tilt_angel' is no dimension or output", "did you mean 'tilt_angle'"]),
        ("sine(tilt_angle)", ["'sine' is no function", "sin"]),
        ("tilt_angle + 3 mm", ["units do not go together"]),
        ("3 foos * tilt_angle", ["the unit 'foos' behind 3 is unknown"]),
        ("tilt_angle.real", ["only arithmetic"]),
        ("().__class__", ["only arithmetic"]),
        ("'a' * 9", ["no number"]),
        ("[x for x in tilt_angle]", ["only arithmetic"]),
        ("tilt_angle if mass else mass", ["only arithmetic"]),
        ("tilt_angle > 1", ["only arithmetic"]),
        ("tilt_angle ^ 2", ["BitXor is no arithmetic", "**"]),
        ("sin(x=1)", ["only arithmetic"]),
        ("__import__('os')", ["is no function"]),
        ("tilt_angle +", ["it is no expression"]),
        ("", ["it is no expression"]),
        ("1" * 600, ["longer than"]),
        ("exp(1 mm)", ["units do not go together"]),
        ("mass * mass * mass", ["which no quantity here has"]),
        ("sin(1, 2, 3, 4)", ["cannot be evaluated"]),
    ],
)
def test_what_is_no_output_says_so(expression, words):
    with pytest.raises(Faults) as fault:
        value(expression, "wrong")
    for word in words:
        assert word in str(fault.value), str(fault.value)
    assert not quantities.is_known("wrong")


@pytest.mark.parametrize("name", ["mass", "tilt_angle", "sin", "Sag", "a b", "duration"])
def test_names_that_mean_something_else(name):
    with pytest.raises(Faults, match="cannot be called so"):
        read_outputs({name: "tilt_angle"})


@pytest.mark.usefixtures("ready_pictures")
def test_an_output_belongs_to_its_study(tmp_path):
    results = []
    for k, expression in enumerate(("800 mm * sin(tilt_angle)", "2 * tilt_angle")):
        own = ("[specification]", f'[outputs]\nsag = {{ value = "{expression}", label = "Sag {k}" }}\n[specification]')
        path = write(tmp_path, *GEOMETRY, own, name=f"{k}.toml")
        results.append(tolmc.run(path, samples=32, workers=1, out=tmp_path / f"{k}"))
    for result, unit in (*zip(results, ("mm", "deg"), strict=True), (pickle.loads(pickle.dumps(results[0])), "mm")):
        assert f"Sag {result.study.name} <small>{unit}</small>" in result._repr_html_()
        again = tolmc.run(result.study, samples=32, workers=1)
        assert again.summary.at["sag", "mean"] == result.summary.at["sag", "mean"]
    assert "sag" not in compare_runs(tmp_path / "0", tmp_path / "1").statistics.index.get_level_values("output")


@example(text="beta")
@given(text=st.text(alphabet="abtilt_ange01.+-*/()[]{}'\"<>= ,:^%mN\n", max_size=40))
def test_any_text_is_a_value_or_a_fault(text):
    try:
        found = value(text, "any_text")
    except Faults:
        return
    assert found.shape == (2,)


OUTPUTS = '[outputs]\nslant = "200 mm * tan(tilt_angle)"\n[specification]\nslant = { max = "91 mm" }'
DERIVED = (*GEOMETRY, ("[specification]", OUTPUTS))


def test_a_study_with_outputs_of_its_own(tmp_path):
    result = tolmc.run(write(tmp_path, *DERIVED), samples=500, out=tmp_path / "run")
    samples = result.samples
    np.testing.assert_array_equal(samples["slant"], 0.2 * np.tan(samples["tilt_angle"]))
    out = (samples["slant"] > 0.091).sum()
    assert 0 < out < 500 and result.requirements.at["slant", "out"] == out
    assert result.summary.at["slant", "unit"] == "m"
    again = tolmc.load_study(tmp_path / "run" / "study.toml")
    assert again.derived == result.study.derived == pickle.loads(pickle.dumps(result.study)).derived
    model = study_model(result.study, ["slant"])
    found = model(samples[["bearing_radius", "journal_radius", "half_length"]].head(5))
    np.testing.assert_allclose(found["slant"], samples["slant"].head(5), rtol=1e-14)


def test_the_target_is_judged(tmp_path):
    target = (*GEOMETRY, ("[specification]", '[specification]\ntarget = "99.7 %"'))
    assert tolmc.load_study(write(tmp_path, *target)).target == 0.997
    with pytest.raises(StudyError, match="between 0 and 1"):
        tolmc.load_study(write(tmp_path, *GEOMETRY, ("[specification]", '[specification]\ntarget = "101 %"')))
    both = (*target, ("[body]", "[allocation]\ntarget_yield = 0.99\n[body]"))
    with pytest.raises(StudyError, match="are the same; leave one out"):
        tolmc.load_study(write(tmp_path, *both))


def test_outputs_that_cannot_be_read_name_the_study(tmp_path):
    with pytest.raises(StudyError, match=r"small.toml: \[outputs\] slant = 'tilt': 'tilt' is no dimension or output"):
        tolmc.load_study(write(tmp_path, ("[body]", '[outputs]\nslant = "tilt"\n[body]')))
    assert json.loads(json.dumps(list(quantities.OUTPUTS)))


@pytest.mark.parametrize(("limit", "verdict"), [("100 mm", "met"), ("80 mm", "not met")])
def test_a_run_says_whether_the_target_is_met(tmp_path, limit, verdict):
    text = OUTPUTS.replace("slant = { max = ", 'target = "99 %"\nslant = { max = ').replace("91 mm", limit)
    result = tolmc.run(
        write(tmp_path, *GEOMETRY[:1], ("[specification]", text), GEOMETRY[1], ('"24.4 deg"', '"1 rad"')), samples=600
    )
    notes = [block.text for block in run_blocks(result) if isinstance(block, Note)]
    assert any(note.startswith(f"Target {verdict}: ") for note in notes), notes
