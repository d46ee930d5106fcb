"""Studies as mappings, and what a notebook shows."""

import pickle
import sys
import tomllib
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure
from small_study import GEOMETRY, TEXT, write

import tolmc
from tolmc.errors import InputError
from tolmc.runs import progress
from tolmc.study.study import StudyError


@pytest.fixture(scope="module")
def content():
    text = TEXT
    for old, new in GEOMETRY:
        text = text.replace(old, new)
    return tomllib.loads(text)


@pytest.fixture(scope="module")
def result(content):
    return tolmc.run(content, samples=400)


def test_a_mapping_is_the_file_that_says_the_same(tmp_path, content, result):
    of_file = tolmc.run(write(tmp_path, *GEOMETRY), samples=400)
    pd.testing.assert_frame_equal(result.samples, of_file.samples)
    again = tmp_path / "again.toml"
    again.write_text(result.study.source, encoding="utf-8")
    assert tomllib.loads(result.study.source) == content
    assert tolmc.load_study(again).scene.scalars == result.study.scene.scalars


def test_a_mapping_may_hold_numpys_numbers_and_none(content):
    changed = content | {
        "loads": {"gravity": np.array([0, -9.81, 0]), "force": None},
        "body": content["body"] | {"mass": np.float64(0.5), "inertia": (4.08e-4, 4.08e-4, np.float32(1.2e-4))},
        "monte_carlo": content["monte_carlo"] | {"samples": np.int64(30)},
    }
    study = tolmc.Study.from_dict(changed)
    assert (study.samples, study.scene.body.mass, study.scene.loads.gravity) == (30, 0.5, (0.0, -9.81, 0.0))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"body": {"mass": -1}}, ["mine: [body] mass = -1", "> 0"]),
        ({"body": {"mass": object()}}, ["mine", "object", "texts, numbers"]),
        ({"bodi": {}}, ["bodi", "did you mean 'body'"]),
    ],
)
def test_a_mapping_that_is_no_study_says_so(content, change, words):
    with pytest.raises(StudyError) as error:
        tolmc.Study.from_dict(content | change, name="mine")
    for word in words:
        assert word in str(error.value)


@pytest.mark.usefixtures("ready_pictures")
def test_a_run_of_a_mapping_goes_on_from_its_directory(tmp_path, content, result):
    from tolmc.runs.run import resume

    tolmc.run(content, samples=300, out=tmp_path / "run")
    longer = resume(tmp_path / "run", extend=100)
    pd.testing.assert_frame_equal(longer.samples, result.samples, check_categorical=False)


def test_what_is_shown_in_a_line(result):
    assert repr(result).startswith("<StudyResult 'A small study': 400 samples; ")
    assert repr(result.study) == (
        "<Study 'A small study': 400 sobol samples, seed 7; varied: bearing_radius, journal_radius, half_length; "
        "limited: tilt_angle>"
    )
    trajectory = tolmc.simulate(result.study.scene)
    assert repr(trajectory).startswith("<Trajectory ok: ") and len(repr(trajectory)) < 200


def test_what_is_shown_on_a_page(result):
    trajectory = tolmc.simulate(result.study.scene)
    for shown, words in (
        (result, ["A small study", "Tilt angle ψ", "24.4"]),
        (result.study, ["Bearing radius R*", "Clearance", "⌀40"]),
        (trajectory, ["Largest N_D", "Status"]),
    ):
        page = shown._repr_html_()
        assert page.count("<table>") == page.count("</table>") >= 1
        for word in words:
            assert word in page
    title = {"title": "<script>"} | {name: table for name, table in tomllib.loads(TEXT).items() if name != "title"}
    assert "<script>" not in tolmc.Study.from_dict(title)._repr_html_()


def test_pictures(result):
    trajectory = tolmc.simulate(result.study.scene)
    for figure in (
        result.plot(),
        result.plot("drivers"),
        result.plot("motion"),
        result.study.plot(),
        trajectory.plot(),
    ):
        assert isinstance(figure, Figure)
        assert figure._repr_png_().startswith(b"\x89PNG")
    with pytest.raises(InputError, match="allowed: distributions, drivers, motion"):
        result.plot("driver")


@pytest.mark.usefixtures("ready_pictures")
def test_everything_can_be_pickled(tmp_path, content, result):
    written = tolmc.run(content, samples=50, out=tmp_path / "run")
    for found in (tolmc.run(content, samples=50), written):
        again = pickle.loads(pickle.dumps(found))
        pd.testing.assert_frame_equal(again.samples, found.samples)
        pd.testing.assert_frame_equal(again.summary, found.summary)
        assert repr(again) == repr(found)
    trajectory = tolmc.simulate(result.study.scene)
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(trajectory)).contact_force, trajectory.contact_force)


@pytest.mark.parametrize(
    ("has_ipython", "has_widgets", "is_jupyter", "expected"),
    [(True, True, True, True), (False, True, True, False), (True, False, True, False), (True, True, False, False)],
)
def test_a_notebook_with_widgets_gets_a_bar(monkeypatch, has_ipython, has_widgets, is_jupyter, expected):
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace()) if has_ipython else monkeypatch.delitem(
        sys.modules, "IPython", raising=False
    )
    monkeypatch.setattr(progress, "find_spec", lambda name: object() if has_widgets else None)
    monkeypatch.setattr("rich.console.Console", lambda **options: SimpleNamespace(is_jupyter=is_jupyter))
    assert progress._in_notebook() == expected
