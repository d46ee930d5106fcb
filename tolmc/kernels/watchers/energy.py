"""Energy less the torque's work: how far it drifts, relative to the largest kinetic energy, or to the size of the
potential energy's variation where that is more.
"""

from __future__ import annotations

import math
from types import ModuleType

import numpy as np

from tolmc.kernels import parameters as P
from tolmc.kernels.jit import device, routine
from tolmc.kernels.lanes import WIDTH
from tolmc.kernels.once import once
from tolmc.kernels.results import ENERGY_CORRECTION, ENERGY_ERROR
from tolmc.kernels.seen import ENERGY, KINETIC, WORK
from tolmc.kernels.system import System, observer
from tolmc.kernels.watchers import Watcher

#: Steps of a motion alone from one look at the energy to the next: its error stays once made, and every look costs 5 %.
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


def watch(system: System, windows: bool) -> Watcher:
    """Watcher of the energy; with ``run.project_energy`` it also puts every step's end back on it.

    With ``windows`` it reads the energy at every step's end from what is seen there.
    """
    equations, load, layout, at = system.equations, system.load, system.layout, system.at
    observe, torque, until, bad_step = system.observe, equations.TORQUE, system.until, system.bad_step
    first, done, counted, error, scale = (*(layout.row() for _ in range(4)), system.energy_scale)
    target_rows, correction_rows, part_h = layout.block(1), layout.block(1), system.part_h
    part_rows, end_rows = system.part_seen, system.end_seen
    project_energy = projection(equations, load)

    @routine
    def begin(run, block, y, coef, work):
        last, correction = run.samples - 1, work[correction_rows]
        for lane in range(WIDTH):
            _, _, _, _, _, _, _, _, kinetic, potential, _ = observe(y, coef, lane)
            work[first + lane] = kinetic + potential
            work[scale + lane] = max(kinetic, run.raw[P.LOAD_ENERGY, min(block + lane, last)])
            work[done + lane], work[counted + lane] = 0.0, 0.0
            work[error + lane], correction[lane] = 0.0, 0.0

    @device
    def look(run, step, end, coef, seen, work):
        if torque:
            for lane in range(WIDTH):
                work[done + lane] += seen[WORK * WIDTH + lane]
        if run.project_energy:
            target = work[target_rows]
            for lane in range(WIDTH):
                target[lane] = work[first + lane] + work[done + lane]
            project_energy(end, coef, target, work[correction_rows])
        if not windows and (run.project_energy or step % INTERVAL == 0 or step == run.steps - 1):
            for lane in range(WIDTH):
                _, _, _, _, _, _, _, _, kinetic, potential, _ = observe(end, coef, lane)
                drift = abs(kinetic + potential - work[done + lane] - work[first + lane])
                # Written so that NaN is kept: a comparison with NaN is false.
                work[error + lane] = work[error + lane] if drift <= work[error + lane] else drift
                work[scale + lane] = kinetic if kinetic > work[scale + lane] else work[scale + lane]
                lost = not drift < np.inf and work[bad_step + lane] < 0.0
                work[bad_step + lane] = step + 1.0 if lost else work[bad_step + lane]

    @routine
    def scan(run, block, window, coef, work):
        if window.first + window.head == 0:
            seen = at(window.seen, window.head)
            for lane in range(WIDTH):
                work[first + lane] = seen[ENERGY * WIDTH + lane]
        for row in range(window.head, window.tail + 1):
            seen, reached = at(window.seen, row + 1), window.first + row + 1.0
            if torque:
                before = at(window.seen, row)
                for lane in range(WIDTH):
                    moves = reached <= work[until + lane]
                    work[counted + lane] += before[WORK * WIDTH + lane] if moves else 0.0
            for lane in range(WIDTH):
                kinetic = seen[KINETIC * WIDTH + lane]
                drift = abs(seen[ENERGY * WIDTH + lane] - work[counted + lane] - work[first + lane])
                moves = reached <= work[until + lane]
                work[error + lane] = drift if moves and not drift <= work[error + lane] else work[error + lane]
                work[scale + lane] = kinetic if moves and kinetic > work[scale + lane] else work[scale + lane]
                lost = not drift < np.inf and work[bad_step + lane] < 0.0 and moves
                work[bad_step + lane] = reached if lost else work[bad_step + lane]

    @routine
    def finish(run, block, y, coef, work):
        correction, part, end, length = work[correction_rows], work[part_rows], work[end_rows], work[part_h]
        for lane in range(min(WIDTH, run.samples - block)):
            size, drift, taken = work[scale + lane], work[error + lane], correction[lane]
            if windows and length[lane] > 0.0:
                size, turned = max(size, end[KINETIC * WIDTH + lane]), part[WORK * WIDTH + lane] if torque else 0.0
                here = abs(end[ENERGY * WIDTH + lane] - work[counted + lane] - turned - work[first + lane])
                drift = drift if here <= drift else here
            # One quotient: of two LLVM may make products, and in the rest of a packed loop may not.
            share = 1.0 / size
            run.out[ENERGY_ERROR, block + lane] = drift * share if drift != 0.0 else 0.0
            run.out[ENERGY_CORRECTION, block + lane] = abs(taken) * share if taken != 0.0 else 0.0

    return Watcher(begin, look, scan if windows else None, finish)
