"""What `tolmc init`, `check`, `explain` and `schema` say is what the models read."""

import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import jsonschema
import pytest
import wearing_study
from places import ROOT, STUDIES
from small_study import TEXT, write

import tolmc
from tolmc import quantities, units
from tolmc.commands.explain import explain, markdown, study_schema
from tolmc.commands.init import KINDS, example, write_example
from tolmc.errors import InputError
from tolmc.study.dimensions import DimensionsTable
from tolmc.study.guide import guide
from tolmc.tables.understood import notes, seconds, understood_blocks

VALIDATOR = jsonschema.Draft202012Validator(study_schema())


@pytest.mark.parametrize("kind", KINDS)
def test_the_study_to_begin_with_is_one(tmp_path, kind):
    path = tmp_path / f"{kind}.toml"
    write_example(path, kind)
    study = tolmc.load_study(path)
    assert study.specification and study.tolerances.varied
    assert list(notes(study)) == []
    assert max(map(len, path.read_text(encoding="utf-8").splitlines())) <= 128


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_the_study_to_begin_with_runs_and_some_of_its_parts_break_a_limit(tmp_path, kind):
    write_example(tmp_path / "study.toml", kind)
    result = tolmc.run(tmp_path / "study.toml", samples=4096)
    assert set(result.statuses.index[result.statuses["count"] > 0]) == {"ok"}
    share = result.requirements.loc["any requirement", "share_least"]
    assert 0 < share < 0.1


def test_init_leaves_what_exists(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text("mine")
    with pytest.raises(InputError, match="exists"):
        write_example(path, "shaft")
    assert path.read_text() == "mine"
    with pytest.raises(InputError, match=r"call it .*mine\.toml"):
        write_example(tmp_path / "mine", "shaft")


@pytest.mark.parametrize(
    "text", [TEXT, *(example(kind) for kind in KINDS), *(p.read_text() for p in STUDIES.glob("*.toml"))]
)
def test_the_schema_takes_every_study(text):
    VALIDATOR.validate(tomllib.loads(text))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('mass = "0.5 kg"', "mass = -1"),
        ('mass = "0.5 kg"', 'weight = "0.5 kg"'),
        ('mass = "0.5 kg"', ""),
        ("[0, -9.81, 0]", "[0, -9.81]"),
        ('"sobol"', '"sobal"'),
        ("samples = 3000", "samples = 0.5"),
        ("{ max =", "{ maximum ="),
        ('tolerance = "0.1 mm"', 'tolerance = ["0.1 mm"]'),
        ("journal_radius =", "journal_radus ="),
    ],
)
def test_the_schema_refuses_what_the_models_refuse(tmp_path, old, new):
    assert not VALIDATOR.is_valid(tomllib.loads(TEXT.replace(old, new)))
    with pytest.raises(tolmc.study.study.StudyError):
        tolmc.load_study(write(tmp_path, (old, new)))


def test_the_description_of_the_study_file_is_the_models():
    assert (STUDIES / "README.md").read_text(encoding="utf-8") == markdown(), (
        "tolmc explain --markdown > studies/README.md"
    )


def test_every_field_says_what_it_means():
    for table in guide(study_schema()):
        assert table.meaning, table.name
        for field in table.fields:
            assert field.meaning.endswith(".") and field.written, field.place
            assert "".join(field.meaning.split()) in "".join(explain(field.place).split())  # however the lines break


def test_everything_that_has_a_name_can_be_asked_for():
    for name in (*quantities.SCALARS, *quantities.OUTPUTS):
        assert quantities.label(name) in explain(name)
        VALIDATOR.validate({**tomllib.loads(TEXT), **_example(name)})
    assert "[body] mass" in explain("body.mass") == explain("[body] mass")
    assert "optional" in explain("force_point") and "required" in explain("duration")
    with pytest.raises(InputError, match="did you mean 'gravity'"):
        explain("gravty")
    assert explain("specification.sag").startswith("[specification.NAME]") and "max" in explain("specification.sag")
    with pytest.raises(InputError, match="'tolmc explain outputs' says how an output of the study's own is named"):
        explain("sag")
    contents = explain(None)
    assert all(f"[{table.name}]" in contents for table in guide(study_schema()) if table.name)


_JOINT = tomllib.loads(TEXT)["dimensions"]


def _example(name: str) -> dict:
    """What `tolmc explain` gives as an example of a tolerance or a limit, read as a study is."""
    match = re.search(r"\[(dimensions|specification)\] (\w+ = .+)$", explain(name), re.MULTILINE)
    section, found = match[1], tomllib.loads(match[2])
    if section == "dimensions":
        assert name in DimensionsTable({**_JOINT, **found}, Path()).entries
        return {section: {**_JOINT, **found}}
    low, high = quantities.output(name).range
    assert all(low < units.read(limit, quantities.unit(name)) < high for limit in found[name].values())
    return {section: found}


def test_check_says_what_it_understood(tmp_path):
    _, dimensions, understood, *rest = understood_blocks(tolmc.load_study(write(tmp_path)))
    assert [cell.content for cell in dimensions.rows[0]][:2] == ["Bearing radius R*", "⌀40"]
    facts = {row[0].content: row[1].content for row in understood.rows}
    assert facts["Clearance"].startswith("20 mm on the diameter, 19.9 to 20.16 mm")
    assert facts["Tilt allowed"].startswith("24.3 deg, ")
    assert facts["Computed"] == "3,000 motions, scrambled Sobol' points, seed 7, 2 workers"
    assert "≤ 4.5 N" in facts["Requirement"]
    assert [note.text for note in rest] == ["The study can be run."]
    wide = tolmc.load_study(write(tmp_path, ('tolerance = "0.05 mm"', 'tolerance = "11 mm"')))
    assert "overlap" in next(notes(wide))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["paper_joint", "horizontal_shaft", "vertical_spindle"])
def test_the_time_guessed_is_right_to_a_factor_of_three(name):
    from tolmc.runs.integrate import study_plan

    study = tolmc.load_study(STUDIES / f"{name}.toml")
    guessed = seconds(study) - seconds(study.replaced(samples=1))
    steps = study_plan(study).steps
    each = {True: 0.2e-6, False: 0.8e-6}[study.scene.body.is_symmetric]
    assert 1 / 3 < guessed / (study.samples * steps * each / study.workers) < 3


@pytest.mark.slow
def test_the_wheel_has_everything_of_the_package(tmp_path):
    tracked = subprocess.run(["git", "ls-files"], cwd=ROOT, check=True, capture_output=True, text=True).stdout.split()
    for name in tracked:  # pip builds where the sources are
        (tmp_path / "source" / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / "source" / name)
    pip = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "-w", tmp_path, tmp_path / "source"]
    subprocess.run(pip, check=True, capture_output=True)
    (wheel,) = tmp_path.glob("*.whl")
    packed = set(zipfile.ZipFile(wheel).namelist())
    assert {name for name in tracked if name.startswith("tolmc/")} - packed == set()


def test_check_says_where_an_unbalanced_rotor_has_its_centre_of_mass_and_what_share_is_asked_for(tmp_path):
    write_example(tmp_path / "rotor.toml", "rotor")
    _, _, understood, *_ = understood_blocks(tolmc.load_study(tmp_path / "rotor.toml"))
    facts = {row[0].content: row[1].content for row in understood.rows}
    assert "centre of mass (0.00000 to 0.02005, 0, 0) mm" in facts["Body"]
    assert "not symmetric" in facts["Body"]
    assert facts["Target"] == "99 % of the parts keep every limit"


def test_check_says_what_rubs_swings_and_wears(tmp_path):
    terms = (
        '[loads]\nforce_terms = [ { amplitude = [0, "2 N", 0], frequency = "25 Hz", phase = "90 deg", axes = "body" } ]'
    )
    swing = '{ amplitude = "30 deg", frequency = "0.5 Hz" }'
    study = wearing_study.study(tmp_path, ("[loads]", terms), ('drive = "constant speed"', f"drive = {swing}"))
    _, _, understood, *_ = understood_blocks(study)
    facts = {row[0].content: row[1].content for row in understood.rows}
    assert facts["Drive"] == "swings by ±30 deg at 0.5 Hz"
    assert "force term 1 (0, 2, 0) N at 25 Hz, phase 90 deg in axes that turn with the body" in facts["Loads"]
    assert facts["Contact"] == "friction 0.15 at slips above 0.0001 m/s, wear 1·10⁻⁵ mm³/(N m)"
    assert "5 % of the parts break a limit, up to 1000 h" in facts["Life"]
