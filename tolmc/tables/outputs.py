"""Outputs of a run: their estimates, what becomes of the samples, and how exact the motions are beside the sampling."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import pandas as pd

from tolmc import quantities
from tolmc.statistics.contact_law import RESTITUTIONS, prefix
from tolmc.statistics.summary import error_budget
from tolmc.tables.table import Cell, Column, Estimated, Number, Share, Table, cells, plain, typeset
from tolmc.text.numbers import without_rounding_errors
from tolmc.text.phrases import STATISTICS, computed, unit

#: What the table of outputs has room for, and the digits of each on a terminal.
_SHOWN = {"mean": 5, "sd": 4, "q0.135": 5, "q50": 5, "q99.865": 5}
_BUDGET = ("mean", "sd", "q99.865")


_OF_SECTION = (
    " Circle − exact: what the circle of constant radius changes, from samples that were run on the exact section too; no "
    "number of samples and no step makes it smaller."
)


def outputs_table(summary: pd.DataFrame, foremost: Iterable[str] = ()) -> Table:
    """Mean, sd and quantiles of every output, from :func:`tolmc.statistics.summary.summarise`; the ``foremost`` first."""
    summary = summary.loc[[*dict.fromkeys(name for name in (*foremost, *summary.index) if name in summary.index)]]
    shown = summary[(summary["used"] > 0) & ~summary.index.isin(quantities.CHECKS)]
    shown = without_rounding_errors(shown, [f"{key}{end}" for key in _SHOWN for end in ("", "_low", "_high")])
    counted = {"samples": summary["samples"].max(), "unknown": summary["failed"].max()}
    seen = computed(counted)
    of = f" of {seen}" if counted["unknown"] else ""
    rows = [
        cells(
            Cell(quantities.label(name), unit(name)),
            *(Estimated.of(row, key, quantities.shown(name)[1], narrow=digits) for key, digits in _SHOWN.items()),
        )
        for name, row in shown.iterrows()
    ]
    return Table(
        "outputs",
        ("Output", *(STATISTICS[key] for key in _SHOWN)),
        tuple(rows),
        title=f"Outputs{of} with 95 % intervals (±, where it reaches the digits shown)",
        caption=f"What the outputs do over {seen}, each estimate with its 95 % interval (±: half its width, where that is "
        "below the digits shown). 0.135 % and 99.865 % are the quantiles between which 99.73 % of the parts lie.",
        frame=_in_shown_units(summary),
    )


def _in_shown_units(summary: pd.DataFrame) -> pd.DataFrame:
    values = [*_SHOWN, "min", "max", "q5", "q95"]
    frame = summary[["samples", "used", "failed", *(f"{key}{end}" for key in values for end in ("", "_low", "_high"))]]
    frame = frame.astype(dict.fromkeys(frame.columns[3:], float))
    factors = np.array([quantities.shown(name)[1] for name in frame.index])
    frame = frame.assign(**{column: frame[column] * factors for column in frame.columns[3:]})
    frame.insert(0, "unit", [quantities.shown(name)[0] for name in frame.index])
    return frame


def statuses_table(statuses: pd.DataFrame) -> Table:
    """What became of the samples, from :func:`tolmc.statistics.summary.count_statuses`."""
    rows = tuple(
        cells(str(status), f"{row['count']:,.0f}", Share.of(row, "share")) for status, row in statuses.iterrows()
    )
    return Table(
        "statuses",
        ("Status", "samples", "share"),
        rows,
        title="What became of the samples",
        caption="What became of the samples.",
        frame=statuses,
    )


def budget_table(summary: pd.DataFrame) -> Table:
    """Integration error beside the half-widths of the sampling intervals."""
    budget = error_budget(summary).dropna(subset="integration")
    of_section = _BUDGET if "section_mean" in summary else ()
    rows = []
    for name, row in budget.iterrows():
        factor = quantities.shown(name)[1]
        errors = (_error(row[key] * factor) for key in ("integration", *_BUDGET))
        model = (Estimated.of(summary.loc[name], f"section_{key}", factor, digits=3, narrow=3) for key in of_section)
        label = quantities.label(name)
        rows.append(cells(label, f"{label} ({unit(name)})", unit(name), *errors, Number(row["ratio"], 2), *model))
    return Table(
        "error_budget",
        (
            Column("Output", only=plain),
            Column("Output", words=True, only=typeset),
            Column("unit", words=True, only=plain),
            "integration",
            *(STATISTICS[key] for key in _BUDGET),
            Column("ratio", only=typeset),
            *(f"circle − exact, {STATISTICS[key]}" for key in of_section),
        ),
        tuple(rows),
        title="Error budget (±)",
        caption="Error budget, ±: integration error beside half the 95 % interval of three estimates. Ratio: integration error "
        "over the smallest of the sampling errors. Open: too few samples to tell."
        + (_OF_SECTION if of_section else ""),
        frame=budget,
    )


def contact_law_table(summary: pd.DataFrame) -> Table:
    """What walls that only push change, with their intervals; without rows where no sample lost contact."""
    laws = [prefix(e) for e in RESTITUTIONS]
    columns = [f"{law}_{key}" for law in laws for key in _BUDGET]
    present = set(columns) <= set(summary.columns)
    shown = summary.dropna(subset=columns) if present else summary.iloc[:0]
    rows = [
        cells(
            Cell(quantities.label(name), unit(name)),
            *(Estimated.of(row, key, quantities.shown(name)[1], digits=3, narrow=3) for key in columns),
        )
        for name, row in shown.iterrows()
    ]
    heads = [f"e = {e:g}, {STATISTICS[key]}" for e in RESTITUTIONS for key in _BUDGET]
    ends = [f"{column}{end}" for column in columns for end in ("", "_low", "_high")]
    return Table(
        "contact_law",
        ("Output", *heads),
        tuple(rows),
        title="Contact law: as run less followed through impacts",
        caption="What the loss of contact leaves out: each statistic as run less that of the same samples followed through "
        "flight and impacts, with restitutions e of 0 and of 0.5; 95 % intervals.",
        frame=shown[ends] if present else None,
    )


def _error(value: float) -> str | Number:
    return "open" if math.isinf(value) else Number(value, 2)
