"""Circle against exact section on the same samples: what is compared, and what of it is shown."""

from dataclasses import replace
from io import StringIO

import numpy as np
import pytest
from rich.console import Console
from small_study import GEOMETRY, write

from tolmc.commands.compare_sections import compare_sections
from tolmc.errors import InputError
from tolmc.runs.run import run
from tolmc.study.file import load_study
from tolmc.tables.sections import comparison_tables
from tolmc.terminal.grid import show
from tolmc.text import plain

# Between the peaks of the two sections.
LIMIT = ("4.5 N", "3.02 N")
EXACT = ("[loads]", '[model]\nsection = "exact"\n[loads]')


def shown(comparison):
    console = Console(file=StringIO(), width=80)
    show(comparison_tables(comparison), console)
    return console.file.getvalue()


def test_every_statistic_and_share_is_compared(tmp_path):
    circle, exact = run(write(tmp_path, LIMIT), samples=400), run(write(tmp_path, LIMIT, EXACT), samples=400)
    table = compare_sections(circle)
    for statistic in ("mean", "sd", "min", "q0.135", "q5", "q50", "q95", "q99.865", "max"):
        row = table.loc[("contact_force_D_max", statistic)]
        expected = [result.summary.at["contact_force_D_max", statistic] for result in (circle, exact)]
        assert [row["circle"], row["exact"]] == expected
        assert row["difference"] == expected[0] - expected[1]
        assert row["difference_percent"] == pytest.approx(100 * row["difference"] / expected[1])
    for requirement in ("tilt_angle", "contact_force_D_max", "any requirement", "contact loss"):
        row = table.loc[(requirement, "share_most")]
        expected = [result.requirements.at[requirement, "share_most"] for result in (circle, exact)]
        assert [row["circle"], row["exact"]] == expected
    assert table.loc[("contact_force_D_max", "share_least"), "difference"] == 1.0
    assert ("tilt_angle", "mean") not in table.index


def test_the_comparison_is_the_same_from_either_side(tmp_path):
    circle, exact = (compare_sections(run(write(tmp_path, *changes), samples=100)) for changes in ((), (EXACT,)))
    np.testing.assert_array_equal(circle.to_numpy(), exact.to_numpy())


def test_a_status_that_only_one_section_has_is_no_sample_of_the_other(tmp_path):
    # Near the level of the bore's axis the exact section's journal leaves the wall in this time, the circle's does not.
    changes = ('alpha = "-110 deg"', 'alpha = "-7 deg"'), ('beta = "-50 deg"', 'beta = "-7 deg"')
    table = compare_sections(run(write(tmp_path, *changes), samples=50))
    assert table.loc["status", ["circle", "exact"]].to_numpy().tolist() == [[1, 0], [0, 1]]
    assert "Status contact lost" in shown(table) and "−100 %" in shown(table)


def test_everything_compared_is_shown(tmp_path):
    text = shown(compare_sections(run(write(tmp_path, LIMIT), samples=100)))
    for words in ("mean", "sd", "min", "max", "0.135 %", "5 %", "median", "95 %", "99.865 %", "Contact force N_E, rms"):
        assert words in text
    for words in ("Contact force N_D, max, out", "+100 %", "Any requirement broken", "Contact lost", "Status ok"):
        assert words in text
    assert max(map(len, text.splitlines())) <= 80 and "…" not in text


def test_shares_that_failed_samples_leave_open_are_bounded(tmp_path):
    wide = ('nominal = "10 mm", tolerance = ["-0.03 mm", "0 mm"]', 'nominal = "19.95 mm", tolerance = "0.1 mm"')
    result = run(write(tmp_path, wide, *GEOMETRY), samples=500)
    text = shown(compare_sections(result))
    failed = plain.share(result.statuses.loc["geometry invalid", "share"])[0]
    assert f"Status geometry invalid {failed}" in " ".join(text.split())
    assert f"Tilt angle ψ, out, at most {failed}" in " ".join(text.split())


def test_the_papers_own_coordinates_know_the_circle_only(tmp_path):
    study = replace(load_study(write(tmp_path, *GEOMETRY)), formulation="published")
    with pytest.raises(InputError, match="'published' knows the circle only"):
        compare_sections(run(study, samples=10))
