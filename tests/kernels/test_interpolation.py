"""Polynomials through values and rates, against scipy's."""

import numpy as np
import pytest
from scipy.interpolate import BarycentricInterpolator, KroghInterpolator

from tolmc.kernels.interpolation import slope_through, through


@pytest.mark.parametrize("places", [[0.0, 0.3, 0.5, 1.0], [-1.5, -0.5, 0.5, 1.5], [1.0, 0.0]])
def test_the_polynomial_goes_through_values_and_rates(places):
    values, rates = np.random.default_rng(1).normal(size=(2, len(places)))
    x = np.linspace(-1.0, 2.0, 31)
    by_values = np.polynomial.Polynomial(through(places) @ values)(x)
    np.testing.assert_allclose(by_values, BarycentricInterpolator(places, values)(x), rtol=1e-12, atol=1e-12)
    # Krogh's takes a value and its rate as two entries at the same place.
    order = np.argsort(places)
    krogh = KroghInterpolator(np.repeat(np.take(places, order), 2), np.column_stack((values, rates))[order].ravel())
    by_both = np.polynomial.Polynomial(through(places, rates=True) @ np.concatenate((values, rates)))(x)
    np.testing.assert_allclose(by_both, krogh(x), rtol=1e-10, atol=1e-10)


def test_coefficients_that_are_whole_or_halves_are_exact():
    assert through([0.0, 1.0], rates=True).tolist() == [[1, 0, 0, 0], [0, 0, 1, 0], [-3, 3, -2, -1], [2, -2, 1, 1]]


@pytest.mark.parametrize(("count", "place"), [(5, 2), (7, 3), (7, 0), (3, 1)])
def test_the_slope_through_values_and_means_is_a_polynomial_s(count, place):
    polynomial = np.polynomial.Polynomial(np.random.default_rng(2).normal(size=2 * count - 1))
    ends, integral = np.arange(count), polynomial.integ()
    known = np.concatenate((polynomial(ends), np.diff(integral(ends))))
    terms = slope_through(count, place) * known
    assert terms.sum() == pytest.approx(polynomial.deriv()(place), abs=1e-14 * np.abs(terms).sum())
