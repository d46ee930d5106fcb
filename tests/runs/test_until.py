"""Runs of studies with ``until``: they stop where they should, survive, and tell it."""

import json
import shutil

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from complaints import complaints
from frames import assert_bitwise_equal
from small_study import GEOMETRY, write

from tolmc.cli import main
from tolmc.runs import directory as run_directory
from tolmc.runs import run as monte_carlo
from tolmc.runs.record import RunDirectoryError
from tolmc.runs.run import resume, run
from tolmc.statistics.observations import Observations
from tolmc.statistics.rows import Rows
from tolmc.study.file import load_study

pytestmark = pytest.mark.usefixtures("ready_pictures_throughout")
LARGEST = 10_000
# 1024, 2048, 4096, 8192 and 10000 samples, each at the level 1 - 0.05/5.
LOOK = 0.99
YIELD = 'statistic = "yield", width = 0.03'


def file(folder, until, *changes, sampling="random"):
    samples = "samples = 3000", f"samples = {LARGEST}\nuntil = {{ {until} }}"
    return write(folder, samples, ('"sobol"', f'"{sampling}"'), *GEOMETRY, *changes)


def mean_until(width):
    return f'output = "tilt_angle", statistic = "mean", width = {width!r}'


def half_angle(samples):
    return Observations(samples["tilt_angle"].to_numpy(), Rows("random", LOOK))


@pytest.mark.parametrize(
    ("until", "count", "estimate"),
    [
        (mean_until(9e-5), 4096, lambda samples: half_angle(samples).mean()),
        ('output = "tilt_angle", statistic = "sd", width = "0.0035 deg"', 4096, lambda s: half_angle(s).sd()),
        ('output = "tilt_angle", statistic = "q50", width = 1e-4', 8192, lambda s: half_angle(s).quantile(0.5)),
        (YIELD, 4096, lambda s: Rows("random", LOOK).share(s["tilt_angle"] <= np.radians(24.4))),
    ],
)
def test_sampling_stops_at_the_first_look_whose_interval_is_narrow_enough(tmp_path, until, count, estimate):
    study = load_study(file(tmp_path, until))
    result = run(study)
    found = result.sequential.found
    assert (found.count, found.reached, result.study.samples) == (count, True, count)
    assert_bitwise_equal(result.samples, run(study, samples=count).samples)
    assert found.estimate == pytest.approx(estimate(result.samples))
    width = study.until.width
    before = estimate(result.samples.iloc[: count // 2])
    assert found.estimate.high - found.estimate.low <= width < before.high - before.low


def test_a_run_that_falls_short_takes_the_largest_number_and_says_so(tmp_path):
    study = load_study(file(tmp_path, mean_until(1e-9)))
    result = run(study, out=tmp_path / "run")
    assert (result.sequential.found.count, result.sequential.found.reached) == (LARGEST, False)
    assert_bitwise_equal(result.samples, run(study, samples=LARGEST).samples)
    assert "ended without the width asked for after 10,000 of at most 10,000 samples" in result.sequential.sentence()


def test_all_intervals_hold_whichever_look_the_run_stops_at(tmp_path):
    result = run(file(tmp_path, mean_until(9e-5)))
    assert result.sequential.looks.look_confidence == pytest.approx(LOOK)
    expected = half_angle(result.samples).mean()
    row = result.summary.loc["tilt_angle"]
    assert (row["mean"], row["mean_low"], row["mean_high"]) == pytest.approx(expected)
    share = Rows("random", LOOK).share(result.samples["tilt_angle"] > np.radians(24.4))
    assert result.requirements.loc["tilt_angle", "share_most_high"] == pytest.approx(share.high)


@pytest.mark.parametrize("sampling", ["random", "sobol"])
def test_a_written_run_has_the_same_numbers(tmp_path, sampling):
    study = load_study(file(tmp_path, 'output = "tilt_angle", statistic = "q50", width = 7e-5', sampling=sampling))
    written, kept = run(study, out=tmp_path / "run"), run(study, workers=1)
    assert written.sequential.found == kept.sequential.found
    assert 1024 <= kept.study.samples <= LARGEST
    assert_bitwise_equal(pd.read_parquet(tmp_path / "run" / "samples.parquet"), kept.samples)
    record = json.loads((tmp_path / "run" / "run.json").read_text())
    count = kept.study.samples
    assert (record["samples"], record["stopped_at"], record["most_samples"]) == (count, count, LARGEST)
    assert run_directory.read(tmp_path / "run").study().until is None


class Stopped(BaseException):
    """As sudden as a kill."""


@pytest.mark.slow
def test_whatever_write_is_the_last_one_the_run_ends_the_same(tmp_path, monkeypatch):
    monkeypatch.setattr(monte_carlo, "_LEAST_WORK", 0.0)  # many blocks
    study = load_study(file(tmp_path, YIELD))
    run(study, out=tmp_path / "whole")
    names = ("samples.parquet", "summary.csv", "requirements.csv")
    expected = {name: (tmp_path / "whole" / name).read_bytes() for name in names}
    original = run_directory.Path.replace
    for last in range(3, 100):  # after the study's copy and the first run.json
        out, calls = tmp_path / str(last), []

        def replace(self, target, *, last=last, calls=calls):
            original(self, target)
            calls.append(target)
            if len(calls) == last:
                raise Stopped

        monkeypatch.setattr(run_directory.Path, "replace", replace)
        try:
            run(study, out=out)
            if len(calls) < last:
                break
        except Stopped:
            pass  # a stop within a picture costs a note alone
        monkeypatch.setattr(run_directory.Path, "replace", original)
        result = resume(out)
        assert result.sequential.found.count == 4096 and result.sequential.found.reached
        assert {name: (out / name).read_bytes() for name in names} == expected
        assert json.loads((out / "run.json").read_text())["stopped_at"] == 4096
        shutil.rmtree(out)
    assert last >= 15


def test_a_finished_run_gets_just_the_samples_asked_for(tmp_path):
    study = load_study(file(tmp_path, YIELD))
    first = run(study, out=tmp_path / "run").sequential.found
    assert resume(tmp_path / "run").study.samples == 4096
    longer = resume(tmp_path / "run", extend=100)
    assert longer.study.samples == 4196
    assert longer.sequential.found == first
    assert_bitwise_equal(longer.samples, run(study, samples=4196).samples)
    assert resume(tmp_path / "run").study.samples == 4196


def test_a_number_of_samples_takes_the_place_of_until(tmp_path):
    result = run(file(tmp_path, YIELD), samples=500, out=tmp_path / "run")
    assert result.sequential is None and result.study.samples == 500
    assert resume(tmp_path / "run").sequential is None


def test_a_record_that_makes_another_run_sequential_is_refused(tmp_path):
    out = tmp_path / "run"
    run(write(tmp_path, *GEOMETRY), samples=100, out=out)
    record = json.loads((out / "run.json").read_text())
    (out / "run.json").write_text(json.dumps(record | {"most_samples": 200}))
    with pytest.raises(RunDirectoryError, match="most_samples = 200, but the study has no"):
        resume(out)


def test_the_command_says_how_sampling_ended(tmp_path):
    until = 'output = "tilt_angle", statistic = "sd", width = "0.0035 deg"'
    result = CliRunner().invoke(main, ["run", str(file(tmp_path, until)), "--out", str(tmp_path / "run")])
    assert result.exit_code == 0 and not complaints(result.stderr)
    assert "A small study: 4,096 samples" in result.stdout
    assert "Sampling stopped after 4,096 of at most 10,000 samples: the 95 % interval of the standard" in result.stdout
    assert "deviation of Tilt angle ψ is 0.003 deg wide, at most 0.0035 deg was asked for" in result.stdout
    again = CliRunner().invoke(main, ["run", "--resume", str(tmp_path / "run")])
    assert "Sampling stopped after 4,096 of at most 10,000 samples" in again.stdout
