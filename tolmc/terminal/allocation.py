"""What an allocation found, for the terminal: engineering units, a table for each question."""

from __future__ import annotations

from collections.abc import Iterator

import pandas as pd

from tolmc import quantities
from tolmc.allocation.allocate import GLANCE, AllocationResult, MotionYield
from tolmc.terminal.tables import Grid


def allocation_tables(result: AllocationResult, *, title: str) -> Iterator[Grid | str]:
    """The winner, how sure it is, what the study has now, the trade-off, and one grade up or down."""
    yield _winner(result, title)
    yield _verdict(result)
    yield _trade_off(result)
    yield _neighbours(result)
    yield _surrogate(result)


def _winner(result: AllocationResult, title: str) -> Grid:
    table = Grid(
        "Dimension", "unit", "grade", "zone", "lower", "upper", "cost",
        title=f"{title}: {'the cheapest tolerances' if result.is_met else 'tolerances tried last, NOT SHOWN TO SUFFICE'}",
    )  # fmt: skip
    for name, row in result.dimensions.iterrows():
        unit, factor = quantities.shown(name)
        limits = (f"{row[key] * factor:.5f}" for key in ("lower", "upper"))
        grade = row["toleranced_size"] or row["grade"]
        table.add_row(quantities.label(name), unit, grade, _width(name, row["width"]), *limits, f"{row['cost']:.4g}")
    return table


def _verdict(result: AllocationResult) -> str:
    plan, confirmed, present = result.plan, result.confirmed, result.present_yield
    reached = "reaches" if result.is_met else "[bold]does not reach[/]"
    sentences = [
        f"Cost {result.winner.cost:.4g}. Yield of {plan.samples:,} independent motions: {_percent(confirmed.value)}; with "
        f"{100.0 * plan.confidence:.4g} % confidence it is at least {_percent(confirmed.low)}, which {reached} the required "
        f"{_percent(plan.target_yield)} (confirming run {result.attempts}; predicted {_percent(result.predicted_yield)}).",
        *_unknown(confirmed, "these motions"),
        *_left_out(result),
        f"The study's own tolerances: {_percent(present.value)} of {present.samples:,} motions, {_percent(present.low)} to "
        f"{_percent(present.high)} with {100.0 * plan.confidence:.4g} % confidence.",
        *_unknown(present, "those motions"),
    ]
    if confirmed.unknown > confirmed.failed:
        sentences.append(
            "Say with on_contact_loss what holds once contact is lost, or forbid it: contact_force_D_min and "
            "contact_force_E_min >= 0."
        )
    return "\n".join(sentences)


def _unknown(found: MotionYield, motions: str) -> Iterator[str]:
    """What the yield says nothing about."""
    if found.failed or found.contact_lost:
        yield (
            f"Of {motions} {_count(found.failed, found.samples)} failed and {_count(found.contact_lost, found.samples)} lost "
            f"contact. {found.unknown:,} are not known to keep or to break the limits and count as breaking them; if all "
            f"kept them, the yield would be {_percent(found.value + found.unknown / found.samples)}."
        )


def _left_out(result: AllocationResult) -> Iterator[str]:
    """What the predictions say nothing about."""
    surrogate = result.surrogate
    if surrogate.failed:
        yield (
            f"Predicted yields leave failing motions out: {_count(surrogate.failed, surrogate.motions)} of the training "
            "motions failed."
        )
    if surrogate.contact_lost:
        yield (
            f"Predicted yields take outputs up to the loss of contact: {_count(surrogate.contact_lost, surrogate.motions)} "
            "of the training motions lost it."
        )


def _trade_off(result: AllocationResult) -> Grid:
    names = [choice.name for choice in result.plan.choices]
    table = Grid("Required yield", "cost", "predicted out, ppm", *map(_heading, names), title="Cost against yield")
    for _, row in result.trade_off.iterrows():
        zones = (_zone(name, row[name]) for name in names)
        table.add_row(_percent(row["required_yield"]), f"{row['cost']:.4g}", f"{row['out_ppm']:.0f}", *zones)
    return table


def _neighbours(result: AllocationResult) -> Grid:
    columns = ("Dimension", "from", "to", "cost", "change", "predicted", "out, ppm")
    unpriced = result.neighbours["cost"].isna().any()
    note = f" (–: not on offer; yield of {min(result.plan.samples, GLANCE):,} motions)" if unpriced else ""
    table = Grid(*columns, title=f"One grade up or down{note}")
    for _, row in result.neighbours.iterrows():
        name = row["dimension"]
        table.add_row(
            quantities.label(name), _zone(name, row["from"]), _zone(name, row["to"]), _money(row["cost"], ".4g"),
            _money(row["cost_change"], "+.3g"), _percent(row["predicted_yield"]), f"{row['out_ppm']:.0f}",
        )  # fmt: skip
    return table


def _surrogate(result: AllocationResult) -> Grid:
    table = Grid("Output", "degree", "held-out error", "of its spread", title="Surrogate over the zones on offer")
    for name, row in result.surrogate.describe().iterrows():
        unit, factor = quantities.shown(name)
        share = "–" if pd.isna(row["held_out_share"]) else f"{row['held_out_share']:.1e}"
        table.add_row(
            quantities.label(name), f"{row['degree']:.0f}", f"{row['held_out_error'] * factor:.1e} {unit}", share
        )
    return table


def _heading(name: str) -> str:
    return f"{quantities.of(name).symbol}, {quantities.shown(name)[0]}"


def _zone(name: str, value: str | float) -> str:
    return value if isinstance(value, str) else _width(name, value)


def _width(name: str, width: float) -> str:
    return f"{width * quantities.shown(name)[1]:.4g}"


def _money(cost: float, form: str) -> str:
    return "–" if pd.isna(cost) else f"{cost:{form}}"


def _count(count: int, total: int) -> str:
    return f"{count:,} ({100.0 * count / total:.3g} %)"


def _percent(share: float) -> str:
    return f"{100.0 * share:.4f} %"
