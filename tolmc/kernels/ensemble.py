"""Integration of many samples at once: blocks of lanes, statistics of the contact forces along the way.

Arrays inside a block are flat, (component, lane) with lanes last, so that every loop over lanes is packed. A kernel is
specialised by what a scene has: arguments that are ``None`` mark what is absent, and their branches are not compiled.

Contact forces. Means are quadratures with the method's own weights. Extrema are maxima over continuous time: the stages
sample every step, a polynomial through the samples finds candidates, the two best of each quantity are kept with the state
at the start of their step, and at the end a step of the very length of the candidate's time gives the exact value, a second,
short one its slope. The loss of contact is bracketed in the same way and located by root finding with steps from the start
of its step.
"""

from __future__ import annotations

import math

import numpy as np

from tolmc.kernels import models
from tolmc.kernels import parameters as P
from tolmc.kernels.jit import device, inlined, kernel, routine
from tolmc.kernels.tableaux import (
    CLASSICAL,
    DORMAND_PRINCE,
    MOTION_ARGUMENTS,
    midpoint_rk4,
    motion_end,
    stage_argument_rk4,
    stage_argument_rk8,
    step_end_rk4,
    step_end_rk8,
)

#: Lanes of a block. Measured on 512-bit vectors: 16 to 64 are alike, fewer leave the latencies of the square root and the
#: divisions uncovered, more leave the first-level cache.
WIDTH = 32

# Rows of the results (row, sample).
(
    D_MAX, D_MIN, D_MEAN, D_RMS, E_MAX, E_MIN, E_MEAN, E_RMS,
    TILT_MAX, LOSS_TIME, ENERGY_ERROR, CONSTRAINT_ERROR, END_TIME, STATUS,
    ORIGIN_X, ORIGIN_Y, AXIS_X, AXIS_Y, AXIS_Z, RERUN_FORCE, RERUN_AT, RERUN_IGNORE,
    MOMENTUM_ERROR, ENERGY_CORRECTION, SPIN_ERROR, HALVING_ERROR,
) = range(26)  # fmt: skip
RESULTS = 26  # the last two are the caller's

OK, CONTACT_LOST, DIVERGED, RERUN = 0, 1, 2, 3  # codes in row STATUS
STOP, CONTINUE, END = 0, 1, 2  # what a loss of contact does

_B4, _B8 = CLASSICAL.b, DORMAND_PRINCE.b
_SAMPLE4, _SAMPLE8 = np.array(CLASSICAL.samples), np.array(DORMAND_PRINCE.samples)
_AT4, _AT8 = np.array(CLASSICAL.positions), np.array(DORMAND_PRINCE.positions)
# Coefficients of the polynomial through the samples, lowest power first: _FIT @ samples.
_FIT4, _FIT8 = (np.linalg.inv(np.vander(at, increasing=True)) for at in (_AT4, _AT8))

_QUANTITIES = 5  # N_D, -N_D, N_E, -N_E, |w|^2: their maxima are sought
_SLOTS = 2  # candidates kept of each quantity
_PROBE = 0.1  # length of the step that is laid around a candidate, as a share of the step
_ROOT_ITERATIONS = 14
#: Steps from one look at the energy to the next: its error stays once made, and every step's look costs 5 % of a motion.
_ENERGY_INTERVAL = 4
_ESTIMATE_ERROR = 4e-3  # of the polynomials' maxima, relative to the quantity's size; measured at most 1e-3 at 1e-6
_REFINEMENTS = 4  # a candidate is looked at again while its maximum lies outside the short step


@device
def _lanes(rows):
    """Array of ``rows`` rows of lanes that begins on a cache line: a 64-byte vector that straddles two costs two loads."""
    buffer = np.empty(rows * WIDTH + 7)
    skip = (-(buffer.ctypes.data // 8)) % 8
    return buffer[skip : skip + rows * WIDTH]


@device
def _yes():
    """True, but no literal: for each literal a function is compiled anew."""
    return np.bool_(True)


@device
def _no():
    """False, but no literal."""
    return np.bool_(False)


def _motion_stage(stage, argument_at):
    """Device function of one stage of rk8 for the motion alone, argument and right-hand side in one loop over the lanes.

    Sums wait for memory, right-hand sides for arithmetic; in one loop they overlap, and a step takes a tenth less.
    """

    @device
    def motion_stage(y, k, argument, coef, h, axial, exact, load):
        n_state, _ = models.sizes(None, axial, exact)
        size = n_state * WIDTH
        for lane in range(WIDTH):
            for c in range(n_state):
                argument[c * WIDTH + lane] = argument_at(y, k, size, c * WIDTH + lane)
            models.advance(argument, coef, h[lane], k, stage * size, lane, WIDTH, None, axial, exact, load)

    return motion_stage


_M0, _M1, _M2, _M3, _M4, _M5, _M6, _M7, _M8, _M9, _M10, _M11 = (
    _motion_stage(stage, argument_at) for stage, argument_at in enumerate(MOTION_ARGUMENTS)
)


@routine
def _motion_step(y, end, coef, h, k, argument, error, axial, exact, load):
    """:func:`_step` of rk8 for a symmetric body's motion alone: its right-hand side is short enough to compile twelve times."""
    _M0(y, k, argument, coef, h, axial, exact, load)
    _M1(y, k, argument, coef, h, axial, exact, load)
    _M2(y, k, argument, coef, h, axial, exact, load)
    _M3(y, k, argument, coef, h, axial, exact, load)
    _M4(y, k, argument, coef, h, axial, exact, load)
    _M5(y, k, argument, coef, h, axial, exact, load)
    _M6(y, k, argument, coef, h, axial, exact, load)
    _M7(y, k, argument, coef, h, axial, exact, load)
    _M8(y, k, argument, coef, h, axial, exact, load)
    _M9(y, k, argument, coef, h, axial, exact, load)
    _M10(y, k, argument, coef, h, axial, exact, load)
    _M11(y, k, argument, coef, h, axial, exact, load)
    n_state, _ = models.sizes(None, axial, exact)
    for lane in range(WIDTH):
        for c in range(n_state):
            end[c * WIDTH + lane] = motion_end(y, k, n_state * WIDTH, c * WIDTH + lane)
        error[lane] = models.project(end, coef, lane, WIDTH, None, axial, exact)


@routine
def _step(y, end, coef, h, k, argument, samples, sums, error, watch, general, axial, exact, rk4, load, forces):
    """One step of ``h[lane]`` from ``y`` to ``end``, projected.

    With ``forces``, and ``watch`` set: N_D, N_E, |w|^2 and the torque's power at the stages into ``samples``
    (stage, 4, lane), the increments of the integrals of N_D, N_D^2, N_E, N_E^2 into ``sums`` (5, lane). The last row of
    ``sums`` is the torque's work. The constraint error left goes to ``error``.
    """
    n_state, _ = models.sizes(general, axial, exact)
    size = n_state * WIDTH
    if rk4 is None:
        stages = 12
    else:
        stages = 4
    for stage in range(stages):
        first, row = stage * size, 4 * stage * WIDTH
        if rk4 is None:
            stage_argument_rk8(stage, y, k, argument, size)
            weight = _B8[stage]
        else:
            stage_argument_rk4(stage, y, k, argument, size)
            weight = _B4[stage]
        # Two written arrays and three read ones: with one more, LLVM's alias checks exceed its limit and the loop is scalar.
        if general is None and (forces is None or weight == 0.0 or not watch):
            for lane in range(WIDTH):
                models.advance(argument, coef, h[lane], k, first, lane, WIDTH, general, axial, exact, load)
        else:
            for lane in range(WIDTH):
                n_d, n_e, w2, power = models.advance(
                    argument, coef, h[lane], k, first, lane, WIDTH, general, axial, exact, load
                )
                samples[row + lane] = n_d
                samples[row + WIDTH + lane] = n_e
                samples[row + 2 * WIDTH + lane] = w2
                if general is not None:
                    samples[row + 3 * WIDTH + lane] = power
    if rk4 is None:
        step_end_rk8(y, k, end, size)
    else:
        step_end_rk4(y, k, end, size)
    for lane in range(WIDTH):
        error[lane] = models.project(end, coef, lane, WIDTH, general, axial, exact)
    if rk4 is not None and forces is not None and watch:
        midpoint_rk4(y, k, argument, size)
        _observe_samples(argument, coef, samples, 4 * stages * WIDTH, general, axial, exact, load)
        _observe_samples(end, coef, samples, 4 * (stages + 1) * WIDTH, general, axial, exact, load)
    if (forces is not None and watch) or general is not None:
        for lane in range(WIDTH):
            _integrate_step(samples, h, sums, lane, general, rk4)


@device
def _observe_samples(y, coef, samples, row, general, axial, exact, load):
    for lane in range(WIDTH):
        _, _, _, _, n_d, n_e, _, _, _, _, w2 = models.observe(y, coef, lane, WIDTH, general, axial, exact, load)
        samples[row + lane] = n_d
        samples[row + WIDTH + lane] = n_e
        samples[row + 2 * WIDTH + lane] = w2


@inlined
def _integrate_step(samples, h, sums, lane, general, rk4):
    """Increments of the integrals over one lane's step, by the method's weights."""
    d, d2, e, e2, work = 0.0, 0.0, 0.0, 0.0, 0.0
    if rk4 is None:
        stages = 12
    else:
        stages = 4
    for stage in range(stages):
        if rk4 is None:
            weight = _B8[stage]
        else:
            weight = _B4[stage]
        if weight != 0.0:
            row = 4 * stage * WIDTH
            n_d, n_e = samples[row + lane], samples[row + WIDTH + lane]
            d += weight * n_d
            d2 += weight * n_d * n_d
            e += weight * n_e
            e2 += weight * n_e * n_e
            if general is not None:
                work += weight * samples[row + 3 * WIDTH + lane]
    sums[lane], sums[WIDTH + lane] = h[lane] * d, h[lane] * d2
    sums[2 * WIDTH + lane], sums[3 * WIDTH + lane] = h[lane] * e, h[lane] * e2
    if general is not None:
        sums[4 * WIDTH + lane] = h[lane] * work


@device
def _energies(y, coef, lane, general, axial, exact, load):
    _, _, _, _, _, _, _, _, kinetic, potential, _ = models.observe(y, coef, lane, WIDTH, general, axial, exact, load)
    return kinetic, potential


@routine
def _project_energy(y, coef, energy, correction, general, axial, exact, load):
    """Scale the speeds so that the energy is ``energy[lane]``; a lane nearly at rest is left alone until it moves.

    What is taken out of a lane adds up in ``correction`` (J): the error that the motion would have without.
    """
    for lane in range(WIDTH):
        kinetic, potential = _energies(y, coef, lane, general, axial, exact, load)
        ratio = (energy[lane] - potential) / kinetic
        near = abs(ratio - 1.0) < 0.1
        factor = math.sqrt(ratio) if near else 1.0
        correction[lane] += kinetic + potential - energy[lane] if near else 0.0
        models.scale_speeds(y, factor, lane, WIDTH, general, axial, exact)


@device
def _pose(y, coef, length, pose, general, axial, exact, load):
    """O_x, O_y and the axis, rows ORIGIN_X to AXIS_Z of the results, of every lane."""
    for lane in range(WIDTH):
        x, z, u, v, _, _, _, _, _, _, w2 = models.observe(y, coef, lane, WIDTH, general, axial, exact, load)
        norm = math.sqrt(length[lane] * length[lane] + w2)
        pose[lane], pose[WIDTH + lane] = x, z
        pose[2 * WIDTH + lane], pose[3 * WIDTH + lane], pose[4 * WIDTH + lane] = u / norm, v / norm, length[lane] / norm


@device
def _samples(samples, quantity, lane, rk4):
    """The step's samples of the quantity whose maximum is sought, in order; rk4 has three, the rest is 0."""
    sign, variable = -1.0 if quantity % 2 == 1 else 1.0, quantity // 2
    if rk4 is None:
        return (
            sign * samples[(4 * _SAMPLE8[0] + variable) * WIDTH + lane],
            sign * samples[(4 * _SAMPLE8[1] + variable) * WIDTH + lane],
            sign * samples[(4 * _SAMPLE8[2] + variable) * WIDTH + lane],
            sign * samples[(4 * _SAMPLE8[3] + variable) * WIDTH + lane],
            sign * samples[(4 * _SAMPLE8[4] + variable) * WIDTH + lane],
        )
    else:
        return (
            sign * samples[(4 * _SAMPLE4[0] + variable) * WIDTH + lane],
            sign * samples[(4 * _SAMPLE4[1] + variable) * WIDTH + lane],
            sign * samples[(4 * _SAMPLE4[2] + variable) * WIDTH + lane],
            0.0,
            0.0,
        )


@device
def _polynomial(s0, s1, s2, s3, s4, rk4):
    """Coefficients c1 .. c4 of the polynomial through the samples; its constant is s0."""
    if rk4 is None:
        return (
            _FIT8[1, 0] * s0 + _FIT8[1, 1] * s1 + _FIT8[1, 2] * s2 + _FIT8[1, 3] * s3 + _FIT8[1, 4] * s4,
            _FIT8[2, 0] * s0 + _FIT8[2, 1] * s1 + _FIT8[2, 2] * s2 + _FIT8[2, 3] * s3 + _FIT8[2, 4] * s4,
            _FIT8[3, 0] * s0 + _FIT8[3, 1] * s1 + _FIT8[3, 2] * s2 + _FIT8[3, 3] * s3 + _FIT8[3, 4] * s4,
            _FIT8[4, 0] * s0 + _FIT8[4, 1] * s1 + _FIT8[4, 2] * s2 + _FIT8[4, 3] * s3 + _FIT8[4, 4] * s4,
        )
    else:
        return (
            _FIT4[1, 0] * s0 + _FIT4[1, 1] * s1 + _FIT4[1, 2] * s2,
            _FIT4[2, 0] * s0 + _FIT4[2, 1] * s1 + _FIT4[2, 2] * s2,
            0.0,
            0.0,
        )


@routine
def _screen(samples, slots, loss_floor, counts, flags, rk4):
    """Count the lanes in which a step may hold a new extremum of each quantity, or a loss of contact at D or E.

    An extremum between the samples lies beyond them by a tenth of their range at most as long as it is a single one; twice
    that is allowed for. Most steps of a motion have no candidate, and looking closer costs more than the step itself.
    """
    counts[:] = 0
    for variable in range(3):
        above = 2 * variable
        top_floor = (2 * variable * _SLOTS + 1) * 4 * WIDTH
        bottom_floor = top_floor + _SLOTS * 4 * WIDTH if variable < 2 else top_floor
        high, low, lost = 0, 0, 0
        for lane in range(WIDTH):
            s0, s1, s2, s3, s4 = _samples(samples, above, lane, rk4)
            top, bottom = max(max(s0, s1), s2), min(min(s0, s1), s2)
            if rk4 is None:
                top, bottom = max(max(top, s3), s4), min(min(bottom, s3), s4)
            beyond = 0.2 * (top - bottom)
            is_high = top + beyond > slots[top_floor + lane]
            is_low = beyond - bottom > slots[bottom_floor + lane]
            is_lost = beyond - bottom > loss_floor[lane]
            # Kept for each lane: what becomes of one must not depend on its neighbours.
            flags[above * WIDTH + lane] = 1.0 if is_high else 0.0
            if variable < 2:
                flags[(above + 1) * WIDTH + lane] = 1.0 if is_low else 0.0
                flags[(_QUANTITIES + variable) * WIDTH + lane] = 1.0 if is_lost else 0.0
            high += is_high
            low += is_low
            lost += is_lost
        counts[above] = high
        if variable < 2:
            counts[above + 1], counts[_QUANTITIES + variable] = low, lost


@routine
def _peak(samples, quantity, best, position, rk4):
    """Estimated maximum over a step of each lane, from the polynomial through the samples, and its position.

    Positions beyond 1 tell that the polynomial still rises at the end: its maximum belongs to the next step.
    """
    for lane in range(WIDTH):
        s0, s1, s2, s3, s4 = _samples(samples, quantity, lane, rk4)
        c1, c2, c3, c4 = _polynomial(s0, s1, s2, s3, s4, rk4)
        top, at = s0, 0.0
        if rk4 is None:
            top, at = (s1, _AT8[1]) if s1 > top else (top, at)
            top, at = (s2, _AT8[2]) if s2 > top else (top, at)
            top, at = (s3, _AT8[3]) if s3 > top else (top, at)
            top, at = (s4, 1.0) if s4 > top else (top, at)
        else:
            top, at = (s1, 0.5) if s1 > top else (top, at)
            top, at = (s2, 1.0) if s2 > top else (top, at)
        x = at
        for _ in range(3):
            slope = c1 + x * (2.0 * c2 + x * (3.0 * c3 + x * 4.0 * c4))
            curvature = 2.0 * c2 + x * (6.0 * c3 + x * 12.0 * c4)
            move = -slope / curvature if curvature < 0.0 else (1.0 if slope > 0.0 else -1.0)
            x = min(max(x + min(max(move, -0.2), 0.2), 0.0), 1.5)
        inside = min(x, 1.0)
        value = s0 + inside * (c1 + inside * (c2 + inside * (c3 + inside * c4)))
        best[lane] = value if value > top else top
        position[lane] = x if value > top or x > 1.0 else at


@routine
def _keep(y, h, number, last, best, position, flags, open_lane, slots, states, quantity, n_state):
    """Put a step's candidate among the two best of its quantity: (value, position, step, h) and the state at its start."""
    first = quantity * _SLOTS * 4 * WIDTH
    second = first + 4 * WIDTH
    state1 = quantity * _SLOTS * n_state * WIDTH
    state2 = state1 + n_state * WIDTH
    news = 0
    for lane in range(WIDTH):
        # A maximum at the very start of a step belongs to the step before, one far beyond the end to the next: else the two
        # places would go to one and the same maximum.
        usable = open_lane[lane] > 0.0 and flags[quantity * WIDTH + lane] > 0.0
        usable = usable and (position[lane] > 0.0 or number == 0.0) and (position[lane] < 1.3 or last)
        position[lane] = min(position[lane], 1.0)
        best[lane] = best[lane] if usable else -np.inf
        news += best[lane] > slots[second + lane]
    if news == 0:
        return
    for lane in range(WIDTH):
        value = best[lane]
        lead = value > slots[first + lane]
        follow = value > slots[second + lane]
        slots[second + lane] = slots[first + lane] if lead else (value if follow else slots[second + lane])
        slots[first + lane] = value if lead else slots[first + lane]
        slots[second + WIDTH + lane] = (
            slots[first + WIDTH + lane] if lead else (position[lane] if follow else slots[second + WIDTH + lane])
        )
        slots[first + WIDTH + lane] = position[lane] if lead else slots[first + WIDTH + lane]
        slots[second + 2 * WIDTH + lane] = (
            slots[first + 2 * WIDTH + lane] if lead else (number if follow else slots[second + 2 * WIDTH + lane])
        )
        slots[first + 2 * WIDTH + lane] = number if lead else slots[first + 2 * WIDTH + lane]
        slots[second + 3 * WIDTH + lane] = (
            slots[first + 3 * WIDTH + lane] if lead else (h[lane] if follow else slots[second + 3 * WIDTH + lane])
        )
        slots[first + 3 * WIDTH + lane] = h[lane] if lead else slots[first + 3 * WIDTH + lane]
        position[lane] = 2.0 if lead else (1.0 if follow else 0.0)
    for c in range(n_state):
        for lane in range(WIDTH):
            a, b, new = state1 + c * WIDTH + lane, state2 + c * WIDTH + lane, y[c * WIDTH + lane]
            states[b] = states[a] if position[lane] == 2.0 else (new if position[lane] == 1.0 else states[b])
            states[a] = new if position[lane] == 2.0 else states[a]


@device
def _vertex(samples, quantity, lane, back, forth, rk4):
    """Maximum near 0 over [back, forth] of the polynomial through a short step's samples, and where; in lengths of it."""
    s0, s1, s2, s3, s4 = _samples(samples, quantity, lane, rk4)
    c1, c2, c3, c4 = _polynomial(s0, s1, s2, s3, s4, rk4)
    x = min(0.5, forth)
    for _ in range(3):
        slope = c1 + x * (2.0 * c2 + x * (3.0 * c3 + x * 4.0 * c4))
        curvature = 2.0 * c2 + x * (6.0 * c3 + x * 12.0 * c4)
        move = -slope / curvature if curvature < 0.0 else (1.0 if slope > 0.0 else -1.0)
        x = min(max(x + min(max(move, -3.0), 3.0), back), forth)
    return s0 + x * (c1 + x * (c2 + x * (c3 + x * c4))), x


@routine
def _refine(
    coef, slots, states, step_length, until, tasks, group_coef, state, trial, end, k, argument, samples, sums, error,
    first, probe, general, axial, exact, rk4, load, forces,
):  # fmt: skip
    """Replace the kept estimates of extrema by the motion's own: ``slots`` (value, position in steps, step, length).

    The runner-up counts only where its estimate could not be told from the best one's; its value is -inf elsewhere. What is
    left to do is gathered from all quantities and lanes into full groups of lanes: the coefficients and the state
    at the start of the candidate's step, a step up to the candidate, and a short one around it whose samples give the vertex.
    """
    n_state, n_coef = models.sizes(general, axial, exact)
    count = 0
    for quantity in range(_QUANTITIES):
        best = quantity * _SLOTS * 4 * WIDTH
        opposite = (quantity ^ 1 if quantity < 4 else 4) * _SLOTS * 4 * WIDTH
        for slot in range(_SLOTS):
            where = best + slot * 4 * WIDTH
            for lane in range(WIDTH):
                margin = _ESTIMATE_ERROR * (abs(slots[best + lane]) + abs(slots[opposite + lane]))
                if slots[where + lane] > -np.inf and (slot == 0 or slots[where + lane] > slots[best + lane] - margin):
                    tasks[count] = (quantity * _SLOTS + slot) * WIDTH + lane
                    count += 1
                else:
                    slots[where + lane] = -np.inf
    for task in tasks[:count]:
        where = task // WIDTH * 4 * WIDTH + task % WIDTH
        at = slots[where + WIDTH] * slots[where + 3 * WIDTH]
        # From here on the place of the short step's start, s, stands for the position.
        slots[where + WIDTH] = max(at - 0.5 * probe[0], 0.0)
    for attempt in range(_REFINEMENTS):
        left = 0
        for group in range(0, count, WIDTH):
            for lane in range(WIDTH):
                task = tasks[min(group + lane, count - 1)]
                slot, source = task // WIDTH, task % WIDTH
                first[lane] = slots[slot * 4 * WIDTH + WIDTH + source]
                for c in range(n_coef):
                    group_coef[c * WIDTH + lane] = coef[c * WIDTH + source]
                for c in range(n_state):
                    state[c * WIDTH + lane] = states[(slot * n_state + c) * WIDTH + source]
            _step(
                state, trial, group_coef, first, k, argument, samples, sums, error, _no(),
                general, axial, exact, rk4, load, forces,
            )  # fmt: skip
            _step(
                trial, end, group_coef, probe, k, argument, samples, sums, error, _yes(),
                general, axial, exact, rk4, load, forces,
            )  # fmt: skip
            for lane in range(min(WIDTH, count - group)):
                task = tasks[group + lane]
                quantity = task // WIDTH // _SLOTS
                where = task // WIDTH * 4 * WIDTH + task % WIDTH
                number, length = slots[where + 2 * WIDTH], slots[where + 3 * WIDTH]
                # An estimate may lie beyond its step's ends; only the ends of the statistics, ``until``, bind.
                after = 0.5 * step_length if length == step_length else 0.0
                before = 0.5 * step_length if number > 0.0 else 0.0
                ends = until[quantity // 4 * WIDTH + task % WIDTH] - number * step_length
                last = max(min(length + after, ends), length)
                back, forth = (-before - first[lane]) / probe[lane], (last - first[lane]) / probe[lane]
                value, move = _vertex(samples, quantity, lane, back, forth, rk4)
                found = first[lane] + move * probe[lane]
                done = move <= back or move >= forth or -0.1 <= move <= 1.1 or attempt == _REFINEMENTS - 1
                slots[where] = value
                slots[where + WIDTH] = found / step_length if done else max(found - 0.5 * probe[lane], -before)
                if not done:
                    tasks[left] = task
                    left += 1
        count = left
        if count == 0:
            break


@routine
def _smallest_force(y, coef, smallest, general, axial, exact, load):
    """min(N_D, N_E) of every lane."""
    for lane in range(WIDTH):
        _, _, _, _, n_d, n_e, _, _, _, _, _ = models.observe(y, coef, lane, WIDTH, general, axial, exact, load)
        smallest[lane] = min(n_d, n_e)


@routine
def _locate_loss(
    state, step, bracket, time, h, step_length, coef, trial, k, argument, samples, sums, error,
    low, high, f_low, f_high, side, force, general, axial, exact, rk4, load, forces,
):  # fmt: skip
    """Time (s) of the first root of min(N_D, N_E) in the lanes with a loss, by the Illinois rule; h is its place in the step.

    ``state`` is that at the start of the loss's ``step`` (-1: no loss), ``bracket`` a place in the step, as a share of it,
    where a force is negative. Every trial is a step from there. The time is -1 where no sign changes, -2 where contact has
    ended in the step before.
    """
    _smallest_force(state, coef, f_low, general, axial, exact, load)
    for lane in range(WIDTH):
        low[lane], side[lane] = 0.0, 0.0
        high[lane], h[lane] = bracket[lane], bracket[lane] * step_length
    for iteration in range(_ROOT_ITERATIONS):
        _step(
            state, trial, coef, h, k, argument, samples, sums, error, _no(), general, axial, exact, rk4, load, forces,
        )  # fmt: skip
        _smallest_force(trial, coef, force, general, axial, exact, load)
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
    _smallest_force(state, coef, force, general, axial, exact, load)
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


@kernel
def integrate(
    raw,
    steps,
    duration,
    on_loss,
    project_energy,
    force_step,
    force_at,
    ignore_step,
    out,
    general,
    axial,
    exact,
    rk4,
    load,
    forces,
    momentum,
    alone,
):
    """Integrate every column of ``raw`` over ``duration`` (s) in ``steps`` equal steps and write its results to ``out``.

    Parameters
    ----------
    raw : (parameters.COUNT, n) array, SI units
    on_loss : STOP, CONTINUE or END
    project_energy : bool
    force_step, force_at, ignore_step : (n,) int64, float64, int64
        Step in which a lane loses contact although its samples do not show it, the place in that step where a contact
        force is negative, and the last step at which a suspicion is to be passed over (-1, 0, -1 at first). A lane whose
        end shows that it needs them has status RERUN; one that ignores all its steps never does.
    out : (RESULTS, n) array
    general, axial, exact, rk4, load, forces, momentum : None or 1
        The equations of motion (:mod:`models`); rk4 instead of rk8; whether there is any load; whether contact forces,
        largest tilt and loss of contact are wanted; whether the angular momentum about Z is conserved.
    alone : None or 1
        Whether that is a symmetric body's motion alone (``general``, ``rk4`` and ``forces`` None). Not told from the
        others: of what is present Numba compiles both branches.
    """
    n = raw.shape[1]
    n_state, n_coef = models.sizes(general, axial, exact)
    if rk4 is None:
        stages = 12
    else:
        stages = 4
    coef, group_coef = _lanes(n_coef), _lanes(n_coef)
    y, end, trial = _lanes(n_state), _lanes(n_state), _lanes(n_state)
    argument, k = _lanes(n_state), _lanes(stages * n_state)
    samples, sums = _lanes((stages + 2) * 4), _lanes(5)
    slots = _lanes(_QUANTITIES * _SLOTS * 4)
    states = _lanes(_QUANTITIES * _SLOTS * n_state)
    integrals, loss_state = _lanes(4), _lanes(n_state)
    h, h_part, best, position = _lanes(1), _lanes(1), _lanes(1), _lanes(1)
    error, constraint_error, length, pose = _lanes(1), _lanes(1), _lanes(1), _lanes(5)
    energy0, work, energy_error, energy_scale = (
        _lanes(1),
        _lanes(1),
        _lanes(1),
        _lanes(1),
    )
    correction, momentum0 = _lanes(1), _lanes(1)
    bad_step, loss_step, loss_bracket = _lanes(1), _lanes(1), _lanes(1)
    open_forces, open_motion, loss_floor, loss_time = (
        _lanes(1), _lanes(1), _lanes(1), _lanes(1)
    )  # fmt: skip
    low, high, f_low, f_high, side = (
        _lanes(1), _lanes(1), _lanes(1), _lanes(1), _lanes(1)
    )  # fmt: skip
    counts, tasks = np.empty(_QUANTITIES + 2, np.int64), np.empty(_QUANTITIES * _SLOTS * WIDTH, np.int64)
    step_length = duration / steps
    probe, flags, until = _lanes(1), _lanes(_QUANTITIES + 2), _lanes(2)
    probe[:] = _PROBE * step_length

    for block in range(0, n, WIDTH):
        for lane in range(WIDTH):
            i = min(block + lane, n - 1)
            models.prepare(raw, i, coef, y, lane, WIDTH, general, axial, exact)
            length[lane] = raw[P.HALF_LENGTH, i]
        forced = 0
        for lane in range(WIDTH):
            kinetic, potential = _energies(y, coef, lane, general, axial, exact, load)
            energy0[lane], energy_scale[lane] = (
                kinetic + potential,
                max(kinetic, raw[P.LOAD_ENERGY, min(block + lane, n - 1)]),
            )
            work[lane], energy_error[lane], constraint_error[lane], correction[lane] = 0.0, 0.0, 0.0, 0.0
            if momentum is not None:
                momentum0[lane], _, _ = models.momentum(y, coef, lane, WIDTH, general, axial, exact)
            h[lane] = step_length
            bad_step[lane], loss_step[lane], loss_time[lane], loss_bracket[lane] = -1.0, -1.0, np.nan, 0.0
            open_forces[lane], open_motion[lane] = 1.0, 1.0
            loss_floor[lane] = 0.0
            forced += force_step[min(block + lane, n - 1)] >= 0
        if forces is not None:
            integrals[:] = 0.0
            slots[:] = 0.0
            for place in range(_QUANTITIES * _SLOTS):
                for lane in range(WIDTH):
                    slots[place * 4 * WIDTH + lane] = -np.inf
            for m in range(n_state * WIDTH):
                loss_state[m] = y[m]
            for place in range(_QUANTITIES * _SLOTS):
                for m in range(n_state * WIDTH):
                    states[place * n_state * WIDTH + m] = y[m]

        for step in range(steps):
            if alone is not None:
                _motion_step(y, end, coef, h, k, argument, error, axial, exact, load)
            else:
                _step(
                    y, end, coef, h, k, argument, samples, sums, error, _yes(), general, axial, exact, rk4, load, forces,
                )  # fmt: skip
            if forces is not None:
                # Losses first: the step in which contact ends belongs to the statistics only up to that instant.
                if forced > 0:
                    for lane in range(WIDTH):
                        i = min(block + lane, n - 1)
                        if step == force_step[i] and loss_step[lane] < 0.0:
                            for c in range(n_state):
                                loss_state[c * WIDTH + lane] = y[c * WIDTH + lane]
                            loss_bracket[lane], loss_step[lane], loss_floor[lane] = force_at[i], step, np.inf
                            open_forces[lane] = open_forces[lane] if on_loss == CONTINUE else 0.0
                            open_motion[lane] = open_motion[lane] if on_loss != END else 0.0
                _screen(samples, slots, loss_floor, counts, flags, rk4)
                for quantity in (1, 3):
                    if counts[_QUANTITIES + quantity // 2] == 0:
                        continue
                    _peak(samples, quantity, best, position, rk4)
                    for lane in range(WIDTH):
                        i = min(block + lane, n - 1)
                        if (
                            best[lane] > 0.0
                            and step > ignore_step[i]
                            and (loss_step[lane] < 0.0 or loss_step[lane] == step)
                        ):
                            if loss_step[lane] < 0.0:
                                for c in range(n_state):
                                    loss_state[c * WIDTH + lane] = y[c * WIDTH + lane]
                                loss_bracket[lane] = min(position[lane], 1.0)
                            loss_bracket[lane] = min(loss_bracket[lane], position[lane])
                            loss_step[lane] = step
                            loss_floor[lane] = np.inf
                            if on_loss != CONTINUE:
                                open_forces[lane] = 0.0
                            if on_loss == END:
                                open_motion[lane] = 0.0
                for quantity in range(_QUANTITIES):
                    if counts[quantity] == 0:
                        continue
                    _peak(samples, quantity, best, position, rk4)
                    open_lane = open_motion if quantity == 4 else open_forces
                    last = step == steps - 1
                    _keep(y, h, float(step), last, best, position, flags, open_lane, slots, states, quantity, n_state)
                for row in range(4):
                    for lane in range(WIDTH):
                        integrals[row * WIDTH + lane] += sums[row * WIDTH + lane] if open_forces[lane] > 0.0 else 0.0
            if general is not None:
                for lane in range(WIDTH):
                    work[lane] += sums[4 * WIDTH + lane]
            if project_energy:
                for lane in range(WIDTH):
                    best[lane] = energy0[lane] + work[lane]
                _project_energy(end, coef, best, correction, general, axial, exact, load)
            for lane in range(WIDTH):
                constraint_error[lane] = max(constraint_error[lane], error[lane])
            if project_energy or step % _ENERGY_INTERVAL == 0 or step == steps - 1:
                for lane in range(WIDTH):
                    kinetic, potential = _energies(end, coef, lane, general, axial, exact, load)
                    drift = abs(kinetic + potential - work[lane] - energy0[lane])
                    moving = open_motion[lane] > 0.0
                    # Written so that NaN is kept: a comparison with NaN is false.
                    energy_error[lane] = drift if moving and not drift <= energy_error[lane] else energy_error[lane]
                    energy_scale[lane] = kinetic if moving and kinetic > energy_scale[lane] else energy_scale[lane]
                    lost = not drift < np.inf and bad_step[lane] < 0.0 and moving
                    bad_step[lane] = float(step) if lost else bad_step[lane]
            y, end = end, y

        losses = 0
        for lane in range(WIDTH):
            losses += loss_step[lane] >= 0.0
        if forces is not None and losses > 0:
            _locate_loss(
                loss_state, loss_step, loss_bracket, loss_time, h_part, step_length, coef, trial, k, argument, samples, sums,
                error, low, high, f_low, f_high, side, best, general, axial, exact, rk4, load, forces,
            )  # fmt: skip
            if on_loss != CONTINUE:
                _step(
                    loss_state, trial, coef, h_part, k, argument, samples, sums, error, _yes(),
                    general, axial, exact, rk4, load, forces,
                )  # fmt: skip
                for row in range(4):
                    for lane in range(WIDTH):
                        integrals[row * WIDTH + lane] += sums[row * WIDTH + lane] if loss_step[lane] >= 0.0 else 0.0
                for lane in range(WIDTH):
                    low[lane] = 1.0 if loss_step[lane] >= 0.0 else 0.0
                    if on_loss == END and loss_step[lane] >= 0.0:
                        for c in range(n_state):
                            y[c * WIDTH + lane] = trial[c * WIDTH + lane]
                flags[:] = 1.0
                for quantity in range(_QUANTITIES if on_loss == END else 4):
                    _peak(samples, quantity, best, position, rk4)
                    _keep(
                        loss_state,
                        h_part,
                        0.0,
                        losses > 0,
                        best,
                        position,
                        flags,
                        low,
                        slots,
                        states,
                        quantity,
                        n_state,
                    )

        if forces is not None:
            for lane in range(WIDTH):
                lost = loss_time[lane] >= 0.0
                until[lane] = loss_time[lane] if lost and on_loss != CONTINUE else duration
                until[WIDTH + lane] = loss_time[lane] if lost and on_loss == END else duration
            _refine(
                coef, slots, states, step_length, until, tasks, group_coef, loss_state, trial, end, k, argument, samples,
                sums, error, best, probe, general, axial, exact, rk4, load, forces,
            )  # fmt: skip
            for quantity in range(_QUANTITIES):
                first = quantity * _SLOTS * 4 * WIDTH
                second = first + 4 * WIDTH
                for lane in range(WIDTH):
                    if slots[second + lane] > slots[first + lane]:
                        for row in range(3):
                            slots[first + row * WIDTH + lane] = slots[second + row * WIDTH + lane]

        for lane in range(min(WIDTH, n - block)):
            i = block + lane
            status = OK
            end_time = duration
            if bad_step[lane] >= 0.0:
                status, end_time = DIVERGED, (bad_step[lane] + 1.0) * step_length
            out[RERUN_FORCE, i], out[RERUN_AT, i], out[RERUN_IGNORE, i] = -1.0, 0.0, ignore_step[i]
            if forces is not None:
                span = duration
                if loss_step[lane] >= 0.0:
                    if loss_time[lane] >= 0.0:
                        status = CONTACT_LOST if status == OK or on_loss != CONTINUE else status
                        end_time = loss_time[lane]
                        if on_loss != CONTINUE:
                            span = loss_time[lane]
                    elif status == OK:
                        status = RERUN
                        out[RERUN_IGNORE, i] = loss_step[lane]
                        if loss_time[lane] == -2.0:
                            out[RERUN_FORCE, i], out[RERUN_AT, i] = loss_step[lane] - 1.0, 1.0
                elif status == OK:
                    for quantity in (1, 3):
                        first = quantity * _SLOTS * 4 * WIDTH
                        if slots[first + lane] > 0.0:
                            # The samples did not show it: contact is lost in the step that this place lies in.
                            place = slots[first + 2 * WIDTH + lane] + slots[first + WIDTH + lane]
                            number = min(max(math.floor(place), 0.0), steps - 1.0)
                            earlier = status == OK or number < out[RERUN_FORCE, i]
                            if ignore_step[i] >= steps:
                                status, end_time, loss_time[lane] = (
                                    CONTACT_LOST,
                                    place * step_length,
                                    place * step_length,
                                )
                            elif earlier:
                                status = RERUN
                                out[RERUN_FORCE, i], out[RERUN_AT, i] = number, place - number
                for end_plane in range(2):
                    first = 2 * end_plane * _SLOTS * 4 * WIDTH
                    second = first + _SLOTS * 4 * WIDTH
                    out[D_MAX + 4 * end_plane, i] = slots[first + lane]
                    out[D_MIN + 4 * end_plane, i] = -slots[second + lane]
                    if status == CONTACT_LOST and on_loss != CONTINUE and span > 0.0:
                        # Until contact is lost no force is negative: what is left below zero is the root's rounding.
                        out[D_MIN + 4 * end_plane, i] = max(-slots[second + lane], 0.0)
                    if span > 0.0:
                        out[D_MEAN + 4 * end_plane, i] = integrals[2 * end_plane * WIDTH + lane] / span
                        out[D_RMS + 4 * end_plane, i] = math.sqrt(integrals[(2 * end_plane + 1) * WIDTH + lane] / span)
                    else:
                        # Contact is lost at the start: the statistics are those of that instant.
                        out[D_MEAN + 4 * end_plane, i] = slots[first + lane]
                        out[D_RMS + 4 * end_plane, i] = abs(slots[first + lane])
                first = 4 * _SLOTS * 4 * WIDTH
                out[TILT_MAX, i] = math.atan(math.sqrt(max(slots[first + lane], 0.0)) / length[lane])
                out[LOSS_TIME, i] = loss_time[lane] if loss_time[lane] >= 0.0 else np.nan
            out[ENERGY_ERROR, i] = energy_error[lane] / energy_scale[lane] if energy_error[lane] != 0.0 else 0.0
            out[ENERGY_CORRECTION, i] = abs(correction[lane]) / energy_scale[lane] if correction[lane] != 0.0 else 0.0
            out[MOMENTUM_ERROR, i] = 0.0
            if momentum is not None:
                about_z, turn, constant = models.momentum(y, coef, lane, WIDTH, general, axial, exact)
                change = abs(about_z - momentum0[lane])
                # Cauchy and Schwarz: no momentum is larger at the largest kinetic energy.
                scale = math.sqrt(2.0 * energy_scale[lane] * turn) + constant
                out[MOMENTUM_ERROR, i] = change / scale if change != 0.0 else 0.0
            out[CONSTRAINT_ERROR, i] = constraint_error[lane]
            out[END_TIME, i], out[STATUS, i] = end_time, status
        _pose(y, coef, length, pose, general, axial, exact, load)
        for row in range(5):
            for lane in range(min(WIDTH, n - block)):
                out[ORIGIN_X + row, block + lane] = pose[row * WIDTH + lane]


@kernel
def trace(raw, steps, duration, project_energy, states, coef, general, axial, exact, rk4, load, forces):
    """States of the motion of column 0 of ``raw`` at the ends of all steps, ``states`` (steps + 1, state).

    The block's lanes all carry the same motion, so that a trajectory is bitwise what a sample with contact forces is.
    """
    n_state, _ = models.sizes(general, axial, exact)
    if rk4 is None:
        stages = 12
    else:
        stages = 4
    y, end = _lanes(n_state), _lanes(n_state)
    argument, k = _lanes(n_state), _lanes(stages * n_state)
    samples, sums, error = _lanes((stages + 2) * 4), _lanes(5), _lanes(1)
    h, energy, correction = _lanes(1), _lanes(1), _lanes(1)
    correction[:] = 0.0
    for column in range(1):  # a literal 0 would compile the equations once more
        for lane in range(WIDTH):
            models.prepare(raw, column, coef, y, lane, WIDTH, general, axial, exact)
    for lane in range(WIDTH):
        h[lane] = duration / steps
    for lane in range(WIDTH):
        kinetic, potential = _energies(y, coef, lane, general, axial, exact, load)
        energy[lane] = kinetic + potential
    for c in range(n_state):
        states[0, c] = y[c * WIDTH]
    for step in range(steps):
        _step(y, end, coef, h, k, argument, samples, sums, error, _no(), general, axial, exact, rk4, load, forces)
        if project_energy:
            if general is not None:
                for lane in range(WIDTH):
                    energy[lane] += sums[4 * WIDTH + lane]
            _project_energy(end, coef, energy, correction, general, axial, exact, load)
        y, end = end, y
        for c in range(n_state):
            states[step + 1, c] = y[c * WIDTH]


@kernel
def observe(states, coef, out, general, axial, exact, load):
    """(O_x, O_y, u, v, N_D, N_E, lambda_D, lambda_E, T, V, |w|^2) of every row of ``states`` into ``out`` (11, rows).

    ``coef`` is what :func:`trace` has prepared.
    """
    n_state, _ = models.sizes(general, axial, exact)
    y = _lanes(n_state)
    for row in range(states.shape[0]):
        for c in range(n_state):
            y[c * WIDTH] = states[row, c]
        for lane in range(1):  # as above
            values = models.observe(y, coef, lane, WIDTH, general, axial, exact, load)
            for j in range(11):
                out[j, row] = values[j]
