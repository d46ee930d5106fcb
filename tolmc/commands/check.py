"""`tolmc check`: what a study file is understood to say."""

from __future__ import annotations

from pathlib import Path

from tolmc.study.file import load_study
from tolmc.tables.understood import understood_blocks
from tolmc.terminal.grid import show


def check_study(path: Path) -> None:
    """Read and check a study file and say what it means; no motion is computed."""
    show(understood_blocks(load_study(path)))
