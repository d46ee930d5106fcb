"""Root sum square: the model replaced by its tangent at the nominal dimensions.

With f(x) = f0 + sum_i g_i (x_i - nominal_i),

    mean = f0 + sum_i g_i (mean_i - nominal_i),      sd^2 = sum_i sum_j g_i g_j rho_ij sd_i sd_j,

and mean +- 3 sd are called the limits of 99.73 % of the parts.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import pandas as pd

from tolmc.analysis.probe import Probe
from tolmc.analysis.surrogate import Model
from tolmc.tolerances.dimension import Tolerances


@dataclass(frozen=True, eq=False)
class Linearisation:
    """The tangent of the model at the nominal dimensions.

    Parameters
    ----------
    tolerances : Tolerances
    nominal : Series, index ``output``
    gradient : DataFrame, index ``output``, a column a varied dimension
        Output's unit over dimension's unit.
    """

    tolerances: Tolerances
    nominal: pd.Series
    gradient: pd.DataFrame

    def _covariance(self) -> np.ndarray:
        names = [d.name for d in self.tolerances.dimensions]
        varied = [names.index(name) for name in self.gradient]
        sd = np.array([self.tolerances.dimensions[k].sd for k in varied])
        correlation = np.eye(len(varied))
        if self.tolerances.correlation is not None:
            correlation = np.array(self.tolerances.correlation)[np.ix_(varied, varied)]
        return correlation * np.outer(sd, sd)

    def root_sum_square(self) -> pd.DataFrame:
        """``nominal``, ``mean``, ``sd`` and ``low``, ``high`` = mean -+ 3 sd; index ``output``, output's unit."""
        shift = np.array([d.mean - d.nominal for d in self.tolerances.varied])
        gradient = self.gradient.to_numpy()
        mean = self.nominal + gradient @ shift
        sd = np.sqrt(np.einsum("oi,ij,oj->o", gradient, self._covariance(), gradient))
        table = {"nominal": self.nominal, "mean": mean, "sd": sd, "low": mean - 3 * sd, "high": mean + 3 * sd}
        return pd.DataFrame(table, index=self.gradient.index)

    def contributions(self) -> pd.DataFrame:
        """Percent of the variance that each dimension contributes, 100 g_i sum_j g_j cov_ij / sd^2; index ``output``.

        Rows sum to 100 (NaN for an output that does not vary). With correlated dimensions the covariance of
        two is halved between them, and a contribution can be negative.
        """
        gradient = self.gradient.to_numpy()
        parts = gradient * (gradient @ self._covariance())
        total = parts.sum(axis=1, keepdims=True)
        percent = 100 * np.divide(parts, total, out=np.full_like(parts, np.nan), where=total > 0)
        return pd.DataFrame(percent, index=self.gradient.index, columns=self.gradient.columns)


def linearise(model: Model, tolerances: Tolerances, *, outputs: Iterable[str], step: float = 0.01) -> Linearisation:
    """Tangent at the nominal dimensions by central differences over ``step`` times the tolerance (upper - lower)."""
    if not 0 < step <= 0.5:
        raise ValueError(f"linearise: step = {step!r} is out of range; allowed: 0 < step <= 0.5 of the tolerance.")
    probe = Probe(model, tolerances, tuple(outputs))
    steps = np.diag(step * np.ptp(probe.limits, axis=1))
    values = probe(np.vstack([probe.nominal[None], probe.nominal + steps, probe.nominal - steps]))
    forward, backward = np.split(values[1:], 2)
    gradient = (forward - backward).T / (2 * np.diag(steps))
    index = pd.Index(probe.outputs, name="output")
    names = [d.name for d in tolerances.varied]
    return Linearisation(
        tolerances, pd.Series(values[0], index=index), pd.DataFrame(gradient, index=index, columns=names)
    )
