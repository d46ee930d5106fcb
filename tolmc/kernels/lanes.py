"""Blocks of lanes: many motions side by side, and the one buffer that a block works in.

Arrays inside a block are flat, (row, lane) with lanes last, so that every loop over lanes is packed. All rows that a kernel
works with stand in one buffer; a :class:`Layout` hands them out by name while the kernel is composed, so that in compiled code
a name is a constant.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType
from typing import NamedTuple

import numpy as np

from tolmc.kernels.jit import device, inlined, once

#: Lanes of a block. Measured on 512-bit vectors: 16 to 64 are alike, fewer leave the latencies of the square root and the
#: divisions uncovered, more leave the first-level cache.
WIDTH = 32


@dataclass
class Layout:
    """Rows of the buffer ``work``, given out in order."""

    rows: int = 0

    def row(self) -> int:
        """Offset of one more row: its number in a lane is ``work[offset + lane]``."""
        return self.block(1).start

    def block(self, rows: int) -> slice:
        """The place of ``rows`` more rows: as an array of their own they are ``work[place]``."""
        first, self.rows = self.rows, self.rows + rows
        return slice(first * WIDTH, self.rows * WIDTH)

    def copy(self) -> Layout:
        """A layout that goes on from here without changing this one."""
        return Layout(self.rows)


class Run(NamedTuple):
    """What one call of a kernel is told, as its parts see it.

    ``raw`` (parameters.COUNT, samples) SI units; ``step_length`` = duration/steps; ``on_loss`` CONTINUE or END; ``momentum``
    whether the angular momentum about Z is conserved; ``out`` (results.RESULTS, samples).
    """

    raw: np.ndarray
    samples: int
    steps: int
    duration: float
    step_length: float
    on_loss: int
    project_energy: bool
    momentum: bool
    out: np.ndarray


@inlined
def lanes(rows):
    """Array of ``rows`` rows of lanes that begins on a cache line: a 64-byte vector that straddles two costs two loads."""
    buffer = np.empty(rows * WIDTH + 7)
    skip = (-(buffer.ctypes.data // 8)) % 8
    return buffer[skip : skip + rows * WIDTH]


@device
def yes():
    """True, but no literal: for each literal a function is compiled anew."""
    return np.bool_(True)


@device
def no():
    """False, but no literal."""
    return np.bool_(False)


@once
def observer(equations: ModuleType, load: bool) -> Callable:
    """What the equations observe of one lane, ``observe(y, coef, lane)``: (O_x, O_y, u, v, N_D, N_E, ..., T, V, |w|^2).

    Taken over as a whole: optimised anew for each use of a part of it, LLVM contracts its arithmetic in other ways.
    """
    of_equations = equations.observe

    @device
    def observe(y, coef, lane):
        return of_equations(y, coef, lane, WIDTH, load)

    return observe
