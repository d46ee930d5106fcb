"""Blocks of lanes: many motions side by side, and the one buffer that a block works in.

Arrays inside a block are flat, (row, lane) with lanes last, so that every loop over lanes is packed. All rows that a kernel
works with stand in one buffer; a :class:`Layout` hands them out by name while the kernel is composed, so that in compiled code
a name is a constant.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

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
