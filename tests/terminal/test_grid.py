"""Tables on a terminal: nothing is cut, and a result says what it should."""

import math
from dataclasses import replace
from io import StringIO

import numpy as np
import pandas as pd
import pytest
from rich.console import Console
from small_study import GEOMETRY, write

from tolmc.commands.answers import write_answers
from tolmc.runs.nominal import study_motion
from tolmc.runs.run import run
from tolmc.study.file import load_study
from tolmc.tables.motion import motion_blocks, sample_table
from tolmc.tables.outputs import outputs_table
from tolmc.tables.requirements import shares_table
from tolmc.tables.run import run_blocks
from tolmc.tables.stackup import answers_blocks
from tolmc.tables.table import Cell, Column, Note, Number, Table, cells
from tolmc.terminal.grid import show


@pytest.fixture
def console():
    return Console(file=StringIO(), width=80)


def text(console):
    return console.file.getvalue()


def wide_table(columns, cell):
    return Table(
        "wide", ("Output", *columns), (cells("Contact force N_D, max", *map(cell, range(len(columns)))),), "A table"
    )


def test_a_result_fits_a_terminal(tmp_path, console):
    result = run(write(tmp_path), samples=2000)
    show(run_blocks(result), console)
    shown = text(console)
    # Nothing is cut off, nothing wrapped by the terminal.
    assert "…" not in shown and max(map(len, shown.splitlines())) <= 80
    for words in ("2,000 samples", "Tilt angle ψ", "deg", "mm", "Contact force N_D, mean", "Error budget", "Status"):
        assert words in shown
    row = np.degrees(result.summary.loc["tilt_angle"].drop(["unit", "section"]).astype(float))
    value, half = row["q50"], max(row["q50_high"] - row["q50"], row["q50"] - row["q50_low"])
    assert f"{value:.3f}" in shown and f"±{half:.1g}" in shown  # an estimate and the half width below it


@pytest.mark.parametrize(("width", "parts"), [(81, 3), (80, 4), (30, 8)])
def test_nothing_is_cut_on_a_narrow_terminal(width, parts):
    names = [f"column number {i}" for i in range(8)]
    console = Console(file=StringIO(), width=width)
    show([wide_table(names, lambda i: f"{i}.123456 ±0.0001")], console)
    shown = text(console)
    assert "…" not in shown and max(map(len, shown.splitlines())) <= width
    assert shown.count("Output") == parts and shown.count("A table") == 1  # each part has the outputs' names
    if width > 30:
        assert all(f"{i}.123456 ±0.0001" in shown and names[i] in shown for i in range(8))
    assert all(shown.count(digit) >= 8 for digit in "123456")  # a column alone that does not fit is folded


def test_a_pipe_has_no_width(capsys):
    show([wide_table([str(i) for i in range(60)], lambda i: "0.123456789"), Note("a sentence " * 60)])
    shown = capsys.readouterr().out
    assert shown.count("0.123456789") == 60 and len(shown.splitlines()[-1]) == 11 * 60


def test_what_people_wrote_is_no_markup(console):
    table = Table("t", ("[red]Output", ":x:"), (cells("[bold]a[/]", Cell("b", "[c]")),), title="50 [bold] [/]")
    show([table, Note("[link=x] :smile:", strong="[link=x]")], console)
    for words in ("[red]Output", ":x:", "[bold]a[/]", "[c]", "50 [bold] [/]", "[link=x] :smile:"):
        assert words in text(console)


def test_tone_and_strength_are_seen():
    console = Console(file=StringIO(), width=80, force_terminal=True, color_system="standard")
    rows = (cells("a", Cell("misleads", tone="bad")), cells("b", Cell("fine", tone="good")))
    show([Table("t", ("Output", "verdict"), rows), Note("It does not reach it.", strong="not")], console)
    shown = text(console)
    assert "\x1b[1;31mmisleads" in shown and "\x1b[1mnot\x1b[0m" in shown
    assert "mfine" not in shown


@pytest.mark.parametrize(
    ("is_dense", "cell", "lines"),
    [
        (False, Cell("5.0", "±0.1"), ["5.0", "±0.1"]),
        (True, Cell("5.0", "±0.1"), ["5.0 ±0.1"]),
        (True, Cell("5.0", "4 to 6"), ["5.0 (4 to 6)"]),
        (True, Cell(detail="degree 3"), ["degree 3"]),
        (False, Cell("40", deviations=("+0.1", "0")), ["40 +0.1/0"]),
    ],
)
def test_small_print_stands_below_or_beside(is_dense, cell, lines, console):
    show([Table("t", (Column("x"),), (cells(cell),), is_dense=is_dense)], console)
    assert [line.strip() for line in text(console).splitlines()[3:] if line.strip()] == lines


def test_rounding_errors_are_zero_beside_values_of_their_unit(console):
    keys = ("mean", "sd", "min", "max", "q0.135", "q5", "q50", "q95", "q99.865")
    names = [f"{key}{end}" for key in keys for end in ("", "_low", "_high")]
    summary = pd.DataFrame(
        {"samples": 10, "used": 10, "failed": 0, **{name: [-8.0398e-17, 70.0, 3e-9] for name in names}},
        index=pd.Index(["contact_force_D_min", "contact_force_D_max", "contact_loss_time"], name="output"),
    )
    show([outputs_table(summary)], console)
    shown = text(console)
    assert "e-17" not in shown and "-0" not in shown.replace("3e-09", "")
    assert "70.000" in shown and "3e-09" in shown  # small beside forces, but a time


@pytest.mark.slow
def test_answers_show_intervals_surrogate_and_verdicts(tmp_path):
    study = write(tmp_path, *GEOMETRY)
    run(study, samples=4096, out=tmp_path / "run")
    answers = write_answers(tmp_path / "run")
    console = Console(file=StringIO(), width=300)
    show(answers_blocks(replace(answers, no_yields="A reason.")), console)
    shown = text(console)
    row = answers.stackup.loc[("tilt_angle", "upper limit")]
    assert f"degree {row['accelerated_degree']:.0f}, error {row['accelerated_held_out']:.1g}" in shown
    assert shown.count("±") > 8 and "RSS misleads" in shown and "% wider" in shown
    assert "No accelerated yield: A reason." in shown
    assert f"{100 * answers.yields.at['tilt_angle', 'accelerated']:.5g} (" in shown
    unknown = answers.stackup.assign(
        worst_case_is=answers.stackup["worst_case_is"].where(answers.stackup["worst_case_is"] == "", "not known"),
        verdict="root sum square agrees; worst case not known: 2 of 8 corners have no value",
        accelerated_missing="5 motions failed",
        accelerated_degree=math.nan,
    )
    console = Console(file=StringIO(), width=300)
    show(answers_blocks(replace(answers, stackup=unknown)), console)
    assert "Worst case not known: 2 of 8 corners have no value (every limit)." in text(console)
    assert "No accelerated estimate: 5 motions failed" in text(console)


def test_requirements_with_failed_samples_are_bounded_both_ways(tmp_path, console):
    wide = ('nominal = "10 mm", tolerance = ["-0.03 mm", "0 mm"]', 'nominal = "19.95 mm", tolerance = "0.1 mm"')
    result = run(write(tmp_path, wide, *GEOMETRY), samples=2000)
    show([shares_table(result.requirements)], console)
    failed = result.statuses.loc["geometry invalid", "share"]
    assert f"0 % to {100 * failed:.3g} %" in text(console)
    show(run_blocks(result), console)
    assert "geometry invalid" in text(console)


@pytest.mark.slow
def test_a_lost_contact_is_told_in_the_summary_and_the_answers(tmp_path, console):
    result = run(write(tmp_path, ("[0, -9.81, 0]", "[0, 9.81, 0]")), samples=200, out=tmp_path / "run")
    show(run_blocks(result), console)
    shown = " ".join(text(console).split())
    told = "In 100 % of the samples contact is lost: outputs of the motion hold up to that instant."
    assert told in shown
    assert "is counted both ways." in shown and "0 % to 100 %" in shown
    answers = write_answers(tmp_path / "run")
    assert answers.yields is None
    notes = [block.text for block in answers_blocks(answers) if isinstance(block, Note)]
    assert told in notes and notes[-1].startswith("No accelerated yield: ")


def test_a_motion_is_shown_with_its_start_and_end(tmp_path, console):
    study = load_study(write(tmp_path))
    trajectory = study_motion(study)
    show(motion_blocks(trajectory, study.scene, title="A [motion]"), console)
    shown = text(console)
    assert "A [motion]" in shown and "Status: ok" in shown
    assert f"{1e3 * trajectory.origin[0, 0]:.5f}" in shown and f"{1e3 * trajectory.origin[-1, 1]:.5f}" in shown
    assert f"{trajectory.contact_force[-1, 1]:.5g}" in shown


def test_a_sample_is_shown_in_engineering_units(console):
    show([sample_table({"bearing_radius": 0.02, "tilt_angle": math.radians(24), "status": "ok"})], console)
    shown = text(console)
    assert "20 " in shown and "24 " in shown and "ok" in shown


def test_a_number_that_does_not_exist_has_no_unit():
    table = Table("t", ("x", "y"), (cells(Number(math.nan, unit="%"), Number(1.25, decimals=1, unit="%")),))
    console = Console(file=StringIO(), width=80)
    show([table], console)
    assert "– " in text(console) and "–  %" not in text(console) and "1.2 %" in text(console)
