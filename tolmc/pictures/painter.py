"""Pictures painted by another process, which loads Matplotlib while this one loads and runs what computes.

Loading Matplotlib and drawing a run's pictures take a second, as long as all else that a short run does.
"""

from __future__ import annotations

import gc
import os
import pickle
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from tolmc import quantities

_painter: subprocess.Popen[bytes] | None = None


@contextmanager
def painter() -> Iterator[None]:
    """A context in which :func:`paint` leaves pictures to another process, where that saves time."""
    global _painter
    if "matplotlib" in sys.modules or not sys.executable or os.cpu_count() == 1:
        yield
        return
    # -P: the working folder of the user may hold files named as modules are.
    command, pipe = [sys.executable, "-P", "-m", __spec__.name], subprocess.PIPE
    # A pipe that is broken holds what the other process did not take, and is painted here.
    with (
        suppress(BrokenPipeError),
        subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL) as other,
    ):
        _painter = other
        try:
            yield
        finally:
            _painter = None
            other.kill()


def paint(path: Path, draw: str, *shown, **words) -> None:
    """The picture ``plots.draw(*shown, **words)`` as a file; ``shown`` and ``words`` can be pickled."""
    if _painter is not None and _left_to(_painter, path, draw, shown, words):
        return
    from tolmc.pictures import plots

    plots.save(getattr(plots, draw)(*shown, **words), path)


def _left_to(painter: subprocess.Popen[bytes], *picture) -> bool:
    """Whether the other process has painted it: not where it is gone, as it is after anything that goes wrong there."""
    assert painter.stdin is not None and painter.stdout is not None
    with suppress(OSError):
        pickle.dump((quantities.derived(), *picture), painter.stdin)
        painter.stdin.flush()
        return painter.stdout.read(1) == _PAINTED
    return False


_PAINTED = b"."


def _serve() -> None:
    """Paint what comes in, until nothing does."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # it is for the process that began this one, which then ends it
    gc.disable()  # for a few pictures
    from tolmc.pictures import plots

    with suppress(EOFError):
        while True:
            outputs, path, draw, shown, words = pickle.load(sys.stdin.buffer)
            for output in outputs:
                quantities.derive(output)
            plots.save(getattr(plots, draw)(*shown, **words), path)
            sys.stdout.buffer.write(_PAINTED)
            sys.stdout.buffer.flush()


if __name__ == "__main__":
    _serve()
