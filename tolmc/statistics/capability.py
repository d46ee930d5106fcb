"""Yield and capability of the outputs, tolerance intervals, and how many samples either needs.

With limits L and U, mean m and standard deviation s, Cp = (U - L)/(6 s) and Cpk = min(U - m, m - L)/(3 s)
take s within lots, Pp and Ppk take the s of all samples (ISO 22514-2); without lots the two pairs are
equal. The indices describe spread and position, nothing more: how many parts are out follows from them for
a normal output only, so the share that is really out stands beside the share that a normal output with
these indices would have.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeVar

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy import special

from tolmc.statistics.rows import Estimate, Observations, Rows
from tolmc.statistics.summary import (
    ALL_REQUIREMENTS,
    ANY_REQUIREMENT,
    CONTACT_LOSS,
    Specification,
    as_columns,
    summarise_requirements,
    without_value,
)
from tolmc.tolerances.unit_cube import lot_numbers

SIDES = ("both", "lower", "upper")

Samples = TypeVar("Samples")


def ppm_from_cpk(cpk: ArrayLike, *, sides: int = 2):
    """Parts per million out of limits for a normal output: 1e6 sides Phi(-3 Cpk); ``sides`` = 2: centred."""
    return 1e6 * sides * special.ndtr(-3 * np.asarray(cpk, float))[()]


def cpk_from_ppm(ppm: ArrayLike, *, sides: int = 2):
    """Inverse of :func:`ppm_from_cpk`."""
    return -special.ndtri(np.asarray(ppm, float) * 1e-6 / sides)[()] / 3


def capability(
    samples: pd.DataFrame,
    *,
    specification: Specification,
    sampling: str = "random",
    confidence: float = 0.95,
    lot_size: int = 1,
    on_contact_loss: str = "stop",
) -> pd.DataFrame:
    """A row a requirement and one for all of them: yield, parts per million and capability indices.

    Parameters
    ----------
    As for :func:`tolmc.statistics.summary.summarise`.

    Returns
    -------
    DataFrame, index ``requirement``
        With ``_low`` and ``_high`` each: ``yield`` and ``ppm``, the share in specification and the parts
        per million out of it, with samples that are not known (:func:`tolmc.statistics.summary.without_value`)
        counted as out and the interval reaching to where they are in; ``Cp``, ``Cpk``, ``Pp``, ``Ppk`` over
        the other samples (NaN where a limit is missing that the index needs, or nothing varies). Their
        intervals hold for outputs that are not normal. ``ppm_if_normal``: what Ppk and its other side promise
        for a normal output; far from ``ppm``, the indices mislead.
    """
    rows = Rows(sampling, confidence, lot_size)
    shares = summarise_requirements(
        samples, specification=specification, sampling=sampling, confidence=confidence, lot_size=lot_size,
        on_contact_loss=on_contact_loss,
    )  # fmt: skip
    shares = shares.drop(index=CONTACT_LOSS).rename(index={ANY_REQUIREMENT: ALL_REQUIREMENTS})
    table = {}
    for name, row in shares.iterrows():
        low, estimate, high = 1 - row["share_most_high"], 1 - row["share_most"], 1 - row["share_least_low"]
        table[name] = {
            **as_columns("yield", Estimate(estimate, low, high)),
            **as_columns("ppm", Estimate(*(1e6 * (1 - share) for share in (estimate, high, low)))),
        }
        if name in specification:
            missing = without_value(samples, name, specification=specification, on_contact_loss=on_contact_loss)
            values = np.where(missing, np.nan, samples[name].to_numpy(float))
            table[name] |= _indices(Observations(values, rows), row["minimum"], row["maximum"])
    return pd.DataFrame.from_dict(table, orient="index").rename_axis("requirement")


def _indices(seen: Observations, low: float, high: float) -> dict[str, float]:
    overall = seen.deviations
    within = overall if seen.rows.lot_size == 1 else _deviations_within_lots(seen)
    columns = {}
    for names, deviations in ((("Cp", "Cpk"), within), (("Pp", "Ppk"), overall)):
        sd, relative = _spread(seen, deviations, lots=deviations is not overall)
        columns |= as_columns(names[0], _two_sided_index(seen, low, high, sd, relative))
        columns |= as_columns(names[1], _nearest_index(seen, low, high, sd, relative))
    margins = [m for m in (high - seen.mean_value, seen.mean_value - low) if not math.isnan(m)]
    columns["ppm_if_normal"] = sum(float(ppm_from_cpk(m / (3 * sd), sides=1)) for m in margins) if sd else math.nan
    return columns


def _lots(seen: Observations) -> np.ndarray:
    return lot_numbers(seen.rows.lot_size, len(seen.values), sampling=seen.rows.sampling)


def _deviations_within_lots(seen: Observations) -> np.ndarray:
    """x_j - mean of its lot in row order, zero for rows that are not used."""
    lots, used = _lots(seen), ~np.isnan(seen.values)
    counts = np.bincount(lots, weights=used)
    means = np.bincount(lots, weights=seen.deviations) / np.maximum(counts, 1)
    return np.where(used, seen.deviations - means[lots], 0.0)


def _spread(seen: Observations, deviations: np.ndarray, *, lots: bool) -> tuple[float, np.ndarray]:
    """Standard deviation and the influence values of its square relative to that."""
    used = ~np.isnan(seen.values)
    lost = len(np.unique(_lots(seen)[used])) if lots else 1
    squares = np.square(deviations)
    total = float(squares.sum())
    if seen.count <= lost or total == 0:
        return 0.0, squares
    return math.sqrt(total / (seen.count - lost)), np.where(used, squares * (seen.count / total) - 1, 0.0)


def _two_sided_index(seen, low, high, sd, relative) -> Estimate:
    """(U - L)/(6 s), its interval on the logarithm."""
    if sd == 0 or math.isnan(high - low):
        return Estimate(math.nan, math.nan, math.nan)
    index = (high - low) / (6 * sd)
    _, below, above = seen.rows.smooth(0.0, -0.5 * relative, seen.count)
    return Estimate(index, index * math.exp(below), index * math.exp(above))


def _nearest_index(seen, low, high, sd, relative) -> Estimate:
    """min over the given limits of distance/(3 s); for normal rows the interval is Bissell's (1990)."""
    sides = [
        (sign * (limit - seen.mean_value) / (3 * sd), sign)
        for limit, sign in ((high, 1), (low, -1))
        if sd > 0 and not math.isnan(limit)
    ]
    if not sides:
        return Estimate(math.nan, math.nan, math.nan)
    estimates = [
        seen.rows.smooth(index, -sign * seen.deviations / (3 * sd) - 0.5 * index * relative, seen.count)
        for index, sign in sides
    ]
    return Estimate(*(min(bounds) for bounds in zip(*estimates, strict=True)))


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
        low, high = _wilks_bounds(Observations(values).ordered, share, confidence, sides)
    else:
        split = 2 if sides == "both" else 1
        # Either end of an equal-tailed interval misses with half of the interval's risk.
        seen = Observations(values, replace(rows, confidence=1 - 2 * (1 - confidence) / split))
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


class SequentialEstimate(NamedTuple):
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
