"""Yield and capability of the outputs.

With limits L and U, mean m and standard deviation s, Cp = (U - L)/(6 s) and Cpk = min(U - m, m - L)/(3 s)
take s within lots, Pp and Ppk take the s of all samples (ISO 22514-2); without lots the two pairs are
equal. The indices describe spread and position, nothing more: how many parts are out follows from them for
a normal output only, so the share that is really out stands beside the share that a normal output with
these indices would have.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy import special

from tolmc.statistics.intervals import Estimate
from tolmc.statistics.observations import Observations
from tolmc.statistics.outcomes import ALL_REQUIREMENTS, ANY_REQUIREMENT, CONTACT_LOSS, Specification, without_value
from tolmc.statistics.rows import Rows
from tolmc.statistics.summary import as_columns, summarise_requirements
from tolmc.tolerances.unit_cube import lot_numbers

#: Standard deviation, as a share of the mean and the limits, that rounding alone leaves of an output that does not vary.
_ROUNDING = 1e-10


def ppm_from_cpk(cpk: ArrayLike, *, sides: int = 2):
    """Parts per million out of limits for a normal output: 1e6 sides Phi(-3 Cpk); ``sides`` = 2: centred."""
    return 1e6 * sides * special.ndtr(-3 * np.asarray(cpk, float))[()]


def cpk_from_ppm(ppm: ArrayLike, *, sides: int = 2):
    """Inverse of :func:`ppm_from_cpk`."""
    return -special.ndtri(np.asarray(ppm, float) * 1e-6 / sides)[()] / 3


def capability(
    samples: pd.DataFrame,
    *,
    specification: Specification,
    sampling: str = "random",
    confidence: float = 0.95,
    lot_size: int = 1,
    on_contact_loss: str = "stop",
) -> pd.DataFrame:
    """A row a requirement and one for all of them: yield, parts per million and capability indices.

    Parameters
    ----------
    As for :func:`tolmc.statistics.summary.summarise`.

    Returns
    -------
    DataFrame, index ``requirement``
        With ``_low`` and ``_high`` each: ``yield`` and ``ppm``, the share in specification and the parts
        per million out of it, with samples that are not known (:func:`tolmc.statistics.outcomes.without_value`)
        counted as out and the interval reaching to where they are in; ``Cp``, ``Cpk``, ``Pp``, ``Ppk`` over
        the other samples (NaN where a limit is missing that the index needs, or nothing varies). Their
        intervals hold for outputs that are not normal. ``ppm_if_normal``: what Ppk and its other side promise
        for a normal output; far from ``ppm``, the indices mislead. ``is_constant``: the output does not vary
        beyond rounding, so that it has no indices.
    """
    rows = Rows(sampling, confidence, lot_size)
    shares = summarise_requirements(
        samples, specification=specification, sampling=sampling, confidence=confidence, lot_size=lot_size,
        on_contact_loss=on_contact_loss,
    )  # fmt: skip
    shares = shares.drop(index=CONTACT_LOSS).rename(index={ANY_REQUIREMENT: ALL_REQUIREMENTS})
    table = {}
    for name, row in shares.iterrows():
        low, estimate, high = 1 - row["share_most_high"], 1 - row["share_most"], 1 - row["share_least_low"]
        table[name] = {
            **as_columns("yield", Estimate(estimate, low, high)),
            **as_columns("ppm", Estimate(*(1e6 * (1 - share) for share in (estimate, high, low)))),
        }
        if name in specification:
            missing = without_value(samples, name, specification=specification, on_contact_loss=on_contact_loss)
            values = np.where(missing, np.nan, samples[name].to_numpy(float))
            table[name] |= _indices(Observations(values, rows), row["minimum"], row["maximum"])
    return pd.DataFrame.from_dict(table, orient="index").rename_axis("requirement")


def _indices(seen: Observations, low: float, high: float) -> dict[str, float]:
    overall = seen.deviations
    within = overall if seen.rows.lot_size == 1 else _deviations_within_lots(seen)
    columns: dict[str, Any] = {}
    scale = np.nanmax(np.abs([seen.mean_value, low, high, 0.0]))
    for names, deviations in ((("Cp", "Cpk"), within), (("Pp", "Ppk"), overall)):
        sd, relative = _spread(seen, deviations, lots=deviations is not overall)
        if sd <= _ROUNDING * scale:
            sd = 0.0
        columns |= as_columns(names[0], _two_sided_index(seen, low, high, sd, relative))
        columns |= as_columns(names[1], _nearest_index(seen, low, high, sd, relative))
    margins = [m for m in (high - seen.mean_value, seen.mean_value - low) if not math.isnan(m)]
    columns["is_constant"] = seen.count > 1 and sd == 0
    columns["ppm_if_normal"] = sum(float(ppm_from_cpk(m / (3 * sd), sides=1)) for m in margins) if sd else math.nan
    return columns


def _lots(seen: Observations) -> np.ndarray:
    return lot_numbers(seen.rows.lot_size, len(seen.values), sampling=seen.rows.sampling)


def _deviations_within_lots(seen: Observations) -> np.ndarray:
    """x_j - mean of its lot in row order, zero for rows that are not used."""
    lots, used = _lots(seen), ~np.isnan(seen.values)
    counts = np.bincount(lots, weights=used)
    means = np.bincount(lots, weights=seen.deviations) / np.maximum(counts, 1)
    return np.where(used, seen.deviations - means[lots], 0.0)


def _spread(seen: Observations, deviations: np.ndarray, *, lots: bool) -> tuple[float, np.ndarray]:
    """Standard deviation and the influence values of its square relative to that."""
    used = ~np.isnan(seen.values)
    lost = len(np.unique(_lots(seen)[used])) if lots else 1
    squares = np.square(deviations)
    total = float(squares.sum())
    if seen.count <= lost or total == 0:
        return 0.0, squares
    return math.sqrt(total / (seen.count - lost)), np.where(used, squares * (seen.count / total) - 1, 0.0)


def _two_sided_index(seen, low, high, sd, relative) -> Estimate:
    """(U - L)/(6 s), its interval on the logarithm."""
    if sd == 0 or math.isnan(high - low):
        return Estimate(math.nan, math.nan, math.nan)
    index = (high - low) / (6 * sd)
    _, below, above = seen.rows.smooth(0.0, -0.5 * relative, seen.count)
    return Estimate(index, index * math.exp(below), index * math.exp(above))


def _nearest_index(seen, low, high, sd, relative) -> Estimate:
    """min over the given limits of distance/(3 s); for normal rows the interval is Bissell's (1990)."""
    sides = [
        (sign * (limit - seen.mean_value) / (3 * sd), sign)
        for limit, sign in ((high, 1), (low, -1))
        if sd > 0 and not math.isnan(limit)
    ]
    if not sides:
        return Estimate(math.nan, math.nan, math.nan)
    estimates = [
        seen.rows.smooth(index, -sign * seen.deviations / (3 * sd) - 0.5 * index * relative, seen.count)
        for index, sign in sides
    ]
    return Estimate(*(min(bounds) for bounds in zip(*estimates, strict=True)))
