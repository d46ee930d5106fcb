"""Terminal tables: engineering units, sensible digits, every estimate with its interval."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np
import pandas as pd
from rich import box
from rich.console import Console, ConsoleOptions
from rich.markup import escape
from rich.measure import Measurement
from rich.table import Table

from tolmc import quantities
from tolmc.mechanism.circle_error import section_error_sentence
from tolmc.text.numbers import NEGLIGIBLE, fixed, without_rounding_errors

_DIGITS = 5
#: Columns of the summary table, and their digits.
_ESTIMATES = {"mean": _DIGITS, "sd": 4, "q0.135": _DIGITS, "q50": _DIGITS, "q99.865": _DIGITS}
#: Wider than any table.
_UNLIMITED = 10_000


def estimate_text(value: float, low: float, high: float, digits: int = _DIGITS, *, between: str = "\n") -> str:
    """An estimate, and below it the half-width of its interval to two digits, as far as the estimate's digits go.

    The estimate has at most ``digits`` significant ones; an interval without an end is called open. ``between`` parts the
    two.
    """
    if math.isnan(value):
        return "–"
    half = max(high - value, value - low)
    decimals = digits - 1 - (math.floor(math.log10(abs(value))) if value else 0)
    if 0 < half < math.inf:
        decimals = min(decimals, 1 - math.floor(math.log10(half)))
    if value == 0 and not 0 < half < math.inf:
        text = "0"
    else:
        text = fixed(value, decimals) if 0 <= decimals <= 7 else f"{value:.{digits if decimals < 0 else 2}g}"
    if math.isinf(half):
        return f"{text}{between}[dim]open[/]"
    if half < 0.5 * 10**-decimals:
        return text
    spread = f"{half:.{decimals}f}" if 0 <= decimals <= 5 else f"{half:.1g}"
    return f"{text}{between}[dim]±{spread}[/]"


def number_text(value: float) -> str:
    """A number to five digits."""
    return "–" if value is None or math.isnan(value) else f"{value + 0.0:.5g}"  # no -0


def share_text(value: float) -> str:
    """A share in percent, or in parts per million where that reads better."""
    if math.isnan(value):
        return "–"
    if value == 0 or value >= 1e-3:
        return f"{100 * value:.3g} %"
    return f"{1e6 * value:.3g} ppm"


def print_result(result, console: Console | None = None) -> None:
    """The summary of a run: outputs, requirements, what became of the samples, error budget, where it is."""
    console = console or standard_output()
    study = result.study
    console.print(
        f"\n[bold]{escape(study.title)}[/]: {study.samples:,} samples, {study.sampling.replace('_', ' ')}, seed {study.seed}"
        f" ({result.elapsed:.1f} s)"
    )
    console.print(summary_table(result.summary))
    console.print(requirement_table(result.requirements))
    for sentence in _contact_notes(result):
        console.print(sentence, highlight=False)
    console.print(status_table(result.statuses))
    if result.plan.unresolved:
        console.print(unresolved_text(result.plan.unresolved), highlight=False)
    if not math.isnan(result.plan.pilot_error):
        console.print(budget_table(result.summary))
    if study.scene.joint.section == "circle" and any(
        quantities.of(name).kind == "force" for name in result.summary.index
    ):
        sentence = section_error_sentence(study.scene.joint)
        console.print(f"\n[bold]Circle or exact section[/]: {sentence}", highlight=False)
    if result.directory is not None:
        console.print(
            f"Written: {escape(str(result.directory))} (samples.parquet, summary.csv, pictures)", soft_wrap=True
        )


def _contact_notes(result) -> Iterator[str]:
    from tolmc.statistics.outcomes import ANY_REQUIREMENT, CONTACT_LOSS

    lost = result.requirements.loc[CONTACT_LOSS]
    if lost["out"] and result.study.on_contact_loss == "stop":
        share = share_text(lost["share_least"])
        yield f"In {share} of the samples contact is lost: outputs of the motion hold up to that instant."
    if result.study.specification and result.requirements.at[ANY_REQUIREMENT, "unknown"]:
        yield "What is not known to keep its limits (motion not computed, or contact lost before) is counted both ways."


def unresolved_text(motions: int) -> str:
    """What it means that the pilot has set motions aside."""
    return (
        f"[bold]Step[/]: {motions} of the motions at the nominal and corner dimensions met the accuracy with no step (a "
        "clearance near zero, or a chaotic motion). Every sample was therefore integrated twice and judged by the difference; "
        "those that miss the accuracy have status inaccurate."
    )


def summary_table(summary: pd.DataFrame) -> Grid:
    """Mean, sd and quantiles of every output, from :func:`tolmc.statistics.summary.summarise`."""
    table = Grid(
        "Output", "mean", "sd", "0.135 %", "median", "99.865 %",
        title="Outputs with 95 % intervals (±, where it reaches the digits shown)",
    )  # fmt: skip
    shown = summary[(summary["used"] > 0) & ~summary.index.isin(quantities.CHECKS)]
    estimates = [f"{key}{end}" for key in _ESTIMATES for end in ("", "_low", "_high")]
    for name, row in without_rounding_errors(shown, estimates).iterrows():
        unit, factor = quantities.shown(name)
        estimates = (
            estimate_text(*(factor * row[f"{key}{end}"] for end in ("", "_low", "_high")), digits)
            for key, digits in _ESTIMATES.items()
        )
        table.add_row(f"{quantities.label(name)}\n[dim]{unit}[/]", *estimates)
    return table


def requirement_table(requirements: pd.DataFrame) -> Grid:
    """Share out of specification, from :func:`tolmc.statistics.summary.summarise_requirements`."""
    # Here, because statistics load SciPy's optimisers, a quarter of a second that the table of a motion need not pay.
    from tolmc.statistics.outcomes import ANY_REQUIREMENT, CONTACT_LOSS

    table = Grid("Requirement", "limits", "out", "share out", "95 % interval", title="Requirements")
    for name, row in requirements.iterrows():
        if name == CONTACT_LOSS:
            label, limits = "Contact lost", ""
        elif name == ANY_REQUIREMENT:
            label, limits = "Any requirement broken", ""
        else:
            label, limits = quantities.label(name), _limits_text(name, row["minimum"], row["maximum"])
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
    unit, factor = quantities.shown(name)
    ends = [f"≥ {number_text(minimum * factor)}"] if not np.isnan(minimum) else []
    ends += [f"≤ {number_text(maximum * factor)}"] if not np.isnan(maximum) else []
    return f"{' and '.join(ends)} {unit}"


def status_table(statuses: pd.DataFrame) -> Grid:
    """What became of the samples, from :func:`tolmc.statistics.summary.count_statuses`."""
    table = Grid("Status", "samples", "share", title="What became of the samples")
    for status, row in statuses.iterrows():
        table.add_row(str(status), f"{int(row['count']):,}", share_text(row["share"]))
    return table


def budget_table(summary: pd.DataFrame) -> Grid:
    """Integration error beside the sampling intervals' half-widths, from :func:`tolmc.statistics.summary.error_budget`."""
    from tolmc.statistics.summary import error_budget

    table = Grid("Output", "unit", "integration", "mean", "sd", "99.865 %", title="Error budget (±)")
    for name, row in error_budget(summary).iterrows():
        if np.isnan(row["integration"]):
            continue
        unit, factor = quantities.shown(name)
        cells = (f"{row[key] * factor:.2g}".replace("inf", "open") for key in ("integration", "mean", "sd", "q99.865"))
        table.add_row(quantities.label(name), unit, *cells)
    return table


def print_comparison(comparison: pd.DataFrame, console: Console | None = None) -> None:
    """Circle against exact section, every statistic and share of :func:`tolmc.commands.compare_sections.compare_sections`."""
    console = console or standard_output()
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


def _difference_table(differences: pd.DataFrame, statistics: Mapping[str, str], *, title: str) -> Grid:
    table = Grid("Output", *statistics.values(), title=title)
    for output, row in differences[list(statistics)].iterrows():
        table.add_row(quantities.label(output), *("–" if np.isnan(value) else f"{value:+.3g}" for value in row))
    return table


def _share_difference_table(comparison: pd.DataFrame) -> Grid:
    """Requirements, between two bounds where failed samples leave their shares open, and statuses."""
    from tolmc.statistics.outcomes import ANY_REQUIREMENT, CONTACT_LOSS

    table = Grid("Share of the samples", "circle", "exact", "difference", title="Requirements and statuses")
    ends = {"share_least": ", at least", "share_most": ", at most"}
    for (output, statistic), row in comparison.iterrows():
        if output == "status":
            label = f"Status {statistic}"
        elif statistic in ends:
            is_settled = comparison.loc[(output, "share_least")].equals(comparison.loc[(output, "share_most")])
            if is_settled and statistic == "share_most":
                continue
            label = {CONTACT_LOSS: "Contact lost", ANY_REQUIREMENT: "Any requirement broken"}.get(
                output, f"{quantities.label(output)}, out"
            ) + ("" if is_settled else ends[statistic])
        else:
            continue
        sign = "+" if row["difference"] > 0 else "−" if row["difference"] < 0 else ""
        difference = f"{sign}{share_text(abs(row['difference']))}"
        table.add_row(label, share_text(row["circle"]), share_text(row["exact"]), difference)
    return table


def print_answers(
    stackup: pd.DataFrame,
    yields: pd.DataFrame | None = None,
    notes: Iterable[str] = (),
    console: Console | None = None,
) -> None:
    """The tables of :class:`tolmc.commands.answers.Answers`: four answers side by side, and the yield by two of them."""
    console = console or standard_output()
    console.print(_answers_table(stackup))
    if yields is not None:
        console.print(_yields_table(yields))
    for sentence in [*_answers_notes(stackup), *notes]:
        console.print(escape(sentence), highlight=False)


def _answers_table(stackup: pd.DataFrame) -> Grid:
    estimated = [f"{kind}{end}" for kind in ("monte_carlo", "accelerated") for end in ("", "_low", "_high")]
    shown = without_rounding_errors(stackup, ["worst_case", "root_sum_square", *estimated])
    table = Grid(
        "Output", "worst", "RSS", "MC", "accelerated", "verdict",
        title="Worst case, root sum square (RSS), Monte Carlo (MC), accelerated; 95 % intervals (±); % of the spread",
    )  # fmt: skip
    for output in shown.index.get_level_values("output").unique():
        unit, factor = quantities.shown(output)
        answers = shown.loc[output]
        title = f"[bold]{quantities.label(output)}[/] ({unit})" if unit else f"[bold]{quantities.label(output)}[/]"
        table.add_row(title, "", "", "", _surrogate_text(answers.iloc[0]))
        for quantity, row in answers.iterrows():
            table.add_row(
                f"  {quantity}",
                *(number_text(row[kind] * factor) for kind in ("worst_case", "root_sum_square")),
                *(
                    estimate_text(*(factor * row[f"{kind}{end}"] for end in ("", "_low", "_high")), between=" ")
                    for kind in ("monte_carlo", "accelerated")
                ),
                _answer_verdict(row),
            )
    return table


def _yields_table(yields: pd.DataFrame) -> Grid:
    table = Grid("Requirement", "Monte Carlo", "accelerated", title="Yield, % of the parts, with 95 % intervals")
    for name, row in yields.iterrows():
        table.add_row(
            quantities.label(name),
            *(
                f"{number_text(100 * row[kind])} [dim]({number_text(100 * row[f'{kind}_low'])} to "
                f"{number_text(100 * row[f'{kind}_high'])})[/]"
                for kind in ("monte_carlo", "accelerated")
            ),
        )
    return table


def _surrogate_text(row: pd.Series) -> str:
    """Degree and held-out error of the surrogate behind the accelerated estimate."""
    if math.isnan(row["accelerated_degree"]):
        return ""
    error = row["accelerated_held_out"]
    return f"[dim]degree {row['accelerated_degree']:.0f}{'' if math.isnan(error) else f', error {error:.1g}'}[/]"


def _answer_verdict(row: pd.Series) -> str:
    parts = [f"RSS {row['root_sum_square_is']}"]
    if not math.isnan(row["error_percent"]):
        parts[0] += f" ({_percent_text(row['error_percent'], '+')})"
    worst = {
        "wider": f"worst {_percent_text(max(row['excess_percent'], 0.0))} wider",
        "exceeded": f"worst exceeded by {_percent_text(row['beyond_percent'])}",
        "not known": "worst not known",
    }
    if row["worst_case_is"] in worst:
        parts.append(worst[row["worst_case_is"]])
    misleads = row["root_sum_square_is"] == "misleads" or row["worst_case_is"] in ("exceeded", "not known")
    return f"[bold red]{', '.join(parts)}[/]" if misleads else ", ".join(parts)


def _percent_text(value: float, sign: str = "") -> str:
    return f"{value:{sign}.{'0f' if abs(value) > 99 else '2g'}} %"


def _answers_notes(stackup: pd.DataFrame) -> Iterator[str]:
    """What the columns cannot say: a worst case that is not known or exceeded, and the accelerated estimate's grounds."""
    limits = stackup.loc[stackup["worst_case_is"].isin(("exceeded", "not known")), "verdict"]
    sentences: dict[str, list[str]] = {}
    for (output, quantity), verdict in limits.items():
        sentence = verdict.partition("; ")[2]
        sentences.setdefault(sentence, []).append(f"{quantities.label(output)}, {quantity}")
    limits_of_all = 2 * stackup.index.get_level_values("output").nunique()
    for sentence, places in sentences.items():
        where = "every limit" if len(places) == limits_of_all else "; ".join(places)
        yield f"{sentence[0].upper()}{sentence[1:]} ({where})."
    missing = stackup["accelerated_missing"].iloc[0]
    if missing:
        yield f"No accelerated estimate: {missing}"
    else:
        yield (
            "Accelerated: a polynomial of the degree shown, corrected by true motions; error: its held-out error over the "
            "output's spread."
        )


def print_trajectory(trajectory, scene, *, title: str, console: Console | None = None) -> None:
    """A motion at some instants, the extremes of its contact forces, and its status."""
    console = console or standard_output()
    table = Grid("t, s", "X0, mm", "Y0, mm", "tilt, deg", "N_D, N", "N_E, N", title=title)
    forces = np.where(
        np.abs(trajectory.contact_force) < NEGLIGIBLE * np.nanmax(np.abs(trajectory.contact_force), initial=0.0),
        0.0,
        trajectory.contact_force,
    )
    for i in np.unique(np.linspace(0, len(trajectory.time) - 1, 11).round().astype(int)):
        table.add_row(
            f"{trajectory.time[i]:.4g}",
            *(fixed(1e3 * x, 5) for x in trajectory.origin[i]),
            fixed(np.degrees(trajectory.tilt[i]), 4),
            *(number_text(force) for force in forces[i]),
        )
    console.print(table)
    joint = scene.joint
    console.print(
        f"Largest tilt the clearance allows: {np.degrees(joint.tilt_angle):.7g} deg; "
        f"r = {1e3 * joint.effective_radius:.7g} mm (R* − r* = {1e3 * joint.approximate_radius:.7g} mm)"
    )
    for name, force in zip(("N_D", "N_E"), forces.T, strict=True):
        console.print(f"{name} at the stored instants: {number_text(force.min())} to {number_text(force.max())} N")
    console.print(f"Status: {escape(trajectory.status)}")


def print_sample(row: Mapping[str, object], console: Console | None = None) -> None:
    """One row of a run: its inputs and outputs."""
    console = console or standard_output()
    table = Grid("Quantity", "value", "unit", title="The sample in the run")
    for name, value in row.items():
        if name == "status":
            table.add_row("Status", str(value), "")
        else:
            unit, factor = quantities.shown(name)
            table.add_row(quantities.label(name), number_text(value * factor), unit)
    console.print(table)


def standard_output() -> Console:
    """The console of standard output; a pipe or a file has no width that a table must fit."""
    console = Console()
    return console if console.is_terminal else Console(width=_UNLIMITED)


class Grid:
    """A table that is never cut: columns that do not fit stand below, beside the first column again."""

    def __init__(self, *columns: str, title: str) -> None:
        self.columns, self.title, self.rows = columns, title, []

    def add_row(self, *cells: str) -> None:
        self.rows.append((*cells, *[""] * (len(self.columns) - len(cells))))

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[Table]:
        part = [0]
        for column in range(1, len(self.columns)):
            if len(part) > 1 and self._width([*part, column], console, options) > options.max_width:
                yield self._part(part)
                part = [0]
            part.append(column)
        yield self._part(part)

    def _width(self, part: Sequence[int], console: Console, options: ConsoleOptions) -> int:
        return Measurement.get(console, options.update(width=_UNLIMITED), self._part(part)).maximum

    def _part(self, part: Sequence[int]) -> Table:
        title = escape(self.title) if 1 in part or len(self.columns) == 1 else None
        table = Table(title=title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, pad_edge=False)
        for i in part:
            is_text = i == 0 or self.columns[i] in ("unit", "verdict")
            table.add_column(self.columns[i], justify="left" if is_text else "right", overflow="fold")
        for row in self.rows:
            table.add_row(*(row[i] for i in part))
        return table
