"""Two runs side by side."""

from __future__ import annotations

from collections.abc import Iterator

import pandas as pd

from tolmc import quantities
from tolmc.runs.compare import RunComparison
from tolmc.tables.table import Cell, Column, Estimated, Note, Table, cells, plain
from tolmc.text.phrases import EVENTS, STATISTICS, unit


def comparison_blocks(found: RunComparison) -> Iterator[Table | Note]:
    """What changed in the study, the statistics and the shares; a difference that its interval leaves open is marked so."""
    first, second = (f"{run.record['title']} ({run.path.name})" for run in (found.first, found.second))
    yield Note(f"{first} → {second}", strong=first, is_apart=True)
    if found.study.empty:
        yield Note("The two studies say the same.")
    else:
        yield _study(found.study)
    yield _shares(found.shares)
    yield _statistics(found.statistics, [str(name) for name in found.shares.index])
    yield Note("Differences are second less first, with 95 % intervals that take the runs as independent.")


def _study(changes: pd.DataFrame) -> Table:
    rows = tuple(cells(str(field), row["first"] or "–", row["second"] or "–") for field, row in changes.iterrows())
    columns = ("Field", Column("first", words=True), Column("second", words=True))
    return Table("study_changes", columns, rows, title="What changed in the study", frame=changes)


def _statistics(statistics: pd.DataFrame, limited: list[str]) -> Table:
    """The outputs with limits first; what only checks the integration is in the frame alone."""
    names = list(dict.fromkeys(statistics.index.get_level_values("output")))
    shown = statistics.loc[sorted(names, key=lambda name: name not in limited)]
    rows = []
    for (output, key), row in shown.iterrows():
        if pd.isna(row["difference"]) or (output in quantities.CHECKS and output not in limited):
            continue
        factor = quantities.shown(output)[1]
        estimates = [Estimated.of(row, part, factor) for part in ("first", "second", "difference")]
        rows.append(cells(f"{quantities.label(output)}, {STATISTICS[key]}", unit(output), *estimates, _seen(row)))
    columns = ("Statistic", Column("unit", words=True), "first", "second", "difference", Column("", words=True))
    return Table("statistics", columns, tuple(rows), title="Outputs", frame=statistics, is_dense=True)


def _shares(shares: pd.DataFrame) -> Table:
    rows = []
    for name, row in shares.iterrows():
        first, second = (plain.share(row[part])[0] for part in ("first", "second"))
        change = f"{_signed(100 * row['difference'])} %"
        interval = f"{_signed(100 * row['difference_low'])} to {_signed(100 * row['difference_high'])} %"
        label = EVENTS.get(str(name)) or f"{quantities.label(str(name))} out"
        rows.append(cells(label, first, second, change, interval, _seen(row)))
    columns = ("Share of the samples", "first", "second", "difference", "95 % interval", Column("", words=True))
    return Table("shares", columns, tuple(rows), title="Requirements", frame=shares)


def _signed(value: float) -> str:
    return f"{value:+.3g}" if value else "0"


def _seen(row: pd.Series) -> Cell:
    """Whether the interval of the difference says that there is one."""
    if row["difference"] == 0:
        return Cell("equal")
    if row["difference_low"] > 0:
        return Cell("more", tone="heading")
    return Cell("less", tone="heading") if row["difference_high"] < 0 else Cell("no difference shown")
