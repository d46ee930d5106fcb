"""Of a run that loses contact some samples are followed through flight and impacts: the same ones always, and kept."""

import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pyarrow as pa
import pytest
from click.testing import CliRunner
from small_study import write

from tolmc import cli
from tolmc.runs.contact_law import CONTACT_LAW, contact_law_subset
from tolmc.runs.exact_subset import EXACT_SECTION
from tolmc.runs.run import resume, run
from tolmc.simulation.plan import Plan
from tolmc.study.file import load_study

pytestmark = pytest.mark.usefixtures("ready_pictures_throughout")

#: A whirl fast enough for some of the parts to leave the wall; the step is given, so that any run of it has the same.
LOSES = (
    ('alpha_rate = "2 rad/s"', 'alpha_rate = "14 rad/s"'), ('beta_rate = "-3 rad/s"', 'beta_rate = "-12 rad/s"'),
    ('tolerance = "0.05 mm"', 'tolerance = "0.5 mm"'), ('"0.1 s"', '"0.3 s"'),
    ("[monte_carlo]", '[monte_carlo]\nstep = "4 ms"'), ('max = "24.4 deg"', 'max = "40 deg"'),
    ('contact_force_D_max = { max = "4.5 N" }', 'contact_force_D_max = { max = "12 N" }'),
)  # fmt: skip
SAMPLES = 512


def followed(restitution):
    return ("[monte_carlo]", f"[contact]\nrestitution = {restitution}\n[monte_carlo]")


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = tmp_path_factory.mktemp("law")
    return folder, run(write(folder, *LOSES), samples=SAMPLES, out=folder / "run")


@pytest.mark.parametrize("restitution", [0.0, 0.5])
def test_the_samples_are_those_of_a_run_with_that_restitution(finished, restitution, tmp_path):
    folder, _ = finished
    kept = pd.read_parquet(folder / "run" / CONTACT_LAW)
    kept = kept[kept["restitution"] == restitution].drop(columns="restitution").reset_index(drop=True)
    assert len(kept) % 16 == 0 and len(kept) >= 64
    alone = run(write(tmp_path, *LOSES, followed(restitution)), samples=len(kept)).samples
    assert kept["impacts_D"].sum() > 0
    pd.testing.assert_frame_equal(
        kept[list(alone)], alone, check_exact=True, check_categorical=False, check_dtype=False
    )


@pytest.mark.slow
def test_they_are_the_same_bits_for_any_workers_and_after_extension(finished):
    folder, result = finished
    resumed = run(folder / "small.toml", samples=SAMPLES - 128, workers=1, out=folder / "again")
    assert not resumed.requirements.equals(result.requirements)
    longer = resume(folder / "again", extend=128)
    pd.testing.assert_frame_equal(longer.requirements, result.requirements, check_exact=True)
    pd.testing.assert_frame_equal(longer.summary, result.summary, check_exact=True)
    kept = [pd.read_parquet(folder / name / CONTACT_LAW) for name in ("again", "run")]
    pd.testing.assert_frame_equal(*kept, check_exact=True)


def test_the_differences_are_those_of_the_samples(finished):
    folder, result = finished
    kept = pd.read_parquet(folder / "run" / CONTACT_LAW)
    for restitution in (0.0, 0.5):
        law = kept[kept["restitution"] == restitution].reset_index(drop=True)
        own = result.samples.iloc[: len(law)]
        good = own["status"].isin(["ok", "contact lost"]) & law["status"].isin(["ok", "contact lost"])
        expected = own.loc[good, "contact_force_E_rms"].mean() - law.loc[good, "contact_force_E_rms"].mean()
        row = result.summary.loc["contact_force_E_rms"]
        assert row[f"restitution_{restitution:g}_mean"] == pytest.approx(expected, rel=1e-9)
        assert row[f"restitution_{restitution:g}_mean_low"] < expected < row[f"restitution_{restitution:g}_mean_high"]


@pytest.mark.slow
def test_a_verdict_that_the_loss_leaves_open_is_told_where_the_number_is(finished, tmp_path):
    folder, result = finished
    row = result.requirements.loc["contact_force_D_max"]
    assert row["contact_law_turns_target"]
    ends = f"not decided: the contact law matters (ends at the loss 0 % to {100 * row['share_most']:.3g} %"
    assert row["contact_law"].startswith(ends)
    assert "restitution 0: 0 %" in row["contact_law"] and "0.5: 0 %" in row["contact_law"]
    for name, index in (("requirements.csv", "requirement"), ("summary.csv", "output")):
        table = pd.read_csv(folder / "run" / name).set_index(index)
        assert table.at["contact_force_D_max", "contact_law"] == row["contact_law"]
    ended = CliRunner().invoke(
        cli.main, ["run", str(folder / "small.toml"), "--samples", str(SAMPLES), "--out", str(tmp_path / "r")]
    )
    assert ended.exit_code == 0 and "the contact law matters (" in ended.stdout
    assert "Contact law: as run less followed through impacts" in ended.stdout
    assert CliRunner().invoke(cli.main, ["report", str(folder / "run")]).exit_code == 0
    page = (folder / "run" / "report.md").read_text(encoding="utf-8")
    assert "the contact law matters (ends at the loss" in page and "give \\[contact\\] restitution" in page
    assert "followed through flight and impacts" in page and (folder / "run" / "tables" / "contact_law.csv").exists()


def test_a_verdict_that_a_law_turns_is_told(finished, tmp_path):
    """Samples that end at the loss keep the limit; followed, some of them break it."""
    changes = [pair for pair in LOSES if "12 N" not in pair[1]]
    ends = ("[monte_carlo]", '[monte_carlo]\non_contact_loss = "end"')
    limit = ('contact_force_D_max = { max = "4.5 N" }', 'contact_force_D_rms = { max = "3.345 N" }\ntarget = "98 %"')
    found = run(write(tmp_path, *changes, ends, limit), samples=SAMPLES).requirements.loc["contact_force_D_rms"]
    assert found["share_most"] == 0 and found["share_most_high"] < 0.02  # met, were it for the run alone
    kept = pd.read_parquet(finished[0] / "run" / CONTACT_LAW)
    shares = (kept["contact_force_D_rms"] > 3.345).groupby(kept["restitution"]).mean()
    assert min(shares) > 0 and found["contact_law_turns_target"]
    said = f"ends at the loss 0 %, restitution 0: {100 * shares[0.0]:.3g} %, 0.5: {100 * shares[0.5]:.3g} %"
    assert found["contact_law"] == f"not decided: the contact law matters ({said})"
    assert found["restitution_0.5_difference"] == pytest.approx(-shares[0.5])


@pytest.mark.parametrize("section", ["", '[model]\nsection = "exact"\n'])
def test_the_terms_can_be_left_out(tmp_path, section):
    study = write(tmp_path, *LOSES, ("[monte_carlo]", f"{section}[monte_carlo]\nmodel_error = false"))
    result = run(study, samples=64, out=tmp_path / "run")
    assert not any(name.startswith(("section", "restitution", "contact_law")) for name in result.requirements)
    assert not (tmp_path / "run" / CONTACT_LAW).exists() and not (tmp_path / "run" / EXACT_SECTION).exists()


def test_where_no_sample_loses_contact_nothing_is_followed(tmp_path):
    result = run(write(tmp_path), samples=64, out=tmp_path / "run")
    assert "contact_law" not in result.requirements and not (tmp_path / "run" / CONTACT_LAW).exists()


class Crew:
    size = 1

    def map(self, function, calls):
        return (function(*call) for call in calls)


@pytest.mark.parametrize(
    ("impacts", "samples", "size"),
    [(0, 1_000_000, 1024), (0, 100_000, 496), (50, 10_000, 128), (500, 10_000, 64), (100_000, 100_000, 16)],
)
def test_the_size_follows_from_the_work(tmp_path, impacts, samples, size):
    """A fiftieth of the run's steps or a tenth of a second, at most five times as much for 64, 16 whatever they cost."""

    def compute(study, plan, start, count):
        assert plan.features.one_sided and not plan.halving and study.on_contact_loss == "follow"
        hits = pa.array(np.full(count, float(impacts)))
        return pa.table({"row": np.arange(start, start + count), "impacts_D": hits, "impacts_E": hits})

    study = load_study(write(tmp_path)).replaced(samples=samples)
    table = contact_law_subset(study, Plan("slope", "rk8", 500, 1e-8), Crew(), compute)
    assert table["row"].to_pylist() == [*range(size)] * 2
    assert table["restitution"].to_pylist() == [0.0] * size + [0.5] * size


def test_a_body_that_cannot_fly_is_not_followed(tmp_path):
    study = load_study(write(tmp_path)).replaced(samples=64)
    rod = replace(study.scene.body, inertia=np.diag([0.5 * 0.004**2, 0.5 * 0.004**2, 0.0]))
    study = replace(study, scene=replace(study.scene, body=rod))
    assert contact_law_subset(study, Plan("slope", "rk8", 20, 1e-8), Crew(), lambda *_: None) is None


def test_json_has_them(finished, tmp_path):
    folder, _ = finished
    ended = CliRunner().invoke(cli.main, ["run", "--resume", str(folder / "run"), "--json"])
    found = json.loads(ended.stdout)["requirements"]["contact_force_D_max"]
    assert found["contact_law_turns_target"] is True and "restitution_0.5_difference" in found
