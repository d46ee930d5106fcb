"""`tolmc run`: a study's samples and their statistics."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from tolmc.commands.compare_sections import compare_run
from tolmc.commands.written import written
from tolmc.runs import run as monte_carlo
from tolmc.study.file import load_study
from tolmc.tables.run import run_blocks
from tolmc.terminal.grid import show
from tolmc.tolerances.interference import interference_note


def run_study(study: Path, *, out: Path | None, compare: bool, **options: Any) -> None:
    """Run the study file into ``out``; options are those of :func:`tolmc.runs.run.run`."""
    loaded = load_study(study)
    if note := interference_note(loaded.tolerances, loaded.scene.scalars):
        click.echo(f"Note: {note}", err=True)
    out = out or monte_carlo.default_directory(study)
    result = monte_carlo.run(loaded, out=out, **options)
    _show(result, result.directory or out, compare)


def resume_run(directory: Path, *, compare: bool, **options: Any) -> None:
    """Go on with the run in ``directory``; options are those of :func:`tolmc.runs.run.resume`."""
    result = monte_carlo.resume(directory, **options)
    _show(result, result.directory or directory, compare)


def _show(result: monte_carlo.StudyResult, directory: Path, compare: bool) -> None:
    show(run_blocks(result))
    written(directory, ("samples.parquet", "summary.csv", "pictures"))
    if result.sequential is not None:
        click.echo(result.sequential.sentence())
    if compare:
        compare_run(result, directory)
