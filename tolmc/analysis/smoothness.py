"""Whether outputs are smooth in the dimensions: how far a polynomial misses samples that are there already."""

from __future__ import annotations

from collections.abc import Iterable
from math import comb

import numpy as np
import pandas as pd

from tolmc.analysis.index_table import varied_names
from tolmc.analysis.surrogate import MAX_DEGREE, MOTIONS_PER_TERM, ROUGH, basis, least_squares, multi_indices
from tolmc.statistics.outcomes import failed

#: Rows that are looked at: enough to tell a jump, and a few milliseconds.
ROWS = 512
# Spread of an output over its mean that is nothing but rounding.
_ROUNDING = 1e-9


def held_out_shares(samples: pd.DataFrame, *, inputs: Iterable[str], outputs: Iterable[str]) -> pd.Series:
    """Held-out error of a polynomial in the dimensions over each output's own spread: 0 where it is smooth, 1 where it is not.

    The root mean square of the leave-one-out errors over the first :data:`ROWS` samples, of the total degree for which it is
    least.

    Parameters
    ----------
    samples : DataFrame, rows in order; failed samples are left out
    inputs : names of dimensions; those that don't vary are left out
    outputs : names of outputs

    Returns
    -------
    Series, index output
        NaN for an output that doesn't vary, or is known in too few samples.
    """
    known = samples.iloc[:ROWS]
    known = known[~failed(known)]
    outputs = list(outputs)
    points, values = known[varied_names(known, inputs)].to_numpy(float), known[outputs].to_numpy(float)
    finite = np.isfinite(values)
    shares = np.full(len(outputs), np.nan)
    for rows in np.unique(finite, axis=1).T:  # outputs known in the same samples share a factorisation
        alike = (finite == rows[:, None]).all(axis=0)
        shares[alike] = _shares(points[rows], values[np.ix_(rows, alike)])
    return pd.Series(shares, index=pd.Index(outputs, name="output"), name="held_out_share")


def _shares(points: np.ndarray, values: np.ndarray) -> np.ndarray:
    """The same of the outputs ``values`` (n, m) at the points (n, k)."""
    count, k = points.shape
    if not k or count < MOTIONS_PER_TERM * (k + 1):
        return np.full(values.shape[1], np.nan)
    low, high = points.min(axis=0), points.max(axis=0)
    sizes = [comb(k + p, p) for p in range(MAX_DEGREE + 1) if MOTIONS_PER_TERM * comb(k + p, p) <= count]
    design = basis(((2.0 * points - (low + high)) / (high - low)).T, multi_indices(k, len(sizes) - 1)).T
    errors, spread = np.array(least_squares(design, values, sizes)[2]), values.std(axis=0)
    return np.where(
        spread > _ROUNDING * np.abs(values.mean(axis=0)), errors / np.maximum(spread, np.finfo(float).tiny), np.nan
    )


def rough(shares: pd.Series) -> pd.Series:
    """Those of :func:`held_out_shares` for which no polynomial stands."""
    return shares[shares > ROUGH]
