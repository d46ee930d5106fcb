"""Pictures of a study: distributions, what drives them, and the nominal motion.

Figures are drawn without pyplot, so nothing is left behind in a notebook's state. Colours are those of Okabe and Ito,
which people with any colour vision tell apart. A million samples go into histograms, never into points.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, fontManager
from matplotlib.ft2font import FT2Font
from matplotlib.ticker import MaxNLocator, StrMethodFormatter

from tolmc import quantities
from tolmc.errors import InputError
from tolmc.mechanism.scene import Scene
from tolmc.statistics.drivers import Drivers, Strongest

if TYPE_CHECKING:
    import pandas as pd

BLUE, ORANGE, RED, GREY = "#0072B2", "#E69F00", "#D55E00", "#666666"
_COLOUR = {"D": BLUE, "E": ORANGE}
_STYLE: dict[Any, Any] = {
    "font.size": 10, "axes.titlelocation": "left", "axes.titlesize": 11, "axes.titleweight": "bold", "figure.titlesize": 13,
    "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "axes.axisbelow": True,
    "grid.color": "#e4e4e4", "grid.linewidth": 0.8, "legend.frameon": False,
    "text.hinting": "none",  # a tenth of the time, and letters stand as their font has them
}  # fmt: skip

_SEEN = 20_000  # values that say how far a histogram must reach
_UPRIGHT = 4  # names of so many inputs stand beside each other


# Left to whoever shows figures; a picture is written without a window.
_OF_WINDOWS = ("backend", "backend_fallback", "interactive", "toolbar")
#: Fonts of scripts that Matplotlib's own font lacks, as systems name them.
_FONTS = (
    "Noto Sans CJK JP", "Noto Sans CJK SC", "Noto Sans JP", "Noto Sans SC", "Source Han Sans", "WenQuanYi Micro Hei",
    "WenQuanYi Zen Hei", "IPAexGothic", "IPAGothic", "Droid Sans Fallback", "Microsoft YaHei", "SimHei", "Yu Gothic",
    "MS Gothic", "Malgun Gothic", "PingFang SC", "Hiragino Sans", "Apple SD Gothic Neo", "Arial Unicode MS", "Noto Sans Thai",
    "Noto Sans Devanagari", "Noto Sans Hebrew", "Noto Sans Arabic",
)  # fmt: skip
_MISSING = "\N{WHITE SQUARE}"


@contextmanager
def styled() -> Iterator[None]:
    """Our settings and Matplotlib's own alone: what a user's matplotlibrc says, usetex among it, must not cost a run."""
    own = {key: value for key, value in mpl.rcParamsDefault.items() if key not in _OF_WINDOWS}
    with mpl.rc_context({**own, **_STYLE, "font.family": [font for font, _ in _fonts()]}):
        yield


@cache
def _fonts() -> tuple[tuple[str, frozenset[int]], ...]:
    """The fonts to draw with, and the signs that each has: Matplotlib's own, then those of other scripts that are installed."""
    installed = {entry.name: entry.fname for entry in fontManager.ttflist if entry.name in _FONTS}
    own = "DejaVu Sans"
    files = {
        own: findfont(FontProperties(family=own)),
        **{name: installed[name] for name in _FONTS if name in installed},
    }
    return tuple((name, frozenset(FT2Font(file).get_charmap())) for name, file in files.items())


def _drawable(text: str) -> str:
    """The text with a square for each sign that no font has."""
    plain = " ".join(text.split())
    return "".join(sign if any(ord(sign) in signs for _, signs in _fonts()) else _MISSING for sign in plain)


class Picture(Figure):
    """A figure that a notebook shows without pyplot."""

    def _repr_png_(self) -> bytes:
        buffer = BytesIO()
        with styled():
            FigureCanvasAgg(self).print_png(buffer)
        return buffer.getvalue()


def warm_up() -> None:
    """Load what Matplotlib loads with its first picture, fonts and formulas: 0.04 s of every picture's 0.2 s."""
    with styled():
        figure = Figure()
        axes = figure.subplots()
        axes.plot([0.0, 1.0], label="a line")
        axes.set_xlabel("$x_1$")
        axes.legend()
        figure.savefig(BytesIO(), format="png")


def save(figure: Figure, path: str | Path) -> None:
    """Write a figure; the format follows the file name."""
    formats = FigureCanvasAgg(figure).get_supported_filetypes()
    if Path(path).suffix[1:].lower() not in formats:
        raise InputError(f"{path} has no ending that says what picture it is; allowed: {', '.join(sorted(formats))}.")
    # Half the time of a picture would go into compressing it a few percent further.
    quick: dict[str, Any] = {"pil_kwargs": {"compress_level": 3}} if Path(path).suffix == ".png" else {}
    with styled():  # text is laid out when it is written
        figure.savefig(path, dpi=150, **quick)


def draw_distributions(
    samples: Mapping[str, np.ndarray] | pd.DataFrame,
    outputs: Sequence[str],
    *,
    nominal: Mapping[str, float],
    specification: Mapping[str, Mapping[str, float]],
    title: str,
) -> Figure:
    """Histograms of ``outputs`` with their nominal values and specification limits (SI units).

    Samples without a value are left out.
    """
    columns = min(2, len(outputs))
    rows = -(-len(outputs) // columns)
    height = 0.7 + 3.3 * rows
    with styled():
        figure = Picture(figsize=(5.3 * columns, height))
        heading(figure, f"{title}: {len(samples[outputs[0]]):,} samples")
        axes = figure.subplots(rows, columns, squeeze=False).ravel()
        for axis, name in zip(axes, outputs, strict=False):
            limits = specification.get(name, {}).values()
            _draw_distribution(axis, np.asarray(samples[name]), name, nominal.get(name), limits)
        for axis in axes[len(outputs) :]:
            axis.set_visible(False)
        figure.subplots_adjust(
            left=0.15 / columns, right=0.965, top=1 - 0.95 / height, bottom=0.6 / height, hspace=0.48, wspace=0.22
        )
    return figure


def heading(figure: Figure, title: str) -> None:
    figure.suptitle(
        _drawable(title), y=1 - 0.15 / figure.get_figheight(), va="top", fontweight="bold", parse_math=False
    )


def axis_label(name: str, *, with_unit: bool = True) -> str:
    unit = quantities.shown(name)[0]
    text = quantities.label(name).replace("N_D", "$N_D$").replace("N_E", "$N_E$")
    return f"{text} ({unit})" if with_unit and unit else text


def _draw_distribution(axis, values: np.ndarray, name: str, nominal: float | None, limits: Iterable[float]) -> None:
    unit, factor = quantities.shown(name)
    finite = np.isfinite(values)
    values = values if finite.all() else values[finite]  # no copy of a million values, here or for the unit below
    axis.set_xlabel(axis_label(name))
    axis.set_ylabel("samples per bin (%)")
    if values.size == 0:
        axis.text(0.5, 0.5, "no sample has a value", transform=axis.transAxes, ha="center", color=GREY)
        return
    lines = [(limit * factor, "limit", RED, "-", 1.08) for limit in limits]
    if nominal is not None and np.isfinite(nominal):
        lines.append((nominal * factor, "nominal", "black", "--", 1.01))
    low, high = _span(values, [value / factor for value, *_ in lines])
    bins = min(80, max(10, int(np.sqrt(values.size))))
    counts, edges = np.histogram(values, bins=bins, range=(low, high))
    axis.stairs(100 * counts / values.size, factor * edges, fill=True, color=BLUE, alpha=0.75)
    axis.set_xlim(factor * low, factor * high)
    axis.xaxis.set_major_locator(MaxNLocator(6))
    for value, word, colour, style, height in lines:
        _mark(axis, value, f"{word} {value:.5g} {unit}", colour, style, height)
    outside = values.size - counts.sum()
    if outside:
        axis.text(0.99, 0.97, f"{outside:,} samples off the scale", transform=axis.transAxes, ha="right", va="top",
                  fontsize=8, color=GREY)  # fmt: skip


def _span(values: np.ndarray, marks: list[float]) -> tuple[float, float]:
    """Range of a histogram: the data without a far tail, and the marks that lie near it."""
    low, centre, high = np.quantile(values[:_SEEN], [0.0005, 0.5, 0.9995])
    low = min(max(values.min(), 2.5 * low - 1.5 * centre), centre)
    high = max(min(values.max(), 2.5 * high - 1.5 * centre), centre)
    width = high - low
    for mark in marks:
        if low - width <= mark <= high + width:
            low, high = min(low, mark), max(high, mark)
    # What varies by less than a millionth is a spike, not a distribution.
    margin = max(0.03 * (high - low), 1e-6 * max(abs(low), abs(high)), 1e-30)
    return low - margin, high + margin


def _mark(axis, value: float, text: str, colour: str, style: str, height: float) -> None:
    """A vertical line with its text above the axes; an arrow where the line is off the scale."""
    low, high = axis.get_xlim()
    if low <= value <= high:
        axis.axvline(value, color=colour, linestyle=style, linewidth=1.6)
    elif value > high:
        text = f"{text} →"
    else:
        text = f"← {text}"
    axis.text(
        min(max(value, low), high), height, text, transform=axis.get_xaxis_transform(), color=colour,
        ha="right" if value > (low + high) / 2 else "left", va="bottom", fontsize=9,
    )  # fmt: skip


def draw_drivers(drivers: Drivers, *, title: str) -> Figure:
    """Which input drives which output: rank correlations, and the strongest driver of both force maxima."""
    below = 0.62 if len(drivers.inputs) <= _UPRIGHT else 1.15  # inches for the names of the inputs
    height = max(4.8, 1.3 + below + 0.36 * len(drivers.outputs))
    with styled():
        figure = Picture(figsize=(11.5, height))
        heading(figure, f"{title}: which dimension drives which output")
        if not drivers.inputs:
            figure.text(0.5, 0.5, "no dimension with a tolerance moves an output", ha="center", color=GREY)
            return figure
        grid = figure.add_gridspec(
            2, 2, width_ratios=(1.2, 1), left=0.225, right=0.97, top=1 - 0.95 / height, bottom=below / height,
            hspace=0.55, wspace=0.28,
        )  # fmt: skip
        _draw_correlations(figure.add_subplot(grid[:, 0]), drivers)
        for row, strongest in enumerate(drivers.strongest):
            _draw_scatter(figure.add_subplot(grid[row, 1]), strongest)
    return figure


def _draw_correlations(axis, drivers: Drivers) -> None:
    axis.imshow(drivers.correlations, cmap="PuOr", vmin=-1, vmax=1, aspect="auto")
    axis.grid(False)
    axis.spines[:].set_visible(False)
    axis.set_title("Rank correlation (+ rises, − falls with the input)")
    columns = [axis_label(name, with_unit=False) for name in drivers.inputs]
    rotated = {"rotation": 30, "ha": "right", "rotation_mode": "anchor"} if len(columns) > _UPRIGHT else {}
    axis.set_xticks(range(len(columns)), columns, **rotated)
    axis.set_yticks(range(len(drivers.outputs)), [axis_label(name, with_unit=False) for name in drivers.outputs])
    axis.tick_params(length=0)
    size = 9 if len(columns) <= 8 else 6
    for (row, column), value in np.ndenumerate(drivers.correlations):
        colour = "white" if abs(value) > 0.6 else "black"
        text = "0" if abs(value) < 0.005 else f"{value:+.2f}".replace("-", "−")
        axis.text(column, row, text, ha="center", va="center", color=colour, fontsize=size)


def _draw_scatter(axis, strongest: Strongest) -> None:
    driver, output = strongest.driver, strongest.output
    (_, x_factor), (y_unit, y_factor) = quantities.shown(driver), quantities.shown(output)
    axis.scatter(strongest.x * x_factor, strongest.y * y_factor, s=4, color=BLUE, alpha=0.5, linewidths=0)
    axis.set_title(axis_label(output, with_unit=False))
    axis.set_xlabel(f"strongest driver: {axis_label(driver)}")
    axis.set_ylabel(y_unit)
    axis.xaxis.set_major_locator(MaxNLocator(5))
    axis.yaxis.set_major_locator(MaxNLocator(5))


def draw_trajectory(trajectory, scene: Scene, *, title: str) -> Figure:
    """Traces of the axis points D and E on their circles, their polar angles and contact forces over time.

    ``trajectory`` is a :class:`tolmc.simulation.trajectory.Trajectory`.
    """
    offset = scene.joint_in_operation.half_length * trajectory.axis[:, :2] / trajectory.axis[:, 2:]
    ends = {"D": trajectory.origin + offset, "E": trajectory.origin - offset}
    with styled():
        figure = Picture(figsize=(11.5, 5.2))
        heading(figure, title)
        grid = figure.add_gridspec(
            2, 2, width_ratios=(1, 1.3), left=0.08, right=0.975, top=0.85, bottom=0.11, hspace=0.3, wspace=0.17
        )
        _draw_traces(figure.add_subplot(grid[:, 0]), ends, 1e3 * scene.joint_in_operation.effective_radius)
        upper = figure.add_subplot(grid[0, 1])
        _draw_forces(upper, trajectory)
        upper.tick_params(labelbottom=False)
        lower = figure.add_subplot(grid[1, 1], sharex=upper)
        for name, points in ends.items():
            angle = np.degrees(np.unwrap(np.arctan2(points[:, 1], points[:, 0])))
            lower.plot(trajectory.time, angle, color=_COLOUR[name], linewidth=1.4, label=name)
        for event in trajectory.events[trajectory.events.kind == "impact"]:
            for axis in (upper, lower):
                axis.axvline(event.time, color=RED, linewidth=0.6, alpha=0.5)
        lower.set_title("Polar angles of D and E")
        lower.set_ylabel("α, β (deg)")
        lower.set_xlabel("time (s)")
    return figure


def _draw_traces(axis, ends: dict[str, np.ndarray], radius: float) -> None:
    turn = np.linspace(0, 2 * np.pi, 241)
    axis.plot(radius * np.cos(turn), radius * np.sin(turn), color=GREY, linewidth=1, linestyle="--",
              label=f"circle, r = {radius:.4g} mm")  # fmt: skip
    # Both move on nearly the same circle: E narrower and on top, so that both stay in sight.
    for (name, points), place, width in zip(ends.items(), ("Z = +L", "Z = −L"), (5.0, 1.8), strict=True):
        colour = _COLOUR[name]
        axis.plot(*1e3 * points.T, color=colour, linewidth=width, label=f"{name}, at {place}", solid_capstyle="round")
        axis.plot(*1e3 * points[0], marker="o", color=colour, markersize=9, markeredgecolor="black")
        axis.plot(*1e3 * points[-1], marker="s", color=colour, markersize=8, markeredgecolor="black")
    axis.set_aspect("equal", adjustable="datalim")
    axis.set_title("Traces of D and E (● start, ■ end)")
    axis.set_xlabel("X (mm)")
    axis.set_ylabel("Y (mm)")
    axis.xaxis.set_major_locator(MaxNLocator(5))
    axis.yaxis.set_major_locator(MaxNLocator(5))
    axis.legend(loc="center")


def _draw_forces(axis, trajectory) -> None:
    axis.axhline(0.0, color="black", linewidth=0.8)
    for name, force in zip("DE", trajectory.contact_force.T, strict=True):
        axis.plot(trajectory.time, force, color=_COLOUR[name], linewidth=1.4, label=f"$N_{name}$")
    leaves = not trajectory.closed.all()
    lost = ~trajectory.closed.any(axis=1) if leaves else (trajectory.contact_force < 0).any(axis=1)
    if lost.any():
        axis.fill_between(
            trajectory.time, 0, 1, where=lost, transform=axis.get_xaxis_transform(), color=RED, alpha=0.2,
            linewidth=0, label="free" if leaves else "contact lost",
        )  # fmt: skip
    axis.set_title("Contact forces")
    axis.set_ylabel("N")
    axis.set_xlim(trajectory.time[0], trajectory.time[-1])
    axis.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, borderaxespad=0.2)


def draw_cost_against_yield(
    trade_off: pd.DataFrame, *, winner: tuple[float, float, float], target_ppm: float, is_met: bool, title: str
) -> Figure:
    """Cost of the cheapest tolerances against the parts per million that they leave out of specification.

    Parameters
    ----------
    trade_off : DataFrame
        ``cost``, ``out_ppm``, ``required_yield``: a row a required yield.
    winner : (cost, predicted ppm out, ppm out at the confidence limit)
    target_ppm : float
        Parts per million that may be out of specification.
    is_met : bool
        Whether the winner was shown to keep the target.
    """
    cost, predicted, limit = winner
    with styled():
        figure = Picture(figsize=(7.5, 4.8))
        heading(figure, f"{title}: cost against yield")
        axis = figure.add_axes((0.1, 0.13, 0.83, 0.68))
        # Linear below one part per million: a choice without any predicted failure stays in the picture.
        axis.set_xscale("symlog", linthresh=1.0, linscale=0.5)
        axis.set_xlim(-0.2, 1e6)
        axis.xaxis.set_major_formatter(StrMethodFormatter("{x:,.0f}"))
        steps = trade_off.sort_values("out_ppm")
        axis.plot(steps["out_ppm"], steps["cost"], color=BLUE, marker="o", linewidth=1.4, label="cheapest, predicted")
        label = "chosen" if is_met else "not shown to suffice"
        axis.plot(predicted, cost, color=RED, marker="D", markersize=8, linestyle="none", label=label)
        axis.plot([predicted, limit], [cost, cost], color=RED, marker="|", markersize=14, markevery=[1], linewidth=2.5,
                  alpha=0.7, label="its confidence limit")  # fmt: skip
        axis.axvline(target_ppm, color="black", linestyle="--", linewidth=1.2)
        axis.text(target_ppm, 1.01, f"allowed {target_ppm:,.0f} ppm", transform=axis.get_xaxis_transform(), ha="center")
        axis.set_xlabel("out of specification (parts per million)")
        axis.set_ylabel("cost")
        axis.yaxis.set_major_locator(MaxNLocator(6))
        axis.margins(y=0.1)
        axis.legend(loc="lower left", bbox_to_anchor=(0.0, 1.06), ncols=3, borderaxespad=0.0, columnspacing=1.5)
    return figure
