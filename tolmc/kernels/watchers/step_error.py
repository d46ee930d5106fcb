"""Error of the roughest step of a motion, by two steps of half its length: contact forces at its end, and their integrals.

The steps of a motion differ in how rough they are by orders of magnitude, and errors go with their eighth power: the roughest
tells whether the motion is resolved. Its energy as a whole often does not, but by how much a step changes it tells one step
from another. Rough is a step that does so, whose last stage, of low order, sees other forces than its end, and whose mean
forces are not those of its ends and their rates: the product of the three finds the worst step, or one that errs a tenth as
much, in 97 to 99 % of random motions whose worst step errs by 1e-8 to 0.1; the two of forces alone in 91 to 97 %, and energy,
which chance may leave as it was, in 97 to 98 %.

The errors of steps that are as rough add up, as in a motion that passes the same spike again and again: it is counted how many
there are.
"""

from __future__ import annotations

from tolmc.kernels.jit import device, routine
from tolmc.kernels.lanes import WIDTH
from tolmc.kernels.results import AS_ROUGH, CONTINUE, D_MAX, D_MIN, D_RMS, DOUBT, E_MAX, E_MIN, LOSS_TIME, ROUGHEST
from tolmc.kernels.seen import ENERGY, KINETIC, LATE_D, LATE_E, N_D, N_E, RATE_D, RATE_E, SUM_D, WORK
from tolmc.kernels.system import System
from tolmc.kernels.watchers import Watcher
from tolmc.kernels.watchers.between import Between

#: Share of the energy up to which a step changes it by rounding, or by chance not at all.
_ROUNDING = 1e-15


def watch(system: System, between: Between) -> Watcher:
    """Watcher of the roughest step's error, and of what is left of an extremum, relative to the largest contact force."""
    layout, state, what, at, until = system.layout, system.equations.STATE, system.seen, system.at, system.until
    torque = system.equations.TORQUE
    step, see, full, unsure = system.stepper.step, system.stepper.see, system.h, between.unsure
    roughest, in_all, row_of, length_rows = layout.row(), layout.row(), layout.row(), layout.block(1)
    start_rows, middle_rows = layout.block(state), layout.block(state)
    force_rows, sum_rows, seen_rows, other_rows = (
        layout.block(2),
        layout.block(4),
        layout.block(what),
        layout.block(what),
    )
    end_seen, part_start, part_seen, part_h = system.end_seen, system.part_start, system.part_seen, system.part_h

    @routine
    def begin(run, block, y, coef, work):
        for lane in range(WIDTH):
            work[roughest + lane], work[in_all + lane], work[unsure + lane] = -1.0, 0.0, 0.0

    @device
    def roughness(seen, after, per_length, share, lane):
        """How far the last stage's forces are from the end's, the mean ones from those of the cubic, and energy from kept.

        ``per_length``: one over the length of the step; ``share``: that length over the one of which the rates at its end are.
        """
        d0, d1, e0, e1 = (
            seen[N_D * WIDTH + lane],
            after[N_D * WIDTH + lane],
            seen[N_E * WIDTH + lane],
            after[N_E * WIDTH + lane],
        )
        mean_d, mean_e = per_length * seen[SUM_D * WIDTH + lane], per_length * seen[(SUM_D + 2) * WIDTH + lane]
        bend_d = (seen[RATE_D * WIDTH + lane] - share * after[RATE_D * WIDTH + lane]) / 12.0
        bend_e = (seen[RATE_E * WIDTH + lane] - share * after[RATE_E * WIDTH + lane]) / 12.0
        late = abs(seen[LATE_D * WIDTH + lane] - d1) + abs(seen[LATE_E * WIDTH + lane] - e1)
        spike = abs(mean_d - 0.5 * (d0 + d1) - bend_d) + abs(mean_e - 0.5 * (e0 + e1) - bend_e)
        gain = after[ENERGY * WIDTH + lane] - seen[ENERGY * WIDTH + lane]
        if torque:
            gain -= seen[WORK * WIDTH + lane]
        size = after[KINETIC * WIDTH + lane] + abs(after[ENERGY * WIDTH + lane])
        return late * spike * (abs(gain) + _ROUNDING * size)

    @routine
    def rough(seen, after, number, reached, per_length, work):
        for lane in range(WIDTH):
            miss = roughness(seen, after, per_length, 1.0, lane)
            counts = reached <= work[until + lane]
            more = miss > work[roughest + lane] and counts
            work[in_all + lane] += miss if counts else 0.0
            work[roughest + lane] = miss if more else work[roughest + lane]
            work[row_of + lane] = number if more else work[row_of + lane]

    @routine
    def scan(run, block, window, coef, work):
        rows, start, forces, sums, length = (
            work[row_of : row_of + WIDTH],
            work[start_rows],
            work[force_rows],
            work[sum_rows],
            work[length_rows],
        )
        for lane in range(WIDTH):
            rows[lane] = -1.0
        for row in range(window.head, window.tail + 1):
            here, after, reached = at(window.seen, row), at(window.seen, row + 1), window.first + row + 1.0
            rough(here, after, row + 0.0, reached, 1.0 / run.step_length, work)
        for lane in range(WIDTH):
            row = int(rows[lane])
            if row >= 0:
                length[lane] = run.step_length
                for c in range(state):
                    start[c * WIDTH + lane] = window.states[(row * state + c) * WIDTH + lane]
                for side in range(2):
                    forces[side * WIDTH + lane] = window.seen[((row + 1) * what + N_D + side) * WIDTH + lane]
                for c in range(4):
                    sums[c * WIDTH + lane] = window.seen[(row * what + SUM_D + c) * WIDTH + lane]

    @routine
    def last_parts(run, work):
        """Where a lane's motion ends within a step that is rougher than the others, that one is looked at."""
        start, forces, sums, length = work[start_rows], work[force_rows], work[sum_rows], work[length_rows]
        end, part, first, part_length = work[end_seen], work[part_seen], work[part_start], work[part_h]
        for lane in range(WIDTH):
            if part_length[lane] <= 0.0:
                continue
            miss = roughness(part, end, 1.0 / part_length[lane], part_length[lane] / run.step_length, lane)
            if miss >= work[roughest + lane]:
                work[roughest + lane], length[lane] = miss, part_length[lane]
                for c in range(state):
                    start[c * WIDTH + lane] = first[c * WIDTH + lane]
                for side in range(2):
                    forces[side * WIDTH + lane] = end[(N_D + side) * WIDTH + lane]
                for c in range(4):
                    sums[c * WIDTH + lane] = part[(SUM_D + c) * WIDTH + lane]

    @routine
    def finish(run, block, y, coef, work):
        last_parts(run, work)
        start, middle, length, forces, sums = (
            work[start_rows],
            work[middle_rows],
            work[length_rows],
            work[force_rows],
            work[sum_rows],
        )
        seen, other, end = work[seen_rows], work[other_rows], work[end_seen]
        for lane in range(WIDTH):
            length[lane] *= 0.5
        step(start, middle, coef, length, seen, work)
        step(middle, start, coef, length, other, work)
        for m in range(SUM_D * WIDTH, (SUM_D + 4) * WIDTH):
            seen[m] += other[m]
        see(start, coef, work[full], other, work)
        for lane in range(min(WIDTH, run.samples - block)):
            i, error, doubt = block + lane, 0.0, work[unsure + lane]
            largest = max(
                max(abs(run.out[D_MAX, i]), abs(run.out[D_MIN, i])), max(abs(run.out[E_MAX, i]), abs(run.out[E_MIN, i]))
            )
            if work[roughest + lane] >= 0.0:
                span = work[until + lane] * run.step_length
                for side in range(2):
                    force = abs(other[(N_D + side) * WIDTH + lane] - forces[side * WIDTH + lane])
                    by_mean = abs(seen[(SUM_D + 2 * side) * WIDTH + lane] - sums[2 * side * WIDTH + lane]) / span
                    by_square = (
                        abs(seen[(SUM_D + 2 * side + 1) * WIDTH + lane] - sums[(2 * side + 1) * WIDTH + lane]) / span
                    )
                    rms = 2.0 * run.out[D_RMS + 4 * side, i]
                    worst = max(force, max(by_mean, by_square / rms if rms > 0.0 else 0.0))
                    error = error if worst <= error else worst
            if run.on_loss != CONTINUE and run.out[LOSS_TIME, i] > 0.0:
                # Where contact is lost a force is zero; it is not where the step there blows up.
                doubt = max(doubt, abs(min(end[N_D * WIDTH + lane], end[N_E * WIDTH + lane])))
            run.out[AS_ROUGH, i] = work[in_all + lane] / work[roughest + lane] if work[roughest + lane] > 0.0 else 1.0
            share = 1.0 / largest  # one quotient, as for the energy
            run.out[ROUGHEST, i] = error * share if error != 0.0 else 0.0
            run.out[DOUBT, i] = doubt * share if doubt != 0.0 else 0.0

    return Watcher(begin=begin, scan=scan, finish=finish)
