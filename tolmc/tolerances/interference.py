"""Whether the tolerances of a joint leave a clearance everywhere in their box."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tolmc.mechanism.operating import operating_dimensions
from tolmc.quantities import OPERATING
from tolmc.tolerances.dimension import Tolerances


def smallest_clearance(tolerances: Tolerances, scalars: Mapping[str, float] | None = None) -> float:
    """R* - r* at the corner of the box where it is smallest, m: the smallest bearing with the largest journal.

    The box is that of the limits; a distribution that is not truncated at them reaches further. With the ``scalars`` of a scene
    the clearance is that in operation, at the worst of the temperatures and the wear that vary.
    """
    bearing, journal = _extremes(tolerances)
    if scalars is None:
        return bearing - journal
    limits = {d.name: (d.lower, d.upper) for d in tolerances.dimensions if d.name in OPERATING}
    axes = [np.unique(limits.get(name, scalars[name])) for name in OPERATING]
    corners = dict(zip(OPERATING, np.meshgrid(*axes, indexing="ij"), strict=True))
    drawn = {"bearing_radius": bearing, "journal_radius": journal, "half_length": scalars["half_length"]}
    bore, shaft, _ = operating_dimensions({**drawn, **corners})
    return float(np.min(bore - shaft))  # linear in each condition, so least at a corner


def interference_note(tolerances: Tolerances, scalars: Mapping[str, float] | None = None) -> str | None:
    """What it means for a run that a corner of the box has no clearance; None where all have one."""
    drawn, clearance = smallest_clearance(tolerances), smallest_clearance(tolerances, scalars)
    if min(drawn, clearance) > 0:
        return None
    if drawn > 0:
        return (
            "temperature and wear close the clearance at a corner of the tolerances: R* − r* is at least "
            f"{1e3 * drawn:.4g} mm as drawn, {1e3 * clearance:.4g} mm in operation. Such samples have the status "
            '"geometry invalid" and count in every share out of specification, once as in and once as out.'
        )
    bearing, journal = _extremes(tolerances)
    return (
        f"the tolerances of bearing_radius (from {1e3 * bearing:.6g} mm) and journal_radius (to {1e3 * journal:.6g} mm) "
        f"overlap: the smallest clearance R* − r* is {1e3 * drawn:.4g} mm. Such parts cannot be assembled; their samples "
        'have the status "geometry invalid" and count in every share out of specification, once as in and once as out.'
    )


def _extremes(tolerances: Tolerances) -> tuple[float, float]:
    """Lower limit of R*, upper limit of r*."""
    dimensions = {dimension.name: dimension for dimension in tolerances.dimensions}
    return dimensions["bearing_radius"].lower, dimensions["journal_radius"].upper
