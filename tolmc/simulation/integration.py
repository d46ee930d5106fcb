"""The way into the kernels in slope coordinates: samples to results, one motion to its trace."""

from __future__ import annotations

import numpy as np

from tolmc.kernels import ensemble, models
from tolmc.simulation import results as R
from tolmc.simulation.plan import Plan

#: What a call of the kernels takes at best: lanes that run together.
WIDTH = ensemble.WIDTH
_ON_LOSS = {"stop": ensemble.STOP, "continue": ensemble.CONTINUE, "end": ensemble.END}
_ATTEMPTS = 5  # runs of a lane whose loss of contact only its refined extrema decide


def integrate(
    raw,
    plan: Plan,
    forces: bool,
    duration: float,
    on_contact_loss: str,
    project_energy: bool,
    out: np.ndarray | None = None,
) -> np.ndarray:
    """Results (R.RESULTS, n) of the columns of ``raw``; lanes that ask for it are run again as they ask."""
    n = raw.shape[1]
    out = np.empty((R.RESULTS, n)) if out is None else out
    features, rk4 = plan.features, plan.method == "rk4"
    # The published forms' pilot must not take its steps from a formula that they don't have.
    alone = plan.formulation == "slope" and not (features.general or rk4 or forces)
    force, at, ignore = np.full(n, -1), np.zeros(n), np.full(n, -1)
    lanes: slice | np.ndarray = slice(None)
    for attempt in range(_ATTEMPTS):
        if attempt == _ATTEMPTS - 1:
            force[lanes], ignore[lanes] = -1, plan.steps
        part = np.empty((R.RESULTS, len(lanes))) if isinstance(lanes, np.ndarray) else out
        ensemble.integrate(
            np.ascontiguousarray(raw[:, lanes]), plan.steps, duration, _ON_LOSS[on_contact_loss], project_energy,
            force[lanes], at[lanes], ignore[lanes], part,
            *features.model, *(1 if flag else None for flag in (rk4, features.load, forces, features.momentum, alone)),
        )  # fmt: skip
        if part is not out:
            out[:, lanes] = part
        lanes = np.flatnonzero(out[R.STATUS] == R.RERUN)
        if not len(lanes):
            break
        force[lanes], at[lanes] = out[R.RERUN_FORCE, lanes].astype(np.int64), out[R.RERUN_AT, lanes]
        ignore[lanes] = np.maximum(ignore[lanes], out[R.RERUN_IGNORE, lanes].astype(np.int64))
    out[R.SPIN_ERROR] = 0.0  # where Omega is conserved, these equations have it as a constant
    return out


def trace(raw: np.ndarray, plan: Plan, duration: float, project_energy: bool) -> np.ndarray:
    """(O_x, O_y, u, v, N_D, N_E, lambda_D, lambda_E, T, V, |w|^2) of column 0 at the ends of all steps, (11, steps + 1)."""
    model, load = plan.features.model, 1 if plan.features.load else None
    sizes = getattr(
        models.sizes, "py_func", models.sizes
    )  # without compilation (NUMBA_DISABLE_JIT) it is the function itself
    n_state, n_coef = sizes(*model)
    states = np.empty((plan.steps + 1, n_state))
    coef = np.empty(n_coef * WIDTH)
    rk4 = 1 if plan.method == "rk4" else None
    # The forces are not looked at here; with them the step is the one that the statistics have compiled.
    ensemble.trace(raw, plan.steps, duration, project_energy, states, coef, *model, rk4, load, 1)
    seen = np.empty((11, plan.steps + 1))
    ensemble.observe(states, coef, seen, *model, load)
    return seen
