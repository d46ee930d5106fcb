"""Which tolerances to choose: the cheapest that keep a required share of the motions within specification.

For each dimension the designer offers widths T of its tolerance zone and what they cost: ISO 286 grades with a cost each
(:class:`Grades`), or a range of widths with a cost-tolerance function (:class:`Curve`). The search asks for

    minimise sum_j c_j(T_j)   subject to   P(all outputs within specification | T) >= yield

A surrogate over the box of the widest zones stands for the motions (:mod:`tolmc.surrogate`), and the same quasi-random points
serve every choice of widths (common random numbers), so that two choices differ by their widths alone. Combinations of
grades are tried from the cheapest up until no cheaper one is left: the first that reaches the yield is the optimum,
whatever the outputs do. Widths that are free are found by sequential quadratic programming for each combination, with the
yield written as "the worst requirement's margin has its yield-quantile at zero or below", which is smooth where a count is not.

The winner is confirmed by true, independent motions; what counts is the lower confidence limit of their yield.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np
import pandas as pd
from scipy.optimize import Bounds, minimize

from tolmc.errors import InputError
from tolmc.intervals import Estimate, Rows, binomial_interval
from tolmc.sampling import SCRAMBLINGS
from tolmc.statistics import out_of_specification
from tolmc.surrogate import Model, Surrogate, fit, training_box
from tolmc.tolerances import Dimension, Tolerances, from_unit, sample, unit_points

ANCHORS = ("nominal", "lower", "upper", "middle")
#: Laws of the variable cost, 1 at x = T/at = 1 and falling, each with its inverse.
LAWS = {
    "reciprocal": (lambda x: 1.0 / x, lambda y: 1.0 / y),
    "reciprocal-square": (lambda x: x**-2.0, lambda y: y**-0.5),
    "exponential": (lambda x: math.exp(1.0 - x), lambda y: 1.0 - math.log(y)),
}
TRAINING = 512
MAX_COMBINATIONS = 200_000
MAX_ATTEMPTS = 5
#: Yields of the trade-off, beside the one required.
LADDER = (0.9, 0.95, 0.99, 0.9973, 0.999, 0.9999)
#: One ISO 286 grade widens a zone by about this factor (R5 series); the step for widths that are free.
GRADE_STEP = 10.0 ** (1.0 / 5.0)
_MIN_POINTS, _MAX_POINTS = 2**14, 2**18
_DIFFERENCE = 1e-4  # relative, of a width


@dataclass(frozen=True)
class Grades:
    """Widths to choose from, narrowest first, with the cost of a piece at each.

    ``anchor`` says which point of the zone stays where it is (see :func:`zone`).
    """

    name: str
    labels: tuple[str, ...]
    widths: tuple[float, ...]
    costs: tuple[float, ...]
    anchor: str = "nominal"


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
    anchor: str = "nominal"

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
class Allocation:
    """A width for every choice, in their order, its label (a grade, or empty for a free width), and the cost of all."""

    widths: tuple[float, ...]
    labels: tuple[str, ...]
    cost: float


@dataclass(frozen=True)
class AllocationResult:
    """The winner and what surrounds it.

    Attributes
    ----------
    winner : Allocation
    tolerances : Tolerances
        With the winner's limits.
    dimensions : DataFrame
        A row a choice: grade, width, lower, upper (SI), cost.
    predicted_yield : float
        By the surrogate.
    confirmed : Estimate
        Yield of the independent true motions; ``low`` is its one-sided lower limit at ``confidence``.
    is_met : bool
        Whether that limit reaches the target.
    attempts : int
        Confirming runs; each failure sends the search to a safer choice, and the levels of all add up to the stated one.
    present_yield : float
        Predicted for the study's own tolerances.
    trade_off : DataFrame
        The cheapest choice for each yield: ``required_yield``, ``cost``, ``predicted_yield``, widths by dimension.
    neighbours : DataFrame
        Each choice one grade finer and coarser, the others kept: ``cost``, ``cost_change``, ``predicted_yield``, ``out_ppm``.
    surrogate : DataFrame
        Degree and held-out error of each output.
    motions : int
        True motions spent on training and confirming.
    """

    plan: Plan
    winner: Allocation
    tolerances: Tolerances
    dimensions: pd.DataFrame
    predicted_yield: float
    confirmed: Estimate
    is_met: bool
    attempts: int
    present_yield: float
    trade_off: pd.DataFrame
    neighbours: pd.DataFrame
    surrogate: pd.DataFrame
    motions: int


def zone(dimension: Dimension, width: float, anchor: str = "nominal") -> tuple[float, float]:
    """Limits of a zone of another width; one point of it stays.

    ``"nominal"`` keeps the nominal size at the same share of the zone, or the limit next to it where the nominal lies
    outside (h, H: the zero line; d: the fundamental deviation); ``"lower"``, ``"upper"``, ``"middle"`` keep these.
    """
    present = dimension.upper - dimension.lower
    if present == 0.0 and anchor == "nominal":
        anchor = "middle"
    share = {"lower": 0.0, "upper": 1.0, "middle": 0.5}.get(anchor)
    if share is None:
        share = min(max((dimension.nominal - dimension.lower) / present, 0.0), 1.0)
    fixed = dimension.lower + share * present
    return fixed - share * width, fixed + (1.0 - share) * width


def with_widths(tolerances: Tolerances, choices: Sequence[Grades | Curve], widths: Sequence[float]) -> Tolerances:
    """The tolerances with the chosen widths; distributions keep their shape within the new limits."""
    chosen = {choice.name: (width, choice.anchor) for choice, width in zip(choices, widths, strict=True)}
    dimensions = []
    for dimension in tolerances.dimensions:
        if dimension.name in chosen:
            dimension = _in_zone(dimension, *zone(dimension, *chosen[dimension.name]))
        dimensions.append(dimension)
    return replace(tolerances, dimensions=tuple(dimensions))


def _in_zone(dimension: Dimension, lower: float, upper: float) -> Dimension:
    """The dimension with other limits, its distribution and the share of its variance between lots kept."""
    # The share between lots, not its amount, which might not fit into a narrow zone.
    lots = {"lot_sd": None, "lot_share": dimension.between_lots} if dimension.lot_sd is not None else {}
    distribution = dimension.distribution.in_zone(dimension, lower, upper)
    return replace(dimension, lower=lower, upper=upper, distribution=distribution, toleranced_size=None, **lots)


def widest_widths(choices: Sequence[Grades | Curve]) -> list[float]:
    """The widest zone that each choice offers; all others lie within it."""
    return [_range(choice)[1] for choice in choices]


def allocate(
    tolerances: Tolerances,
    specification: Mapping[str, Mapping[str, float | None]],
    plan: Plan,
    model: Model,
    *,
    training: int = TRAINING,
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

    Raises
    ------
    InputError
        When the plan, the specification or the sizes of the runs cannot serve, and when no choice reaches the yield.
    """
    _check(tolerances, specification, plan)
    planned = _planned_yield(plan)
    widest = with_widths(tolerances, plan.choices, widest_widths(plan.choices))
    surrogate = fit(model, training_box(widest), tuple(specification), motions=training, seed=plan.seed)
    search = _Search(tolerances, specification, plan, surrogate, _point_count(planned))
    refused: set[Allocation] = set()
    for attempt in range(1, MAX_ATTEMPTS + 1):
        winner = _candidate(search, planned, refused)
        if winner is None:
            raise InputError(_nothing_found(search, plan, planned))
        chosen = with_widths(tolerances, plan.choices, winner.widths)
        confirmed = _confirm(model, chosen, specification, plan, attempt)
        if confirmed.low >= plan.target_yield:
            break
        refused.add(winner)
        planned = 1.0 - 0.5 * (1.0 - planned)
    return AllocationResult(
        plan=plan,
        winner=winner,
        tolerances=chosen,
        dimensions=_dimension_table(plan, winner, chosen),
        predicted_yield=search.fresh_yield(winner.widths),
        confirmed=confirmed,
        is_met=confirmed.low >= plan.target_yield,
        attempts=attempt,
        present_yield=search.present_yield,
        trade_off=_trade_off(search, plan),
        neighbours=_neighbours(search, plan, winner),
        surrogate=surrogate.describe(),
        motions=surrogate.motions + attempt * plan.samples,
    )


def _candidate(search: _Search, planned: float, refused: Set[Allocation]) -> Allocation | None:
    """The cheapest choice with the planned yield, judged by points that it was not chosen on."""
    required = planned
    for _ in range(4):
        candidate = search.cheapest(required, refused=refused)
        shortfall = 0.0 if candidate is None else planned - search.fresh_yield(candidate.widths)
        if shortfall <= 0.0:
            break
        required += shortfall
    return candidate


def _check(tolerances: Tolerances, specification, plan: Plan) -> None:
    if not specification:
        raise InputError("allocation: [specification] is empty; give at least one output a limit.")
    if "contact_loss_time" in specification:
        raise InputError(
            "allocation: contact_loss_time is missing where contact is never lost, so it cannot be approximated; "
            "require contact_force_D_min and contact_force_E_min >= 0 instead."
        )
    if not plan.choices:
        raise InputError("allocation: no dimension has a choice; give at least one grades or a cost function.")
    combinations = math.prod(len(choice.widths) for choice in plan.choices if isinstance(choice, Grades))
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


def _range(choice: Grades | Curve) -> tuple[float, float]:
    return (choice.widths[0], choice.widths[-1]) if isinstance(choice, Grades) else (choice.narrowest, choice.widest)


def _planned_yield(plan: Plan) -> float:
    """The least true yield whose confirming run passes in 39 of 40 cases."""
    low, high = plan.target_yield, 1.0
    confidence = _confidence(plan, 1)
    if _lower_limit(plan.samples, plan.samples, confidence) < plan.target_yield:
        needed = math.ceil(math.log(1.0 - confidence) / math.log(plan.target_yield))
        raise InputError(
            f"allocation: samples = {plan.samples} cannot show a yield of {plan.target_yield} at the confidence "
            f"{plan.confidence}, even if all are good; give at least {needed}, ten times that to leave a choice."
        )
    for _ in range(60):
        middle = 0.5 * (low + high)
        spread = math.sqrt(plan.samples * middle * (1.0 - middle))
        passes = _lower_limit(plan.samples * middle - 1.96 * spread, plan.samples, confidence) >= plan.target_yield
        low, high = (low, middle) if passes else (middle, high)
    return high


def _confidence(plan: Plan, attempt: int) -> float:
    """Confidence of a confirming run; the errors of all runs, halved from one to the next, add up to the stated one."""
    return 1.0 - (1.0 - plan.confidence) / 2.0**attempt


def _lower_limit(good: float, count: int, confidence: float) -> float:
    """One-sided Clopper-Pearson limit."""
    return binomial_interval(min(max(good, 0.0), count), count, confidence=2.0 * confidence - 1.0)[0]


def _point_count(planned: float) -> int:
    """Points that hold some hundred failures at the planned yield."""
    wanted = 200.0 / max(1.0 - planned, 1e-12)
    return int(min(max(2 ** math.ceil(math.log2(wanted)), _MIN_POINTS), _MAX_POINTS))


class _Search:
    """Yields by the surrogate on common points, and the cheapest choice for a yield."""

    def __init__(self, tolerances, specification, plan: Plan, surrogate: Surrogate, points: int) -> None:
        self.tolerances = tolerances
        self.specification = specification
        self.plan = plan
        self.surrogate = surrogate
        widest = with_widths(tolerances, plan.choices, widest_widths(plan.choices))
        self.points = unit_points(widest, points, sampling="sobol", seed=plan.seed)
        self._yields: dict[tuple[float, ...], float] = {}

    def margins(self, widths: Sequence[float], rows: slice | np.ndarray = slice(None)) -> np.ndarray:
        """Worst requirement's margin at every point, in spreads of its output; positive: out of specification."""
        tolerances = with_widths(self.tolerances, self.plan.choices, widths)
        return self._margins(from_unit(tolerances, self.points[rows]))

    def _margins(self, inputs: pd.DataFrame) -> np.ndarray:
        outputs = self.surrogate(inputs)
        worst = np.full(len(inputs), -np.inf)
        for name, limits in self.specification.items():
            values, spread = outputs[name].to_numpy(), self.surrogate.spread[name] or 1.0
            for sign, limit in ((1.0, limits.get("max")), (-1.0, limits.get("min"))):
                if limit is not None:
                    np.maximum(worst, sign * (values - limit) / spread, out=worst)
        return worst

    def yield_of(self, widths: Sequence[float]) -> float:
        widths = tuple(widths)
        if widths not in self._yields:
            self._yields[widths] = float(np.mean(self.margins(widths) <= 0.0))
        return self._yields[widths]

    def fresh_yield(self, widths: Sequence[float]) -> float:
        """Yield at points on which nothing was chosen: free of the optimum's selection for its own points."""
        return self._yield_at(with_widths(self.tolerances, self.plan.choices, widths))

    @property
    def present_yield(self) -> float:
        """Yield of the tolerances as they are."""
        return self._yield_at(self.tolerances)

    def _yield_at(self, tolerances: Tolerances) -> float:
        points = unit_points(tolerances, _MAX_POINTS, sampling="sobol", seed=self.plan.seed + 1)
        return float(np.mean(self._margins(from_unit(tolerances, points)) <= 0.0))

    def cheapest(
        self, required: float, *, refused: Set[Allocation] = frozenset(), known: Allocation | None = None
    ) -> Allocation | None:
        """The cheapest choice whose predicted yield reaches the required one; None when there is none.

        ``known`` is a choice that reaches it, from which the search starts.
        """
        best = known
        for bound, grades in self._combinations:
            if best is not None and bound >= best.cost:
                break
            found = self._solve(grades, required, math.inf if best is None else best.cost)
            if found is not None and found not in refused and (best is None or found.cost < best.cost):
                best = found
        return best

    @cached_property
    def _combinations(self) -> list[tuple[float, tuple[int, ...]]]:
        """Combinations of grades in the order of the least cost that they allow."""
        grades = [choice for choice in self.plan.choices if isinstance(choice, Grades)]
        free = sum(choice.cost(choice.widest) for choice in self.plan.choices if isinstance(choice, Curve))
        combinations = product(*(range(len(choice.widths)) for choice in grades))
        bounds = (
            (free + sum(choice.costs[i] for choice, i in zip(grades, combination, strict=True)), combination)
            for combination in combinations
        )
        return sorted(bounds)

    def _solve(self, grades: tuple[int, ...], required: float, ceiling: float) -> Allocation | None:
        """The cheapest choice with these grades, or None where none reaches the yield at less than the ceiling."""
        chosen = iter(grades)
        fixed = [next(chosen) if isinstance(choice, Grades) else None for choice in self.plan.choices]
        narrow, wide = (
            np.array(
                [_range(c)[end] if i is None else c.widths[i] for c, i in zip(self.plan.choices, fixed, strict=True)]
            )
            for end in (0, 1)
        )
        # Zones that all cost what the ceiling leaves when the others are at their widest are narrower than any that
        # pay: when even they miss the yield, the combination is out.
        spare = ceiling - self.allocation(wide, fixed).cost
        affordable = narrow.copy()
        for j, choice in enumerate(self.plan.choices):
            if fixed[j] is None:
                affordable[j] = choice.narrowest_below(choice.cost(choice.widest) + spare)
        if self._is_hopeless(affordable, required) or self.yield_of(affordable) < required:
            return None
        if self.yield_of(wide) < required:
            wide = self._free_widths(affordable, wide, required)
        return self.allocation(wide, fixed)

    def allocation(self, widths: Sequence[float], grades: Sequence[int | None]) -> Allocation:
        """The choice of these widths; ``grades`` index those that are graded."""
        labels, cost = [], 0.0
        for choice, width, grade in zip(self.plan.choices, widths, grades, strict=True):
            labels.append("" if grade is None else choice.labels[grade])
            cost += choice.cost(width) if grade is None else choice.costs[grade]
        return Allocation(tuple(float(width) for width in widths), tuple(labels), float(cost))

    def _is_hopeless(self, widths: np.ndarray, required: float) -> bool:
        """Whether one scrambling of the points alone shows that the yield is missed: most choices end here."""
        few = np.mean(self.margins(widths, slice(None, None, SCRAMBLINGS)) <= 0.0)
        count = len(self.points) // SCRAMBLINGS
        return few + 5.0 * math.sqrt(max(few * (1.0 - few), 1.0 / count) / count) < required

    def _free_widths(self, narrow: np.ndarray, wide: np.ndarray, required: float) -> np.ndarray:
        """Cheapest widths between a choice that reaches the yield and one that misses it."""
        on_boundary = self._boundary(narrow, wide, required)
        free = np.flatnonzero(wide > narrow)
        if len(free) == 1:
            return on_boundary
        curves = [self.plan.choices[j] for j in free]

        def widths(x):
            result = narrow.copy()
            result[free] = np.exp(x)
            return result

        def cost(w):
            return sum(curve.cost(width) for curve, width in zip(curves, w[free], strict=True))

        low, high = np.log(narrow[free]), np.log(wide[free])
        scale = cost(narrow) - cost(wide)
        found = minimize(
            lambda x: cost(widths(x)) / scale,
            np.log(on_boundary[free]),
            method="SLSQP",
            bounds=Bounds(low, high),
            constraints={
                "type": "ineq",
                "fun": lambda x: -self._quantile(widths(x), required)[0],
                "jac": lambda x: -self._slopes(widths(x), free, required),
            },
            options={"ftol": 1e-7, "maxiter": 50},
        )
        optimum = widths(np.clip(found.x, low, high))
        ends = (optimum, wide) if self.yield_of(optimum) >= required else (narrow, optimum)
        return min(self._boundary(*ends, required), on_boundary, key=cost)

    def _boundary(self, inside: np.ndarray, outside: np.ndarray, required: float) -> np.ndarray:
        """Farthest widths from ``inside`` (reaches the yield) towards ``outside`` (misses it) that reach it."""
        a, b = 0.0, 1.0
        for _ in range(12):
            middle = 0.5 * (a + b)
            reached = self.yield_of(inside ** (1.0 - middle) * outside**middle) >= required
            a, b = (middle, b) if reached else (a, middle)
        return inside ** (1.0 - a) * outside**a

    def _quantile(self, widths: np.ndarray, required: float) -> tuple[float, np.ndarray, np.ndarray]:
        """Quantile of the margins, averaged over half of the ranks beyond it, the points there, and their weights."""
        margins = self.margins(widths)
        count = len(margins)
        rank = required * (count - 1)
        reach = max(0.5 * (count - 1 - rank), 1.0)
        first, last = max(math.ceil(rank - reach), 0), min(math.floor(rank + reach), count - 1)
        weights = 1.0 - np.abs(np.arange(first, last + 1) - rank) / reach
        weights /= weights.sum()
        near = np.argsort(margins)[first : last + 1]
        return float(weights @ margins[near]), near, weights

    def _slopes(self, widths: np.ndarray, free: np.ndarray, required: float) -> np.ndarray:
        """Derivatives of the quantile by the logarithms of the free widths: the mean ones of the points at it."""
        value, near, weights = self._quantile(widths, required)
        slopes = []
        for j in free:
            wider = widths.copy()
            wider[j] *= 1.0 + _DIFFERENCE
            slopes.append((weights @ self.margins(wider, near) - value) / math.log1p(_DIFFERENCE))
        return np.array(slopes)


def _confirm(model: Model, tolerances: Tolerances, specification, plan: Plan, attempt: int) -> Estimate:
    """Yield of independent motions, failed ones counted as bad; ``low`` is a one-sided limit."""
    samples = model(sample(tolerances, plan.samples, sampling="random", seed=plan.seed + attempt))
    out, known = out_of_specification(samples, specification)
    good = np.logical_and.reduce([known[name] & ~out[name] for name in specification])
    return Rows("random", 2.0 * _confidence(plan, attempt) - 1.0, tolerances.lot_size or 1).share(good)


def _nothing_found(search: _Search, plan: Plan, planned: float) -> str:
    best = search.yield_of([_range(choice)[0] for choice in plan.choices])
    return (
        f"allocation: no choice of tolerances has a predicted yield of {planned:.6g}, which it takes to show "
        f"{plan.target_yield:.6g} at the confidence {plan.confidence:.6g} with {plan.samples} samples; the narrowest one has "
        f"{best:.6g}. Offer narrower zones, widen [specification], ask for a lower yield, or confirm with more samples."
    )


def _dimension_table(plan: Plan, winner: Allocation, tolerances: Tolerances) -> pd.DataFrame:
    by_name = {dimension.name: dimension for dimension in tolerances.dimensions}
    rows = [
        {
            "dimension": choice.name,
            "grade": label,
            "width": width,
            "lower": by_name[choice.name].lower,
            "upper": by_name[choice.name].upper,
            "cost": choice.costs[choice.labels.index(label)] if label else choice.cost(width),
        }
        for choice, label, width in zip(plan.choices, winner.labels, winner.widths, strict=True)
    ]
    return pd.DataFrame(rows).set_index("dimension")


def _describe(search: _Search, plan: Plan, allocation: Allocation) -> dict[str, object]:
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


def _trade_off(search: _Search, plan: Plan) -> pd.DataFrame:
    rows, allocation = [], None
    for required in sorted({*LADDER, plan.target_yield}, reverse=True):
        # What reaches the higher yield reaches this one too, and leaves less to search.
        allocation = search.cheapest(required, known=allocation)
        if allocation is not None:
            rows.append({"required_yield": required, **_describe(search, plan, allocation)})
    return pd.DataFrame(rows[::-1])


def _neighbours(search: _Search, plan: Plan, winner: Allocation) -> pd.DataFrame:
    rows = []
    for j, choice in enumerate(plan.choices):
        for direction, neighbour in _steps(search, choice, winner, j):
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
    return pd.DataFrame(rows)


def _steps(search: _Search, choice: Grades | Curve, winner: Allocation, j: int) -> Iterator[tuple[str, Allocation]]:
    """The winner with choice j one grade finer and one coarser, where that is on offer."""
    grades = [
        other.labels.index(label) if label else None
        for other, label in zip(search.plan.choices, winner.labels, strict=True)
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
