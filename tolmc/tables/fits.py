"""Fits side by side: clearance, yield, peaks and cost."""

from __future__ import annotations

from collections.abc import Iterator

import pandas as pd

from tolmc import quantities
from tolmc.statistics.intervals import Estimate
from tolmc.statistics.outcomes import ENOUGH_COMPUTED
from tolmc.study.sections import TARGET_YIELD
from tolmc.study.study import Study
from tolmc.tables.table import Cell, Column, Estimated, Note, Number, Share, Table, cells
from tolmc.text.phrases import MET, STATISTICS, TONES, joined, judged, model_doubt, model_turns_target, unit
from tolmc.text.typeset import span


def fits_blocks(study: Study, found: pd.DataFrame, *, samples: int) -> Iterator[Table | Note]:
    """The fits, and which of them meet the study's target; ``found`` is from :func:`tolmc.runs.fits.try_fits`."""
    target = study.target or TARGET_YIELD
    peaks = [column for column in found if " q" in column and not column.endswith(("_low", "_high"))]
    priced = bool(found["cost"].notna().any())
    yields = {fit: Estimate(*(row[f"yield{end}"] for end in ("", "_low", "_high"))) for fit, row in found.iterrows()}
    verdicts = {fit: judged(estimate, target) for fit, estimate in yields.items()}
    verdicts |= {fit: model_doubt(row) for fit, row in found.iterrows() if model_turns_target(row)}
    rows = []
    for fit, row in found.iterrows():
        rows.append(
            cells(
                str(fit),
                span(1e3 * row["clearance_low"], 1e3 * row["clearance_high"]),
                Share.of(row, "yield"),
                f"{100 * row['yield_low']:.6g} to {100 * row['yield_high']:.6g} %",
                *(Estimated.of(row, peak, quantities.shown(peak.split()[0])[1]) for peak in peaks),
                *([Number(row["cost"], 4)] if priced else []),
                Cell(verdicts[fit], tone=TONES.get(verdicts[fit], "open")),
            )
        )
    heads = [
        f"{quantities.label(name)}, {STATISTICS[s]} ({unit(name)})" for name, s in (peak.split() for peak in peaks)
    ]
    columns = ("Fit", "clearance, mm", "yield", "95 % interval", *heads, *(["cost"] if priced else []))
    yield Table(
        "fits",
        (*columns, Column(f"target {100 * target:.6g} %", words=True)),
        tuple(rows),
        title=f"{study.title}: fits from {samples:,} samples each",
        frame=found,
    )
    few = [fit for fit, share in found["computed_share"].items() if share < ENOUGH_COMPUTED]
    if few:
        yield Note(
            f"With {joined(few)} fewer than {100 * ENOUGH_COMPUTED:g} % of the samples could be computed; the others "
            "are counted both ways.",
            is_apart=True,
        )
    yield _answer(found, [fit for fit, verdict in verdicts.items() if verdict == MET], f"{100 * target:.6g} %")
    if not priced:
        yield Note(
            "No costs: where [allocation.dimensions] of the study prices bore and journal, they stand beside ('tolmc explain "
            "allocation.dimensions')."
        )


def _answer(found: pd.DataFrame, met: list, target: str) -> Note:
    """The loosest of the fits that meet the target."""
    if not met:
        return Note(f"None of these fits is shown to keep the limits in {target} of the parts.", is_apart=True)
    loosest = max(met, key=lambda fit: found.at[fit, "clearance_high"])
    others = [fit for fit in met if fit != loosest]
    more = f" So {'do' if len(others) > 1 else 'does'} {joined(others)}." if others else ""
    return Note(
        f"Of these fits {loosest} is the loosest that keeps the limits in {target} of the parts.{more}",
        strong=str(loosest),
        is_apart=True,
    )
