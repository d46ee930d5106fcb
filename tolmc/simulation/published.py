"""Motions in the paper's own coordinates, for comparison, and their statistics."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tolmc.kernels import parameters as P
from tolmc.kernels import published
from tolmc.kernels import results as R
from tolmc.kernels.tableaux import TABLEAUX
from tolmc.simulation.judge import SINGULAR_PSI, SINGULAR_THETA, SINGULAR_TILT
from tolmc.simulation.plan import Plan

if TYPE_CHECKING:
    from tolmc.simulation.continuous import Sampled

_STATUS = {
    published.SINGULAR_PSI: SINGULAR_PSI,
    published.SINGULAR_MAXIMUM_TILT: SINGULAR_TILT,
    published.SINGULAR_THETA: SINGULAR_THETA,
    published.DIVERGED: R.DIVERGED,
}


@dataclass(frozen=True)
class Records:
    """A motion in the paper's coordinates at the ends of its steps; rows after the last valid one are NaN."""

    status: int
    rows: int
    q: np.ndarray
    qd: np.ndarray
    axis: np.ndarray
    contact_force: np.ndarray
    multipliers: np.ndarray
    energy: np.ndarray
    work: np.ndarray


def published_records(parameters: np.ndarray, plan: Plan, duration: float) -> Records:
    tableau, n = TABLEAUX[plan.method], plan.steps + 1
    q, qd, axis = np.empty((n, 5)), np.empty((n, 5)), np.empty((n, 3))
    force, multipliers, energy, work = np.empty((n, 2)), np.empty((n, 2)), np.empty(n), np.empty(n)
    q[0], qd[0] = published.start(parameters)
    regular = plan.formulation == "published-regular"
    status, rows = published.integrate(
        parameters, duration / plan.steps, tableau.matrix, tableau.b, regular,
        q, qd, axis, force, multipliers, energy, work,
    )  # fmt: skip
    return Records(status, rows, q, qd, axis, force, multipliers, energy, work)


def published_results(raw, plan: Plan, forces: bool, duration: float, on_contact_loss: str) -> np.ndarray:
    """Results (R.RESULTS, n) of the columns of ``raw`` in the paper's coordinates.

    One motion after the other: these formulations are for comparison. A motion that ends at a singular set has no
    statistics; its status says which set, its end time when.
    """
    out = np.full((R.RESULTS, raw.shape[1]), np.nan)
    step = duration / plan.steps
    for i in range(raw.shape[1]):
        parameters = np.ascontiguousarray(raw[:, i])
        records = published_records(parameters, plan, duration)
        status, rows = records.status, records.rows
        quantities: list[Sampled] = []
        if status == published.OK and forces:
            sampled_status, quantities = _quantities(parameters, plan, records, step)
            lost = [quantity.first_gap() for quantity in quantities]
            if min(lost) < plan.steps:
                status, rows = sampled_status, 1 + min(lost)
        if status != published.OK:
            out[R.STATUS, i] = _STATUS[status]
            out[R.END_TIME, i] = max(rows - 1, 0) * step
            continue
        drift = np.abs(records.energy - records.work - records.energy[0]).max()
        out[R.ENERGY_ERROR, i] = drift / _kinetic_scale(records, parameters) if drift else 0.0
        out[R.MOMENTUM_ERROR, i], out[R.SPIN_ERROR, i] = _invariants(records, parameters)
        out[R.ENERGY_CORRECTION, i] = 0.0
        d, e, r = *_ends(records, parameters), parameters[P.RADIUS]
        out[R.CONSTRAINT_ERROR, i] = max(np.abs(np.hypot(*end.T) / r - 1).max() for end in (d, e))
        out[R.ORIGIN_X : R.ORIGIN_Y + 1, i] = records.q[-1, :2]
        out[R.AXIS_X : R.AXIS_Z + 1, i] = records.axis[-1]
        out[R.END_TIME, i], out[R.STATUS, i] = duration, R.OK
        if not forces:
            continue
        tilt, *sides = quantities
        losses = [side.first_root() for side in sides]
        loss = np.nan if np.isnan(losses).all() else float(np.nanmin(losses))
        until = duration if np.isnan(loss) or on_contact_loss == "continue" else loss
        for first, side in zip((R.D_MAX, R.E_MAX), sides, strict=True):
            mean = side.integral(until) / until if until > 0 else side.records[0]
            square = side.squared().integral(until) / until if until > 0 else side.records[0] ** 2
            # The polynomial through the squares of a coarse step may turn negative.
            rms = math.sqrt(max(square, 0.0))
            out[first : first + 4, i] = side.maximum(until), -side.negative().maximum(until), mean, rms
        out[R.TILT_MAX, i] = tilt.maximum(until)
        out[R.LOSS_TIME, i] = loss
        if not np.isnan(loss):
            out[R.STATUS, i], out[R.END_TIME, i] = R.CONTACT_LOST, loss
    return out


def _invariants(records: Records, parameters: np.ndarray) -> tuple[float, float]:
    """Relative change of the angular momentum about Z and of Omega between the start and the end of a motion."""
    body = published.body_matrix(parameters)
    momenta, spins = [], []
    for q, speeds in zip(records.q[[0, -1]], records.qd[[0, -1]], strict=True):
        mass_matrix, _ = published.mass_matrix(q, body)
        turn = np.array([-q[1], q[0], 1.0, 0.0, 0.0])
        largest = math.sqrt((turn @ mass_matrix @ turn) * (speeds @ mass_matrix @ speeds))
        momenta.append((turn @ mass_matrix @ speeds, largest))
        spins.append((speeds[4] + speeds[2] * math.cos(q[3]), np.abs(speeds[2:]).max()))
    changes: list[float] = []
    for (first, scale_first), (last, scale_last) in (momenta, spins):
        change = abs(last - first)
        changes.append(change / max(scale_first, scale_last) if change else 0.0)
    return changes[0], changes[1]


def _quantities(parameters, plan: Plan, records: Records, step: float) -> tuple[int, list[Sampled]]:
    """Status of the motion between its records, and tilt, N_D, N_E with their samples there.

    A sample that meets a singular set where the records pass it is bridged by its step's other samples.
    """
    # SciPy's interpolation, a third of a second to import, is for these formulations alone.
    from tolmc.simulation.continuous import POSITIONS, Sampled

    tableau = TABLEAUX[plan.method]
    origin, axis, force = (np.empty((plan.steps, len(POSITIONS), width)) for width in (2, 3, 2))
    status = published.sample_steps(
        parameters, step, tableau.matrix, tableau.b, plan.formulation == "published-regular", records.q, records.qd,
        POSITIONS, origin, axis, force,
    )  # fmt: skip
    tilt = Sampled(tilt_of(records.axis), tilt_of(axis), step)
    sides = [Sampled(records.contact_force[:, k], force[:, :, k], step) for k in range(2)]
    return status, [quantity.bridged() for quantity in (tilt, *sides)]


def tilt_of(axis: np.ndarray) -> np.ndarray:
    return np.arctan2(np.hypot(axis[..., 0], axis[..., 1]), axis[..., 2])


def _ends(records: Records, parameters: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """D and E at the records, (n, 2) each."""
    offset = parameters[P.HALF_LENGTH] * records.axis[:, :2] / records.axis[:, 2:]
    return records.q[:, :2] + offset, records.q[:, :2] - offset


def _kinetic_scale(records: Records, parameters: np.ndarray) -> float:
    """Largest kinetic energy of a motion, J; without C Omega^2/2 where the body is symmetric, as in slope coordinates."""
    body = published.body_matrix(parameters)
    symmetric = parameters[P.COM_X] == parameters[P.COM_Y] == 0 and parameters[P.J_XX] == parameters[P.J_YY]
    symmetric = symmetric and not parameters[[P.J_XY, P.J_XZ, P.J_YZ]].any()
    spin = 0.5 * parameters[P.J_ZZ] * parameters[P.SPIN_RATE] ** 2 if symmetric else 0.0
    kinetic = [0.5 * v @ published.mass_matrix(x, body)[0] @ v for x, v in zip(records.q, records.qd, strict=True)]
    return max(max(kinetic) - spin, np.finfo(float).tiny)
