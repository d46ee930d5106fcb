"""`tolmc report`: a finished run as one file to read."""

from __future__ import annotations

from pathlib import Path

import click

from tolmc.commands.answers import write_answers
from tolmc.commands.written import written
from tolmc.report.write import write_report
from tolmc.runs import directory as run_directory
from tolmc.statistics.outcomes import ENOUGH_COMPUTED, computed_share
from tolmc.statistics.summary import count_statuses
from tolmc.text.phrases import too_few_computed


def report_run(directory: Path) -> bool:
    """Write the answers and the report of the run in ``directory``.

    Returns whether enough samples could be computed for the run to stand for the parts; says so first where not.
    """
    write_answers(directory)
    report = write_report(directory)
    statuses = count_statuses(run_directory.read(directory).read(columns=["status"]).to_pandas())
    if warning := too_few_computed(statuses):
        click.echo(warning)
    written(report)
    return computed_share(statuses) >= ENOUGH_COMPUTED
