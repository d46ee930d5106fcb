"""What a table is before anybody sees it: columns, cells that hold values, and the notes around it.

A table is built once, of values. :meth:`Table.written` turns it into texts in a notation, :mod:`tolmc.text.plain` for a
terminal or :mod:`tolmc.text.typeset` for a page; whoever shows it (rich, HTML, Markdown) sees texts alone. Its CSV file holds
``frame``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

import pandas as pd

from tolmc.text import plain, typeset

__all__ = [
    "Cell",
    "Column",
    "Estimated",
    "Note",
    "Number",
    "Share",
    "Table",
    "Written",
    "WrittenCell",
    "cells",
    "plain",
    "typeset",
]


class Notation(Protocol):
    """How numbers are written: :mod:`tolmc.text.plain` or :mod:`tolmc.text.typeset`; pairs are a text and its small print."""

    def number(self, value: float, digits: int = ...) -> str: ...
    def to_decimals(self, value: float, decimals: int) -> str: ...
    def estimate(self, value: float, low: float, high: float, *, digits: int = ...) -> tuple[str, str]: ...
    def share(self, value: float, low: float, high: float) -> tuple[str, str]: ...


@dataclass(frozen=True)
class Number:
    """A value in the unit shown, to so many significant ``digits``, or to so many ``decimals``; ``unit`` stands behind it."""

    value: float
    digits: int = 5
    decimals: int | None = None
    unit: str = ""

    def texts(self, notation: Notation) -> tuple[str, str]:
        if self.decimals is None:
            text = notation.number(self.value, self.digits)
        else:
            text = notation.to_decimals(self.value, self.decimals)
        return (f"{text} {self.unit}" if self.unit and not math.isnan(self.value) else text), ""


@dataclass(frozen=True)
class Estimated:
    """A value in the unit shown with its interval, to at most ``digits`` on a page and ``narrow`` on a terminal."""

    value: float
    low: float
    high: float
    digits: int = 6
    narrow: int = 5

    @classmethod
    def of(cls, row: Mapping[str, float], key: str, factor: float = 1.0, **digits: int) -> Estimated:
        """From the entries ``key``, ``key_low`` and ``key_high``, times ``factor``."""
        value, low, high = (factor * row[f"{key}{end}"] for end in ("", "_low", "_high"))
        return cls(value, low, high, **digits)

    @property
    def ends(self) -> tuple[float, float, float]:
        """Value, low, high."""
        return self.value, self.low, self.high

    def texts(self, notation: Notation) -> tuple[str, str]:
        digits = self.narrow if notation is plain else self.digits
        return notation.estimate(*self.ends, digits=digits)


@dataclass(frozen=True)
class Share(Estimated):
    """A share of the samples with its interval, as a number from 0 to 1."""

    def texts(self, notation: Notation) -> tuple[str, str]:
        return notation.share(*self.ends)


@dataclass(frozen=True)
class Cell:
    """A cell: what it holds, a second line in small print, deviations in the manner of a drawing, and more for the eye.

    ``bar`` is a share from 0 to 1 that is drawn behind the text; ``tone`` one of "good", "bad", "open", or "heading" for a row
    that heads those below.
    """

    content: str | Number | Estimated = ""
    detail: str = ""
    deviations: tuple[str, ...] = ()
    bar: float | None = None
    tone: str = ""

    def written(self, notation: Notation) -> WrittenCell:
        text, detail = (self.content, "") if isinstance(self.content, str) else self.content.texts(notation)
        return WrittenCell(text, self.detail or detail, self.deviations, self.bar, self.tone)


@dataclass(frozen=True)
class WrittenCell:
    """A cell in texts."""

    text: str
    detail: str = ""
    deviations: tuple[str, ...] = ()
    bar: float | None = None
    tone: str = ""

    @property
    def line(self) -> str:
        """The cell in one line."""
        text = " ".join([self.text, "/".join(self.deviations)]).strip()
        return f"{text} ({self.detail})" if self.detail else text


def cells(*contents: Cell | str | Number | Estimated) -> tuple[Cell, ...]:
    """A row: what is no cell yet becomes one."""
    return tuple(content if isinstance(content, Cell) else Cell(content) for content in contents)


@dataclass(frozen=True)
class Column:
    """A column by its heading; ``words`` stand to the left, numbers to the right.

    ``only``: the notation in which the column is shown, where the other has no room or no need for it.
    """

    heading: str
    words: bool = False
    only: Notation | None = None


@dataclass(frozen=True)
class Written:
    """A table in texts: ``left`` are the columns that stand to the left."""

    name: str
    title: str
    caption: str
    header: tuple[str, ...]
    rows: tuple[tuple[WrittenCell, ...], ...]
    left: tuple[int, ...]
    is_dense: bool

    @property
    def alignment(self) -> tuple[str, ...]:
        """What Markdown has below the header."""
        return tuple(":--" if i in self.left else "--:" for i in range(len(self.header)))


@dataclass(frozen=True)
class Table:
    """A table of values.

    Attributes
    ----------
    name : str
        Of its CSV file and of its place in a report.
    columns : tuple of Column or str
        A str is the heading of a column of numbers; the first column always holds words.
    rows : tuple of rows of :func:`cells`
    title : str
        Above it on a terminal: what it shows.
    caption : str
        Below it on a page: what it shows, and how to read it.
    frame : DataFrame
        Its content in full precision, for the CSV file.
    is_dense : bool
        Whether small print stands beside the text, so that a row is a line, and not below it.
    """

    name: str
    columns: tuple[Column | str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    title: str = ""
    caption: str = ""
    frame: pd.DataFrame | None = field(default=None, repr=False)
    is_dense: bool = False

    def __bool__(self) -> bool:
        return bool(self.rows)

    def written(self, notation: Notation) -> Written:
        """The table in texts, with the columns that the notation shows."""
        columns = [Column(column) if isinstance(column, str) else column for column in self.columns]
        shown = [i for i, column in enumerate(columns) if column.only in (None, notation)]
        return Written(
            name=self.name,
            title=self.title,
            caption=self.caption,
            header=tuple(columns[i].heading for i in shown),
            rows=tuple(tuple(row[i].written(notation) for i in shown) for row in self.rows),
            left=tuple(place for place, i in enumerate(shown) if place == 0 or columns[i].words),
            is_dense=self.is_dense,
        )

    def csv(self) -> str:
        """The table in full precision, an unnamed index left out; "" without a frame."""
        return "" if self.frame is None else self.frame.to_csv(index=self.frame.index.names != [None])


@dataclass(frozen=True)
class Note:
    """A sentence beside tables: ``strong`` is the part of it that stands out, ``is_apart`` says that space goes before it."""

    text: str
    strong: str = ""
    is_apart: bool = False
