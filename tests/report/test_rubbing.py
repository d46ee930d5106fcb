"""The report's sections on friction, drive, wear and life."""

import re

import pytest
import wearing_study

from tolmc.commands.life import life_study
from tolmc.report.rubbing import of_life, of_rubbing
from tolmc.report.write import write_report
from tolmc.runs.record import RunDirectoryError
from tolmc.runs.run import run


@pytest.mark.slow
def test_a_report_has_friction_drive_wear_and_life(tmp_path):
    study = wearing_study.study(tmp_path, ("[life]", "[life]\nsteps = 3"))
    result = run(study, out=tmp_path / "run")
    found = life_study(tmp_path / "run")
    write_report(tmp_path / "run")
    text = (tmp_path / "run" / "report.md").read_text(encoding="utf-8")
    friction, life = (
        text.split(f"## {name}\n", 1)[1].split("\n## ", 1)[0] for name in ("Friction, drive and wear", "Life")
    )
    power, torque, rate = (result.summary.at[name, "q50"] for name in
                           ("friction_power_mean", "drive_torque_max", "wear_rate"))  # fmt: skip
    assert f"turns {power:.3g} W" in friction
    assert f"drive gives at most {torque:.3g} N m" in friction
    assert f"{3.6e12 * rate:.3g} mm³/h" in friction
    assert f"{found.life.value:.4g} h" in life and "life.png" in life
    assert len(re.findall(r"^\| [\d,.]+ \|", life, re.M)) == 4
    page = (tmp_path / "run" / "report.html").read_text(encoding="utf-8")
    assert "<h2>Life</h2>" in page and "<h2>Friction, drive and wear</h2>" in page


def test_a_study_without_them_has_no_such_sections(tmp_path):
    assert of_rubbing(wearing_study.study(tmp_path), None) == []
    assert of_life(tmp_path) == []
    (tmp_path / "life.json").write_text("{}")
    with pytest.raises(RunDirectoryError, match=r"life\.json is damaged: .* run tolmc life"):
        of_life(tmp_path)
