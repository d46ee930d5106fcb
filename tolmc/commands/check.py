"""`tolmc check`: what a study file is understood to say."""

from __future__ import annotations

from pathlib import Path

from tolmc.study.file import load_study
from tolmc.study.study import Study
from tolmc.tables.understood import understood_blocks
from tolmc.terminal.grid import show


def check_study(path: Path) -> None:
    """Read and check a study file and say what it means; no motion is computed."""
    study = load_study(path)
    check_prices(study)
    show(understood_blocks(study))


def check_prices(study: Study) -> None:
    """StudyError where the study prices tolerances in a way that cannot be read, as ``tolmc allocate`` and reports do."""
    if "dimensions" in study.allocation:
        # What allocates loads half a second of packages, which other studies do not need.
        from tolmc.allocation.study_table import read_plan

        read_plan(study)
