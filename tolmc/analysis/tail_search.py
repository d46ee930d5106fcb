"""Where to look for rare events: a density that crowds the tail of a function of standard normals.

The density that estimates P(g(Z) > t), Z standard normal, without any variance is Z's own, restricted to g > t. The
cross-entropy method fits a simple density to it in levels (Rubinstein & Kroese 2004): draw, raise the level to what the
best tenth exceeds, fit to that tenth, and so on up to t. What is fitted here is Student's t density, whose long tails
leave no part of the restricted density uncovered, mixed with Z's own, so that no weight exceeds 1/DEFENSIVE and a region
that the levels overlooked is still drawn from.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import cast

import numpy as np
from scipy.special import gammaln

DEFENSIVE = 0.1
FREEDOM = 5.0
ELITE = 0.1
#: Each level makes the tail about ten times as likely.
MAX_LEVELS = 15
#: Evaluations a level for each parameter of the mean and its scale; fewer fit the covariance too loosely.
LEVEL_SAMPLES = 125


class TailNotReached(ValueError):
    """No value of the function lies in the tail that was sought."""


@dataclass(frozen=True, eq=False)
class Proposal:
    """Mixture of the standard normal density and Student's t density in k dimensions.

    Attributes
    ----------
    mean : (k,)
    factor : (k, k)
        Lower Cholesky factor of the t density's scale matrix.
    """

    mean: np.ndarray
    factor: np.ndarray

    def draw(self, count: int, rng: np.random.Generator) -> np.ndarray:
        """Points (count, k)."""
        z = rng.standard_normal((count, len(self.mean)))
        stretch = np.sqrt(FREEDOM / rng.chisquare(FREEDOM, count))[:, None]
        return np.where(rng.random((count, 1)) < DEFENSIVE, z, self.mean + stretch * (z @ self.factor.T))

    def weights(self, z: np.ndarray) -> np.ndarray:
        """Standard normal density over the mixture's, (n,), at the points z (n, k)."""
        k = len(self.mean)
        whitened2 = np.sum(np.linalg.solve(self.factor, (z - self.mean).T) ** 2, axis=0)
        log_t = (
            gammaln(0.5 * (FREEDOM + k)) - gammaln(0.5 * FREEDOM) - 0.5 * k * np.log(0.5 * FREEDOM)
            - np.log(np.diag(self.factor)).sum() - 0.5 * (FREEDOM + k) * np.log1p(whitened2 / FREEDOM)
        )  # fmt: skip
        log_normal = -0.5 * np.sum(z * z, axis=1)
        return np.exp(-np.logaddexp(np.log(DEFENSIVE), np.log1p(-DEFENSIVE) + log_t - log_normal))


def _fit(z: np.ndarray, weights: np.ndarray) -> Proposal:
    """Weighted mean and covariance; few effective points lean on the covariance of Z, which most directions keep."""
    share = weights / weights.sum()
    mean = share @ z
    centred = z - mean
    effective, prior = 1.0 / np.sum(share**2), z.shape[1] + 1
    covariance = (effective * (share * centred.T) @ centred + prior * np.eye(z.shape[1])) / (effective + prior)
    return Proposal(mean, np.linalg.cholesky(covariance))


def upper_quantile(values: np.ndarray, masses: np.ndarray, probability: float) -> float:
    """The value at which the mass of all values that are not smaller reaches the probability.

    Masses may be negative (corrections): their sum is then not quite monotone, and the bisection finds a place where it passes
    the probability for good rather than a short excursion.
    """
    order = np.argsort(values)[::-1]
    above = np.cumsum(masses[order])
    return float(values[order[min(int(np.searchsorted(above, probability)), len(order) - 1)]])


def find_tail(
    function: Callable[[np.ndarray], np.ndarray],
    dimension: int,
    *,
    threshold: float | None = None,
    probability: float | None = None,
    samples: int,
    rng: np.random.Generator,
) -> tuple[Proposal, int]:
    """Proposal that crowds {z: function(z) >= threshold}, or the upper tail of the given probability.

    Parameters
    ----------
    function : callable
        Points (n, dimension) to values (n,); NaN counts as far from the tail.
    threshold, probability : float
        One of the two says where the tail begins.
    samples : int
        Evaluations a level.

    Returns
    -------
    proposal : Proposal
    evaluations : int

    Raises
    ------
    TailNotReached
        When the levels stop rising below the threshold.
    """
    if (threshold is None) == (probability is None):
        raise ValueError("find_tail: give either threshold or probability.")
    z, weights = rng.standard_normal((samples, dimension)), np.ones(samples)
    for level_number in range(1, MAX_LEVELS + 1):
        values = np.nan_to_num(function(z), nan=-np.inf)
        target = upper_quantile(values, weights / samples, cast(float, probability)) if threshold is None else threshold
        level = min(target, float(np.quantile(values, 1.0 - ELITE, method="higher")))
        # A tail in a narrow gap may never hold a tenth of a proposal; what it holds at the last level must do.
        elite = values >= (level if level_number < MAX_LEVELS else target)
        if not elite.any():
            break
        proposal = _fit(z[elite], weights[elite])
        if level >= target:
            break
        z = proposal.draw(samples, rng)
        weights = proposal.weights(z)
    if not np.any(values >= target):
        raise TailNotReached(
            f"find_tail: after {MAX_LEVELS} levels the largest value is {values.max():.6g}, below the threshold {target:.6g}, "
            f"which may be out of reach. Check the threshold, or give more than {samples} samples a level."
        )
    return proposal, level_number * samples
