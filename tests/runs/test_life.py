"""The life of a joint that wears, against what Archard's law says of a shaft whose load and speed do not change."""

import math

import numpy as np
import pytest
from small_study import write
from wearing_study import HOURS, SPEED, K, study

from tolmc.mechanism.wear import bore_depth
from tolmc.runs import life as ageing
from tolmc.runs.life import contact_arc, life
from tolmc.runs.nominal import study_motion
from tolmc.study.file import load_study
from tolmc.study.study import StudyError
from tolmc.tables.life import life_blocks, life_sentence


def test_a_steady_load_wears_by_archards_law(tmp_path):
    found = life(study(tmp_path, ("[life]", "[life]\nsteps = 4")))
    weight = 0.5 * 9.81 * math.cos(math.atan(0.15))
    volume = K * weight * SPEED * 19.885e-3 * HOURS * 3600  # of the middle journal
    last = found.table.loc[HOURS]
    assert last["worn_volume q50"] == pytest.approx(volume, rel=1e-3)
    assert last["wear_rate q50"] == pytest.approx(volume / (HOURS * 3600), rel=1e-3)
    size = np.array([20e-3]), np.array([19.885e-3])
    depth = bore_depth(np.array([volume / 40e-3]), *size)[0]
    opened = last["approximate_radius q50"] - found.table.loc[0.0, "approximate_radius q50"]
    assert opened == pytest.approx(depth, rel=0.02)
    assert found.contact_arc < 1e-3
    assert math.isnan(found.step_error)


def test_the_life_is_where_the_share_of_good_parts_falls(tmp_path):
    found = life(study(tmp_path, ("samples = 64", "samples = 512")))
    assert found.step_error < 0.01
    inside = found.table["inside"].to_numpy()
    assert inside[0] == 1.0 and inside[-1] < 0.5 and (np.diff(inside) <= 0).all()
    hours = found.table.index.to_numpy()
    before = hours[inside >= 0.95][-1]
    assert before <= found.life.value <= hours[inside < 0.95][0]
    assert found.life.low < found.life.value < found.life.high
    assert f"{found.life.value:.4g} h" in life_sentence(found)
    table, *notes = life_blocks(found)
    assert len(table.rows) == len(hours)
    assert "20 steps of 50 h" in notes[1].text


def test_a_life_beyond_the_running_time_is_open(tmp_path):
    found = life(study(tmp_path, ('max = "0.18 mm"', 'max = "9 mm"'), ("[life]", "[life]\nsteps = 2")))
    assert found.life.value == math.inf and found.life.high == math.inf
    assert "more than 1,000 h" in life_sentence(found)


def test_the_journal_takes_its_share_and_an_arc_thins_the_wear(tmp_path):
    steps = ("[life]", "[life]\nsteps = 2")
    opened = {}
    for name, given in {"bore": "", "journal": "journal_share = 1\n", "round": 'contact_arc = "360 deg"\n'}.items():
        table = life(study(tmp_path, (steps[0], f"{steps[1]}\n{given}"))).table["approximate_radius q50"]
        opened[name] = table.iloc[-1] - table.iloc[0]
    assert opened["round"] == pytest.approx(opened["journal"], rel=0.05)
    assert opened["round"] < 0.2 * opened["bore"]


def test_steps_that_are_kept_are_not_computed_again(tmp_path, monkeypatch):
    small = study(tmp_path, ("[life]", "[life]\nsteps = 3"))
    first = life(small, keep=tmp_path / "steps")
    (tmp_path / "steps" / "step_0003.parquet").unlink()
    computed = []
    integrate = ageing.integrate_study
    monkeypatch.setattr(
        ageing, "integrate_study", lambda *given, **more: computed.append(1) or integrate(*given, **more)
    )
    again = life(small, keep=tmp_path / "steps")
    assert len(computed) == 1
    assert again.table.equals(first.table)
    life(small.replaced(seed=8), keep=tmp_path / "steps")
    assert len(computed) == 5


def test_the_arc_is_where_the_contact_wanders(tmp_path):
    rocks = study(
        tmp_path, ('drive = "constant speed"\n', ""), ("friction = 0.15", "friction = 0.0"), ('"0.01 s"', '"1 s"')
    )
    assert contact_arc(study_motion(rocks)) == pytest.approx(2 * math.atan(0.15), rel=0.1)


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ([('wear_coefficient = "1e-5 mm^3/(N m)"\n', "")], "give .contact. wear_coefficient"),
        ([('"1e-5 mm^3/(N m)"', '"-1e-5 mm^3/(N m)"')], "wear_coefficient.*expected a wear coefficient >= 0"),
        ([('"1e-5 mm^3/(N m)"', '"1e-5 mm^3"')], "not that of a wear coefficient"),
        ([("[life]", "[life]\njournal_share = 1.5")], "journal_share = 1.5: expected a number from 0 to 1"),
        ([("[life]", "[life]\nbroken_share = 0")], "broken_share = 0"),
        ([(f'running_time = "{HOURS} h"', "")], "running_time is missing"),
    ],
)
def test_what_cannot_be_is_named(tmp_path, changes, complaint):
    with pytest.raises(StudyError, match=complaint):
        study(tmp_path, *changes)


def test_what_a_life_needs_is_named(tmp_path):
    without = write(tmp_path)
    with pytest.raises(StudyError, match=r"\[life\] is missing"):
        life(load_study(without))
    text = ('[specification]\napproximate_radius = { max = "0.18 mm" }', "")
    with pytest.raises(StudyError, match=r"\[specification\] is missing"):
        life(study(tmp_path, text))
