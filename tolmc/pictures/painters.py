"""Pictures painted by other processes, which load Matplotlib while this one loads and runs what computes.

Loading Matplotlib and drawing a run's pictures take a second, as long as all else that a short run does.
"""

from __future__ import annotations

import gc
import os
import pickle
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from queue import SimpleQueue
from typing import BinaryIO, cast

from tolmc import quantities

#: Pictures that are painted at a time.
PAINTERS = 2
_DONE = b"."

# What leads to each painter that has nothing to paint; None where pictures are drawn here.
_idle: SimpleQueue[BinaryIO] | None = None
_here = threading.Lock()  # Matplotlib is for one thread at a time


@contextmanager
def painters() -> Iterator[subprocess.Popen | None]:
    """A context in which :func:`paint` leaves pictures to other processes, where that saves time; gives the first of them."""
    global _idle
    if "matplotlib" in sys.modules or not hasattr(os, "fork") or not sys.executable or os.cpu_count() == 1:
        yield None
        return
    with ExitStack() as opened:
        pairs = [[opened.enter_context(end) for end in socket.socketpair()] for _ in range(PAINTERS)]
        process = _begun([theirs.fileno() for _, theirs in pairs])
        if process is not None:
            opened.enter_context(process)
            opened.callback(process.kill)
            _idle = SimpleQueue()
            for ours, theirs in pairs:
                theirs.close()
                stream = cast(BinaryIO, ours.makefile("rwb"))
                opened.callback(_closed, stream)
                _idle.put(stream)
        try:
            yield process
        finally:
            _idle = None


def _begun(numbers: list[int]) -> subprocess.Popen | None:
    """A process that paints for these sockets; None where the system refuses one."""
    # -P: the working folder of the user may hold files named as modules are.
    command = [sys.executable, "-P", "-m", __spec__.name, *map(str, numbers)]
    alone, null = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}, subprocess.DEVNULL  # threads don't survive a fork
    with suppress(OSError):
        return subprocess.Popen(command, env=alone, pass_fds=numbers, stdin=null, stdout=null, stderr=null)
    return None


def _closed(stream: BinaryIO) -> None:
    with suppress(OSError):  # of a painter that is gone, with what it did not take
        stream.close()


def paint(path: Path, draw: str, *shown, **words) -> None:
    """The picture ``plots.draw(*shown, **words)`` as a file; ``shown`` and ``words`` can be pickled."""
    if _idle is not None and _left_to(_idle, path, draw, shown, words):
        return
    from tolmc.pictures import plots

    with _here:
        plots.save(getattr(plots, draw)(*shown, **words), path)


def _left_to(idle: SimpleQueue[BinaryIO], *picture) -> bool:
    """Whether a painter has painted it: not where it is gone, as it is after anything that goes wrong there."""
    painter = idle.get()
    try:
        pickle.dump((quantities.derived(), *picture), painter, pickle.HIGHEST_PROTOCOL)
        painter.flush()
        return painter.read(1) == _DONE
    except OSError:
        return False
    finally:
        idle.put(painter)


def _serve(numbers: list[int]) -> None:
    """A painter at the other end of each of these sockets; they share what is loaded."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # it is for the process that began this one, which then ends it
    gc.disable()  # for a few pictures
    from tolmc.pictures import plots

    plots.warm_up()  # while there is nothing to paint yet; before the fork, for all painters
    own = next((number for number in numbers[1:] if os.fork() == 0), numbers[0])
    for number in numbers:
        if number != own:
            os.close(number)  # which else would stay open where its painter is gone
    _paint_from(own)


def _paint_from(number: int) -> None:
    """Paint what comes in, until nothing does."""
    from tolmc.pictures import plots

    with socket.socket(fileno=number) as end, end.makefile("rwb") as stream, suppress(EOFError):
        while True:
            outputs, path, draw, shown, words = pickle.load(stream)
            for output in outputs:
                quantities.derive(output)
            plots.save(getattr(plots, draw)(*shown, **words), path)
            stream.write(_DONE)
            stream.flush()


if __name__ == "__main__":
    _serve([int(number) for number in sys.argv[1:]])
