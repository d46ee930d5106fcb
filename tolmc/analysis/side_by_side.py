"""Worst case, root sum square and Monte Carlo side by side: where what drawing offices use misleads."""

from __future__ import annotations

import math
from enum import StrEnum

import pandas as pd

#: Percent of the spread: samples that are less than this beyond the worst case are there by the error of search and motion.
RESOLVED = 0.01
# Row of the comparison -> column of the Monte Carlo summary.
QUANTITIES = {"mean": "mean", "sd": "sd", "lower limit": "q0.135", "upper limit": "q99.865"}


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
        Columns as in ``monte_carlo``; from :func:`tolmc.analysis.accelerated.accelerated_summary` also ``degree`` and
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
    return pd.DataFrame(list(rows.values()), index=index)


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
    if table is None or name not in table.index or column not in table:
        return {f"{kind}{end}": math.nan for end in ("", "_low", "_high")}
    return {f"{kind}{end}": table.at[name, f"{column}{end}"] for end in ("", "_low", "_high")}


def _surrogate(accelerated: pd.DataFrame | None, name: str) -> dict[str, float]:
    columns = {"accelerated_degree": "degree", "accelerated_held_out": "held_out_share"}
    if accelerated is None or name not in accelerated.index:
        return dict.fromkeys(columns, math.nan)
    return {new: accelerated.at[name, old] if old in accelerated else math.nan for new, old in columns.items()}


def _worst_value(worst: pd.Series, quantity: str) -> float:
    """The worst case of a limit, which is not known where the model failed on the way."""
    is_known = quantity in _EXTREME and not worst["failed"]
    return float(worst[_EXTREME[quantity]]) if is_known else math.nan


def _judged(row: dict, quantity: str, material: float, found: pd.Series, worst: pd.Series) -> dict:
    value, low, high = row["monte_carlo"], row["monte_carlo_low"], row["monte_carlo_high"]
    scale = found["sd"] if quantity == "sd" else found["q99.865"] - found["q0.135"]
    percents = ("error_percent", "uncertainty_percent", "excess_percent", "beyond_percent")
    unjudged: dict[str, float | str] = {**dict.fromkeys(percents, math.nan), "worst_case_is": ""}
    if not scale > 0:
        kind = Linear.UNKNOWN if math.isnan(scale) else Linear.CONSTANT
        return unjudged | {"root_sum_square_is": kind.value, "verdict": kind.value}
    linear, percent = row["root_sum_square"], 100 / scale
    of = "of the sd" if quantity == "sd" else "of the spread"
    kind, words = _linear_verdict(linear, value, low, high, percent, of, material)
    judged = unjudged | {
        "error_percent": percent * (linear - value),
        "uncertainty_percent": percent * 0.5 * (high - low),
        "root_sum_square_is": kind.value,
        "verdict": f"root sum square {words}",
    }
    if quantity in _EXTREME:
        outward = 1 if quantity == "upper limit" else -1
        beyond = outward * percent * (found[_EXTREME[quantity]] - row["worst_case"])
        excess = outward * percent * (row["worst_case"] - value)
        worst_kind, words = _worst_verdict(excess, beyond, worst)
        judged |= {
            "excess_percent": excess,
            "beyond_percent": max(beyond, 0.0),
            "worst_case_is": worst_kind.value,
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
