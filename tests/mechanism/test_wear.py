"""Worn depths against their definition: the area that a circle sticks out of another, and what is worn all round."""

import math

import numpy as np
import pytest

from tolmc.mechanism.wear import bore_depth, journal_depth, worn_area

BORE, JOURNAL = 12.5e-3, 12.45e-3


def stuck_out(depth, bore, journal, *, arc=0.0):
    """The area by quadrature in polar coordinates about the bore's centre: circles shifted towards every angle of the arc."""
    angle = np.linspace(0.0, math.pi, 200_001)  # either side of the arc's middle is as the other
    off = np.maximum(angle - 0.5 * arc, 0.0)  # from the nearest direction of the wear
    centre = bore - journal + depth
    reach = centre * np.cos(off) + np.sqrt(journal**2 - (centre * np.sin(off)) ** 2)
    return np.trapezoid(np.maximum(reach**2 - bore**2, 0.0), angle)


@pytest.mark.parametrize("clearance", [1e-6, 5e-5, 3e-3])
@pytest.mark.parametrize("depth", [1e-7, 1e-5, 4e-4])
@pytest.mark.parametrize("arc", [0.0, 0.3, 2.0])
def test_the_worn_area_is_what_sticks_out(clearance, depth, arc):
    journal = BORE - clearance
    area, slope = worn_area(np.array([depth]), np.array([BORE]), np.array([journal]), arc)
    assert area[0] == pytest.approx(stuck_out(depth, BORE, journal, arc=arc), rel=1e-5)
    more, less = (stuck_out(depth * (1 + sign * 1e-2), BORE, journal, arc=arc) for sign in (1, -1))
    assert slope[0] == pytest.approx((more - less) / (2e-2 * depth), rel=1e-3)


@pytest.mark.parametrize("arc", [0.0, 1e-3, 0.5, 3.0])
def test_the_depth_of_an_area_wears_that_area(arc):
    depth = np.geomspace(1e-9, 1e-3, 25)
    bore, journal = np.full(25, BORE), np.full(25, JOURNAL)
    area, _ = worn_area(depth, bore, journal, arc)
    assert bore_depth(area, bore, journal, arc) == pytest.approx(depth, rel=1e-8)
    assert bore_depth(np.zeros(1), bore[:1], journal[:1], arc) == [0.0]


def test_all_round_the_area_is_that_of_a_ring():
    depth = np.array([1e-9, 1e-4])
    ring = math.pi * ((BORE + depth) ** 2 - BORE**2)
    assert bore_depth(ring, np.full(2, BORE), np.full(2, JOURNAL), 2 * math.pi) == pytest.approx(depth, rel=1e-6)
    disc = math.pi * (JOURNAL**2 - (JOURNAL - depth) ** 2)
    assert journal_depth(disc, np.full(2, JOURNAL)) == pytest.approx(depth, rel=1e-6)
    assert np.isnan(journal_depth(np.array([1.0]), np.array([JOURNAL])))


def test_a_wider_arc_wears_less_deep():
    area = np.array([1e-6])
    depths = [
        bore_depth(area, np.array([BORE]), np.array([JOURNAL]), arc)[0] for arc in (0.0, 0.5, 2.0, 5.0, 2 * math.pi)
    ]
    assert (np.diff(depths) < 0).all()
