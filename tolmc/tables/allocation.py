"""What an allocation found: the winner, how sure it is, what else the yield would cost."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import pandas as pd

from tolmc import quantities
from tolmc.allocation.allocate import GLANCE, AllocationResult, MotionYield
from tolmc.tables.table import Column, Note, Number, Table, cells
from tolmc.text.numbers import NOTHING


def allocation_blocks(
    result: AllocationResult, *, title: str, shown_names: Mapping[str, str]
) -> Iterator[Table | Note]:
    """The winner, how sure it is, what the study has now, the trade-off, and one grade up or down.

    ``shown_names`` are those of the study's tolerances.
    """
    yield _winner(result, title, shown_names)
    yield from _verdict(result)
    yield _trade_off(result, shown_names)
    yield _neighbours(result, shown_names)
    yield _surrogate(result)


def _winner(result: AllocationResult, title: str, shown_names: Mapping[str, str]) -> Table:
    rows = []
    for name, row in result.dimensions.rename(index=shown_names).iterrows():
        unit, factor = quantities.shown(name)
        limits = (Number(row[key] * factor, decimals=5) for key in ("lower", "upper"))
        grade = row["toleranced_size"] or row["grade"]
        rows.append(
            cells(quantities.label(name), unit, grade, _width(name, row["width"]), *limits, Number(row["cost"], 4))
        )
    return Table(
        "dimensions",
        ("Dimension", Column("unit", words=True), "grade", "zone", "lower", "upper", "cost"),
        tuple(rows),
        title=f"{title}: {'the cheapest tolerances' if result.is_met else 'tolerances tried last, NOT SHOWN TO SUFFICE'}",
        frame=result.dimensions,
    )


def _verdict(result: AllocationResult) -> Iterator[Note]:
    plan, confirmed, present = result.plan, result.confirmed, result.present_yield
    reached = "reaches" if result.is_met else "does not reach"
    yield Note(
        f"Cost {result.winner.cost:.4g}. Yield of {plan.samples:,} independent motions: {_percent(confirmed.value)}; with "
        f"{100.0 * plan.confidence:.4g} % confidence it is at least {_percent(confirmed.low)}, which {reached} the required "
        f"{_percent(plan.target_yield)} (confirming run {result.attempts}; predicted {_percent(result.predicted_yield)}).",
        strong="" if result.is_met else reached,
    )
    yield from _unknown(confirmed, "these motions")
    yield from _left_out(result)
    yield Note(
        f"The study's own tolerances: {_percent(present.value)} of {present.samples:,} motions, {_percent(present.low)} to "
        f"{_percent(present.high)} with {100.0 * plan.confidence:.4g} % confidence."
    )
    yield from _unknown(present, "those motions")
    if confirmed.unknown > confirmed.failed:
        yield Note(
            "Say with on_contact_loss what holds once contact is lost, or forbid it: contact_force_D_min and "
            "contact_force_E_min >= 0."
        )


def _unknown(found: MotionYield, motions: str) -> Iterator[Note]:
    """What the yield says nothing about."""
    if found.failed or found.contact_lost:
        yield Note(
            f"Of {motions} {_count(found.failed, found.samples)} failed and {_count(found.contact_lost, found.samples)} lost "
            f"contact. {found.unknown:,} are not known to keep or to break the limits and count as breaking them; if all "
            f"kept them, the yield would be {_percent(found.value + found.unknown / found.samples)}."
        )


def _left_out(result: AllocationResult) -> Iterator[Note]:
    """What the predictions say nothing about."""
    surrogate = result.surrogate
    if surrogate.failed:
        yield Note(
            f"Predicted yields leave failing motions out: {_count(surrogate.failed, surrogate.motions)} of the training "
            "motions failed."
        )
    if surrogate.contact_lost:
        yield Note(
            f"Predicted yields take outputs up to the loss of contact: {_count(surrogate.contact_lost, surrogate.motions)} "
            "of the training motions lost it."
        )


def _trade_off(result: AllocationResult, shown_names: Mapping[str, str]) -> Table:
    names = [shown_names[choice.name] for choice in result.plan.choices]
    rows = []
    for _, row in result.trade_off.rename(columns=shown_names).iterrows():
        zones = (_zone(name, row[name]) for name in names)
        rows.append(cells(_percent(row["required_yield"]), Number(row["cost"], 4), f"{row['out_ppm']:.0f}", *zones))
    return Table(
        "trade_off",
        ("Required yield", "cost", "predicted out, ppm", *map(_heading, names)),
        tuple(rows),
        title="Cost against yield",
        frame=result.trade_off,
    )


def _neighbours(result: AllocationResult, shown_names: Mapping[str, str]) -> Table:
    unpriced = result.neighbours["cost"].isna().any()
    note = f" (–: not on offer; yield of {min(result.plan.samples, GLANCE):,} motions)" if unpriced else ""
    rows = []
    for _, row in result.neighbours.iterrows():
        name, change = shown_names[row["dimension"]], row["cost_change"]
        rows.append(
            cells(
                quantities.label(name),
                _zone(name, row["from"]),
                _zone(name, row["to"]),
                Number(row["cost"], 4),
                NOTHING if pd.isna(change) else f"{change:+.3g}",
                _percent(row["predicted_yield"]),
                f"{row['out_ppm']:.0f}",
            )
        )
    return Table(
        "neighbours",
        ("Dimension", "from", "to", "cost", "change", "predicted", "out, ppm"),
        tuple(rows),
        title=f"One grade up or down{note}",
        frame=result.neighbours,
    )


def _surrogate(result: AllocationResult) -> Table:
    described = result.surrogate.describe()
    rows = []
    for name, row in described.iterrows():
        unit, factor = quantities.shown(name)
        share = NOTHING if pd.isna(row["held_out_share"]) else f"{row['held_out_share']:.1e}"
        rows.append(
            cells(quantities.label(name), f"{row['degree']:.0f}", f"{row['held_out_error'] * factor:.1e} {unit}", share)
        )
    columns = ("Output", "degree", "held-out error", "of its spread")
    return Table("surrogate", columns, tuple(rows), title="Surrogate over the zones on offer")


def _heading(name: str) -> str:
    return f"{quantities.of(name).symbol}, {quantities.shown(name)[0]}"


def _zone(name: str, value: str | float) -> str | Number:
    return value if isinstance(value, str) else _width(name, value)


def _width(name: str, width: float) -> Number:
    return Number(width * quantities.shown(name)[1], 4)


def _count(count: int, total: int) -> str:
    return f"{count:,} ({100.0 * count / total:.3g} %)"


def _percent(share: float) -> str:
    return f"{100.0 * share:.4f} %"
