"""Beside a run on the circle some of its samples run on the exact section: the same ones always, and what they say is kept."""

from dataclasses import replace

import pandas as pd
import pytest
from click.testing import CliRunner
from small_study import GEOMETRY, write

from tolmc import cli
from tolmc.runs.exact_subset import EXACT_SECTION, subset_size
from tolmc.runs.run import resume, run
from tolmc.simulation.plan import Plan
from tolmc.study.file import load_study

pytestmark = pytest.mark.usefixtures("ready_pictures_throughout")

#: Between the forces on the circle, 3.042 to 3.055 N, and those on the exact section, a fiftieth less.
LIMIT = ('contact_force_D_max = { max = "4.5 N" }', 'contact_force_D_max = { max = "3.0 N" }')
WIDE = ('tilt_angle = { max = "24.4 deg" }', 'tilt_angle = { max = "26 deg" }')


def test_the_size_depends_on_the_study_alone_and_costs_a_fiftieth(tmp_path):
    study = load_study(write(tmp_path))
    long = Plan("slope", "rk8", 10_000, 1e-8)
    for samples in (1000, 10_000, 50_000, 100_000, 1_000_000):
        size = subset_size(study.replaced(samples=samples), long)
        assert size % 16 == 0 and (size == 16 or 1.5 * size <= 0.02 * samples or size == 1024)
    assert subset_size(study.replaced(samples=1_000_000), long) == 1024
    assert subset_size(study.replaced(samples=5), long) == 0
    short = replace(long, steps=20)
    assert subset_size(study.replaced(samples=2000), short) == 1024  # a hundredth of a second


def test_what_says_nothing_new_costs_nothing(tmp_path):
    plan = Plan("slope", "rk8", 20, 1e-8)
    exact = write(tmp_path, ("[monte_carlo]", '[model]\nsection = "exact"\n[monte_carlo]'))
    assert subset_size(load_study(exact), plan) == 0
    assert subset_size(load_study(write(tmp_path, *GEOMETRY)), plan) == 0
    result = run(write(tmp_path, *GEOMETRY), samples=64, out=tmp_path / "run")
    assert "section" not in result.requirements and not (tmp_path / "run" / EXACT_SECTION).exists()


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = tmp_path_factory.mktemp("exact")
    return folder, run(write(folder, LIMIT, WIDE), samples=1500, out=folder / "run")


def test_the_samples_are_those_of_a_run_on_the_exact_section(finished):
    folder, _ = finished
    exact = write(
        folder, LIMIT, WIDE, ("[monte_carlo]", '[model]\nsection = "exact"\n[monte_carlo]'), name="exact.toml"
    )
    kept = pd.read_parquet(folder / "run" / EXACT_SECTION)
    alone = run(exact, samples=len(kept)).samples
    inputs = ["bearing_radius", "journal_radius", "half_length"]
    pd.testing.assert_frame_equal(kept[inputs], alone[inputs])
    forces = [name for name in kept if name.startswith("contact_force")]
    pd.testing.assert_frame_equal(kept[forces], alone[forces], rtol=1e-6, atol=1e-6)


@pytest.mark.slow
def test_they_are_the_same_bits_for_any_workers_and_after_extension(finished):
    folder, result = finished
    again = run(folder / "small.toml", samples=1500, workers=1, out=folder / "again")
    pd.testing.assert_frame_equal(again.requirements, result.requirements, check_exact=True)
    pd.testing.assert_frame_equal(again.summary, result.summary, check_exact=True)
    longer = resume(folder / "again", extend=700)
    whole = run(folder / "small.toml", samples=2200, out=folder / "whole")
    pd.testing.assert_frame_equal(longer.requirements, whole.requirements, check_exact=True)
    in_memory = run(folder / "small.toml", samples=2200)
    pd.testing.assert_frame_equal(longer.summary, in_memory.summary, check_exact=True)
    kept = [pd.read_parquet(folder / name / EXACT_SECTION) for name in ("again", "whole")]
    pd.testing.assert_frame_equal(*kept, check_exact=True)


@pytest.mark.slow
def test_a_verdict_that_the_section_turns_is_told_where_the_number_is(finished, tmp_path):
    folder, result = finished
    row = result.requirements.loc["contact_force_D_max"]
    low, high = row["share_most"], row["exact_least"]
    exact = run(
        write(tmp_path, LIMIT, WIDE, ("[monte_carlo]", '[model]\nsection = "exact"\n[monte_carlo]')), samples=1500
    ).requirements.loc["contact_force_D_max", "share_most"]
    assert row["exact_most_low"] <= exact <= row["exact_most_high"]
    assert low != pytest.approx(high, abs=0.2)
    told = f"not decided: the section matters (circle {100 * low:.3g} %, exact {100 * high:.3g} %)"
    assert row["section"] == told
    for name in ("requirements.csv", "summary.csv"):
        assert pd.read_csv(folder / "run" / name).set_index(
            "requirement" if name[0] == "r" else "output").at["contact_force_D_max", "section"] == told  # fmt: skip
    shown = CliRunner().invoke(
        cli.main, ["run", str(folder / "small.toml"), "--samples", "1500", "--out", str(tmp_path / "r")]
    )
    assert told in shown.stdout and "circle − exact, mean" in shown.stdout
    assert CliRunner().invoke(cli.main, ["report", str(folder / "run")]).exit_code == 0
    page = (folder / "run" / "report.md").read_text(encoding="utf-8")
    assert told in page and "**Not decided: the section matters" in page


def test_one_sided_contact_is_left_to_a_run_of_its_own(tmp_path):
    study = load_study(write(tmp_path))
    plan = Plan("slope", "rk8", 20, 1e-8)
    assert subset_size(study, plan) > 0
    assert subset_size(study, replace(plan, features=replace(plan.features, one_sided=True))) == 0
