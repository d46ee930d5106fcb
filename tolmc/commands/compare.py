"""`tolmc compare`: two runs side by side."""

from __future__ import annotations

from pathlib import Path

from tolmc.commands.written import written
from tolmc.runs.compare import compare_runs
from tolmc.tables.compare import comparison_blocks
from tolmc.tables.page import document
from tolmc.terminal.grid import show


def compare_directories(first: Path, second: Path, *, out: Path | None) -> None:
    """Compare the runs in two directories; ``out`` is an HTML file to write the comparison into too."""
    found = compare_runs(first, second)
    blocks = list(comparison_blocks(found))
    show(blocks)
    if out is not None:
        out.write_text(document(blocks, f"{first} and {second}"), encoding="utf-8")
        written(out)
