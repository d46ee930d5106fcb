"""Which dimension moves which output, and where the failures come from."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import pandas as pd

from tolmc import quantities
from tolmc.analysis.from_samples import INTERACTIONS, contributions
from tolmc.analysis.smoothness import rough
from tolmc.tables.table import Cell, Column, Estimated, Table, cells
from tolmc.text.phrases import event, jumps, place
from tolmc.text.typeset import number, to_decimals

#: Dimensions that have a column of their own: more do not fit on a page.
_COLUMNS = 6


def contributions_table(indices: pd.DataFrame, directions: pd.DataFrame, *, are_correlated: bool) -> Table:
    """Share of every output's variance that each dimension contributes.

    ``indices`` are from :func:`tolmc.analysis.from_samples.first_order`, ``directions`` from
    :func:`tolmc.analysis.from_samples.rank_correlation`.
    """
    percent = contributions(indices).dropna(how="all")
    dimensions, others = _foremost(percent.drop(columns=INTERACTIONS).max())
    rows = []
    for name, row in percent.iterrows():
        found = [_percent(row[d], _direction(directions.at[(name, d), "correlation"])) for d in dimensions]
        found += [_percent(row[others].sum())] if others else []
        rows.append(cells(quantities.label(name), *found, _percent(row[INTERACTIONS])))
    labels = [quantities.label(dimension) for dimension in dimensions] + (["Others"] if others else [])
    rest = "Interactions and correlation" if are_correlated else "Interactions"
    half = 50 * (indices["first_high"] - indices["first_low"])
    return Table(
        "contributions",
        ("Output", *labels, rest),
        tuple(rows),
        title="Contribution of each dimension to the variance",
        caption="Contribution of each dimension to the variance of each output. ↑: the output rises with the dimension, ↓: it "
        f"falls. {rest}: what no dimension contributes alone. Sampling leaves the entries uncertain by up to "
        f"±{number(half[np.isfinite(half)].max(), 2)} percentage points.",
        frame=indices.join(directions.drop(columns="used")),
    )


def _foremost(weight: pd.Series) -> tuple[list[str], list[str]]:
    """The names that have a column, in their order, and those for which the page is too narrow."""
    chosen = weight.nlargest(_COLUMNS).index
    return [name for name in weight.index if name in chosen], [name for name in weight.index if name not in chosen]


def _percent(value: float, sign: str = "") -> Cell:
    return Cell(f"{sign}{to_decimals(value, 1)} %", bar=min(max(value / 100, 0.0), 1.0))


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
    for name in happened.index.unique("event"):
        found = happened.loc[name]
        places = (
            Cell(
                f"{row['distance']:.2f}",
                place(row["where"], row["share"], otherwise="could be chance"),
                bar=row["distance"],
            )
            for _, row in found.loc[dimensions].iterrows()
        )
        rows.append(cells(event(name), f"{found['events'].iloc[0]:,}", *places))
    return Table(
        "failures",
        ("Failure", "samples", *(quantities.label(dimension) for dimension in dimensions)),
        tuple(rows),
        title="Where the failures come from",
        caption="Where the failures come from: how far a dimension's distribution in the failures lies from that in all other "
        "samples, 0 (it has nothing to do with them) to 1 (a value of it separates them), and where most of them lie.",
        frame=sources.drop(columns="finding"),
    )


def indices_table(indices: pd.DataFrame, outputs: Iterable[str]) -> Table:
    """Sobol' indices of the ``outputs``: a row for the first order and one for the total of each."""
    known = indices.dropna(subset="first")
    strongest = known["total"].groupby("dimension", sort=False).max()
    dimensions, _ = _foremost(strongest)
    rows = [
        cells(
            quantities.label(output),
            order,
            *(Estimated.of(known.loc[(output, d)], column, digits=3, narrow=3) for d in dimensions),
        )
        for output in outputs
        if output in known.index.unique("output")
        for column, order in (("first", "first order"), ("total", "total"))
    ]
    shares = known.get("held_out_share", pd.Series(index=known.index, dtype=float)).groupby("output").first()
    words = jumps(
        rough(shares[shares.index.isin(list(outputs))]),
        "The net gains such outputs little; their intervals, which take its rows for independent, hold.",
    )
    return Table(
        "sobol_indices",
        ("Output", Column("index", words=True), *(quantities.label(dimension) for dimension in dimensions)),
        tuple(rows),
        title="Sobol' indices with 95 % intervals",
        caption="Sobol' indices with 95 % intervals. First order: the share of the variance that vanishes when the dimension "
        "is made exactly. Total: the share that remains when all others are." + (f" Jumps: {words}" if words else ""),
        frame=indices,
    )
