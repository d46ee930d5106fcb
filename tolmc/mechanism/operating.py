"""Operating conditions: what temperature and wear make of the dimensions on the drawing.

Drawings hold at 20 °C (ISO 1) and for new parts. With T the temperatures, alpha the expansion coefficients, Delta T = T - 20 °C
and w the worn depths,

    R* = R*_20 (1 + alpha_B Delta T_B) + w_B,    L = L_20 (1 + alpha_B Delta T_B),    r* = r*_20 (1 + alpha_J Delta T_J) - w_J.

A bush pressed into a stiff housing cannot grow outwards or along its axis: all of its growth in volume, 3 alpha Delta T, goes
into the wall's thickness s. Its length stays, and the bore's diameter closes by 6 alpha Delta T s:

    R* = R*_20 - 3 alpha_B Delta T_B s + w_B,    L = L_20.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tolmc.mechanism.checks import finite_number, set_frozen
from tolmc.quantities import OPERATING

#: °C; the temperature at which drawings hold, ISO 1.
REFERENCE_TEMPERATURE = 20.0
#: °C; hardly any solid is left above it.
HOTTEST = 3500.0
#: 1/K; ten times that of any metal.
LARGEST_EXPANSION = 1e-3
ABSOLUTE_ZERO = -273.15

#: Linear expansion of materials at room temperature, 1/K. Metals, polyamide, PEEK and PTFE: W. D. Callister, Materials Science
#: and Engineering, table B.6 (grades in brackets; the middle of a range); polyacetal: the usual figure of its makers.
EXPANSION = {
    "steel": 11.7e-6,  # 1020
    "stainless steel": 17.2e-6,  # 304
    "grey cast iron": 11.4e-6,
    "ductile cast iron": 11.2e-6,  # 60-40-18
    "aluminium": 23.6e-6,  # 6061
    "bearing bronze": 18.0e-6,  # C93200
    "brass": 20.5e-6,  # C36000
    "copper": 17.0e-6,  # C11000
    "titanium": 8.6e-6,
    "polyamide 66": 144e-6,
    "polyacetal": 110e-6,
    "PEEK": 78e-6,
    "PTFE": 171e-6,
}


def expansion_coefficient(name: str, value: object) -> float:
    """The coefficient, 1/K, of a number or of the name of a material in :data:`EXPANSION`."""
    if not isinstance(value, str):
        number = finite_number("Operating", name, value)
        if abs(number) > LARGEST_EXPANSION:
            raise ValueError(
                f"Operating: {name} = {value!r} 1/K is out of range; allowed: up to {LARGEST_EXPANSION:g} 1/K either way. "
                "Steel has 12e-6."
            )
        return number
    if value not in EXPANSION:
        raise ValueError(
            f"Operating: {name} = {value!r} is no material of the table; allowed: {', '.join(EXPANSION)}, "
            "or a number in 1/K such as 12e-6."
        )
    return EXPANSION[value]


@dataclass(frozen=True)
class Operating:
    """Temperatures and wear of the joint in operation.

    Parameters
    ----------
    bearing_temperature, journal_temperature : float, °C
        20 °C where nothing is said.
    bearing_expansion, journal_expansion : float, 1/K, or the name of a material in :data:`EXPANSION`
    bush_wall : float, m
        Thickness of a bush in a stiff housing; 0: the bearing expands freely.
    bearing_wear, journal_wear : float, m
        Depth worn off the bore and off the journal, on the radius; >= 0.
    """

    bearing_temperature: float = REFERENCE_TEMPERATURE
    journal_temperature: float = REFERENCE_TEMPERATURE
    bearing_expansion: float = 0.0
    journal_expansion: float = 0.0
    bush_wall: float = 0.0
    bearing_wear: float = 0.0
    journal_wear: float = 0.0

    def __post_init__(self) -> None:
        for name in ("bearing_temperature", "journal_temperature"):
            celsius = finite_number("Operating", name, getattr(self, name))
            if celsius <= ABSOLUTE_ZERO:
                raise ValueError(
                    f"Operating: {name} = {celsius!r} °C is out of range; allowed: above {ABSOLUTE_ZERO} °C."
                )
            set_frozen(self, **{name: celsius})
        for name in ("bearing_expansion", "journal_expansion"):
            set_frozen(self, **{name: expansion_coefficient(name, getattr(self, name))})
        for name in ("bush_wall", "bearing_wear", "journal_wear"):
            depth = finite_number("Operating", name, getattr(self, name))
            if depth < 0:
                raise ValueError(f"Operating: {name} = {depth!r} m is out of range; allowed: >= 0.")
            set_frozen(self, **{name: depth})

    @property
    def scalars(self) -> dict[str, float]:
        """The conditions by name."""
        return {name: getattr(self, name) for name in OPERATING}


def operating_dimensions(values: Mapping[str, np.ndarray | float]) -> tuple[np.ndarray | float, ...]:
    """R*, r* and L in operation, m, from the drawn dimensions and the conditions (module docstring).

    Parameters
    ----------
    values : mapping from the names of the dimensions and of
        :data:`tolmc.quantities.OPERATING` to floats or (n,) arrays, SI units and °C
    """
    bearing = values["bearing_expansion"] * (values["bearing_temperature"] - REFERENCE_TEMPERATURE)
    journal = values["journal_expansion"] * (values["journal_temperature"] - REFERENCE_TEMPERATURE)
    bore, wall = values["bearing_radius"], values["bush_wall"]
    bush = bore - 3.0 * bearing * wall, values["half_length"]
    whole = bore * (1.0 + bearing), values["half_length"] * (1.0 + bearing)
    grown: np.ndarray | float
    length: np.ndarray | float
    if isinstance(wall, np.ndarray):
        grown, length = (np.where(wall > 0, *either) for either in zip(bush, whole, strict=True))
    else:
        grown, length = bush if wall > 0 else whole
    return (
        grown + values["bearing_wear"],
        values["journal_radius"] * (1.0 + journal) - values["journal_wear"],
        length,
    )


def closing_temperature(values: Mapping[str, float]) -> float | None:
    """Temperature of the bearing, °C, at which the clearance closes while the journal keeps its distance from the bearing's.

    Both parts warm together, T_J = T_B + (the present difference). None where no temperature closes it.
    """
    warm, cold = dict(values), dict(values)
    for name in ("bearing_temperature", "journal_temperature"):
        cold[name], warm[name] = values[name], values[name] + 1.0

    def clearance(at: Mapping[str, float]) -> float:
        bore, journal, _ = operating_dimensions(at)
        return float(bore - journal)

    slope = clearance(warm) - clearance(cold)  # the clearance is linear in the temperature
    return None if slope == 0.0 else values["bearing_temperature"] - clearance(cold) / slope


def closing_sentence(values: Mapping[str, float]) -> str:
    """Why the joint cannot be in operation under these conditions, and what would mend it."""
    bore, journal, length = (float(value) for value in operating_dimensions(values))
    if not (journal > 0.0 and length > 0.0):
        return (
            f"temperature and wear leave a journal radius of {journal!r} m and a half length of {length!r} m; allowed: > 0. "
            "Correct journal_wear, the temperatures or the expansion coefficients."
        )
    closing = closing_temperature(values)
    at = "" if closing is None else f"; the clearance closes at {closing:.4g} °C"
    return (
        f"at bearing_temperature = {values['bearing_temperature']:.4g} °C the bore's radius is {1e3 * bore:.6g} mm and "
        f"the journal's {1e3 * journal:.6g} mm: no clearance is left{at}. Allowed: temperatures that leave one; "
        "give more clearance on the drawing, or other materials."
    )
