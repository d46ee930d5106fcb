"""When kernels are being compiled: what long work says of itself meanwhile."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager

from tolmc.kernels.notices import listening

# How long that takes at first; the one-sided kernels are the longest.
_WORDS = "compiling kernels, once, about {}"
_TIMES = {True: "20 s", False: "10 s"}


def compilations(began: Callable[[str], None], ended: Callable[[], None]) -> AbstractContextManager[None]:
    """Calls ``began`` with words for it when kernels are compiled within the context, in any thread, and then ``ended``."""
    return listening(lambda module: began(_WORDS.format(_TIMES["one_sided" in module])), ended)
