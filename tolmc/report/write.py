"""The report of a run: one HTML file that needs nothing else, the same as Markdown, and its tables as CSV files.

    DIR/report.html    to read, to print and to attach to a drawing
    DIR/report.md      the same sentences and tables
    DIR/tables/*.csv   the tables in full precision

It is made from what the run directory holds: no motion is computed for it. Beside samples, summary and pictures a run may
leave there, for the report to show, ``stackup.csv`` (:func:`tolmc.analysis.side_by_side.side_by_side`),
``one_at_a_time.csv`` and ``sobol_indices.csv`` (the functions of that name in :mod:`tolmc.analysis`), and ``surrogate.json``
(:mod:`tolmc.allocation.explored`), with which the HTML file answers what other tolerances would do.
"""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape
from markupsafe import Markup, escape

from tolmc.report.content import report_content
from tolmc.runs import directory as run_directory
from tolmc.runs.record import RunDirectoryError
from tolmc.text import typeset

__all__ = ["write_report"]


def write_report(directory: str | Path) -> Path:
    """Write the report of the finished run in ``directory`` into it; returns the path of the HTML file.

    Raises
    ------
    RunDirectoryError
        When the directory holds no run, a run that is not finished, or files that are damaged.
    InputError
        When the study asks for a yield that cannot be read.
    """
    run = run_directory.read(directory)
    if not run.is_complete:
        raise RunDirectoryError(
            f"{run.path}: the run is not finished, so there is nothing to report yet. Finish it with: tolmc run --resume "
            f"{run.path}"
        )
    if run.rows() != run.record["samples"]:
        raise RunDirectoryError(
            f"{run.samples_path} holds {run.rows()} samples, {run.record['samples']} are expected. Restore it, or run the "
            "study into a new directory."
        )
    content = report_content(run)
    (run.path / "tables").mkdir(exist_ok=True)
    for table in content["tables"]:
        run.write_text(f"tables/{table.name}.csv", table.csv())
    content["tables"] = {table.name: table.written(typeset) for table in content["tables"]}
    environment = _environment()
    for name in ("report.md", "report.html"):
        run.write_text(name, environment.get_template(name).render(content))
    return run.path / "report.html"


@cache
def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("tolmc.report"),
        autoescape=select_autoescape(["html"]),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters.update(css=_css_string, symbols=_symbols, markdown=_markdown, fence=_fence, raw=Markup)
    return environment


def _css_string(text: str) -> str:
    """Text for between quotes in a style sheet, where nothing of it can end the string or the sheet."""
    return "".join(c if c == " " or (c.isascii() and c.isalnum()) else f"\\{ord(c):x} " for c in text)


def _symbols(text: str, subscript: str = "<i>N</i><sub>{}</sub>") -> Markup:
    """HTML of a text with the symbols of the contact forces set as such."""
    return Markup(re.sub("N_([DE])", lambda match: subscript.format(match[1]), str(escape(text))))


def _markdown(text: str) -> str:
    """Text in which Markdown sees no markup."""
    return re.sub(r"([\\`*_|<>\[\]#])", r"\\\1", text)


def _fence(text: str) -> str:
    """A fence longer than any in the text."""
    return "`" * (1 + max([2, *map(len, re.findall("`+", text))]))
