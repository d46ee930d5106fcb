"""What swings in a study file: a drive and parts of the loads, their units and tolerances, and what they cannot be."""

import math

import pytest
from small_study import write

import tolmc
from tolmc.study.file import load_study
from tolmc.study.study import StudyError

SWING = '[loads]\ndrive = { amplitude = "30 deg", frequency = "0.5 Hz", phase = "90 deg" }'
TERMS = """[loads]
force_terms = [
    { amplitude = ["0 N", "2 N", "0 N"], frequency = "25 Hz" },
    { amplitude = ["1 N", "0 N", "0 N"], frequency = 0, phase = "90 deg", axes = "body" },
]
torque_terms = [ { amplitude = [0, 0, "5 N mm"], frequency = "10 Hz" } ]
"""


def load(folder, new, *changes):
    return load_study(write(folder, ("[loads]", new), *changes))


def test_a_drive_that_swings_is_read_and_may_have_tolerances(tmp_path):
    varied = '\n[dimensions.drive_amplitude]\ntolerance = "2 deg"\n[dimensions.drive_frequency]\ntolerance = "0.1 Hz"\n'
    study = load(tmp_path, SWING, ("\n[body]", f"{varied}[body]"))
    drive = study.scene.loads.drive
    assert (drive.amplitude, drive.frequency, drive.phase) == pytest.approx((math.pi / 6, 0.5, math.pi / 2), rel=1e-15)
    limits = {dimension.name: (dimension.lower, dimension.upper) for dimension in study.tolerances.dimensions}
    assert limits["drive_frequency"] == pytest.approx((0.4, 0.6))
    changed = study.scene.replaced(drive_amplitude=0.1, drive_frequency=2.0)
    assert changed.loads.drive == tolmc.Oscillation(0.1, 2.0, math.pi / 2)


def test_parts_that_swing_are_read_and_may_have_tolerances(tmp_path):
    varied = (
        '\n[dimensions.force_term_1_y]\ntolerance = "0.5 N"\n[dimensions.torque_term_1_phase]\ntolerance = "5 deg"\n'
    )
    study = load(tmp_path, TERMS, ("\n[body]", f"{varied}[body]"))
    loads = study.scene.loads
    assert loads.force_terms == (tolmc.Harmonic((0, 2, 0), 25.0), tolmc.Harmonic((1, 0, 0), 0.0, math.pi / 2, "body"))
    assert loads.torque_terms == (tolmc.Harmonic((0, 0, 5e-3), 10.0),)
    assert loads.turning == (False, True, False, False)
    limits = {dimension.name: (dimension.lower, dimension.upper) for dimension in study.tolerances.dimensions}
    assert limits["force_term_1_y"] == pytest.approx((1.5, 2.5))
    changed = study.scene.replaced(force_term_2_x=3.0).loads
    assert changed.force_terms == (loads.force_terms[0], tolmc.Harmonic((3, 0, 0), 0.0, math.pi / 2, "body"))
    assert changed.torque_terms == loads.torque_terms


@pytest.mark.parametrize(
    ("new", "complaint"),
    [
        (SWING.replace("0.5 Hz", "0.5 rad/s"), r"\[loads\] drive.frequency = '0.5 rad/s': .* not that of a frequency"),
        (SWING.replace("0.5 Hz", "-1 Hz"), r"\[loads\] drive.frequency = '-1 Hz': expected a frequency >= 0"),
        (SWING.replace('"30 deg"', '"30 mm"'), r"\[loads\] drive.amplitude"),
        (SWING.replace("phase", "phases"), r"\[loads\] drive.phases = '90 deg' is unknown; did you mean 'phase'"),
        (SWING.replace('amplitude = "30 deg", ', ""), r"\[loads\] drive.amplitude is missing"),
        (TERMS.replace('"2 N"', '"2 mm"'), r"\[loads\] force_terms.0.amplitude"),
        (TERMS.replace('axes = "body"', 'axes = "shaft"'), "'fixed' or 'body'"),
        (TERMS.replace(', frequency = "10 Hz"', ""), "torque_terms.0.frequency is missing"),
        (TERMS.replace("force_terms = [", "force_terms = [ { amplitude = [0, 0, 0], frequency = 1 },"), "at most 2"),
    ],
)
def test_what_cannot_be_is_named(tmp_path, new, complaint):
    with pytest.raises(StudyError, match=complaint):
        load(tmp_path, new)


@pytest.mark.parametrize("name", ["drive_amplitude", "force_term_2_x"])
def test_what_does_not_swing_cannot_vary(tmp_path, name):
    varied = f"\n[dimensions.{name}]\ntolerance = 0.1\n"
    with pytest.raises(StudyError, match=f"{name} varies, but the loads have none"):
        load(tmp_path, "[loads]", ("\n[body]", f"{varied}[body]"))
