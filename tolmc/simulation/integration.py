"""The way into the kernels in slope coordinates: samples to results, one motion to its trace."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from tolmc.kernels import entries, lanes
from tolmc.kernels import parameters as P
from tolmc.kernels import results as R
from tolmc.kernels.tableaux import PUBLISHED
from tolmc.simulation import one_sided
from tolmc.simulation.plan import Plan
from tolmc.simulation.second_look import look_again

#: What a call of the kernels takes at best: lanes that run together.
WIDTH = lanes.WIDTH
# "stop" and "end" are one: what the two-sided model makes of a journal that has left the wall is no motion of it.
_ON_LOSS = {"stop": R.END, "continue": R.CONTINUE, "end": R.END}

# How the error of the roughest step is judged. Statistics err up to ten times less than the forces at one step's end, or, as
# errors add up and grow along a motion, more: a pilot has seen by how much. In random motions at given steps 1e-5 may become
# 1e-3: beyond 1e-5 no given step is trusted, whatever accuracy is asked for.
_TRUSTED, _OF_STATISTICS = 1e-5, 0.3
# So many steps as rough as the roughest are usual and part of that: nine random motions in ten have fewer.
_USUAL = 3.0


def integrate(
    raw,
    plan: Plan,
    forces: bool,
    duration: float,
    on_contact_loss: str,
    project_energy: bool,
    out: np.ndarray | None = None,
) -> np.ndarray:
    """Results (R.RESULTS, n) of the columns of ``raw``, with a wall that only pushes where the plan has one."""
    out = np.empty((R.RESULTS, raw.shape[1])) if out is None else out
    features = plan.features
    if features.alone:
        return one_sided.integrate(raw, plan, duration, out)
    if not (features.one_sided or features.rubs):
        return _two_sided(raw, plan, forces, duration, on_contact_loss, project_energy, out)
    # The forces are needed whoever asks for them: they say which motions leave the wall, and friction follows them.
    _two_sided(raw, plan, True, duration, "end", project_energy, out)
    one_sided.never_left(out)
    if features.rubs:
        worn = raw[P.WEAR_COEFFICIENT] * (out[R.D_SLIP_WORK] + out[R.E_SLIP_WORK])
        out[R.WEAR_RATE] = worn / np.where(out[R.END_TIME] > 0.0, out[R.END_TIME], 1.0)
    lost = out[R.STATUS] == R.CONTACT_LOST
    if features.one_sided and lost.any():
        out[:, lost] = one_sided.follow(raw[:, lost], plan, duration, out[:, lost])
    return out


def _two_sided(
    raw, plan: Plan, forces: bool, duration: float, on_contact_loss: str, project_energy: bool, out: np.ndarray
) -> np.ndarray:
    """The same with a wall that holds the journal."""
    features = plan.features
    # The published forms' pilot must not take its steps from a formula that they don't have.
    method = PUBLISHED if plan.formulation != "slope" and plan.method == "rk8" else plan.method
    kernel = entries.integrate(features.formulation, method, load=features.load, forces=forces)
    on_loss, raw = _ON_LOSS[on_contact_loss], np.ascontiguousarray(raw)
    if features.rubs:
        raw[P.HELD] = features.driven
    kernel(raw, plan.steps, duration, on_loss, project_energy, features.momentum, out)
    out[R.STEP_ERROR] = _step_error(out, plan)
    if forces and math.isnan(plan.pilot_error) and not plan.halving:

        def once_more(columns: np.ndarray, other: Plan) -> np.ndarray:
            space = np.empty((R.RESULTS, columns.shape[1]))
            halved = replace(other, halving=True)  # judged by two integrations already
            return _two_sided(columns, halved, forces, duration, on_contact_loss, project_energy, space)

        look_again(out, raw, plan, duration, once_more)
    out[R.SPIN_ERROR] = 0.0  # where Omega is conserved, these equations have it as a constant
    return out


def _step_error(out: np.ndarray, plan: Plan) -> np.ndarray:
    """What a motion's statistics may err by, relative to its largest force.

    What is left of an extremum is its own error; at given steps it is a sign of worse, as the roughest step's error is, and
    steps as rough as that one count too: the pilot has measured what they add up to.
    """
    grows, is_given = of_statistics(plan), math.isnan(plan.pilot_error)
    rough = out[R.ROUGHEST] * np.fmax(out[R.AS_ROUGH] / _USUAL, 1.0) if is_given else out[R.ROUGHEST]
    return np.maximum(grows * rough, (grows if is_given else 1.0) * out[R.DOUBT])


def of_statistics(plan: Plan) -> float:
    """Error of a motion's statistics over that of its roughest step, as samples are judged."""
    if math.isnan(plan.pilot_error):
        return max(_OF_STATISTICS, plan.accuracy / _TRUSTED)
    return _OF_STATISTICS if math.isnan(plan.growth) else max(_OF_STATISTICS, plan.growth)


def trace(raw: np.ndarray, plan: Plan, duration: float, project_energy: bool) -> np.ndarray:
    """(O_x, O_y, u, v, N_D, N_E, lambda_D, lambda_E, T, V, |w|^2) of column 0 at the ends of all steps, (11, steps + 1)."""
    formulation, load = plan.features.formulation, plan.features.load
    integrate_one = entries.trace(formulation, plan.method, load=load)
    sizes = integrate_one.head.sizes
    states, coef = np.empty((plan.steps + 1, sizes["state"])), np.empty(sizes["coefficients"])
    integrate_one(np.ascontiguousarray(raw), plan.steps, duration, project_energy, states, coef)
    seen = np.empty((11, plan.steps + 1))
    entries.observe(formulation, load=load)(states, coef, seen)
    return seen
