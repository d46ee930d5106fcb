"""When kernels are being compiled: what long work says of itself meanwhile."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from numba.core import event

# How long that takes at first; the one-sided kernels are the longest.
_WORDS = "compiling kernels, once, about {}"
_TIMES = {True: "20 s", False: "10 s"}


class _Listener(event.Listener):
    """Tells when the outermost of tolmc's compilations begins and ends; what is read from the cache is none."""

    def __init__(self, began: Callable[[str], None], ended: Callable[[], None]) -> None:
        self._began, self._ended = began, ended
        self._depth, self._lock = 0, threading.Lock()

    def on_start(self, event: event.Event) -> None:
        module = event.data["dispatcher"].py_func.__module__
        if not module.startswith("tolmc."):
            return
        with self._lock:
            self._depth += 1
            if self._depth > 1:
                return
        self._began(_WORDS.format(_TIMES["one_sided" in module]))

    def on_end(self, event: event.Event) -> None:
        if not event.data["dispatcher"].py_func.__module__.startswith("tolmc."):
            return
        with self._lock:
            self._depth -= 1
            if self._depth > 0:
                return
        self._ended()


@contextmanager
def compilations(began: Callable[[str], None], ended: Callable[[], None]) -> Iterator[None]:
    """Calls ``began`` with words for it when kernels are compiled within the context, in any thread, and then ``ended``."""
    with event.install_listener("numba:compile", _Listener(began, ended)):
        yield
