"""Tables and notes on a terminal, drawn by rich."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from rich import box
from rich.console import Console, ConsoleOptions
from rich.measure import Measurement
from rich.table import Table as RichTable
from rich.text import Text

from tolmc.tables.table import Note, Table, Written, WrittenCell, plain

_TONES = {"bad": "bold red", "heading": "bold"}
#: Wider than any table.
_UNLIMITED = 10_000


def show(blocks: Iterable[Table | Note], console: Console | None = None) -> None:
    """Print tables and notes in their order."""
    console = console or standard_output()
    for block in blocks:
        if isinstance(block, Table):
            console.print(Grid(block.written(plain)))
        else:
            console.print(_sentence(block))


def standard_output() -> Console:
    """The console of standard output; a pipe or a file has no width that a table must fit."""
    console = Console()
    return console if console.is_terminal else Console(width=_UNLIMITED)


def _sentence(note: Note) -> Text:
    text = Text(f"\n{note.text}" if note.is_apart else note.text)
    start = text.plain.find(note.strong)
    text.stylize("bold", start, start + len(note.strong))
    return text


class Grid:
    """A table that is never cut: columns that do not fit stand below, beside the first column again."""

    def __init__(self, table: Written) -> None:
        self.table = table
        self._rows = [[_text(cell, table.is_dense) for cell in row] for row in table.rows]

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[RichTable]:
        part = [0]
        for column in range(1, len(self.table.header)):
            if len(part) > 1 and not self._fits([*part, column], console, options):
                yield self._part(part)
                part = [0]
            part.append(column)
        yield self._part(part)

    def _fits(self, part: Sequence[int], console: Console, options: ConsoleOptions) -> bool:
        if options.max_width >= _UNLIMITED:  # to measure a run's tables takes as long as to print them
            return True
        width = Measurement.get(console, options.update(width=_UNLIMITED), self._part(part)).maximum
        return width <= options.max_width

    def _part(self, part: Sequence[int]) -> RichTable:
        title = Text(self.table.title, style="bold") if 1 in part or len(self.table.header) == 1 else None
        drawn = RichTable(title=title, title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
        for i in part:
            heading, is_left = Text(self.table.header[i]), i in self.table.left
            drawn.add_column(heading, justify="left" if is_left else "right", overflow="fold")
        for row in self._rows:
            drawn.add_row(*(row[i] for i in part))
        return drawn


def _text(cell: WrittenCell, is_dense: bool) -> Text:
    """The cell with its small print below, or in a dense table beside it: in brackets unless it is a spread."""
    text = Text(" ".join([cell.text, "/".join(cell.deviations)]).strip(" ") if cell.deviations else cell.text)
    text.stylize(_TONES.get(cell.tone, ""))
    if not cell.detail:
        return text
    detail = cell.detail
    if is_dense and cell.text and not (detail.startswith("±") or detail == "open"):
        detail = f"({detail})"
    between = ("" if not cell.text else " ") if is_dense else "\n"
    return text.append(between).append(detail, style="dim")
