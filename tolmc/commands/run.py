"""`tolmc run`: a study's samples and their statistics."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, cast

import click

from tolmc.commands.check import check_prices
from tolmc.commands.compare_sections import compare_run
from tolmc.commands.written import written
from tolmc.runs import run as monte_carlo
from tolmc.statistics.outcomes import ENOUGH_COMPUTED
from tolmc.study.file import load_study
from tolmc.study.slips import slips
from tolmc.tables.run import brief_blocks, run_blocks, run_notes
from tolmc.terminal.grid import show
from tolmc.tolerances.interference import interference_note


def run_study(study: Path, shown: Mapping[str, bool], *, out: Path | None, **options: Any) -> bool:
    """Run the study file into ``out``; options are those of :func:`tolmc.runs.run.run`.

    Returns whether enough samples could be computed for the run to stand for the parts.

    ``shown``: "brief", "as_json", or sections to "compare".
    """
    loaded = load_study(study)
    check_prices(loaded)
    if note := interference_note(loaded.tolerances, loaded.scene.scalars):
        _note(note)
    for slip in slips(loaded):
        _note(slip)
    directory, tables = out or monte_carlo.default_directory(study), _Tables(shown)
    result = monte_carlo.run(loaded, out=directory, on_summary=tables.show, **options)
    _show_rest(result, cast(Path, result.directory), shown, tables)
    return result.computed_share >= ENOUGH_COMPUTED


def _note(sentence: str) -> None:
    # Standard error that cannot be written must not cost a run.
    with suppress(OSError):
        click.echo(f"Note: {sentence}", err=True)


def resume_run(directory: Path, shown: Mapping[str, bool], **options: Any) -> bool:
    """Go on with the run in ``directory``, as :func:`run_study`; options are those of :func:`tolmc.runs.run.resume`."""
    tables = _Tables(shown)
    result = monte_carlo.resume(directory, on_summary=tables.show, **options)
    _show_rest(result, result.directory or directory, shown, tables)
    return result.computed_share >= ENOUGH_COMPUTED


class _Tables:
    """The tables of a run, shown while its pictures are drawn: a reader that is gone costs nothing of what is still written."""

    def __init__(self, shown: Mapping[str, bool]) -> None:
        self._shown = shown
        self.failure: OSError | SystemExit | None = None

    def show(self, result: monte_carlo.StudyResult) -> None:
        if self._shown["as_json"]:
            return
        try:
            show(brief_blocks(result) if self._shown["brief"] else run_blocks(result))
        except (OSError, SystemExit) as error:  # the second is what rich makes of a closed pipe
            self.failure = error


def _show_rest(result: monte_carlo.StudyResult, directory: Path, shown: Mapping[str, bool], tables: _Tables) -> None:
    """What is known at a run's end."""
    if tables.failure is not None:
        raise tables.failure
    if shown["as_json"]:
        click.echo(json.dumps(record(result), indent=1, ensure_ascii=False))
        return
    if not shown["brief"]:
        show(run_notes(result))
    written(directory, ("samples.parquet", "summary.csv", "pictures"))
    if result.sequential is not None:
        click.echo(result.sequential.sentence())
    if shown["compare"]:
        compare_run(result, directory)


def record(result: monte_carlo.StudyResult) -> dict[str, Any]:
    """What a run found as JSON has it, SI units; null where there is no number."""
    tables = {"summary": result.summary, "requirements": result.requirements, "statuses": result.statuses}
    study = result.study
    return {
        "title": study.title,
        "samples": study.samples,
        "sampling": study.sampling,
        "seed": study.seed,
        "seconds": round(result.elapsed, 3),
        "computed_share": result.computed_share,
        "directory": None if result.directory is None else str(result.directory),
        "nominal": {name: _json(value) for name, value in result.nominal.items()},
        **{
            name: {str(row): {key: _json(value) for key, value in values.items()} for row, values in table.iterrows()}
            for name, table in tables.items()
        },
    }


def _json(value: Any) -> Any:
    value = value.item() if hasattr(value, "item") else value
    return None if isinstance(value, float) and not math.isfinite(value) else value
