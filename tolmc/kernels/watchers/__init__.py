"""What is watched along a motion: each watcher turns a block's steps into rows of the results.

A watcher is made for one :class:`tolmc.kernels.system.System` and has three functions, all with the arguments
``(run, block, step, y, end, coef, work)``:

``begin``
    Before the first step, y the states at t = 0.
``look``
    After each step, from y to end.
``finish``
    After the last step, y the states at the end; writes the watcher's rows of ``run.out`` (:mod:`tolmc.kernels.results`).

The order of a
kernel's watchers is that of their work: who shuts a gate of the system comes before who reads it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from tolmc.kernels.jit import inlined


@inlined
def nothing(run, block, step, y, end, coef, work):
    """A watcher's part that has nothing to do."""


@dataclass(frozen=True)
class Watcher:
    """Functions of one watcher."""

    begin: Callable = nothing
    look: Callable = nothing
    finish: Callable = nothing


def in_order(parts: list[Callable]) -> Callable:
    """One function that calls all ``parts``, flat: taking over functions within functions compiles slowly."""
    six = parts + [nothing] * (6 - len(parts))
    first, second, third, fourth, fifth, sixth = six

    @inlined
    def together(run, block, step, y, end, coef, work):
        first(run, block, step, y, end, coef, work)
        second(run, block, step, y, end, coef, work)
        third(run, block, step, y, end, coef, work)
        fourth(run, block, step, y, end, coef, work)
        fifth(run, block, step, y, end, coef, work)
        sixth(run, block, step, y, end, coef, work)

    return together
