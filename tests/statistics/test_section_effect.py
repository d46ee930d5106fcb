"""The model's term of the error budget, on samples whose exact values are known."""

import numpy as np
import pandas as pd
import pytest

from tolmc.statistics.section_effect import section_differences, section_of_requirements
from tolmc.statistics.summary import summarise_requirements

N, SUBSET = 20_000, 1024


def frames(shift: float, spread: float = 0.0, *, limit: float, scale: float = 1.0):
    """A normal output on the circle; on the exact section it is shifted, by more where it is large."""
    x = np.random.default_rng(3).normal(10.0, scale, N)
    samples = pd.DataFrame({"contact_force_D_max": x, "status": "ok"})
    exact = samples.iloc[:SUBSET].assign(contact_force_D_max=lambda f: f.contact_force_D_max * (1 + spread) + shift)
    return samples, exact, {"contact_force_D_max": {"max": limit}}


def verdicts(samples, exact, specification, target=0.9973, **options):
    shares = summarise_requirements(samples, specification=specification, **options)
    return section_of_requirements(
        samples, samples.iloc[: len(exact)], exact, shares, specification=specification, target=target, **options
    )


@pytest.mark.parametrize("sampling", ["random", "sobol"])
def test_intervals_of_differences_hold_the_truth_as_often_as_they_say(sampling):
    truth, held = (
        {"section_mean": -0.5, "section_sd": -0.1, "section_q50": -0.5},
        dict.fromkeys(("mean", "sd", "q50"), 0),
    )
    for seed in range(60):
        x = np.random.default_rng(seed).normal(10.0, 1.0, SUBSET)
        circle = pd.DataFrame({"contact_force_D_max": x})
        exact = pd.DataFrame({"contact_force_D_max": 1.1 * x - 0.5})
        row = section_differences(circle, exact, ["contact_force_D_max"], sampling=sampling).iloc[0]
        for key in held:
            name = f"section_{key}"
            held[key] += row[f"{name}_low"] <= truth[name] <= row[f"{name}_high"]
        assert row["section_mean_high"] - row["section_mean_low"] < 0.03  # they are paired: the spread itself is 1
    assert min(held.values()) >= 52  # of 60, 57 are expected


def test_the_same_on_both_sections_differs_in_nothing():
    samples, exact, specification = frames(0.0, limit=12.0)
    found = section_differences(samples.iloc[:SUBSET], exact, ["contact_force_D_max"], sampling="random")
    assert (found.drop(columns=[c for c in found if c.endswith(("_low", "_high"))]) == 0).all(axis=None)
    assert (verdicts(samples, exact, specification)["section"] == "").all()


@pytest.mark.parametrize(
    ("shift", "limit", "target", "matters"),
    [
        (0.0, 14.0, 0.9973, False),
        (0.5, 16.0, 0.9973, False),  # far from the limit
        (3.0, 14.0, 0.9973, True),  # met on the circle, a sixth out exactly
        (-3.0, 11.0, 0.9973, True),  # broken on the circle, met exactly
        (5.0, 11.8, 0.9973, True),  # 3.6 % out on the circle, nearly all exactly
        (0.1, 11.5, 0.9973, False),  # broken on both
        (0.1, 14.0, 0.9973, False),
        (0.4, 12.5, 0.99, True),  # 0.6 % and 1.8 %
        (0.4, 12.5, 0.9, False),
    ],
)
def test_a_verdict_that_the_section_could_turn_is_not_decided(shift, limit, target, matters):
    samples, exact, specification = frames(shift, limit=limit)
    found = verdicts(samples, exact, specification, target)
    row = found.loc["contact_force_D_max"]
    assert bool(row["section"]) == matters == bool(found.loc["any requirement", "section"])
    true = np.mean(samples["contact_force_D_max"] + shift > limit)
    assert row["exact_most_low"] <= true <= row["exact_most_high"]
    on_circle = np.mean(samples["contact_force_D_max"] > limit)
    assert row["section_difference_low"] <= on_circle - true <= row["section_difference_high"]
    if matters:
        assert row["section"].startswith("not decided: the section matters (circle ") and "exact " in row["section"]


def test_contact_that_only_the_exact_section_loses_is_seen():
    samples, exact, specification = frames(0.0, limit=16.0)
    exact = exact.assign(status=np.where(np.arange(SUBSET) % 2, "contact lost", "ok"))
    row = verdicts(samples, exact, specification).loc["contact_force_D_max"]
    assert row["section"] == "not decided: the section matters (circle 0 %, exact 0 % to 50 %)"


def test_rare_failures_stay_rare():
    """No sample of the subset breaks the limit, a few of all do: the share is that of parts per million, and stays decided."""
    samples, exact, specification = frames(0.001, limit=13.8)
    assert 0 < (samples["contact_force_D_max"] > 13.8).sum() < 10
    assert (verdicts(samples, exact, specification, target=0.998)["section"] == "").all()
