"""Expectations from weighted values, and from a surrogate corrected by true motions; moments, quantiles, shares."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import stdtrit

from tolmc.analysis.questions import CONFIDENCE, Question
from tolmc.analysis.tail_search import upper_quantile

#: A relative error of this size is the arithmetic's, not the surrogate's.
ROUNDING = 1e-13


@dataclass(frozen=True)
class Moment:
    """An estimated expectation, the variance of that estimate, and the degrees of freedom behind the variance."""

    value: float
    variance: float
    freedom: float

    @property
    def reach(self) -> float:
        """Half the width of the interval."""
        return float(stdtrit(self.freedom, 0.5 + 0.5 * CONFIDENCE)) * self.variance**0.5

    def __add__(self, other: Moment) -> Moment:
        """Sum of independent estimates, degrees of freedom by Welch and Satterthwaite."""
        variance = self.variance + other.variance
        spread = self.variance**2 / self.freedom + other.variance**2 / other.freedom
        return Moment(self.value + other.value, variance, variance**2 / spread if spread > 0.0 else self.freedom)


@dataclass(frozen=True, eq=False)
class Weighted:
    """Values with weights that average to one; ``scramblings`` interleaved independent parts, or independent rows (0)."""

    values: np.ndarray
    weights: np.ndarray
    scramblings: int = 0

    def expect(self, phi: Callable[[np.ndarray], np.ndarray]) -> Moment:
        terms = self.weights * phi(self.values)
        parts = terms.reshape(-1, self.scramblings).mean(axis=0) if self.scramblings else terms
        return Moment(float(parts.mean()), float(parts.var(ddof=1)) / len(parts), len(parts) - 1)

    def share_above(self, threshold: float) -> Moment:
        return self.expect(lambda y: (y > threshold) + 0.0)

    def atoms(self) -> tuple[np.ndarray, np.ndarray]:
        """Values and the probability that each stands for."""
        return self.values, self.weights / len(self.values)


@dataclass(frozen=True, eq=False)
class Corrected:
    """Surrogate values at every point, true ones at the points kept."""

    surrogate: Weighted
    keep: np.ndarray  # (N,) probability of a true motion at each point
    kept: np.ndarray  # (m,) the rows drawn with it
    truth: np.ndarray  # (m,) their true values
    error: float  # root mean square error of the surrogate, as held out in training

    def expect(self, phi) -> Moment:
        difference = phi(self.truth) - phi(self.surrogate.values[self.kept])
        scaled = self._scale * difference
        variance = float(np.sum((1.0 - self.keep[self.kept]) * scaled**2))
        return self.surrogate.expect(phi) + Moment(float(scaled.sum()), variance, max(len(self.kept) - 1, 1))

    @property
    def _scale(self) -> np.ndarray:
        """Probability that each true motion stands for."""
        return self.surrogate.atoms()[1][self.kept] / self.keep[self.kept]

    def share_above(self, threshold: float) -> Moment:
        """Its variance is never less than what the surrogate's error allows.

        Where no kept motion lies on the other side of the threshold than its surrogate value, the estimated variance
        is zero; but a point at the distance d may do so with the probability E[error^4]/d^4 (Markov's inequality).
        """
        moment, base = self.expect(lambda y: (y > threshold) + 0.0), self.surrogate.share_above(threshold)
        values, masses = self.surrogate.atoms()
        residual = np.append(self.truth - values[self.kept], self.error)
        error = float(np.mean(residual**4)) ** 0.25
        if error <= ROUNDING * np.abs(values).max():
            return moment
        crossing = (error / np.maximum(np.abs(values - threshold), error)) ** 4
        bound = float(np.sum(masses**2 * (1.0 - self.keep) / self.keep * crossing))
        return replace(moment, variance=max(moment.variance, base.variance + bound))

    def atoms(self) -> tuple[np.ndarray, np.ndarray]:
        values, masses = self.surrogate.atoms()
        return (
            np.concatenate([values, self.truth, values[self.kept]]),
            np.concatenate([masses, self._scale, -self._scale]),
        )


def answer_of(design: Weighted | Corrected, question: Question) -> tuple[float, float, float]:
    """Value and interval from a design that holds the values times the question's sign."""
    if question.kind == "quantile":
        return _quantile(design, question)
    if question.is_tail:
        return wilson_interval(design.share_above(question.threshold), len(design.atoms()[0]))
    centre = float(np.median(design.atoms()[0]))  # sums about zero would cancel
    mean = design.expect(lambda y: y - centre)
    if question.kind == "mean":
        return centre + mean.value, centre + mean.value - mean.reach, centre + mean.value + mean.reach
    return _sd(design, centre + mean.value)


def _sd(design, mean: float) -> tuple[float, float, float]:
    sd = max(design.expect(lambda y: (y - mean) ** 2).value, 0.0) ** 0.5
    if sd == 0.0:
        return 0.0, 0.0, 0.0
    # The derivative of sd with respect to the distribution carries its variance (delta method).
    reach = design.expect(lambda y: ((y - mean) ** 2 - sd**2) / (2.0 * sd)).reach
    return sd, max(sd - reach, 0.0), sd + reach


def _quantile(design, question: Question) -> tuple[float, float, float]:
    """Woodruff's (1952) interval: the values where the estimated tail differs from the probability by its own error."""
    values, masses = design.atoms()
    value = upper_quantile(values, masses, question.probability)
    reach = design.share_above(value).reach
    inner = upper_quantile(values, masses, question.probability + reach)
    outer = upper_quantile(values, masses, question.probability - reach) if reach < question.probability else np.inf
    low, high = sorted((question.sign * inner, question.sign * outer))
    return question.sign * value, low, high


def wilson_interval(moment: Moment, count: int) -> tuple[float, float, float]:
    """Wilson's interval at the number of independent samples that would have the moment's variance."""
    p, size = min(max(moment.value, 0.0), 1.0), float(count)
    if 0.0 < p < 1.0 and moment.variance > 0.0:
        size = p * (1.0 - p) / moment.variance
    z2 = float(stdtrit(moment.freedom, 0.5 + 0.5 * CONFIDENCE)) ** 2 / size
    centre, reach = p + 0.5 * z2, (z2 * (p * (1.0 - p) + 0.25 * z2)) ** 0.5
    return p, max((centre - reach) / (1.0 + z2), 0.0), min((centre + reach) / (1.0 + z2), 1.0)
