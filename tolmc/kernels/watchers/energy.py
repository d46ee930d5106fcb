"""Balance of energy: its largest error along a motion, and the projection on it.

T + V less the work of the torque is constant. Errors are relative to the largest kinetic energy, or to the size of the
potential energy's variation where that is more.
"""

from __future__ import annotations

import math
from types import ModuleType

import numpy as np

from tolmc.kernels import parameters as P
from tolmc.kernels.jit import once, piece, routine
from tolmc.kernels.lanes import WIDTH, observer
from tolmc.kernels.results import ENERGY_CORRECTION, ENERGY_ERROR
from tolmc.kernels.system import System
from tolmc.kernels.watchers import Watcher

#: Steps from one look at the energy to the next: its error stays once made, and every step's look costs 5 % of a motion.
INTERVAL = 4


@once
def projection(equations: ModuleType, load: bool):
    """Function that scales the speeds of every lane so that its energy is ``energy[lane]``.

    A lane nearly at rest is left alone until it moves. What is taken out of a lane adds up in ``correction`` (J): the error
    that the motion would have without.
    """
    observe, scale_speeds = observer(equations, load), equations.scale_speeds

    @routine
    def project_energy(y, coef, energy, correction):
        for lane in range(WIDTH):
            _, _, _, _, _, _, _, _, kinetic, potential, _ = observe(y, coef, lane)
            ratio = (energy[lane] - potential) / kinetic
            near = abs(ratio - 1.0) < 0.1
            factor = math.sqrt(ratio) if near else 1.0
            correction[lane] += kinetic + potential - energy[lane] if near else 0.0
            scale_speeds(y, factor, lane, WIDTH)

    return project_energy


def watch(system: System) -> Watcher:
    """Watcher of the energy; with ``run.project_energy`` it also puts every step's end back on it."""
    equations, load, layout = system.equations, system.load, system.layout
    observe, torque, sum_rows = system.observe, equations.TORQUE, system.stepper.sums
    open_motion, bad_step = system.open_motion, system.bad_step
    first, done, error, scale = layout.row(), layout.row(), layout.row(), system.energy_scale
    target_rows, correction_rows = layout.block(1), layout.block(1)
    project_energy = projection(equations, load)

    @routine
    def begin(run, block, step, y, end, coef, work):
        last, correction = run.raw.shape[1] - 1, work[correction_rows]
        for lane in range(WIDTH):
            _, _, _, _, _, _, _, _, kinetic, potential, _ = observe(y, coef, lane)
            work[first + lane] = kinetic + potential
            work[scale + lane] = max(kinetic, run.raw[P.LOAD_ENERGY, min(block + lane, last)])
            work[done + lane], work[error + lane], correction[lane] = 0.0, 0.0, 0.0

    @piece
    def look(run, block, step, y, end, coef, work):
        if torque:
            sums = work[sum_rows]
            for lane in range(WIDTH):
                work[done + lane] += sums[4 * WIDTH + lane]
        if run.project_energy:
            target = work[target_rows]
            for lane in range(WIDTH):
                target[lane] = work[first + lane] + work[done + lane]
            project_energy(end, coef, target, work[correction_rows])
        if run.project_energy or step % INTERVAL == 0 or step == run.steps - 1:
            for lane in range(WIDTH):
                _, _, _, _, _, _, _, _, kinetic, potential, _ = observe(end, coef, lane)
                drift = abs(kinetic + potential - work[done + lane] - work[first + lane])
                moving = work[open_motion + lane] > 0.0
                # Written so that NaN is kept: a comparison with NaN is false.
                work[error + lane] = drift if moving and not drift <= work[error + lane] else work[error + lane]
                work[scale + lane] = kinetic if moving and kinetic > work[scale + lane] else work[scale + lane]
                lost = not drift < np.inf and work[bad_step + lane] < 0.0 and moving
                work[bad_step + lane] = float(step) if lost else work[bad_step + lane]

    @routine
    def finish(run, block, step, y, end, coef, work):
        correction = work[correction_rows]
        for lane in range(min(WIDTH, run.raw.shape[1] - block)):
            size, drift, taken = work[scale + lane], work[error + lane], correction[lane]
            run.out[ENERGY_ERROR, block + lane] = drift / size if drift != 0.0 else 0.0
            run.out[ENERGY_CORRECTION, block + lane] = abs(taken) / size if taken != 0.0 else 0.0

    return Watcher(begin, look, finish)
