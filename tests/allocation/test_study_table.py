"""The [allocation] table of a study file, and the command that reads it."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from small_study import GEOMETRY, write

from tolmc import tilt_angle
from tolmc.allocation.allocate import Grades, Plan, allocate, with_widths, zone
from tolmc.allocation.offers import offered_box
from tolmc.allocation.study_table import _choice, read_plan
from tolmc.cli import main
from tolmc.commands.allocate import allocate_study
from tolmc.commands.check import check_study
from tolmc.errors import InputError
from tolmc.study.file import load_study
from tolmc.study.study import StudyError
from tolmc.tolerances import fits
from tolmc.tolerances.dimension import Dimension, Tolerances
from tolmc.tolerances.distributions import Uniform
from tolmc.tolerances.draw import sample

ALLOCATION = """
[allocation]
target_yield = "99 %"
samples = 20000

[allocation.dimensions]
bearing_radius = { grades = { IT8 = 6.0, IT9 = 4.2, IT10 = 3.1 } }
journal_radius = { grades = { IT7 = 3.6, IT6 = 5.5, IT8 = 2.5, IT9 = 1.9 }, anchor = "upper" }
half_length = { narrowest = "0.01 mm", widest = "0.4 mm", cost = { fixed = 0.8, variable = 1.2, at = "0.1 mm" } }
"""


def study_file(folder, *changes):
    text = ALLOCATION
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    return write(folder, *GEOMETRY, ("[specification]", text + "\n[specification]"))


def test_plan_of_a_study_file(tmp_path):
    plan = read_plan(load_study(study_file(tmp_path)))
    bore, journal, length = plan.choices
    assert (plan.target_yield, plan.confidence, plan.samples, plan.seed) == (0.99, 0.95, 20000, 7)
    assert bore.labels == ("IT7", "IT8", "IT9", "IT10", "IT11") and bore.offered == (1, 2, 3)
    assert bore.costs[1:4] == (6.0, 4.2, 3.1) and np.isnan(bore.costs[0]) and np.isnan(bore.costs[4])
    assert bore.widths == pytest.approx([0.5 * fits.it_grade(40, grade) for grade in range(7, 12)])
    assert (bore.narrowest, bore.widest) == (bore.widths[1], bore.widths[3])
    assert journal.labels == ("IT5", "IT6", "IT7", "IT8", "IT9", "IT10") and journal.anchor == "upper"
    assert (length.narrowest, length.widest, length.at) == pytest.approx((1e-5, 4e-4, 1e-4))
    assert (length.fixed, length.variable, length.law) == (0.8, 1.2, "reciprocal")


@pytest.mark.parametrize(
    ("dimension", "grade", "micrometres"),
    [
        (Dimension.from_fit("50 H7/d9")[0], "IT7", 12.5),
        (Dimension.from_tolerance_class("half_length", "80 h9"), "IT9", 37.0),
        (Dimension.from_deviations("journal_radius", 0.025, -80e-6, -40e-6), "IT7", 12.5),
    ],
)
def test_grades_are_those_of_the_basic_size_at_the_end_of_its_row(dimension, grade, micrometres):
    study = SimpleNamespace(tolerances=Tolerances((dimension,)))
    choice = _choice(study, dimension.name, {"grades": {grade: 1.0}})
    assert choice.widths[1] == pytest.approx(micrometres * 1e-6)


def of_class(size):
    """The dimension that may have this class: capitals are a hole's."""
    return "bearing_radius" if size.split()[1][0].isupper() else "journal_radius"


@pytest.mark.parametrize(
    ("size", "grade", "labels"),
    [
        ("40 H7", "IT18", ("IT17", "IT18")),
        ("40 h7", "IT01", ("IT01", "IT0")),
        ("40 K7", "IT8", ("IT7", "IT8")),  # the standard has no K9 here
        ("2 js7", "IT17", ("IT16", "IT17", "IT18")),
    ],
)
def test_grades_beside_the_offer_are_those_of_the_standard(size, grade, labels):
    name = of_class(size)
    study = SimpleNamespace(tolerances=Tolerances((Dimension.from_tolerance_class(name, size),)))
    assert _choice(study, name, {"grades": {grade: 1.0}}).labels == labels


def test_a_grade_beside_the_offer_shows_its_yield_by_true_motions():
    """Where the surrogate was not trained the output jumps; the cheapest choice is the coarsest on offer."""

    def kinked(inputs):
        return pd.DataFrame({"y": np.where(inputs["alpha"].abs() > 0.05, 1.0, 0.0), "status": "ok"})

    wide = Tolerances((Dimension("alpha", 0.0, -0.1, 0.1, Uniform()),))
    choice = Grades("alpha", ("IT5", "IT6", "IT7"), (0.05, 0.1, 0.2), (2.0, 1.0, np.nan))
    result = allocate(wide, {"y": {"max": 0.5}}, Plan((choice,), 0.99, samples=4000), kinked)
    assert result.winner.labels == ("IT6",)
    coarser = result.neighbours.set_index("direction").loc["coarser"]
    assert coarser["to"] == "IT7" and np.isnan(coarser["cost"]) and np.isnan(coarser["cost_change"])
    assert coarser["predicted_yield"] == pytest.approx(0.5, abs=0.03)
    assert result.motions == 512 + 3 * 4000


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('"99 %"', "1.0"), r"\[allocation\] target_yield = 1.0: expected a share between 0 and 1"),
        (
            ("samples = 20000", "confidence = 0.5"),
            r"\[allocation\] confidence = 0.5: expected a share between 0.5 and 1",
        ),
        (("half_length =", "mass ="), r"\[allocation\] dimensions.mass is unknown.*allowed: bearing_radius"),
        (('anchor = "upper"', 'anchor = "top"'), r"journal_radius.anchor = 'top' is not possible.*'nominal', 'lower'"),
        (("IT10 = 3.1", "IT99 = 3.1"), r"bearing_radius.grades: ISO 286: grade 'IT99' is unknown"),
        (("{ IT8 = 6.0, IT9 = 4.2, IT10 = 3.1 }", "{}"), r"bearing_radius.grades is empty; give at least one grade"),
        (('narrowest = "0.01 mm", ', ""), r"half_length.narrowest is missing; give the narrowest zone"),
        (('"0.4 mm"', '"0.001 mm"'), r"half_length = .*: expected at > 0 and 0 < narrowest < widest"),
        (("variable = 1.2, ", ""), r"half_length.cost.variable is missing; give the cost on top of fixed"),
        ((', at = "0.1 mm" }', ', at = "0.1 mm", law = "linear" }'), r"law = 'linear' is not possible.*'reciprocal'"),
        (("cost = {", "grades = { IT7 = 1 }, cost = {"), r"half_length = .*: expected either grades or cost"),
    ],
)
def test_plans_that_cannot_be_used(tmp_path, change, message):
    path = study_file(tmp_path, change)
    for read in (lambda: read_plan(load_study(path)), lambda: check_study(path)):
        with pytest.raises(StudyError, match=message):
            read()


def test_study_without_allocation_or_specification(tmp_path):
    with pytest.raises(StudyError, match=r"\[allocation\] is missing; say there what tolerances cost"):
        read_plan(load_study(write(tmp_path)))
    without = write(tmp_path, *GEOMETRY, ('[specification]\ntilt_angle = { max = "24.4 deg" }', ALLOCATION))
    with pytest.raises(StudyError, match=r"\[specification\] is missing; an allocation needs limits"):
        allocate_study(without, out=tmp_path)


@pytest.mark.slow
def test_allocation_of_a_study_end_to_end(tmp_path, capsys):
    result = allocate_study(study_file(tmp_path), out=tmp_path / "out")
    printed = capsys.readouterr().out
    for words in (
        "the cheapest tolerances",
        "Cost against yield",
        "One grade up or down (–: not on offer; yield of 10,000 motions)",
        "which reaches the required 99.0000 %",
    ):
        assert words in printed
    written = pd.read_csv(tmp_path / "out/dimensions.csv", index_col="dimension")
    assert written.loc["bearing_radius", "grade"] == result.dimensions.loc["bearing_radius", "grade"]
    assert len(pd.read_csv(tmp_path / "out/trade_off.csv")) == len(result.trade_off)
    files = ("dimensions.csv", "trade_off.csv", "neighbours.csv", "cost_against_yield.png")
    assert f"({', '.join(files)})" in printed.replace("\n", "")
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == sorted(files)
    # Motions that took part in nothing: the winner's yield by the geometry alone.
    inputs = sample(result.tolerances, 200_000, sampling="random", seed=123)
    share = np.mean(tilt_angle(*(inputs[name].to_numpy() for name in inputs)) <= np.radians(24.4))
    assert share == pytest.approx(result.predicted_yield, abs=1.5e-3)
    assert share >= 0.99


ISO = (
    ('bearing_radius = { nominal = "20 mm", tolerance = "0.05 mm" }', 'fit = "40 H7/d9"'),
    ('journal_radius = { nominal = "10 mm", tolerance = ["-0.03 mm", "0 mm"] }\n', ""),
    ('nominal = "20 mm", tolerance = "0.1 mm", distribution = "uniform"', 'diameter = "40 js9"'),
)


@pytest.mark.parametrize(
    ("anchor", "bore", "length"),
    [
        ("", (20.0, 20.031), (20.0 - 0.05, 20.0 + 0.05)),
        (', anchor = "middle"', (20.00625 - 0.0155, 20.00625 + 0.0155), (20.0 - 0.05, 20.0 + 0.05)),
        (', anchor = "upper"', (20.0125 - 0.031, 20.0125), (20.0155 - 0.1, 20.0155)),
    ],
)
def test_zones_of_a_fit_keep_their_letters(tmp_path, anchor, bore, length):
    text = f"""[allocation.dimensions]
bearing_radius = {{ grades = {{ IT9 = 1.0, IT7 = 2.0 }}{anchor} }}
half_length = {{ narrowest = "0.01 mm", widest = "0.4 mm", cost = {{ variable = 1, at = "0.1 mm" }}{anchor} }}

[specification]"""
    study = load_study(write(tmp_path, *ISO, ("[specification]", text)))
    chosen = with_widths(study.tolerances, read_plan(study).choices, [31e-6, 100e-6]).dimensions
    found = {d.name: (1e3 * d.lower, 1e3 * d.upper) for d in chosen}
    assert found["bearing_radius"] == pytest.approx(bore, abs=1e-9)
    assert found["half_length"] == pytest.approx(length, abs=1e-9)
    assert found["journal_radius"] == pytest.approx((19.929, 19.96))
    assert chosen[0].toleranced_size == (None if anchor else "40 H9")


@pytest.mark.parametrize(
    ("size", "limits"),
    [("40 d9", (-0.04 - 0.1, -0.04)), ("40 h6", (-0.1, 0.0)), ("40 D9", (0.04, 0.14)), ("40 JS7", (-0.05, 0.05))],
)
def test_free_zones_of_a_class_hold_its_fundamental_deviation(size, limits):
    dimension = Dimension.from_tolerance_class(of_class(size), size)
    assert [1e3 * limit - 20.0 for limit in zone(dimension, 0.1e-3)] == pytest.approx(limits)


def test_training_covers_zones_that_lie_beside_each_other():
    """ES of P6 is -21 um at 40 mm, that of P8 -26 um: the wider zone does not hold the narrower one."""
    dimension = Dimension.from_tolerance_class("bearing_radius", "40 P7", distribution=Uniform())
    sizes = ("40 P6", "40 P8")
    widths = tuple(0.5 * fits.it_grade(40, grade) for grade in (6, 8))
    choice = Grades("bearing_radius", ("IT6", "IT8"), widths, (2.0, 1.0), toleranced_sizes=sizes)
    low, high = offered_box(Tolerances((dimension,)), [choice])["bearing_radius"]
    assert (low, high) == pytest.approx((0.02 - 32.5e-6, 0.02 - 10.5e-6), abs=1e-9)


def test_zones_that_no_dimension_can_have_are_told(tmp_path):
    study = study_file(tmp_path, ('widest = "0.4 mm"', 'widest = "50 mm"'))
    with pytest.raises(InputError, match=r"half_length: nominal = 0\.02, limits -0\.00.*allowed: > 0"):
        allocate_study(study, out=tmp_path)


def test_command_ends_with_a_code_when_the_requirement_is_not_shown(tmp_path):
    falling = (("gravity = [0, -9.81, 0]", "gravity = [0, 9.81, 0]"), ("24.4 deg", "26 deg"))
    text = """[allocation]
target_yield = 0.9
samples = 200

[allocation.dimensions]
bearing_radius = { grades = { IT7 = 1.0 } }

[specification]"""
    study = write(tmp_path, *falling, ("[specification]", text), ('max = "4.5 N"', 'max = "50 N"'))
    done = CliRunner().invoke(main, ["allocate", str(study), "--out", str(tmp_path / "out")])
    assert done.exit_code == 3, done.output
    assert "NOT SHOWN TO SUFFICE" in done.output and "200 (100 %) lost" in done.output
    meant = write(tmp_path, *falling, ("[specification]", text), ('max = "4.5 N"', 'max = "50 N"'),
                  ("[monte_carlo]", '[monte_carlo]\non_contact_loss = "continue"'), name="meant.toml")  # fmt: skip
    done = CliRunner().invoke(main, ["allocate", str(meant), "--out", str(tmp_path / "out")])
    assert done.exit_code == 0, done.output
    assert "the cheapest tolerances" in done.output
