"""What to change next: the least single change that does, and nothing where none does."""

import numpy as np
import pytest
from small_study import GEOMETRY, TEXT, write

import tolmc
from tolmc.allocation.next_change import next_changes
from tolmc.commands.answers import write_answers
from tolmc.report.write import write_report
from tolmc.tolerances.draw import sample

pytestmark = pytest.mark.usefixtures("ready_pictures_throughout")

RADII = "\n".join(line for line in TEXT.splitlines() if "_radius " in line)


def study_with(folder, limit, *changes):
    return tolmc.load_study(write(folder, *GEOMETRY, ('"24.4 deg"', f'"{limit} deg"'), *changes))


def true_yield(study, row):
    """Yield with the row's zone in place of the study's, from the equation of the tilt itself."""
    from tolmc.mechanism.geometry import tilt_angle

    dimensions = [
        d if d.name != row["dimension"] else type(d)(d.name, 0.5 * (row["lower"] + row["upper"]), row["lower"], row["upper"],
                                                     d.distribution.in_zone(d, row["lower"], row["upper"]))
        for d in study.tolerances.dimensions
    ]  # fmt: skip
    drawn = sample(type(study.tolerances)(dimensions), 100_000, sampling="sobol", seed=11)
    tilt = tilt_angle(*(drawn[name] for name in ("bearing_radius", "journal_radius", "half_length")))
    return np.mean(tilt <= study.specification["tilt_angle"]["max"])


def test_the_least_changes_reach_the_target_and_one_step_less_does_not(tmp_path):
    study = study_with(tmp_path, 24.4)
    found = next_changes(study, 0.999)
    assert len(found) and (found["kind"].ne("moved").diff().fillna(False) >= 0).all()
    for _, row in found.iterrows():
        assert true_yield(study, row) >= 0.999
        assert row["predicted_yield"] == pytest.approx(true_yield(study, row), abs=1e-3)
        assert row["yield_low"] <= true_yield(study, row) <= row["yield_high"]
        zone = next(d for d in study.tolerances.dimensions if d.name == row["dimension"])
        if row["kind"] == "moved":
            back = np.sign(row["lower"] - zone.lower) * 0.1 * (zone.upper - zone.lower)
            less = {**row, "lower": row["lower"] - back, "upper": row["upper"] - back}
            assert true_yield(study, less) < 0.999 + 0.2e-3


def test_classes_change_by_letters_and_grades(tmp_path):
    study = study_with(tmp_path, 0.35, (RADII, 'fit = "40 H11/d11"'))
    found = next_changes(study, 0.9973)
    sizes = set(found["toleranced_size"]) - {""}
    assert sizes and all(size.startswith("40 ") for size in sizes)
    for _, row in found[found["toleranced_size"] != ""].iterrows():
        letter = row["toleranced_size"].split()[1][0]
        assert (letter in "Hd") == (row["kind"] == "narrower")


def test_where_no_single_change_does_there_is_none(tmp_path):
    assert next_changes(study_with(tmp_path, 5), 0.9973).empty


@pytest.mark.parametrize(("limit", "is_told"), [(24.4, True), (26, False)])
def test_the_report_says_what_to_change_where_the_target_is_missed(tmp_path, limit, is_told):
    study = study_with(tmp_path, limit)
    tolmc.run(study, samples=2000, out=tmp_path / "run")
    write_answers(tmp_path / "run")
    write_report(tmp_path / "run")
    assert ("The least single change" in (tmp_path / "run" / "report.md").read_text(encoding="utf-8")) == is_told


@pytest.mark.slow
def test_a_report_without_a_change_that_does(tmp_path):
    tolmc.run(study_with(tmp_path, 5), samples=500, out=tmp_path / "run")
    write_answers(tmp_path / "run")
    assert write_report(tmp_path / "run").exists()
    assert "The least single change" not in (tmp_path / "run" / "report.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_what_a_shorter_run_had_to_change_is_forgotten(tmp_path):
    tolmc.run(study_with(tmp_path, 26), samples=2000, out=tmp_path / "run")
    (tmp_path / "run" / "next_changes.csv").write_text("dimension\nmass\n")
    write_answers(tmp_path / "run")
    assert not (tmp_path / "run" / "next_changes.csv").exists()
