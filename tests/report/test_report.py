"""Tests of the report: what it says agrees with the run, stands on its own, and is honest about what it lacks."""

import base64
import html
import io
import json
import math
import re
import shutil
import tomllib
from html.parser import HTMLParser
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from PIL import Image
from places import STUDIES
from read_numbers import numbers_in
from ready_pictures import pictures_at_hand

from tolmc import quantities
from tolmc.analysis.linear import linearise
from tolmc.analysis.one_at_a_time import one_at_a_time
from tolmc.analysis.side_by_side import side_by_side
from tolmc.analysis.sobol import sobol_indices
from tolmc.analysis.worst_case import worst_case
from tolmc.cli import main
from tolmc.commands.answers import write_answers
from tolmc.errors import InputError
from tolmc.mechanism import geometry
from tolmc.report import answer
from tolmc.report.write import write_report
from tolmc.runs import directory as run_directory
from tolmc.runs import run as monte_carlo
from tolmc.runs.record import RunDirectoryError
from tolmc.statistics.capability import capability
from tolmc.statistics.intervals import Estimate
from tolmc.statistics.outcomes import ANY_REQUIREMENT, CONTACT_LOSS
from tolmc.statistics.rows import Rows
from tolmc.statistics.summary import summarise_requirements
from tolmc.text import phrases, typeset

pytestmark = pytest.mark.usefixtures("ready_pictures")  # but in the paper's joint, which all tests share

JOINT = STUDIES / "paper_joint.toml"

HOSTILE = 'Bearing "A|B" </style><script>alert(1)</script> \\\\ `50 %` N_D'
GEOMETRY = """
[dimensions]
bearing_radius = { nominal = "20 mm", tolerance = "0.05 mm" }
journal_radius = { nominal = "19.8 mm", tolerance = ["-0.03 mm", "0 mm"] }
half_length = "20 mm"
[body]
mass = 1
inertia = [1e-3, 1e-3, 1e-3]
[motion]
alpha = 0
beta = 1
duration = 1
[monte_carlo]
samples = 320
sampling = "random"
outputs = ["tilt_angle", "effective_radius"]
"""


def run_study(folder: Path, text: str, **options) -> Path:
    (folder / "study.toml").write_text(text, encoding="utf-8")
    monte_carlo.run(folder / "study.toml", out=folder / "run", workers=1, **options)
    return folder / "run"


@pytest.fixture(scope="module")
def directory(tmp_path_factory):
    """The paper's joint, with its report."""
    out = tmp_path_factory.mktemp("paper") / "run"
    monte_carlo.run(JOINT, samples=512, workers=1, out=out)
    write_report(out)
    return out


@pytest.fixture(scope="module")
def geometry_once(tmp_path_factory):
    with pictures_at_hand():
        return run_study(tmp_path_factory.mktemp("geometry"), GEOMETRY)


@pytest.fixture
def geometry_run(geometry_once, tmp_path):
    return shutil.copytree(geometry_once, tmp_path / "run")


def page_of(directory: Path) -> str:
    return (directory / "report.html").read_bytes().decode("utf-8")


def text_of(page: str) -> str:
    """The page as it is read: no tags, no style sheet, single spaces."""
    page = re.sub("<style>.*?</style>", "", page, flags=re.DOTALL)
    page = re.sub("<i>N</i><sub>([DE])</sub>", r"N_\1", page)
    return " ".join(html.unescape(re.sub("<[^>]*>", " ", page)).split())


class Page(HTMLParser):
    """Checks that tags are balanced, and keeps what refers to something else."""

    VOID = ("meta", "img", "br", "line", "circle", "rect", "path", "polyline")

    def __init__(self, page: str) -> None:
        super().__init__(convert_charrefs=True)
        self.open, self.tags, self.references, self.styles = [], [], [], []
        self.feed(page)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        self.references += [
            value for name, value in attributes if name in ("src", "href", "srcset", "xlink:href", "data")
        ]
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.tags.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] == "style":
            self.styles.append(data)


def assert_stands_alone(page: str) -> None:
    parsed = Page(page)
    assert all(reference.startswith("data:image/png;base64,") for reference in parsed.references)
    assert not {"script", "link", "iframe", "object", "base"} & set(parsed.tags)
    sheet = "".join(parsed.styles)
    assert not re.search(r"@import|https?:|url\((?!#)", sheet)
    assert not re.search(r"""=\s*["']\s*(https?:)?//""", page)


def markdown_table(directory: Path, heading: str) -> pd.DataFrame:
    """The first table below a heading of report.md, as texts."""
    text = (directory / "report.md").read_text(encoding="utf-8")
    lines = text.split(f"\n{heading}\n", 1)[1].splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith("|"))
    stop = next(i for i in range(start, len(lines)) if not lines[i].startswith("|"))
    rows = [[cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in lines[start:stop]]
    assert {len(row) for row in rows} == {len(rows[0])}
    assert all(re.fullmatch(r":--|--:", cell) for cell in rows[1])
    plain = [[re.sub(r"\\(.)", r"\1", cell) for cell in row] for row in rows]
    return pd.DataFrame(plain[2:], columns=plain[0])


class TestPage:
    def test_stands_alone(self, directory):
        page = page_of(directory)
        assert page.startswith("<!DOCTYPE html>") and '<meta charset="utf-8">' in page
        assert Page(page).tags.count("h1") == 1
        assert_stands_alone(page)

    def test_names_every_requirement_with_its_interval(self, directory):
        table = markdown_table(directory, "**No, the tolerances are not good enough.**").set_index("Requirement")
        samples = pd.read_parquet(directory / "samples.parquet")
        out = {
            "Tilt angle ψ": samples["tilt_angle"] > math.radians(24.45),
            "Contact force N_D, max": samples["contact_force_D_max"] > 5.085,
        }
        out["All requirements"] = np.logical_or(*out.values())
        assert list(table.index) == list(out)
        assert list(table["limits"]) == ["≤ 24.45 deg", "≤ 5.085 N", ""]
        tilt, *of_motion = table["verdict"]
        assert tilt == "not met"
        for verdict, name in zip(of_motion, list(out)[1:], strict=True):
            share_out = f"{100 * out[name].mean():.3g} %"
            assert verdict == f"not decided: the section matters (circle {share_out}, exact 100 %)"
        for name, broken in out.items():
            row, count = table.loc[name], int(broken.sum())
            assert int(row["parts out"]) == count > 0
            share = Rows("sobol").share(broken)
            kept, low, high = numbers_in(row["yield"])
            assert kept == pytest.approx(100 * (1 - count / 512), abs=0.06)
            assert (low, high) == pytest.approx((100 * (1 - share.high), 100 * (1 - share.low)), abs=0.06)
            millionths = numbers_in(row["parts per million out"])
            assert millionths == pytest.approx([1e6 * count / 512, 1e6 * share.low, 1e6 * share.high], abs=501)
        read = re.sub("[()]", "", text_of(page_of(directory)))
        for name, row in table.iterrows():
            line = re.sub("[()]", "", " ".join([name, *row]))  # the page has small print where Markdown has brackets
            assert line.replace("  ", " ") in read

    def test_answers_first(self, directory):
        page = page_of(directory)
        answer = text_of(page[page.index('<section class="answer') : page.index("<h2>")])
        assert answer.startswith(
            "Do parts made to the limits of bearing radius R*, journal radius r* and half length L keep"
        )
        assert "No, the tolerances are not good enough." in answer
        assert (
            "The half length L matters most: it makes 94 % of the variance of the largest contact force N_D" in answer
        )
        assert re.search(r"99.73 % are asked for.*lie in the lowest quarter of the half length L", answer)
        assert 'section = "exact"' in answer

    def test_shows_tolerances_as_a_drawing_does(self, directory):
        table = markdown_table(directory, "## Dimensions and tolerances").set_index("Dimension")
        assert list(table["on the drawing"]) == ["⌀40 ±0.1", "⌀20 0/−0.06", "40 ±0.2"]
        assert list(table["in the model"]) == ["20 ±0.05", "10 0/−0.03", "20 ±0.1"]
        assert list(table["limits"]) == ["19.95 to 20.05", "9.97 to 10.00", "19.9 to 20.1"]
        assert table["distribution of the parts"].iloc[2] == "uniform"

    def test_holds_the_study_the_versions_and_the_commands(self, directory):
        page = page_of(directory)
        blocks = [html.unescape(block) for block in re.findall("<pre>(.*?)</pre>", page, flags=re.DOTALL)]
        assert blocks[0] == "tolmc run study.toml --samples 512 --seed 2026 --out again\ntolmc report again"
        assert blocks[1] == JOINT.read_text(encoding="utf-8")
        record = json.loads((directory / "run.json").read_text())
        assert record["study_sha256"] in page
        assert all(f"{name} {version}" in page for name, version in record["versions"].items())

    def test_embeds_the_pictures(self, directory):
        shown = re.findall('src="data:image/png;base64,(.*?)"', page_of(directory))
        for name, text in zip(("distributions.png", "drivers.png", "nominal.png"), shown, strict=True):
            assert len(base64.b64decode(text)) < 0.5 * (directory / name).stat().st_size
            small, whole = (
                np.asarray(Image.open(source).convert("RGB"), float)
                for source in (io.BytesIO(base64.b64decode(text)), directory / name)
            )
            assert small.shape == whole.shape and np.abs(small - whole).mean() < 0.5

    def test_a_damaged_picture_is_named(self, geometry_run):
        (geometry_run / "drivers.png").write_bytes(b"no picture")
        with pytest.raises(RunDirectoryError, match=r"drivers\.png is damaged.*Delete it"):
            write_report(geometry_run)

    def test_weighs_integration_against_sampling(self, directory):
        text = text_of(page_of(directory))
        record = json.loads((directory / "run.json").read_text())
        assert f"{record['plan']['steps']} steps of rk8" in text
        assert typeset.number(record["plan"]["pilot_error"], 2) in text
        assert "the journal left the wall in 0 of all samples, 0 % (0 % to" in text
        assert "Failed samples: none." in text

    def test_is_the_same_again_and_leaves_the_run_alone(self, directory):
        run = {path: path.read_bytes() for path in directory.iterdir() if path.is_file()}
        write_report(directory)
        assert run == {path: path.read_bytes() for path in directory.iterdir() if path.is_file()}


#: Outputs that the study of the joint limits.
LIMITED = tomllib.loads(JOINT.read_text())["specification"]


class TestTables:
    @pytest.mark.parametrize(
        ("column", "key"),
        [("mean", "mean"), ("sd", "sd"), ("0.135 %", "q0.135"), ("median", "q50"), ("99.865 %", "q99.865")],
    )
    def test_markdown_agrees_with_the_summary(self, directory, column, key):
        table = markdown_table(directory, "## Outputs")
        summary = pd.read_csv(directory / "summary.csv").set_index("output")
        shown = [name for name in summary.index if summary.at[name, "used"] and not name.endswith("error")]
        shown.sort(key=lambda name: name not in LIMITED)  # outputs with limits stand first
        assert len(table) == len(shown)
        for name, text in zip(shown, table[column], strict=True):
            factor = quantities.shown(name)[1]
            value, *interval = numbers_in(text)
            expected = summary.at[name, key] * factor
            low, high = (summary.at[name, f"{key}_{end}"] * factor for end in ("low", "high"))
            half = max((abs(end - expected) for end in (low, high) if math.isfinite(end)), default=math.inf)
            shown_to = {"abs": max(0.06 * half, 5.1e-6 * expected) if math.isfinite(half) else 1e-4 * expected}
            assert value == pytest.approx(expected, **shown_to)
            if "±" in text:
                assert interval == [pytest.approx(half, rel=0.06)]
            elif "open" in text:
                assert math.isinf(half)
            elif "up to" in text:
                assert math.isinf(low) and interval == [pytest.approx(high, **shown_to)]
            elif "from" in text:
                assert math.isinf(high) and interval == [pytest.approx(low, **shown_to)]
            else:
                assert interval == pytest.approx([low, high], **shown_to)

    def test_csv_holds_the_summary_in_full_precision(self, directory):
        table = pd.read_csv(directory / "tables" / "outputs.csv").set_index("output")
        summary = pd.read_csv(directory / "summary.csv").set_index("output")
        summary = summary.loc[sorted(summary.index, key=lambda name: name not in LIMITED)]
        factors = np.array([quantities.shown(name)[1] for name in summary.index])
        assert list(table.index) == list(summary.index)
        for key in ("mean", "sd_low", "q99.865_high", "max"):
            np.testing.assert_allclose(table[key], summary[key] * factors, rtol=1e-15)

    def test_every_table_is_a_csv_file(self, directory):
        names = {path.stem for path in (directory / "tables").glob("*.csv")}
        assert names == {
            "dimensions", "constants", "requirements", "capability", "contributions", "failures", "outputs",
            "error_budget", "statuses",
        }  # fmt: skip
        assert all(len(pd.read_csv(path)) for path in (directory / "tables").glob("*.csv"))

    def test_contributions_make_up_the_whole(self, directory):
        table = markdown_table(directory, "## Which tolerance matters").set_index("Output")
        for _, row in table.iterrows():
            assert sum(numbers_in(text)[0] for text in row) == pytest.approx(100, abs=0.3)
        assert table.at["Tilt angle ψ", "Bearing radius R*"].startswith("↑")
        assert table.at["Tilt angle ψ", "Half length L"].startswith("↓")

    def test_many_dimensions_leave_room_for_others(self, tmp_path):
        varied = "\n".join(
            f'{name} = {{ tolerance = "1 deg" }}'
            if name in ("alpha", "beta", "spin")
            else f"{name} = {{ tolerance = 0.1 }}"
            for name in ("mass", "alpha", "beta", "spin", "alpha_rate", "beta_rate", "spin_rate")
        )
        directory = run_study(tmp_path, GEOMETRY.replace("[body]", f"{varied}\n[body]"))
        write_report(directory)
        table = markdown_table(directory, "## Which tolerance matters")
        assert list(table.columns[[0, 1, 2, -2, -1]]) == [
            "Output", "Bearing radius R*", "Journal radius r*", "Others", "Interactions",
        ]  # fmt: skip
        assert len(table.columns) == 9
        assert len(pd.read_csv(directory / "tables" / "contributions.csv")["dimension"].unique()) == 9


class TestOtherRuns:
    def test_leaves_out_what_the_run_lacks(self, geometry_run):
        for name in ("drivers.png", "summary.csv"):
            (geometry_run / name).unlink()
        write_report(geometry_run)
        page = page_of(geometry_run)
        assert_stands_alone(page)
        headings = re.findall("<h2>(.*?)</h2>", page)
        assert headings == [
            "Dimensions and tolerances", "Outputs", "Which tolerance matters", "How far to trust the numbers",
            "What the model does not cover", "How to reproduce this report",
        ]  # fmt: skip
        text = text_of(page)
        assert "The study sets no requirement: see the outputs below." in text
        assert "main source of variance of 2 of 2 outputs" in text
        assert "leave the wall." not in text  # nothing was integrated, so nothing was seen
        assert "Half length L 40 20 20 mm exact" in text

    def test_a_geometric_run_integrates_nothing(self, geometry_run):
        write_report(geometry_run)
        text = text_of(page_of(geometry_run))
        assert "Integration: none; the outputs follow from the dimensions alone." in text
        assert "intervals hold with 95 % confidence and are computed for independent samples" in text

    def test_without_tolerances(self, tmp_path):
        text = GEOMETRY.replace('{ nominal = "20 mm", tolerance = "0.05 mm" }', '"20 mm"')
        text = text.replace('{ nominal = "19.8 mm", tolerance = ["-0.03 mm", "0 mm"] }', '"19.8 mm"')
        directory = run_study(tmp_path, text + '[specification]\ntilt_angle = { max = "2 deg" }\n', samples=4)
        write_report(directory)
        read = text_of(page_of(directory))
        assert "Do parts made to the nominal dimensions keep the tilt angle ψ ≤ 2 deg?" in read
        assert "Which tolerance matters" not in read

    @pytest.mark.parametrize(
        ("limit", "headline", "verdict"),
        [
            ('{ max = "1 deg" }', "Yes, the tolerances are good enough.", "met"),
            ('{ min = "0.57 deg", max = "0.6 deg" }', "No, the tolerances are not good enough.", "not met"),
            ('{ max = "0.78 deg" }', "Not decided: more samples are needed.", "not decided"),
        ],
    )
    def test_verdict(self, tmp_path, limit, headline, verdict):
        samples = 4096 if verdict == "met" else 320
        directory = run_study(tmp_path, f"{GEOMETRY}[specification]\ntilt_angle = {limit}\n", samples=samples)
        write_report(directory)
        assert headline in text_of(page_of(directory))
        table = pd.read_csv(directory / "tables" / "requirements.csv").set_index("requirement")
        assert table.at["tilt_angle", "verdict"] == verdict
        assert "all_requirements" not in table.index

    def test_judges_by_the_yield_that_the_study_asks_for(self, tmp_path):
        text = f'{GEOMETRY}[specification]\ntilt_angle = {{ max = "0.65 deg" }}\n[allocation]\ntarget_yield = "50 %"\n'
        directory = run_study(tmp_path, text)
        write_report(directory)
        assert "50 % are asked for" in text_of(page_of(directory))
        assert pd.read_csv(directory / "tables" / "requirements.csv").at[0, "verdict"] == "met"

    def test_no_title_can_break_the_page(self, tmp_path):
        text = f"title = '''{HOSTILE}\nsecond line'''\n{GEOMETRY}# ```` </pre> <b>\n"
        directory = run_study(tmp_path, text)
        write_report(directory)
        page = page_of(directory)
        assert_stands_alone(page)
        assert "alert(1)" not in "".join(Page(page).styles)
        assert text_of(page).count(f"{HOSTILE} second line") >= 1
        assert html.unescape(re.findall("<pre>(.*?)</pre>", page, flags=re.DOTALL)[1]) == text
        markdown = (directory / "report.md").read_text(encoding="utf-8")
        assert markdown.rstrip().endswith("`````") and f"`````toml\n{text}" in markdown

    def test_fit_correlation_and_lots(self, tmp_path):
        text = GEOMETRY.replace('half_length = "20 mm"', 'lot_size = 8\nfit = "40 D9/d9"\nhalf_length = "20 mm"')
        text = text.replace('{ nominal = "20 mm", tolerance = "0.05 mm" }', "{ lot_share = 0.3 }")
        text = text.replace(
            '{ nominal = "19.8 mm", tolerance = ["-0.03 mm", "0 mm"] }', '{ distribution = "triangular" }'
        )
        directory = run_study(tmp_path, f"{text}[correlation]\nbearing_radius.journal_radius = 0.25\n")
        write_report(directory)
        table = markdown_table(directory, "## Dimensions and tolerances")
        assert list(table["on the drawing"][:2]) == ["⌀40 D9", "⌀40 d9"]
        assert table["limits"][0] == "40.080 to 40.142"  # 40 mm + 80 and 142 µm
        text = text_of(page_of(directory))
        assert "Correlation of Bearing diameter 2 R* and Journal diameter 2 r*: 0.25." in text
        assert "lots of 8; share of the variance between lots: Bearing diameter 2 R* 30 %" in text
        assert "computed from the scatter among the lots" in text
        assert "Interactions and correlation" in text

    @pytest.mark.slow
    def test_a_lost_contact_is_not_good_enough(self, tmp_path):
        text = JOINT.read_text().replace("[0, -9.81, 0]", "[0, 9.81, 0]").replace('"1 s"', '"0.05 s"')
        text = text.replace('max = "24.45 deg"', 'max = "40 deg"').replace('max = "5.085 N"', 'max = "50 N"')
        directory = run_study(tmp_path, text, samples=2048)
        write_report(directory)
        read = text_of(page_of(directory))
        assert (
            "Not decided: in 100 % of the samples the journal leaves the wall, and what follows is not known." in read
        )
        assert "At least 0 % and at most 100 % of the samples meet every requirement" in read
        table = pd.read_csv(directory / "tables" / "requirements.csv").set_index("requirement")
        verdicts = table["verdict"].to_dict()
        assert verdicts["tilt_angle"] == "met"
        for name in ("contact_force_D_max", "all requirements"):
            assert verdicts[name].startswith(
                "not decided: the contact law matters (ends at the loss 0 % to 100 %, restitution"
            )
        assert table.loc["contact_force_D_max", ["yield", "yield_high"]].tolist() == [0, 1]
        capable = pd.read_csv(directory / "tables" / "capability.csv")["requirement"]
        assert list(capable) == ["tilt_angle"]  # no force is known for a whole motion

    @pytest.mark.parametrize(
        ("lost", "in_limits", "headline"),
        [
            (
                1,
                True,
                "Yes, the tolerances are good enough, though in 0.0244 % of the samples the journal leaves the wall.",
            ),
            (
                2000,
                False,
                "No, the tolerances are not good enough; in 48.8 % of the samples the journal leaves the wall.",
            ),
            (
                40,
                True,
                "Not decided: in 0.977 % of the samples the journal leaves the wall, and what follows is not known.",
            ),
        ],
    )
    def test_headlines_tell_the_share_that_lost_contact(self, lost, in_limits, headline):
        statuses = ["contact lost"] * lost + ["ok"] * (4096 - lost)
        samples = pd.DataFrame({"tilt_max": 0.0 if in_limits else 1.0, "status": statuses})
        specification = {"tilt_max": {"max": 0.5}}
        shares = summarise_requirements(samples, specification=specification)
        row = capability(samples, specification=specification).iloc[0]
        verdict = phrases.judged(Estimate(row["yield"], row["yield_low"], row["yield_high"]), 0.997)
        told = answer._headline(verdict, shares.loc[ANY_REQUIREMENT], shares.loc[CONTACT_LOSS], 0.997)
        assert told == headline

    def test_contact_loss_is_told(self, tmp_path):
        text = JOINT.read_text().replace('alpha_rate = "2 rad/s"', 'alpha_rate = "14 rad/s"')
        text = text.replace('beta_rate = "-3 rad/s"', 'beta_rate = "-12 rad/s"').replace('"1 s"', '"0.3 s"')
        text = text.replace('tolerance = "0.05 mm"', 'tolerance = "0.5 mm"')
        directory = run_study(tmp_path, text, samples=256)
        write_report(directory)
        statuses = pd.read_csv(directory / "tables" / "statuses.csv").set_index("status")
        assert 0 < statuses.at["contact lost", "count"] < 256
        text = text_of(page_of(directory))
        share = typeset.share(*statuses.loc["contact lost", ["share", "share_low", "share_high"]])
        assert f"In {share[0]} of the samples ({share[1]}) the journal leaves the wall" in text
        (row,) = re.findall(r"\| Contact lost \| (\d+) \|", (directory / "report.md").read_text(encoding="utf-8"))
        assert int(row) == statuses.at["contact lost", "count"]  # in the table of where the failures come from


@pytest.fixture(scope="module")
def extended_once(geometry_once, tmp_path_factory):
    """A run with what other commands may leave in its directory, and its worst case."""
    directory = shutil.copytree(geometry_once, tmp_path_factory.mktemp("extended") / "run")
    study = run_directory.read(directory).study()

    def model(inputs):
        radii = [inputs[name] for name in ("bearing_radius", "journal_radius", "half_length")]
        return pd.DataFrame(
            {"tilt_angle": geometry.tilt_angle(*radii), "effective_radius": geometry.effective_radius(*radii)}
        )

    outputs = ["tilt_angle", "effective_radius"]
    summary = pd.read_csv(directory / "summary.csv").set_index("output")
    worst = worst_case(model, study.tolerances, outputs=outputs)
    linear = linearise(model, study.tolerances, outputs=outputs).root_sum_square()
    answers = side_by_side(worst, linear, summary)
    answers.to_csv(directory / "stackup.csv")
    one_at_a_time(model, study.tolerances, outputs=outputs, points=5).to_csv(
        directory / "one_at_a_time.csv", index=False
    )
    sobol_indices(model, study.tolerances, outputs=outputs, count=64).to_csv(directory / "sobol_indices.csv")
    write_report(directory)
    return directory, worst


class TestFurtherTables:
    """What other commands may leave in a run directory."""

    @pytest.fixture
    def extended(self, extended_once, tmp_path):
        return shutil.copytree(extended_once[0], tmp_path / "run")

    def test_four_answers_side_by_side(self, extended, extended_once):
        _, worst = extended_once
        table = markdown_table(extended, "## Worst case, root sum square, Monte Carlo").set_index("Output")
        low, high = np.degrees(worst.loc["tilt_angle", ["min", "max"]].astype(float))
        shown = [numbers_in(text)[0] for text in table["worst case"].iloc[:2]]
        assert shown == pytest.approx([low, high], abs=5e-4)
        assert list(table["limit"]) == ["lower", "upper"] * 2 and table.index[2] == "Effective radius r (mm)"
        # 320 samples do not know these quantiles.
        assert list(table["verdict"]) == ["root sum square not decided"] * 4

    def test_a_worst_case_that_is_exceeded_or_not_known_is_told(self, extended):
        stackup = pd.read_csv(extended / "stackup.csv").set_index(["output", "quantity"])
        stackup.loc[("tilt_angle", "upper limit"), ["worst_case_is", "beyond_percent"]] = ["exceeded", 3.25]
        stackup.loc[("tilt_angle", "lower limit"), ["worst_case_is", "worst_case"]] = ["not known", math.nan]
        stackup["accelerated_missing"] = "5 motions failed"
        stackup.to_csv(extended / "stackup.csv")
        write_report(extended)
        table = markdown_table(extended, "## Worst case, root sum square, Monte Carlo")
        assert table["verdict"].iloc[0] == "root sum square not decided (worst case not known)"
        assert table["worst case"].iloc[0].startswith("–")
        assert table["verdict"].iloc[1].endswith("(samples 3.2 % beyond the worst case)")
        assert "No accelerated estimate: 5 motions failed" in text_of(page_of(extended))

    def test_the_accelerated_yield_stands_beside(self, tmp_path):
        directory = run_study(tmp_path, f'{GEOMETRY}[specification]\ntilt_angle = {{ max = "0.6 deg" }}\n')
        write_answers(directory)
        write_report(directory)
        row = pd.read_csv(directory / "yields.csv").iloc[0]
        assert row["monte_carlo_low"] < row["accelerated"] < row["monte_carlo_high"]
        value, interval = typeset.share(*row[["accelerated", "accelerated_low", "accelerated_high"]])
        assert f"{value} {interval}" in text_of(page_of(directory))

    def test_the_accelerated_estimate_has_its_table(self, extended):
        stackup = pd.read_csv(extended / "stackup.csv").set_index(["output", "quantity"])
        for end, shift in (("", 0.0), ("_low", -1e-4), ("_high", 1e-4)):
            stackup[f"accelerated{end}"] = stackup["monte_carlo"] + shift
        stackup = stackup.assign(accelerated_degree=4, accelerated_held_out=2e-5)
        stackup.to_csv(extended / "stackup.csv")
        write_report(extended)
        text = (extended / "report.md").read_text(encoding="utf-8")
        assert "| degree | held-out error |" in text and re.search(r"\| 4 \| 2·10⁻⁵ \|", text)

    def test_curves_and_indices(self, extended):
        page = page_of(extended)
        assert_stands_alone(page)
        assert page.count("<polyline") == 2  # the tilt angle over two dimensions
        first = [tuple(map(float, point.split(","))) for point in re.search('points="(.*?)"', page)[1].split()]
        assert first[0][0] == 0 and first[-1][0] == 200
        assert all(a[1] > b[1] for a, b in pairwise(first))  # tilt rises with the bearing radius
        assert "total" in set(pd.read_csv(extended / "tables" / "sobol_indices.csv").columns)
        assert "Total: the share that remains when all others are." in text_of(page)

    def test_other_pictures_come_last(self, extended):
        (extended / "nominal.png").unlink(missing_ok=True)
        (extended / "sample_7.png").write_bytes((extended / "drivers.png").read_bytes())
        write_report(extended)
        page = page_of(extended)
        assert "<h2>Further pictures</h2>" in page and "Sample 7." in page


class TestErrors:
    def test_no_run(self, tmp_path):
        with pytest.raises(RunDirectoryError, match=r"is no run directory: it has no run.json"):
            write_report(tmp_path)
        with pytest.raises(RunDirectoryError, match="is no run directory"):
            write_report(tmp_path / "absent")

    def test_unfinished_run(self, geometry_run):
        record = json.loads((geometry_run / "run.json").read_text())
        (geometry_run / "run.json").write_text(json.dumps(record | {"state": "running"}))
        with pytest.raises(RunDirectoryError, match=r"not finished.*tolmc run --resume"):
            write_report(geometry_run)
        assert not (geometry_run / "report.html").exists()

    def test_missing_and_truncated_samples(self, geometry_run):
        samples = geometry_run / "samples.parquet"
        content = samples.read_bytes()
        samples.write_bytes(content[:-100])
        with pytest.raises(RunDirectoryError, match="truncated or foreign"):
            write_report(geometry_run)
        samples.unlink()
        with pytest.raises(RunDirectoryError, match="holds 0 samples, 320 are expected"):
            write_report(geometry_run)

    @pytest.mark.parametrize("content", ["", "nothing,known\n1,2\n"])
    def test_damaged_table(self, geometry_run, content):
        (geometry_run / "summary.csv").write_text(content)
        with pytest.raises(RunDirectoryError, match=r"summary.csv is damaged.*delete it"):
            write_report(geometry_run)

    def test_unreadable_target(self, tmp_path):
        directory = run_study(
            tmp_path, f'{GEOMETRY}[specification]\ntilt_angle = {{ max = 1 }}\n[allocation]\ntarget_yield = "much"\n'
        )
        with pytest.raises(InputError, match=r"\[allocation\] target_yield = 'much'"):
            write_report(directory)

    def test_command(self, geometry_run, tmp_path):
        done = CliRunner().invoke(main, ["report", str(geometry_run)])
        assert done.exit_code == 0 and done.output == f"Written: {geometry_run / 'report.html'}\n"
        failed = CliRunner().invoke(main, ["report", str(tmp_path / "absent")])
        assert failed.exit_code == 2 and failed.output.startswith("Error: ") and "Traceback" not in failed.output
