"""ISO 286: published values of the standard, its rules, and errors that say what is allowed."""

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tolmc.tolerances import fits

SIZES = st.floats(min_value=1.5, max_value=3150.0)
CLEARANCE = ["a", "b", "c", "d", "e", "f", "g", "h"]


def micrometres(size, designation):
    return tuple(1e6 * deviation for deviation in fits.limits(size, designation))


# ISO 286-2, lower and upper limit deviation in micrometres.
@pytest.mark.parametrize(
    ("size", "designation", "lower", "upper"),
    [
        (50, "H7", 0, 25),
        (50, "g6", -25, -9),
        (50, "f7", -50, -25),
        (50, "d9", -142, -80),
        (25, "f7", -41, -20),
        (10, "g6", -14, -5),
        (100, "g6", -34, -12),
        (40, "H11", 0, 160),
        (40, "c11", -280, -120),
        (25, "s6", 35, 48),
        (25, "p6", 22, 35),
        (25, "n6", 15, 28),
        (25, "k6", 2, 15),
        (25, "k8", 0, 33),
        (25, "js7", -10.5, 10.5),
        (25, "h9", -52, 0),
        (60, "u6", 87, 106),
        (8, "zc8", 97, 119),
        (2, "j8", -6, 8),
        (200, "j6", -13, 16),
        (25, "t6", 41, 54),
        (600, "g6", -66, -22),
        (3000, "h7", -210, 0),
        (15, "cd9", -113, -70),
        (100, "E8", 72, 126),
        (20, "F8", 20, 53),
        (40, "D10", 80, 180),
        (340, "A13", 1200, 2090),
        (25, "J7", -9, 12),
        (25, "JS6", -6.5, 6.5),
        # Holes K .. ZC carry the Delta rule.
        (25, "K7", -15, 6),
        (25, "M7", -21, 0),
        (25, "N7", -28, -7),
        (25, "N9", -52, 0),
        (25, "P7", -35, -14),
        (25, "R7", -41, -20),
        (25, "R10", -112, -28),
        (25, "P8", -55, -22),
        (25, "P9", -74, -22),
        (25, "N8", -36, -3),
        (25, "S7", -48, -27),
        (50, "U7", -86, -61),
        (2, "K7", -10, 0),
        (2, "N9", -29, -4),
        (2, "P7", -16, -6),
        (300, "M6", -41, -9),
        (300, "M7", -52, 0),
        (600, "N7", -114, -44),
        (600, "P7", -148, -78),
    ],
)
def test_published_limits(size, designation, lower, upper):
    assert micrometres(size, designation) == pytest.approx((lower, upper), abs=1e-9)


@pytest.mark.parametrize(
    ("size", "grade", "width"),
    [
        (50, 7, 25),
        (40, "IT9", 62),
        (3, "01", 0.3),
        (500, 0, 6),
        (400, 18, 8900),
        (3150, 1, 26),
        (18.0001, 6, 13),
    ],
)
def test_standard_tolerances(size, grade, width):
    assert fits.it_grade(size, grade) == pytest.approx(width * 1e-6, rel=1e-12)


def test_standard_tolerances_follow_the_tolerance_factor():
    # ISO 286-1: IT = factor * i, i = 0.45 D^(1/3) + 0.001 D micrometres up to 500 mm, D the geometric mean of
    # a range of sizes in mm; the published values are rounded, by hand.
    factors = dict(zip(range(5, 19), (7, 10, 16, 25, 40, 64, 100, 160, 250, 400, 640, 1000, 1600, 2500), strict=True))
    bounds = (3, 6, 10, 18, 30, 50, 80, 120, 180, 250, 315, 400, 500)
    for (low, high), (grade, factor) in itertools.product(itertools.pairwise(bounds), factors.items()):
        mean = (low * high) ** 0.5
        expected = factor * (0.45 * mean ** (1 / 3) + 0.001 * mean) * 1e-6
        assert fits.it_grade(high, grade) == pytest.approx(expected, rel=0.045, abs=0.7e-6), (high, grade)


COARSE = (30, 50, 80, 120, 180, 250, 315, 400, 500, 630, 800, 1000, 1250, 1600, 2000, 2500, 3150)
FINE = (
    *(30, 40, 50, 65, 80, 100, 120, 140, 160, 180, 200, 225, 250, 280, 315, 355, 400, 450, 500, 560, 630),
    *(710, 800, 900, 1000, 1120, 1250, 1400, 1600, 1800, 2000, 2240, 2500, 2800, 3150),
)


def it(size, grade):
    return 1e6 * fits.it_grade(size, grade)


# ISO 286-1, formulas for fundamental deviations in micrometres: D the geometric mean of a range, s its upper end.
FORMULAS = {
    "a": (FINE, lambda D, s: 265 + 1.3 * D if s <= 120 else 3.5 * D),
    "b": (FINE, lambda D, s: 140 + 0.85 * D if s <= 160 else 1.8 * D),
    "d": (COARSE, lambda D, s: 16 * D**0.44),
    "e": (COARSE, lambda D, s: 11 * D**0.41),
    "f": (COARSE, lambda D, s: 5.5 * D**0.41),
    "g": (COARSE, lambda D, s: 2.5 * D**0.34),
    "m": (COARSE, lambda D, s: it(s, 7) - it(s, 6) if s <= 500 else 0.024 * D + 12.6),
    "n": (COARSE, lambda D, s: 5 * D**0.34 if s <= 500 else 0.04 * D + 21),
    "t": (FINE, lambda D, s: it(s, 7) + 0.63 * D),
    "u": (FINE, lambda D, s: it(s, 7) + D),
    "v": (FINE, lambda D, s: it(s, 7) + 1.25 * D),
    "x": (FINE, lambda D, s: it(s, 7) + 1.6 * D),
    "y": (FINE, lambda D, s: it(s, 7) + 2 * D),
    "z": (FINE, lambda D, s: it(s, 7) + 2.5 * D),
    "za": (FINE, lambda D, s: it(s, 8) + 3.15 * D),
    "zb": (FINE, lambda D, s: it(s, 9) + 4 * D),
    "zc": (FINE, lambda D, s: it(s, 10) + 5 * D),
}
LAST_SIZE = {letter: 500 for letter in ("a", "b", "v", "x", "y", "z", "za", "zb", "zc")}


@pytest.mark.parametrize("letter", FORMULAS)
def test_fundamental_deviations_follow_their_formulas(letter):
    bounds, formula = FORMULAS[letter]
    for low, high in itertools.pairwise(bounds):
        if high <= LAST_SIZE.get(letter, 3150):
            lower, upper = micrometres(high, f"{letter}7")
            deviation = -upper if letter in CLEARANCE else lower
            expected = formula((low * high) ** 0.5, high)
            assert deviation == pytest.approx(expected, rel=0.05, abs=1.5), high


@given(SIZES)
def test_grades_widen(size):
    grades = fits.GRADES if size <= 500 else fits.GRADES[2:]
    widths = [fits.it_grade(size, grade) for grade in grades]
    assert all(a < b for a, b in itertools.pairwise(widths))


@given(SIZES, st.sampled_from(range(1, 19)))
def test_zone_is_as_wide_as_its_grade(size, grade):
    for letter in ("H", "h", "JS", "js", "G", "g", "m", "p"):
        lower, upper = fits.limits(size, f"{letter}{grade}")
        assert upper - lower == pytest.approx(fits.it_grade(size, grade), rel=1e-9)


@given(st.floats(min_value=1.5, max_value=500.0), st.sampled_from(range(5, 12)))
def test_holes_mirror_shafts_in_clearance_letters(size, grade):
    uppers = []
    for letter in CLEARANCE:
        lower, upper = fits.limits(size, f"{letter}{grade}")
        assert fits.limits(size, f"{letter.upper()}{grade}") == (-upper, -lower)
        uppers.append(upper)
    assert uppers == sorted(uppers)


@given(st.floats(min_value=3.1, max_value=500.0), st.sampled_from(["k", "m", "n", "p", "r", "s", "u", "x"]))
def test_hole_basis_and_shaft_basis_fits_agree(size, letter):
    # What Delta is for: H7/p6 and P7/h6 have the same clearances.
    hole_basis = fits.fit(f"{size:.6f} H7/{letter}6").clearance
    shaft_basis = fits.fit(f"{size:.6f} {letter.upper()}7/h6").clearance
    assert shaft_basis == pytest.approx(hole_basis, abs=1e-12)


def test_zero_has_no_sign():
    assert [str(micrometres(*case)[1]) for case in ((50, "h7"), (2, "K6"), (600, "K7"))] == ["0.0"] * 3


def test_fit_gives_radii():
    fit = fits.fit("40 H7/d9")
    assert fit.size == 0.04
    assert fit.hole == (0.0, 25e-6)
    assert fit.shaft == pytest.approx((-142e-6, -80e-6), rel=1e-12)
    assert fit.clearance == pytest.approx((80e-6, 167e-6), rel=1e-12)
    assert fit.bearing_radius == pytest.approx((20e-3, 20.0125e-3), rel=1e-15)
    assert fit.journal_radius == pytest.approx((19.929e-3, 19.96e-3), rel=1e-15)


@pytest.mark.parametrize("text", ["⌀40 H7/d9", "Ø 40 H7 / d9", "40H7/d9", "40 mm H7/d9", "40.0 H7/d9"])
def test_fit_is_read_as_engineers_write_it(text):
    fit = fits.fit(text)
    assert (fit.hole, fit.shaft) == (fits.fit("40 H7/d9").hole, fits.fit("40 H7/d9").shaft)


def test_interference_has_negative_clearance():
    assert fits.fit("25 H7/p6").clearance == pytest.approx((-35e-6, -1e-6), rel=1e-9)


@pytest.mark.parametrize(
    ("designation", "coarser", "held", "deviations"),
    [
        ("40 H7", "40 H9", "lower", (0, 62)),
        ("40 D7", "40 D9", "lower", (80, 142)),
        ("40 d7", "40 d9", "upper", (-142, -80)),
        ("40 js7", "40 js9", "middle", (-31, 31)),
        ("40 JS7", "40 JS9", "middle", (-31, 31)),
        ("40 p7", "40 p9", "lower", (26, 88)),
        ("40 N8", "40 N9", "upper", (-62, 0)),
    ],
)
def test_another_grade_keeps_the_letter(designation, coarser, held, deviations):
    assert fits.with_grade(designation, "IT9") == coarser
    assert fits.held_limit(designation) == held
    size, lower, upper = fits.size_limits(coarser)
    assert (1e6 * (lower - size), 1e6 * (upper - size)) == pytest.approx(deviations)


def test_size_limits():
    assert fits.size_limits("40 d9") == pytest.approx((0.04, 0.039858, 0.03992), rel=1e-15)


@pytest.mark.parametrize(
    ("size", "designation", "says"),
    [
        (50, "i7", ["'i7'", "allowed"]),
        (50, "Hh7", ["'Hh7'", "allowed"]),
        (50, "H19", ["'19'", "allowed"]),
        (50, "7H", ["'7H'", "allowed"]),
        (20, "t6", ["t", "20 mm", "over 24"]),
        (60, "fg6", ["fg", "60 mm", "up to 50 mm"]),
        (600, "H01", ["IT01", "up to 500 mm"]),
        (50, "j9", ["j9", "js"]),
        (50, "K9", ["K9", "JS9"]),
        (50, "P2", ["P2", "grade 3"]),
        (1, "a11", ["a", "1 mm", "choose c"]),
        (1, "N9", ["N9", "1 mm", "JS9"]),
        (0, "H7", ["size = 0", "3150"]),
        (3151, "H7", ["size = 3151", "3150"]),
        (float("nan"), "H7", ["nan", "allowed"]),
    ],
)
def test_errors_name_what_is_allowed(size, designation, says):
    with pytest.raises(ValueError) as error:
        fits.limits(size, designation)
    assert all(word in str(error.value) for word in says), str(error.value)


@pytest.mark.parametrize("text", ["40 d9/H7", "H7/d9", "40 H7", "-40 H7/d9", "40 H7/d9 extra", ""])
def test_fit_errors_name_the_form(text):
    with pytest.raises(ValueError, match="40 H7/d9"):
        fits.fit(text)


@pytest.mark.parametrize("text", ["40", "H7", "40 H7/d9"])
def test_size_limits_errors_name_the_form(text):
    with pytest.raises(ValueError, match="40 H7"):
        fits.size_limits(text)
