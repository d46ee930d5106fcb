"""Tolerance zones on offer: their widths, what they cost, and where they lie.

For each dimension the designer offers widths T = upper - lower: ISO 286 grades with a cost each (:class:`Grades`), or a range
of widths with a cost-tolerance function (:class:`Curve`). A zone of another width keeps its tolerance class's letter, or one
of its points (:func:`zone`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tolmc.analysis.surrogate import training_box
from tolmc.errors import InputError
from tolmc.tolerances import fits
from tolmc.tolerances.dimension import Dimension, Tolerances

ANCHORS = ("nominal", "lower", "upper", "middle")
#: Laws of the variable cost, 1 at x = T/at = 1 and falling, each with its inverse.
LAWS = {
    "reciprocal": (lambda x: 1.0 / x, lambda y: 1.0 / y),
    "reciprocal-square": (lambda x: x**-2.0, lambda y: y**-0.5),
    "exponential": (lambda x: math.exp(1.0 - x), lambda y: 1.0 - math.log(y)),
}

#: A width for every choice, in their order.
Widths = Sequence[float] | np.ndarray


@dataclass(frozen=True)
class Grades:
    """Widths to choose from, narrowest first, with the cost of a piece at each.

    Parameters
    ----------
    name : str
        Of the dimension.
    labels : of str
    widths : of float, m (or the dimension's unit)
    costs : of float
        NaN: not on offer; such a grade is never chosen, only shown beside those on offer.
    anchor : str, optional
        Which point of the zone stays where it is (see :func:`zone`).
    toleranced_sizes : of str, optional
        ISO 286 names of the zones, such as "40 H7"; they say where the zones lie, in place of the anchor.
    """

    name: str
    labels: tuple[str, ...]
    widths: tuple[float, ...]
    costs: tuple[float, ...]
    anchor: str | None = None
    toleranced_sizes: tuple[str, ...] = ()

    @property
    def offered(self) -> tuple[int, ...]:
        """Places of the grades on offer."""
        return tuple(i for i, cost in enumerate(self.costs) if not math.isnan(cost))

    @property
    def narrowest(self) -> float:
        """Width of the narrowest zone on offer."""
        return self.widths[self.offered[0]]

    @property
    def widest(self) -> float:
        """Width of the widest zone on offer."""
        return self.widths[self.offered[-1]]


@dataclass(frozen=True)
class Curve:
    """A range of widths with the cost fixed + variable * law(T/at), which falls as the zone widens."""

    name: str
    narrowest: float
    widest: float
    at: float
    variable: float
    fixed: float = 0.0
    law: str = "reciprocal"
    anchor: str | None = None

    def cost(self, width: float) -> float:
        """Cost of a piece with a zone of this width (m, or the dimension's unit)."""
        return self.fixed + self.variable * LAWS[self.law][0](width / self.at)

    def narrowest_below(self, cost: float) -> float:
        """The narrowest width on offer that costs no more; infinite when none does."""
        if self.cost(self.widest) > cost:
            return math.inf
        if self.cost(self.narrowest) <= cost:
            return self.narrowest
        return self.at * LAWS[self.law][1]((cost - self.fixed) / self.variable)


def zone(dimension: Dimension, width: float, anchor: str | None = None) -> tuple[float, float]:
    """Limits of a zone of another width; one point of it stays.

    ``"nominal"`` keeps the nominal size at the same share of the zone, or the limit next to it where the nominal lies
    outside; ``"lower"``, ``"upper"``, ``"middle"`` keep these. None keeps the fundamental deviation of the dimension's
    tolerance class (H, h: the zero line; d: the upper limit; js: the middle), and the nominal where it has none.
    """
    if anchor is None:
        anchor = "nominal" if dimension.toleranced_size is None else fits.held_limit(dimension.toleranced_size)
    present = dimension.upper - dimension.lower
    if present == 0.0 and anchor == "nominal":
        anchor = "middle"
    share = {"lower": 0.0, "upper": 1.0, "middle": 0.5}.get(anchor)
    if share is None:
        share = min(max((dimension.nominal - dimension.lower) / present, 0.0), 1.0)
    fixed = dimension.lower + share * present
    return fixed - share * width, fixed + (1.0 - share) * width


def with_widths(tolerances: Tolerances, choices: Sequence[Grades | Curve], widths: Widths) -> Tolerances:
    """The tolerances with the chosen widths; distributions keep their shape within the new limits."""
    chosen = {choice.name: (choice, width) for choice, width in zip(choices, widths, strict=True)}
    dimensions = (_in_zone(d, *chosen[d.name]) if d.name in chosen else d for d in tolerances.dimensions)
    return replace(tolerances, dimensions=tuple(dimensions))


def _in_zone(dimension: Dimension, choice: Grades | Curve, width: float) -> Dimension:
    size = None
    if isinstance(choice, Grades) and choice.toleranced_sizes:
        size = choice.toleranced_sizes[choice.widths.index(width)]
        named = Dimension.from_tolerance_class(dimension.name, size)
        lower, upper = named.lower, named.upper
    else:
        lower, upper = zone(dimension, width, choice.anchor)
    # The share between lots is kept, not its amount, which might not fit into a narrow zone.
    lots: dict[str, Any] = {"lot_sd": None, "lot_share": dimension.between_lots} if dimension.lot_sd is not None else {}
    distribution = dimension.distribution.in_zone(dimension, lower, upper)
    return replace(dimension, lower=lower, upper=upper, distribution=distribution, toleranced_size=size, **lots)


def offered_box(tolerances: Tolerances, choices: Sequence[Grades | Curve]) -> dict[str, tuple[float, float]]:
    """Range of every dimension over all zones on offer, SI units: an ISO zone may lie beside a wider one (P6, P8).

    Raises
    ------
    InputError
        When a dimension cannot have one of the zones.
    """
    offers = [
        [choice.widths[i] for i in choice.offered] if isinstance(choice, Grades) else [choice.narrowest, choice.widest]
        for choice in choices
    ]
    steps = range(max(map(len, offers)))
    tried = (with_widths(tolerances, choices, [widths[min(i, len(widths) - 1)] for widths in offers]) for i in steps)
    try:
        return hull(*map(training_box, tried))
    except ValueError as error:
        raise InputError(f"allocation: {error}") from None


def hull(*boxes: Mapping[str, tuple[float, float]]) -> dict[str, tuple[float, float]]:
    """The smallest box that holds all of the boxes."""
    return {name: (min(box[name][0] for box in boxes), max(box[name][1] for box in boxes)) for name in boxes[0]}
