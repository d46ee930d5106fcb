"""The cheapest choice of tolerance zones for a yield, by a surrogate on common points."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise, product

import numpy as np
from scipy.optimize import Bounds, minimize

from tolmc.allocation.offers import Curve, Grades, Widths, with_widths
from tolmc.analysis.surrogate import Surrogate
from tolmc.tolerances.dimension import Tolerances
from tolmc.tolerances.draw import from_unit, unit_points
from tolmc.tolerances.unit_cube import SCRAMBLINGS

MAX_POINTS = 2**18
_DIFFERENCE = 1e-4  # relative, of a width
_WAY = 8  # stretches of the way from the widest zones to the narrowest


@dataclass(frozen=True)
class Allocation:
    """A width for every choice, in their order, its label (a grade, or empty for a free width), and the cost of all."""

    widths: tuple[float, ...]
    labels: tuple[str, ...]
    cost: float


class Search:
    """Yields by the surrogate on common points, and the cheapest choice for a yield.

    Parameters
    ----------
    tolerances : Tolerances
    specification : mapping of output to {"min": ..., "max": ...}, SI units
    choices : of Grades and Curve
    surrogate : Surrogate
    points : int
        Quasi-random points that serve every choice.
    seed : int
    """

    def __init__(
        self,
        tolerances: Tolerances,
        specification: Mapping[str, Mapping[str, float | None]],
        choices: Sequence[Grades | Curve],
        surrogate: Surrogate,
        *,
        points: int,
        seed: int,
    ) -> None:
        self.tolerances = tolerances
        self.specification = specification
        self.choices = choices
        self.surrogate = surrogate
        self.seed = seed
        widest = self._with_widths([choice.widest for choice in choices])
        self.points = unit_points(widest, points, sampling="sobol", seed=seed)
        self.few = self.points[::SCRAMBLINGS]
        self._yields: dict[tuple[float, ...], float] = {}

    def _with_widths(self, widths: Widths) -> Tolerances:
        return with_widths(self.tolerances, self.choices, widths)

    def margins(self, widths: Widths, points: np.ndarray) -> np.ndarray:
        """Worst requirement's margin at every point, in spreads of its output; positive: out of specification."""
        outputs = self.surrogate(from_unit(self._with_widths(widths), points))
        worst = np.full(len(points), -np.inf)
        for name, limits in self.specification.items():
            values, spread = outputs[name].to_numpy(), self.surrogate.spread[name] or 1.0
            for sign, limit in ((1.0, limits.get("max")), (-1.0, limits.get("min"))):
                if limit is not None:
                    np.maximum(worst, sign * (values - limit) / spread, out=worst)
        return worst

    def yield_of(self, widths: Widths) -> float:
        """Predicted yield at the common points."""
        key = tuple(float(width) for width in widths)
        if key not in self._yields:
            self._yields[key] = float(np.mean(self.margins(widths, self.points) <= 0.0))
        return self._yields[key]

    def fresh_yield(self, widths: Widths) -> float:
        """Yield at points on which nothing was chosen: free of the optimum's selection for its own points."""
        points = unit_points(self._with_widths(widths), MAX_POINTS, sampling="sobol", seed=self.seed + 1)
        return float(np.mean(self.margins(widths, points) <= 0.0))

    def cheapest(
        self, required: float, *, refused: Collection[Allocation] = (), known: Allocation | None = None
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
        grades = [choice for choice in self.choices if isinstance(choice, Grades)]
        free = sum(choice.cost(choice.widest) for choice in self.choices if isinstance(choice, Curve))
        combinations = product(*(choice.offered for choice in grades))
        bounds = (
            (free + sum(choice.costs[i] for choice, i in zip(grades, combination, strict=True)), combination)
            for combination in combinations
        )
        return sorted(bounds)

    def _solve(self, grades: tuple[int, ...], required: float, ceiling: float) -> Allocation | None:
        """The cheapest choice with these grades, or None where none reaches the yield at less than the ceiling."""
        chosen = iter(grades)
        fixed = [next(chosen) if isinstance(choice, Grades) else 0 for choice in self.choices]
        wide = np.array(
            [c.widths[i] if isinstance(c, Grades) else c.widest for c, i in zip(self.choices, fixed, strict=True)]
        )
        spare = ceiling - self.allocation(wide, fixed).cost
        if spare <= 0.0:
            return None
        # No zone that the ceiling pays for is narrower than the one that costs what is left when the others are at their
        # widest.
        narrow = wide.copy()
        for j, choice in enumerate(self.choices):
            if isinstance(choice, Curve):
                narrow[j] = choice.narrowest_below(choice.cost(choice.widest) + spare)
        widths = self._cheapest_widths(narrow, wide, required)
        return None if widths is None else self.allocation(widths, fixed)

    def allocation(self, widths: Widths, grades: Sequence[int]) -> Allocation:
        """The choice of these widths; ``grades`` are the places of those that are graded, and any number for the others."""
        labels, cost = [], 0.0
        for choice, width, grade in zip(self.choices, widths, grades, strict=True):
            labels.append(choice.labels[grade] if isinstance(choice, Grades) else "")
            cost += choice.costs[grade] if isinstance(choice, Grades) else choice.cost(width)
        return Allocation(tuple(float(width) for width in widths), tuple(labels), float(cost))

    def _cheapest_widths(self, narrow: np.ndarray, wide: np.ndarray, required: float) -> np.ndarray | None:
        """The cheapest widths from narrow to wide that reach the yield; None where none is found.

        Wider is cheaper, but not always worse: a zone that keeps a limit moves its middle as it widens. So the whole way
        is looked at, from its cheap end, before the narrowest widths may say that there is nothing.
        """
        if self._reaches(wide, required):
            return wide
        way = [wide ** (1.0 - s) * narrow**s for s in np.linspace(0.0, 1.0, _WAY + 1)] if np.any(narrow < wide) else []
        for outside, inside in pairwise(way):
            if self._reaches(inside, required):
                return self._free_widths(inside, outside, (narrow, wide), required)
        if np.count_nonzero(narrow < wide) > 1:
            inside = self._safest(way[_WAY // 2], (narrow, wide), required)
            if self._reaches(inside, required):
                return self._free_widths(inside, wide, (narrow, wide), required)
        return None

    def _reaches(self, widths: np.ndarray, required: float) -> bool:
        """Whether the predicted yield reaches the required one; most choices miss it on a few of the points already."""
        share, count = float(np.mean(self.margins(widths, self.few) <= 0.0)), len(self.few)
        if share + 5.0 * math.sqrt(max(share * (1.0 - share), 1.0 / count) / count) < required:
            return False
        return self.yield_of(widths) >= required

    def _free_widths(self, inside: np.ndarray, outside: np.ndarray, ends, required: float) -> np.ndarray:
        """Cheapest widths between the ends, from one choice that reaches the yield and one that misses it."""
        narrow, wide = ends
        on_boundary = self._boundary(inside, outside, required)
        free = np.flatnonzero(wide > narrow)
        if len(free) == 1:
            return on_boundary
        curves = [self.choices[int(j)] for j in free]

        def cost(w: np.ndarray) -> float:
            return sum(
                curve.cost(width) for curve, width in zip(curves, w[free], strict=True) if isinstance(curve, Curve)
            )

        scale = cost(narrow) - cost(wide)
        constraint = {
            "type": "ineq",
            "fun": lambda w: -self._quantile(w, required, self.points)[0],
            "jac": lambda w: -self._slopes(w, free, required, self.points),
        }
        optimum = _minimum(lambda w: cost(w) / scale, on_boundary, ends, free, constraints=constraint)
        nearer, farther = (optimum, wide) if self.yield_of(optimum) >= required else (inside, optimum)
        return min(self._boundary(nearer, farther, required), on_boundary, key=cost)

    def _safest(self, start: np.ndarray, ends, required: float) -> np.ndarray:
        """Widths between the ends at which the quantile of the margins is least, on a few of the points."""
        free = np.flatnonzero(ends[1] > ends[0])
        return _minimum(
            lambda w: self._quantile(w, required, self.few)[0],
            start,
            ends,
            free,
            jac=lambda w: self._slopes(w, free, required, self.few),
        )

    def _boundary(self, inside: np.ndarray, outside: np.ndarray, required: float) -> np.ndarray:
        """Farthest widths from ``inside`` (reaches the yield) towards ``outside`` (misses it) that reach it."""
        a, b = 0.0, 1.0
        for _ in range(12):
            middle = 0.5 * (a + b)
            reached = self.yield_of(inside ** (1.0 - middle) * outside**middle) >= required
            a, b = (middle, b) if reached else (a, middle)
        return inside ** (1.0 - a) * outside**a

    def _quantile(self, widths: np.ndarray, required: float, points: np.ndarray):
        """Quantile of the margins, averaged over half of the ranks beyond it, the points there, and their weights."""
        margins = self.margins(widths, points)
        count = len(margins)
        rank = required * (count - 1)
        reach = max(0.5 * (count - 1 - rank), 1.0)
        first, last = max(math.ceil(rank - reach), 0), min(math.floor(rank + reach), count - 1)
        weights = 1.0 - np.abs(np.arange(first, last + 1) - rank) / reach
        weights /= weights.sum()
        near = np.argsort(margins)[first : last + 1]
        return float(weights @ margins[near]), points[near], weights

    def _slopes(self, widths: np.ndarray, free: np.ndarray, required: float, points: np.ndarray) -> np.ndarray:
        """Derivatives of the quantile by the logarithms of the free widths: the mean ones of the points at it."""
        value, near, weights = self._quantile(widths, required, points)
        slopes = []
        for j in free:
            wider = widths.copy()
            wider[j] *= 1.0 + _DIFFERENCE
            slopes.append((weights @ self.margins(wider, near) - value) / math.log1p(_DIFFERENCE))
        return np.array(slopes)


def _minimum(function, start: np.ndarray, ends, free: np.ndarray, *, jac=None, constraints=None) -> np.ndarray:
    """Widths between the ends with the least value of the function, the free ones by sequential quadratic programming.

    The logarithms of the widths are the variables; ``jac`` and the constraints' are derivatives by these.
    """
    low, high = (np.log(end[free]) for end in ends)

    def widths(x):
        result = start.copy()
        result[free] = np.exp(x)
        return result

    def of_logarithms(f):
        return None if f is None else lambda x: f(widths(x))

    constraint = {key: f if key == "type" else of_logarithms(f) for key, f in (constraints or {}).items()}
    found = minimize(
        of_logarithms(function),
        np.log(start[free]),
        jac=of_logarithms(jac),
        method="SLSQP",
        bounds=Bounds(low, high),
        constraints=constraint or (),
        options={"ftol": 1e-7, "maxiter": 50},
    )
    return widths(np.clip(found.x, low, high))
