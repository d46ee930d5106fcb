"""Whether the tolerances of a joint leave a clearance everywhere in their box."""

from __future__ import annotations

from tolmc.tolerances.dimension import Tolerances


def smallest_clearance(tolerances: Tolerances) -> float:
    """R* - r* at the corner of the box where it is smallest, m: the smallest bearing with the largest journal.

    The box is that of the limits; a distribution that is not truncated at them reaches further.
    """
    bearing, journal = _extremes(tolerances)
    return bearing - journal


def interference_note(tolerances: Tolerances) -> str | None:
    """What it means for a run that a corner of the box has no clearance; None where all have one."""
    clearance = smallest_clearance(tolerances)
    if clearance > 0:
        return None
    bearing, journal = _extremes(tolerances)
    return (
        f"the tolerances of bearing_radius (from {1e3 * bearing:.6g} mm) and journal_radius (to {1e3 * journal:.6g} mm) "
        f"overlap: the smallest clearance R* − r* is {1e3 * clearance:.4g} mm. Such parts cannot be assembled; their samples "
        'have the status "geometry invalid" and count in every share out of specification, once as in and once as out.'
    )


def _extremes(tolerances: Tolerances) -> tuple[float, float]:
    """Lower limit of R*, upper limit of r*."""
    dimensions = {dimension.name: dimension for dimension in tolerances.dimensions}
    return dimensions["bearing_radius"].lower, dimensions["journal_radius"].upper
