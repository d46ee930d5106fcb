"""Explicit Runge-Kutta steps stage by stage: rk8 and rk4, with the contact forces seen at the stages."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType

from tolmc.kernels import tableaux
from tolmc.kernels.jit import inlined, routine
from tolmc.kernels.lanes import WIDTH, Layout, observer
from tolmc.kernels.steppers import Stepper
from tolmc.kernels.tableaux import Tableau


@dataclass(frozen=True)
class Method:
    """A tableau and its sums over a block: arguments of stages, the step's end, and its midpoint where stages are too crude."""

    tableau: Tableau
    argument: Callable
    end: Callable
    midpoint: Callable | None = None


RK8 = Method(tableaux.DORMAND_PRINCE, tableaux.stage_argument_rk8, tableaux.step_end_rk8)
RK4 = Method(tableaux.CLASSICAL, tableaux.stage_argument_rk4, tableaux.step_end_rk4, tableaux.midpoint_rk4)


def build(method: Method, equations: ModuleType, load: bool, forces: bool, layout: Layout) -> Stepper:
    """Stepper of ``method`` for ``equations``; with ``forces`` a step that is watched leaves samples and sums.

    Without them the sums hold the torque's work alone, where there can be one.
    """
    stages, weights = method.tableau.stages, method.tableau.b
    size, torque = equations.STATE * WIDTH, equations.TORQUE
    argument_rows, k_rows = layout.block(equations.STATE), layout.block(stages * equations.STATE)
    sample_rows, sum_rows, error_rows = layout.block((stages + 2) * 4), layout.block(5), layout.block(1)
    stage_argument, step_end = method.argument, method.end
    advance, project = equations.advance, equations.project
    sample_extra, integrate = _extra_samples(method, equations, load), _integrals(method.tableau, torque)
    extra = method.midpoint is not None

    # Arrays by themselves: of slices within the function LLVM would not see how few alias checks tell them apart.
    @routine
    def through_stages(y, end, coef, h, k, argument, samples, sums, error, watch):
        for stage in range(stages):
            first, row = stage * size, 4 * stage * WIDTH
            stage_argument(stage, y, k, argument, size)
            weight = weights[stage]
            # Two written arrays, three read: with one more, LLVM's alias checks exceed their limit and the loop is scalar.
            if not torque and (not forces or weight == 0.0 or not watch):
                for lane in range(WIDTH):
                    advance(argument, coef, h[lane], k, first, lane, WIDTH, load)
            else:
                for lane in range(WIDTH):
                    n_d, n_e, w2, power = advance(argument, coef, h[lane], k, first, lane, WIDTH, load)
                    samples[row + lane] = n_d
                    samples[row + WIDTH + lane] = n_e
                    samples[row + 2 * WIDTH + lane] = w2
                    if torque:
                        samples[row + 3 * WIDTH + lane] = power
        step_end(y, k, end, size)
        for lane in range(WIDTH):
            error[lane] = project(end, coef, lane, WIDTH)
        if extra and forces and watch:
            sample_extra(y, end, k, argument, coef, samples)
        if torque or (forces and watch):
            for lane in range(WIDTH):
                integrate(samples, h, sums, lane)

    @inlined
    def step(y, end, coef, h, work, watch):
        samples, sums, error = work[sample_rows], work[sum_rows], work[error_rows]
        through_stages(y, end, coef, h, work[k_rows], work[argument_rows], samples, sums, error, watch)

    return Stepper(method.tableau, step, error_rows, sample_rows, sum_rows)


def _extra_samples(method: Method, equations: ModuleType, load: bool):
    """Samples at the step's midpoint and end, rows ``stages`` and ``stages + 1``."""
    stages, size = method.tableau.stages, equations.STATE * WIDTH
    midpoint, observe = method.midpoint, observer(equations, load)
    if midpoint is None:

        @inlined
        def nothing(y, end, k, argument, coef, samples):
            pass

        return nothing

    @routine
    def look(y, coef, samples, row):
        for lane in range(WIDTH):
            _, _, _, _, n_d, n_e, _, _, _, _, w2 = observe(y, coef, lane)
            samples[row + lane] = n_d
            samples[row + WIDTH + lane] = n_e
            samples[row + 2 * WIDTH + lane] = w2

    @inlined
    def sample_extra(y, end, k, argument, coef, samples):
        midpoint(y, k, argument, size)
        look(argument, coef, samples, 4 * stages * WIDTH)
        look(end, coef, samples, 4 * (stages + 1) * WIDTH)

    return sample_extra


def _integrals(tableau: Tableau, torque: bool):
    """Increments of the integrals over one lane's step, by the method's weights."""
    stages, weights = tableau.stages, tableau.b

    @inlined
    def integrate(samples, h, sums, lane):
        d, d2, e, e2, work = 0.0, 0.0, 0.0, 0.0, 0.0
        for stage in range(stages):
            weight = weights[stage]
            if weight != 0.0:
                row = 4 * stage * WIDTH
                n_d, n_e = samples[row + lane], samples[row + WIDTH + lane]
                d += weight * n_d
                d2 += weight * n_d * n_d
                e += weight * n_e
                e2 += weight * n_e * n_e
                if torque:
                    work += weight * samples[row + 3 * WIDTH + lane]
        sums[lane], sums[WIDTH + lane] = h[lane] * d, h[lane] * d2
        sums[2 * WIDTH + lane], sums[3 * WIDTH + lane] = h[lane] * e, h[lane] * e2
        if torque:
            sums[4 * WIDTH + lane] = h[lane] * work

    return integrate
