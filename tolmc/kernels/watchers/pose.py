"""Pose at the end of a motion: O and the journal's axis."""

from __future__ import annotations

import math

from tolmc.kernels import parameters as P
from tolmc.kernels.jit import routine
from tolmc.kernels.lanes import WIDTH
from tolmc.kernels.results import ORIGIN_X
from tolmc.kernels.system import System
from tolmc.kernels.watchers import Watcher


def watch(system: System) -> Watcher:
    """Watcher of the last state alone; in the axial form, which does not know the turn about Z, of its invariants."""
    observe, pose_rows, length_row = system.observe, system.layout.block(5), system.layout.row()

    @routine
    def begin(run, block, y, coef, work):
        for lane in range(WIDTH):
            work[length_row + lane] = run.raw[P.HALF_LENGTH, min(block + lane, run.samples - 1)]

    @routine
    def finish(run, block, y, coef, work):
        pose = work[pose_rows]
        for lane in range(WIDTH):
            x, z, u, v, _, _, _, _, _, _, w2 = observe(y, coef, lane)
            length = work[length_row + lane]
            norm = math.sqrt(length * length + w2)
            pose[lane], pose[WIDTH + lane] = x, z
            pose[2 * WIDTH + lane], pose[3 * WIDTH + lane], pose[4 * WIDTH + lane] = u / norm, v / norm, length / norm
        for row in range(5):
            for lane in range(min(WIDTH, run.samples - block)):
                run.out[ORIGIN_X + row, block + lane] = pose[row * WIDTH + lane]

    return Watcher(begin=begin, finish=finish)
