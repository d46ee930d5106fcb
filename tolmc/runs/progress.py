"""A progress bar on the terminal, for work that turns out to be long."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pyarrow as pa

_LONG = 1.0  # seconds


@contextmanager
def progress(title: str, total: int, done: int = 0) -> Iterator[Callable[[Iterator[pa.Table]], Iterator[pa.Table]]]:
    """Gives a function that passes tables through and counts their rows, ``done`` of ``total`` being there already.

    The bar appears on stderr after a second, in a terminal only.
    """
    if sys.stderr is None or sys.stderr.closed or not sys.stderr.isatty():  # closed or None: pythonw, a service
        yield lambda tables: tables
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    name = TextColumn("{task.description}", markup=False)
    columns = name, BarColumn(), MofNCompleteColumn(), TextColumn("samples"), TimeRemainingColumn()
    bar = Progress(*columns, console=Console(stderr=True), transient=True)
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
