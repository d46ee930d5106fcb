"""What the circle of constant radius changes in a run's numbers, from samples that were run on the exact section too.

The third term of a run's error budget, beside integration and sampling: the model's. Both sections see the same dimensions, so
that differences are known far better than the numbers themselves.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import pandas as pd

from tolmc.statistics.intervals import Estimate, t_quantile
from tolmc.statistics.outcomes import (
    ANY_REQUIREMENT,
    CONTACT_LOSS,
    Specification,
    contact_lost,
    failed,
    out_of_specification,
)
from tolmc.statistics.rows import Rows
from tolmc.statistics.summary import QUANTILES, as_columns, summarise_requirements
from tolmc.tolerances.unit_cube import SCRAMBLINGS, lot_numbers

#: Beside the target, the yield of which the sections must agree whether it is reached: that most parts keep a requirement.
MOST = 0.5
_STATISTICS = ("mean", "sd", *QUANTILES)
_MATTERS = "not decided: the section matters"


def section_differences(
    circle: pd.DataFrame, exact: pd.DataFrame, outputs: Iterable[str], **drawn: Any
) -> pd.DataFrame:
    """Circle less exact section of every statistic of the outputs, over the same samples.

    Parameters
    ----------
    circle, exact : a row a sample, the same samples in the same order
    outputs : names of columns of both
    drawn : ``sampling``, ``lot_size``, ``confidence`` of :class:`tolmc.statistics.rows.Rows`

    Returns
    -------
    DataFrame, index ``output``
        ``section_mean``, ``section_sd`` and the quantiles, each with ``_low`` and ``_high``, in the output's unit. Intervals
        are by the jackknife over 16 groups of rows (scramblings, or whole lots), Student's t with 15 degrees.
    """
    return paired_differences(circle, exact, outputs, "section", **drawn)


def paired_differences(
    first: pd.DataFrame, second: pd.DataFrame, outputs: Iterable[str], prefix: str, **drawn: Any
) -> pd.DataFrame:
    """First less second of every statistic of the outputs, over the same samples: :func:`section_differences`."""
    rows = Rows(**drawn)
    groups = lot_numbers(rows.lot_size, len(first), sampling=rows.sampling) % SCRAMBLINGS
    unusable = failed(first) | failed(second)
    table = {}
    for name in outputs:
        pair = np.stack([first[name].to_numpy(float), second[name].to_numpy(float)])
        used = ~(unusable | np.isnan(pair).any(axis=0))
        differences = _jackknife(pair[:, used], groups[used], rows.confidence)
        table[name] = {
            column: value
            for key, estimate in zip(_STATISTICS, differences, strict=True)
            for column, value in as_columns(f"{prefix}_{key}", estimate).items()
        }
    return pd.DataFrame.from_dict(table, orient="index").rename_axis("output")


def _jackknife(pair: np.ndarray, groups: np.ndarray, confidence: float) -> list[Estimate]:
    present, sizes = np.unique(groups, return_counts=True)
    if pair.shape[1] < 2 * SCRAMBLINGS or len(present) < 2:
        return [Estimate(math.nan, -math.inf, math.inf)] * len(_STATISTICS)
    value = _difference(pair)
    without = np.empty((len(present), len(_STATISTICS)))
    for size in np.unique(sizes):  # groups of a size at once: they all have the same, or a row more
        of_size = sizes == size
        without[of_size] = _difference(np.stack([pair[:, groups != group] for group in present[of_size]]))
    count = len(present)
    error = np.sqrt((count - 1) / count * np.square(without - without.mean(axis=0)).sum(axis=0))
    half = t_quantile(confidence, count - 1) * error
    return [Estimate(v, v - h, v + h) for v, h in zip(value.tolist(), half.tolist(), strict=True)]


def _difference(pairs: np.ndarray) -> np.ndarray:
    """First less second statistics, (..., statistics), of (..., 2, rows)."""
    quantiles = np.quantile(pairs, list(QUANTILES.values()), axis=-1)
    statistics = np.array([pairs.mean(axis=-1), pairs.std(axis=-1), *quantiles])  # (statistics, ..., 2)
    return np.moveaxis(statistics[..., 0] - statistics[..., 1], 0, -1)


def section_of_requirements(
    samples: pd.DataFrame,
    circle: pd.DataFrame,
    exact: pd.DataFrame,
    shares: pd.DataFrame,
    *,
    specification: Specification,
    target: float,
    on_contact_loss: str = "stop",
    **drawn: Any,
) -> pd.DataFrame:
    """What the exact section says of every requirement, and whether it could turn the verdict.

    Parameters
    ----------
    samples : all samples of the run, on the circle
    circle, exact : the first of them, there and on the exact section
    shares : :func:`tolmc.statistics.summary.summarise_requirements` of ``samples``
    target : the yield that is asked for

    Returns
    -------
    DataFrame, index ``requirement``
        ``exact_least``, ``exact_most`` with ``_low`` and ``_high``: the share out on the exact section, as ``share_least`` and
        ``share_most`` of the run; ``section_difference`` with its interval: share out on the circle less that on the exact
        section, over the same samples; ``section``: "not decided: the section matters (circle 3 %, exact 100 %)" where the
        circle decides whether most parts, or the target yield, keep the requirement and the exact section does not confirm it;
        empty elsewhere. ``section_turns_target``: whether that is so of the target yield.
    """
    rows = Rows(**drawn)
    # A sample that failed on the circle, by halving its steps say, is not known on the exact section either.
    exact = exact.assign(status=exact["status"].astype(object).mask(failed(circle), circle["status"].astype(object)))
    found = summarise_requirements(exact, specification=specification, on_contact_loss=on_contact_loss, **drawn)
    frames = {"circle": circle, "exact": exact}
    states = {section: events(frame, specification, on_contact_loss) for section, frame in frames.items()}
    shifted = _shifted_shares(samples, circle, exact, specification, on_contact_loss, drawn)
    table: dict[str, dict[str, Any]] = {}
    for name in shares.index:
        (out, known), (out_exact, known_exact) = states["circle"][name], states["exact"][name]
        agree = bool(np.array_equal(known, known_exact))
        difference = share_difference(rows, out, out_exact)
        bounds = found.loc[name, "share_least_low"], found.loc[name, "share_most_high"]
        if agree and name in shifted:
            bounds = shifted[name]
        differs = not agree or not np.array_equal(out, out_exact) or name in shifted
        of_target = differs and turns(shares.loc[name], bounds, target)
        matters = of_target or (differs and turns(shares.loc[name], bounds, MOST))
        table[str(name)] = {
            **{f"exact_{key[6:]}": found.loc[name, key] for key in found if key.startswith("share_")},
            **as_columns("section_difference", difference),
            "section": _sentence(shares.loc[name], found.loc[name]) if matters else "",
            "section_turns_target": of_target,
        }
    return pd.DataFrame.from_dict(table, orient="index").rename_axis("requirement")


def share_difference(rows: Rows, first: np.ndarray, second: np.ndarray) -> Estimate:
    """Share of the rows in ``first`` less that in ``second``, (rows,) bool each, from those in one of them alone."""
    only, other = rows.share(first & ~second), rows.share(second & ~first)
    return Estimate(only.value - other.value, only.low - other.high, only.high - other.low)


def events(
    samples: pd.DataFrame, specification: Specification, on_contact_loss: str
) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Rows out of each requirement, and rows known to be in or out; of any, and of contact loss; (rows,) bool each."""
    out, known = out_of_specification(samples, specification, on_contact_loss=on_contact_loss)
    events = {name: (out[name], known[name]) for name in specification}
    if specification:
        any_out = np.any(list(out.values()), axis=0)
        events[ANY_REQUIREMENT] = any_out, any_out | np.all(list(known.values()), axis=0)
    events[CONTACT_LOSS] = contact_lost(samples), ~failed(samples)
    return events


def _shifted_shares(
    samples: pd.DataFrame,
    circle: pd.DataFrame,
    exact: pd.DataFrame,
    specification: Specification,
    on_contact_loss: str,
    drawn: Mapping[str, Any],
) -> dict[str, tuple[float, float]]:
    """Bounds of the shares out with limits moved by the least and the largest difference that any sample showed.

    All samples of the run count here, so that a share of parts per million stays one.
    """
    least: dict[str, dict[str, float]] = {}
    most: dict[str, dict[str, float]] = {}
    for name, limits in specification.items():
        moved = (exact[name] - circle[name]).to_numpy(float)
        moved = moved[np.isfinite(moved)]
        low, high = (moved.min(), moved.max()) if len(moved) else (0.0, 0.0)
        ends = {key: limit for key, limit in limits.items() if limit is not None}
        least[name] = {key: limit - (low if key == "max" else high) for key, limit in ends.items()}
        most[name] = {key: limit - (high if key == "max" else low) for key, limit in ends.items()}
        if most[name].get("min", -math.inf) > most[name].get("max", math.inf):
            return {}
    if not specification:
        return {}
    judge = {"on_contact_loss": on_contact_loss, **drawn}
    fewest = summarise_requirements(samples, specification=least, **judge)["share_least_low"]
    largest = summarise_requirements(samples, specification=most, **judge)["share_most_high"]
    return {str(name): (fewest[name], largest[name]) for name in fewest.index if name != CONTACT_LOSS}


def turns(counted: pd.Series, bounds: tuple[float, float], required: float) -> bool:
    """Whether the run decides about a yield and the bounds of the share out by another model do not decide the same."""
    allowed = 1.0 - required
    verdict = side(counted["share_least_low"], counted["share_most_high"], allowed)
    return verdict != 0 and side(*bounds, allowed) != verdict


def side(low: float, high: float, allowed: float) -> int:
    """-1: no more than allowed is out; 1: more is; 0: not decided."""
    return -1 if high <= allowed else 1 if low > allowed else 0


def _sentence(circle: pd.Series, exact: pd.Series) -> str:
    return f"{_MATTERS} (circle {percent(circle)}, exact {percent(exact)})"


def percent(counted: pd.Series) -> str:
    """The share out of a requirement, or both where samples are unknown."""
    least, most = (f"{100 * counted[key]:.3g} %" for key in ("share_least", "share_most"))
    return least if least == most else f"{least} to {most}"
