"""Fits side by side: the same study with each, from the same points."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

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
        bore and journal where [allocation] prices both grades, else NaN.

    Raises
    ------
    ValueError, InputError
        When a fit cannot be read or leaves no clearance, or the study cannot be run.
    """
    names = fit_series(tried, study_size(study)) if isinstance(tried, str) else list(tried)
    rows = {name: _row(study.with_fit(name), name, samples) for name in names}
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("fit")


def _row(study: Study, fit: str, samples: int | None) -> dict[str, float]:
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
    return found | {"cost": _cost(study, fits.fit(fit).toleranced_sizes)}


def _cost(study: Study, sizes: Iterable[str]) -> float:
    """Cost of bore and journal in these classes, by the grades that [allocation.dimensions] prices."""
    tables = study.allocation.get("dimensions", {})
    total = 0.0
    for name, size in zip(JOINT[:2], sizes, strict=True):
        priced = {**tables.get(name, {}), **tables.get(DRAWN[name], {})}
        total += float(priced.get("grades", {}).get(f"IT{fits.grade_of(size)}", np.nan))
    return total
