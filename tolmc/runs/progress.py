"""A progress bar on the terminal or in a notebook, for work that turns out to be long."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.util import find_spec

import pyarrow as pa

_LONG = 1.0  # seconds


@contextmanager
def progress(title: str, total: int, done: int = 0) -> Iterator[Callable[[Iterator[pa.Table]], Iterator[pa.Table]]]:
    """Gives a function that passes tables through and counts their rows, ``done`` of ``total`` being there already.

    The bar appears after a second, on stderr in a terminal or below the cell of a notebook that has ipywidgets.
    """
    on_terminal = sys.stderr is not None and not sys.stderr.closed and sys.stderr.isatty()  # closed or None: a service
    if not (on_terminal or _in_notebook()):
        yield lambda tables: tables
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    name = TextColumn("{task.description}", markup=False)
    columns = name, BarColumn(), MofNCompleteColumn(), TextColumn("samples"), TimeRemainingColumn()
    console = Console(stderr=on_terminal)
    bar = Progress(*columns, console=console, transient=True)
    task = bar.add_task(title, total=total, completed=done)
    began = time.perf_counter()

    def counted(tables: Iterator[pa.Table]) -> Iterator[pa.Table]:
        for table in tables:
            bar.advance(task, table.num_rows)
            if time.perf_counter() - began > _LONG:
                bar.start()
            yield table

    try:
        yield counted
    finally:
        bar.stop()


def _in_notebook() -> bool:
    """Whether a notebook runs this that can draw the bar; rich draws it by ipywidgets."""
    if "IPython" not in sys.modules or find_spec("ipywidgets") is None:
        return False
    from rich.console import Console

    return Console().is_jupyter
