"""Sobol' indices of independent dimensions by motions of their own.

With V the variance of the output Y and X_i a dimension, the first-order index S_i = Var(E[Y | X_i])/V is the share that
vanishes on average when X_i is made exactly, and the total index T_i = 1 - Var(E[Y | all but X_i])/V what would remain if
all others were.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pandas as pd
from scipy.stats import qmc

from tolmc.analysis.index_table import index_table
from tolmc.analysis.smoothness import held_out_shares
from tolmc.analysis.surrogate import Model
from tolmc.statistics.intervals import Estimate
from tolmc.statistics.rows import Rows
from tolmc.statistics.summary import as_columns
from tolmc.tolerances.dimension import Tolerances
from tolmc.tolerances.draw import from_unit


def sobol_indices(
    model: Model,
    tolerances: Tolerances,
    *,
    outputs: Iterable[str],
    count: int = 1024,
    seed: int = 0,
    confidence: float = 0.95,
    resamples: int = 1000,
) -> pd.DataFrame:
    """First-order and total Sobol' indices of every varied dimension, by count (k + 2) evaluations of the model.

    Two samples A, B of the k dimensions and, for each dimension i, A with column i from B give (Saltelli et
    al. 2010, Comput. Phys. Commun. 181; Jansen 1999)

        S_i = mean(f_B (f_ABi - f_A))/V,      T_i = mean((f_A - f_ABi)^2)/(2 V).

    Parameters
    ----------
    model : inputs -> outputs, DataFrames with a row a point; NaN where the motion failed
    tolerances : Tolerances
        Without correlation. Points are parts of different lots.
    count : int
        Rows of A, raised to a power of two (one scrambled Sobol' net in 2 k dimensions).
    resamples : int
        Of the bootstrap over rows, whose percentiles are the intervals. It takes the rows for independent,
        while the net makes the estimates several times more accurate: the intervals hold more than their
        level.

    Returns
    -------
    DataFrame, index ``output``, ``dimension``
        ``first``, ``total`` with ``_low`` and ``_high``; ``used``, rows in which no evaluation failed;
        ``held_out_share`` of the output (:func:`tolmc.analysis.smoothness.held_out_shares`): where it is not small the
        net is no better than random points. NaN for an output that doesn't vary.

    Raises
    ------
    ValueError
        With correlated dimensions: use :func:`first_order` on a sample.
    """
    rows = Rows("random", confidence)
    if tolerances.correlation is not None:
        raise ValueError(
            "sobol_indices: the dimensions are correlated, and their shares of the variance then overlap; "
            "use first_order or rank_correlation on a sample."
        )
    outputs = list(outputs)
    names = [d.name for d in tolerances.varied]
    k = len(names)
    table: dict[tuple[str, str], dict[str, float]] = {}
    if k == 0:
        return index_table(table, ("output", "dimension"), ("first", "total"), "used", "held_out_share")
    rng = np.random.default_rng(seed)
    net = qmc.Sobol(2 * k, rng=rng).random_base2((count - 1).bit_length())
    a, b = np.split(net, 2, axis=1)
    mixed = np.repeat(a[None], k, axis=0)
    for i in range(k):
        mixed[i, :, i] = b[:, i]
    points = from_unit(tolerances, np.vstack([a, b, *mixed]))
    answers = model(points)
    shares = held_out_shares(points.join(answers[outputs]), inputs=names, outputs=outputs)
    found = answers[outputs].to_numpy(float)
    found = found.reshape(k + 2, len(net), len(outputs))
    for column, output in enumerate(outputs):
        values = found[:, :, column]
        values = values[:, ~np.isnan(values).any(axis=0)]
        indices = _bootstrapped(values, rng, resamples, rows.confidence)
        for i, name in enumerate(names):
            table[output, name] = {
                **as_columns("first", Estimate(*indices[:, i])),
                **as_columns("total", Estimate(*indices[:, k + i])),
                "used": values.shape[1],
                "held_out_share": shares[output],
            }
    return index_table(table, ("output", "dimension"), ("first", "total"), "used", "held_out_share")


def _bootstrapped(values: np.ndarray, rng: np.random.Generator, resamples: int, confidence: float) -> np.ndarray:
    """(3, 2 k): estimate, lower and upper bound of the k first-order, then of the k total indices."""
    count = values.shape[1]
    k = len(values) - 2
    if count < 2 or np.ptp(values) == 0:
        return np.full((3, 2 * k), np.nan)
    # The estimators don't change with a shift of f; their variance is least about the mean.
    f_a, f_b, *f_mixed = values - values[:2].mean()
    terms = [f_a + f_b, f_a**2 + f_b**2]
    terms += [f_b * (f - f_a) for f in f_mixed] + [0.5 * (f_a - f) ** 2 for f in f_mixed]
    columns = np.stack(terms, axis=1)

    def indices(times):  # that each row counts
        sum_ab, sum_of_squares, *numerators = (times / count) @ columns
        return np.array(numerators) / (0.5 * sum_of_squares - (0.5 * sum_ab) ** 2)

    resampled = [indices(np.bincount(rng.integers(count, size=count), minlength=count)) for _ in range(resamples)]
    tail = 0.5 * (1 - confidence)
    return np.vstack([indices(np.ones(count)), np.quantile(resampled, [tail, 1 - tail], axis=0)])
