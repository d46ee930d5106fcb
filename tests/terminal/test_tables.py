import math
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
from tolmc.terminal import tables


@pytest.fixture
def console():
    return Console(file=StringIO(), width=80)


def text(console):
    return console.file.getvalue()


@pytest.mark.parametrize(
    ("estimate", "digits", "expected"),
    [
        ((24.3278, 24.32, 24.33), 6, "24.3278\n±0.0078"),
        ((24.3278, 24.32, 24.3281), 6, "24.3278\n±0.0078"),
        ((24.32776, 24.327749, 24.327761), 6, "24.3278"),
        ((24.32776, 20.0, 30.0), 6, "24.3\n±5.7"),
        ((24.32776, 24.32776, 24.32776), 6, "24.3278"),
        ((0.0, 0.0, 0.0), 6, "0"),
        ((0.0, -math.inf, 0.0), 6, "0\nopen"),
        ((-0.0004, -0.11, 0.11), 6, "0.00\n±0.11"),
        ((1234567.0, 1234000.0, 1235000.0), 6, "1.23457e+06\n±6e+02"),
        ((0.00035996, 0.00035989, 0.00036003), 4, "0.0003600\n±7e-08"),
        ((5.5, -math.inf, 5.5), 6, "5.50000\nopen"),
        ((-3.38461e-16, -4e-16, -3e-16), 6, "-3.4e-16\n±6e-17"),
        ((math.nan, math.nan, math.nan), 6, "–"),
    ],
)
def test_estimates_show_the_digits_that_are_known(estimate, digits, expected):
    assert tables.estimate_text(*estimate, digits).replace("[dim]", "").replace("[/]", "") == expected


@pytest.mark.parametrize(
    ("share", "expected"),
    [(0.0, "0 %"), (0.0345, "3.45 %"), (1.0, "100 %"), (0.001, "0.1 %"), (6.6e-5, "66 ppm"), (math.nan, "–")],
)
def test_shares_read_well(share, expected):
    assert tables.share_text(share) == expected


def test_a_result_fits_a_terminal(tmp_path, console):
    result = run(write(tmp_path), samples=2000)
    tables.print_result(result, console)
    shown = text(console)
    assert (
        "…" not in shown and max(map(len, shown.splitlines())) <= 80
    )  # nothing is cut off, nothing wrapped by the terminal
    for words in ("2,000 samples", "Tilt angle ψ", "deg", "mm", "Contact force N_D, mean", "Error budget", "Status"):
        assert words in shown
    row = np.degrees(result.summary.loc["tilt_angle"].drop("unit").astype(float))
    value, half = row["q50"], max(row["q50_high"] - row["q50"], row["q50"] - row["q50_low"])
    assert f"{value:.3f}" in shown and f"±{half:.1g}" in shown  # an estimate and the half width below it


@pytest.mark.parametrize(("width", "parts"), [(81, 3), (80, 4), (30, 8)])
def test_nothing_is_cut_on_a_narrow_terminal(width, parts):
    names = [f"column number {i}" for i in range(8)]
    table = tables.Grid("Output", *names, title="A table")
    table.add_row("Contact force N_D, max", *(f"{i}.123456 ±0.0001" for i in range(8)))
    console = Console(file=StringIO(), width=width)
    console.print(table)
    shown = text(console)
    assert "…" not in shown and max(map(len, shown.splitlines())) <= width
    assert shown.count("Output") == parts  # each part has the outputs' names
    if width > 30:
        assert all(f"{i}.123456 ±0.0001" in shown and names[i] in shown for i in range(8))
    assert all(shown.count(digit) >= 8 for digit in "123456")  # a column alone that does not fit is folded


def test_a_pipe_has_no_width(capsys):
    table = tables.Grid("Output", *map(str, range(60)), title="A table")
    table.add_row("x", *["0.123456789"] * 60)
    tables.standard_output().print(table)
    assert capsys.readouterr().out.count("0.123456789") == 60


def test_rounding_errors_are_zero_beside_values_of_their_unit(console):
    names = [f"{key}{end}" for key in ("mean", "sd", "q0.135", "q50", "q99.865") for end in ("", "_low", "_high")]
    summary = pd.DataFrame(
        {"used": 10, **{name: [-8.0398e-17, 70.0, 3e-9] for name in names}},
        index=pd.Index(["contact_force_D_min", "contact_force_D_max", "contact_loss_time"], name="output"),
    )
    console.print(tables.summary_table(summary))
    shown = text(console)
    assert "e-17" not in shown and "-0" not in shown.replace("3e-09", "")
    assert "70.000" in shown and "3e-09" in shown  # small beside forces, but a time


@pytest.mark.slow
def test_answers_show_intervals_surrogate_and_verdicts(tmp_path):
    study = write(tmp_path, *GEOMETRY)
    run(study, samples=4096, out=tmp_path / "run")
    answers = write_answers(tmp_path / "run")
    console = Console(file=StringIO(), width=300)
    tables.print_answers(answers.stackup, answers.yields, ["A note."], console)
    shown = text(console)
    row = answers.stackup.loc[("tilt_angle", "upper limit")]
    assert f"degree {row['accelerated_degree']:.0f}, error {row['accelerated_held_out']:.1g}" in shown
    assert shown.count("±") > 8 and "RSS misleads" in shown and "% wider" in shown and "A note." in shown
    assert f"{100 * answers.yields.at['tilt_angle', 'accelerated']:.5g} (" in shown
    unknown = answers.stackup.assign(
        worst_case_is=answers.stackup["worst_case_is"].where(answers.stackup["worst_case_is"] == "", "not known"),
        verdict="root sum square agrees; worst case not known: 2 of 8 corners have no value",
        accelerated_missing="5 motions failed",
        accelerated_degree=math.nan,
    )
    console = Console(file=StringIO(), width=300)
    tables.print_answers(unknown, console=console)
    assert "Worst case not known: 2 of 8 corners have no value (every limit)." in text(console)
    assert "No accelerated estimate: 5 motions failed" in text(console)


def test_requirements_with_failed_samples_are_bounded_both_ways(tmp_path, console):
    wide = ('nominal = "10 mm", tolerance = ["-0.03 mm", "0 mm"]', 'nominal = "19.95 mm", tolerance = "0.1 mm"')
    result = run(write(tmp_path, wide, *GEOMETRY), samples=2000)
    console.print(tables.requirement_table(result.requirements))
    failed = result.statuses.loc["geometry invalid", "share"]
    assert f"0 % to {100 * failed:.3g} %" in text(console)
    tables.print_result(result, console)
    assert "geometry invalid" in text(console)


@pytest.mark.slow
def test_a_lost_contact_is_told_in_the_summary_and_the_answers(tmp_path, console):
    result = run(write(tmp_path, ("[0, -9.81, 0]", "[0, 9.81, 0]")), samples=200, out=tmp_path / "run")
    tables.print_result(result, console)
    shown = " ".join(text(console).split())
    assert "In 100 % of the samples contact is lost: outputs of the motion hold up to that instant." in shown
    assert "is counted both ways." in shown and "0 % to 100 %" in shown
    answers = write_answers(tmp_path / "run")
    assert answers.notes[0].startswith("In 100 % of the samples contact is lost")
    assert answers.notes[1].startswith("No accelerated yield: ") and answers.yields is None


def test_a_motion_is_shown_with_its_start_and_end(tmp_path, console):
    study = load_study(write(tmp_path))
    trajectory = study_motion(study)
    tables.print_trajectory(trajectory, study.scene, title="A [motion]", console=console)
    shown = text(console)
    assert "A [motion]" in shown and "Status: ok" in shown
    assert f"{1e3 * trajectory.origin[0, 0]:.5f}" in shown and f"{1e3 * trajectory.origin[-1, 1]:.5f}" in shown
    assert f"{trajectory.contact_force[-1, 1]:.5g}" in shown


def test_a_sample_is_shown_in_engineering_units(console):
    tables.print_sample({"bearing_radius": 0.02, "tilt_angle": math.radians(24), "status": "ok"}, console)
    shown = text(console)
    assert "20 " in shown and "24 " in shown and "ok" in shown
