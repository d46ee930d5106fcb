"""Wear of bore and journal: from the worn volume to the depth by which the clearance opens.

Archard's law: V = k * integral of N |v| dt. The bore loses its share of V over its whole length, where the journal lies.
Pressed by h into a bore of radius R, a journal of radius r < R removes the part of its circle that sticks out, its centre
being at e = R - r + h. With phi and theta half the angles of the worn arc, seen from the journal's centre and from the bore's,

    cos phi = (R^2 - r^2 - e^2)/(2 r e),   sin theta = (r/R) sin phi
    A(h) = r^2 phi + e r sin phi - R^2 theta,   dA/dh = 2 r sin phi

(the area between two circles). Where the contact wanders over an arc s of the bore, the union of these shapes has
s/2 ((R + h)^2 - R^2) more; all round it is pi ((R + h)^2 - R^2) and no more. A journal that turns wears all round:
pi (r^2 - (r - h)^2).
"""

from __future__ import annotations

import math

import numpy as np

_ITERATIONS = (
    60  # Newton's, from below and then from above: four to ten reach rounding, more where the arc is nearly closed
)


def worn_area(
    depth: np.ndarray, bore_radius: np.ndarray, journal_radius: np.ndarray, arc: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """(A, dA/dh) of the bore's section, m^2 and m, worn to ``depth`` (m) where the contact wanders over ``arc`` (rad)."""
    centre = bore_radius - journal_radius + depth
    cosine = (bore_radius**2 - journal_radius**2 - centre**2) / (2.0 * journal_radius * centre)
    phi = np.arccos(np.clip(cosine, -1.0, 1.0))
    sine = np.sin(phi)
    # The bore's centre lies within the journal: the angle seen from it is below a right angle only for a shallow arc.
    theta = np.arctan2(journal_radius * sine, centre + journal_radius * np.cos(phi))
    crescent = journal_radius**2 * phi + centre * journal_radius * sine - bore_radius**2 * theta
    ring = 0.5 * depth * (2.0 * bore_radius + depth)
    return crescent + arc * ring, 2.0 * journal_radius * sine + arc * (bore_radius + depth)


def bore_depth(area: np.ndarray, bore_radius: np.ndarray, journal_radius: np.ndarray, arc: float = 0.0) -> np.ndarray:
    """Depth h (m) of the bore's wear, from the area (m^2) that its section has lost.

    Parameters
    ----------
    area, bore_radius, journal_radius : (n,) arrays, m^2 and m; 0 < r < R
    arc : float, rad
        Arc over which the contact wanders; 2 pi: all round.
    """
    all_round = area / math.pi / (bore_radius + np.sqrt(bore_radius**2 + area / math.pi))
    if arc >= 2.0 * math.pi:
        return all_round
    clearance = bore_radius - journal_radius
    # A(h) ~ (4/3) r sqrt(2/c) h^(3/2) with c the clearance over R/r: a first guess from which Newton's iteration converges.
    reach = 4.0 / 3.0 * journal_radius * np.sqrt(2.0 * bore_radius / (journal_radius * clearance))
    depth = np.cbrt((area / reach) ** 2)
    if arc > 0.0:
        depth = np.minimum(depth, area / (arc * bore_radius))
    for _ in range(_ITERATIONS):
        found, slope = worn_area(depth, bore_radius, journal_radius, arc)
        step = np.divide(area - found, slope, out=np.zeros_like(depth), where=slope > 0.0)
        depth = np.maximum(depth + step, 0.0)
        if np.all(np.abs(step) <= 1e-13 * depth):
            break
    return np.maximum(depth, all_round)


def journal_depth(area: np.ndarray, journal_radius: np.ndarray) -> np.ndarray:
    """Depth (m) of the journal's wear, all round, from the area (m^2) that its section has lost; NaN beyond all of it."""
    with np.errstate(invalid="ignore"):
        return area / math.pi / (journal_radius + np.sqrt(journal_radius**2 - area / math.pi))
