"""`tolmc report`: a finished run as one file to read."""

from __future__ import annotations

from pathlib import Path

from tolmc.commands.answers import write_answers
from tolmc.commands.written import written
from tolmc.report.write import write_report


def report_run(directory: Path) -> None:
    """Write the answers and the report of the run in ``directory``."""
    write_answers(directory)
    written(write_report(directory))
