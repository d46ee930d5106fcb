"""One round of a block: a step of every lane's own length, and what is seen at its end.

The first stage is known from the end of the step before, the last evaluation of a round is at the step's end, so that a round
has as many as the formula has stages.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from tolmc.kernels.interpolation import through
from tolmc.kernels.jit import device, routine
from tolmc.kernels.once import once
from tolmc.kernels.one_sided import formula as formulas
from tolmc.kernels.one_sided import layout as at
from tolmc.kernels.one_sided.equations import Equations
from tolmc.kernels.one_sided.integrals import closed
from tolmc.kernels.one_sided.layout import WIDTH
from tolmc.kernels.tableaux import CLASSICAL, DORMAND_PRINCE


class Stepper(NamedTuple):
    """Device functions of a formula on given equations; ``k_rows`` rows are what its stages keep."""

    stages: int
    k_rows: int
    step: object
    look: object
    looked_samples: object
    ends: object


#: Places in a step at which a force is known: the formula's own samples, the last one at the end itself.
POSITIONS_8, POSITIONS_4 = np.array(DORMAND_PRINCE.positions), np.array(CLASSICAL.positions)
FIT_8, FIT_4 = through(POSITIONS_8), through(POSITIONS_4)


#: Share of a step over which rates are taken: shorter than that of the two-sided kernels (steppers.NUDGE), as a journal that
#: rolls, whose slip the regularised law brings to rest within a fraction of a step, has rates of nothing else.
_NUDGE = 2.0**-20


@once
def replacer(rows: int) -> Callable:
    """Routine ``replace(old, new, decision, least)``: rows taken over in lanes whose decision is ``least`` or a later one."""

    @routine
    def replace(old, new, decision, least):
        for lane in range(WIDTH):
            chosen = decision[lane] >= least
            for row in range(rows):
                # Both are read before one is chosen: of a choice between two places LLVM makes no packed loop.
                before, after = old[row * WIDTH + lane], new[row * WIDTH + lane]
                old[row * WIDTH + lane] = after if chosen else before

    return replace


def build(equations: Equations, rk4: bool) -> Stepper:
    """The round of one formula."""
    formula = formulas.build(equations, rk4)
    stages, plain_step, midpoint = formula.stages, formula.step, formula.midpoint
    n_state, n_samples = equations.state, equations.samples
    size, stride, speeds = n_state * WIDTH, n_samples * WIDTH, at.OV_X * WIDTH
    advance, look_at, project = equations.advance, equations.look, equations.project
    glimpse, glimpsed, forces = equations.glimpse, equations.glimpsed, equations.forces
    flies, rubs = not equations.works, equations.rubs
    rows = (0, stages, stages) if rk4 else DORMAND_PRINCE.samples
    row_1, row_2, row_3 = rows[1], rows[2], rows[3 % len(rows)]

    @routine
    def look(y, coef, f, seen, argument, step_length):
        """y' and what is seen at every lane's state; rates of forces from a look a little way along the motion."""
        if glimpsed and closed(coef) == 0:
            for lane in range(WIDTH):
                glimpse(y, coef, f, seen, lane, WIDTH)
        else:
            for lane in range(WIDTH):
                look_at(y, coef, f, seen, lane, WIDTH)
        # With friction whatever the others do: a moment that holds Omega has a rate in flight too, and no old rate stays.
        if rubs or closed(coef) > 0.0:
            dt = _NUDGE * step_length
            for m in range(size):
                argument[m] = y[m] + dt * f[m]
            for lane in range(WIDTH):
                n_d, n_e, torque, drive = forces(argument, coef, lane, WIDTH)
                seen[at.N_RATE_D * WIDTH + lane] = (n_d - seen[at.N_D * WIDTH + lane]) / dt
                seen[at.N_RATE_E * WIDTH + lane] = (n_e - seen[at.N_E * WIDTH + lane]) / dt
                if rubs:
                    seen[at.TORQUE_RATE * WIDTH + lane] = (torque - seen[at.TORQUE * WIDTH + lane]) / dt
                    seen[at.DRIVE_RATE * WIDTH + lane] = (drive - seen[at.DRIVE * WIDTH + lane]) / dt

    @routine
    def step(y, coef, f0, seen, lanes, k, argument, samples, end):
        """One step of every lane from ``y`` to ``end``, projected; stage values into ``samples`` (stage, quantity, lane)."""
        h = coef[at.STEP * WIDTH : (at.STEP + 1) * WIDTH]
        in_flight = flies and closed(coef) == 0
        plain_step(in_flight, y, f0, coef, h, k, argument, samples, end)
        if not in_flight:
            for lane in range(WIDTH):
                on_d, on_e = coef[at.CLOSED_D * WIDTH + lane] > 0.0, coef[at.CLOSED_E * WIDTH + lane] > 0.0
                project(end, coef, on_d, on_e, lane, WIDTH)
            if rk4:
                midpoint(y, k, argument)
                after, there = k[stages * (size - speeds) :], samples[stages * stride :]
                for lane in range(WIDTH):
                    advance(argument, coef, 0.0, after, there, lane, WIDTH)

    @device
    def looked_samples(samples, seen0, seen1, quantity, lane):
        """A quantity (N_D, N_E, a torque) at the start, at two or three places of the step, and at its end."""
        row = at.N_D + quantity if quantity < 2 else at.TORQUE if quantity == at.S_TORQUE else at.DRIVE
        first, last = seen0[row * WIDTH + lane], seen1[row * WIDTH + lane]
        s1 = samples[(row_1 * n_samples + quantity) * WIDTH + lane]
        if rk4:
            return first, s1, last, 0.0, 0.0
        s2 = samples[(row_2 * n_samples + quantity) * WIDTH + lane]
        s3 = samples[(row_3 * n_samples + quantity) * WIDTH + lane]
        return first, s1, s2, s3, last

    @device
    def ends(seen0, seen1, quantity, h, lane):
        """A quantity (N_D, N_E, |w|^2, a torque) at a step's two ends, and its changes there over the step."""
        row, rate = at.N_D + quantity, at.N_RATE_D + quantity
        if quantity == at.S_W2:
            row, rate = at.W2, at.W2_RATE
        elif quantity == at.S_TORQUE:
            row, rate = at.TORQUE, at.TORQUE_RATE
        elif quantity == at.S_DRIVE:
            row, rate = at.DRIVE, at.DRIVE_RATE
        return (
            seen0[row * WIDTH + lane], seen1[row * WIDTH + lane],
            h * seen0[rate * WIDTH + lane], h * seen1[rate * WIDTH + lane],
        )  # fmt: skip

    return Stepper(stages, formula.rows, step, look, looked_samples, ends)
