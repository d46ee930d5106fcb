"""What is watched along a motion: each watcher turns a block's steps into rows of the results.

A watcher is made for one :class:`tolmc.kernels.system.System` and has four functions:

``begin(run, block, y, coef, work)``
    Before the first step, y the states at t = 0.
``look(run, step, end, coef, seen, work)``
    After each step, with its end and what it saw.
``scan(run, block, window, coef, work)``
    At the intervals of a :class:`tolmc.kernels.seen.Window`, each interval of a motion once; only where forces are watched.
``finish(run, block, y, coef, work)``
    After the last step, y the states at the end; writes the watcher's rows of ``run.out`` (:mod:`tolmc.kernels.results`).

The order of a kernel's watchers is that of their work: who ends a lane's motion comes before who reads where it ends.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from tolmc.kernels.jit import chain, inlined


@dataclass(frozen=True)
class Watcher:
    """Functions of one watcher; None: nothing to do."""

    begin: Callable | None = None
    look: Callable | None = None
    scan: Callable | None = None
    finish: Callable | None = None


def together(watchers: Sequence[Watcher]) -> Watcher:
    """One watcher that does all of ``watchers``' work, in their order."""
    pairs = {"begin": _pair, "look": _pair_of_looks, "scan": _pair, "finish": _pair}
    return Watcher(**{
        name: chain([one for watcher in watchers if (one := getattr(watcher, name))], pair) for name, pair in pairs.items()
    })  # fmt: skip


def _pair(first: Callable, second: Callable) -> Callable:
    @inlined
    def both(run, block, at, coef, work):
        first(run, block, at, coef, work)
        second(run, block, at, coef, work)

    return both


def _pair_of_looks(first: Callable, second: Callable) -> Callable:
    @inlined
    def both(run, step, end, coef, seen, work):
        first(run, step, end, coef, seen, work)
        second(run, step, end, coef, seen, work)

    return both
