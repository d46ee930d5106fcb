"""Fits side by side: which are meant, and that each is the study with it."""

import pytest
from click.testing import CliRunner
from small_study import GEOMETRY, TEXT, write

import tolmc
from tolmc.cli import main
from tolmc.runs.fits import study_size, try_fits
from tolmc.tables.fits import fits_blocks
from tolmc.tables.table import Note
from tolmc.tolerances.fit_series import fit_series

RADII = "\n".join(line for line in TEXT.splitlines() if "_radius " in line)
FIT = (
    *GEOMETRY,
    (RADII, 'fit = "40 H11/d11"\njournal_radius = { distribution = "triangular" }'),
    ('"24.4 deg"', '"0.45 deg"'),
)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("H11/d11", ["40 H11/d11"]),
        ("H11/d11, 50 H7/f6", ["40 H11/d11", "50 H7/f6"]),
        ("H11/c11-e11", ["40 H11/c11", "40 H11/d11", "40 H11/e11"]),
        ("H7-H9/e8", ["40 H7/e8", "40 H8/e8", "40 H9/e8"]),
        ("H9/d9, H9/d9", ["40 H9/d9"]),
        ("F8-H8/h7-f7", [f"40 {hole}/{shaft}" for hole in ("F8", "G8", "H8") for shaft in ("f7", "g7", "h7")]),
    ],
)
def test_fits_that_a_text_names(text, expected):
    assert fit_series(text, "40") == expected


@pytest.mark.parametrize(
    ("text", "size", "words"),
    [
        ("H11", "40", "is no fit"),
        ("H11/d11", None, "has no size"),
        ("H11/c9-d11", "40", "changes letter and grade"),
        ("H11/z99", "40", "grade"),
        ("H7/js6-k6", "40", "no range of letters"),
        ("", "40", "is no fit"),
    ],
)
def test_texts_that_name_no_fit(text, size, words):
    with pytest.raises(ValueError, match=words):
        fit_series(text, size)


def test_each_fit_is_the_study_with_it(tmp_path):
    study = tolmc.load_study(write(tmp_path, *FIT))
    assert study_size(study) == "40"
    found = try_fits(study, "H11/c11-e11", samples=800)
    for fit, row in found.iterrows():
        other = (RADII, f'fit = "{fit}"\njournal_radius = {{ distribution = "triangular" }}')
        alone = tolmc.run(write(tmp_path, *GEOMETRY, other, FIT[-1]), samples=800)
        assert row["yield"] == 1 - alone.requirements.at["tilt_angle", "share_most"]
        assert row["tilt_angle q99.865"] == alone.summary.at["tilt_angle", "q99.865"]
    assert found["yield"].is_monotonic_increasing and 0 < found["yield"].iloc[0] < found["yield"].iloc[-1]
    assert found.at["40 H11/d11", "clearance_low"] == pytest.approx(80e-6)
    assert found["cost"].isna().all()


def test_fits_are_priced_by_the_grades_of_an_allocation(tmp_path):
    prices = (
        "[allocation.dimensions]\nbearing_radius = { grades = { IT11 = 2, IT9 = 3 } }\n"
        "journal_diameter = { grades = { IT11 = 1 } }\n"
    )
    study = tolmc.load_study(write(tmp_path, *FIT, ("[body]", f"{prices}[body]")))
    found = try_fits(study, "H11/d11, H9/d11, H9/d9", samples=100)
    assert found["cost"].iloc[:2].tolist() == [3, 4] and found["cost"].isna().iloc[2]


def test_the_loosest_fit_that_does_is_named(tmp_path):
    study = tolmc.load_study(write(tmp_path, *FIT))
    table, note, costs = fits_blocks(study, try_fits(study, "H11/c11-h11", samples=2000), samples=2000)
    verdicts = [row[-1].content for row in table.rows]
    assert verdicts[0] == "not met" and verdicts[-1] == "met"
    others = [row[0].content for row, verdict in zip(table.rows, verdicts, strict=True) if verdict == "met"][1:]
    assert note.text.endswith(f" {others[-1]}.") and note.text.startswith(f"Of these fits {note.strong} is the loosest")
    assert isinstance(note, Note) and note.strong == table.rows[verdicts.index("met")][0].content
    assert isinstance(costs, Note) and "[allocation.dimensions]" in costs.text


def test_what_the_model_of_the_joint_may_turn_is_not_decided(tmp_path):
    motion = (*FIT[2:], ("[monte_carlo]", '[monte_carlo]\nstep = "5 ms"'))
    study = tolmc.load_study(write(tmp_path, *motion))
    found = try_fits(study, "H11/d11, H9/d9", samples=64)
    for fit, row in found.iterrows():
        alone = tolmc.run(study.with_fit(str(fit)), samples=64).requirements.loc["any requirement"]
        assert row[["section", "section_turns_target"]].tolist() == alone[["section", "section_turns_target"]].tolist()
    said = "not decided: the section matters (circle 0 %, exact 5 %)"
    first = found.index[0]
    found = found.assign(
        **{"yield": 1.0, "yield_low": 1.0, "yield_high": 1.0, "section": "", "section_turns_target": False}
    )
    found.loc[first, ["section", "section_turns_target"]] = [said, True]
    table, note, _ = fits_blocks(study, found, samples=64)
    verdicts = {row[0].content: row[-1].content for row in table.rows}
    assert verdicts == {first: said, found.index[1]: "met"} and note.strong == found.index[1]


def test_fits_of_which_too_few_samples_could_be_computed_are_named(tmp_path):
    study = tolmc.load_study(write(tmp_path, *FIT))
    found = try_fits(study, "H11/c11-d11", samples=64)
    found["computed_share"] = [0.89, 0.9]
    told = next(block.text for block in fits_blocks(study, found, samples=64) if isinstance(block, Note))
    assert told.startswith(f"With {found.index[0]} fewer than 90 % of the samples could be computed")


def test_fits_on_the_command_line(tmp_path):
    def invoke(*arguments):
        return CliRunner().invoke(main, ["fits", *map(str, arguments)])

    path = write(tmp_path, *FIT)
    shown = invoke(path, "--try", "H11/d11, H9/d9", "--samples", 200, "--csv", tmp_path / "fits.csv")
    assert shown.exit_code == 0 and "40 H9/d9" in shown.stdout and (tmp_path / "fits.csv").exists()
    assert "leaves a clearance of" in invoke(path, "--try", "H7/s6").stderr
    assert "no fit" in invoke(path, "--try", "d9").stderr
    bare = write(tmp_path, *GEOMETRY, ('tilt_angle = { max = "24.4 deg" }', ""))
    assert "[specification] is missing" in invoke(bare, "--try", "40 H7/d9").stderr
    measured = (tmp_path / "d.csv").write_text("d\n20\n20.01\n")
    data = (RADII, 'bearing_radius = { data = "d.csv", column = "d", unit = "mm" }\njournal_radius = "19.9 mm"')
    assert measured and "limits of its own" in invoke(write(tmp_path, *GEOMETRY, data), "--try", "40 H7/d9").stderr
