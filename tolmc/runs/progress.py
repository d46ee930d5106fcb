"""What long work is doing: a line on the terminal or in a notebook, elsewhere one on standard error now and then."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from importlib.util import find_spec
from typing import TYPE_CHECKING, TypeAlias

from tolmc.simulation.compilation import compilations

if TYPE_CHECKING:
    import pyarrow as pa

_LONG = 1.0  # seconds until the line appears
_SELDOM = 30.0  # seconds until the first line where nothing can be drawn over; the next ones after twice as long each
_Passed: TypeAlias = "Callable[[Iterator[pa.Table]], Iterator[pa.Table]]"


@contextmanager
def progress(title: str, total: int | None = None, done: int = 0) -> Iterator[_Passed]:
    """Gives a function that passes tables through and counts their rows, ``done`` of ``total`` being there already.

    The line appears after a second, on stderr in a terminal or below the cell of a notebook that has ipywidgets, and says when
    kernels are being compiled. Elsewhere stderr gets a line after half a minute, and others after twice as long each.
    """
    on_terminal = sys.stderr is not None and not sys.stderr.closed and sys.stderr.isatty()  # closed or None: a service
    drawn = on_terminal or _in_notebook()
    with _drawn(title, total, done, on_terminal) if drawn else _written(title, total, done) as counted:
        yield counted


@contextmanager
def _drawn(title: str, total: int | None, done: int, on_terminal: bool) -> Iterator[_Passed]:
    """A line that is drawn over."""
    from rich.console import Console, RenderableType
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    began = time.perf_counter()

    class Line(Progress):
        def get_renderables(self) -> Iterator[RenderableType]:
            if time.perf_counter() - began > _LONG:
                yield from super().get_renderables()

    name = TextColumn("{task.description}", markup=False)
    counting = (BarColumn(), MofNCompleteColumn(), TextColumn("samples"), TimeRemainingColumn())
    columns = counting if total else (TimeElapsedColumn(),)
    line = Line(name, *columns, console=Console(stderr=on_terminal), transient=True)
    task = line.add_task(title, total=total, completed=done)

    def counted(tables: Iterator[pa.Table]) -> Iterator[pa.Table]:
        for table in tables:
            line.advance(task, table.num_rows)
            yield table

    def say(words: str = "") -> None:
        line.update(task, description=f"{title}: {words}" if words else title)

    with line, compilations(say, say):
        yield counted


@contextmanager
def _written(title: str, total: int | None, done: int) -> Iterator[_Passed]:
    """Lines on standard error, few of them."""
    is_over, rows, doing, began = threading.Event(), [done], [""], time.perf_counter()

    def now_and_then() -> None:
        wait = _SELDOM
        while not is_over.wait(wait):
            words = f": {doing[0]}" if doing[0] else ""
            count = f", {rows[0]:,} of {total:,} samples" if total else ""
            _write(f"{title}{words}{count}, {time.perf_counter() - began:.0f} s")
            wait *= 2.0

    def counted(tables: Iterator[pa.Table]) -> Iterator[pa.Table]:
        for table in tables:
            rows[0] += table.num_rows
            yield table

    def say(words: str = "") -> None:
        doing[0] = words

    teller = threading.Thread(target=now_and_then, daemon=True)
    teller.start()
    try:
        with compilations(say, say):
            yield counted
    finally:
        is_over.set()
        teller.join()


def _write(sentence: str) -> None:
    # Standard error that is closed, None or gone must not cost a run.
    with suppress(OSError, ValueError, AttributeError):
        sys.stderr.write(f"{' '.join(sentence.split())}\n")
        sys.stderr.flush()


def _in_notebook() -> bool:
    """Whether a notebook runs this that can draw the bar; rich draws it by ipywidgets."""
    if "IPython" not in sys.modules or find_spec("ipywidgets") is None:
        return False
    from rich.console import Console

    return Console().is_jupyter
