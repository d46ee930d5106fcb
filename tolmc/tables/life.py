"""Life of a joint that wears: what running time does, and after how many hours too many parts break a limit."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

import pandas as pd

from tolmc import quantities
from tolmc.runs.life import LifeResult
from tolmc.study.study import Study
from tolmc.tables.table import Estimated, Note, Share, Table, cells
from tolmc.text.phrases import unit
from tolmc.text.plain import number

_MOST_COLUMNS = 4


def life_blocks(result: LifeResult) -> Iterator[Table | Note]:
    """The table against running time, and the life in a sentence."""
    yield life_table(result.table, result.study, result.shown[:_MOST_COLUMNS])
    first, *others = life_sentences(result)
    yield Note(first, strong=_hours(result.life.value), is_apart=True)
    yield from map(Note, others)


def life_sentences(result: LifeResult) -> list[str]:
    """The life, how it was found, and what is not known."""
    sentences = [life_sentence(result), _how(result)]
    unknown = int(result.table["unknown"].max())
    if unknown:
        sentences.append(
            f"Up to {unknown:,} of {result.study.samples:,} parts have no numbers at some time (contact lost, or a motion that "
            "failed); the shares and the life's interval count them both ways."
        )
    return sentences


def shown_in(table: pd.DataFrame) -> tuple[str, ...]:
    """The outputs of a table against running time, as many as a page has room for."""
    names = (column.removesuffix(" q50") for column in table if column.endswith(" q50"))
    return tuple(name for name in names if quantities.is_known(name))[:_MOST_COLUMNS]


def life_sentence(result: LifeResult) -> str:
    """After how many hours the parts break their limits."""
    share = f"{100 * result.section.broken_share:.4g} %"
    value, low, high = result.life
    running = _hours(result.table.index[-1])
    if math.isinf(value):
        sure = "" if math.isinf(low) else f" (95 % interval: from {_hours(low)})"
        return f"{share} of the parts break a limit after more than {running}, the running time{sure}."
    until = f"more than {running}" if math.isinf(high) else _hours(high)
    return f"{share} of the parts break a limit after {_hours(value)} (95 % interval: {_hours(low)} to {until})."


def _hours(hours: float) -> str:
    return f"{hours:,.4g} h" if hours < 1e4 else f"{hours:,.0f} h"


def _how(result: LifeResult) -> str:
    steps = len(result.table) - 1
    length = _hours(result.table.index[1])
    chosen = (
        "as the study has it"
        if math.isnan(result.step_error)
        else f"twice as many change the nominal joint's worn depth by {100 * result.step_error:.2g} %"
    )
    arc = math.degrees(result.contact_arc)
    shape = "in the journal's own shape"
    spread = (
        "all round" if arc >= 360.0 else shape if arc < 1.0 else f"over an arc of {arc:.3g} deg and {shape} at its ends"
    )
    return (
        f"Wear by Archard's law in {steps} steps of {length} ({chosen}), each a study of {result.study.samples:,} parts; the "
        f"bore wears along its whole length, {spread}. Ranges are 5 % to 95 % of the parts."
    )


def life_table(table: pd.DataFrame, study: Study, shown: Iterable[str]) -> Table:
    """The ``shown`` outputs and the share of good parts against running time, of :class:`tolmc.runs.life.LifeResult`."""
    shown = tuple(shown)
    rows = []
    for hours, row in table.iterrows():
        values: list[Estimated | str] = []
        for name in shown:
            factor = quantities.shown(name)[1]
            low, high = (number(factor * row[f"{name} {key}"], 4) for key in ("q5", "q95"))
            values += [Estimated.of(row, f"{name} q50", factor, narrow=4), f"{low} to {high}"]
        rows.append(cells(f"{hours:,.6g}", *values, Share.of(row, "inside")))
    heads = [head for name in shown for head in (f"{quantities.label(name)} ({unit(name)})", "5 % to 95 %")]
    return Table(
        "life",
        ("Hours", *heads, "inside the limits"),
        tuple(rows),
        title=f"{study.title}: {study.samples:,} parts that wear",
        caption="Medians over the parts with their 95 % intervals, ranges between 5 % and 95 % of the parts, and the share of "
        "the parts that keep every limit.",
        frame=table,
        is_dense=True,
    )
