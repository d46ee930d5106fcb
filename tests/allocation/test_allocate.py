"""The cheapest tolerances: against exact optima, and confirmed by true motions."""

from dataclasses import replace
from io import StringIO
from itertools import product, takewhile

import numpy as np
import pandas as pd
import pytest
from rich.console import Console
from scipy.stats import norm

from tolmc.allocation.allocate import Curve, Grades, Inspection, Plan, _planned_yield, allocate
from tolmc.errors import InputError
from tolmc.statistics.intervals import binomial_interval
from tolmc.tables.allocation import allocation_blocks
from tolmc.tables.table import Note
from tolmc.terminal.grid import show
from tolmc.tolerances.dimension import Dimension, Tolerances
from tolmc.tolerances.distributions import Measured, Normal, Uniform
from tolmc.tolerances.draw import sample

NAMES = ("alpha", "beta", "spin")
SLOPES = np.array([3.0, 2.0, 1.0])
WEIGHTS = (1.0, 2.0, 1.0)
TOLERANCES = Tolerances(tuple(Dimension(name, 0.0, -0.1, 0.1, Normal(truncated=False)) for name in NAMES))
LIMIT = 0.3
SPECIFICATION = {"y": {"max": LIMIT}}
CURVES = tuple(Curve(name, 0.02, 3.0, at=0.1, variable=w) for name, w in zip(NAMES, WEIGHTS, strict=True))
GRADES = tuple(
    Grades(
        name,
        ("IT5", "IT6", "IT7", "IT8", "IT9", "IT10", "IT11"),
        tuple(0.05 * 1.6**i for i in range(7)),
        tuple(w / 1.6**i for i in range(7)),
    )
    for name, w in zip(NAMES, WEIGHTS, strict=True)
)


def linear(inputs):
    return pd.DataFrame({"y": inputs[list(NAMES)].to_numpy() @ SLOPES, "status": "ok"})


def exact_yield(widths):
    """P(slopes . x <= limit) with x normal, sd = T/6."""
    return norm.cdf(LIMIT / np.linalg.norm(SLOPES * np.asarray(widths) / 6.0))


def lagrange_optimum(required):
    """min sum_j w_j at/T_j with sum (a_j T_j/6)^2 = s^2: T_j is proportional to (w_j/a_j^2)^(1/3)."""
    widths = (np.array(WEIGHTS) / SLOPES**2) ** (1.0 / 3.0)
    widths *= LIMIT / norm.ppf(required) / np.linalg.norm(SLOPES * widths / 6.0)
    return widths, float(np.sum(np.array(WEIGHTS) * 0.1 / widths))


@pytest.mark.slow
def test_free_widths_are_those_of_lagrange():
    result = allocate(TOLERANCES, SPECIFICATION, Plan(CURVES, 0.99, samples=20_000, seed=3), linear)
    reached = exact_yield(result.winner.widths)
    widths, cost = lagrange_optimum(reached)
    assert result.winner.cost == pytest.approx(cost, rel=5e-3)
    np.testing.assert_allclose(result.winner.widths, widths, rtol=0.1)
    assert result.predicted_yield == pytest.approx(reached, abs=2e-4)
    assert result.is_met and result.confirmed.low >= 0.99
    assert result.winner.cost < 1.1 * lagrange_optimum(0.99)[1]


@pytest.mark.slow
def test_grades_are_those_of_trying_all():
    result = allocate(TOLERANCES, SPECIFICATION, Plan(GRADES, 0.99, samples=50_000, seed=1), linear)
    costs = {}
    for chosen in product(range(7), repeat=3):
        if exact_yield([choice.widths[i] for choice, i in zip(GRADES, chosen, strict=True)]) >= 0.991:
            costs[chosen] = sum(choice.costs[i] for choice, i in zip(GRADES, chosen, strict=True))
    cheapest = min(costs, key=costs.get)
    assert result.winner.labels == tuple(choice.labels[i] for choice, i in zip(GRADES, cheapest, strict=True))
    assert result.winner.cost == pytest.approx(costs[cheapest])
    assert result.motions == 512 + 50_000 + 10_000


@pytest.mark.slow
def test_grades_and_free_widths_together():
    few = [
        replace(choice, labels=choice.labels[1:5], widths=choice.widths[1:5], costs=choice.costs[1:5])
        for choice in (GRADES[0], GRADES[2])
    ]
    choices = (few[0], CURVES[1], few[1])
    result = allocate(TOLERANCES, SPECIFICATION, Plan(choices, 0.99, samples=20_000, seed=3), linear)
    reached = exact_yield(result.winner.widths)
    spare = (LIMIT / norm.ppf(reached)) ** 2
    best = np.inf
    for i, j in product(range(4), repeat=2):
        rest = spare - (SLOPES[0] * few[0].widths[i] / 6.0) ** 2 - (SLOPES[2] * few[1].widths[j] / 6.0) ** 2
        if rest > 0.0:
            width = 6.0 * rest**0.5 / SLOPES[1]
            best = min(best, few[0].costs[i] + few[1].costs[j] + CURVES[1].cost(width))
    assert result.winner.cost == pytest.approx(best, rel=2e-3)


@pytest.mark.slow
def test_trade_off_and_neighbours():
    choices = (*GRADES[:2], CURVES[2])
    result = allocate(TOLERANCES, SPECIFICATION, Plan(choices, 0.98, samples=20_000, seed=2), linear)
    table = result.trade_off
    assert table["cost"].is_monotonic_increasing
    assert (table["predicted_yield"] >= table["required_yield"]).all()
    assert 0.98 in table["required_yield"].to_numpy()
    neighbours = result.neighbours.set_index(["dimension", "direction"])
    for name, row in result.dimensions.iterrows():
        finer, coarser = (neighbours.loc[(name, direction)] for direction in ("finer", "coarser"))
        assert finer["cost_change"] > 0 > coarser["cost_change"]
        assert finer["out_ppm"] < coarser["out_ppm"]
        assert row["upper"] - row["lower"] == pytest.approx(row["width"])
    step = neighbours.loc[("spin", "coarser"), "to"] / neighbours.loc[("spin", "coarser"), "from"]
    assert step == pytest.approx(10**0.2)
    assert result.dimensions["cost"].sum() == pytest.approx(result.winner.cost)
    present = result.present_yield
    assert (present.samples, present.unknown) == (10_000, 0)
    assert present.value == pytest.approx(exact_yield([0.2] * 3), abs=4e-3)
    assert present.high - present.low < 0.01


@pytest.mark.slow
def test_confirmation_is_clopper_pearson_on_motions_of_another_seed():
    plan = Plan(GRADES, 0.99, samples=20_000, seed=5)
    result = allocate(TOLERANCES, SPECIFICATION, plan, linear)
    values = linear(sample(result.tolerances, plan.samples, sampling="random", seed=plan.seed + result.attempts))["y"]
    good = int((values <= LIMIT).sum())
    assert result.confirmed.value == good / plan.samples
    # The first run may err with half of the probability that the statement may: 2.5 %, one-sided.
    assert result.attempts == 1
    assert result.confirmed.low == pytest.approx(binomial_interval(good, plan.samples, confidence=0.95)[0])


def with_status(status, y=None):
    """The linear model with a status, and another y if given, where alpha is above 0."""

    def model(inputs):
        outputs = linear(inputs)
        half = inputs["alpha"] > 0.0
        outputs.loc[half, "status"] = status
        if y is not None:
            outputs.loc[half, "y"] = y
        return outputs

    return model


def printed(result):
    """The winner and the verdict; the tables after them are of named outputs."""
    console = Console(record=True, width=400, file=StringIO())
    names = [choice.name for choice in result.plan.choices]
    blocks = allocation_blocks(result, title="A study", shown_names=dict(zip(names, names, strict=True)))
    show([next(blocks), *takewhile(lambda block: isinstance(block, Note), blocks)], console)
    return console.export_text()


@pytest.mark.slow
def test_failed_motions_count_as_bad_and_are_told():
    failing = with_status("diverged", y=np.nan)
    result = allocate(TOLERANCES, SPECIFICATION, Plan(GRADES[:1], 0.99, samples=2000, seed=5), failing)
    confirmed = result.confirmed
    assert not result.is_met and result.attempts > 1
    assert confirmed.value == pytest.approx(0.5, abs=0.05)
    assert confirmed.high > 0.99 and confirmed.unknown == confirmed.failed == pytest.approx(1000, abs=100)
    assert result.surrogate.failed == 256
    text = printed(result)
    assert "the cheapest" not in text and "NOT SHOWN TO SUFFICE" in text
    assert f"Of these motions {confirmed.failed:,} (" in text and "256 (50 %) of the training motions failed" in text


@pytest.mark.slow
def test_motions_that_lost_contact_are_known_only_when_the_study_says_so():
    plan = Plan(GRADES[:1], 0.99, samples=2000, seed=5)
    lost = with_status("contact lost")
    result = allocate(TOLERANCES, SPECIFICATION, plan, lost)
    confirmed = result.confirmed
    assert not result.is_met and confirmed.low < 0.55 and confirmed.high > 0.99
    assert confirmed.unknown == confirmed.contact_lost == pytest.approx(1000, abs=100)
    assert result.surrogate.contact_lost == 256
    assert f"{confirmed.contact_lost:,} (" in printed(result)
    known = allocate(TOLERANCES, SPECIFICATION, plan, lost, on_contact_loss="continue")
    assert known.is_met and known.confirmed.unknown == 0 and known.confirmed.contact_lost > 0


def test_a_limit_broken_before_contact_is_lost_may_still_be_kept_in_the_end():
    """Only an extreme stays broken; y is none."""
    inspection = Inspection(with_status("contact lost", y=2.0 * LIMIT), SPECIFICATION, on_contact_loss="stop")
    found = inspection.yield_of(TOLERANCES, 2000, 1, 0.95)
    assert found.unknown == found.contact_lost > 900 and found.low < 0.55 and found.high == 1.0


def test_choices_that_all_fail_are_the_last_tried():
    lost = with_status("contact lost")
    one = tuple(replace(choice, labels=("IT5",), widths=(0.05,), costs=(1.0,)) for choice in GRADES)
    result = allocate(TOLERANCES, SPECIFICATION, Plan(one, 0.99, samples=2000), lost)
    assert not result.is_met and result.attempts == 1 and result.winner.labels == ("IT5",) * 3


def test_present_yield_is_that_of_motions_not_of_the_surrogate():
    """Outside the zones on offer the output does what no polynomial from within could say."""

    def kinked(inputs):
        return pd.DataFrame({"y": np.where(inputs["alpha"].abs() > 0.05, 1.0, inputs["alpha"]), "status": "ok"})

    wide = Tolerances((Dimension("alpha", 0.0, -0.1, 0.1, Uniform()),))
    plan = Plan((Curve("alpha", 0.01, 0.05, 0.1, 1.0),), 0.99, samples=4000)
    result = allocate(wide, {"y": {"max": 0.5}}, plan, kinked)
    assert result.is_met
    assert result.present_yield.value == pytest.approx(0.5, abs=0.03)
    assert result.present_yield.low < 0.5 < result.present_yield.high
    assert f"of {result.present_yield.samples:,} motions" in printed(result)


def test_widest_zone_is_taken_where_it_is_best():
    """A uniform zone from 0 to T: the share 1 - m/T above a minimum m rises with T."""
    tolerances = Tolerances((Dimension("alpha", 0.1, 0.0, 0.2, Uniform()),))
    choice = Curve("alpha", 0.01, 0.8, at=0.1, variable=1.0, anchor="lower")
    result = allocate(tolerances, {"y": {"min": 0.005}}, Plan((choice,), 0.95, samples=20_000), first)
    assert result.is_met and result.winner.widths == (0.8,)


def test_widths_between_two_that_miss_are_found():
    """With a maximum M as well, the share (M - m)/T falls again beyond T = M: the widest zone misses, too."""
    tolerances = Tolerances((Dimension("alpha", 0.1, 0.0, 0.2, Uniform()),))
    choice = Curve("alpha", 0.01, 0.8, at=0.1, variable=1.0, anchor="lower")
    plan = Plan((choice,), 0.95, samples=20_000)
    result = allocate(tolerances, {"y": {"min": 0.005, "max": 0.6}}, plan, first)
    assert result.is_met
    assert result.winner.widths[0] == pytest.approx(0.595 / _planned_yield(plan, tolerances), rel=2e-3)


def first(inputs):
    return pd.DataFrame({"y": inputs["alpha"], "status": "ok"})


def test_choices_off_the_way_from_widest_to_narrowest_are_found():
    """One dimension must be wide and the other narrow: no choice between the two extremes does."""

    def model(inputs):
        return pd.DataFrame({"y": inputs["alpha"], "z": inputs["beta"], "status": "ok"})

    zones = tuple(Dimension(name, 0.05, 0.0, 0.1, Uniform()) for name in ("alpha", "beta"))
    choices = tuple(Curve(name, 0.01, 1.0, at=0.1, variable=1.0, anchor="lower") for name in ("alpha", "beta"))
    specification = {"y": {"min": 0.02}, "z": {"max": 0.02}}
    result = allocate(Tolerances(zones), specification, Plan(choices, 0.95, samples=20_000), model)
    wide, narrow = result.winner.widths
    assert result.is_met and (1.0 - 0.02 / wide) * min(0.02 / narrow, 1.0) >= 0.95


LOTS = Tolerances((TOLERANCES.dimensions[0], replace(TOLERANCES.dimensions[1], lot_share=0.5)), lot_size=50)


def test_lots_ask_for_samples_before_anything_runs():
    def no_motion(inputs):
        raise AssertionError

    with pytest.raises(InputError, match=r"4000 in lots of 50 cannot show.*give at least 18400,"):
        allocate(LOTS, SPECIFICATION, Plan(GRADES[:2], 0.99, samples=4000), no_motion)


def test_plans_count_what_lots_leave_independent():
    plan = Plan(GRADES[:2], 0.99, samples=40_000)
    single, half, whole = (
        _planned_yield(plan, replace(LOTS, dimensions=(replace(LOTS.dimensions[1], lot_share=share),)))
        for share in (0.0, 0.5, 1.0)
    )
    # One lot is worth 50/(1 + 49 share) independent parts.
    assert single == pytest.approx(_planned_yield(plan, TOLERANCES))
    alone = Tolerances((replace(LOTS.dimensions[1], lot_share=None),))
    assert whole == pytest.approx(_planned_yield(replace(plan, samples=800), alone), abs=1e-9)
    assert half == pytest.approx(_planned_yield(replace(plan, samples=round(40_000 / 25.5)), alone), abs=1e-6)
    assert single < half < whole


@pytest.mark.slow
def test_lots_are_confirmed_with_the_planned_choice():
    tolerances = Tolerances(
        tuple(replace(dimension, lot_share=0.2) for dimension in TOLERANCES.dimensions), lot_size=10
    )
    result = allocate(tolerances, SPECIFICATION, Plan(GRADES, 0.99, samples=20_000, seed=1), linear)
    assert result.is_met and result.attempts == 1


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"specification": {}}, r"\[specification\] is empty; give at least one output a limit"),
        (
            {"specification": {"contact_loss_time": {"min": 1.0}}},
            "require contact_force_D_min and contact_force_E_min >= 0",
        ),
        ({"plan": Plan((), 0.99)}, "no dimension has a choice; give at least one"),
        (
            {"plan": Plan((Curve("mass", 0.1, 1.0, 1.0, 1.0),), 0.99)},
            "mass is no dimension of the study; allowed: alpha, beta",
        ),
        ({"plan": Plan(GRADES, 0.9999, samples=1000)}, r"samples = 1000 cannot show.*give at least \d{5}"),
        ({"specification": {"y": {"max": 0.0}}}, r"narrowest one has 0\.\d+, the widest 0\.\d+\. Offer other zones"),
    ],
)
def test_errors_say_what_to_do(changes, message):
    arguments = {"specification": SPECIFICATION, "plan": Plan(GRADES, 0.99, samples=2000)} | changes
    with pytest.raises(InputError, match=message):
        allocate(TOLERANCES, arguments["specification"], arguments["plan"], linear)


def test_measured_dimensions_cannot_be_narrowed():
    tolerances = Tolerances((Dimension("alpha", 0.0, distribution=Measured([0.0, 0.1, 0.2])),))
    with pytest.raises(InputError, match="alpha follows a distribution of its own"):
        allocate(tolerances, SPECIFICATION, Plan(GRADES[:1]), linear)


def test_too_many_combinations_are_refused():
    many = tuple(
        Grades(name, tuple(map(str, range(70))), tuple(range(1, 71)), tuple(range(70, 0, -1))) for name in NAMES
    )
    with pytest.raises(InputError, match=r"343000 combinations; allowed: 200000\. Offer fewer grades"):
        allocate(TOLERANCES, SPECIFICATION, Plan(many), linear)
