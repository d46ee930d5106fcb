"""What `tolmc check` has understood, for the terminal."""

from __future__ import annotations

from rich import box
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from tolmc.terminal.tables import standard_output


def print_understood(title: str, understood, console: Console | None = None) -> None:
    """The :class:`tolmc.commands.check.Understood` of a study."""
    console = console or standard_output()
    console.print(f"\n[bold]{escape(title)}[/]")
    dimensions = Table("Dimension", "nominal", "limits", "distribution", box=box.SIMPLE_HEAD, pad_edge=True)
    for row in understood.dimensions:
        dimensions.add_row(*map(escape, row))
    console.print(dimensions)
    grid = Table.grid(padding=(0, 2))
    grid.add_column(style="bold")
    grid.add_column(max_width=100)
    last = None
    for what, words in understood.facts:
        grid.add_row(f" {what}" if what != last else "", escape(words))
        last = what
    console.print(grid)
    for note in understood.notes:
        console.print(f"\n[bold]Note[/]: {escape(note)}", highlight=False, soft_wrap=True)
    console.print("\nThe study can be run.", highlight=False)
