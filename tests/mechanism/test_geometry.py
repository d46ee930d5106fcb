"""Equations (1)-(3) against the paper's own formula in 80 digits."""

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tolmc import approximate_radius, effective_radius, tilt_angle

FUNCTIONS = (tilt_angle, effective_radius, approximate_radius)


def exact(bearing_radius, journal_radius, half_length):
    """psi = arccos(r*/sqrt(R*^2 + L^2)) - arctan(L/R*) and r = R* - r*/cos(psi), as the paper writes them."""
    with mpmath.workdps(80):
        R, r, L = (mpmath.mpf(x) for x in (bearing_radius, journal_radius, half_length))
        psi = mpmath.acos(r / mpmath.sqrt(R**2 + L**2)) - mpmath.atan(L / R)
        return psi, R - r / mpmath.cos(psi)


def ulps(value, reference):
    """Error of a float in units of the spacing of floats at the reference."""
    with mpmath.workdps(80):
        return float(abs(mpmath.mpf(float(value)) - reference) / np.spacing(abs(float(reference))))


@st.composite
def joints(draw):
    """Clearance ratios 1e-12 ... 10, journals of 1 um ... 1 km, L/r* of 1e-3 ... 1e4."""
    journal = 10 ** draw(st.floats(-6, 3))
    bearing = journal * (1 + 10 ** draw(st.floats(-12, 1)))
    return bearing, journal, journal * 10 ** draw(st.floats(-3, 4))


@given(joints())
def test_tilt_and_radius_are_exact_to_four_ulps(joint):
    psi, r = exact(*joint)
    assert ulps(tilt_angle(*joint), psi) <= 4
    assert ulps(effective_radius(*joint), r) <= 4


@given(joints())
def test_the_journal_touches_the_bearing_at_both_ends(joint):
    R, r, L = joint
    psi = tilt_angle(*joint)
    assert abs(R * np.cos(psi) - L * np.sin(psi) - r) <= 1e-15 * (R + L + r)
    assert effective_radius(*joint) == pytest.approx(L * np.tan(psi), rel=1e-14)


def test_the_papers_example():
    assert np.degrees(tilt_angle(2, 1, 2)) == pytest.approx(24.2951889, abs=5e-8)
    assert effective_radius(2, 1, 2) == pytest.approx(0.902832459, abs=5e-10)
    assert approximate_radius(2, 1, 2) == 1


def test_a_small_clearance_gives_the_approximate_radius():
    ratio = effective_radius(1 + 1e-9, 1.0, 2.0) / approximate_radius(1 + 1e-9, 1.0, 2.0)
    assert ratio == pytest.approx(1 - 1e-9 / 8, abs=1e-15)  # r = c - c^2 r*/(2 L^2) + ..., c = R* - r*


def test_arguments_broadcast():
    R, r, L = np.array([[2.0], [3.0]]), np.array([1.0, 1.5, 1.9]), 2.0
    for function in FUNCTIONS:
        result = function(R, r, L)
        assert result.shape == (2, 3)
        for i in range(2):
            for j in range(3):
                assert result[i, j] == function(R[i, 0], r[j], L)


def test_numbers_and_lists_are_taken():
    for function in FUNCTIONS:
        assert np.ndim(function(2, 1, 2)) == 0
        assert np.array_equal(function([2, 3], 1, 2), function(np.array([2.0, 3.0]), 1.0, 2.0))


@pytest.mark.parametrize(
    "joint",
    [
        (1, 1, 1), (1, 2, 1), (2, 0, 1), (2, -1, 1), (2, 1, 0), (2, 1, -1),
        (np.nan, 1, 1), (2, np.nan, 1), (2, 1, np.nan), (np.inf, 1, 1), (2, 1, np.inf),
    ],
)  # fmt: skip
def test_an_impossible_joint_is_refused(joint):
    for function in (tilt_angle, effective_radius):
        with pytest.raises(ValueError, match="0 < journal_radius < bearing_radius") as error:
            function(*joint)
        for value in joint:
            assert repr(float(value)) in str(error.value)


def test_the_error_names_the_element():
    with pytest.raises(ValueError, match=r"at index \(1, 0\).*journal_radius=3\.0 m"):
        tilt_angle([[2.0, 2.0], [2.0, 4.0]], [[1.0, 1.0], [3.0, 3.0]], 1.0)


def test_the_approximate_radius_needs_no_length():
    assert approximate_radius(3.0, 1.0) == 2.0
    with pytest.raises(ValueError, match="bearing_radius=1"):
        approximate_radius(1.0, 3.0)


@pytest.mark.parametrize("scale", [2.0**-600, 2.0**-300, 2.0**300, 2.0**600])
def test_lengths_of_any_size_keep_their_geometry(scale):
    sizes = np.array([0.020, 0.010, 0.020])
    assert tilt_angle(*(scale * sizes)) == tilt_angle(*sizes)
    assert effective_radius(*(scale * sizes)) == scale * effective_radius(*sizes)
