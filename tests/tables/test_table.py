"""A table of values, written in the notation of a terminal and of a page."""

import math

import pandas as pd
import pytest

from tolmc.mechanism.scene import Joint
from tolmc.tables.outputs import budget_table
from tolmc.tables.run import section_note
from tolmc.tables.table import Cell, Column, Estimated, Number, Share, Table, cells, plain, typeset


@pytest.mark.parametrize(
    ("value", "terminal", "page"),
    [
        ("a text", ("a text", ""), ("a text", "")),
        (Number(-1.5e-7, 2), ("-1.5e-07", ""), ("−1.5·10⁻⁷", "")),
        (Number(math.nan), ("–", ""), ("–", "")),
        (Number(-2.0, decimals=1, unit="mm"), ("-2.0 mm", ""), ("−2.0 mm", "")),
        (Estimated(5.0, 4.0, 6.0), ("5.0", "±1.0"), ("5.0", "4.0 to 6.0")),
        (Estimated(24.32776, 24.327749, 24.327771), ("24.328", ""), ("24.3278", "±1.1·10⁻⁵")),
        (Estimated(2.0, -math.inf, 2.1), ("2.0000", "open"), ("2.00", "up to 2.10")),
        (Share(6.6e-5, 5e-5, 8e-5), ("66 ppm", ""), ("0.0066 %", "0.0050 % to 0.0080 %")),
    ],
)
def test_a_cell_has_its_texts_in_either_notation(value, terminal, page):
    for notation, texts in ((plain, terminal), (typeset, page)):
        written = Cell(value).written(notation)
        assert (written.text, written.detail) == texts


def test_a_column_may_be_of_one_notation():
    columns = ("Output", Column("unit", words=True, only=plain), "mean", Column("verdict", words=True, only=typeset))
    table = Table("t", columns, (cells("a", "N", Number(1.5), "good"),), caption="A caption.")
    terminal, page = table.written(plain), table.written(typeset)
    assert terminal.header == ("Output", "unit", "mean") and terminal.left == (0, 1)
    assert page.header == ("Output", "mean", "verdict") and page.left == (0, 2)
    assert page.alignment == (":--", "--:", ":--")
    assert [cell.text for cell in terminal.rows[0]] == ["a", "N", "1.5"]
    assert [cell.text for cell in page.rows[0]] == ["a", "1.5", "good"]


def test_a_cell_in_one_line():
    cell = Cell("⌀40", "small print", deviations=("+0.1", "0"))
    assert cell.written(typeset).line == "⌀40 +0.1/0 (small print)"


def test_csv_leaves_out_an_index_without_name():
    frame = pd.DataFrame({"a": [0.1 + 0.2]})
    assert Table("t", (), (), frame=frame).csv() == "a\n0.30000000000000004\n"
    assert Table("t", (), (), frame=frame.rename_axis("row")).csv() == "row,a\n0,0.30000000000000004\n"


def test_the_budget_says_the_same_to_both():
    row = {"integration_error": 1e-8}
    for key in ("mean", "sd", "q0.135", "q5", "q50", "q95", "q99.865"):
        row |= {f"{key}_low": 1.0, f"{key}_high": math.inf if key == "q99.865" else 1.002}
    summary = pd.DataFrame([row], index=pd.Index(["contact_force_D_max"], name="output"))
    terminal, page = (budget_table(summary).written(notation) for notation in (plain, typeset))
    assert [cell.text for cell in terminal.rows[0]] == [
        "Contact force N_D, max",
        "N",
        "1e-08",
        "0.001",
        "0.001",
        "open",
    ]
    assert [cell.text for cell in page.rows[0]] == [
        "Contact force N_D, max (N)",
        "1·10⁻⁸",
        "0.001",
        "0.001",
        "open",
        "1·10⁻⁵",
    ]


def test_the_note_on_the_section_names_position_tilt_and_contact_forces():
    # The paper's joint: (1/cos(psi) - 1) r*/(R* - r*) = 9.72 %.
    sentence = section_note(Joint(0.02, 0.01, 0.02)).text
    assert "position by up to 9.72 %" in sentence and "tilt by up to 9.72 %" in sentence
    assert "contact-force peaks by up to about 9.72 %" in sentence
    assert "up to 0.000125 %" in section_note(Joint(0.01 * (1 + 1e-5), 0.01, 0.02)).text
