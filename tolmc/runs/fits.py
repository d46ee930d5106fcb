"""Fits side by side: the same study with each, from the same points."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import pandas as pd

from tolmc.quantities import DRAWN, JOINT
from tolmc.runs.run import run
from tolmc.statistics.outcomes import ANY_REQUIREMENT
from tolmc.study.study import Study
from tolmc.tolerances import fits
from tolmc.tolerances.fit_series import fit_series

#: The quantile of an output that is limited above, and of one that is limited below: ±3 sigma of a normal one.
_EXTREMES = {"max": "q99.865", "min": "q0.135"}

#: What the run of a fit says of the model of the joint.
_MODEL_TERMS = [f"{term}{end}" for term in ("section", "contact_law") for end in ("", "_turns_target")]


def study_size(study: Study) -> str | None:
    """Nominal diameter of the study's fit, mm; None where it has none."""
    sizes = [d.toleranced_size for d in study.tolerances.dimensions if d.toleranced_size and d.name != "half_length"]
    return f"{round(1e3 * fits.size_limits(sizes[0])[0], 9):g}" if sizes else None


def try_fits(study: Study, tried: str | Sequence[str], *, samples: int | None = None) -> pd.DataFrame:
    """The study with each of some fits.

    Parameters
    ----------
    tried : fits, or a text that :func:`tolmc.tolerances.fit_series.fit_series` reads
    samples : in place of the study's

    Returns
    -------
    pandas.DataFrame, index ``fit``
        ``clearance_low``, ``clearance_high`` on the diameter (m); ``yield`` with its 95 % interval, ``unknown`` samples within
        it; for each limited output its quantile near the limit with the interval, such as ``tilt_angle q99.865``; ``cost`` of
        bore and journal where [allocation] prices both grades, else NaN; ``computed_share``; ``section``, ``contact_law`` and
        whether each ``_turns_target``, as the run's requirements have them, where any fit's run has.

    Raises
    ------
    ValueError, InputError
        When a fit cannot be read or leaves no clearance, or the study cannot be run.
    """
    names = fit_series(tried, study_size(study)) if isinstance(tried, str) else list(tried)
    rows = {name: _row(study.with_fit(name), name, samples) for name in names}
    table = pd.DataFrame.from_dict(rows, orient="index").rename_axis("fit")
    said = {
        name: table[name].fillna("" if name in ("section", "contact_law") else False)
        for name in _MODEL_TERMS
        if name in table
    }
    return table.assign(**said)


def _row(study: Study, fit: str, samples: int | None) -> dict[str, Any]:
    result = run(study, samples=samples)
    low, high = fits.fit(fit).clearance
    out = result.requirements.loc[ANY_REQUIREMENT]
    found = {
        "clearance_low": low,
        "clearance_high": high,
        "yield": 1.0 - out["share_most"],
        "yield_low": 1.0 - out["share_most_high"],
        "yield_high": 1.0 - out["share_least_low"],
        "unknown": out["unknown"],
    }
    for name, limits in study.specification.items():
        for end in limits:
            statistic = _EXTREMES[end]
            for bound in ("", "_low", "_high"):
                found[f"{name} {statistic}{bound}"] = result.summary.at[name, f"{statistic}{bound}"]
    terms = {name: out[name] for name in _MODEL_TERMS if name in out}
    cost = _cost(study, fits.fit(fit).toleranced_sizes)
    return found | {"cost": cost, "computed_share": result.computed_share, **terms}


def _cost(study: Study, sizes: Iterable[str]) -> float:
    """Cost of bore and journal in these classes, by the grades that [allocation.dimensions] prices."""
    tables = study.allocation.get("dimensions", {})
    total = 0.0
    for name, size in zip(JOINT[:2], sizes, strict=True):
        priced = {**tables.get(name, {}), **tables.get(DRAWN[name], {})}
        total += float(priced.get("grades", {}).get(f"IT{fits.grade_of(size)}", np.nan))
    return total
