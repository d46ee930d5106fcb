"""Sampling in looks of doubling size until an interval is narrow enough, at a confidence that holds for all looks together."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from tolmc.statistics.intervals import Estimate
from tolmc.statistics.tolerance_intervals import _check_share

Samples = TypeVar("Samples")


@dataclass(frozen=True)
class Looks:
    """The numbers of samples at which a sequential run looks whether its interval is narrow enough.

    Looking several times and stopping when the interval pleases spoils its level. Here the sizes are fixed
    beforehand and each look has an equal part of the risk 1 - confidence (Bonferroni), so that with the
    confidence asked for *all* the intervals hold, whichever one the run stops at, for every estimate and
    every sampling.

    Parameters
    ----------
    start, largest : int
        First size, and the size at which the run ends whatever the width is.
    growth : float
        Ratio of successive sizes, > 1. Few looks cost little: with 5 of them intervals are 1.31 times as
        wide.
    confidence : float
    """

    start: int
    largest: int
    growth: float = 2.0
    confidence: float = 0.95

    def __post_init__(self) -> None:
        _check_share("confidence", self.confidence)
        if not 2 <= self.start <= self.largest:
            raise ValueError(
                f"Looks: start = {self.start!r}, largest = {self.largest!r}; allowed: 2 <= start <= largest."
            )
        if not self.growth > 1:
            raise ValueError(f"Looks: growth = {self.growth!r} is out of range; allowed: > 1, such as 2.")

    @property
    def sizes(self) -> tuple[int, ...]:
        """Sizes in ascending order; the last is ``largest``."""
        sizes = [self.start]
        while sizes[-1] < self.largest:
            sizes.append(min(max(round(sizes[-1] * self.growth), sizes[-1] + 1), self.largest))
        return tuple(sizes)

    @property
    def look_confidence(self) -> float:
        """Confidence of the interval at each look."""
        return 1 - (1 - self.confidence) / len(self.sizes)


@dataclass(frozen=True)
class SequentialEstimate:
    """An estimate with its interval, the samples that it took, and whether the interval is as narrow as asked for."""

    estimate: Estimate
    count: int
    reached: bool


def sample_until(
    draw: Callable[[int], Samples],
    estimate: Callable[[Samples, float], Estimate],
    *,
    width: float,
    looks: Looks,
) -> SequentialEstimate:
    """Draw samples until an interval is at most ``width`` wide, with the interval's level kept.

    Parameters
    ----------
    draw : count -> samples
        The first ``count`` samples of the run.
    estimate : (samples, confidence) -> Estimate
        Such as ``lambda x, c: Observations(x, Rows("sobol", c)).mean()``.
    width : float
        Of the interval, high - low, in the estimate's unit.
    looks : Looks
    """
    if not width > 0:
        raise ValueError(f"width = {width!r} is out of range; allowed: > 0.")
    for count in looks.sizes:
        found = estimate(draw(count), looks.look_confidence)
        if found.high - found.low <= width:
            return SequentialEstimate(found, count, True)
    return SequentialEstimate(found, count, False)
