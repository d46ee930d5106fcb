"""Worst case and root sum square, and how far they are from Monte Carlo.

Worst case takes the limits of the dimensions at their most adverse. Root sum square replaces the model by
its tangent at the nominal dimensions, f(x) = f0 + sum_i g_i (x_i - nominal_i), so that

    mean = f0 + sum_i g_i (mean_i - nominal_i),      sd^2 = sum_i sum_j g_i g_j rho_ij sd_i sd_j,

and calls mean +- 3 sd the limits of 99.73 % of the parts. Both are what drawing offices use; the table of
:func:`side_by_side` says where they mislead.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.stats import qmc

from tolmc.surrogate import Model
from tolmc.tolerances import Tolerances

MAX_CORNER_DIMENSIONS = 14
# Row of the comparison -> column of the Monte Carlo summary.
QUANTITIES = {"mean": "mean", "sd": "sd", "lower limit": "q0.135", "upper limit": "q99.865"}


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


def worst_case(model: Model, tolerances: Tolerances, *, outputs: Iterable[str], interior: bool = False) -> pd.DataFrame:
    """Smallest and largest value of every output within the limits.

    Evaluates all 2^k corners of the k varied dimensions. That is the worst case of an output that is
    monotone in every dimension; an output with an extreme inside the limits needs ``interior``, which adds
    64 k points of a Sobol' sequence and then improves the best point of each output and side by a compass
    search, down to 1/1000 of the tolerances.

    Returns
    -------
    DataFrame, index ``output``
        ``nominal``, ``min``, ``max`` in the output's unit; ``min_at``, ``max_at``, the dimensions there in
        words; ``failed``, evaluations without a value, beyond which the worst case is not known.

    Raises
    ------
    ValueError
        With more than 14 varied dimensions.
    """
    probe = Probe(model, tolerances, tuple(outputs))
    dimensions = len(tolerances.varied)
    if dimensions > MAX_CORNER_DIMENSIONS:
        raise ValueError(
            f"worst_case: {dimensions} dimensions have a tolerance, which makes 2^{dimensions} corners; allowed: up to "
            f"{MAX_CORNER_DIMENSIONS}. Fix those that matter least at their nominal."
        )
    points = np.array(list(itertools.product((0.0, 1.0), repeat=dimensions)))
    if interior and dimensions:
        spread = qmc.Sobol(dimensions, rng=np.random.default_rng(0)).random_base2((64 * dimensions - 1).bit_length())
        points = np.vstack([points, spread])
    values = _at(probe, points)
    failures = np.isnan(values).sum(axis=0)
    nominal = probe(probe.nominal[None])[0]
    table = {}
    sides = [(k, sign) for k in range(len(probe.outputs)) for sign in (-1, 1)]
    if interior and dimensions:
        best = _compass_search(probe, points, values, sides)
    else:
        best = [_best(points, values[:, k], sign) for k, sign in sides]
    for k, name in enumerate(probe.outputs):
        (low_at, low), (high_at, high) = best[2 * k], best[2 * k + 1]
        table[name] = {
            "nominal": nominal[k],
            "min": low,
            "max": high,
            "min_at": _in_words(tolerances, low_at),
            "max_at": _in_words(tolerances, high_at),
            "failed": failures[k],
        }
    return pd.DataFrame.from_dict(table, orient="index").rename_axis("output")


def _at(probe: Probe, places: np.ndarray) -> np.ndarray:
    """Outputs at places of the unit cube between the limits."""
    low, high = probe.limits.T
    # Exact at both ends, which a corner of the drawing has to be.
    return probe(np.where(places == 1, high, low + places * (high - low)))


def _best(points: np.ndarray, values: np.ndarray, sign: int) -> tuple[np.ndarray, float]:
    if np.isnan(values).all():
        return np.full(points.shape[1], np.nan), math.nan
    k = int(np.nanargmax(sign * values))
    return points[k], float(values[k])


def _compass_search(probe, points, values, sides) -> list[tuple[np.ndarray, float]]:
    """Improves the best point of each (output, sign) by steps along the axes, halved where none helps."""
    best = [_best(points, values[:, k], sign) for k, sign in sides]
    dimensions = points.shape[1]
    moves = np.vstack([np.eye(dimensions), -np.eye(dimensions)])
    steps = np.full(len(sides), 0.25)
    while (active := np.flatnonzero(steps > 1e-3)).size:
        trials = [np.clip(best[s][0] + steps[s] * moves, 0, 1) for s in active]
        found = _at(probe, np.vstack(trials)).reshape(len(active), len(moves), -1)
        for s, places, outcome in zip(active, trials, found, strict=True):
            k, sign = sides[s]
            place, value = _best(places, outcome[:, k], sign)
            if sign * value > sign * best[s][1]:
                best[s] = place, value
            else:
                steps[s] /= 2
    return best


def _in_words(tolerances: Tolerances, place: np.ndarray) -> str:
    if np.isnan(place).any():
        return "not known"
    ends = {0.0: "lower limit", 1.0: "upper limit"}
    parts = (
        f"{d.name} at its {ends[u]}" if u in ends else f"{d.name} at {100 * u:.1f} % of its tolerance"
        for d, u in zip(tolerances.varied, place.tolist(), strict=True)
    )
    return ", ".join(parts)


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


def side_by_side(
    worst: pd.DataFrame,
    linear: pd.DataFrame,
    monte_carlo: pd.DataFrame,
    *,
    accelerated: pd.DataFrame | None = None,
    material: float = 0.02,
) -> pd.DataFrame:
    """Worst case, root sum square, Monte Carlo and the accelerated estimate of every output, with a verdict.

    Parameters
    ----------
    worst : from :func:`worst_case`
    linear : from :meth:`Linearisation.root_sum_square`
    monte_carlo : from :func:`tolmc.statistics.summarise`
    accelerated : DataFrame, index ``output``, optional
        Columns as in ``monte_carlo``.
    material : float
        Error, as a share of the output's spread, up to which a linear answer is good enough.

    Returns
    -------
    DataFrame, index ``output``, ``quantity``
        A row for mean, sd and the limits of 99.73 % of the parts: ``worst_case``, ``root_sum_square``,
        ``monte_carlo``, ``accelerated`` (these two with ``_low``, ``_high``) in the output's unit;
        ``error_percent``, root sum square - Monte Carlo in percent of the spread (the distance of the Monte
        Carlo limits; for the sd in percent of it); ``uncertainty_percent``, half the Monte Carlo interval
        likewise; ``excess_percent``, how far the worst case lies beyond the Monte Carlo limit; ``verdict``
        in words.
    """
    rows = {}
    for name in monte_carlo.index:
        found = monte_carlo.loc[name]
        spread = found["q99.865"] - found["q0.135"]
        for quantity, column in QUANTITIES.items():
            scale = found["sd"] if quantity == "sd" else spread
            row = {
                "worst_case": {"lower limit": worst.at[name, "min"], "upper limit": worst.at[name, "max"]}.get(
                    quantity
                ),
                "root_sum_square": linear.at[name, _LINEAR[quantity]],
                **_estimate("monte_carlo", monte_carlo, name, column),
                **_estimate("accelerated", accelerated, name, column),
            }
            rows[name, quantity] = row | _judged(row, quantity, scale, material, found)
    index = pd.MultiIndex.from_tuples(rows, names=["output", "quantity"])
    return pd.DataFrame(list(rows.values()), index=index).astype({"worst_case": float})


_LINEAR = {"mean": "mean", "sd": "sd", "lower limit": "low", "upper limit": "high"}


def _estimate(kind: str, table: pd.DataFrame | None, name: str, column: str) -> dict[str, float]:
    known = table is not None and name in table.index and column in table
    return {f"{kind}{end}": table.at[name, f"{column}{end}"] if known else math.nan for end in ("", "_low", "_high")}


def _judged(row: dict, quantity: str, scale: float, material: float, found: pd.Series) -> dict:
    value, low, high = row["monte_carlo"], row["monte_carlo_low"], row["monte_carlo_high"]
    if not scale > 0:
        return {"verdict": "does not vary"}
    linear, percent = row["root_sum_square"], 100 / scale
    of = "of the sd" if quantity == "sd" else "of the spread"
    judged = {
        "error_percent": percent * (linear - value),
        "uncertainty_percent": percent * 0.5 * (high - low),
        "verdict": f"root sum square {_linear_verdict(linear, value, low, high, percent, of, material)}",
    }
    if row["worst_case"] is not None:
        outward = 1 if quantity == "upper limit" else -1
        extreme = found["max"] if outward > 0 else found["min"]
        beyond = outward * percent * (extreme - row["worst_case"])
        judged["excess_percent"] = outward * percent * (row["worst_case"] - value)
        judged["verdict"] += f"; worst case {_worst_verdict(judged['excess_percent'], beyond)}"
    return judged


def _linear_verdict(linear, value, low, high, percent, of, material) -> str:
    if math.isnan(linear):
        return "not known: the model failed near the nominal dimensions"
    outside = percent * max(low - linear, linear - high, 0.0)
    if outside == 0:
        return "agrees" if math.isfinite(high - low) else "is not contradicted: the sample is too small to tell"
    error = f"{abs(percent * (linear - value)):.3g} % {of} too {'high' if linear > value else 'low'}"
    return f"{'misleads' if outside > 100 * material else 'is good enough'}: {error}"


def _worst_verdict(excess: float, beyond: float) -> str:
    if math.isnan(excess):
        return "not known: the model failed at the limits"
    if beyond > 1e-6:
        return f"misleads: samples go {beyond:.3g} % of the spread beyond it"
    return f"is {excess:.3g} % of the spread wider"
