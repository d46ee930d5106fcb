"""One-at-a-time curves as small drawings: each output over each dimension between its limits."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import pandas as pd

from tolmc import quantities
from tolmc.statistics.outcomes import Specification
from tolmc.text import phrases, typeset

WIDTH, HEIGHT = 200, 110


@dataclass(frozen=True)
class Panel:
    """A curve in a frame of WIDTH by HEIGHT: ``points``, the heights of the ``limits``, and the texts at the frame's ends."""

    output: str
    dimension: str
    points: str
    limits: tuple[float, ...]
    left: str
    right: str
    bottom: str
    top: str


def panels(curves: pd.DataFrame, outputs: Iterable[str], specification: Specification) -> list[list[Panel]]:
    """A row of panels for each of the ``outputs``, a panel a dimension, from :func:`one_at_a_time`.

    The panels of a row share their scale, so that slopes compare.
    """
    known = [name for name in outputs if name in curves and curves[name].notna().any()]
    limits = {name: [limit for limit in specification.get(name, {}).values() if limit is not None] for name in known}
    return [list(_row(curves, name, limits[name])) for name in known]


def _row(curves: pd.DataFrame, output: str, limits: Iterable[float]) -> Iterable[Panel]:
    values = curves[output].to_numpy(float)
    low, high = _span(values[np.isfinite(values)], limits)

    factor = quantities.shown(output)[1]
    bottom, top = typeset.span(low * factor, high * factor, 3).split(" to ")

    def heights(y):
        return HEIGHT * (high - np.asarray(y, float)) / (high - low)

    for dimension, curve in curves.groupby(level="dimension", sort=False):
        curve = curve[np.isfinite(curve[output])]
        if len(curve) < 2:
            continue
        x = curve["value"].to_numpy(float)
        across = WIDTH * (x - x[0]) / (x[-1] - x[0])
        yield Panel(
            output=f"{quantities.label(output)} ({phrases.unit(output)})",
            dimension=quantities.label(dimension),
            points=" ".join(f"{a:.1f},{b:.1f}" for a, b in zip(across, heights(curve[output]), strict=True)),
            limits=tuple(round(float(h), 1) for h in heights(list(limits)) if 0 <= h <= HEIGHT),
            left=phrases.quantity(dimension, x[0]),
            right=phrases.quantity(dimension, x[-1]),
            bottom=bottom,
            top=top,
        )


def _span(values: np.ndarray, limits: Iterable[float]) -> tuple[float, float]:
    """The range of the values, with the limits that lie near it, and a margin."""
    low, high = float(values.min()), float(values.max())
    width = high - low
    near = [limit for limit in limits if low - width <= limit <= high + width]
    low, high = min([low, *near]), max([high, *near])
    margin = 0.06 * (high - low) or 1e-6 * max(abs(high), 1e-300)
    return low - margin, math.nextafter(high + margin, math.inf)
