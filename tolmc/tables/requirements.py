"""Requirements: the share of the samples out of each, the yield judged against its target, the capability."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import pandas as pd

from tolmc import quantities
from tolmc.statistics.capability import ALL_REQUIREMENTS
from tolmc.statistics.intervals import Estimate
from tolmc.statistics.outcomes import ANY_REQUIREMENT
from tolmc.statistics.tolerance_intervals import ToleranceInterval
from tolmc.study.study import Study
from tolmc.tables.table import Cell, Column, Estimated, Number, Share, Table, cells, plain
from tolmc.text.phrases import EVENTS, TONES, judged, limits, model_doubt, unit
from tolmc.text.typeset import span

_INDICES = ("Cp", "Cpk", "Pp", "Ppk")
_NOT_KNOWN = (
    " Samples that could not be computed, or that lost contact before they broke a requirement, are not known to be in: the "
    "yield counts them as out, its interval reaches to where they are in."
)
_ACCELERATED = " Accelerated: from a polynomial corrected by a few hundred true motions of its own."


def shares_table(requirements: pd.DataFrame) -> Table:
    """Share out of each requirement, from :func:`tolmc.statistics.summary.summarise_requirements`."""
    doubts = [model_doubt(row) for _, row in requirements.iterrows()]
    rows = []
    for doubt, (name, row) in zip(doubts, requirements.iterrows(), strict=True):
        least, most = plain.share(row["share_least"])[0], plain.share(row["share_most"])[0]
        rows.append(
            cells(
                EVENTS.get(name) or quantities.label(name),
                "" if name in EVENTS else limits(name, row["minimum"], row["maximum"]),
                f"{row['out']:,.0f}",
                least if least == most else f"{least} to {most}",
                f"{plain.share(row['share_least_low'])[0]} to {plain.share(row['share_most_high'])[0]}",
                *([Cell(doubt, tone="open")] if any(doubts) else []),
            )
        )
    columns: tuple[Column | str, ...] = ("Requirement", "limits", "out", "share out", "95 % interval")
    columns = (*columns, *([Column("verdict", words=True)] if any(doubts) else []))
    return Table("shares_out", columns, tuple(rows), title="Requirements", frame=requirements)


def requirements_table(
    study: Study, shares: pd.DataFrame, capability: pd.DataFrame, target: float, yields: pd.DataFrame | None = None
) -> Table:
    """Yield and parts per million of every requirement and of all together, judged against a target yield.

    ``yields`` are from :func:`tolmc.analysis.four_answers.four_answers`; without any the accelerated yield has no column.
    """
    yields = pd.DataFrame() if yields is None else yields
    undecided = model_verdicts(shares)
    verdicts = [
        undecided.get(str(name)) or judged(_estimate(row, "yield"), target) for name, row in capability.iterrows()
    ]
    rows = []
    for verdict, (name, row) in zip(verdicts, capability.iterrows(), strict=True):
        is_all = name == ALL_REQUIREMENTS
        counted = shares.loc[ANY_REQUIREMENT if is_all else name]
        rows.append(
            cells(
                EVENTS[name] if is_all else quantities.label(name),
                limits(name, counted["minimum"], counted["maximum"]),
                _count_out(counted),
                Share.of(row, "yield"),
                *([Share.of(yields.loc[name], "accelerated")] if name in yields.index else []),
                Estimated.of(row, "ppm"),
                Cell(verdict, tone=TONES.get(verdict, "open")),
            )
        )
    frame = capability[[f"{key}{end}" for key in ("yield", "ppm") for end in ("", "_low", "_high")]]
    return Table(
        "requirements",
        (
            "Requirement",
            Column("limits", words=True),
            "parts out",
            "yield",
            *(["accelerated yield"] if len(yields) else []),
            "parts per million out",
            Column("verdict", words=True),
        ),
        tuple(rows),
        title="Requirements",
        caption=f"Yield with 95 % intervals, from {study.samples:,} samples. Met: the whole interval of the yield lies at or "
        f"above {100 * target:.6g} %. Not met: it lies below. Not decided: it holds that value."
        + (_NOT_KNOWN if shares.loc[ANY_REQUIREMENT, "unknown"] else "")
        + (_ACCELERATED if len(yields) else ""),
        frame=frame.assign(target=target, verdict=verdicts),
    )


def model_verdicts(shares: pd.DataFrame) -> dict[str, str]:
    """{requirement: "not decided: the section matters (...)"} where a model of the joint may turn the verdict."""
    found = {str(name): doubt for name, row in shares.iterrows() if (doubt := model_doubt(row))}
    return found | ({ALL_REQUIREMENTS: found[ANY_REQUIREMENT]} if ANY_REQUIREMENT in found else {})


def _count_out(counted: pd.Series) -> str:
    """Samples out of a requirement, with those that may be."""
    least, most = counted["out"], counted["out"] + counted["unknown"]
    return f"{least:,.0f}" if least == most else f"{least:,.0f} to {most:,.0f}"


def capability_table(capability: pd.DataFrame, intervals: Mapping[str, ToleranceInterval]) -> Table:
    """Capability indices and tolerance intervals (``intervals``: low, high by output, SI)."""
    found = capability.loc[list(intervals)]
    found = found[found["ppm_if_normal"].notna() | found["is_constant"].eq(True)]
    ends = pd.DataFrame(intervals, index=["tolerance_interval_low", "tolerance_interval_high"]).T
    return Table(
        "capability",
        ("Output", *_INDICES, "ppm if normal", "ppm counted", "99.73 % of parts"),
        tuple(_capability_rows(found, intervals)),
        title="Capability with 95 % intervals",
        caption="Capability of the outputs with 95 % intervals. Cp and Pp need two limits. The indices presume a normal "
        "output: where the parts per million that they promise differ from those counted, trust the count. Last column: where "
        "at least 99.73 % of all parts lie, with 95 % confidence, whatever the distribution (open: too few samples to tell). "
        "Samples without a value for the whole motion are left out.",
        frame=found.join(ends),
    )


def _capability_rows(found: pd.DataFrame, intervals: Mapping[str, ToleranceInterval]) -> Iterator[tuple[Cell, ...]]:
    for name, row in found.iterrows():
        if row["is_constant"]:
            yield cells(quantities.label(name), "does not vary", *[""] * 4, Number(row["ppm"], 3), "")
            continue
        low, high = (quantities.shown(name)[1] * end for end in intervals[name])
        yield cells(
            quantities.label(name),
            *(Estimated.of(row, key, digits=3, narrow=3) for key in _INDICES),
            Number(row["ppm_if_normal"], 3),
            Number(row["ppm"], 3),
            Cell(span(low, high, 3), unit(name)) if math.isfinite(high - low) else "open",
        )


def yields_table(yields: pd.DataFrame) -> Table:
    """Yield by Monte Carlo and accelerated, in percent, from :func:`tolmc.analysis.four_answers.four_answers`."""
    rows = []
    for name, row in yields.iterrows():
        intervals = (Estimated.of(row, kind, 100.0) for kind in ("monte_carlo", "accelerated"))
        rows.append(
            cells(
                EVENTS.get(name) or quantities.label(name),
                *(Cell(Number(x.value), f"{plain.number(x.low)} to {plain.number(x.high)}") for x in intervals),
            )
        )
    return Table(
        "yields",
        ("Requirement", "Monte Carlo", "accelerated"),
        tuple(rows),
        title="Yield, % of the parts, with 95 % intervals",
        frame=yields,
        is_dense=True,
    )


def _estimate(row: Mapping[str, float], key: str) -> Estimate:
    return Estimate(*(row[f"{key}{end}"] for end in ("", "_low", "_high")))
