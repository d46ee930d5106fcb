"""Numbers as a page shows them."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from read_numbers import numbers_in

from tolmc.text import typeset


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        (0.0, 5, "0"), (-9.81, 5, "−9.81"), (1e-8, 2, "1·10⁻⁸"), (33947.2, 3, "33,900"), (123456.0, 6, "123456"),
        (2.5e12, 3, "2.5·10¹²"), (math.nan, 5, "–"), (-math.inf, 5, "−∞"), (0.1 + 0.2, 5, "0.3"),
    ],
)  # fmt: skip
def test_number(value, digits, text):
    assert typeset.number(value, digits) == text


@pytest.mark.parametrize(
    ("estimate", "texts"),
    [
        ((24.3278, 24.3268, 24.3288), ("24.3278", "24.3268 to 24.3288")),
        ((5.0, 4.0, 6.0), ("5.0", "4.0 to 6.0")),
        ((33123.0, 32000.0, 34300.0), ("33,100", "32,000 to 34,300")),
        ((1.2944, 1.2944 - 5e-7, 1.2944 + 5e-7), ("1.29440", "±5·10⁻⁷")),
        ((2.0, -math.inf, 2.1), ("2.00", "up to 2.10")),
        ((2.0, 1.9, math.inf), ("2.00", "from 1.90")),
        ((2.0, -math.inf, math.inf), ("2", "open")),
        ((2.0, 2.0, 2.0), ("2", "")),
        ((0.0, 0.0, 0.00037), ("0", "0 to 0.00037")),
        ((math.nan, 0.0, 1.0), ("–", "")),
    ],
)
def test_estimate(estimate, texts):
    assert typeset.estimate(*estimate) == texts


def test_share_has_exact_ends():
    assert typeset.share(1.0, 0.9982, 1.0) == ("100 %", "99.82 % to 100 %")


@given(
    st.floats(1e-6, 1e8).flatmap(
        lambda v: st.tuples(
            st.just(v), st.floats(1e-9, 0.5).map(lambda s: v * s), st.floats(1e-9, 0.5).map(lambda s: v * s)
        )
    )
)
def test_estimate_loses_less_than_its_interval_is_wide(numbers):
    value, below, above = numbers
    text, interval = typeset.estimate(value, value - below, value + above)
    half = max(below, above)
    assert numbers_in(text)[0] == pytest.approx(value, abs=max(0.06 * half, 5.1e-6 * value))
    if "to" in interval:
        assert numbers_in(interval) == pytest.approx(
            [value - below, value + above], abs=max(0.06 * half, 5.1e-6 * value)
        )


@pytest.mark.parametrize(
    ("nominal", "lower", "upper", "texts"),
    [
        (20.0, 19.95, 20.05, ("±0.05",)), (10.0, 9.97, 10.0, ("0", "−0.03")), (40.0, 40.08, 40.142, ("+0.142", "+0.08")),
        (5.0, 5.0, 5.0, ()),
    ],
)  # fmt: skip
def test_deviations(nominal, lower, upper, texts):
    assert typeset.deviations(nominal, lower, upper) == texts


@pytest.mark.parametrize(
    ("low", "high", "text"),
    [(19.95, 20.05, "19.95 to 20.05"), (-3.2999977, -2.7000023, "−3.3 to −2.7"), (100.0, 5000.0, "100 to 5000")],
)
def test_span(low, high, text):
    assert typeset.span(low, high) == text
