"""A balance grade of ISO 21940-11, such as "G6.3": how far the centre of mass of a rotor may lie off its axis.

The grade is the largest speed of the centre of mass around the axis, e Ω = 6.3 mm/s for G6.3. Balancing leaves any
eccentricity up to e: ``center_of_mass_x`` is uniform from 0 to e. Which way x points at the start is that of ``spin``.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from tolmc.study.fields import Faults, place, short

# mm/s; the coarsest grade of the standard, of large slow marine engines.
_LARGEST = 4000
_GRADE = re.compile(r"\s*G\s*(\d+(?:\.\d+)?)\s*")


def with_unbalance(
    dimensions: Mapping[str, Any], center_of_mass: tuple[float, ...], spin_rate: float
) -> dict[str, Any]:
    """The [dimensions] table with what its balance grade says of the centre of mass.

    Parameters
    ----------
    center_of_mass, spin_rate : of the body (m) and of the start (rad/s)

    Raises
    ------
    Faults
        Where the grade is none, the rotor does not turn, or its centre of mass is given otherwise too.
    """
    table = dict(dimensions)
    if "unbalance" not in table:
        return table
    written = table.pop("unbalance")
    field = f"{place('dimensions', 'unbalance')} = {short(written)}"
    match = _GRADE.fullmatch(written) if isinstance(written, str) else None
    if match is None or not 0 < float(match[1]) <= _LARGEST:
        raise Faults(
            f'{field} is no balance grade; write one of ISO 21940-11, "G0.4" to "G{_LARGEST}", such as "G6.3" (mm/s).'
        )
    if spin_rate == 0:
        raise Faults(f"{field} needs a rotor that turns; give {place('motion', 'spin_rate')}.")
    double = [f"[dimensions] {name}" for name in ("center_of_mass_x", "center_of_mass_y") if name in table]
    if double or center_of_mass[0] or center_of_mass[1]:
        other = double[0] if double else f"{place('body', 'center_of_mass')} off the axis"
        raise Faults(f"{field} and {other} both say where the centre of mass lies; leave one out.")
    eccentricity = 1e-3 * float(match[1]) / abs(spin_rate)
    return table | {"center_of_mass_x": {"lower": 0.0, "upper": eccentricity, "distribution": "uniform"}}
