"""Which tolerance matters: for the variation of an output, and for what goes wrong.

Shares of variance are Sobol' indices. With V the variance of the output Y and X_i a dimension, the
first-order index S_i = Var(E[Y | X_i])/V is the share that vanishes on average when X_i is made exactly,
and the total index T_i = 1 - Var(E[Y | all but X_i])/V what would remain if all others were. Both need
independent dimensions to add up.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy import special, stats
from scipy.stats import qmc

from tolmc.analysis.surrogate import Model
from tolmc.statistics.rows import Estimate, Rows, signed_rank_interval
from tolmc.statistics.summary import (
    ANY_REQUIREMENT,
    CONTACT_LOSS,
    Specification,
    as_columns,
    contact_lost,
    failed,
    out_of_specification,
)
from tolmc.tolerances.dimension import Tolerances, from_unit
from tolmc.tolerances.unit_cube import SCRAMBLINGS

FAILED = "failed"
INTERACTIONS = "interactions"
# Evidence below which a dimension is said to have no influence on failures.
SIGNIFICANCE = 0.01


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
        ``first``, ``total`` with ``_low`` and ``_high``; ``used``, rows in which no evaluation failed. NaN
        for an output that doesn't vary.

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
    table = {}
    if k == 0:
        return _indexed(table, ("output", "dimension"), ("first", "total"), "used")
    rng = np.random.default_rng(seed)
    net = qmc.Sobol(2 * k, rng=rng).random_base2((count - 1).bit_length())
    a, b = np.split(net, 2, axis=1)
    mixed = np.repeat(a[None], k, axis=0)
    for i in range(k):
        mixed[i, :, i] = b[:, i]
    found = model(from_unit(tolerances, np.vstack([a, b, *mixed])))[outputs].to_numpy(float)
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
            }
    return _indexed(table, ("output", "dimension"), ("first", "total"), "used")


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
    terms = np.stack(terms, axis=1)
    equal = np.full(count, 1 / count)

    def indices(weights):
        sum_ab, sum_of_squares, *numerators = weights @ terms
        return np.array(numerators) / (0.5 * sum_of_squares - (0.5 * sum_ab) ** 2)

    resampled = [indices(rng.multinomial(count, equal) / count) for _ in range(resamples)]
    tail = 0.5 * (1 - confidence)
    return np.vstack([indices(equal), np.quantile(resampled, [tail, 1 - tail], axis=0)])


def _indexed(table: dict, names: Sequence[str], estimates: Sequence[str], *others: str) -> pd.DataFrame:
    columns = [f"{name}{end}" for name in estimates for end in ("", "_low", "_high")]
    index = pd.MultiIndex.from_tuples(list(table), names=names)
    return pd.DataFrame(list(table.values()), index=index, columns=[*columns, *others])


def _varied(samples: pd.DataFrame, inputs: Iterable[str]) -> list[str]:
    return [name for name in inputs if samples[name].min() < samples[name].max()]


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
        for name in _varied(samples, inputs)
    }
    table = {}
    for output in outputs:
        values, used = _used(samples, unusable, output)
        for name, cell in cells.items():
            index = _class_index(values[used], cell[used], classes, rows.confidence)
            table[output, name] = {**as_columns("first", index), "used": np.count_nonzero(used)}
    return _indexed(table, ("output", "dimension"), ("first",), "used")


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
    names = _varied(samples, inputs)
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
    return _indexed(table, ("output", "dimension"), ("correlation",), "used")


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
    return _Ranked((stats.rankdata(x) - 0.5) / max(len(x), 1) - 0.5, np.argsort(x, kind="stable"))


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


def one_at_a_time(model: Model, tolerances: Tolerances, *, outputs: Iterable[str], points: int = 21) -> pd.DataFrame:
    """Outputs over each varied dimension from its lower to its upper limit, the others at nominal.

    Returns
    -------
    DataFrame
        ``dimension``, ``value`` (SI unit), then the outputs; ``points`` rows a dimension.
    """
    if points < 2:
        raise ValueError(f"one_at_a_time: points = {points!r} is out of range; allowed: from 2.")
    nominal = {d.name: np.full(points, d.nominal) for d in tolerances.dimensions}
    outputs = list(outputs)
    curves = [pd.DataFrame({**nominal, d.name: np.linspace(d.lower, d.upper, points)}) for d in tolerances.varied]
    if not curves:
        return pd.DataFrame(columns=["dimension", "value", *outputs])
    found = model(pd.concat(curves, ignore_index=True))[outputs].reset_index(drop=True)
    found.insert(0, "dimension", np.repeat([d.name for d in tolerances.varied], points))
    values = [curve[d.name] for curve, d in zip(curves, tolerances.varied, strict=True)]
    found.insert(1, "value", np.concatenate(values))
    return found


def failure_sources(
    samples: pd.DataFrame,
    *,
    inputs: Iterable[str],
    specification: Specification | None = None,
    lot_size: int = 1,
    on_contact_loss: str = "stop",
) -> pd.DataFrame:
    """Which dimensions the failures come from: broken requirements, contact loss, failed samples.

    Compares each dimension's distribution in the samples with the event and in those without (regional
    sensitivity, Hornberger & Spear 1981) by the Kolmogorov-Smirnov distance: 0 when the dimension has
    nothing to do with the event, 1 when a value of it separates the two.

    Returns
    -------
    DataFrame, index ``event``, ``dimension``, the events' dimensions by descending distance
        ``events``, their number; ``distance``; ``p_value``, probability of such a distance without
        influence (rows of a lot count once; too high for Sobol' and Latin hypercube rows); ``where``, in
        which part of the dimension the events lie: "high", "low", "middle", "both ends" or "anywhere";
        ``share``, how many of them lie there (upper or lower quarter, middle half, outer quarters);
        ``finding``, in words. "Anywhere" stands where the p-value exceeds 0.01 divided by the number of
        dimensions.
    """
    names = _varied(samples, inputs)
    events = _events(samples, specification or {}, on_contact_loss)
    orders = {name: np.argsort(samples[name].to_numpy(float), kind="stable") for name in names}
    table = {}
    for event, (happened, known) in events.items():
        found = {name: _shift(happened[o], known[o], lot_size, SIGNIFICANCE / len(names)) for name, o in orders.items()}
        for name in sorted(found, key=lambda name: -found[name]["distance"]):
            table[event, name] = found[name] | {"finding": _in_words(event, name, found[name])}
    columns = ("events", "distance", "p_value", "where", "share", "finding")
    return _indexed(table, ("event", "dimension"), (), *columns)


def _events(
    samples: pd.DataFrame, specification: Specification, on_contact_loss: str
) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Rows in which each event happened, and rows in which it is known whether it did."""
    out, known = out_of_specification(samples, specification, on_contact_loss=on_contact_loss)
    events = {name: (out[name], known[name]) for name in specification}
    if len(specification) > 1:
        any_out = np.any(list(out.values()), axis=0)
        events[ANY_REQUIREMENT] = any_out, any_out | np.all(list(known.values()), axis=0)
    unusable = failed(samples)
    return events | {CONTACT_LOSS: (contact_lost(samples), ~unusable), FAILED: (unusable, np.ones(len(samples), bool))}


def _shift(happened: np.ndarray, known: np.ndarray, lot_size: int, significance: float) -> dict:
    """Distance between the rows with and without an event, which come in ascending order of a dimension."""
    happened = happened[known]
    n, m = len(happened), np.count_nonzero(happened)
    if m in (0, n):
        return {"events": m, "distance": 0.0, "p_value": 1.0, "where": "anywhere", "share": math.nan}
    lag = np.cumsum(~happened) / (n - m) - np.cumsum(happened) / m  # positive where the events come later
    above, below = max(lag.max(), 0.0), max(-lag.min(), 0.0)
    distance = float(max(above, below))
    p_value = float(special.kolmogorov(distance * math.sqrt(m * (n - m) / n / lot_size)))
    where, share = _part(happened, lag, above, below) if p_value <= significance else ("anywhere", math.nan)
    return {"events": m, "distance": distance, "p_value": p_value, "where": where, "share": share}


def _part(happened: np.ndarray, lag: np.ndarray, above: float, below: float) -> tuple[str, float]:
    lowest, *middle, highest = (np.count_nonzero(part) for part in np.array_split(happened, 4))
    total = np.count_nonzero(happened)
    if min(above, below) > 0.5 * max(above, below):
        if lag.argmax() < lag.argmin():
            return "middle", sum(middle) / total
        return "both ends", (lowest + highest) / total
    return ("high", highest / total) if above > below else ("low", lowest / total)


_PARTS = {
    "high": "the upper quarter of {name} holds {share:.0f} % of it (25 % without influence)",
    "low": "the lower quarter of {name} holds {share:.0f} % of it (25 % without influence)",
    "middle": "the middle half of {name} holds {share:.0f} % of it (50 % without influence)",
    "both ends": "the two outer quarters of {name} hold {share:.0f} % of it (50 % without influence)",
    "anywhere": "{name} shows no influence",
}


def _in_words(event: str, name: str, found: dict) -> str:
    if found["events"] == 0:
        return f"{event}: no such sample"
    return f"{event}: {_PARTS[found['where']].format(name=name, share=100 * found['share'])}"
