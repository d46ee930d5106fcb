import json
import math
import shutil
from dataclasses import replace

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from frames import assert_bitwise_equal
from places import DATA
from scenes import DIMENSIONS
from small_study import GEOMETRY, write

from tolmc.runs import directory as run_directory
from tolmc.runs import files
from tolmc.runs import run as monte_carlo
from tolmc.runs.record import FORMAT, RunDirectoryError
from tolmc.runs.run import resume, run
from tolmc.simulation.ensemble import simulate_many
from tolmc.study.file import load_study

pytestmark = pytest.mark.usefixtures("ready_pictures")
SAMPLES = 2000
WRITE_BLOCK = run_directory.RunDirectory.write_block


@pytest.fixture(autouse=True)
def _many_blocks(monkeypatch):
    monkeypatch.setattr(monte_carlo, "_LEAST_WORK", 0.0)


@pytest.fixture
def study(tmp_path):
    return load_study(write(tmp_path, *GEOMETRY)).replaced(samples=SAMPLES)


@pytest.fixture
def finished(tmp_path, study):
    run(study, out=tmp_path / "run")
    return tmp_path / "run"


class Stopped(BaseException):
    """As sudden as a kill: nothing but what is on the disk goes on."""


@pytest.fixture
def stopped(tmp_path, study, monkeypatch):
    """A run that was stopped with some of its blocks written."""
    stop_after(monkeypatch, "write_block", 3)
    with pytest.raises(Stopped):
        run(study, out=tmp_path / "stopped")
    monkeypatch.setattr(run_directory.RunDirectory, "write_block", WRITE_BLOCK)
    return tmp_path / "stopped"


def stop_after(monkeypatch, method, count):
    original, calls = getattr(run_directory.RunDirectory, method), []

    def stopping(self, *arguments):
        original(self, *arguments)
        calls.append(arguments)
        if len(calls) == count:
            raise Stopped

    monkeypatch.setattr(run_directory.RunDirectory, method, stopping)


def blocks(directory):
    return sorted((directory / "blocks").glob("*.parquet"))


def change_record(directory, **changes):
    record = json.loads((directory / "run.json").read_text())
    (directory / "run.json").write_text(json.dumps(record | changes))


def test_a_stopped_run_goes_on_and_computes_no_block_twice(study, finished, stopped, monkeypatch):
    assert len(blocks(stopped)) == 3
    written = []
    original = run_directory.RunDirectory.write_block
    monkeypatch.setattr(
        run_directory.RunDirectory,
        "write_block",
        lambda self, start, table: (written.append(start), original(self, start, table)),
    )
    result = resume(stopped)
    assert_bitwise_equal(result.samples, run(study).samples)
    assert (stopped / "samples.parquet").read_bytes() == (finished / "samples.parquet").read_bytes()
    assert (stopped / "summary.csv").read_bytes() == (finished / "summary.csv").read_bytes()
    assert min(written) == 3 * 256
    assert not (stopped / "blocks").exists()


@pytest.mark.slow
def test_whatever_write_is_the_last_one_the_run_ends_the_same(tmp_path, study, finished, monkeypatch):
    expected = {name: (finished / name).read_bytes() for name in ("samples.parquet", "summary.csv", "requirements.csv")}
    original = run_directory.Path.replace
    for before in (True, False):
        for last in range(100):
            out, calls = tmp_path / f"{before}{last}", []

            def replace(self, target, *, before=before, last=last, calls=calls):
                calls.append(target)
                if len(calls) == last + 1 and before:
                    raise Stopped
                original(self, target)
                if len(calls) == last + 1:
                    raise Stopped

            monkeypatch.setattr(run_directory.Path, "replace", replace)
            try:
                run(study, out=out)
                break
            except Stopped:
                monkeypatch.setattr(run_directory.Path, "replace", original)
            if (out / "run.json").exists():
                resume(out)
            else:
                run(study, out=out)
            assert {name: (out / name).read_bytes() for name in expected} == expected
            assert json.loads((out / "run.json").read_text())["state"] == "complete"
            shutil.rmtree(out)
        assert last > 10


@pytest.mark.parametrize("sampling", ["random", "sobol"])
def test_extend_adds_samples_to_a_finished_run(tmp_path, sampling):
    study = load_study(write(tmp_path, ('"sobol"', f'"{sampling}"'), *GEOMETRY)).replaced(samples=1000)
    run(study, out=tmp_path / "run")
    first = resume(tmp_path / "run", extend=700)
    second = resume(tmp_path / "run", extend=1)
    assert first.study.samples == 1700
    assert_bitwise_equal(second.samples, run(study.replaced(samples=1701)).samples)
    assert second.summary.loc["tilt_angle", "samples"] == 1701


def test_an_extension_that_was_stopped_goes_on(tmp_path, study, finished, monkeypatch):
    stop_after(monkeypatch, "write_block", 2)
    with pytest.raises(Stopped):
        resume(finished, extend=1000)
    monkeypatch.setattr(run_directory.RunDirectory, "write_block", WRITE_BLOCK)
    with pytest.raises(RunDirectoryError, match="finish it first"):
        resume(finished, extend=5)
    assert_bitwise_equal(resume(finished).samples, run(study.replaced(samples=SAMPLES + 1000)).samples)


def test_a_latin_hypercube_cannot_be_extended(tmp_path):
    study = load_study(write(tmp_path, ('"sobol"', '"latin_hypercube"'), *GEOMETRY))
    run(study, out=tmp_path / "run")
    with pytest.raises(RunDirectoryError, match="Latin hypercube"):
        resume(tmp_path / "run", extend=10)


def test_resuming_a_finished_run_changes_nothing(finished):
    before = (finished / "samples.parquet").read_bytes()
    result = resume(finished)
    assert len(result.samples) == SAMPLES
    assert (finished / "samples.parquet").read_bytes() == before


def test_two_runs_cannot_share_a_directory(study, stopped):
    with run_directory.reopen(stopped), pytest.raises(RunDirectoryError, match="in use by another run"):
        resume(stopped)
    assert resume(stopped).study.samples == SAMPLES


def test_a_changed_study_is_refused(tmp_path, study, stopped):
    other = write(tmp_path, *GEOMETRY, ('"0.5 kg"', '"0.6 kg"'), name="other.toml")
    with pytest.raises(RunDirectoryError, match="another study"):
        resume(stopped, study=other)
    assert resume(stopped, study=tmp_path / "small.toml").study.samples == SAMPLES
    shutil.copy(other, stopped / "study.toml")
    with pytest.raises(RunDirectoryError, match=r"study\.toml has changed"):
        resume(stopped)
    (stopped / "study.toml").write_text("title = ")
    with pytest.raises(RunDirectoryError, match="damaged"):
        resume(stopped)


def test_changed_measurements_are_refused(tmp_path):
    (tmp_path / "rings.csv").write_text("d\n39.98\n40.01\n40.02\n")
    table = '{ data = "rings.csv", column = "d", unit = "0.5 mm" }'
    path = write(tmp_path, ('{ nominal = "20 mm", tolerance = "0.05 mm" }', table), *GEOMETRY)
    run(path, out=tmp_path / "run")
    (tmp_path / "rings.csv").write_text("d\n39.90\n40.01\n40.02\n")
    assert resume(tmp_path / "run").samples["bearing_radius"].min() < 0.019991  # the run has its own copy
    with pytest.raises(RunDirectoryError, match="another study"):
        resume(tmp_path / "run", study=path)
    (tmp_path / "run" / "data" / "rings.csv").write_text("d\n39.90\n40.01\n40.02\n")
    with pytest.raises(RunDirectoryError, match="changed"):
        resume(tmp_path / "run")


def truncate(path):
    path.write_bytes(path.read_bytes()[:-100])


def flip_a_byte(path):
    content = bytearray(path.read_bytes())
    content[len(content) // 3] ^= 1
    path.write_bytes(content)


def empty(path):
    path.write_bytes(b"")


@pytest.mark.parametrize("damage", [truncate, flip_a_byte, empty])
def test_a_damaged_block_is_refused_and_can_be_computed_again(study, stopped, damage):
    block = blocks(stopped)[1]
    damage(block)
    with pytest.raises(RunDirectoryError, match=f"{block.name} is truncated or foreign.*Delete it and resume"):
        resume(stopped)
    block.unlink()
    assert_bitwise_equal(resume(stopped).samples, run(study).samples)


@pytest.mark.parametrize("damage", [truncate, flip_a_byte, empty])
def test_damaged_samples_are_refused(finished, damage):
    damage(finished / "samples.parquet")
    with pytest.raises(RunDirectoryError, match=r"samples\.parquet is truncated or foreign"):
        resume(finished)


def test_foreign_blocks_are_refused(tmp_path, study, stopped, monkeypatch):
    stop_after(monkeypatch, "write_block", 3)
    with pytest.raises(Stopped):
        run(study, seed=99, out=tmp_path / "foreign")
    monkeypatch.setattr(run_directory.RunDirectory, "write_block", WRITE_BLOCK)
    first, second, *_ = blocks(stopped)
    own = first.read_bytes()
    shutil.copy(blocks(tmp_path / "foreign")[0], first)
    with pytest.raises(RunDirectoryError, match="another run"):
        resume(stopped)
    shutil.copy(second, first)  # this run's, but of other samples
    with pytest.raises(RunDirectoryError, match="another run"):
        resume(stopped)
    first.write_bytes(own)
    change_record(stopped, block=512)
    with pytest.raises(RunDirectoryError, match="512 are expected"):
        resume(stopped)


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (None, "no run directory"),
        ("", "cannot be read"),
        ("[" * 100_000, "cannot be read"),
        ("[1]", "not written by tolmc"),
        ('{"format": "x"}', "not written by tolmc"),
        (f'{{"format": {FORMAT + 1}}}', "Update tolmc"),
        (f'{{"format": {FORMAT}}}', "title is missing"),
    ],
)
def test_what_is_no_run_directory_is_refused(tmp_path, content, complaint):
    if content is not None:
        (tmp_path / "run.json").write_text(content)
    with pytest.raises(RunDirectoryError, match=complaint):
        resume(tmp_path)
    with pytest.raises(RunDirectoryError, match="no run directory"):
        resume(tmp_path / "absent")


def test_a_full_disk_leaves_a_run_that_goes_on(tmp_path, study, monkeypatch):
    original, calls = run_directory.pq.ParquetWriter.write_table, []

    def full(self, *arguments, **options):
        calls.append(arguments)
        if len(calls) == 5:
            raise OSError(28, "No space left on device")
        return original(self, *arguments, **options)

    monkeypatch.setattr(run_directory.pq.ParquetWriter, "write_table", full)
    with pytest.raises(OSError, match="No space left") as error:
        run(study, out=tmp_path / "run")
    assert f"tolmc run --resume {tmp_path / 'run'}" in error.value.__notes__[0]
    assert not list((tmp_path / "run").rglob(".partial*"))
    monkeypatch.setattr(run_directory.pq.ParquetWriter, "write_table", original)
    assert_bitwise_equal(resume(tmp_path / "run").samples, run(study).samples)


def test_a_plan_once_made_holds(tmp_path, monkeypatch):
    """A run goes on with the steps that its record says, not with those that a new pilot would choose."""
    study, out = load_study(write(tmp_path)).replaced(samples=600), tmp_path / "run"
    stop_after(monkeypatch, "write_block", 1)
    with pytest.raises(Stopped):
        run(study, out=out)
    monkeypatch.setattr(run_directory.RunDirectory, "write_block", WRITE_BLOCK)
    plan = run_directory.read(out).record["plan"]
    change_record(out, plan=plan | {"steps": 2 * plan["steps"]})
    result, begun = resume(out), run(study)
    # As text: fields that are not a number are equal to themselves in no Python from 3.13 on.
    assert str(result.plan) == str(replace(begun.plan, steps=2 * plan["steps"]))
    assert_bitwise_equal(result.samples.iloc[:256], begun.samples.iloc[:256])
    rest = result.samples.iloc[256:].reset_index(drop=True)
    dimensions = {name: rest[name].to_numpy() for name in DIMENSIONS}
    expected = simulate_many(study.scene, **dimensions, plan=result.plan)
    assert_bitwise_equal(rest, expected)
    assert not rest["contact_force_D_max"].isin(begun.samples["contact_force_D_max"]).any()


def test_reading_parts(finished, study):
    directory = run_directory.read(finished)
    everything = run(study).samples
    for rows in (0, 1, 255, 256, 257, 1999, 2000, 5000):
        table = directory.read(["tilt_angle"], rows)
        np.testing.assert_array_equal(table["tilt_angle"], everything["tilt_angle"].iloc[:rows])
    for index in (0, 255, 256, 1999):
        assert directory.row(index)["tilt_angle"] == everything["tilt_angle"].iloc[index]


def test_rows_of_an_unfinished_run(stopped, study):
    directory = run_directory.read(stopped)
    assert directory.row(700)["tilt_angle"] == run(study).samples["tilt_angle"].iloc[700]
    with pytest.raises(RunDirectoryError, match="as far as they are computed"):
        directory.row(800)


def test_row_groups_have_one_size_whatever_the_blocks(tmp_path, study, monkeypatch):
    monkeypatch.setattr(files, "ROW_GROUP", 600)
    whole = run(study, out=tmp_path / "run").samples
    file = pq.ParquetFile(tmp_path / "run" / "samples.parquet")
    assert [file.metadata.row_group(group).num_rows for group in range(file.num_row_groups)] == [600, 600, 600, 200]
    read = run_directory.read(tmp_path / "run")
    assert [read.row(index)["tilt_angle"] for index in (0, 599, 600, 1999)] == list(
        whole["tilt_angle"][[0, 599, 600, 1999]]
    )
    assert_bitwise_equal(read.read(rows=601).to_pandas(), whole.head(601))
    assert file.schema_arrow.field("status").type.value_type == "string"


def test_a_run_of_format_1_can_be_read_and_extended(tmp_path):
    shutil.copytree(DATA / "run_format_1", tmp_path / "run")
    before = pd.read_parquet(tmp_path / "run" / "samples.parquet")
    assert len(resume(tmp_path / "run").samples) == 20
    result = resume(tmp_path / "run", extend=10)
    assert_bitwise_equal(result.samples.iloc[:20], before)
    fresh = run(tmp_path / "run" / "study.toml", samples=30).samples
    np.testing.assert_allclose(result.samples["tilt_angle"], fresh["tilt_angle"], rtol=1e-14)


def test_a_run_with_other_columns_is_not_mixed_with_this_version(finished):
    samples = pq.read_table(finished / "samples.parquet")
    old = samples.drop_columns("effective_radius")
    pq.write_table(old, finished / "samples.parquet")
    before = (finished / "samples.parquet").read_bytes()
    with pytest.raises(RunDirectoryError, match=r"other columns \(effective_radius\).*Go on with that version"):
        resume(finished, extend=10)
    assert (finished / "samples.parquet").read_bytes() == before


def test_a_plan_of_another_version_is_refused(stopped):
    plan = json.loads((stopped / "run.json").read_text())["plan"]
    change_record(stopped, plan=plan | {"cleverness": 7})
    with pytest.raises(RunDirectoryError, match="cleverness"):
        resume(stopped)


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"block": 0}, "block = 0"),
        ({"block": True}, "block = true"),
        ({"samples": 0}, "samples = 0"),
        ({"samples": "20"}, "samples = '20'"),
        ({"seed": -1}, "seed = -1"),
        ({"sampling": "sobl"}, "sampling = 'sobl'"),
        ({"state": "over"}, "state = 'over'"),
        ({"study_sha256": "x"}, "study_sha256 = 'x'"),
        ({"versions": {"tolmc": 1}}, "versions.tolmc = 1"),
        ({"plan": None}, "plan = None"),
    ],
)
def test_a_damaged_record_is_refused(stopped, changes, complaint):
    change_record(stopped, **changes)
    with pytest.raises(RunDirectoryError, match=rf"run\.json is damaged: {complaint}: .*Restore it"):
        resume(stopped)


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"steps": "x"}, "plan.steps = 'x'"),
        ({"steps": 0}, "plan.steps = 0"),
        ({"accuracy": None}, "plan.accuracy = None"),
        ({"accuracy": "Infinity"}, "plan.accuracy = 'Infinity'"),
        ({"method": "rk9"}, "plan.method = 'rk9'"),
        ({"formulation": 3}, "plan.formulation = 3"),
        ({"pilot_error": -1.0}, "plan.pilot_error = -1.0"),
        ({"features": {"exact": "no"}}, "plan.features.exact = 'no'"),
        ({"halving": 1}, "plan.halving = 1"),
    ],
)
def test_a_damaged_plan_is_refused(stopped, changes, complaint):
    change_record(stopped, plan=json.loads((stopped / "run.json").read_text())["plan"] | changes)
    with pytest.raises(RunDirectoryError, match=rf"run\.json is damaged: {complaint}: "):
        resume(stopped)


@pytest.mark.parametrize("pilot_error", [1e-9, math.inf, math.nan])
def test_a_plan_survives_its_record(tmp_path, study, pilot_error):
    plan = replace(run(study).plan, pilot_error=pilot_error, growth=math.nan if math.isnan(pilot_error) else 3.5)
    with run_directory.create(tmp_path / "run", study, block=256, plan=monte_carlo._record_of(plan)):
        pass

    def refuse(constant):
        raise AssertionError(f"{constant} is no JSON")

    json.loads((tmp_path / "run" / "run.json").read_text(), parse_constant=refuse)
    read = monte_carlo._recorded_plan(run_directory.read(tmp_path / "run"))
    assert repr(read) == repr(plan)


def test_an_infinite_error_that_python_wrote_is_still_read(stopped, study):
    plan = json.loads((stopped / "run.json").read_text())["plan"]
    change_record(stopped, plan=plan | {"pilot_error": math.inf})
    assert "Infinity," in (stopped / "run.json").read_text().replace("}", ",")
    assert resume(stopped).plan.pilot_error == math.inf


def test_a_run_is_not_extended_past_the_largest_number(finished):
    before = (finished / "run.json").read_text()
    with pytest.raises(RunDirectoryError, match="allowed: at most 1000000000"):
        resume(finished, extend=10**9)
    assert (finished / "run.json").read_text() == before
