"""Slips that can be computed are told."""

import pytest
from click.testing import CliRunner
from small_study import GEOMETRY, write

from tolmc import cli
from tolmc.study.file import load_study
from tolmc.study.slips import slips


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (('nominal = "20 mm", tolerance = "0.05 mm"', 'nominal = "20 m", tolerance = "0.05 mm"'), ["bearing_radius", "2e+03"]),
        (('nominal = "20 mm", tolerance = "0.1 mm"', 'nominal = "20 m", tolerance = "0.1 mm"'), ["half_length = 20000 mm"]),
        (('nominal = "20 mm", tolerance = "0.1 mm"', 'nominal = "20 um", tolerance = "1 um"'), ["half_length", "1/500 of"]),
        (('alpha = "-110 deg"', "alpha = -110"), ["[motion] alpha = -110 is taken in rad", '"-110 deg"']),
        (('beta = "-50 deg"', 'beta = -50\nspin = 90'), ["[motion] beta", "[motion] spin = 90"]),
        (('tilt_angle = { max = "24.4 deg" }', "tilt_angle = { max = 24.4 }"), ["[specification] tilt_angle.max = 24.4"]),
        (("[body]", 'alpha = { tolerance = 7 }\n[body]'), ["[dimensions] alpha.tolerance = 7"]),
        (("gravity = [0, -9.81, 0]", "gravity = [0, -9810, 0]"), ["[loads] gravity = -9810", "mm/s^2"]),
        (('tilt_angle = { max = "24.4 deg" }', 'tilt_angle = { max = "90 deg" }'), ["tilt_angle.max = 90 deg says nothing"]),
        (("[specification]", '[specification]\ncontact_loss_time = { min = "5 s" }'),
         ["= 5 s is later than the motion ends, after 0.1 s"]),
        (("[specification]", '[outputs]\nsag = "5 mm"\n[specification]'), ["[outputs] sag is the same number for all parts"]),
        (("[body]", '[contact]\nfriction = 2\nslip_speed = "1 m/s"\n[body]'),
         ["friction = 2 is more", "slip_speed = 1 m/s: below it"]),
        (("[body]", '[contact]\nwear_coefficient = "0.1 mm^3/(N m)"\n[body]'),
         ["wear_coefficient = 0.1 mm³/(N m) is more than"]),
        (("[body]", '[contact]\nrestitution = 0.5\ncontact_stiffness = 100\n[body]'),
         ["100 N/m^1.5: under 4.9", "than the clearance"]),
        (('spin_rate = "80 rad/s"', 'spin_rate = "1e9 rpm"'), ["spin_rate = 1.047e+08 rad/s is 1.05e+06 m/s at the journal's"]),
        (("[body]", '[operating]\nbearing_expansion = -1e-3\nbush_wall = "1 m"\n[body]'),
         ["no metal's or plastic's", "bush_wall = 1000"]),
        (('center_of_mass = ["0 mm", "0 mm", "4 mm"]', "center_of_mass = [0, 0, 4]"), ["[body] center_of_mass = 4", "mm"]),
    ],
)  # fmt: skip
def test_a_likely_slip_is_told(tmp_path, change, words):
    inertia = ("inertia = [4.08e-4, 4.08e-4, 1.2e-4]", "centroidal_inertia = [4.08e-4, 4.08e-4, 1.2e-4]")
    told = " ".join(slips(load_study(write(tmp_path, inertia, change))))
    for word in words:
        assert word in told


@pytest.mark.parametrize(
    ("limited", "beta", "is_told"),
    [
        ("play", "-110 deg", True),
        ("play", "250 deg", True),
        ("play", "-50 deg", False),
        ("tilt_angle", "-110 deg", False),
    ],
)
def test_a_motion_that_starts_without_tilt_has_a_note_where_its_tilt_is_limited(tmp_path, limited, beta, is_told):
    own = '[outputs]\nplay = "800 mm * sin(tilt_max)"\n[specification]\nplay = { max = "3 mm" }'
    changes = [("[specification]", own)] if limited == "play" else []
    told = " ".join(slips(load_study(write(tmp_path, ('beta = "-50 deg"', f'beta = "{beta}"'), *changes))))
    assert ("For the tilt that the clearance allows write tilt_angle." in told) == is_told


def test_what_is_meant_is_not_told(tmp_path):
    assert list(slips(load_study(write(tmp_path)))) == []
    radians = ('alpha = "-110 deg"', 'alpha = "-110 rad"')  # said with its unit
    assert list(slips(load_study(write(tmp_path, radians)))) == []


@pytest.mark.usefixtures("ready_pictures")
def test_a_run_tells_and_goes_on(tmp_path):
    study = write(tmp_path, *GEOMETRY, ('alpha = "-110 deg"', "alpha = -110"))
    result = CliRunner().invoke(cli.main, ["run", str(study), "--samples", "64", "--out", str(tmp_path / "run")])
    assert result.exit_code == 0
    assert result.stderr.startswith("Note: [motion] alpha = -110 is taken in rad.")
    assert "alpha = -110 is taken in rad" in CliRunner().invoke(cli.main, ["check", str(study)]).stdout
