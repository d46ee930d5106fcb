"""First loss of contact: the instant at which a contact force turns negative.

Bracketed by the samples of a step and located by root finding with steps from the start of that step. A loss between the
samples shows only in the refined extrema: such a lane asks to be run again with a hint (status RERUN). The hints:

``force_step``, ``force_at``
    Step in which a lane loses contact although its samples do not show it (-1: none), and the place in that step where a
    contact force is negative.
``ignore_step``
    Last step at which a suspicion is to be passed over (-1 at first); a lane that ignores all its steps asks for no rerun.
"""

from __future__ import annotations

import numpy as np

from tolmc.kernels.jit import piece, routine
from tolmc.kernels.lanes import WIDTH, no, yes
from tolmc.kernels.peaks import peaks_of
from tolmc.kernels.results import (
    CONTACT_LOST,
    CONTINUE,
    END,
    END_TIME,
    LOSS_TIME,
    OK,
    RERUN,
    RERUN_AT,
    RERUN_FORCE,
    RERUN_IGNORE,
    STATUS,
)
from tolmc.kernels.system import System
from tolmc.kernels.watchers import Watcher

ITERATIONS = 14


def watch(system: System) -> Watcher:
    """Watcher of the loss; it shuts the gates of the lanes that have one and leaves their last step, as ``run.on_loss`` says.

    STOP ends the force statistics, END the whole motion, CONTINUE neither.
    """
    layout, state, step_once = system.layout, system.equations.STATE, system.stepper.step
    sample_rows, part, part_h, part_state = system.stepper.samples, system.part, system.part_h, system.part_state
    open_forces, open_motion = system.open_forces, system.open_motion
    until_forces, until_motion = system.until_forces, system.until_motion
    forced, floor, loss_step, bracket, time = (layout.row() for _ in range(5))
    best_rows, position_rows, trial_rows = layout.block(1), layout.block(1), layout.block(state)
    low_rows, high_rows, f_low_rows, f_high_rows, side_rows = (layout.block(1) for _ in range(5))
    estimate = peaks_of(system.stepper.tableau).estimate
    screen, locate = _screen(system, floor), _locate(system)

    @routine
    def begin(run, block, step, y, end, coef, work):
        hints, last = 0, run.raw.shape[1] - 1
        for lane in range(WIDTH):
            work[loss_step + lane], work[time + lane], work[bracket + lane], work[floor + lane] = -1.0, np.nan, 0.0, 0.0
            hints += run.force_step[min(block + lane, last)] >= 0
        work[forced] = hints
        at_loss = work[part_state]
        for m in range(state * WIDTH):
            at_loss[m] = y[m]

    @piece
    def look(run, block, step, y, end, coef, work):
        at_loss, last = work[part_state], run.raw.shape[1] - 1
        # Losses first: the step in which contact ends belongs to the statistics only up to that instant.
        if work[forced] > 0.0:
            for lane in range(WIDTH):
                i = min(block + lane, last)
                if step == run.force_step[i] and work[loss_step + lane] < 0.0:
                    for c in range(state):
                        at_loss[c * WIDTH + lane] = y[c * WIDTH + lane]
                    work[bracket + lane], work[loss_step + lane], work[floor + lane] = run.force_at[i], step, np.inf
                    work[open_forces + lane] = work[open_forces + lane] if run.on_loss == CONTINUE else 0.0
                    work[open_motion + lane] = work[open_motion + lane] if run.on_loss != END else 0.0
        samples, best, position = work[sample_rows], work[best_rows], work[position_rows]
        suspects = screen(samples, work)
        for end_plane in range(2):
            if (suspects >> end_plane) & 1 == 0:
                continue
            estimate(samples, 2 * end_plane + 1, best, position)
            for lane in range(WIDTH):
                i = min(block + lane, last)
                known = work[loss_step + lane]
                if best[lane] > 0.0 and step > run.ignore_step[i] and (known < 0.0 or known == step):
                    if known < 0.0:
                        for c in range(state):
                            at_loss[c * WIDTH + lane] = y[c * WIDTH + lane]
                        work[bracket + lane] = min(position[lane], 1.0)
                    work[bracket + lane] = min(work[bracket + lane], position[lane])
                    work[loss_step + lane], work[floor + lane] = step, np.inf
                    if run.on_loss != CONTINUE:
                        work[open_forces + lane] = 0.0
                    if run.on_loss == END:
                        work[open_motion + lane] = 0.0

    @routine
    def finish(run, block, step, y, end, coef, work):
        losses = 0
        for lane in range(WIDTH):
            losses += work[loss_step + lane] >= 0.0
            work[part + lane] = 0.0
        if losses > 0:
            locate(
                work[part_state], work[loss_step : loss_step + WIDTH], work[bracket : bracket + WIDTH],
                work[time : time + WIDTH], work[part_h], run.step_length, coef, work[trial_rows],
                work[low_rows], work[high_rows], work[f_low_rows], work[f_high_rows], work[side_rows], work[best_rows], work,
            )  # fmt: skip
            if run.on_loss != CONTINUE:
                trial = work[trial_rows]
                step_once(work[part_state], trial, coef, work[part_h], work, yes())
                for lane in range(WIDTH):
                    work[part + lane] = 1.0 if work[loss_step + lane] >= 0.0 else 0.0
                    if run.on_loss == END and work[loss_step + lane] >= 0.0:
                        for c in range(state):
                            y[c * WIDTH + lane] = trial[c * WIDTH + lane]
        for lane in range(WIDTH):
            at = work[time + lane]
            lost = at >= 0.0
            work[until_forces + lane] = at if lost and run.on_loss != CONTINUE else run.duration
            work[until_motion + lane] = at if lost and run.on_loss == END else run.duration
        for lane in range(min(WIDTH, run.raw.shape[1] - block)):
            i = block + lane
            at = work[time + lane]
            run.out[RERUN_FORCE, i], run.out[RERUN_AT, i], run.out[RERUN_IGNORE, i] = -1.0, 0.0, run.ignore_step[i]
            run.out[LOSS_TIME, i] = at if at >= 0.0 else np.nan
            if work[loss_step + lane] >= 0.0:
                if at >= 0.0:
                    if run.out[STATUS, i] == OK or run.on_loss != CONTINUE:
                        run.out[STATUS, i] = CONTACT_LOST
                    run.out[END_TIME, i] = at
                elif run.out[STATUS, i] == OK:
                    run.out[STATUS, i], run.out[RERUN_IGNORE, i] = RERUN, work[loss_step + lane]
                    if at == -2.0:
                        run.out[RERUN_FORCE, i], run.out[RERUN_AT, i] = work[loss_step + lane] - 1.0, 1.0

    return Watcher(begin, look, finish)


def _screen(system: System, floor: int):
    """Which of D (bit 0) and E (bit 1) may lose contact in a step in any lane.

    An extremum between the samples lies beyond them by a tenth of their range at most as long as it is a single one; twice
    that is allowed for.
    """
    peaks = peaks_of(system.stepper.tableau)
    of_step, range_of = peaks.of_step, peaks.range_of

    @routine
    def screen(samples, work):
        suspects = 0
        for end_plane in range(2):
            lost = 0
            for lane in range(WIDTH):
                s0, s1, s2, s3, s4 = of_step(samples, 2 * end_plane, lane)
                top, bottom = range_of(s0, s1, s2, s3, s4)
                lost += 0.2 * (top - bottom) - bottom > work[floor + lane]
            if lost > 0:
                suspects |= 1 << end_plane
        return suspects

    return screen


def _locate(system: System):
    """Time (s) of the first root of min(N_D, N_E) in the lanes with a loss, by the Illinois rule; h is its place in the step.

    ``start`` is the state at the start of the loss's ``step`` (-1: no loss), ``bracket`` a place in the step, as a share of it,
    where a force is negative. Every trial is a step from there. The time is -1 where no sign changes, -2 where contact has
    ended in the step before.
    """
    step_once, observe = system.stepper.step, system.observe

    @routine
    def smallest_force(y, coef, smallest):
        """min(N_D, N_E) of every lane."""
        for lane in range(WIDTH):
            _, _, _, _, n_d, n_e, _, _, _, _, _ = observe(y, coef, lane)
            smallest[lane] = min(n_d, n_e)

    @routine
    def locate(start, step, bracket, time, h, step_length, coef, trial, low, high, f_low, f_high, side, force, work):
        smallest_force(start, coef, f_low)
        for lane in range(WIDTH):
            low[lane], side[lane] = 0.0, 0.0
            high[lane], h[lane] = bracket[lane], bracket[lane] * step_length
        for iteration in range(ITERATIONS):
            step_once(start, trial, coef, h, work, no())
            smallest_force(trial, coef, force)
            for lane in range(WIDTH):
                x, value = h[lane] / step_length, force[lane]
                # The end kept twice in a row loses half its weight; the first trial is the bracket's own end.
                if iteration == 0:
                    high[lane], f_high[lane] = x, value
                elif value < 0.0:
                    high[lane], f_high[lane] = x, value
                    f_low[lane] *= 0.5 if side[lane] < 0.0 else 1.0
                    side[lane] = -1.0
                else:
                    low[lane], f_low[lane] = x, value
                    f_high[lane] *= 0.5 if side[lane] > 0.0 else 1.0
                    side[lane] = 1.0
                span = high[lane] - low[lane]
                x = low[lane] + span * f_low[lane] / (f_low[lane] - f_high[lane])
                x = x if low[lane] <= x <= high[lane] else 0.5 * (low[lane] + high[lane])
                h[lane] = x * step_length
        smallest_force(start, coef, force)
        for lane in range(WIDTH):
            at_start = force[lane] <= 0.0
            h[lane] = 0.0 if at_start else h[lane]
            if step[lane] >= 0.0:
                if at_start and step[lane] > 0.0:
                    time[lane] = -2.0
                elif f_high[lane] < 0.0 or at_start:
                    time[lane] = step[lane] * step_length + h[lane]
                else:
                    time[lane] = -1.0

    return locate
