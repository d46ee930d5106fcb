"""Every output along one dimension, the others at their nominal values."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pandas as pd

from tolmc.analysis.surrogate import Model
from tolmc.tolerances.dimension import Tolerances


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
