"""Estimates with confidence intervals from the rows of a Monte Carlo run.

What an interval may assume depends on how the rows were drawn:

* ``"random"``: rows are independent; the usual independent-sample formulas hold.
* ``"latin_hypercube"``: the same formulas are used. Stratifying every input leaves an estimate's variance
  at most n/(n - 1) times that of a random sample (Owen 1997, Stat. Probab. Lett. 32, for means and, through
  their influence functions, for what is smooth in means), so the intervals hold at least their level and
  are too wide for nearly additive outputs.
* ``"sobol"``: rows are 16 independent scramblings of the Sobol' sequence, interleaved (row i belongs to
  scrambling i % 16). Rows of one scrambling depend on each other, so every interval comes from the scatter
  among the scramblings.
* Rows that share a lot (``lot_size`` > 1: row i belongs to lot i // lot_size) share its shift: intervals
  come from the scatter among the lots. With Sobol' rows a lot lies within one scrambling, and the
  scramblings stay independent.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy import optimize, special

from tolmc.statistics.order_statistics import OrderStatistics
from tolmc.tolerances.unit_cube import SAMPLINGS, SCRAMBLINGS

SHARE_METHODS = ("exact", "jeffreys")


class Estimate(NamedTuple):
    """A value and the interval that contains the truth with the stated confidence.

    A bound that the sample is too small to give is infinite; the value of an empty sample is NaN.
    """

    value: float
    low: float
    high: float


def _normal_quantile(confidence: float) -> float:
    return float(special.ndtri(0.5 + 0.5 * confidence))


def _t_quantile(confidence: float, degrees: int) -> float:
    return float(special.stdtrit(degrees, 0.5 + 0.5 * confidence))


@lru_cache
def _signed_rank_distribution(count: int) -> np.ndarray:
    """P(W <= w), w = 0 .. count (count + 1)/2, for Wilcoxon's signed-rank statistic."""
    ways = np.zeros(count * (count + 1) // 2 + 1)
    ways[0] = 1
    for rank in range(1, count + 1):
        ways[rank:] += ways[:-rank].copy()
    return np.cumsum(ways) / 2.0**count


def signed_rank_interval(values: np.ndarray, confidence: float) -> tuple[float, float]:
    """Interval for the centre of a symmetric distribution, by Wilcoxon's signed ranks.

    Bounds are order statistics of the averages of all pairs (Hodges & Lehmann 1963), interpolated between
    the two neighbouring exact levels. Unlike Student's t it keeps its level for any tail, and the errors of
    scrambled nets have long ones: a smooth output meets a poor scrambling rarely, and then the t interval
    is many times too wide.
    """
    levels = 1 - 2 * _signed_rank_distribution(len(values))
    k = int(np.searchsorted(-levels, -confidence, side="right")) - 1
    if k < 0:
        return -math.inf, math.inf
    i, j = np.triu_indices(len(values))
    averages = np.sort(0.5 * (values[i] + values[j]))
    fraction = (levels[k] - confidence) / (levels[k] - levels[k + 1])
    low = averages[k] + fraction * (averages[k + 1] - averages[k])
    high = averages[-1 - k] - fraction * (averages[-1 - k] - averages[-2 - k])
    return float(low), float(high)


def binomial_interval(
    events: float, count: float, *, confidence: float = 0.95, method: str = "exact"
) -> tuple[float, float]:
    """Interval for a probability from ``events`` in ``count`` independent trials.

    ``"exact"``: Clopper & Pearson (1934), at least the stated confidence for every probability; with few
    events it holds distinctly more. ``"jeffreys"``: equal-tailed with prior Beta(1/2, 1/2) (Brown, Cai &
    DasGupta 2001), the stated confidence on average over probabilities. Both numbers may be fractional
    (effective counts).
    """
    if method not in SHARE_METHODS:
        raise ValueError(f"method = {method!r} is unknown; allowed: {', '.join(SHARE_METHODS)}.")
    if not 0 <= events <= count:
        raise ValueError(f"events = {events!r} of count = {count!r} is out of range; allowed: 0 <= events <= count.")
    tail = 0.5 - 0.5 * confidence
    spare = count - events
    prior = (0.0, 1.0) if method == "exact" else (0.5, 0.5)
    low = special.betaincinv(events + prior[0], spare + prior[1], tail) if events > 0 else 0.0
    high = special.betaincinv(events + prior[1], spare + prior[0], 1 - tail) if spare > 0 else 1.0
    return float(low), float(high)


@dataclass(frozen=True)
class Rows:
    """How the rows of a run were drawn, and the confidence asked of its intervals.

    Parameters
    ----------
    sampling : "random", "latin_hypercube" or "sobol"
    confidence : float
        0 < confidence < 1.
    lot_size : int
        Consecutive rows that share a lot; 1: rows share nothing.
    """

    sampling: str = "random"
    confidence: float = 0.95
    lot_size: int = 1

    def __post_init__(self) -> None:
        if self.sampling not in SAMPLINGS:
            raise ValueError(f"sampling = {self.sampling!r} is unknown; allowed: {', '.join(SAMPLINGS)}.")
        if not 0 < self.confidence < 1:
            raise ValueError(
                f"confidence = {self.confidence!r} is out of range; allowed: between 0 and 1, such as 0.95."
            )
        if self.lot_size < 1:
            raise ValueError(f"lot_size = {self.lot_size!r} is out of range; allowed: whole numbers from 1.")

    @property
    def are_independent(self) -> bool:
        """Whether every row stands for itself (not Sobol', no lots)."""
        return self.sampling != "sobol" and self.lot_size == 1

    def group_sums(self, values: np.ndarray) -> np.ndarray:
        """Sum over each independent group of rows: a scrambling (fewer than 16 for fewer rows), a lot, or a row itself."""
        if self.are_independent:
            return values
        if self.sampling == "sobol":
            return _column_sums(values, min(SCRAMBLINGS, len(values)))
        whole = len(values) // self.lot_size * self.lot_size
        rest = values[whole:]
        return np.append(values[:whole].reshape(-1, self.lot_size).sum(axis=1), rest.sum() if len(rest) else [])

    def group_counts(self, known: np.ndarray | None, rows: int) -> np.ndarray:
        """Rows that count in each independent group; ``known`` are those rows (None: all)."""
        if known is not None:
            return self.group_sums(known)
        if self.sampling == "sobol":
            return -(-np.arange(rows, max(rows - SCRAMBLINGS, 0), -1) // SCRAMBLINGS)
        return np.diff(np.append(np.arange(0, rows, self.lot_size), rows))

    @staticmethod
    def _variance_of_sums(sums: np.ndarray, count: int, groups: int) -> tuple[float, int]:
        """Variance of an estimate from the sums of its influence values over independent groups; degrees of freedom."""
        if groups < 2:
            return math.inf, 1
        return groups / (groups - 1) * float(sums @ sums) / count**2, groups - 1

    def smooth(self, value: float, influence: np.ndarray, count: int) -> Estimate:
        """Interval for any estimate that is a smooth function of means, from its influence values.

        To first order such an estimate is T = truth + (1/n) sum_j psi_j; for a mean psi_j = x_j - mean.
        Independent rows give T +- t_{n-1} sqrt(sum psi_j^2/(n (n - 1))), lots the same with their sums in
        place of the rows. With Sobol' rows each scrambling g gives T + (1/n_g) sum_{j in g} psi_j, and the
        interval is that of :func:`signed_rank_interval` on these, widened to hold T where it does not.

        Parameters
        ----------
        value : float
            The estimate T.
        influence : (rows,) array
            psi_j, in row order, zero for rows that are not used; their sum is zero.
        count : int
            Number n of rows that are used.
        """
        return self.smooth_of_groups(value, self.group_sums(influence), count)

    def smooth_of_groups(self, value: float, sums: np.ndarray, count: int) -> Estimate:
        """:meth:`smooth` from the sums of the influence values over independent groups (:meth:`group_sums`)."""
        if count < 2 or not math.isfinite(value):
            return Estimate(value, -math.inf, math.inf)
        if self.sampling == "sobol":
            low, high = signed_rank_interval(sums * (len(sums) / count), self.confidence)
            return Estimate(value, value + min(low, 0.0), value + max(high, 0.0))
        variance, degrees = self._variance_of_sums(sums, count, count if self.are_independent else len(sums))
        half_width = _t_quantile(self.confidence, degrees) * math.sqrt(variance)
        return Estimate(value, value - half_width, value + half_width)

    def effective_count(self, events: np.ndarray, known: np.ndarray | None = None) -> float:
        """Number of independent rows that would know the share of ``events`` as well as these rows do.

        n_eff = share (1 - share)/SE^2 with SE from the scramblings or lots, times (z/t)^2 because SE has
        few degrees of freedom (Korn & Graubard 1998, Survey Methodology 24). ``events`` and ``known`` are (rows,) bool:
        rows with the event, which are known ones, and rows that count (None: all).
        """
        count = len(events) if known is None else np.count_nonzero(known)
        if self.are_independent or count < 2:
            return float(count)
        share = np.count_nonzero(events) / count
        binomial = share * (1 - share)
        if binomial == 0:
            # No event at all: rows of a lot may all have it together.
            return float(count if self.sampling == "sobol" else math.ceil(count / self.lot_size))
        sums = self.group_sums(events) - share * self.group_counts(known, len(events))
        variance, degrees = self._variance_of_sums(sums, count, len(sums))
        # A scrambling counts whole rows: equal counts in all of them don't make the share exact.
        resolution = min(binomial / count, 1 / count**2)
        ratio = _normal_quantile(self.confidence) / _t_quantile(self.confidence, degrees)
        return ratio**2 * binomial / max(variance, resolution)

    def share(self, events: ArrayLike, *, known: ArrayLike | None = None, method: str = "exact") -> Estimate:
        """Share of rows with an event, by :func:`binomial_interval` of the (effective) counts.

        Parameters
        ----------
        events : (rows,) bool, in row order
        known : (rows,) bool, optional
            Rows that count; all when None.
        """
        events = np.asarray(events, bool)
        known = None if known is None else np.asarray(known, bool)
        count = len(events) if known is None else np.count_nonzero(known)
        if count == 0:
            return Estimate(math.nan, 0.0, 1.0)
        events = events if known is None else events & known
        value = np.count_nonzero(events) / count
        size = self.effective_count(events, known)
        return Estimate(value, *binomial_interval(value * size, size, confidence=self.confidence, method=method))


# NumPy adds up rows of 64 times 16 numbers ten times faster than rows of 16.
_LONG_ROW = 64


def _column_sums(values: np.ndarray, width: int) -> np.ndarray:
    """Sum of every ``width``-th value, from each of the first ``width`` on."""
    if width == 0:
        return values[:0]
    long = _LONG_ROW * width
    whole, even = len(values) // long * long, len(values) // width * width
    sums = values[:whole].reshape(-1, _LONG_ROW, width).sum(axis=0).sum(axis=0)
    sums += values[whole:even].reshape(-1, width).sum(axis=0)
    sums[: len(values) - even] += values[even:]
    return sums


@lru_cache(maxsize=4096)
def _fractional_rank(count: float, level: float, probability: float) -> float:
    """The r in (0, n + 1) with P(X_(r) <= quantile) = I_level(r, n + 1 - r) = probability (Hutson 1999)."""
    edge = 1e-9
    return optimize.brentq(
        lambda r: special.betainc(r, count + 1 - r, level) - probability,
        edge,
        count + 1 - edge,
        xtol=1e-9 * count,
    )


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
    rows: Rows = Rows()

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
        n, z = self.count, _normal_quantile(self.rows.confidence)
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
