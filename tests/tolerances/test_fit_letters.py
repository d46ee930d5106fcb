"""Letters of fits and tolerance classes: what is meant is said, nothing is guessed."""

import pytest

from tolmc.tolerances.dimension import Dimension
from tolmc.tolerances.fits import fit, is_hole


@pytest.mark.parametrize(
    ("name", "designation", "meant"),
    [
        ("bearing_radius", "40 h7", "40 H7"),
        ("bearing_radius", "⌀40.4 h7", "40.4 H7"),
        ("bearing_radius", "40 js7", "40 JS7"),
        ("bearing_radius", "40 za8", "40 ZA8"),
        ("journal_radius", "40 H7", "40 h7"),
        ("journal_radius", "40 D9", "40 d9"),
        ("journal_radius", "40 JS7", "40 js7"),
    ],
)
def test_a_class_of_the_other_part_is_refused_with_the_one_that_is_meant(name, designation, meant):
    with pytest.raises(ValueError, match=rf"Dimension {name}: .*'{meant}'"):
        Dimension.from_tolerance_class(name, designation)


def test_a_length_takes_both():
    assert is_hole("60 H11") and not is_hole("60 js11")
    for designation in ("60 H11", "60 h11", "60 js11"):
        Dimension.from_tolerance_class("half_length", designation)


@pytest.mark.parametrize(
    ("designation", "meant"),
    [
        ("40 h7/d9", "40 H7/d9"),
        ("40 H7/D9", "40 H7/d9"),
        ("40 d9/H7", "40 H7/d9"),
        ("40 H7-d9", "40 H7/d9"),
        ("40 H7 d9", "40 H7/d9"),
        ("40 H 7 / d 9", "40 H7/d9"),
        ("40,5 H7/d9", "40.5 H7/d9"),
        ("⌀40 mm h7/d9", "40 H7/d9"),
    ],
)
def test_a_fit_with_a_slip_says_what_is_meant(designation, meant):
    with pytest.raises(ValueError, match=f"did you mean '{meant}'"):
        fit(designation)


@pytest.mark.parametrize("designation", ["40", "H7/d9", "40 H7", "40 H7/d9 x", "40 Js7/h6", ""])
def test_what_is_no_fit_is_refused(designation):
    with pytest.raises(ValueError, match=r"ISO 286: "):
        fit(designation)


def test_letters_of_two_sizes_are_refused():
    with pytest.raises(ValueError, match=r"JS for a hole, js for a shaft"):
        Dimension.from_tolerance_class("bearing_radius", "40 Js7")
