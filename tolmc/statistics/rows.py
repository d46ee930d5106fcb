"""How the rows of a Monte Carlo run were drawn, and what an interval may therefore assume.

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
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tolmc.statistics.intervals import Estimate, binomial_interval, normal_quantile, signed_rank_interval, t_quantile
from tolmc.tolerances.unit_cube import SAMPLINGS, SCRAMBLINGS


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
        half_width = t_quantile(self.confidence, degrees) * math.sqrt(variance)
        return Estimate(value, value - half_width, value + half_width)

    def effective_count(self, events: np.ndarray, known: np.ndarray | None = None) -> float:
        """Number of independent rows that would know the share of ``events`` as well as these rows do.

        n_eff = share (1 - share)/SE^2 with SE from the scramblings or lots, times (z/t)^2 because SE has
        few degrees of freedom (Korn & Graubard 1998, Survey Methodology 24). ``events`` and ``known`` are (rows,) bool:
        rows with the event, which are known ones, and rows that count (None: all).
        """
        count = len(events) if known is None else int(np.count_nonzero(known))
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
        ratio = normal_quantile(self.confidence) / t_quantile(self.confidence, degrees)
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
