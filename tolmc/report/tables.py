"""The tables of a report: numbers of a run as texts in cells, and as frames for CSV files."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from tolmc import quantities
from tolmc.analysis.from_samples import INTERACTIONS, contributions
from tolmc.quantities import SCALARS
from tolmc.report import words
from tolmc.statistics.capability import ALL_REQUIREMENTS
from tolmc.statistics.intervals import Estimate
from tolmc.statistics.outcomes import ANY_REQUIREMENT, CONTACT_LOSS
from tolmc.statistics.summary import error_budget
from tolmc.study.study import Study
from tolmc.text.numbers import fixed, without_rounding_errors
from tolmc.tolerances import fits

#: Outputs that check the integration; they have a sentence in the report, not a row.
INDICES = ("Cp", "Cpk", "Pp", "Ppk")
STATISTICS = {"mean": "mean", "sd": "sd", "q0.135": "0.135 %", "q50": "median", "q99.865": "99.865 %"}
#: Dimensions that have a column of their own: more do not fit on a page.
_COLUMNS = 6
_EVENTS = {ANY_REQUIREMENT: "Any requirement broken", CONTACT_LOSS: "Contact lost", "failed": "Motion not computed"}


@dataclass(frozen=True)
class Cell:
    """A cell: its text, a second line in small print, deviations in the manner of a drawing, and more for the eye.

    ``bar`` is a share from 0 to 1 that is drawn behind the text, ``tone`` one of "good", "bad", "open".
    """

    text: str
    detail: str = ""
    deviations: tuple[str, ...] = ()
    bar: float | None = None
    tone: str = ""

    @property
    def plain(self) -> str:
        """The cell in one line."""
        text = " ".join([self.text, "/".join(self.deviations)]).strip()
        return f"{text} ({self.detail})" if self.detail else text


@dataclass(frozen=True)
class Table:
    """A table of the report; ``name`` is that of its CSV file, ``frame`` its content."""

    name: str
    caption: str
    header: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    frame: pd.DataFrame = field(repr=False)
    #: Columns that hold words and stand to the left; all others hold numbers.
    left: tuple[int, ...] = (0,)

    @property
    def alignment(self) -> tuple[str, ...]:
        """What Markdown has below the header."""
        return tuple(":--" if i in self.left else "--:" for i in range(len(self.header)))

    def __bool__(self) -> bool:
        return bool(self.rows)


def _cells(values: Iterable[Cell | str | tuple[str, str]]) -> tuple[Cell, ...]:
    return tuple(v if isinstance(v, Cell) else Cell(v) if isinstance(v, str) else Cell(*v) for v in values)


def _named(name: str, detail: str = "") -> Cell:
    return Cell(quantities.label(name), detail)


def dimensions_table(study: Study) -> Table:
    """Nominal values, limits and distributions, on the diameter where a drawing gives that."""
    classes = _tolerance_classes(study)
    rows, frame = [], {}
    for dimension in study.tolerances.dimensions:
        unit, factor = quantities.shown(dimension.name)
        nominal, low, high = (factor * x for x in (dimension.nominal, dimension.lower, dimension.upper))
        on_drawing = _on_drawing(dimension.name, nominal, low, high, classes)
        rows.append(
            _cells(
                (
                    _named(dimension.name),
                    on_drawing,
                    Cell(words.number(nominal, 8), deviations=words.deviations(nominal, low, high)),
                    Cell(
                        words.span(low, high) if high > low else words.number(nominal, 8),
                        _in_rpm(study, dimension.name, dimension.lower, dimension.upper),
                    ),
                    unit,
                    words.distribution(dimension),
                )
            )
        )
        frame[dimension.name] = {
            "unit": unit,
            "drawing": on_drawing.plain,
            "nominal": nominal,
            "lower_limit": low,
            "upper_limit": high,
            "mean": factor * dimension.mean,
            "sd": factor * dimension.sd,
            "distribution": words.distribution(dimension),
        }
    return Table(
        "dimensions",
        "Dimensions that vary from part to part, as drawn (diameter, length) and as the model takes them (radius, half "
        "length), and what the parts were assumed to follow between the limits.",
        ("Dimension", "on the drawing", "in the model", "limits", "unit", "distribution of the parts"),
        tuple(rows),
        pd.DataFrame.from_dict(frame, orient="index").rename_axis("dimension"),
        left=(0, 4, 5),
    )


def _in_rpm(study: Study, name: str, *values: float) -> str:
    """Values of an angular velocity as a study that is written in rpm has them."""
    if quantities.unit(name) != "rad/s" or "rpm" not in study.source:
        return ""
    ends = dict.fromkeys(words.number(value * 30 / math.pi, 6) for value in values)
    return f"{' to '.join(ends)} rpm"


def _tolerance_classes(study: Study) -> dict[str, str]:
    """ISO 286 classes that the study names: {"bearing_radius": "40 H7"}."""
    table = tomllib.loads(study.source)["dimensions"]
    classes = {
        name: _class_text(fits.size_limits(entry["diameter"])[0], entry["diameter"])
        for name, entry in table.items()
        if isinstance(entry, dict) and "diameter" in entry
    }
    if "fit" in table:
        fit = fits.fit(table["fit"])
        hole, shaft = fit.designation.split("/")
        of_hole = _class_text(fit.size, hole)
        classes |= {"bearing_radius": of_hole, "journal_radius": f"{of_hole.split()[0]} {shaft.strip()}"}
    return classes


def _class_text(size: float, designation: str) -> str:
    """Size (m) and class as a drawing has them: ``40 H7``, however the study writes "⌀ 40mmH7"."""
    tolerance_class = re.sub(r"^\D*[\d.]+\s*(?:mm)?\s*", "", designation)
    return f"{words.number(1e3 * size, 8)} {tolerance_class.strip()}"


def _on_drawing(name: str, nominal: float, low: float, high: float, classes: Mapping[str, str]) -> Cell:
    sign = "⌀" if name in ("bearing_radius", "journal_radius") else ""
    if name in classes:
        return Cell(f"{sign}{classes[name]}")
    if not sign and name != "half_length":
        return Cell(words.NOTHING)
    return Cell(f"{sign}{words.number(2 * nominal, 8)}", deviations=words.deviations(2 * nominal, 2 * low, 2 * high))


def constants_table(study: Study) -> Table:
    """Scalars of the scene that are the same in every sample and not zero."""
    varied = study.tolerances.names
    held = {name: value for name, value in study.scene.scalars.items() if name not in varied and value != 0}
    held = {name: held[name] for name in SCALARS if name in held}
    rows = tuple(
        _cells((_named(name), Cell(words.quantity(name, value), _in_rpm(study, name, value))))
        for name, value in held.items()
    )
    frame = pd.DataFrame(
        {"unit": [quantities.unit(name) for name in held], "value": list(held.values())},
        index=pd.Index(held, name="quantity"),
    )
    return Table(
        "constants", "The same in every sample; what is not named is zero.", ("Quantity", "value"), rows, frame
    )


def requirements_table(
    study: Study, shares: pd.DataFrame, capability: pd.DataFrame, target: float, yields: pd.DataFrame | None = None
) -> Table:
    """Yield and parts per million of every requirement and of all together, judged against a target yield.

    ``yields`` are from :mod:`tolmc.commands.answers`; where there are none the accelerated yield has no column.
    """
    yields = pd.DataFrame() if yields is None else yields
    rows, unknown = [], shares.loc[ANY_REQUIREMENT, "unknown"]
    for name, row in capability.iterrows():
        counted = shares.loc[ANY_REQUIREMENT if name == ALL_REQUIREMENTS else name]
        verdict = words.judged(_estimate(row, "yield"), target)
        label = "All requirements" if name == ALL_REQUIREMENTS else quantities.label(name)
        rows.append(
            _cells(
                (
                    label,
                    words.limits(name, counted["minimum"], counted["maximum"]),
                    _count_out(counted),
                    words.share(*_estimate(row, "yield")),
                    *([words.share(*_estimate(yields.loc[name], "accelerated"))] if name in yields.index else []),
                    words.estimate(*_estimate(row, "ppm")),
                    Cell(verdict, tone=_TONE[verdict]),
                )
            )
        )
    frame = capability[[f"{key}{end}" for key in ("yield", "ppm") for end in ("", "_low", "_high")]]
    return Table(
        "requirements",
        f"Yield with 95 % intervals, from {study.samples:,} samples. Met: the whole interval of the yield lies at or above "
        f"{100 * target:.6g} %. Not met: it lies below. Not decided: it holds that value."
        + (_NOT_KNOWN if unknown else "")
        + (_ACCELERATED if len(yields) else ""),
        (
            "Requirement",
            "limits",
            "parts out",
            "yield",
            *(["accelerated yield"] if len(yields) else []),
            "parts per million out",
            "verdict",
        ),
        tuple(rows),
        frame.assign(target=target, verdict=[row[-1].text for row in rows]),
        left=(0, 1, len(rows[0]) - 1),
    )


_NOT_KNOWN = (
    " Samples that could not be computed, or that lost contact before they broke a requirement, are not known to be in: the "
    "yield counts them as out, its interval reaches to where they are in."
)

_ACCELERATED = " Accelerated: from a polynomial corrected by a few hundred true motions of its own."


def _count_out(counted: pd.Series) -> str:
    """Samples out of a requirement, with those that may be."""
    least, most = counted["out"], counted["out"] + counted["unknown"]
    return f"{least:,.0f}" if least == most else f"{least:,.0f} to {most:,.0f}"


_TONE = {words.MET: "good", words.BROKEN: "bad", words.OPEN: "open"}


def capability_table(capability: pd.DataFrame, intervals: Mapping[str, Estimate]) -> Table:
    """Capability indices and tolerance intervals (``intervals``: low, high by output, SI)."""
    rows = []
    found = capability.loc[list(intervals)].dropna(subset="ppm_if_normal")
    for name, row in found.iterrows():
        low, high = (quantities.shown(name)[1] * end for end in intervals[name])
        rows.append(
            _cells(
                (
                    _named(name),
                    *(words.estimate(*_estimate(row, key), digits=3) for key in INDICES),
                    words.number(row["ppm_if_normal"], 3),
                    words.number(row["ppm"], 3),
                    Cell(words.span(low, high, 3), words.unit(name)) if math.isfinite(high - low) else Cell("open"),
                )
            )
        )
    ends = pd.DataFrame(intervals, index=["tolerance_interval_low", "tolerance_interval_high"]).T
    return Table(
        "capability",
        "Capability of the outputs with 95 % intervals. Cp and Pp need two limits. The indices presume a normal output: where "
        "the parts per million that they promise differ from those counted, trust the count. Last column: where at least "
        "99.73 % of all parts lie, with 95 % confidence, whatever the distribution (open: too few samples to tell). Samples "
        "without a value for the whole motion are left out.",
        ("Output", *INDICES, "ppm if normal", "ppm counted", "99.73 % of parts"),
        tuple(rows),
        found.join(ends),
    )


def outputs_table(summary: pd.DataFrame) -> Table:
    """Estimates of every output with their intervals."""
    shown = summary[(summary["used"] > 0) & ~summary.index.isin(quantities.CHECKS)]
    shown = without_rounding_errors(shown, [f"{key}{end}" for key in STATISTICS for end in ("", "_low", "_high")])
    rows = []
    for name, row in shown.iterrows():
        factor = quantities.shown(name)[1]
        rows.append(
            _cells(
                (
                    _named(name, words.unit(name)),
                    *(words.estimate(*_estimate(row, key), factor=factor) for key in STATISTICS),
                )
            )
        )
    return Table(
        "outputs",
        "What the outputs do over all samples, each estimate with its 95 % interval (±: half its width, where that is below "
        "the digits shown). 0.135 % and 99.865 % are the quantiles between which 99.73 % of the parts lie.",
        ("Output", *STATISTICS.values()),
        tuple(rows),
        _in_shown_units(summary),
    )


def _in_shown_units(summary: pd.DataFrame) -> pd.DataFrame:
    values = [*STATISTICS, "min", "max", "q5", "q95"]
    frame = summary[["samples", "used", "failed", *(f"{key}{end}" for key in values for end in ("", "_low", "_high"))]]
    frame = frame.astype(dict.fromkeys(frame.columns[3:], float))
    factors = np.array([quantities.shown(name)[1] for name in frame.index])
    frame = frame.assign(**{column: frame[column] * factors for column in frame.columns[3:]})
    frame.insert(0, "unit", [quantities.shown(name)[0] for name in frame.index])
    return frame


def contributions_table(indices: pd.DataFrame, directions: pd.DataFrame, *, are_correlated: bool) -> Table:
    """Share of every output's variance that each dimension contributes.

    ``indices`` are from :func:`tolmc.analysis.from_samples.first_order`, ``directions`` from
    :func:`tolmc.analysis.from_samples.rank_correlation`.
    """
    percent = contributions(indices).dropna(how="all")
    dimensions, others = _foremost(percent.drop(columns=INTERACTIONS).max())
    rows = []
    for name, row in percent.iterrows():
        cells = [_percent(row[d], _direction(directions.at[(name, d), "correlation"])) for d in dimensions]
        cells += [_percent(row[others].sum())] if others else []
        rows.append((_named(name), *cells, _percent(row[INTERACTIONS])))
    labels = [quantities.label(dimension) for dimension in dimensions] + (["Others"] if others else [])
    rest = "Interactions and correlation" if are_correlated else "Interactions"
    half = 50 * (indices["first_high"] - indices["first_low"])
    return Table(
        "contributions",
        "Contribution of each dimension to the variance of each output. ↑: the output rises with the dimension, ↓: it falls. "
        f"{rest}: what no dimension contributes alone. Sampling leaves the entries uncertain by up to "
        f"±{words.number(half[np.isfinite(half)].max(), 2)} percentage points.",
        ("Output", *labels, rest),
        tuple(rows),
        indices.join(directions.drop(columns="used")),
    )


def _foremost(weight: pd.Series) -> tuple[list[str], list[str]]:
    """The names that have a column, in their order, and those for which the page is too narrow."""
    chosen = weight.nlargest(_COLUMNS).index
    return [name for name in weight.index if name in chosen], [name for name in weight.index if name not in chosen]


def _percent(value: float, sign: str = "") -> Cell:
    text = f"{round(value, 1) + 0.0:.1f} %".replace("-", words.MINUS)
    return Cell(f"{sign}{text}", bar=min(max(value / 100, 0.0), 1.0))


def _direction(correlation: float) -> str:
    if math.isnan(correlation) or abs(correlation) < 0.05:
        return ""
    return "↑ " if correlation > 0 else "↓ "


def failures_table(sources: pd.DataFrame, inputs: Iterable[str]) -> Table:
    """Where in each dimension the samples that break a requirement, lose contact or fail lie."""
    happened = sources[sources["events"] > 0]
    strongest = happened["distance"].groupby("dimension").max()
    dimensions, _ = _foremost(strongest.reindex([name for name in inputs if name in strongest]))
    rows = []
    for event in happened.index.unique("event"):
        found = happened.loc[event]
        cells = (
            Cell(f"{found.at[d, 'distance']:.2f}", _place(found.loc[d]), bar=found.at[d, "distance"])
            for d in dimensions
        )
        label = _EVENTS.get(event) or f"{quantities.label(event)} out"
        rows.append((Cell(label), Cell(f"{found['events'].iloc[0]:,}"), *cells))
    return Table(
        "failures",
        "Where the failures come from: how far a dimension's distribution in the failures lies from that in all other samples, "
        "0 (it has nothing to do with them) to 1 (a value of it separates them), and where most of them lie.",
        ("Failure", "samples", *(quantities.label(dimension) for dimension in dimensions)),
        tuple(rows),
        sources.drop(columns="finding"),
    )


def _place(row: pd.Series) -> str:
    if row["where"] not in words.PLACES:
        return "could be chance"
    return words.PLACES[row["where"]].format(share=f"{100 * row['share']:.0f} %")


def budget_table(summary: pd.DataFrame) -> Table:
    """Integration error beside the half-widths of the sampling intervals."""
    budget = error_budget(summary).dropna(subset="integration")
    rows = []
    for name, row in budget.iterrows():
        factor = quantities.shown(name)[1]
        errors = (_error(row[key] * factor) for key in ("integration", "mean", "sd", "q99.865"))
        rows.append(_cells((f"{quantities.label(name)} ({words.unit(name)})", *errors, words.number(row["ratio"], 2))))
    return Table(
        "error_budget",
        "Error budget, ±: integration error beside half the 95 % interval of three estimates. Ratio: integration error over "
        "the smallest of the sampling errors. Open: too few samples to tell.",
        ("Output", "integration", "mean", "sd", "99.865 %", "ratio"),
        tuple(rows),
        budget,
    )


def _error(value: float) -> str:
    return "open" if math.isinf(value) else words.number(value, 2)


def statuses_table(statuses: pd.DataFrame) -> Table:
    """What became of the samples."""
    rows = tuple(
        _cells((str(status), f"{row['count']:,.0f}", words.share(*_estimate(row, "share"))))
        for status, row in statuses.iterrows()
    )
    return Table("statuses", "What became of the samples.", ("Status", "samples", "share"), rows, statuses)


def stackup_table(stackup: pd.DataFrame) -> Table:
    """Worst case, root sum square, Monte Carlo and the accelerated estimate side by side: both limits of each output."""
    stackup = stackup.drop(index=list(quantities.CHECKS), level="output", errors="ignore")
    kinds = {"worst_case": "worst case", "root_sum_square": "root sum square", "monte_carlo": "Monte Carlo"}
    missing = stackup["accelerated_missing"].dropna()
    if stackup["accelerated"].notna().any():
        kinds["accelerated"] = "accelerated"
    limits = without_rounding_errors(stackup, _in_unit(kinds))
    limits = limits[limits.index.isin(("lower limit", "upper limit"), level="quantity")]
    rows = [_side_by_side(name, quantity, row, kinds) for (name, quantity), row in limits.iterrows()]
    return Table(
        "stackup",
        "The limits of each output by worst case (all parts), and by the other methods (99.73 % of the parts). Small print: "
        "95 % intervals, and how far worst case and root sum square are from Monte Carlo, in percent of the distance of its "
        "limits. Root sum square misleads where it leaves the interval of the Monte Carlo limit by more than 2 %; the worst "
        "case, sought at the corners and inside the limits, is exceeded where samples lie beyond it, and not known where "
        "motions within the limits have no value."
        + (f" No accelerated estimate: {missing.iloc[0]}" if len(missing) else ""),
        ("Output", "limit", *kinds.values(), "verdict"),
        tuple(rows),
        stackup,
        left=(0, 1, len(kinds) + 2),
    )


def _in_unit(kinds: Iterable[str]) -> list[str]:
    """Columns of the stack-up in the output's unit."""
    ends = {"monte_carlo": ("", "_low", "_high"), "accelerated": ("", "_low", "_high")}
    return [f"{kind}{end}" for kind in kinds for end in ends.get(kind, ("",))]


def _side_by_side(name: str, quantity: str, row: pd.Series, kinds: Iterable[str]) -> tuple[Cell, ...]:
    factor = quantities.shown(name)[1]
    decimals = _decimals(row, factor)
    details = {
        "worst_case": _percent_off(row["excess_percent"], "wider"),
        "root_sum_square": _percent_off(row["error_percent"], "off"),
        "monte_carlo": _interval(row, "monte_carlo", factor),
        "accelerated": _interval(row, "accelerated", factor),
    }
    cells = (Cell(_to_decimals(row[kind] * factor, decimals), details[kind]) for kind in kinds)
    first = _named(name, words.unit(name)) if quantity == "lower limit" else Cell("")
    return (first, Cell(quantity.split()[0]), *cells, _verdict(row))


def _decimals(row: pd.Series, factor: float) -> int:
    """Decimals that show a thousandth of what the methods differ by."""
    found = [abs(row[kind] - row["monte_carlo"]) * factor for kind in ("worst_case", "root_sum_square")]
    difference = max((x for x in found if 0 < x < math.inf), default=0.0)
    size = abs(row["monte_carlo"]) * factor
    finest = difference / 100 if difference else size * 1e-4
    return min(max(-math.floor(math.log10(finest)), 0), 9) if finest > 0 else 0


def _to_decimals(value: float, decimals: int) -> str:
    return words.NOTHING if math.isnan(value) else fixed(value, decimals).replace("-", words.MINUS)


def _percent_off(percent: float, of: str) -> str:
    return "" if math.isnan(percent) else f"{words.number(percent, 2)} % {of}"


def _interval(row: pd.Series, kind: str, factor: float) -> str:
    found = _estimate(row, kind)
    return "" if math.isnan(found.value) else words.estimate(*found, factor=factor)[1]


def _verdict(row: pd.Series) -> Cell:
    """On root sum square, and below it on the worst case where that misleads."""
    if row["root_sum_square_is"] == "does not vary":
        return Cell("does not vary")
    worst = {
        "exceeded": f"samples {words.number(row['beyond_percent'], 2)} % beyond the worst case",
        "not known": "worst case not known",
    }.get(row["worst_case_is"], "")
    kind = row["root_sum_square_is"]
    tone = "bad" if worst or kind == "misleads" else {"good enough": "good", "not decided": "open"}.get(kind, "")
    return Cell(f"root sum square {kind}", worst, tone=tone)


def accelerated_table(stackup: pd.DataFrame) -> Table:
    """The accelerated estimate of every output, and the surrogate behind it."""
    stackup = stackup.drop(index=list(quantities.CHECKS), level="output", errors="ignore").dropna(subset="accelerated")
    shown = without_rounding_errors(stackup, _in_unit(("accelerated",)))
    rows = []
    for name, answers in shown.groupby("output", sort=False):
        factor, answers = quantities.shown(name)[1], answers.droplevel("output")
        estimates = (words.estimate(*_estimate(answers.loc[q], "accelerated"), factor=factor) for q in answers.index)
        surrogate = answers.iloc[0]
        rows.append(
            _cells(
                (
                    _named(name, words.unit(name)),
                    *estimates,
                    words.number(surrogate["accelerated_degree"], 2),
                    words.number(surrogate["accelerated_held_out"], 2),
                )
            )
        )
    columns = [*_in_unit(("accelerated",)), "accelerated_degree", "accelerated_held_out"]
    return Table(
        "accelerated",
        "The accelerated estimate with 95 % intervals: a polynomial in place of the motion, corrected by true motions, so that "
        "a poor polynomial widens the interval and nothing else. Degree: that of the polynomial. Held-out error: its error at "
        "motions that it was not fitted to, over the output's spread.",
        ("Output", "mean", "sd", "0.135 %", "99.865 %", "degree", "held-out error"),
        tuple(rows),
        stackup[columns],
    )


def indices_table(indices: pd.DataFrame, outputs: Iterable[str]) -> Table:
    """Sobol' indices of the ``outputs``: a row for the first order and one for the total of each."""
    known = indices.dropna(subset="first")
    strongest = known["total"].groupby("dimension", sort=False).max()
    dimensions, _ = _foremost(strongest)
    rows = [
        _cells(
            (
                quantities.label(output),
                order,
                *(words.estimate(*_estimate(known.loc[(output, d)], column), digits=3) for d in dimensions),
            )
        )
        for output in outputs
        if output in known.index.unique("output")
        for column, order in (("first", "first order"), ("total", "total"))
    ]
    return Table(
        "sobol_indices",
        "Sobol' indices with 95 % intervals. First order: the share of the variance that vanishes when the dimension is made "
        "exactly. Total: the share that remains when all others are.",
        ("Output", "index", *(quantities.label(dimension) for dimension in dimensions)),
        tuple(rows),
        indices,
        left=(0, 1),
    )


def _estimate(row: Mapping[str, float], key: str) -> Estimate:
    return Estimate(row[key], row[f"{key}_low"], row[f"{key}_high"])
