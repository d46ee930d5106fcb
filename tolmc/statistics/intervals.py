"""A value and its confidence interval, and the intervals that need nothing but numbers."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy import special

SHARE_METHODS = ("exact", "jeffreys")


class Estimate(NamedTuple):
    """A value and the interval that contains the truth with the stated confidence.

    A bound that the sample is too small to give is infinite; the value of an empty sample is NaN.
    """

    value: float
    low: float
    high: float


def normal_quantile(confidence: float) -> float:
    return float(special.ndtri(0.5 + 0.5 * confidence))


def t_quantile(confidence: float, degrees: int) -> float:
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
