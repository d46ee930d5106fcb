"""Worst case: the limits of the dimensions at their most adverse, at the corners and inside the box."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.stats import qmc

from tolmc.analysis.linear import linearise
from tolmc.analysis.probe import Probe
from tolmc.analysis.surrogate import Model
from tolmc.tolerances.dimension import Tolerances

MAX_CORNER_DIMENSIONS = 14
#: Points inside the limits for each dimension, from how many of the best a search starts, and how far these lie apart.
SPREAD, STARTS, APART = 256, 4, 0.25
#: Steps of the search, in shares of the tolerances.
LARGEST_STEP = 0.25
#: Gain that ends it, as a share of the values' range.
NEGLIGIBLE = 1e-6


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
    """A place from which the search goes on: of output k, to its largest (sign 1) or smallest (-1) value.

    ``least``: gains that are no more are rounding.
    """

    k: int
    sign: int
    place: np.ndarray
    value: float
    least: float
    step: float = LARGEST_STEP

    def look(self, places: np.ndarray, values: np.ndarray) -> None:
        """Go to the best of these places if it is better, and on with larger steps; else take smaller ones."""
        gains = self.sign * (values - self.value)
        if (gains > self.least).any():
            best = int(np.nanargmax(gains))
            self.place, self.value = places[best], float(values[best])
            self.step = min(2 * self.step, LARGEST_STEP)
        else:
            self.step /= 2


def _starts(points: np.ndarray, values: np.ndarray) -> list[int]:
    """Rows of the largest values that lie apart: all on one hill would find that hill alone."""
    chosen: list[int] = []
    for row in np.argsort(-values, kind="stable")[: np.count_nonzero(~np.isnan(values))]:
        if all(np.abs(points[row] - points[other]).max() > APART for other in chosen):
            chosen.append(row)
        if len(chosen) == STARTS:
            break
    return chosen


class _Search:
    """Improves the best points of each output and side by steps along the axes, doubled where one helps, else halved."""

    def __init__(self, probe: Probe, points: np.ndarray, values: np.ndarray) -> None:
        self.probe = probe
        self.known = dict(zip(map(bytes, points), values, strict=True))
        self.climbers = [
            _Climber(k, sign, points[row], values[row, k], NEGLIGIBLE * reach)
            for k, reach in enumerate(
                np.nanmax(values, axis=0, initial=-np.inf) - np.nanmin(values, axis=0, initial=np.inf)
            )
            for sign in (-1, 1)
            for row in _starts(points, sign * values[:, k])
        ]

    @property
    def evaluations(self) -> int:
        return len(self.known)

    @property
    def failed(self) -> np.ndarray:
        """Evaluations without a value, of each output."""
        return np.isnan(list(self.known.values())).sum(axis=0)

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
            self._evaluate(np.vstack(trials))
            for climber, places in zip(active, trials, strict=True):
                climber.look(places, np.array([self.known[bytes(place)][climber.k] for place in places]))

    def _evaluate(self, places: np.ndarray) -> None:
        """What is not known of these places: climbers of many outputs start from the same ones."""
        fresh = {bytes(place): place for place in places if bytes(place) not in self.known}
        if fresh:
            self.known |= zip(fresh, _at(self.probe, np.array(list(fresh.values()))), strict=True)


def _in_words(tolerances: Tolerances, place: np.ndarray) -> str:
    if np.isnan(place).any():
        return "not known"
    ends = {0.0: "lower limit", 1.0: "upper limit"}
    parts = (
        f"{d.name} at its {ends[u]}" if u in ends else f"{d.name} at {100 * u:.1f} % of its tolerance"
        for d, u in zip(tolerances.varied, place.tolist(), strict=True)
    )
    return ", ".join(parts)
