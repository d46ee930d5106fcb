"""Quantities, limits and verdicts in words."""

import math

import pytest

from tolmc.statistics.intervals import Estimate
from tolmc.text import phrases


@pytest.mark.parametrize(
    ("low", "high", "verdict"), [(0.9973, 1.0, "met"), (0.99, 0.9972, "not met"), (0.99, 0.9973, "not decided")]
)
def test_judged(low, high, verdict):
    assert phrases.judged(Estimate(0.997, low, high), 0.9973) == verdict


@pytest.mark.parametrize(
    ("limits", "text"),
    [
        ((math.nan, math.radians(24.45)), "≤ 24.45 deg"),
        ((math.radians(-1.5), math.nan), "≥ −1.5 deg"),
        ((math.radians(24), math.radians(24.4567)), "≥ 24 deg and ≤ 24.4567 deg"),
    ],
)
def test_limits(limits, text):
    assert phrases.limits("tilt_angle", *limits) == text


def test_events_are_named_or_an_output_out_of_its_limits():
    assert phrases.event("contact loss") == "Contact lost"
    assert phrases.event("tilt_angle") == "Tilt angle ψ out"
