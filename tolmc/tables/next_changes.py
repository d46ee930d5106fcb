"""What to change next, for the report."""

from __future__ import annotations

import pandas as pd

from tolmc import quantities
from tolmc.statistics.intervals import Estimate
from tolmc.study.study import Study
from tolmc.tables.table import Cell, Column, Share, Table, cells
from tolmc.text.phrases import TONES, judged, unit
from tolmc.text.typeset import span

# A verdict of the circle says so: where the section turns the requirements, it turns these too.
_ON = {"circle": " on the circle of constant radius", "exact": ""}
_WORDS = {"moved": "move the zone", "narrower": "narrow the zone"}


def next_changes_table(study: Study, found: pd.DataFrame, target: float) -> Table:
    """Single changes that would keep the limits, from :func:`tolmc.allocation.next_change.next_changes`."""
    names, rows = study.tolerances.shown_names, []
    for _, row in found.iterrows():
        name = names[row["dimension"]]
        factor = quantities.shown(name)[1]
        size = row["toleranced_size"] if isinstance(row["toleranced_size"], str) else ""
        verdict = judged(Estimate(row["yield"], row["yield_low"], row["yield_high"]), target)
        rows.append(
            cells(
                quantities.label(name),
                f"{_WORDS[row['kind']]}{f' to {size}' if size else ''}",
                span(factor * row["lower"], factor * row["upper"]),
                unit(name),
                Share.of(row, "yield"),
                Cell(verdict, tone=TONES[verdict]),
            )
        )
    return Table(
        "next_changes",
        (
            "Dimension",
            Column("change", words=True),
            "limits then",
            Column("unit", words=True),
            "yield then",
            Column("verdict", words=True),
        ),
        tuple(rows),
        title="What to change next",
        caption=f"The least single change of each dimension with which {100 * target:.6g} % of the parts keep every limit, "
        f"found by a polynomial and judged by 10,000 true motions{_ON[study.scene.joint.section]}. "
        "Moves, which cost no accuracy, come first.",
        frame=found,
    )
