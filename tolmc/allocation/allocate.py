"""Which tolerances to choose: the cheapest that keep a required share of the motions within specification.

For each dimension the designer offers widths T of its tolerance zone and what they cost: ISO 286 grades with a cost each
(:class:`Grades`), or a range of widths with a cost-tolerance function (:class:`Curve`). The search asks for

    minimise sum_j c_j(T_j)   subject to   P(all outputs within specification | T) >= yield

A surrogate over the box of all zones on offer stands for the motions (:mod:`tolmc.analysis.surrogate`), and the same
quasi-random points serve every choice of widths (common random numbers), so that two
choices differ by their widths alone. Combinations
of grades are tried from the cheapest up until no cheaper one is left: the first that reaches the yield is the optimum,
whatever the outputs do. Widths that are free are found by sequential quadratic programming for each combination, with the
yield written as "the worst requirement's margin has its yield-quantile at zero or below", which is smooth where a count is
not. Predicted yields are of the motions that succeed; how many of the training ones did not is part of the result.

The winner is confirmed by true, independent motions; what counts is the lower confidence limit of their yield.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from tolmc import quantities
from tolmc.allocation.offers import ANCHORS, LAWS, Curve, Grades, offered_box, with_widths, zone
from tolmc.allocation.search import MAX_POINTS, Allocation, Search
from tolmc.analysis.surrogate import Model, Surrogate, fit, refuse_rough
from tolmc.errors import InputError
from tolmc.statistics.intervals import binomial_interval
from tolmc.statistics.outcomes import Specification, contact_lost, failed, out_of_specification
from tolmc.statistics.rows import Rows
from tolmc.tolerances.dimension import Tolerances
from tolmc.tolerances.draw import sample

__all__ = [
    "ANCHORS", "LAWS", "Allocation", "AllocationResult", "Curve", "Grades", "MotionYield", "Plan", "allocate",
    "with_widths", "zone",
]  # fmt: skip

TRAINING = 512
MAX_COMBINATIONS = 200_000
MAX_ATTEMPTS = 5
#: Motions that answer for tolerances which are not confirmed: the study's own, and grades beside those on offer.
GLANCE = 10_000
#: Yields of the trade-off, beside the one required.
LADDER = (0.9, 0.95, 0.99, 0.9973, 0.999, 0.9999)
#: One ISO 286 grade widens a zone by about this factor (R5 series); the step for widths that are free.
GRADE_STEP = 10.0 ** (1.0 / 5.0)
_MIN_POINTS = 2**14


@dataclass(frozen=True)
class Plan:
    """What is asked of an allocation.

    Parameters
    ----------
    choices : of Grades and Curve, one a dimension
    target_yield : float
        Share of motions that keep every requirement, in (0, 1).
    confidence : float
        Of the statement that the yield is at least that, in (0.5, 1).
    samples : int
        True motions of the confirming run.
    seed : int
    """

    choices: tuple[Grades | Curve, ...]
    target_yield: float = 0.9973
    confidence: float = 0.95
    samples: int = 100_000
    seed: int = 0


@dataclass(frozen=True)
class MotionYield:
    """Yield of true, independent motions.

    A motion is not known when it failed, or when its journal left the wall before a limit was broken and nothing says
    what holds then. It counts as out of specification in ``value`` and ``low``, as within it in ``high``.

    Attributes
    ----------
    value : float
        Share known to be within specification.
    low, high : float
        One-sided confidence limits of the yield.
    samples, unknown, failed, contact_lost : int
        Motions, and how many of them were not known, failed, lost contact.
    """

    value: float
    low: float
    high: float
    samples: int
    unknown: int
    failed: int
    contact_lost: int


@dataclass(frozen=True)
class AllocationResult:
    """The winner and what surrounds it.

    Attributes
    ----------
    winner : Allocation
        When not ``is_met``, the choice that was confirmed last.
    tolerances : Tolerances
        With the winner's limits.
    dimensions : DataFrame
        A row a choice: grade, toleranced_size (empty: none), width, lower, upper (SI), cost.
    predicted_yield : float
        By the surrogate.
    confirmed : MotionYield
        Yield of the independent true motions; ``low`` is its one-sided lower limit at ``confidence``.
    is_met : bool
        Whether that limit reaches the target.
    attempts : int
        Confirming runs; each failure sends the search to a safer choice, and the levels of all add up to the stated one.
    present_yield : MotionYield
        Of the study's own tolerances, by at most :data:`GLANCE` motions; ``low`` and ``high`` hold it with ``confidence``.
    trade_off : DataFrame
        The cheapest choice for each yield: ``required_yield``, ``cost``, ``predicted_yield``, widths by dimension.
    neighbours : DataFrame
        Each choice one grade finer and coarser, the others kept: ``cost``, ``cost_change`` (NaN: not on offer),
        ``predicted_yield`` (of grades not on offer, by :data:`GLANCE` true motions), ``out_ppm``.
    surrogate : Surrogate
        With its training motions, and how many of them failed or lost contact.
    motions : int
        True motions spent.
    """

    plan: Plan
    winner: Allocation
    tolerances: Tolerances
    dimensions: pd.DataFrame
    predicted_yield: float
    confirmed: MotionYield
    is_met: bool
    attempts: int
    present_yield: MotionYield
    trade_off: pd.DataFrame
    neighbours: pd.DataFrame
    surrogate: Surrogate
    motions: int


def allocate(
    tolerances: Tolerances,
    specification: Mapping[str, Mapping[str, float | None]],
    plan: Plan,
    model: Model,
    *,
    training: int = TRAINING,
    on_contact_loss: str = "stop",
) -> AllocationResult:
    """Find the cheapest tolerances and confirm them.

    Parameters
    ----------
    tolerances : Tolerances
        Every dimension; those without a choice keep their tolerance.
    specification : mapping of output to {"min": ..., "max": ...}, SI units
    plan : Plan
    model : callable
        Inputs to outputs, by true motions.
    training : int
        Motions that train the surrogate.
    on_contact_loss : "stop", "continue" or "end"
        What the motions do then; "stop": a motion that lost contact is not known to keep a limit.

    Raises
    ------
    InputError
        When the plan, the specification or the sizes of the runs cannot serve, and when no choice reaches the yield.
    """
    _check(tolerances, specification, plan)
    planned = _planned_yield(plan, tolerances)
    surrogate = _train(model, tolerances, specification, plan, training)
    search = Search(tolerances, specification, plan.choices, surrogate, points=_point_count(planned), seed=plan.seed)
    inspection = Inspection(model, specification, on_contact_loss)
    winner, confirmed, attempts = _confirm(search, inspection, plan, planned)
    chosen, glance = with_widths(tolerances, plan.choices, winner.widths), min(plan.samples, GLANCE)
    present = inspection.yield_of(tolerances, glance, plan.seed, 0.5 + 0.5 * plan.confidence)
    neighbours = _neighbours(search, plan, winner, inspection, glance)
    return AllocationResult(
        plan=plan,
        winner=winner,
        tolerances=chosen,
        dimensions=_dimension_table(plan, winner, chosen),
        predicted_yield=search.fresh_yield(winner.widths),
        confirmed=confirmed,
        is_met=confirmed.low >= plan.target_yield,
        attempts=attempts,
        present_yield=present,
        trade_off=_trade_off(search, plan),
        neighbours=neighbours,
        surrogate=surrogate,
        motions=surrogate.motions + attempts * plan.samples + glance * (1 + int(neighbours["cost"].isna().sum())),
    )


def _train(model: Model, tolerances: Tolerances, specification: Specification, plan: Plan, motions: int) -> Surrogate:
    box = offered_box(tolerances, plan.choices)
    try:
        surrogate = fit(model, box, tuple(specification), motions=motions, seed=plan.seed)
        refuse_rough("the surrogate that allocation searches with", surrogate)
    except ValueError as error:
        raise InputError(f"allocation: {error}") from None
    return surrogate


def _confirm(search: Search, inspection: Inspection, plan: Plan, planned: float) -> tuple[Allocation, MotionYield, int]:
    """The first candidate that is confirmed, or else the last tried, with its yield and the number of confirming runs."""
    tried: list[Allocation] = []
    for attempt in range(1, MAX_ATTEMPTS + 1):
        candidate = _candidate(search, planned, tried) if _can_show(plan, search.tolerances, attempt) else None
        if candidate is None:
            break
        tried.append(candidate)
        chosen = with_widths(search.tolerances, plan.choices, candidate.widths)
        confirmed = inspection.yield_of(chosen, plan.samples, plan.seed + attempt, _confidence(plan, attempt))
        if confirmed.low >= plan.target_yield:
            break
        planned = 1.0 - 0.5 * (1.0 - planned)
    if not tried:
        raise InputError(_nothing_found(search, plan, planned))
    return tried[-1], confirmed, len(tried)


def _candidate(search: Search, planned: float, refused: Sequence[Allocation]) -> Allocation | None:
    """The cheapest choice with the planned yield, judged by points that it was not chosen on."""
    required = planned
    for _ in range(4):
        candidate = search.cheapest(required, refused=refused)
        shortfall = 0.0 if candidate is None else planned - search.fresh_yield(candidate.widths)
        if shortfall <= 0.0:
            break
        required += shortfall
    return candidate


def _check(tolerances: Tolerances, specification: Specification, plan: Plan) -> None:
    if not specification:
        raise InputError("allocation: [specification] is empty; give at least one output a limit.")
    for name in specification:
        if quantities.output(name).event:
            raise InputError(
                f"allocation: {name} is missing where that never happens, so it cannot be approximated; "
                "require contact_force_D_min and contact_force_E_min >= 0 instead."
            )
    if not plan.choices:
        raise InputError("allocation: no dimension has a choice; give at least one grades or a cost function.")
    combinations = math.prod(len(choice.offered) for choice in plan.choices if isinstance(choice, Grades))
    if combinations > MAX_COMBINATIONS:
        raise InputError(
            f"allocation: the grades make {combinations} combinations; allowed: {MAX_COMBINATIONS}. Offer fewer grades."
        )
    by_name = {dimension.name: dimension for dimension in tolerances.dimensions}
    for choice in plan.choices:
        if choice.name not in by_name:
            raise InputError(f"allocation: {choice.name} is no dimension of the study; allowed: {', '.join(by_name)}.")
        if by_name[choice.name].distribution.stands_alone:
            raise InputError(
                f"allocation: {choice.name} follows a distribution of its own (measured values or scipy.stats), which "
                "does not narrow with the limits; give it one that does, such as normal, or leave it out."
            )


def _planned_yield(plan: Plan, tolerances: Tolerances) -> float:
    """The least true yield whose confirming run passes in 39 of 40 cases."""
    confidence, lot_size = _confidence(plan, 1), tolerances.lot_size or 1
    if not _can_show(plan, tolerances, 1):
        lots = "" if lot_size == 1 else f" in lots of {lot_size}"
        raise InputError(
            f"allocation: samples = {plan.samples}{lots} cannot show a yield of {plan.target_yield} at the confidence "
            f"{plan.confidence}, even if all are good; give at least {_least_units(plan, 1) * lot_size}, ten times that "
            "to leave a choice."
        )
    # Parts of a lot fail together with a correlation of at most that of anything they have in common.
    units = plan.samples / (1.0 + (lot_size - 1) * tolerances.lot_correlation)
    low, high = plan.target_yield, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        spread = math.sqrt(units * middle * (1.0 - middle))
        passes = _lower_limit(units * middle - 1.96 * spread, units, confidence) >= plan.target_yield
        low, high = (low, middle) if passes else (middle, high)
    return high


def _can_show(plan: Plan, tolerances: Tolerances, attempt: int) -> bool:
    """Whether a confirming run can pass at all: the parts of a lot may all be good together, so each lot counts once."""
    return math.ceil(plan.samples / (tolerances.lot_size or 1)) >= _least_units(plan, attempt)


def _least_units(plan: Plan, attempt: int) -> int:
    """Independent units that show the yield when all are good."""
    return math.ceil(math.log(1.0 - _confidence(plan, attempt)) / math.log(plan.target_yield))


def _confidence(plan: Plan, attempt: int) -> float:
    """Confidence of a confirming run; the errors of all runs, halved from one to the next, add up to the stated one."""
    return 1.0 - (1.0 - plan.confidence) / 2.0**attempt


def _lower_limit(good: float, count: float, confidence: float) -> float:
    """One-sided Clopper-Pearson limit."""
    return binomial_interval(min(max(good, 0.0), count), count, confidence=2.0 * confidence - 1.0)[0]


def _point_count(planned: float) -> int:
    """Points that hold some hundred failures at the planned yield."""
    wanted = 200.0 / max(1.0 - planned, 1e-12)
    return int(min(max(2 ** math.ceil(math.log2(wanted)), _MIN_POINTS), MAX_POINTS))


@dataclass(frozen=True)
class Inspection:
    """True motions of tolerances, held against the specification."""

    model: Model
    specification: Mapping[str, Mapping[str, float | None]]
    on_contact_loss: str

    def yield_of(self, tolerances: Tolerances, count: int, seed: int, confidence: float) -> MotionYield:
        """Yield of independent motions, with one-sided limits."""
        samples = self.model(sample(tolerances, count, sampling="random", seed=seed))
        out, known = out_of_specification(samples, self.specification, on_contact_loss=self.on_contact_loss)
        broken = np.logical_or.reduce(list(out.values()))
        good = ~broken & np.logical_and.reduce(list(known.values()))
        rows = Rows("random", 2.0 * confidence - 1.0, tolerances.lot_size or 1)
        least, most = rows.share(good), rows.share(~broken)
        counts = (
            int(np.count_nonzero(motions)) for motions in (~good & ~broken, failed(samples), contact_lost(samples))
        )
        return MotionYield(least.value, least.low, most.high, count, *counts)


def _nothing_found(search: Search, plan: Plan, planned: float) -> str:
    narrowest, widest = (
        search.yield_of([getattr(choice, end) for choice in plan.choices]) for end in ("narrowest", "widest")
    )
    return (
        f"allocation: no choice of tolerances has a predicted yield of {planned:.6g}, which it takes to show "
        f"{plan.target_yield:.6g} at the confidence {plan.confidence:.6g} with {plan.samples} samples; the narrowest one has "
        f"{narrowest:.6g}, the widest {widest:.6g}. Offer other zones, widen [specification], ask for a lower yield, or "
        "confirm with more samples."
    )


def _cost(choice: Grades | Curve, label: str, width: float) -> float:
    return choice.costs[choice.labels.index(label)] if isinstance(choice, Grades) else choice.cost(width)


def _dimension_table(plan: Plan, winner: Allocation, tolerances: Tolerances) -> pd.DataFrame:
    by_name = {dimension.name: dimension for dimension in tolerances.dimensions}
    rows = [
        {
            "dimension": choice.name,
            "grade": label,
            "toleranced_size": by_name[choice.name].toleranced_size or "",
            "width": width,
            "lower": by_name[choice.name].lower,
            "upper": by_name[choice.name].upper,
            "cost": _cost(choice, label, width),
        }
        for choice, label, width in zip(plan.choices, winner.labels, winner.widths, strict=True)
    ]
    return pd.DataFrame(rows).set_index("dimension")


def _describe(search: Search, plan: Plan, allocation: Allocation) -> dict[str, object]:
    predicted = search.yield_of(allocation.widths)
    return {
        "cost": allocation.cost,
        "predicted_yield": predicted,
        "out_ppm": 1e6 * (1.0 - predicted),
        **{
            choice.name: label or width
            for choice, label, width in zip(plan.choices, allocation.labels, allocation.widths, strict=True)
        },
    }


def _trade_off(search: Search, plan: Plan) -> pd.DataFrame:
    rows, allocation = [], None
    for required in sorted({*LADDER, plan.target_yield}, reverse=True):
        # What reaches the higher yield reaches this one too, and leaves less to search.
        allocation = search.cheapest(required, known=allocation)
        if allocation is not None:
            rows.append({"required_yield": required, **_describe(search, plan, allocation)})
    return pd.DataFrame(rows[::-1])


def _neighbours(search: Search, plan: Plan, winner: Allocation, inspection: Inspection, glance: int) -> pd.DataFrame:
    rows = []
    for j, choice in enumerate(plan.choices):
        for direction, neighbour in _steps(search, choice, winner, j):
            if math.isnan(neighbour.cost):  # beyond the zones that trained the surrogate
                tolerances = with_widths(search.tolerances, plan.choices, neighbour.widths)
                predicted = inspection.yield_of(tolerances, glance, plan.seed, plan.confidence).value
            else:
                predicted = search.fresh_yield(neighbour.widths)
            rows.append(
                {
                    "dimension": choice.name,
                    "direction": direction,
                    "from": winner.labels[j] or winner.widths[j],
                    "to": neighbour.labels[j] or neighbour.widths[j],
                    "cost": neighbour.cost,
                    "cost_change": neighbour.cost - winner.cost,
                    "predicted_yield": predicted,
                    "out_ppm": 1e6 * (1.0 - predicted),
                }
            )
    columns = ("dimension", "direction", "from", "to", "cost", "cost_change", "predicted_yield", "out_ppm")
    return pd.DataFrame(rows, columns=columns)


def _steps(search: Search, choice: Grades | Curve, winner: Allocation, j: int) -> Iterator[tuple[str, Allocation]]:
    """The winner with choice j one grade finer and one coarser, where there is one."""
    grades = [
        other.labels.index(label) if isinstance(other, Grades) else 0
        for other, label in zip(search.choices, winner.labels, strict=True)
    ]
    for direction, step in (("finer", -1), ("coarser", 1)):
        widths, chosen = list(winner.widths), list(grades)
        if isinstance(choice, Grades):
            chosen[j] += step
            if not 0 <= chosen[j] < len(choice.widths):
                continue
            widths[j] = choice.widths[chosen[j]]
        else:
            widths[j] = min(max(widths[j] * GRADE_STEP**step, choice.narrowest), choice.widest)
            if widths[j] == winner.widths[j]:
                continue
        yield direction, search.allocation(widths, chosen)
