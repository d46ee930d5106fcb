"""Which input drives which output: rank correlations of the samples, and samples over the strongest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tolmc import quantities

if TYPE_CHECKING:
    import pandas as pd

#: Samples whose ranks are correlated: they give a correlation to +-0.01, and ranks of a million cost a second.
RANKED = 20_000
# Samples that are kept of an output and its strongest driver, and the outputs of which they are, where they are there.
_POINTS, _KEPT = 2_000, ("contact_force_D_max", "contact_force_E_max")


@dataclass(frozen=True)
class Strongest:
    """Samples of an output over the input that drives it most, SI units, (samples,) each."""

    driver: str
    output: str
    x: np.ndarray
    y: np.ndarray


@dataclass(frozen=True)
class Drivers:
    """Rank correlations (outputs, inputs) of what varies, and the strongest of two outputs."""

    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    correlations: np.ndarray
    strongest: tuple[Strongest, ...]


def drivers_of(samples: pd.DataFrame, inputs: Sequence[str]) -> Drivers:
    """What drives the outputs among the columns of the samples."""
    outputs = [name for name in quantities.responses_among(samples) if _varies(samples[name])]
    inputs = [name for name in inputs if _varies(samples[name])]
    if not inputs or not outputs:
        return Drivers((), (), np.empty((0, 0)), ())
    correlations = rank_correlations(samples, inputs, outputs)
    kept = [name for name in _KEPT if name in outputs] or outputs[:2]
    return Drivers(
        inputs=tuple(inputs),
        outputs=tuple(outputs),
        correlations=correlations.to_numpy(),
        strongest=tuple(_strongest(samples, correlations.loc[name].abs().idxmax(), name) for name in kept),
    )


def rank_correlations(samples: pd.DataFrame, inputs: Sequence[str], outputs: Sequence[str]) -> pd.DataFrame:
    """Spearman's rank correlation of every output (rows) with every input (columns).

    Over the first :data:`RANKED` samples that have both; NaN where one of them does not vary.
    """
    return samples[[*inputs, *outputs]].iloc[:RANKED].corr(method="spearman").loc[outputs, inputs]


def _strongest(samples: pd.DataFrame, driver: str, output: str) -> Strongest:
    head = samples[[driver, output]].iloc[:_POINTS]
    return Strongest(driver, output, head[driver].to_numpy(), head[output].to_numpy())


def _varies(column: pd.Series) -> bool:
    values = column.to_numpy()[:RANKED]
    values = values[np.isfinite(values)]
    return values.size > 1 and np.ptp(values) > 1e-12 * np.abs(values).max()
