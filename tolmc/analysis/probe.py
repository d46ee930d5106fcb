"""A model at points between the limits of the dimensions that vary."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from tolmc.analysis.surrogate import Model
from tolmc.tolerances.dimension import Tolerances


@dataclass(frozen=True, eq=False)
class Probe:
    """A model seen as a function of the varied dimensions alone.

    Parameters
    ----------
    model : inputs -> outputs
        Called with a row a point and a column a dimension (SI units, dimensions without tolerance at
        nominal); returns a row a point with the outputs as columns, NaN where the motion failed.
    tolerances : Tolerances
    outputs : names of output columns
    """

    model: Model
    tolerances: Tolerances
    outputs: tuple[str, ...]

    @property
    def limits(self) -> np.ndarray:
        """(varied, 2): lower and upper limit."""
        return np.array([(d.lower, d.upper) for d in self.tolerances.varied]).reshape(-1, 2)

    @property
    def nominal(self) -> np.ndarray:
        """(varied,)"""
        return np.array([d.nominal for d in self.tolerances.varied])

    def __call__(self, points: np.ndarray) -> np.ndarray:
        """(n, varied) -> (n, outputs)."""
        values = {d.name: column for d, column in zip(self.tolerances.varied, points.T, strict=True)}
        inputs = {d.name: values.get(d.name, np.full(len(points), d.nominal)) for d in self.tolerances.dimensions}
        return self.model(pd.DataFrame(inputs))[list(self.outputs)].to_numpy(float)
