"""Which tolerance matters, from the samples of a run: first-order indices and rank correlations.

The first-order Sobol' index S_i = Var(E[Y | X_i])/V is the share of the output's variance V that vanishes on average when the
dimension X_i is made exactly; shares add up for independent dimensions.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
import pandas as pd
import scipy  # scipy.stats, half a second, is loaded when ranks are first asked for

from tolmc.analysis.index_table import index_table, varied_names
from tolmc.statistics.intervals import Estimate, signed_rank_interval
from tolmc.statistics.outcomes import (
    failed,
)
from tolmc.statistics.rows import Rows
from tolmc.statistics.summary import as_columns
from tolmc.tolerances.unit_cube import SCRAMBLINGS

INTERACTIONS = "interactions"


def _used(samples: pd.DataFrame, unusable: np.ndarray, output: str) -> tuple[np.ndarray, np.ndarray]:
    values = samples[output].to_numpy(float)
    return values, ~(unusable | np.isnan(values))


def first_order(
    samples: pd.DataFrame,
    *,
    inputs: Iterable[str],
    outputs: Iterable[str],
    sampling: str = "random",
    confidence: float = 0.95,
    lot_size: int = 1,
) -> pd.DataFrame:
    """First-order Sobol' indices from an existing sample, without any further evaluation.

    The rows are sorted into M classes of equal size by the dimension, M = sqrt(n) up to 256, and S is the
    variance of the class means over that of the rows. The scatter that the means have of themselves is
    taken off; it follows from 16 independent groups of rows (for Sobol' the scramblings), and so do the
    intervals, by the jackknife that leaves one group out. Classes have a width, so that about S/M^2 is
    missing (more where the output goes up and down).

    Parameters
    ----------
    samples : DataFrame of the run, rows in order; failed samples are left out
    inputs : names of dimensions; those that don't vary are left out
    outputs : names of outputs
    sampling, confidence, lot_size
        As for :func:`tolmc.statistics.summary.summarise`.

    Returns
    -------
    DataFrame, index ``output``, ``dimension``
        ``first`` with ``_low`` and ``_high`` (estimates of small indices can be negative); ``used``. NaN
        for an output that doesn't vary or has fewer than 32 rows. With correlated dimensions the indices
        overlap.
    """
    rows = Rows(sampling, confidence, lot_size)
    unusable = failed(samples)
    classes = max(2, min(math.isqrt(np.count_nonzero(~unusable)), 256))
    groups = np.arange(len(samples)) // (1 if sampling == "sobol" else lot_size) % SCRAMBLINGS
    cells = {
        name: groups * classes + _equal_classes(samples[name].to_numpy(float), ~unusable, classes)
        for name in varied_names(samples, inputs)
    }
    table = {}
    for output in outputs:
        values, used = _used(samples, unusable, output)
        for name, cell in cells.items():
            index = _class_index(values[used], cell[used], classes, rows.confidence)
            table[output, name] = {**as_columns("first", index), "used": np.count_nonzero(used)}
    return index_table(table, ("output", "dimension"), ("first",), "used")


def _equal_classes(x: np.ndarray, known: np.ndarray, classes: int) -> np.ndarray:
    """Class 0 .. classes - 1 of each row by its rank among the known ones."""
    members = np.zeros(len(x), int)
    where = np.flatnonzero(known)
    members[where[np.argsort(x[where], kind="stable")]] = np.arange(len(where)) * classes // max(len(where), 1)
    return members


def _class_index(values: np.ndarray, cell: np.ndarray, classes: int, confidence: float) -> Estimate:
    if len(values) < 2 * SCRAMBLINGS or np.ptp(values) == 0:
        return Estimate(math.nan, math.nan, math.nan)
    shape = (SCRAMBLINGS, classes)
    values = values - values.mean()
    counts, sums, squares = (
        np.bincount(cell, weights=weights, minlength=SCRAMBLINGS * classes).reshape(shape)
        for weights in (np.ones(len(values)), values, values**2)
    )
    index = _share_between(counts, sums, squares)
    without = [_share_between(*(np.delete(x, g, axis=0) for x in (counts, sums, squares))) for g in range(SCRAMBLINGS)]
    if np.isnan(without).any():
        return Estimate(index, -math.inf, math.inf)
    low, high = signed_rank_interval((SCRAMBLINGS - 1) * (index - np.array(without)), confidence)
    return Estimate(index, index + min(low, 0.0), index + max(high, 0.0))


def _share_between(counts: np.ndarray, sums: np.ndarray, squares: np.ndarray) -> float:
    """Variance between classes over the whole one, from the rows' count, sum and sum of squares in (group, class)."""
    n, groups = counts.sum(), len(counts)
    mean = sums.sum() / n
    total = squares.sum() - n * mean**2
    if total <= 1e-12 * squares.sum():  # all variation was in a group that is left out
        return math.nan
    size = np.maximum(counts.sum(axis=0), 1)
    means = sums.sum(axis=0) / size
    scatter = groups / (groups - 1) * ((sums - means * counts) ** 2).sum(axis=0) / size**2
    return float(size @ ((means - mean) ** 2 - scatter) / total)


def rank_correlation(
    samples: pd.DataFrame,
    *,
    inputs: Iterable[str],
    outputs: Iterable[str],
    sampling: str = "random",
    confidence: float = 0.95,
    lot_size: int = 1,
) -> pd.DataFrame:
    """Spearman's rank correlation of every output with every dimension, its sign telling the direction.

    Parameters as for :func:`first_order`. The interval is that of atanh(rho) from the influence values of
    rho, ranks included, so that it holds for dependent dimensions and outputs and for every sampling.

    Returns
    -------
    DataFrame, index ``output``, ``dimension``
        ``correlation`` with ``_low`` and ``_high``; ``used``. NaN for an output that doesn't vary.
    """
    rows = Rows(sampling, confidence, lot_size)
    unusable = failed(samples)
    names = varied_names(samples, inputs)
    ranks: dict[bytes, dict[str, _Ranked]] = {}
    table = {}
    for output in outputs:
        values, used = _used(samples, unusable, output)
        key = used.tobytes()  # outputs with the same used rows share the ranks of the dimensions
        if key not in ranks:
            ranks[key] = {name: _ranked(samples[name].to_numpy(float)[used]) for name in names}
        of_output = _ranked(values[used])
        for name in names:
            correlation = _spearman(ranks[key][name], of_output, used, rows)
            table[output, name] = {**as_columns("correlation", correlation), "used": np.count_nonzero(used)}
    return index_table(table, ("output", "dimension"), ("correlation",), "used")


class _Ranked(NamedTuple):
    """Ranks, ties averaged, as shares of the sample about 1/2; rows in ascending order."""

    ranks: np.ndarray
    order: np.ndarray

    def sum_above(self, other: np.ndarray) -> np.ndarray:
        """Sum of ``other`` over the rows that are not below a row."""
        sums = np.empty_like(other)
        sums[self.order] = other[self.order][::-1].cumsum()[::-1]
        return sums


def _ranked(x: np.ndarray) -> _Ranked:
    return _Ranked((scipy.stats.rankdata(x) - 0.5) / max(len(x), 1) - 0.5, np.argsort(x, kind="stable"))


def _spearman(of_x: _Ranked, of_y: _Ranked, used: np.ndarray, rows: Rows) -> Estimate:
    x, y = of_x.ranks, of_y.ranks
    scale = math.sqrt(float(x @ x) * float(y @ y))
    n = len(x)
    if n < 2 or scale == 0:
        return Estimate(math.nan, math.nan, math.nan)
    rho = float(x @ y) / scale
    if 1 - abs(rho) < 1e-12:
        return Estimate(rho, rho, rho)
    # A row moves the ranks of all rows above it, in x and in y.
    psi = x * y + (of_x.sum_above(y) + of_y.sum_above(x)) / n
    influence = np.zeros(len(used))
    influence[used] = (psi - psi.mean()) * (n / scale)
    _, low, high = rows.smooth(0.0, influence / (1 - rho**2), n)
    centre = math.atanh(rho)
    return Estimate(rho, math.tanh(centre + low), math.tanh(centre + high))


def contributions(indices: pd.DataFrame) -> pd.DataFrame:
    """Percent of each output's variance that the dimensions contribute, as engineers read it.

    Parameters
    ----------
    indices : from :func:`sobol_indices` or :func:`first_order`

    Returns
    -------
    DataFrame, index ``output``
        A column a dimension, 100 S_i, and ``interactions``, the rest to 100: what two or more dimensions do
        together. Sampling errors can make single entries slightly negative.
    """
    percent = 100 * indices["first"].unstack("dimension", sort=False)
    return percent.assign(**{INTERACTIONS: 100 - percent.sum(axis=1, skipna=False)})
