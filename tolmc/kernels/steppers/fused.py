"""A step of the motion alone, its stages' arguments and right-hand sides in one loop over the lanes.

Sums wait for memory, right-hand sides for arithmetic; in one loop they overlap, and a step takes a tenth less. For equations
short enough to be compiled once a stage: those of a symmetric body.
"""

from __future__ import annotations

from types import ModuleType

from tolmc.kernels.jit import inlined, piece, routine
from tolmc.kernels.lanes import WIDTH, Layout
from tolmc.kernels.steppers import Stepper
from tolmc.kernels.tableaux import MOTION_ALONE, MOTION_ARGUMENTS, motion_end


def build(equations: ModuleType, load: bool, layout: Layout) -> Stepper:
    """Stepper by the formula of the motion alone; it leaves neither samples nor sums."""
    state = equations.STATE
    size = state * WIDTH
    argument_rows, k_rows = layout.block(state), layout.block(MOTION_ALONE.stages * state)
    error_rows, none = layout.block(1), layout.block(0)
    project = equations.project
    stages = _in_order([_stage(equations, load, number, at) for number, at in enumerate(MOTION_ARGUMENTS)])

    @routine
    def through_stages(y, end, coef, h, k, argument, error):
        stages(y, k, argument, coef, h)
        for lane in range(WIDTH):
            for c in range(state):
                end[c * WIDTH + lane] = motion_end(y, k, size, c * WIDTH + lane)
            error[lane] = project(end, coef, lane, WIDTH)

    @inlined
    def step(y, end, coef, h, work, watch):
        through_stages(y, end, coef, h, work[k_rows], work[argument_rows], work[error_rows])

    return Stepper(MOTION_ALONE, step, error_rows, none, none)


def _stage(equations: ModuleType, load: bool, number: int, argument_at):
    """One stage: its argument's sum over the stages before, and its right-hand side."""
    state, advance = equations.STATE, equations.advance
    size = state * WIDTH

    @piece
    def stage(y, k, argument, coef, h):
        for lane in range(WIDTH):
            for c in range(state):
                argument[c * WIDTH + lane] = argument_at(y, k, size, c * WIDTH + lane)
            advance(argument, coef, h[lane], k, number * size, lane, WIDTH, load)

    return stage


def _in_order(stages):
    """One function that calls all stages."""
    first, *others = stages
    if not others:
        return first
    rest = _in_order(others)

    @inlined
    def in_order(y, k, argument, coef, h):
        first(y, k, argument, coef, h)
        rest(y, k, argument, coef, h)

    return in_order
