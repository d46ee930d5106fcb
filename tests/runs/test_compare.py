"""Two runs side by side: what changed, and whether intervals of differences hold."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from small_study import GEOMETRY, write

import tolmc
from tolmc.cli import main
from tolmc.errors import InputError
from tolmc.runs.compare import STATISTICS, compare_runs, difference
from tolmc.tables.compare import comparison_blocks
from tolmc.tables.table import Table

pytestmark = pytest.mark.usefixtures("ready_pictures_throughout")


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs")
    wider = ('tolerance = ["-0.03 mm", "0 mm"]', 'tolerance = ["-0.06 mm", "0 mm"]')
    tolmc.run(write(folder, *GEOMETRY), samples=2000, out=folder / "first")
    tolmc.run(write(folder, *GEOMETRY, wider), samples=2000, seed=8, out=folder / "second")
    return folder / "first", folder / "second"


def test_values_are_the_runs_own_and_differences_second_less_first(runs):
    found = compare_runs(*runs)
    results = [tolmc.runs.directory.read(path) for path in runs]
    assert found.first.path == results[0].path
    tilt = found.statistics.loc["tilt_angle"]
    assert list(tilt.index) == list(STATISTICS)
    np.testing.assert_array_equal(tilt["difference"], tilt["second"] - tilt["first"])
    assert tilt.at["mean", "difference_low"] > 0  # a smaller journal tilts further
    assert tilt.at["sd", "difference_low"] > 0
    out = found.shares.loc["tilt_angle"]
    assert out["difference"] > 0 and out["difference_low"] > 0


def test_what_changed_in_the_study(runs):
    changes = compare_runs(*runs).study
    assert list(changes.index) == ["[dimensions] journal_radius.tolerance"]
    assert changes.iloc[0].tolist() == ["['-0.03 mm', '0 mm']", "['-0.06 mm', '0 mm']"]
    assert compare_runs(runs[0], runs[0]).study.empty


def test_a_run_does_not_differ_from_itself(runs):
    found = compare_runs(runs[0], runs[0])
    statistics = found.statistics
    assert (statistics["difference"] == 0).all()
    (table,) = (b for b in comparison_blocks(found) if isinstance(b, Table) and b.name == "statistics")
    assert {row[-1].content for row in table.rows} == {"equal"}
    assert ((statistics["difference_low"] <= 0) & (statistics["difference_high"] >= 0)).all()


def test_the_interval_of_a_difference_holds_as_often_as_it_says():
    rng = np.random.default_rng(5)
    n, repeats, true = 60, 4000, 0.7
    first, second = rng.exponential(1.0, (repeats, n)), rng.normal(1.0 + true, 0.4, (repeats, n))

    def interval(values):
        mean, half = values.mean(axis=1), 1.96 * values.std(axis=1, ddof=1) / np.sqrt(n)
        return np.stack((mean, mean - half, mean + half), axis=1)

    found = difference(interval(first), interval(second))
    covered = ((found["difference_low"] <= true) & (true <= found["difference_high"])).mean()
    assert 0.93 < covered < 0.97


def test_what_rounding_leaves_is_no_difference():
    same = np.array([[0.3, 0.3, 0.3], [2.0, 1.9, 2.1]])
    found = difference(same, same + np.array([[5.6e-17], [0.01]]))
    assert found.loc[0, ["difference", "difference_low", "difference_high"]].tolist() == [0.0, 0.0, 0.0]
    assert found.at[1, "difference"] == pytest.approx(0.01)


def test_an_interval_without_an_end_leaves_the_difference_without_one():
    found = difference(np.array([[1.0, -np.inf, 2.0]]), np.array([[3.0, 2.5, 3.5]]))
    assert found.at[0, "difference_high"] == np.inf and np.isfinite(found.at[0, "difference_low"])


def test_compare_on_the_command_line(runs, tmp_path):
    def invoke(*arguments):
        return CliRunner().invoke(main, ["compare", *map(str, arguments)])

    shown = invoke(*runs, "--out", tmp_path / "both.html")
    assert shown.exit_code == 0
    for words in (
        "What changed in the study",
        "journal_radius.tolerance",
        "Tilt angle ψ, mean",
        "more",
        "no difference shown",
    ):
        assert words in shown.stdout
    places = [
        shown.stdout.index(words)
        for words in ("Requirements", "Any requirement broken", "Outputs", "Tilt angle ψ, mean")
    ]
    assert places == sorted(places)  # what was asked before all else
    page = (tmp_path / "both.html").read_text(encoding="utf-8")
    assert page.startswith("<!DOCTYPE html>") and page.count("<table>") == 3 and "http" not in page
    assert "is no run directory" in invoke(runs[0], tmp_path).stderr


def test_outputs_with_limits_come_first_and_checks_of_the_integration_only_in_the_frame(runs):
    found = compare_runs(*runs)
    names = ["energy_error", "effective_radius", "tilt_angle"]
    parts = [found.statistics.loc[["tilt_angle"]].rename(index={"tilt_angle": name}) for name in names]
    blocks = comparison_blocks(replace(found, statistics=pd.concat(parts)))
    (table,) = (block for block in blocks if isinstance(block, Table) and block.name == "statistics")
    assert list(dict.fromkeys(str(row[0].content).split(",")[0] for row in table.rows)) == [
        "Tilt angle ψ",
        "Effective radius r",
    ]
    assert "energy_error" in table.frame.index


def test_a_run_that_is_not_finished_is_refused(runs, tmp_path):
    import json
    import shutil

    shutil.copytree(runs[0], tmp_path / "part")
    record = json.loads((tmp_path / "part" / "run.json").read_text(encoding="utf-8"))
    (tmp_path / "part" / "run.json").write_text(json.dumps(record | {"state": "running"}), encoding="utf-8")
    with pytest.raises(InputError, match="not finished"):
        compare_runs(tmp_path / "part", runs[1])
