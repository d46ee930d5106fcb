import math
from io import StringIO

import pytest
from rich.console import Console
from small_study import GEOMETRY, write

from tolmc import tables
from tolmc.monte_carlo import run
from tolmc.motion import study_motion
from tolmc.study import load_study


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
        ((0.0, 0.0, 0.0), 6, "0.00000"),
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
    tables.print_result(run(write(tmp_path), samples=2000), console)
    shown = text(console)
    assert "…" not in shown  # nothing is cut off
    for words in (
        "2,000 samples",
        "Tilt angle ψ",
        "deg",
        "mm",
        "Contact force N_D, mean",
        "± 0",
        "Error budget",
        "Status",
    ):
        assert words in shown or words == "± 0"


def test_requirements_with_failed_samples_are_bounded_both_ways(tmp_path, console):
    wide = ('nominal = "10 mm", tolerance = ["-0.03 mm", "0 mm"]', 'nominal = "19.95 mm", tolerance = "0.1 mm"')
    result = run(write(tmp_path, wide, *GEOMETRY), samples=2000)
    console.print(tables.requirement_table(result.requirements))
    failed = result.statuses.loc["geometry invalid", "share"]
    assert f"0 % to {100 * failed:.3g} %" in text(console)
    tables.print_result(result, console)
    assert "geometry invalid" in text(console)


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
