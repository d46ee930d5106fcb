"""One block of samples: from scalars to columns of outputs, each sample with its status."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from tolmc import quantities
from tolmc.kernels import parameters as P
from tolmc.kernels import results as R
from tolmc.mechanism import geometry
from tolmc.mechanism.scene import Scene
from tolmc.simulation.integration import integrate
from tolmc.simulation.judge import GEOMETRY_INVALID, difference, judged
from tolmc.simulation.one_sided import has_room
from tolmc.simulation.outputs import ROWS, integrates, lacking, wants_forces
from tolmc.simulation.packing import pack_again, scratch
from tolmc.simulation.plan import Plan


def block_columns(
    scene: Scene,
    columns: Mapping[str, np.ndarray],
    n: int,
    outputs: Sequence[str],
    plan: Plan,
    on_contact_loss: str,
    project_energy: bool,
) -> dict[str, np.ndarray]:
    """Columns of the outputs, status_time and status (its code) of ``n`` samples; valid until this thread's next block.

    ``columns`` are the scalars that vary, (n,) each. Absurd numbers run through: what they make of a motion is seen in its
    status, not in warnings.
    """
    with np.errstate(all="ignore"):
        raw, code = pack_again({**scene.scalars, **columns}, n)
        joint = _inside(code != GEOMETRY_INVALID)
        found = {name: _geometry(name, raw, joint) for name in outputs if name in quantities.GEOMETRY}
        found["status_time"] = np.full(n, np.nan)
        if plan.features.free:
            code[(code == R.OK) & ~has_room(raw, plan)] = GEOMETRY_INVALID
        valid = code == R.OK
        results: np.ndarray | None = None
        if integrates(outputs) and valid.any():
            forces, valid = wants_forces(outputs), _inside(valid)
            results = _results(raw, valid, plan, forces, scene.duration, on_contact_loss, project_energy)
            code[valid] = results[R.STATUS, valid]
            found["status_time"] = np.where(code != R.OK, results[R.END_TIME], np.nan)
            code = judged(code, results, raw, plan, forces)
    without = lacking(plan)
    for name in outputs:
        if name in ROWS:
            found[name] = np.full(n, np.nan) if results is None or name in without else results[ROWS[name]]
    return {name: found[name] for name in (*outputs, "status_time")} | {"status": code}


def _inside(chosen: np.ndarray) -> np.ndarray | slice:
    """The places that are chosen; all of them as a slice, which copies nothing."""
    return slice(None) if chosen.all() else chosen


def _geometry(name: str, raw: np.ndarray, joint: np.ndarray | slice) -> np.ndarray:
    """What follows from the dimensions of the samples that are a ``joint``; NaN of the others."""
    row = quantities.of(name).row
    if row:
        return raw[getattr(P, row)]
    values = np.full(raw.shape[1], np.nan)
    large, small, length = (raw[row, joint] for row in (P.BEARING_RADIUS, P.JOURNAL_RADIUS, P.HALF_LENGTH))
    if large.size:
        values[joint] = getattr(geometry, name)(large, small, length)
    return values


def _results(raw, valid, plan: Plan, forces: bool, duration: float, on_contact_loss: str, project_energy: bool):
    """The kernels' results (results.RESULTS, n); NaN of the samples that are not ``valid``."""
    inside = np.ascontiguousarray(raw[:, valid])
    if plan.formulation == "slope":
        out = scratch("results", R.RESULTS, inside.shape[1])
        part = integrate(inside, plan, forces, duration, on_contact_loss, project_energy, out)
        if plan.halving:
            finer = replace(plan, steps=2 * plan.steps)
            fine = integrate(inside, finer, forces, duration, on_contact_loss, project_energy)
            part[R.HALVING_ERROR] = difference(part, fine, inside[P.RADIUS], forces)
    else:
        from tolmc.simulation.published import published_results  # and with it Numba, which takes half a second to load

        part = published_results(inside, plan, forces, duration, on_contact_loss)
    if isinstance(valid, slice):
        return part
    results = np.full((R.RESULTS, raw.shape[1]), np.nan)
    results[:, valid] = part
    return results
