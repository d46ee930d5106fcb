"""Circle against exact section: every statistic and share of :func:`tolmc.commands.compare_sections.compare_sections`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
import pandas as pd

from tolmc import quantities
from tolmc.tables.table import Table, cells, plain
from tolmc.text.numbers import NOTHING
from tolmc.text.phrases import EVENTS, STATISTICS
from tolmc.text.typeset import MINUS

_MOMENTS = ("mean", "sd", "min", "max")
_QUANTILES = ("q0.135", "q5", "q50", "q95", "q99.865")
_ENDS = {"share_least": ", at least", "share_most": ", at most"}


def comparison_tables(comparison: pd.DataFrame) -> Iterator[Table]:
    """Differences of the statistics in percent, then the shares in both."""
    differences = comparison["difference_percent"].unstack("statistic", sort=False)
    if "mean" in differences:
        outputs = differences[differences["mean"].notna()]
        yield _differences(
            outputs, _MOMENTS, name="moments", title="Circle less exact section, in percent of the exact value"
        )
        yield _differences(outputs, _QUANTILES, name="quantiles", title="The same for the quantiles")
    yield _shares(comparison)


def _differences(differences: pd.DataFrame, statistics: Iterable[str], *, name: str, title: str) -> Table:
    rows = [
        cells(quantities.label(output), *(NOTHING if np.isnan(value) else f"{value:+.3g}" for value in row))
        for output, row in differences[list(statistics)].iterrows()
    ]
    return Table(name, ("Output", *(STATISTICS[key] for key in statistics)), tuple(rows), title=title)


def _shares(comparison: pd.DataFrame) -> Table:
    """Requirements, between two bounds where failed samples leave their shares open, and statuses."""
    rows = []
    for (output, statistic), row in comparison.iterrows():
        if output == "status":
            label = f"Status {statistic}"
        elif statistic in _ENDS:
            is_settled = comparison.loc[(output, "share_least")].equals(comparison.loc[(output, "share_most")])
            if is_settled and statistic == "share_most":
                continue
            label = EVENTS.get(output) or f"{quantities.label(output)}, out"
            label += "" if is_settled else _ENDS[statistic]
        else:
            continue
        sign = "+" if row["difference"] > 0 else MINUS if row["difference"] < 0 else ""
        shares = (plain.share(x)[0] for x in (row["circle"], row["exact"], abs(row["difference"])))
        circle, exact, difference = shares
        rows.append(cells(label, circle, exact, f"{sign}{difference}"))
    columns = ("Share of the samples", "circle", "exact", "difference")
    return Table("shares", columns, tuple(rows), title="Requirements and statuses")
