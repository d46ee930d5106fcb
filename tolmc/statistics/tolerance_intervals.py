"""Intervals that hold a share of all parts, and how many samples they need (Wilks 1941)."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from tolmc.statistics.observations import Observations
from tolmc.statistics.rows import Rows

SIDES = ("both", "lower", "upper")


def _confidence_of(count: int, share: float, discarded: int) -> float:
    """P(at least ``discarded`` of ``count`` parts lie in the outer share 1 - ``share``)."""
    if discarded > count:
        return 0.0
    return float(special.betainc(discarded, count - discarded + 1, 1 - share)) if discarded > 0 else 1.0


def _check_share(name: str, value: float) -> None:
    if not 0 < value < 1:
        raise ValueError(f"{name} = {value!r} is out of range; allowed: between 0 and 1, such as 0.95.")


def wilks_sample_size(share: float, confidence: float, *, sides: int = 2, rank: int = 1) -> int:
    """Smallest independent sample whose extremes enclose a share of the population with a confidence (Wilks 1941).

    The n with P(B(n, 1 - share) >= sides rank) >= confidence, B binomial.

    Parameters
    ----------
    share, confidence : float
        Between 0 and 1.
    sides : 1 (a bound on one side) or 2 (an interval)
    rank : int
        Order of the extremes that are used: 1 the outermost, 2 the next, ...
    """
    _check_share("share", share)
    _check_share("confidence", confidence)
    if sides not in (1, 2) or rank < 1:
        raise ValueError(f"sides = {sides!r}, rank = {rank!r}; allowed: sides 1 or 2, rank from 1.")
    discarded = sides * rank
    below, enough = discarded - 1, discarded
    while _confidence_of(enough, share, discarded) < confidence:
        below, enough = enough, 2 * enough
    while enough - below > 1:
        middle = (below + enough) // 2
        if _confidence_of(middle, share, discarded) < confidence:
            below = middle
        else:
            enough = middle
    return enough


class ToleranceInterval(NamedTuple):
    """Values between which at least the share asked for lies, with a confidence of at least the one asked for.

    A bound that the sample is too small to give is infinite.
    """

    low: float
    high: float


def tolerance_interval(
    values: ArrayLike,
    *,
    share: float = 0.95,
    sides: str = "both",
    sampling: str = "random",
    confidence: float = 0.95,
    lot_size: int = 1,
) -> ToleranceInterval:
    """Distribution-free tolerance interval from order statistics.

    Independent rows: as many extremes are discarded as :func:`wilks_sample_size` allows, equally many on
    either side. Other rows: bounds are those of the intervals of the outer quantiles (each side at half the
    risk).

    Parameters
    ----------
    values : (rows,) array_like, in row order; NaN where a row is not used
    sides : "both", "lower" or "upper"
    """
    _check_share("share", share)
    if sides not in SIDES:
        raise ValueError(f"sides = {sides!r} is unknown; allowed: {', '.join(SIDES)}.")
    rows = Rows(sampling, confidence, lot_size)
    if rows.are_independent:
        low, high = _wilks_bounds(Observations(np.asarray(values, float)).ordered, share, confidence, sides)
    else:
        split = 2 if sides == "both" else 1
        # Either end of an equal-tailed interval misses with half of the interval's risk.
        seen = Observations(np.asarray(values, float), replace(rows, confidence=1 - 2 * (1 - confidence) / split))
        tail = (1 - share) / split
        low, high = seen.quantile(tail).low, seen.quantile(1 - tail).high
    return ToleranceInterval(-math.inf if sides == "upper" else low, math.inf if sides == "lower" else high)


def _wilks_bounds(ordered: np.ndarray, share: float, confidence: float, sides: str) -> tuple[float, float]:
    count, per_side = len(ordered), 2 if sides == "both" else 1
    few, many = 0, count // per_side + 1  # extremes on a side: few may go, many may not
    while many - few > 1:
        middle = (few + many) // 2
        if _confidence_of(count, share, per_side * middle) >= confidence:
            few = middle
        else:
            many = middle
    if few == 0:
        return -math.inf, math.inf
    return float(ordered[few - 1]), float(ordered[count - few])
