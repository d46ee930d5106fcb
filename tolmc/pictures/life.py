"""Picture of a joint that wears: clearance, forces, tilt and the share of good parts against running time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from tolmc import quantities
from tolmc.pictures.plots import BLUE, GREY, RED, Picture, axis_label, heading, styled

_COLUMNS = 2


def draw_life(
    table: pd.DataFrame,
    outputs: Sequence[str],
    *,
    life: tuple[float, float, float],
    broken_share: float,
    specification: Mapping[str, Mapping[str, float]],
    title: str,
) -> Figure:
    """Median and the band from 5 % to 95 % of the parts of each output, and the share of the parts inside their limits.

    Parameters
    ----------
    table : DataFrame, index hours
        As :class:`tolmc.runs.life.LifeResult` has it.
    outputs : names in it
    life : (hours, low, high)
        When ``broken_share`` of the parts has broken a limit, with its interval.
    """
    hours = table.index.to_numpy(float)
    rows = -(-(len(outputs) + 1) // _COLUMNS)
    height = 0.75 + 2.9 * rows
    with styled():
        figure = Picture(figsize=(10.6, height))
        heading(figure, f"{title}: against running time")
        axes = figure.subplots(rows, _COLUMNS, squeeze=False).ravel()
        for axis, name in zip(axes, outputs, strict=False):
            _draw_output(axis, hours, table, name, specification.get(name, {}))
        _draw_share(axes[len(outputs)], hours, table, broken_share)
        for axis in axes[: len(outputs) + 1]:
            _mark_life(axis, hours[-1], life)
        for axis in axes[len(outputs) + 1 :]:
            axis.set_visible(False)
        figure.subplots_adjust(
            left=0.085, right=0.975, top=1 - 0.95 / height, bottom=0.6 / height, hspace=0.42, wspace=0.22
        )
    return figure


def _draw_output(axis: Any, hours: np.ndarray, table: pd.DataFrame, name: str, limits: Mapping[str, float]) -> None:
    _, factor = quantities.shown(name)
    low, middle, high = (factor * table[f"{name} {key}"].to_numpy() for key in ("q5", "q50", "q95"))
    axis.fill_between(hours, low, high, color=BLUE, alpha=0.22, linewidth=0, label="5 % to 95 % of the parts")
    axis.plot(hours, middle, color=BLUE, marker="o", markersize=3, linewidth=1.6, label="median")
    bounds = (factor * table[f"{name} q50{end}"].to_numpy() for end in ("_low", "_high"))
    axis.fill_between(hours, *bounds, color=BLUE, alpha=0.6, linewidth=0)
    for limit in limits.values():
        axis.axhline(factor * limit, color=RED, linewidth=1.4, label="limit")
    axis.set_title(axis_label(name))
    axis.legend(loc="best", fontsize=8)
    _scale(axis, hours)


def _draw_share(axis: Any, hours: np.ndarray, table: pd.DataFrame, broken_share: float) -> None:
    inside, low, high = (100 * table[f"inside{end}"].to_numpy() for end in ("", "_low", "_high"))
    axis.fill_between(hours, low, high, color=GREY, alpha=0.3, linewidth=0, label="95 % interval")
    axis.plot(hours, inside, color="black", marker="o", markersize=3, linewidth=1.6)
    axis.axhline(
        100 * (1 - broken_share), color=RED, linestyle="--", linewidth=1.2, label=f"{100 * (1 - broken_share):.4g} %"
    )
    axis.set_ylim(-3, 103)
    axis.set_title("Parts inside every limit (%)")
    axis.legend(loc="best", fontsize=8)
    _scale(axis, hours)


def _scale(axis: Any, hours: np.ndarray) -> None:
    axis.set_xlim(0.0, hours[-1])
    axis.set_xlabel("running time (h)")


def _mark_life(axis: Any, last: float, life: tuple[float, float, float]) -> None:
    value, low, high = life
    if np.isfinite(low):
        axis.axvspan(low, min(high, last), color=RED, alpha=0.15, linewidth=0)
    if np.isfinite(value):
        axis.axvline(value, color=RED, linestyle=":", linewidth=1.6)
