"""The [allocation] table of a study file: what tolerances cost and which yield is required.

[allocation.dimensions]
bearing_radius = { grades = { IT7 = 9.0, IT8 = 5.5, IT9 = 3.6 }, anchor = "lower" }
half_length = { narrowest = "0.02 mm", widest = "0.4 mm", cost = { fixed = 1, variable = 2, at = "0.1 mm" } }

A radius or half-length gets half the width of its grade. The standard's row is that of the basic size of a ``fit`` or
``diameter``, else of twice the nominal; the zone of such a size keeps its letter (40 H7 becomes 40 H9).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal

from tolmc.allocation.allocate import Plan
from tolmc.allocation.offers import ANCHORS, LAWS, Curve, Grades, with_widths
from tolmc.quantities import DRAWN, JOINT
from tolmc.study.drawing import model_name
from tolmc.study.fields import (
    Faults,
    Form,
    Own,
    OwnUnit,
    Section,
    check_names,
    in_section,
    own,
    place,
    quantity,
    share,
    short,
    validated,
    whole,
)
from tolmc.study.sections import MAX_SAMPLES, TARGET_YIELD
from tolmc.study.study import Study, StudyError
from tolmc.tolerances import fits
from tolmc.tolerances.dimension import Dimension, Tolerances


class _Cost(Section):
    """What a dimension costs: fixed + variable f(T/at) of the width T of its zone, upper less lower limit."""

    law: Literal[tuple(LAWS)] = "reciprocal"
    """Its shape f(x): 1/x, 1/x² or exp(1 - x)."""
    fixed: quantity("1") = 0.0
    """Cost however wide the zone is, in any currency."""
    variable: quantity("1", positive=True, remedy="give the cost on top of fixed at the width `at`")
    """Cost on top of `fixed` where the zone is `at` wide."""
    at: own(remedy="give the width to which the variable cost belongs")
    """The width to which the variable cost belongs."""


class ChoiceSection(Section):
    """What one dimension of `[allocation.dimensions]` may be: ISO 286 grades, or any width between two."""

    grades: dict[str, quantity("1", positive=True)] | None = None
    """Grades of the diameter (of the bearing's length) and the cost of a piece in each: { IT7 = 9.0, IT8 = 5.5 }."""
    cost: _Cost | None = None
    """Cost of any width, in place of `grades`."""
    narrowest: Own | None = None
    """Narrowest zone that can be bought, with `cost`."""
    widest: Own | None = None
    """Widest zone, with `cost`."""
    anchor: Literal[ANCHORS] | None = None
    """Point of the zone that stays when its width changes. When not given the zone of a `fit` or `diameter` keeps its letter,
    any other its nominal value."""


class AllocationSection(Section):
    """What tolerances cost and which yield is required, for `tolmc allocate`. Distributions keep their shape."""

    target_yield: share(0.0) | None = None
    """Share of the motions that keep every limit; that of `[specification] target` when not given, else 99.73 %."""
    confidence: share(0.5) = 0.95
    """Of the statement that the yield is at least that."""
    samples: whole(1, MAX_SAMPLES) = 100_000
    """Independent motions of the confirming run."""
    seed: whole(0, 2**63 - 1) | None = None
    """Its seed; that of `[monte_carlo]` when not given."""
    dimensions: Annotated[
        dict[str, Any],
        Form("a table for each", {"type": "object"}, "give each dimension to choose grades or a cost function"),
    ]
    """Each dimension whose tolerance is to be chosen; the others keep theirs."""


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
    table = validated(AllocationSection, study.allocation, "allocation")
    names = tuple(dimension.name for dimension in study.tolerances.dimensions)
    check_names(
        table.dimensions, (*names, *(DRAWN[name] for name in names if name in DRAWN)), "allocation", "dimensions"
    )
    choices = tuple(_choice(study, word, entry) for word, entry in table.dimensions.items())
    if len({choice.name for choice in choices}) < len(choices):
        raise Faults(
            "[allocation] dimensions: a dimension is there twice, by its own name and the drawing's; leave one out."
        )
    seed = study.seed if table.seed is None else table.seed
    target = table.target_yield or study.target or TARGET_YIELD
    return Plan(choices, target, table.confidence, table.samples, seed)


def _choice(study: Study, word: str, entry: object) -> Grades | Curve:
    name, where = model_name(word), ("allocation", "dimensions", word)
    choice = validated(ChoiceSection, entry, *where, context=OwnUnit.of(word))
    cost: _Cost | None = choice.cost
    ends: dict[str, Any] = {"narrowest": choice.narrowest, "widest": choice.widest}
    if (choice.grades is None) == (cost is None):
        raise Faults(f"{place(*where)} = {short(entry)}: expected either grades or cost; give one of them.")
    if cost is None:
        return _grades(study, name, choice, (*where, "grades"))
    for field, width in ends.items():
        if width is None:
            raise Faults(f"{place(*where, field)} is missing; give the {field} zone that can be bought.")
    if cost.at <= 0 or not 0 < ends["narrowest"] < ends["widest"]:
        raise Faults(
            f"{place(*where)} = {short(entry)}: expected at > 0 and 0 < narrowest < widest; correct the widths."
        )
    return Curve(name, ends["narrowest"], ends["widest"], cost.at, cost.variable, cost.fixed, cost.law, choice.anchor)


def _grades(study: Study, name: str, choice: ChoiceSection, where: tuple[str, ...]) -> Grades:
    if name not in JOINT:
        raise Faults(f"{place(*where)}: ISO 286 grades are for {', '.join(JOINT)}; give {name} a cost function.")
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
    labels = tuple(sorted(widths, key=widths.__getitem__))
    sizes: tuple[str, ...] = ()
    if anchor is None and dimension.toleranced_size is not None:
        sizes = tuple(fits.with_grade(dimension.toleranced_size, label) for label in labels)
        for size in sizes:
            fits.size_limits(size)  # the standard does not have every letter in every grade
    wide, each = (tuple(column[label] for label in labels) for column in (widths, costs))
    return Grades(dimension.name, labels, wide, each, anchor, sizes)


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
