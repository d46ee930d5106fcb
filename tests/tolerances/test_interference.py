import pytest
from places import STUDIES
from small_study import write

from tolmc.study.file import load_study
from tolmc.tolerances.interference import interference_note, smallest_clearance


def tolerances(folder, *changes):
    return load_study(write(folder, *changes)).tolerances


def test_smallest_clearance_is_that_of_the_smallest_bearing_with_the_largest_journal(tmp_path):
    assert smallest_clearance(tolerances(tmp_path)) == pytest.approx(0.01995 - 0.01)
    wide = tolerances(tmp_path, ('tolerance = ["-0.03 mm", "0 mm"]', 'tolerance = ["-0.03 mm", "10 mm"]'))
    assert smallest_clearance(wide) == pytest.approx(-0.05e-3)


def test_a_note_says_which_dimensions_overlap_and_by_how_much(tmp_path):
    note = interference_note(tolerances(tmp_path, ('tolerance = "0.05 mm"', 'tolerance = "11 mm"')))
    assert "bearing_radius (from 9 mm)" in note and "journal_radius (to 10 mm)" in note and "is -1 mm" in note


@pytest.mark.parametrize("path", sorted(STUDIES.glob("*.toml")), ids=lambda path: path.stem)
def test_the_studies_of_the_repository_have_clearance(path):
    assert interference_note(load_study(path).tolerances) is None


def test_conditions_that_close_the_clearance_are_noted(tmp_path):
    hot = '[operating]\njournal_temperature = "1020 °C"\njournal_expansion = 0.0005\n[motion]'
    study = load_study(write(tmp_path, ("[motion]", hot)))
    drawn = smallest_clearance(study.tolerances)
    assert smallest_clearance(study.tolerances, study.scene.scalars) == pytest.approx(drawn - 0.01 * 0.0005 * 1000)
    assert interference_note(study.tolerances, study.scene.scalars) is None
    worn = study.scene.scalars | {"journal_expansion": 0.001}
    assert "in operation" in interference_note(study.tolerances, worn)


def test_no_clearance_at_all_is_noted(tmp_path):
    # A fit of H and h: the largest journal fills the smallest bearing.
    touching = ('nominal = "10 mm", tolerance = ["-0.03 mm", "0 mm"]', 'lower = "19.9 mm", upper = "19.95 mm"')
    assert "is 0 mm" in interference_note(tolerances(tmp_path, touching))
