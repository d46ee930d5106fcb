"""Who is told when kernels are being compiled."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager


class _Listener:
    """Tells when the outermost compilation begins and ends."""

    def __init__(self, began: Callable[[str], None], ended: Callable[[], None]) -> None:
        self._began, self._ended = began, ended
        self._depth, self._lock = 0, threading.Lock()

    def begin(self, module: str) -> None:
        with self._lock:
            self._depth += 1
            if self._depth > 1:
                return
        self._began(module)

    def end(self) -> None:
        with self._lock:
            if self._depth == 0:  # it has come while one was under way
                return
            self._depth -= 1
            if self._depth > 0:
                return
        self._ended()


_LISTENERS: list[_Listener] = []


def begin(module: str) -> None:
    """Something of a module of this name begins to be compiled; what is read from the disk is not."""
    for listener in tuple(_LISTENERS):
        listener.begin(module)


def end() -> None:
    """And that has ended."""
    for listener in tuple(_LISTENERS):
        listener.end()


@contextmanager
def compiling(module: str) -> Iterator[None]:
    """A context in which something of this module is compiled, by whatever process."""
    begin(module)
    try:
        yield
    finally:
        end()


@contextmanager
def listening(began: Callable[[str], None], ended: Callable[[], None]) -> Iterator[None]:
    """Calls ``began(module)`` when a compilation begins within the context, in any thread, and then ``ended()``."""
    listener = _Listener(began, ended)
    _LISTENERS.append(listener)
    try:
        yield
    finally:
        _LISTENERS.remove(listener)
