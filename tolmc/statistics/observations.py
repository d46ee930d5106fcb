"""Mean, standard deviation, quantiles and shares of one output, each with its interval."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np
from scipy import special

from tolmc.statistics.intervals import Estimate, normal_quantile
from tolmc.statistics.order_statistics import OrderStatistics
from tolmc.statistics.rows import Rows


@lru_cache(maxsize=4096)
def _fractional_rank(count: float, level: float, probability: float) -> float:
    """The r in (0, n + 1) with P(X_(r) <= quantile) = I_level(r, n + 1 - r) = probability (Hutson 1999)."""
    low, high = 0.0, count + 1.0
    while high - low > 1e-9 * count:
        middle = 0.5 * (low + high)
        # The larger the rank, the less probably its order statistic lies below the quantile.
        low, high = (
            (middle, high) if special.betainc(middle, count + 1 - middle, level) > probability else (low, middle)
        )
    return 0.5 * (low + high)


@dataclass(frozen=True, eq=False)
class Observations:
    """The values of one output, with the estimates that a summary needs.

    Parameters
    ----------
    values : (rows,) array
        In row order; NaN where the row is not used.
    rows : Rows
    """

    values: np.ndarray
    rows: Rows = field(default_factory=Rows)

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", np.asarray(self.values, float))

    @cached_property
    def ordered(self) -> np.ndarray:
        """Used values in ascending order."""
        return np.sort(self.used)

    @cached_property
    def _is_used(self) -> np.ndarray | None:
        """Rows with a value; None: all."""
        if not np.isnan(self.values.min(initial=math.inf)):  # a NaN anywhere is their minimum
            return None
        return ~np.isnan(self.values)

    @cached_property
    def used(self) -> np.ndarray:
        """Values of the used rows, in row order."""
        return self.values if self._is_used is None else self.values[self._is_used]

    @cached_property
    def order(self) -> OrderStatistics:
        """Order statistics of the used values."""
        return OrderStatistics(self.used)

    @cached_property
    def count(self) -> int:
        """Number of used rows."""
        return len(self.used)

    @cached_property
    def mean_value(self) -> float:
        return float(self.used.mean()) if self.count else math.nan

    @cached_property
    def deviations(self) -> np.ndarray:
        """x_j - mean in row order, zero for rows that are not used."""
        deviations = self.values - self.mean_value
        if self._is_used is not None:
            deviations[~self._is_used] = 0.0
        return deviations

    def mean(self) -> Estimate:
        """Mean, by :meth:`Rows.smooth`."""
        return self.rows.smooth(self.mean_value, self.deviations, self.count)

    def sd(self) -> Estimate:
        """Standard deviation s, with an interval that holds for outputs that are not normal.

        Independent rows: Bonett (2006, Comput. Stat. Data Anal. 50, 775), from the variance of log s^2 with
        the kurtosis taken about a trimmed mean. Others: log s^2 by :meth:`Rows.smooth`. The divisor is n -
        1, for Sobol' rows n: their mean is known far better than n independent rows would know it and costs
        no degree of freedom.
        """
        n = self.count
        if n < 2:
            return Estimate(math.nan, 0.0, math.inf)
        sums = self.rows.group_sums(np.square(self.deviations))
        total = float(sums.sum())
        s = math.sqrt(total / (n if self.rows.sampling == "sobol" else n - 1))
        if total == 0:
            return Estimate(s, s, s)
        if self.rows.are_independent:
            return Estimate(s, *self._bonett(s, total))
        # Sums of the influence values n d_j^2 / sum d^2 - 1 of log s^2.
        sums = n / total * sums - self.rows.group_counts(self._is_used, len(self.values))
        _, low, high = self.rows.smooth_of_groups(0.0, sums, n)
        return Estimate(s, s * math.exp(0.5 * low), s * math.exp(0.5 * high))

    def _bonett(self, s: float, total: float) -> tuple[float, float]:
        n, z = self.count, normal_quantile(self.rows.confidence)
        if n <= max(4.0, z):
            return 0.0, math.inf
        trimmed = int(n / (2 * math.sqrt(n - 4)))
        squares = np.square(self.used - self._trimmed_mean(trimmed))
        kurtosis = n * float(squares @ squares) / total**2
        correction = n / (n - z)
        error = correction * math.sqrt(max(kurtosis - (n - 3) / n, 0.0) / (n - 1))
        centre = s * math.sqrt(correction)
        return centre * math.exp(-0.5 * z * error), centre * math.exp(0.5 * z * error)

    def _trimmed_mean(self, trimmed: int) -> float:
        """Mean without the ``trimmed`` smallest and the ``trimmed`` largest values."""
        low, high = self.order[trimmed], self.order[self.count - 1 - trimmed]
        clipped = float(np.clip(self.used, low, high).sum())
        return (clipped - trimmed * (low + high)) / (self.count - 2 * trimmed)

    def minimum(self) -> Estimate:
        """Smallest value; nothing but the distribution's own limits says how far below it others may lie."""
        smallest = float(self.used.min()) if self.count else math.nan
        return Estimate(smallest, -math.inf, smallest if self.count else math.inf)

    def maximum(self) -> Estimate:
        """Largest value; as for :meth:`minimum`, its upper bound is infinite."""
        largest = float(self.used.max()) if self.count else math.nan
        return Estimate(largest, largest if self.count else -math.inf, math.inf)

    def quantile(self, level: float) -> Estimate:
        """Quantile, 0 < level < 1, with a distribution-free interval.

        The value interpolates as numpy.quantile does. The bounds are the order statistics X_(r), X_(s) with
        I_level(r, n + 1 - r) = (1 + confidence)/2, I_level(s, n + 1 - s) = (1 - confidence)/2, interpolated
        between neighbours (Hutson 1999; Beran & Hall 1993: the level's error is of order 1/n). A bound
        beyond the sample's ends is infinite. Unless rows are independent, n is the effective count of the
        share of values up to the quantile.
        """
        n = self.count
        if n == 0:
            return Estimate(math.nan, -math.inf, math.inf)
        value = self.order.at(1 + level * (n - 1))
        size = float(n)
        if not self.rows.are_independent:
            size = self.rows.effective_count(self.values <= value, self._is_used)
        low, high = (self._bound(size, level, 0.5 + side * 0.5 * self.rows.confidence) for side in (1, -1))
        return Estimate(value, min(low, value), max(high, value))

    def quantiles(self, levels: Sequence[float]) -> list[Estimate]:
        """:meth:`quantile` of several levels; their order statistics are found together."""
        n = self.count
        for level in levels if n else ():
            # Four standard errors of independent rows to either side: the intervals' bounds then need no further search.
            rank, reach = int(level * (n - 1)), math.ceil(4 * math.sqrt(n * level * (1 - level)))
            self.order.place(max(rank - reach, 0), min(rank + 1 + reach, n - 1))
        return [self.quantile(level) for level in levels]

    def _bound(self, size: float, level: float, probability: float) -> float:
        """The order statistic of ``size`` independent rows that is not above a quantile with a probability."""
        rank = _fractional_rank(size, level, probability)
        if rank < 1:
            return -math.inf
        if rank > size:
            return math.inf
        return self.order.at(rank * (self.count + 1) / (size + 1))
