"""Kernels: equations of motion, a stepper and watchers composed into one loop over blocks of lanes.

:func:`build` composes by closures over device functions: over sources only, never over values of a run. What it returns is an
entry that closes over nothing (:func:`tolmc.kernels.jit.entry`), so that its compiled code is found again by other processes.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

import numpy as np

from tolmc.kernels import jit, loops, names, tableaux
from tolmc.kernels.formulations import FORMULATIONS
from tolmc.kernels.lanes import WIDTH, Layout
from tolmc.kernels.once import once
from tolmc.kernels.seen import ROWS
from tolmc.kernels.steppers import Stepper, stages
from tolmc.kernels.system import System, observer
from tolmc.kernels.watchers import (
    Watcher,
    contact_loss,
    energy,
    extrema,
    friction,
    invariants,
    pose,
    rates,
    step_error,
    together,
)
from tolmc.kernels.watchers.between import between


@once
def stepper_of(formulation: str, method: str, load: bool, forces: bool) -> tuple[Stepper, Layout]:
    """A stepper and the layout of its rows: one for all kernels, which so share its compilation."""
    equations, layout = FORMULATIONS[formulation], Layout()
    tableau = tableaux.DORMAND_PRINCE if method == tableaux.PUBLISHED else tableaux.METHODS[method]
    return stages.build(tableau, equations, _plain(load), forces, layout), layout


@once
def build(formulation: str, method: str, *, load: bool, forces: bool) -> Callable:
    """Entry ``integrate(raw, steps, duration, on_loss, project_energy, momentum, out)``.

    It integrates every column of ``raw`` over ``duration`` (s) in ``steps`` equal steps and writes its results to ``out``;
    the arguments are those of :class:`tolmc.kernels.lanes.Run`.

    Parameters
    ----------
    formulation : name in :data:`FORMULATIONS`
    method : name in :data:`tolmc.kernels.tableaux.METHODS`, or :data:`tolmc.kernels.tableaux.PUBLISHED`
    load : whether there is any load
    forces : whether contact forces, largest tilt and loss of contact are wanted
    """
    system = _system(formulation, method, load, forces)
    watcher, name = together(_watchers(system, forces)), names.integrate(formulation, method, load=load, forces=forces)
    entry, loop = (loops.watch, loops.watch_blocks) if forces else (loops.integrate, loops.integrate_blocks)
    parts = _parts(system)
    watching = {"begin": watcher.begin, "look": watcher.look, "scan": watcher.scan, "finish": watcher.finish}
    blocks = jit.piece(loop, f"{name}_blocks", **watching, **parts)
    window = [ROWS * system.equations.STATE, ROWS * system.seen] if forces else []
    return jit.entry(entry, name, buffers=_numbers(system.layout.rows, *window), blocks=blocks)


@once
def build_trace(formulation: str, method: str, *, load: bool) -> Callable:
    """Entry ``trace(raw, steps, duration, on_energy, states, coef)``: the states at the ends of all steps.

    ``states`` (steps + 1, STATE) of the motion of column 0 of ``raw``, ``coef`` its coefficients; with ``on_energy`` every step
    is projected on the energy. The step is the one that the statistics take: a trajectory is bitwise what a sample with
    contact forces is. Its head's sizes say how much ``states`` and ``coef`` hold: "state" and "coefficients".
    """
    system = _system(formulation, method, load, forces=True)
    target_rows, correction_rows = system.layout.block(1), system.layout.block(1)
    name, equations = names.trace(formulation, method, load=load), system.equations
    block = jit.piece(
        loops.trace_block, f"{name}_block", project_energy=energy.projection(equations, system.load),
        target_rows=target_rows, correction_rows=correction_rows, **_parts(system),
    )  # fmt: skip
    sizes = {"state": equations.STATE, "coefficients": equations.COEFFICIENTS * WIDTH}
    return jit.entry(loops.trace, name, buffers=_numbers(system.layout.rows), sizes=sizes, blocks=block)


@once
def build_observe(formulation: str, *, load: bool) -> Callable:
    """Entry ``observe(states, coef, out)``: what the formulation observes in every row of ``states``, into ``out`` (11, rows).

    ``coef`` is what the trace has prepared.
    """
    equations = FORMULATIONS[formulation]
    name = names.observe(formulation, load=load)
    rows = jit.piece(
        loops.observe_rows, f"{name}_rows", observe_lane=observer(equations, _plain(load)), state=equations.STATE
    )
    return jit.entry(loops.observe, name, buffers=_numbers(equations.STATE), blocks=rows)


def _system(formulation: str, method: str, load: bool, forces: bool) -> System:
    stepper, layout = stepper_of(formulation, method, load, forces)
    return System.of(FORMULATIONS[formulation], _plain(load), stepper, layout.copy())


def _plain(flag: bool) -> bool:
    """The flag as no literal of Numba's: the equations are compiled once for both, and their arithmetic is one and the same."""
    return cast(bool, np.bool_(flag))


def _watchers(system: System, forces: bool) -> list[Watcher]:
    """The watchers of a kernel, in the order of their work."""
    watchers = [energy.watch(system, forces), invariants.constraints(system, forces)]
    if forces:
        polynomials = between(system)
        statistics = [extrema.watch(system, polynomials), step_error.watch(system, polynomials)]
        rubbing = [friction.watch(system)] if system.equations.RUBS else []
        loss = contact_loss.watch(system, polynomials)
        watchers = [rates.watch(system), loss, *statistics, *watchers, *rubbing]
    return [*watchers, invariants.angular_momentum(system), pose.watch(system)]


def _parts(system: System) -> dict[str, object]:
    """What the loops need of a system, once all its rows are given out."""
    equations, seen_rows = system.equations, system.layout.block(system.seen)
    return {
        "prepare": equations.prepare, "start": equations.start, "observe_lane": system.observe,
        "state": equations.STATE, "torque": equations.TORQUE,
        "step_once": system.stepper.step, "see": system.stepper.see, "seen_rows": seen_rows,
        "what": system.seen, "at": system.at,
        "y_rows": system.y, "end_rows": system.end, "coef_rows": system.coef, "h_rows": system.h,
        "until": system.until, "bad_step": system.bad_step, "end_state": system.end_state, "end_seen": system.end_seen,
        "part_h": system.part_h,
    }  # fmt: skip


def _numbers(*rows: int) -> list[int]:
    """How many numbers stand in each of these rows' buffers."""
    return [count * WIDTH for count in rows]
