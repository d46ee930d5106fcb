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

from collections.abc import Callable
from dataclasses import dataclass

from tolmc.kernels.jit import inlined


@inlined
def no_begin(run, block, y, coef, work):
    """Nothing to do before the first step."""


@inlined
def no_look(run, step, end, coef, seen, work):
    """Nothing to do after a step."""


@inlined
def no_scan(run, block, window, coef, work):
    """Nothing to do with a window."""


@inlined
def no_finish(run, block, y, coef, work):
    """Nothing to do after the last step."""


@dataclass(frozen=True)
class Watcher:
    """Functions of one watcher."""

    begin: Callable = no_begin
    look: Callable = no_look
    scan: Callable = no_scan
    finish: Callable = no_finish


def together(watchers: list[Watcher]) -> Watcher:
    """One watcher that does all of ``watchers``' work, in their order."""
    one, *others = watchers
    if not others:
        return one
    rest = together(others)
    begin_one, look_one, scan_one, finish_one = one.begin, one.look, one.scan, one.finish
    begin_rest, look_rest, scan_rest, finish_rest = rest.begin, rest.look, rest.scan, rest.finish

    @inlined
    def begin(run, block, y, coef, work):
        begin_one(run, block, y, coef, work)
        begin_rest(run, block, y, coef, work)

    @inlined
    def look(run, step, end, coef, seen, work):
        look_one(run, step, end, coef, seen, work)
        look_rest(run, step, end, coef, seen, work)

    @inlined
    def scan(run, block, window, coef, work):
        scan_one(run, block, window, coef, work)
        scan_rest(run, block, window, coef, work)

    @inlined
    def finish(run, block, y, coef, work):
        finish_one(run, block, y, coef, work)
        finish_rest(run, block, y, coef, work)

    return Watcher(begin, look, scan, finish)
