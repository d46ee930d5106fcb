"""Terminal tables: engineering units, sensible digits, every estimate with its interval."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import pandas as pd
from rich import box
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from tolmc import units
from tolmc.section_estimate import section_error_estimate

_CHECKS = ("energy_error", "constraint_error")
_DIGITS = 5


def estimate_text(value: float, low: float, high: float, digits: int = _DIGITS) -> str:
    """An estimate, and below it the half-width of its interval to two digits, as far as the estimate's digits go.

    The estimate has at most ``digits`` significant ones; an interval without an end is called open.
    """
    if math.isnan(value):
        return "–"
    half = max(high - value, value - low)
    decimals = digits - 1 - (math.floor(math.log10(abs(value))) if value else 0)
    if 0 < half < math.inf:
        decimals = min(decimals, 1 - math.floor(math.log10(half)))
    text = f"{value:.{decimals}f}" if 0 <= decimals <= 7 else f"{value:.{digits if decimals < 0 else 2}g}"
    if math.isinf(half):
        return f"{text}\n[dim]open[/]"
    if half < 0.5 * 10**-decimals:
        return text
    spread = f"{half:.{decimals}f}" if 0 <= decimals <= 5 else f"{half:.1g}"
    return f"{text}\n[dim]±{spread}[/]"


def number_text(value: float) -> str:
    """A number to five digits."""
    return "–" if value is None or math.isnan(value) else f"{value:.5g}"


def share_text(value: float) -> str:
    """A share in percent, or in parts per million where that reads better."""
    if math.isnan(value):
        return "–"
    if value == 0 or value >= 1e-3:
        return f"{100 * value:.3g} %"
    return f"{1e6 * value:.3g} ppm"


def print_result(result, console: Console | None = None) -> None:
    """The summary of a run: outputs, requirements, what became of the samples, error budget, where it is."""
    console = console or Console()
    study = result.study
    console.print(
        f"\n[bold]{escape(study.title)}[/]: {study.samples:,} samples, {study.sampling.replace('_', ' ')}, seed {study.seed}"
        f" ({result.elapsed:.1f} s)"
    )
    console.print(summary_table(result.summary))
    console.print(requirement_table(result.requirements))
    console.print(status_table(result.statuses))
    if not math.isnan(result.plan.pilot_error):
        console.print(budget_table(result.summary))
    if study.scene.joint.section == "circle" and any(name.startswith("contact_force") for name in result.summary.index):
        share = section_error_estimate(study.scene.joint)["contact_force"]
        console.print(
            "\n[bold]Circle or exact section[/]: on this joint the circle of constant radius misstates contact-force peaks "
            f"by up to about {share_text(share)} in nine motions of ten; --compare-section measures it.",
            highlight=False,
        )
    if result.directory is not None:
        console.print(
            f"Written: {escape(str(result.directory))} (samples.parquet, summary.csv, pictures)", soft_wrap=True
        )


def summary_table(summary: pd.DataFrame) -> Table:
    """Mean, sd and quantiles of every output, from :func:`tolmc.statistics.summarise`."""
    table = _table(
        "Output", "mean", "sd", "0.135 %", "median", "99.865 %",
        title="Outputs with 95 % intervals (±, where it reaches the digits shown)",
    )  # fmt: skip
    for name, row in summary.iterrows():
        if name in _CHECKS or row["used"] == 0:
            continue
        unit, factor = units.shown(name)
        estimates = (
            estimate_text(*(factor * row[f"{key}{end}"] for end in ("", "_low", "_high")), digits)
            for key, digits in (
                ("mean", _DIGITS),
                ("sd", 4),
                ("q0.135", _DIGITS),
                ("q50", _DIGITS),
                ("q99.865", _DIGITS),
            )
        )
        table.add_row(f"{units.label(name)}\n[dim]{unit}[/]", *estimates)
    return table


def requirement_table(requirements: pd.DataFrame) -> Table:
    """Share out of specification, from :func:`tolmc.statistics.summarise_requirements`."""
    # Here, because statistics load SciPy's optimisers, a quarter of a second that the table of a motion need not pay.
    from tolmc.statistics import ANY_REQUIREMENT, CONTACT_LOSS

    table = _table("Requirement", "limits", "out", "share out", "95 % interval", title="Requirements")
    for name, row in requirements.iterrows():
        if name == CONTACT_LOSS:
            label, limits = "Contact lost", ""
        elif name == ANY_REQUIREMENT:
            label, limits = "Any requirement broken", ""
        else:
            label, limits = units.label(name), _limits_text(name, row["minimum"], row["maximum"])
        least, most = share_text(row["share_least"]), share_text(row["share_most"])
        table.add_row(
            label,
            limits,
            f"{int(row['out']):,}",
            least if least == most else f"{least} to {most}",
            f"{share_text(row['share_least_low'])} to {share_text(row['share_most_high'])}",
        )
    return table


def _limits_text(name: str, minimum: float, maximum: float) -> str:
    unit, factor = units.shown(name)
    ends = [f"≥ {number_text(minimum * factor)}"] if not np.isnan(minimum) else []
    ends += [f"≤ {number_text(maximum * factor)}"] if not np.isnan(maximum) else []
    return f"{' and '.join(ends)} {unit}"


def status_table(statuses: pd.DataFrame) -> Table:
    """What became of the samples, from :func:`tolmc.statistics.count_statuses`."""
    table = _table("Status", "samples", "share", title="What became of the samples")
    for status, row in statuses.iterrows():
        table.add_row(str(status), f"{int(row['count']):,}", share_text(row["share"]))
    return table


def budget_table(summary: pd.DataFrame) -> Table:
    """Integration error beside the sampling intervals' half-widths, from :func:`tolmc.statistics.error_budget`."""
    from tolmc.statistics import error_budget

    table = _table("Output", "unit", "integration", "mean", "sd", "99.865 %", title="Error budget (±)")
    for name, row in error_budget(summary).iterrows():
        if np.isnan(row["integration"]):
            continue
        unit, factor = units.shown(name)
        cells = (f"{row[key] * factor:.2g}".replace("inf", "open") for key in ("integration", "mean", "sd", "q99.865"))
        table.add_row(units.label(name), unit, *cells)
    return table


def print_comparison(comparison: pd.DataFrame, console: Console | None = None) -> None:
    """Circle against exact section, every statistic and share of :func:`tolmc.section_comparison.compare_sections`."""
    console = console or Console()
    differences = comparison["difference_percent"].unstack("statistic", sort=False)
    if "mean" in differences:
        outputs = differences[differences["mean"].notna()]
        moments = {"mean": "mean", "sd": "sd", "min": "min", "max": "max"}
        quantiles = {"q0.135": "0.135 %", "q5": "5 %", "q50": "median", "q95": "95 %", "q99.865": "99.865 %"}
        console.print(
            _difference_table(outputs, moments, title="Circle less exact section, in percent of the exact value")
        )
        console.print(_difference_table(outputs, quantiles, title="The same for the quantiles"))
    console.print(_share_difference_table(comparison))


def _difference_table(differences: pd.DataFrame, statistics: Mapping[str, str], *, title: str) -> Table:
    table = _table("Output", *statistics.values(), title=title)
    for output, row in differences[list(statistics)].iterrows():
        table.add_row(units.label(output), *("–" if np.isnan(value) else f"{value:+.3g}" for value in row))
    return table


def _share_difference_table(comparison: pd.DataFrame) -> Table:
    """Requirements, between two bounds where failed samples leave their shares open, and statuses."""
    from tolmc.statistics import ANY_REQUIREMENT, CONTACT_LOSS

    table = _table("Share of the samples", "circle", "exact", "difference", title="Requirements and statuses")
    ends = {"share_least": ", at least", "share_most": ", at most"}
    for (output, statistic), row in comparison.iterrows():
        if output == "status":
            label = f"Status {statistic}"
        elif statistic in ends:
            is_settled = comparison.loc[(output, "share_least")].equals(comparison.loc[(output, "share_most")])
            if is_settled and statistic == "share_most":
                continue
            label = {CONTACT_LOSS: "Contact lost", ANY_REQUIREMENT: "Any requirement broken"}.get(
                output, f"{units.label(output)}, out"
            ) + ("" if is_settled else ends[statistic])
        else:
            continue
        sign = "+" if row["difference"] > 0 else "−" if row["difference"] < 0 else ""
        difference = f"{sign}{share_text(abs(row['difference']))}"
        table.add_row(label, share_text(row["circle"]), share_text(row["exact"]), difference)
    return table


def print_answers(stackup: pd.DataFrame, console: Console | None = None) -> None:
    """Worst case, root sum square, Monte Carlo and accelerated estimate: :func:`tolmc.stackup.side_by_side`."""
    kinds = {
        "worst_case": "worst",
        "root_sum_square": "RSS",
        "monte_carlo": "MC",
        "accelerated": "accel.",
    }
    table = _table(
        "Output",
        *kinds.values(),
        "RSS off by",
        title="Worst case, root sum square (RSS), Monte Carlo (MC), accelerated; off: in % of the spread",
    )
    for output in stackup.index.get_level_values("output").unique():
        unit, scale = units.shown(output)
        table.add_row(f"[bold]{units.label(output)}[/] ({unit})" if unit else f"[bold]{units.label(output)}[/]")
        for quantity, row in stackup.loc[output].iterrows():
            values = [number_text(row[kind] * scale) if kind in row else "–" for kind in kinds]
            misleads = str(row["verdict"]).startswith("root sum square misleads")
            error = "–" if np.isnan(row["error_percent"]) else f"{row['error_percent']:+.2g} %"
            table.add_row(f"  {quantity}", *values, f"[bold red]{error}[/]" if misleads else error)
    (console or Console()).print(table)


def print_trajectory(trajectory, scene, *, title: str, console: Console | None = None) -> None:
    """A motion at some instants, the extremes of its contact forces, and its status."""
    console = console or Console()
    table = _table("t, s", "X0, mm", "Y0, mm", "tilt, deg", "N_D, N", "N_E, N", title=title)
    for i in np.unique(np.linspace(0, len(trajectory.time) - 1, 11).round().astype(int)):
        table.add_row(
            f"{trajectory.time[i]:.4g}",
            *(f"{1e3 * x:.5f}" for x in trajectory.origin[i]),
            f"{np.degrees(trajectory.tilt[i]):.4f}",
            *(f"{force:.5g}" for force in trajectory.contact_force[i]),
        )
    console.print(table)
    joint = scene.joint
    console.print(
        f"Largest tilt the clearance allows: {np.degrees(joint.tilt_angle):.7g} deg; "
        f"r = {1e3 * joint.effective_radius:.7g} mm (R* − r* = {1e3 * joint.approximate_radius:.7g} mm)"
    )
    for name, force in zip(("N_D", "N_E"), trajectory.contact_force.T, strict=True):
        console.print(f"{name} at the stored instants: {force.min():.5g} to {force.max():.5g} N")
    console.print(f"Status: {escape(trajectory.status)}")


def print_sample(row: Mapping[str, object], console: Console | None = None) -> None:
    """One row of a run: its inputs and outputs."""
    console = console or Console()
    table = _table("Quantity", "value", "unit", title="The sample in the run")
    for name, value in row.items():
        if name == "status":
            table.add_row("Status", str(value), "")
        else:
            unit, factor = units.shown(name)
            table.add_row(units.label(name), number_text(value * factor), unit)
    console.print(table)


def _table(*columns: str, title: str) -> Table:
    table = Table(title=escape(title), title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, pad_edge=False)
    for i, column in enumerate(columns):
        table.add_column(column, justify="left" if i == 0 or column == "unit" else "right", no_wrap=True)
    return table
