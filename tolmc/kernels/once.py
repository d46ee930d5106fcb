"""Results that are made once."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import cache, wraps


def once(build: Callable) -> Callable:
    """A function that makes its result once for each choice of arguments, also when threads ask at the same time."""
    made, lock = cache(build), threading.RLock()

    @wraps(build)
    def build_once(*choice, **choices):
        with lock:
            return made(*choice, **choices)

    return build_once
