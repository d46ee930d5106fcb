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
from enum import StrEnum

import numpy as np
import pandas as pd
from scipy.stats import qmc

from tolmc.analysis.surrogate import Model
from tolmc.tolerances.dimension import Tolerances

MAX_CORNER_DIMENSIONS = 14
#: Points inside the limits for each dimension, from how many of the best a search starts, and how far these lie apart.
SPREAD, STARTS, APART = 256, 4, 0.25
#: Percent of the spread: samples that are less than this beyond the worst case are there by the error of search and motion.
RESOLVED = 0.01
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
    256 k points of a Sobol' sequence and improves four good points of each output and side by a compass
    search, the best of them down to 1/1000 of the tolerances. With more than 14 varied dimensions the corners
    are those to which the signs of the sensitivities point, two for each output, and the search is always
    made. A search can miss an extreme that is higher than its surroundings in a small part of the limits.

    Returns
    -------
    DataFrame, index ``output``
        ``nominal``, ``min``, ``max`` in the output's unit; ``min_at``, ``max_at``, the dimensions there in
        words; ``failed``, evaluations without a value, beyond which the worst case is not known, of
        ``evaluations``; ``corners_failed`` of ``corners``; ``all_corners``, whether these are all there are.
    """
    probe = Probe(model, tolerances, tuple(outputs))
    dimensions = len(tolerances.varied)
    has_all = dimensions <= MAX_CORNER_DIMENSIONS
    corners = _all_corners(dimensions) if has_all else _adverse_corners(probe)
    is_searched = dimensions > 0 and (interior or not has_all)
    points = np.vstack([corners, _spread(dimensions)]) if is_searched else corners
    values = _at(probe, points)
    search = _Search(probe, points, values)
    if is_searched:
        search.improve(0.03)
        search.keep_best()
        search.improve(1e-3)
    nominal = probe(probe.nominal[None])[0]
    table = {}
    for k, name in enumerate(probe.outputs):
        (low_at, low), (high_at, high) = search.best(k, -1), search.best(k, 1)
        table[name] = {
            "nominal": nominal[k],
            "min": low,
            "max": high,
            "min_at": _in_words(tolerances, low_at),
            "max_at": _in_words(tolerances, high_at),
            "failed": search.failed[k],
            "evaluations": search.evaluations,
            "corners_failed": np.count_nonzero(np.isnan(values[: len(corners), k])),
            "corners": len(corners),
            "all_corners": has_all,
        }
    return pd.DataFrame.from_dict(table, orient="index").rename_axis("output")


def _all_corners(dimensions: int) -> np.ndarray:
    """(2^dimensions, dimensions) of the unit cube between the limits."""
    return np.array(list(itertools.product((0.0, 1.0), repeat=dimensions)))


def _adverse_corners(probe: Probe) -> np.ndarray:
    """Corners of the unit cube in which the tangent at the nominal has its extremes."""
    gradient = linearise(probe.model, probe.tolerances, outputs=probe.outputs).gradient.to_numpy()
    return np.unique(np.vstack([gradient > 0, gradient < 0]).astype(float), axis=0)


def _spread(dimensions: int) -> np.ndarray:
    """At least SPREAD points for each dimension, all over the unit cube."""
    return qmc.Sobol(dimensions, rng=np.random.default_rng(0)).random_base2((SPREAD * dimensions - 1).bit_length())


def _at(probe: Probe, places: np.ndarray) -> np.ndarray:
    """Outputs at places of the unit cube between the limits."""
    low, high = probe.limits.T
    # Exact at both ends, which a corner of the drawing has to be.
    return probe(np.where(places == 1, high, low + places * (high - low)))


@dataclass
class _Climber:
    """A place from which the search goes on: of output k, to its largest (sign 1) or smallest (-1) value."""

    k: int
    sign: int
    place: np.ndarray
    value: float
    step: float = 0.25

    def look(self, places: np.ndarray, values: np.ndarray) -> None:
        """Go to the best of these places if it is better, else take smaller steps."""
        gains = self.sign * (values - self.value)
        if (gains > 0).any():
            best = int(np.nanargmax(gains))
            self.place, self.value = places[best], float(values[best])
        else:
            self.step /= 2


def _starts(points: np.ndarray, values: np.ndarray) -> list[int]:
    """Rows of the largest values that lie apart: all on one hill would find that hill alone."""
    chosen = []
    for row in np.argsort(-values, kind="stable")[: np.count_nonzero(~np.isnan(values))]:
        if all(np.abs(points[row] - points[other]).max() > APART for other in chosen):
            chosen.append(row)
        if len(chosen) == STARTS:
            break
    return chosen


class _Search:
    """Improves the best points of each output and side by steps along the axes, halved where none helps."""

    def __init__(self, probe: Probe, points: np.ndarray, values: np.ndarray) -> None:
        self.probe, self.evaluations, self.failed = probe, len(values), np.isnan(values).sum(axis=0)
        self.climbers = [
            _Climber(k, sign, points[row], values[row, k])
            for k in range(values.shape[1])
            for sign in (-1, 1)
            for row in _starts(points, sign * values[:, k])
        ]

    def best(self, k: int, sign: int) -> tuple[np.ndarray, float]:
        """Place and value of the best point of a side; NaN where every evaluation failed."""
        side = [climber for climber in self.climbers if (climber.k, climber.sign) == (k, sign)]
        if not side:
            return np.full(len(self.probe.limits), np.nan), math.nan
        found = max(side, key=lambda climber: sign * climber.value)
        return found.place, found.value

    def keep_best(self) -> None:
        best = {}
        for climber in sorted(self.climbers, key=lambda climber: climber.sign * climber.value):
            best[climber.k, climber.sign] = climber
        self.climbers = list(best.values())

    def improve(self, finest: float) -> None:
        """Until no step longer than ``finest``, in shares of the tolerances, helps any climber."""
        moves = np.vstack([np.eye(len(self.probe.limits)), -np.eye(len(self.probe.limits))])
        while active := [climber for climber in self.climbers if climber.step > finest]:
            trials = [np.clip(climber.place + climber.step * moves, 0, 1) for climber in active]
            found = _at(self.probe, np.vstack(trials))
            self.evaluations += len(found)
            self.failed = self.failed + np.isnan(found).sum(axis=0)
            for climber, places, values in zip(active, trials, np.split(found, len(active)), strict=True):
                climber.look(places, values[:, climber.k])


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
    missing: str = "",
    material: float = 0.02,
) -> pd.DataFrame:
    """Worst case, root sum square, Monte Carlo and the accelerated estimate of every output, with a verdict.

    Parameters
    ----------
    worst : from :func:`worst_case`
    linear : from :meth:`Linearisation.root_sum_square`
    monte_carlo : from :func:`tolmc.statistics.summary.summarise`
    accelerated : DataFrame, index ``output``, optional
        Columns as in ``monte_carlo``; from :func:`tolmc.analysis.estimators.accelerated_summary` also ``degree`` and
        ``held_out_share`` of its surrogate.
    missing : str
        Why there is no accelerated estimate.
    material : float
        Error, as a share of the output's spread, up to which a linear answer is good enough.

    Returns
    -------
    DataFrame, index ``output``, ``quantity``
        A row for mean, sd and the limits of 99.73 % of the parts: ``worst_case``, ``root_sum_square``,
        ``monte_carlo``, ``accelerated`` (these two with ``_low``, ``_high``) in the output's unit, the worst
        case NaN where an evaluation failed; ``accelerated_degree``, ``accelerated_held_out`` (held-out error
        over the output's spread in training), ``accelerated_missing``;
        ``error_percent``, root sum square - Monte Carlo in percent of the spread (the distance of the Monte
        Carlo limits; for the sd in percent of it); ``uncertainty_percent``, half the Monte Carlo interval
        likewise; ``excess_percent``, how far the worst case lies beyond the Monte Carlo limit;
        ``beyond_percent``, how far samples go beyond the worst case; ``root_sum_square_is`` (a value of
        :class:`Linear`), ``worst_case_is`` (of :class:`Worst`, empty for mean and sd); ``verdict``, the same
        in words with numbers.
    """
    rows = {}
    for name in monte_carlo.index:
        found, limits = monte_carlo.loc[name], worst.loc[name]
        for quantity, column in QUANTITIES.items():
            row = {
                "worst_case": _worst_value(limits, quantity),
                "root_sum_square": linear.at[name, _LINEAR[quantity]],
                **_estimate("monte_carlo", monte_carlo, name, column),
                **_estimate("accelerated", accelerated, name, column),
                **_surrogate(accelerated, name),
                "accelerated_missing": missing,
            }
            rows[name, quantity] = row | _judged(row, quantity, material, found, limits)
    index = pd.MultiIndex.from_tuples(rows, names=["output", "quantity"])
    table = pd.DataFrame(list(rows.values()), index=index)
    return table.assign(worst_case_is=table["worst_case_is"].fillna(""))


class Linear(StrEnum):
    """What root sum square is, judged by Monte Carlo."""

    GOOD = "good enough"
    MISLEADS = "misleads"
    OPEN = "not decided"
    UNKNOWN = "not known"
    CONSTANT = "does not vary"


class Worst(StrEnum):
    """What the worst case is, judged by Monte Carlo."""

    WIDER = "wider"
    EXCEEDED = "exceeded"
    UNKNOWN = "not known"


_EXTREME = {"lower limit": "min", "upper limit": "max"}
_LINEAR = {"mean": "mean", "sd": "sd", "lower limit": "low", "upper limit": "high"}


def _estimate(kind: str, table: pd.DataFrame | None, name: str, column: str) -> dict[str, float]:
    known = table is not None and name in table.index and column in table
    return {f"{kind}{end}": table.at[name, f"{column}{end}"] if known else math.nan for end in ("", "_low", "_high")}


def _surrogate(accelerated: pd.DataFrame | None, name: str) -> dict[str, float]:
    columns = {"accelerated_degree": "degree", "accelerated_held_out": "held_out_share"}
    known = accelerated is not None and name in accelerated.index
    return {
        new: accelerated.at[name, old] if known and old in accelerated else math.nan for new, old in columns.items()
    }


def _worst_value(worst: pd.Series, quantity: str) -> float:
    """The worst case of a limit, which is not known where the model failed on the way."""
    is_known = quantity in _EXTREME and not worst["failed"]
    return float(worst[_EXTREME[quantity]]) if is_known else math.nan


def _judged(row: dict, quantity: str, material: float, found: pd.Series, worst: pd.Series) -> dict:
    value, low, high = row["monte_carlo"], row["monte_carlo_low"], row["monte_carlo_high"]
    scale = found["sd"] if quantity == "sd" else found["q99.865"] - found["q0.135"]
    if not scale > 0:
        return {"root_sum_square_is": Linear.CONSTANT.value, "verdict": Linear.CONSTANT.value}
    linear, percent = row["root_sum_square"], 100 / scale
    of = "of the sd" if quantity == "sd" else "of the spread"
    kind, words = _linear_verdict(linear, value, low, high, percent, of, material)
    judged = {
        "error_percent": percent * (linear - value),
        "uncertainty_percent": percent * 0.5 * (high - low),
        "root_sum_square_is": kind.value,
        "verdict": f"root sum square {words}",
    }
    if quantity in _EXTREME:
        outward = 1 if quantity == "upper limit" else -1
        beyond = outward * percent * (found[_EXTREME[quantity]] - row["worst_case"])
        excess = outward * percent * (row["worst_case"] - value)
        kind, words = _worst_verdict(excess, beyond, worst)
        judged |= {
            "excess_percent": excess,
            "beyond_percent": max(beyond, 0.0),
            "worst_case_is": kind.value,
            "verdict": f"{judged['verdict']}; worst case {words}",
        }
    return judged


def _linear_verdict(linear, value, low, high, percent, of, material) -> tuple[Linear, str]:
    if math.isnan(linear):
        return Linear.UNKNOWN, "not known: the model failed near the nominal dimensions"
    outside = percent * max(low - linear, linear - high, 0.0)
    if outside == 0:
        if math.isfinite(high - low):
            return Linear.GOOD, "agrees"
        return Linear.OPEN, "is not contradicted: the sample is too small to tell"
    error = f"{abs(percent * (linear - value)):.3g} % {of} too {'high' if linear > value else 'low'}"
    if outside > 100 * material:
        return Linear.MISLEADS, f"misleads: {error}"
    return Linear.GOOD, f"is good enough: {error}"


def _worst_verdict(excess: float, beyond: float, worst: pd.Series) -> tuple[Worst, str]:
    if worst["corners_failed"]:
        return Worst.UNKNOWN, f"not known: {worst['corners_failed']} of {worst['corners']} corners have no value"
    if worst["failed"]:
        return (
            Worst.UNKNOWN,
            f"not known: {worst['failed']} of {worst['evaluations']} motions within the limits have no value",
        )
    how = "" if worst["all_corners"] else " (corners by the signs of the sensitivities)"
    if beyond > RESOLVED:
        return Worst.EXCEEDED, f"misleads: samples go {beyond:.3g} % of the spread beyond it{how}"
    return Worst.WIDER, f"is {max(excess, 0.0):.3g} % of the spread wider{how}"
