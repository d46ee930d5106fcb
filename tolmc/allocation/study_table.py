"""The [allocation] table of a study file: what tolerances cost and which yield is required.

[allocation]
target_yield = 0.9973          share of the motions that keep every limit of [specification]
confidence = 0.95              of the statement that the yield is at least that; above 0.5
samples = 100000               independent motions of the confirming run
seed = 7                       that of [monte_carlo] when not given

[allocation.dimensions]        each dimension whose tolerance is to be chosen; the others keep theirs
bearing_radius = { grades = { IT7 = 9.0, IT8 = 5.5, IT9 = 3.6 }, anchor = "lower" }
half_length = { narrowest = "0.02 mm", widest = "0.4 mm", cost = { fixed = 1, variable = 2, at = "0.1 mm" } }

``grades``: ISO 286 grades of the diameter (of the bearing's length 2 L), each with the cost of a piece; a radius or half-length
gets half their width. The standard's row is that of the basic size of a ``fit`` or ``diameter``, else of twice the nominal.
``cost``: fixed + variable f(T/at) of the zone's width T = upper - lower, between the widths ``narrowest`` and ``widest``;
``law`` names f: "reciprocal" (1/x, the default), "reciprocal-square" (1/x^2) or "exponential" (exp(1 - x)).
``anchor``: the point of the zone that stays when its width changes: "nominal", "lower", "upper" or "middle". When it is not
given, the zone of a ``fit`` or ``diameter`` keeps its letter (40 H7 becomes 40 H9), any other its nominal.
Costs are in any currency. Distributions keep their shape between the limits.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from tolmc import units
from tolmc.allocation.allocate import Plan
from tolmc.allocation.offers import ANCHORS, LAWS, Curve, Grades, with_widths
from tolmc.study.fields import Faults, Own, Section, check_names, in_section, place, quantity, validated, whole
from tolmc.study.sections import MAX_SAMPLES
from tolmc.study.study import Study, StudyError
from tolmc.tolerances import fits
from tolmc.tolerances.dimension import Dimension, Tolerances

_GRADED = ("bearing_radius", "journal_radius", "half_length")


def _share(low: float):
    def read(value: object) -> float:
        number = units.read(value, "1")
        if not low < number < 1.0:
            raise ValueError(f"expected a share between {low:g} and 1, such as 0.9973 or '99.73 %'")
        return number

    return Annotated[float, BeforeValidator(read)]


class _Cost(Section):
    law: Literal[tuple(LAWS)] = "reciprocal"
    fixed: quantity("1") = 0.0
    variable: Annotated[
        quantity("1", positive=True), Field(description="give the cost on top of fixed at the width `at`")
    ]
    at: Annotated[Own, Field(description="give the width to which the variable cost belongs")]


class _Choice(Section):
    grades: dict[str, quantity("1", positive=True)] | None = None
    cost: _Cost | None = None
    narrowest: Own | None = None
    widest: Own | None = None
    anchor: Literal[ANCHORS] | None = None


class _Allocation(Section):
    target_yield: _share(0.0) = 0.9973
    confidence: _share(0.5) = 0.95
    samples: whole(1, MAX_SAMPLES) = 100_000
    seed: whole(0, 2**63 - 1) | None = None
    dimensions: Annotated[dict[str, Any], Field(description="give each dimension to choose grades or a cost function")]


def read_plan(study: Study) -> Plan:
    """The plan that a study's [allocation] describes.

    Raises
    ------
    StudyError
        The message names the field, its value, what is allowed and what to do.
    """
    try:
        return _plan(study)
    except Faults as faults:
        raise StudyError("\n".join(f"{study.title}: {sentence}" for sentence in faults.sentences)) from None


def _plan(study: Study) -> Plan:
    if not study.allocation:
        raise Faults("[allocation] is missing; say there what tolerances cost and which yield is required.")
    table = validated(_Allocation, study.allocation, "allocation")
    names = tuple(dimension.name for dimension in study.tolerances.dimensions)
    check_names(table.dimensions, names, "allocation", "dimensions")
    choices = tuple(_choice(study, name, entry) for name, entry in table.dimensions.items())
    seed = study.seed if table.seed is None else table.seed
    return Plan(choices, table.target_yield, table.confidence, table.samples, seed)


def _choice(study: Study, name: str, entry: object) -> Grades | Curve:
    where = ("allocation", "dimensions", name)
    choice = validated(_Choice, entry, *where, context=units.SI[name])
    if (choice.grades is None) == (choice.cost is None):
        raise Faults(f"{place(*where)} must have either grades or cost; give one of them.")
    if choice.grades is not None:
        return _grades(study, name, choice)
    for field in ("narrowest", "widest"):
        if getattr(choice, field) is None:
            raise Faults(f"{place(*where, field)} is missing; give the {field} zone that can be bought.")
    if choice.cost.at <= 0 or not 0 < choice.narrowest < choice.widest:
        raise Faults(f"{place(*where)}: allowed: at > 0 and 0 < narrowest < widest; correct the widths.")
    cost = choice.cost
    return Curve(name, choice.narrowest, choice.widest, cost.at, cost.variable, cost.fixed, cost.law, choice.anchor)


def _grades(study: Study, name: str, choice: _Choice) -> Grades:
    where = ("allocation", "dimensions", name, "grades")
    if name not in _GRADED:
        raise Faults(f"{place(*where)}: ISO 286 grades are for {', '.join(_GRADED)}; give {name} a cost function.")
    if not choice.grades:
        raise Faults(f"{place(*where)} is empty; give at least one grade with its cost, such as IT7 = 9.0.")
    if choice.narrowest is not None or choice.widest is not None:
        raise Faults(f"{place(*where)}: narrowest and widest belong to a cost function; leave them out.")
    dimension = next(dimension for dimension in study.tolerances.dimensions if dimension.name == name)
    with in_section(*where):
        offer = _offer(dimension, choice.grades, choice.anchor)
    for step in (-1, 1):
        offer = _with_grade_beside(study.tolerances, dimension, offer, step)
    return offer


def _offer(dimension: Dimension, costs: Mapping[str, float], anchor: str | None) -> Grades:
    """Grades with these costs, narrowest first."""
    widths = {label: 0.5 * fits.it_grade(_basic_size(dimension), label) for label in costs}
    labels = tuple(sorted(widths, key=widths.get))
    sizes = ()
    if anchor is None and dimension.toleranced_size is not None:
        sizes = tuple(fits.with_grade(dimension.toleranced_size, label) for label in labels)
        for size in sizes:
            fits.size_limits(size)  # the standard does not have every letter in every grade
    columns = (tuple(column[label] for label in labels) for column in (widths, costs))
    return Grades(dimension.name, labels, *columns, anchor, sizes)


def _with_grade_beside(tolerances: Tolerances, dimension: Dimension, offer: Grades, step: int) -> Grades:
    """The offer with the next finer or coarser grade, which has no cost, where the standard and the dimension allow it."""
    end = offer.labels[0 if step < 0 else -1]
    place = fits.GRADES.index(end.upper().removeprefix("IT")) + step
    if not 0 <= place < len(fits.GRADES):
        return offer
    costs = dict(zip(offer.labels, offer.costs, strict=True)) | {f"IT{fits.GRADES[place]}": math.nan}
    try:
        wider = _offer(dimension, costs, offer.anchor)
        with_widths(tolerances, [wider], [wider.widths[0 if step < 0 else -1]])
    except ValueError:
        return offer
    return wider


def _basic_size(dimension: Dimension) -> float:
    """Size that decides the row of the standard's tables, mm: that of the tolerance class, else twice the nominal."""
    named = dimension.toleranced_size
    size = 2.0 * dimension.nominal if named is None else fits.size_limits(named)[0]
    return round(1e3 * size, 9)  # rounding of the units must not carry 50 mm into the row above
