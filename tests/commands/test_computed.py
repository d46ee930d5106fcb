"""A run of which too few samples could be computed says so first, claims nothing of the others and ends with code 4."""

import json

import pandas as pd
import pytest
from click.testing import CliRunner
from small_study import GEOMETRY, write

from tolmc import cli
from tolmc.report import answer, notes
from tolmc.report.write import write_report
from tolmc.statistics.outcomes import CONTACT_LOSS, ENOUGH_COMPUTED, computed_share
from tolmc.statistics.summary import count_statuses, summarise_requirements
from tolmc.text import phrases

pytestmark = pytest.mark.usefixtures("ready_pictures_throughout")

#: Half of the bores are smaller than their journals.
CLASHING = (
    ('bearing_radius = { nominal = "20 mm", tolerance = "0.05 mm" }',
     'bearing_radius = { nominal = "10.2 mm", tolerance = "1 mm", distribution = "uniform" }'),
    ('tilt_angle = { max = "24.4 deg" }', 'tilt_angle = { max = "2 deg" }'),
)  # fmt: skip


@pytest.fixture(scope="module")
def clashing(tmp_path_factory):
    folder = tmp_path_factory.mktemp("clashing")
    study = write(folder, *GEOMETRY, *CLASHING)
    ended = CliRunner().invoke(cli.main, ["run", str(study), "--samples", "640", "--out", str(folder / "run")])
    return folder / "run", ended


def frame(**counts):
    return pd.DataFrame({"status": [status.replace("_", " ") for status, n in counts.items() for _ in range(n)]})


def test_the_run_says_so_first_and_ends_with_its_own_code(clashing):
    directory, ended = clashing
    assert ended.exit_code == 4
    statuses = pd.read_parquet(directory / "samples.parquet")["status"].value_counts()
    known, unknown = statuses["ok"], statuses["geometry invalid"]
    first = ended.stdout.strip().splitlines()[0]
    assert first.startswith(f"Only {100 * known / 640:.3g} % of the samples could be computed, {known} of 640")
    assert f"{unknown} geometry invalid" in first
    assert f"Outputs of the {known} samples that could be computed" in ended.stdout


def test_going_on_with_it_and_its_json_say_it_too(clashing):
    directory, _ = clashing
    ended = CliRunner().invoke(cli.main, ["run", "--resume", str(directory), "--json"])
    assert ended.exit_code == 4
    record = json.loads(ended.stdout)
    assert (
        record["computed_share"] == pytest.approx(record["statuses"]["ok"]["share"]) and record["computed_share"] < 0.9
    )


def test_the_report_says_it_first_and_ends_so(clashing):
    directory, _ = clashing
    ended = CliRunner().invoke(cli.main, ["report", str(directory)])
    assert ended.exit_code == 4 and ended.stdout.startswith("Only ")
    page = (directory / "report.md").read_text(encoding="utf-8")
    headline = next(line for line in page.splitlines() if line.startswith("**"))
    assert headline.startswith("**Only ") and "could be computed" in headline


def test_a_run_of_which_enough_could_be_computed_ends_with_0_and_no_warning(tmp_path):
    study = write(tmp_path, *GEOMETRY)
    ended = CliRunner().invoke(cli.main, ["run", str(study), "--samples", "64", "--out", str(tmp_path / "run")])
    assert ended.exit_code == 0 and "could be computed" not in ended.stdout


@pytest.mark.parametrize(
    ("counts", "warning"),
    [
        ({"ok": 90, "inaccurate": 10}, ""),
        ({"ok": 40, "contact_lost": 50, "inaccurate": 10}, ""),
        ({"ok": 40, "contact_lost": 49, "inaccurate": 6, "diverged": 5}, "Only 89 % of the samples could be computed, 89 of"),
        ({"inaccurate": 100}, "None of the 100 samples could be computed (100 inaccurate)"),
    ],
)  # fmt: skip
def test_a_known_loss_of_contact_is_an_answer(counts, warning):
    statuses = count_statuses(frame(**counts))
    told = phrases.too_few_computed(statuses)
    assert told.startswith(warning) and bool(told) == bool(warning)
    assert (computed_share(statuses) >= ENOUGH_COMPUTED) == (not warning)


@pytest.mark.parametrize("unknown", [0, 1, 3])
@pytest.mark.parametrize("lost", [0, 7])
def test_no_sentence_claims_anything_of_samples_that_are_unknown(unknown, lost):
    samples = frame(ok=90 - lost, contact_lost=lost, inaccurate=unknown)
    shares = summarise_requirements(samples, specification={})
    said = [*answer._contact(shares, True, "stop"), *notes.of_contact(shares, is_watched=True, on_contact_loss="stop")]
    text, total = " ".join(said), 90 + unknown
    assert "no sample" not in text.lower()
    if unknown and not lost:
        assert "In none of the 90 samples that could be computed does the journal leave the wall." in text
    if unknown:
        assert (
            f"{100 * lost / total:.3g} % to {100 * (lost + unknown) / total:.3g} %" in text
            and f"{'1 sample' if unknown == 1 else '3 samples'} could not be computed" in text
        )
        assert f"({unknown} more are unknown)" in phrases.cut_short(0.1, unknown)
    else:
        assert "could be computed" not in text


def test_bounds_that_read_alike_stand_once():
    shares = summarise_requirements(frame(ok=4000, contact_lost=5999, inaccurate=1), specification={})
    assert phrases.share_between(shares.loc[CONTACT_LOSS])[0] == "60 %"


#: A bucket that hangs off its worn pin: chaotic long before its two seconds are over.
BUCKET = (
    ('{ nominal = "20 mm", tolerance = "0.05 mm" }', '{ nominal = "30.9 mm", tolerance = "0.4 mm" }'),
    ('{ nominal = "10 mm", tolerance = ["-0.03 mm", "0 mm"] }', '{ diameter = "60 f7" }'),
    ('{ nominal = "20 mm", tolerance = "0.1 mm", distribution = "uniform" }', '{ nominal = "40 mm" }'),
    ('"0.5 kg"', '"800 kg"'), ('["0 mm", "0 mm", "4 mm"]', '["500 mm", "0 mm", "30 mm"]'),
    ("inertia = [4.08e-4, 4.08e-4, 1.2e-4]", "centroidal_inertia = [120, 120, 100]"),
    ('"-110 deg"', '"-90 deg"'), ('"-50 deg"', '"-90 deg"'), ('alpha_rate = "2 rad/s"\nbeta_rate = "-3 rad/s"', ""),
    ('"80 rad/s"', '"0 rad/s"\nspin = "-60 deg"'), ('"0.1 s"', '"2 s"'),
)  # fmt: skip


@pytest.mark.slow
def test_why_no_step_serves_is_said_on_the_terminal_in_the_record_and_in_the_report(tmp_path):
    out = tmp_path / "run"
    ended = CliRunner().invoke(cli.main, ["run", str(write(tmp_path, *BUCKET)), "--samples", "64", "--out", str(out)])
    assert ended.exit_code == 4 and ended.stdout.strip().startswith("None of the 64 samples could be computed")
    said = json.loads((out / "run.json").read_text(encoding="utf-8"))["pilot"]
    assert said.startswith("The motions become chaotic after t = 0.") and "judged one by one" in said
    assert f"Step: {said}" in ended.stdout
    briefly = CliRunner().invoke(cli.main, ["run", "--resume", str(out), "--brief"])
    assert f"Step: {said}" in briefly.stdout
    write_report(out)  # without the command's answers, for which it would follow thousands of chaotic motions
    page = (out / "report.md").read_text(encoding="utf-8")
    assert said in page.replace("\\", "")  # without the signs that escape Markdown's
