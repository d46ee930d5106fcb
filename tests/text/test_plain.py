"""Numbers as a terminal shows them."""

import math

import pytest

from tolmc.text import plain


@pytest.mark.parametrize(
    ("estimate", "digits", "expected"),
    [
        ((24.3278, 24.32, 24.33), 6, "24.3278\n±0.0078"),
        ((24.3278, 24.32, 24.3281), 6, "24.3278\n±0.0078"),
        ((24.32776, 24.327749, 24.327761), 6, "24.3278"),
        ((24.32776, 20.0, 30.0), 6, "24.3\n±5.7"),
        ((24.32776, 24.32776, 24.32776), 6, "24.3278"),
        ((0.0, 0.0, 0.0), 6, "0"),
        ((0.0, -math.inf, 0.0), 6, "0\nopen"),
        ((-0.0004, -0.11, 0.11), 6, "0.00\n±0.11"),
        ((1234567.0, 1234000.0, 1235000.0), 6, "1.23457e+06\n±6e+02"),
        ((0.00035996, 0.00035989, 0.00036003), 4, "0.0003600\n±0.0000001"),
        ((5.5, -math.inf, 5.5), 6, "5.50000\nopen"),
        ((-3.38461e-16, -4e-16, -3e-16), 6, "-3.4e-16\n±6e-17"),
        ((math.nan, math.nan, math.nan), 6, "–"),
    ],
)
def test_estimates_show_the_digits_that_are_known(estimate, digits, expected):
    assert "\n".join(filter(None, plain.estimate(*estimate, digits=digits))) == expected


@pytest.mark.parametrize(
    ("share", "expected"),
    [(0.0, "0 %"), (0.0345, "3.45 %"), (1.0, "100 %"), (0.001, "0.1 %"), (6.6e-5, "66 ppm"), (math.nan, "–")],
)
def test_shares_read_well(share, expected):
    assert plain.share(share) == (expected, "")
