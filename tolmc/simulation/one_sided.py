"""Motions that leave the wall: the samples that do, from the parameters to the same rows of results as all others.

Where a formulation keeps contact its two-sided kernel runs first; only samples that lose contact are integrated here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from tolmc.kernels import entries
from tolmc.kernels import parameters as P
from tolmc.kernels import results as R
from tolmc.kernels.one_sided import layout as at
from tolmc.simulation.features import Features
from tolmc.simulation.plan import Plan

#: Events of one motion after which it is given up.
MOST_EVENTS = 100_000
#: Height of a bounce over the clearance below which a contact stays closed, for accuracies of 1e-7 and finer; in proportion to
#: the accuracy for others.
_REST_HEIGHT, _FINE = 1e-11, 1e-7
#: Share of the clearance by which a start within it may miss the wall.
_ROUNDING = 1e-12

_TERM_PHASES = (P.FORCE_TERM_1_PHASE, P.FORCE_TERM_2_PHASE, P.TORQUE_TERM_1_PHASE, P.TORQUE_TERM_2_PHASE)


def given(raw: np.ndarray, plan: Plan, held: np.ndarray | None = None) -> np.ndarray:
    """What the one-sided kernels take beside the parameters, (layout.GIVEN, n).

    ``held``: results of the two-sided kernels, at whose loss of contact the motions begin.
    """
    rows = np.empty((at.GIVEN, raw.shape[1]))
    rows[at.TIME], rows[at.ON_D], rows[at.ON_E] = 0.0, 0.0, 0.0
    rows[at.RESTITUTION] = raw[P.RESTITUTION] if plan.features.one_sided else -1.0
    rows[at.STIFFNESS] = raw[P.CONTACT_STIFFNESS]
    rows[at.FRICTION], rows[at.SLIP_SPEED] = raw[P.FRICTION], raw[P.SLIP_SPEED]
    rows[at.LOSS], rows[at.HELD] = -1.0, plan.features.driven
    aimed = _FINE if math.isnan(plan.pilot_error) else plan.accuracy
    rows[at.REST] = _REST_HEIGHT * max(aimed / _FINE, 1.0)
    if held is not None:
        rows[at.TIME], rows[at.ON_D], rows[at.ON_E] = held[R.END_TIME], 1.0, 1.0
        # The end whose force has just fallen to zero.
        rows[at.LOSS] = np.where(held[R.D_MIN] <= held[R.E_MIN], 0.0, 1.0)
        rows[at.CHI], rows[at.OMEGA] = raw[P.SPIN], raw[P.SPIN_RATE]
        entries.start_from(plan.features.formulation)(raw, np.ascontiguousarray(held[R.STATE :]), rows)
    elif plan.features.free:
        _start_within(raw, rows)
        rows[at.CHI], rows[at.OMEGA] = raw[P.SPIN], raw[P.SPIN_RATE]
    else:
        entries.from_angles()(raw, rows, plan.features.exact)
    if plan.features.shaken or plan.features.swings:
        _phases(raw, plan, rows)
    return rows


def _phases(raw: np.ndarray, plan: Plan, rows: np.ndarray) -> None:
    """The rows of what swings, and the part of Omega that the drive's swing has."""
    rows[at.PHASE_1 : at.PHASE_4 + 1] = raw[list(_TERM_PHASES)]
    rows[at.PHASE_DRIVE] = raw[P.DRIVE_PHASE]
    if plan.features.swings:
        swing = 2.0 * math.pi * raw[P.DRIVE_FREQUENCY] * raw[P.DRIVE_AMPLITUDE]
        rows[at.OMEGA] += swing * np.cos(raw[P.DRIVE_PHASE])
    rows[at.TURNS_1 : at.TURNS_4 + 1] = 0.0
    for place, turns in enumerate(plan.turning):
        rows[at.TURNS_1 + place] = turns


def _start_within(raw: np.ndarray, rows: np.ndarray) -> None:
    length = raw[P.HALF_LENGTH]
    for row, source in ((at.START_X, P.ORIGIN_X), (at.START_X_RATE, P.ORIGIN_RATE_X)):
        rows[row : row + 2] = raw[source : source + 2]
    for row, source in ((at.START_U, P.SLOPE_X), (at.START_U_RATE, P.SLOPE_RATE_X)):
        np.multiply(length, raw[source : source + 2], out=rows[row : row + 2])


def has_room(raw: np.ndarray, plan: Plan) -> np.ndarray:
    """Which starts within the clearance lie within it, (n,) bool."""
    gaps, rows = np.empty((2, raw.shape[1])), np.empty((at.GIVEN, raw.shape[1]))
    _start_within(raw, rows)
    entries.gaps()(np.ascontiguousarray(raw), rows, plan.features.exact, gaps)
    return np.logical_and(*(gaps >= -_ROUNDING))


def _run(raw: np.ndarray, plan: Plan, duration: float, out, counts, record, events, held=None) -> None:
    """The kernel that has what the plan's features ask for, and nothing more."""
    kernel = entries.one_sided(**kind(plan.features, plan.method))
    start = given(raw, plan, held)
    kernel(raw, start, plan.steps, duration, MOST_EVENTS, plan.accuracy, out, counts, record, events)


def kind(features: Features, method: str) -> dict[str, bool]:
    """What :func:`tolmc.kernels.entries.one_sided` is asked for."""
    swings = features.shaken or features.swings
    return {
        "exact": features.exact, "general": features.general, "rubs": features.rubs and not swings, "swings": swings,
        "rk4": method == "rk4",
    }  # fmt: skip


def integrate(raw: np.ndarray, plan: Plan, duration: float, out: np.ndarray | None = None) -> np.ndarray:
    """Results (R.RESULTS, n) of the columns of ``raw``, all of them one-sided from the start.

    A penetration beyond the plan's accuracy ends a motion.
    """
    return _results(raw, plan, duration, np.empty((R.RESULTS, raw.shape[1])) if out is None else out)


def follow(raw: np.ndarray, plan: Plan, duration: float, held: np.ndarray) -> np.ndarray:
    """Results of motions that the two-sided kernels have followed to their loss of contact, ``held``, and from there on."""
    out = _results(raw, plan, duration, np.empty((R.RESULTS, raw.shape[1])), held)
    before = held[R.END_TIME]
    touched = duration * (out[R.D_CLOSED_SHARE] + out[R.E_CLOSED_SHARE])
    for highest, share in ((R.D_MAX, R.D_CLOSED_SHARE), (R.E_MAX, R.E_CLOSED_SHARE)):
        lowest, mean, rms = range(highest + 1, highest + 4)
        closed = duration * out[share]
        square = held[rms] ** 2 * before + np.nan_to_num(out[rms]) ** 2 * closed
        out[highest] = np.fmax(held[highest], out[highest])
        # No force of a closed contact is negative: what is left below zero is the root's rounding.
        out[lowest] = np.fmin(np.maximum(held[lowest], 0.0), out[lowest])
        out[mean] += held[mean] * before / duration
        out[rms] = np.sqrt(square / (before + closed))
        out[share] += before / duration
    out[R.TILT_MAX] = np.fmax(held[R.TILT_MAX], out[R.TILT_MAX])
    out[R.LOSS_TIME] = before
    if plan.features.rubs:
        _joined(out, held, raw, duration, touched)
    for error in (R.ENERGY_ERROR, R.MOMENTUM_ERROR):
        out[error] += held[error]
    out[R.CONSTRAINT_ERROR] = np.maximum(held[R.CONSTRAINT_ERROR], out[R.CONSTRAINT_ERROR])
    out[R.STEP_ERROR] = held[R.STEP_ERROR]
    return out


def _results(
    raw: np.ndarray, plan: Plan, duration: float, out: np.ndarray, held: np.ndarray | None = None
) -> np.ndarray:
    """``out`` with the kernel's results, and what wears."""
    raw, counts = np.ascontiguousarray(raw), np.zeros(3, np.int64)
    _run(raw, plan, duration, out, counts, np.empty((at.RECORD, 0)), np.empty((at.EVENT, 0)), held)
    np.arctan(out[R.TILT_MAX], out=out[R.TILT_MAX])
    if plan.features.rubs:
        # Where a wall without restitution loses its journal the motion ends.
        lasted = duration if plan.features.one_sided else np.where(out[R.END_TIME] > 0.0, out[R.END_TIME], 1.0)
        out[R.WEAR_RATE] = raw[P.WEAR_COEFFICIENT] * (out[R.D_SLIP_WORK] + out[R.E_SLIP_WORK]) / lasted
    return out


def _joined(out: np.ndarray, held: np.ndarray, raw: np.ndarray, duration: float, touched: np.ndarray) -> None:
    """The rows of friction and drive from a motion's two parts; ``touched`` (s) is how long both ends touch in the second."""
    before = held[R.END_TIME]
    for largest in (R.FRICTION_TORQUE_MAX, R.DRIVE_TORQUE_MAX):
        out[largest] = np.fmax(held[largest], out[largest])
    for mean in (R.FRICTION_TORQUE_MEAN, R.FRICTION_POWER_MEAN, R.SLOW_SHARE, R.DRIVE_TORQUE_MEAN, R.DRIVE_POWER_MEAN):
        out[mean] += held[mean] * before / duration
    for work in (R.FRICTION_WORK, R.D_SLIP_WORK, R.E_SLIP_WORK):
        out[work] += held[work]
    turned = 2.0 * before * held[R.WHIRL_RATE_MEAN] + touched * np.nan_to_num(out[R.WHIRL_RATE_MEAN])
    touched = touched + 2.0 * before
    out[R.WHIRL_RATE_MEAN] = np.divide(turned, touched, out=np.full_like(touched, np.nan), where=touched > 0)
    out[R.WEAR_RATE] = raw[P.WEAR_COEFFICIENT] * (out[R.D_SLIP_WORK] + out[R.E_SLIP_WORK]) / duration


def never_left(results: np.ndarray) -> None:
    """The rows that impacts fill, of motions that stay on the wall."""
    results[R.D_IMPACTS : R.IMPACT_LOSS + 1] = 0.0
    results[[R.D_CLOSED_SHARE, R.E_CLOSED_SHARE]] = 1.0
    results[R.FIRST_IMPACT] = np.nan


_EVENT = np.dtype([("time", float), ("kind", "U8"), ("ends", "U2"), ("impulse", float, 2), ("speed", float, 2)])
_KINDS = ("impact", "release", "closing")


def no_events() -> np.recarray:
    """The events of a motion that stays on the wall."""
    return np.recarray(0, _EVENT)


@dataclass(frozen=True)
class Rows:
    """A motion row by row: time (n,), origin, slope, force, closed (2, n) each, energy (n,), spin_rate (n,).

    The energy is without a symmetric body's spin where that is constant.
    """

    time: np.ndarray
    origin: np.ndarray
    slope: np.ndarray
    force: np.ndarray
    closed: np.ndarray
    energy: np.ndarray
    spin_rate: np.ndarray


def flown(raw: np.ndarray, plan: Plan, duration: float) -> tuple[Rows, np.recarray]:
    """The motion of column 0 with rows at both sides of every event, and the events."""
    record, happened = _trace(raw, plan, duration)
    rows = Rows(
        time=record[at.T_TIME], origin=record[at.T_X : at.T_Y + 1], slope=record[at.T_U : at.T_V + 1],
        force=record[at.T_D : at.T_E + 1], closed=record[at.T_CLOSED_D : at.T_CLOSED_E + 1] > 0,
        energy=record[at.T_KINETIC] + record[at.T_POTENTIAL], spin_rate=record[at.T_OMEGA],
    )  # fmt: skip
    events = np.recarray(happened.shape[1], _EVENT)
    events.time = happened[at.E_TIME]
    events.kind = [_KINDS[int(kind)] for kind in happened[at.E_KIND]]
    events.ends = ["D" * bool(d) + "E" * bool(e) for d, e in zip(happened[at.E_D], happened[at.E_E], strict=True)]
    events.impulse, events.speed = (
        happened[at.E_IMPULSE_D : at.E_IMPULSE_E + 1].T,
        happened[at.E_SPEED_D : at.E_SPEED_E + 1].T,
    )
    return rows, events


def agreeing_impacts(raw: np.ndarray, plan: Plan, duration: float) -> int:
    """Impacts of the motion of column 0 before the first event that twice the steps put elsewhere or make another."""
    _, coarse = _trace(raw, plan, duration)
    _, fine = _trace(raw, replace(plan, steps=2 * plan.steps), duration)
    common = min(coarse.shape[1], fine.shape[1])
    coarse, fine = coarse[:, :common], fine[:, :common]
    kind = [at.E_KIND, at.E_D, at.E_E]
    differ = (coarse[kind] != fine[kind]).any(axis=0)
    differ |= np.abs(coarse[at.E_TIME] - fine[at.E_TIME]) > plan.accuracy * duration
    alike = int(np.argmax(differ)) if differ.any() else common
    return int((coarse[at.E_KIND, :alike] == 0).sum())


def _trace(raw: np.ndarray, plan: Plan, duration: float) -> tuple[np.ndarray, np.ndarray]:
    """Rows (layout.RECORD, rows) and events (layout.EVENT, events) of the motion of column 0."""
    raw = np.ascontiguousarray(raw[:, :1])
    rows, events = 2 * plan.steps + 64, 256
    while True:
        record, happened = np.empty((at.RECORD, rows)), np.empty((at.EVENT, events))
        counts = np.zeros(3, np.int64)
        _run(raw, plan, duration, np.empty((R.RESULTS, 1)), counts, record, happened)
        if counts[1] <= rows and counts[2] <= events:
            return record[:, : counts[1]], happened[:, : counts[2]]
        rows, events = max(rows, int(counts[1])), max(events, int(counts[2]))
