"""What to change next: for each dimension the least single change with which the parts keep their limits.

A change moves a zone or makes it narrower: by a letter or a grade where the dimension has an ISO 286 class, else by a tenth of
the zone's width at a time, or by a step of the R10 series. A surrogate over all zones tried finds the first that reaches the
target, and true, independent motions judge it. Moving a zone costs nothing but a drawing, so that moves come first.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from tolmc.allocation.allocate import GLANCE, TRAINING, Inspection
from tolmc.allocation.offers import hull, zone
from tolmc.analysis.model import study_model
from tolmc.analysis.surrogate import Surrogate, fit, training_box
from tolmc.quantities import JOINT
from tolmc.study.study import Study
from tolmc.tolerances import fits
from tolmc.tolerances.dimension import Dimension, Tolerances
from tolmc.tolerances.draw import from_unit, unit_points
from tolmc.tolerances.interference import smallest_clearance

MOVED, NARROWER = "moved", "narrower"
#: Changes that true motions judge, the least ones.
CHECKED = 4
_POINTS = 2**14
_STEPS = 10
_LETTERS = "abcdefgh"
# The surrogate's prediction has to be better than the target by this share of what may be out.
_MARGIN = 0.1


@dataclass(frozen=True)
class _Change:
    """Another zone of a dimension, and how much of a change that is."""

    kind: str
    dimension: Dimension
    amount: float


def next_changes(study: Study, target: float) -> pd.DataFrame:
    """The least changes that the surrogate finds to reach the target, judged by true motions.

    Returns
    -------
    pandas.DataFrame
        A row a change, the least first: ``dimension``, ``kind`` ("moved", "narrower"), ``toleranced_size`` (empty: none),
        ``lower`` and ``upper`` (SI), ``predicted_yield``, ``yield`` with its 95 % interval. Empty where no single change does.

    Raises
    ------
    InputError, ValueError
        When the study's motions cannot be computed or approximated.
    """
    changes = [change for dimension in study.tolerances.varied for change in _changes(study.tolerances, dimension)]
    if not changes:
        return pd.DataFrame()
    outputs = tuple(study.specification)
    tried = [_with(study.tolerances, change.dimension) for change in changes]
    model = study_model(study, outputs, box=hull(*map(training_box, (study.tolerances, *tried))))
    surrogate = fit(
        model, hull(*map(training_box, (study.tolerances, *tried))), outputs, motions=TRAINING, seed=study.seed
    )
    points = unit_points(study.tolerances, _POINTS, sampling="sobol", seed=study.seed)
    asked = target + _MARGIN * (1.0 - target)
    found: dict[tuple[str, str], tuple[_Change, float]] = {}
    for change, tolerances in zip(changes, tried, strict=True):
        key = change.dimension.name, change.kind
        if key not in found and (predicted := _yield(surrogate, tolerances, points, study.specification)) >= asked:
            found[key] = change, predicted
    order = sorted(found.values(), key=lambda pair: (pair[0].kind != MOVED, pair[0].amount))[:CHECKED]
    inspection = Inspection(model, study.specification, study.on_contact_loss)
    return pd.DataFrame([_row(study, inspection, *pair) for pair in order])


def _changes(tolerances: Tolerances, dimension: Dimension) -> Iterator[_Change]:
    """Other zones of a dimension that leave a clearance, the least change of each kind first."""
    if dimension.distribution.stands_alone:
        return
    possible = _of_class(dimension) if dimension.toleranced_size is not None else _free(dimension)
    for change in possible:
        if dimension.name not in JOINT or smallest_clearance(_with(tolerances, change.dimension)) > 0:
            yield change


def _free(dimension: Dimension) -> Iterator[_Change]:
    width = dimension.upper - dimension.lower
    for step in range(1, _STEPS + 1):
        for sign in (1, -1):
            shift = sign * step / _STEPS * width
            yield _Change(
                MOVED, _between(dimension, dimension.lower + shift, dimension.upper + shift, shift), step / _STEPS
            )
    for step in range(1, _STEPS + 1):
        narrower = width * 10.0 ** (-step / 10.0)
        yield _Change(NARROWER, _between(dimension, *zone(dimension, narrower), 0.0), width / narrower)


def _of_class(dimension: Dimension) -> Iterator[_Change]:
    size, letter, grade = fits.parts(str(dimension.toleranced_size))
    if letter.lower() in _LETTERS:
        place = _LETTERS.index(letter.lower())
        for other in sorted(_LETTERS, key=lambda word: abs(_LETTERS.index(word) - place))[1:]:
            named = other.upper() if letter.isupper() else other
            yield from _class(dimension, MOVED, f"{size} {named}{grade}", abs(_LETTERS.index(other) - place))
    for finer in range(int(grade) - 1, max(int(grade) - 5, 0), -1):
        yield from _class(dimension, NARROWER, f"{size} {letter}{finer}", 10.0 ** ((int(grade) - finer) / 5.0))


def _class(dimension: Dimension, kind: str, toleranced: str, amount: float) -> Iterator[_Change]:
    try:
        yield _Change(kind, dimension.in_class(toleranced), amount)
    except ValueError:  # the standard does not have every letter in every grade and size
        return


def _between(dimension: Dimension, lower: float, upper: float, shift: float) -> Dimension:
    distribution = dimension.distribution.in_zone(dimension, lower, upper)
    return replace(dimension, nominal=dimension.nominal + shift, lower=lower, upper=upper, distribution=distribution)


def _with(tolerances: Tolerances, dimension: Dimension) -> Tolerances:
    changed = (dimension if d.name == dimension.name else d for d in tolerances.dimensions)
    return replace(tolerances, dimensions=tuple(changed))


def _yield(
    surrogate: Surrogate, tolerances: Tolerances, points: np.ndarray, specification: Mapping[str, Mapping[str, float]]
) -> float:
    outputs = surrogate(from_unit(tolerances, points))
    kept = np.ones(len(points), bool)
    for name, limits in specification.items():
        values = outputs[name].to_numpy()
        kept &= (values <= limits.get("max", np.inf)) & (values >= limits.get("min", -np.inf))
    return float(kept.mean())


def _row(study: Study, inspection: Inspection, change: _Change, predicted: float) -> dict[str, object]:
    dimension = change.dimension
    judged = inspection.yield_of(_with(study.tolerances, dimension), GLANCE, study.seed + 1, 0.975)
    return {
        "dimension": dimension.name,
        "kind": change.kind,
        "toleranced_size": dimension.toleranced_size or "",
        "lower": dimension.lower,
        "upper": dimension.upper,
        "predicted_yield": predicted,
        "yield": judged.value,
        "yield_low": judged.low,
        "yield_high": judged.high,
    }
