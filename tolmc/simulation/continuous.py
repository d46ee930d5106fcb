"""Statistics over continuous time of quantities that are known at samples within every step of a motion.

In each step a polynomial runs through the step's two ends and the Gauss-Legendre points between them; integrals are
Gauss's, extrema and roots the polynomial's. Used where a motion is recorded step by step (the published formulations);
ensembles in slope coordinates have their own, packed, in kernels/watchers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre
from scipy.interpolate import BarycentricInterpolator
from scipy.optimize import brentq, minimize_scalar

_NODES, _WEIGHTS = legendre.leggauss(8)
#: Positions in (0, 1) at which a step must be sampled.
POSITIONS = 0.5 * (1 + _NODES)
_WEIGHTS = 0.5 * _WEIGHTS
_ALL = np.concatenate(([0.0], POSITIONS, [1.0]))
_FINE = np.linspace(0.0, 1.0, 65)
_ENOUGH = len(_ALL) - 2  # samples of a step through which its polynomial is as good as the motion's own order


@dataclass(frozen=True)
class Sampled:
    """A quantity at the records (n + 1,) and at POSITIONS in every step (n, 8), steps of equal length (s)."""

    records: np.ndarray
    inner: np.ndarray
    step: float

    @property
    def _values(self) -> np.ndarray:
        return np.column_stack((self.records[:-1], self.inner, self.records[1:]))

    def bridged(self) -> Sampled:
        """The same with a step's missing (NaN) samples taken from the polynomial through its others, if these are enough."""
        inner = self.inner.copy()
        for i in np.flatnonzero(np.isnan(inner).any(axis=1)):
            present = np.isfinite(self._values[i])
            if np.count_nonzero(present) >= _ENOUGH:
                through = BarycentricInterpolator(_ALL[present], self._values[i][present])
                inner[i, ~present[1:-1]] = through(_ALL[~present])
        return Sampled(self.records, inner, self.step)

    def first_gap(self) -> int:
        """First step with a missing sample; the number of steps when there is none."""
        gaps = np.isnan(self.inner).any(axis=1)
        return int(np.argmax(gaps)) if gaps.any() else len(gaps)

    def maximum(self, until: float = np.inf) -> float:
        """Largest value over [0, until], by the polynomials of the steps whose samples come near it."""
        values = self._values
        fine = BarycentricInterpolator(_ALL, values.T)(_FINE)
        starts = self.step * np.arange(len(values))
        fine[starts[None, :] + _FINE[:, None] * self.step > until * (1 + 1e-15)] = -np.inf
        tops = fine.max(axis=0)
        best = tops.max()
        for i in np.flatnonzero(tops >= best - 1e-2 * max(np.ptp(self.records), abs(best) * 1e-6)):
            at = _FINE[fine[:, i].argmax()]
            polynomial = BarycentricInterpolator(_ALL, values[i])
            low, high = max(at - _FINE[1], 0.0), min(at + _FINE[1], 1.0, (until - starts[i]) / self.step)
            if high > low:
                found = minimize_scalar(
                    lambda x, f=polynomial: -float(f(x)), bounds=(low, high), method="bounded", options={"xatol": 1e-9}
                )
                best = max(best, -found.fun)
        return float(best)

    def integral(self, until: float = np.inf) -> float:
        """Integral over [0, until] (at most the whole motion)."""
        whole = min(len(self.inner), int(until / self.step)) if np.isfinite(until) else len(self.inner)
        total = self.step * float((self.inner[:whole] @ _WEIGHTS).sum())
        rest = until / self.step - whole
        if whole < len(self.inner) and rest > 0:
            polynomial = BarycentricInterpolator(_ALL, self._values[whole])
            total += self.step * rest * float(_WEIGHTS @ polynomial(rest * POSITIONS))
        return total

    def squared(self) -> Sampled:
        return Sampled(self.records**2, self.inner**2, self.step)

    def negative(self) -> Sampled:
        return Sampled(-self.records, -self.inner, self.step)

    def first_root(self) -> float:
        """First time (s) at which the quantity turns negative; NaN if it never does, 0 if it starts so."""
        if self.records[0] < 0:
            return 0.0
        values = self._values
        fine = BarycentricInterpolator(_ALL, values.T)(_FINE)
        negative = np.flatnonzero((fine < 0).any(axis=0))
        if not len(negative):
            return np.nan
        i = negative[0]
        below = int(np.argmax(fine[:, i] < 0))
        polynomial = BarycentricInterpolator(_ALL, values[i])
        root = brentq(lambda x: float(polynomial(x)), _FINE[below - 1], _FINE[below]) if below else 0.0
        return self.step * (i + root)
