"""`tolmc answers`: the four answers of a finished run, side by side."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from tolmc.allocation.explored import explore
from tolmc.allocation.next_change import next_changes
from tolmc.analysis.four_answers import Answers, four_answers
from tolmc.analysis.surrogate import MotionsFailed
from tolmc.commands.written import written
from tolmc.errors import InputError
from tolmc.runs import directory as run_directory
from tolmc.runs.progress import progress
from tolmc.runs.worst import draw_worst
from tolmc.statistics.outcomes import ANY_REQUIREMENT
from tolmc.study.sections import TARGET_YIELD
from tolmc.study.study import Study
from tolmc.tables.stackup import answers_blocks
from tolmc.tables.table import Note
from tolmc.terminal.grid import show


def write_answers(directory: str | Path) -> Answers:
    """The answers of the finished run in ``directory``, written there as CSV files for the report to show.

    Raises
    ------
    InputError
        When the run is not finished.
    """
    opened = run_directory.read(directory)
    summary = opened.path / "summary.csv"
    if not opened.is_complete or not summary.exists():
        raise InputError(f"{directory}: the run is not finished. Finish it with: tolmc run --resume {directory}")
    requirements = pd.read_csv(opened.path / "requirements.csv").set_index("requirement")
    statistics = pd.read_csv(summary).set_index("output")
    study = opened.study()
    with progress(f"{study.title}: answers"):
        answers = four_answers(study, statistics, requirements)
    for name, table in answers.files().items():
        opened.write_text(name, table.to_csv(index=table.index.names != [None]))
    if answers.stackup is not None:
        with progress(f"{study.title}: surrogates"):
            opened.write_text("surrogate.json", explore(study, statistics).json())
    with progress(f"{study.title}: worst sample"):
        draw_worst(opened)
    target = study.target or TARGET_YIELD
    (opened.path / "next_changes.csv").unlink(missing_ok=True)  # of a shorter run
    asks = study.specification and study.formulation == "slope"
    if asks and 1.0 - requirements.at[ANY_REQUIREMENT, "share_most_high"] < target:
        with progress(f"{study.title}: what to change next"):
            changes = _next_changes(study, target)
        opened.write_text("next_changes.csv", changes.to_csv(index=False))
    return answers


def _next_changes(study: Study, target: float) -> pd.DataFrame:
    """What to change next; nothing where motions fail, so that nothing can be predicted."""
    try:
        return next_changes(study, target)
    except MotionsFailed:
        return pd.DataFrame()


def answer_run(directory: Path) -> None:
    """Print and write the answers of the run in ``directory``."""
    answers = write_answers(directory)
    if answers.stackup is None:
        show([Note("No answers beside the run's own: no dimension varies, or the formulation is not 'slope'.")])
        return
    show(answers_blocks(answers))
    written(directory, answers.files())
