"""From scenes to numbers: packs parameters, chooses the step, calls the kernels. The only gate into them."""

from __future__ import annotations

import math
import threading
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from tolmc.kernels import ensemble, models, published
from tolmc.kernels import parameters as P
from tolmc.kernels.tableaux import TABLEAUX
from tolmc.mechanism import geometry
from tolmc.mechanism.checks import choice, positive_number
from tolmc.mechanism.scene import SCALARS, Scene

if TYPE_CHECKING:
    from tolmc.simulation.continuous import Sampled

FORMULATIONS = ("slope", "published", "published-regular")
METHODS = tuple(TABLEAUX)
ON_CONTACT_LOSS = {"stop": ensemble.STOP, "continue": ensemble.CONTINUE, "end": ensemble.END}

GEOMETRY_OUTPUTS = ("tilt_angle", "effective_radius", "approximate_radius")
_FORCE_ROWS = {
    "contact_force_D_max": ensemble.D_MAX,
    "contact_force_D_min": ensemble.D_MIN,
    "contact_force_D_mean": ensemble.D_MEAN,
    "contact_force_D_rms": ensemble.D_RMS,
    "contact_force_E_max": ensemble.E_MAX,
    "contact_force_E_min": ensemble.E_MIN,
    "contact_force_E_mean": ensemble.E_MEAN,
    "contact_force_E_rms": ensemble.E_RMS,
    "tilt_max": ensemble.TILT_MAX,
    "contact_loss_time": ensemble.LOSS_TIME,
}
_MOTION_ROWS = {"energy_error": ensemble.ENERGY_ERROR, "constraint_error": ensemble.CONSTRAINT_ERROR}
#: Further invariants: columns of the scenes that have them.
_INVARIANT_ROWS = {
    "momentum_error": ensemble.MOMENTUM_ERROR,
    "spin_error": ensemble.SPIN_ERROR,
    "energy_correction": ensemble.ENERGY_CORRECTION,
}
#: State at the end of the motion; computed only on request.
END_OUTPUTS = ("origin_x_end", "origin_y_end", "axis_x_end", "axis_y_end", "axis_z_end")
_END_ROWS = dict(zip(END_OUTPUTS, range(ensemble.ORIGIN_X, ensemble.AXIS_Z + 1), strict=True))
_ROWS = {**_FORCE_ROWS, **_MOTION_ROWS, **_INVARIANT_ROWS, **_END_ROWS}

#: Output columns of :func:`simulate_many` that every scene has, in their order.
OUTPUTS = (*GEOMETRY_OUTPUTS, *_FORCE_ROWS, *_MOTION_ROWS)
#: Those that a scene has where the quantity is conserved, or is projected on.
INVARIANT_OUTPUTS = tuple(_INVARIANT_ROWS)
#: The outputs that watch the integration.
CHECKS = (*_MOTION_ROWS, *INVARIANT_OUTPUTS)

#: Accuracy aimed at when nothing is said, relative to r, to 1 (axis), to the largest contact force and to the energy.
DEFAULT_ACCURACY = 1e-7
#: Energy error above which a sample counts as inaccurate when the step is given and no accuracy is stated.
COARSE_ACCURACY = 1e-4

# Codes of a sample's status; the first three are the kernels' own.
_INACCURATE, _INVALID, _BODY_INVALID, _SINGULAR_PSI, _SINGULAR_TILT, _SINGULAR_THETA = range(3, 9)
#: Every status in words, in the order of the codes.
STATUSES = (
    "ok",
    "contact lost",
    "diverged",
    "inaccurate",
    "geometry invalid",
    "body invalid",
    "singular: psi = k pi/2",
    "singular: X0 = Y0 = 0",
    "singular: theta = 0",
)
_WORDS = pd.Series(STATUSES).array
_PUBLISHED_STATUS = {
    published.SINGULAR_PSI: _SINGULAR_PSI,
    published.SINGULAR_MAXIMUM_TILT: _SINGULAR_TILT,
    published.SINGULAR_THETA: _SINGULAR_THETA,
    published.DIVERGED: ensemble.DIVERGED,
}

_CHUNK = 8192  # most samples a call of a kernel: half as many take 3 % longer, twice as many gain 1 %
_MOST_STEPS = 2_000_000
_ATTEMPTS = 5  # runs of a lane whose loss of contact only its refined extrema decide
_PATIENCE = 6  # halvings of the step without gain after which the pilot gives a motion up
_FAR_FASTER = 64  # how much faster than the middle one a motion may be for the pilot to follow it
_PILOT_SHARE = 0.3  # the pilot aims below the stated accuracy, for samples between its corners


@dataclass(frozen=True)
class Features:
    """What the kernels must compute; what is False is not compiled into them."""

    general: bool = False
    axial: bool = False
    exact: bool = False
    load: bool = True
    #: Whether the angular momentum about Z, and Omega, are conserved.
    momentum: bool = False
    spin: bool = False

    @property
    def model(self) -> tuple[int | None, int | None, int | None]:
        """general, axial, exact as the kernels' specialising arguments."""
        return 1 if self.general else None, 1 if self.axial else None, 1 if self.exact else None


@dataclass(frozen=True)
class Plan:
    """How a scene is integrated: formulation, method, number of equal steps, and the accuracy it is judged by.

    One plan serves a whole study: all its samples run through the same kernel, so that a block of samples, or one alone,
    repeats bitwise.
    """

    formulation: str
    method: str
    steps: int
    accuracy: float
    #: Largest error that step halving showed on the pilot's motions (NaN when the step was given).
    pilot_error: float = math.nan
    features: Features = Features()
    #: Whether every sample is integrated once more with twice the steps, and judged by the difference too.
    halving: bool = False
    #: Motions among the pilot's for which no number of steps met the accuracy.
    unresolved: int = 0

    def __post_init__(self) -> None:
        if isinstance(self.features, Mapping):  # as read back from a file
            object.__setattr__(self, "features", Features(**self.features))


@dataclass(frozen=True)
class Trajectory:
    """One motion, a row a step; the last row is at the scene's duration exactly.

    ``time`` (n,) s, ``origin`` (n, 2) m, ``axis`` (n, 3), ``contact_force`` (n, 2) N_D and N_E in N, ``multipliers`` (n, 2) in
    the formulation's own rows, ``tilt`` (n,) rad, ``energy`` (n,) J, ``status`` "ok" or what happened and when.
    """

    time: np.ndarray
    origin: np.ndarray
    axis: np.ndarray
    contact_force: np.ndarray
    multipliers: np.ndarray
    tilt: np.ndarray
    energy: np.ndarray
    status: str

    def to_frame(self) -> pd.DataFrame:
        """The trajectory as a table, SI units."""
        return pd.DataFrame(
            {
                "time": self.time,
                "origin_x": self.origin[:, 0],
                "origin_y": self.origin[:, 1],
                **{f"axis_{c}": self.axis[:, i] for i, c in enumerate("xyz")},
                "contact_force_D": self.contact_force[:, 0],
                "contact_force_E": self.contact_force[:, 1],
                "tilt": self.tilt,
                "energy": self.energy,
            }
        )


def step_count(duration: float, step: float) -> int:
    """Number of equal steps of at most ``step`` (s) that end at ``duration`` exactly."""
    steps = max(1, math.ceil(duration / positive_number("step", step) * (1 - 1e-12)))
    if steps > 10**9:
        raise ValueError(f"step = {step!r} s asks for {steps} steps over {duration!r} s; allowed: at most 1e9 steps.")
    return steps


def _scalars(scene: Scene, columns: Mapping[str, np.ndarray]) -> dict[str, np.ndarray | float]:
    return {**scene.scalars, **columns}


_SCRATCH = threading.local()


def _scratch(name: str, rows: int, n: int) -> np.ndarray:
    """An array (rows, n) that this thread uses again in every block: page faults of a fresh one took a tenth of the time."""
    kept = getattr(_SCRATCH, name, None)
    if kept is None or kept.size < rows * n:
        kept = np.empty(rows * n)
        setattr(_SCRATCH, name, kept)
    return kept[: rows * n].reshape(rows, n)


def _raw(
    values: Mapping[str, np.ndarray | float], n: int, raw: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Parameter array (parameters.COUNT, n) and the code of each sample: OK, or why it cannot be integrated."""
    raw = np.empty((P.COUNT, n)) if raw is None else raw
    rows = {name: row for row, name in enumerate(SCALARS[3:], start=P.MASS)}
    rows |= {
        "half_length": P.HALF_LENGTH,
        "bearing_radius": P.BEARING_RADIUS,
        "journal_radius": P.JOURNAL_RADIUS,
    }
    finite = np.ones(n, bool)
    for name, row in rows.items():
        raw[row] = values[name]
        if np.ndim(values[name]):  # a scene's own scalars are finite
            finite &= np.isfinite(values[name])
    large, small, length = raw[P.BEARING_RADIUS], raw[P.JOURNAL_RADIUS], raw[P.HALF_LENGTH]
    joint = np.isfinite(large) & np.isfinite(small) & np.isfinite(length) & (small > 0) & (small < large) & (length > 0)
    code = np.where(joint, np.where(finite, ensemble.OK, _BODY_INVALID), _INVALID)
    if any(np.ndim(values[name]) for name in _BODY_SCALARS):
        inside = code == ensemble.OK
        code[inside] = np.where(_is_body(raw[:, inside]), ensemble.OK, _BODY_INVALID)
    raw[P.RADIUS] = np.nan
    if joint.any():
        inside = slice(None) if joint.all() else joint
        raw[P.RADIUS, inside] = geometry.effective_radius(large[inside], small[inside], length[inside])
    raw[P.LOAD_ENERGY] = _load_energy(values, raw[P.RADIUS], length)
    alpha, beta = 0.5 * values["alpha"], 0.5 * values["beta"]
    with np.errstate(invalid="ignore"):  # an infinite angle is the sample's status to tell
        raw[P.COS_MEAN], raw[P.SIN_MEAN] = np.cos(alpha + beta), np.sin(alpha + beta)
        raw[P.COS_HALF], raw[P.SIN_HALF] = np.cos(alpha - beta), np.sin(alpha - beta)
    return raw, code


def _is_body(raw: np.ndarray) -> np.ndarray:
    """Which columns hold a mass and an inertia that a body can have, by the rules of mechanism.Body."""
    mass, c = raw[P.MASS], raw[P.COM_X : P.COM_Z + 1].T
    entries = [P.J_XX, P.J_XY, P.J_XZ, P.J_XY, P.J_YY, P.J_YZ, P.J_XZ, P.J_YZ, P.J_ZZ]
    inertia = raw[entries].T.reshape(-1, 3, 3)
    shift = np.einsum("ni,ni->n", c, c)[:, None, None] * np.eye(3) - c[:, :, None] * c[:, None, :]
    moments = np.linalg.eigvalsh(inertia - mass[:, None, None] * shift)
    slack = 1e-9 * np.abs(inertia).max(axis=(1, 2))
    return (mass > 0) & (moments[:, 0] >= -slack) & (moments[:, 2] <= moments[:, 0] + moments[:, 1] + slack)


def _load_energy(values: Mapping[str, np.ndarray | float], r: np.ndarray, length: np.ndarray) -> np.ndarray:
    """Size of the potential energy's variation, J: r |F_h| + r/L |G_h| + (r/L)^2 |G_z|/2 with G = sum z_i F_i."""
    weight = [values["mass"] * values[f"gravity_{axis}"] for axis in "xyz"]
    force = [values[f"force_{axis}"] for axis in "xyz"]
    arm_weight, arm_force = values["center_of_mass_z"], values["force_point_z"]
    lever = [np.abs(arm_weight * w) + np.abs(arm_force * f) for w, f in zip(weight, force, strict=True)]
    horizontal = np.abs(weight[0] + force[0]) + np.abs(weight[1] + force[1])
    slope = r / length
    return r * horizontal + slope * (lever[0] + lever[1] + 0.5 * slope * lever[2])


_BODY_SCALARS = tuple(name for name in SCALARS if name.startswith(("mass", "center_of_mass", "inertia")))
_UNSYMMETRIC = {
    "center_of_mass_x", "center_of_mass_y", "inertia_xy", "inertia_xz", "inertia_yz", "inertia_xx", "inertia_yy",
    "torque_x", "torque_y", "torque_z", "force_point_x", "force_point_y",
}  # fmt: skip


def _features(scene: Scene, varied: set[str], pose: bool) -> Features:
    """What the kernels must compute for a scene whose scalars ``varied`` vary from sample to sample.

    ``general``: the body is not symmetric, or a load turns with it or has a moment along its axis; ``axial``: all load is
    axial and nobody asks for the ``pose`` itself; ``exact``: the section is exact; ``load``: there is any load.
    """
    body, loads = scene.body, scene.loads
    names = {f"{load}_{axis}" for load in ("gravity", "force", "torque") for axis in "xyz"}
    present = {name for name in names if scene.scalars[name]} | (varied & names)
    force = any(name.startswith("force") for name in present)
    off_axis = force and loads.force_point is not None and any(loads.force_point[:2])
    torque = any(name.startswith("torque") for name in present)
    general = not body.is_symmetric or off_axis or torque or bool(varied & _UNSYMMETRIC)
    transverse = any(not name.endswith("_z") for name in present)
    exact = scene.joint.section == "exact"
    if general and not scene.scalars["inertia_zz"] > 0:
        raise ValueError(
            "Body: inertia[2, 2] = 0 kg m^2 has no spin dynamics under this body or load; allowed: > 0 unless the body is "
            "symmetric about the journal's axis and no load has a moment along it. Give the journal's own inertia."
        )
    turned = present & {"gravity_x", "gravity_y", "force_x", "force_y", "torque_z"}
    axial = not (general or transverse or pose or exact)
    symmetric = body.is_symmetric and not (varied & _UNSYMMETRIC) and not (off_axis or torque)
    return Features(general, axial, exact, bool(present), momentum=not turned, spin=symmetric)


def _integrate(
    raw, plan: Plan, forces: bool, duration: float, on_loss: int, project_energy: bool, out: np.ndarray | None = None
) -> np.ndarray:
    """Results (ensemble.RESULTS, n) of the columns of ``raw``; lanes that ask for it are run again as they ask."""
    n = raw.shape[1]
    out = np.empty((ensemble.RESULTS, n)) if out is None else out
    features, rk4 = plan.features, plan.method == "rk4"
    # The published forms' pilot must not take its steps from a formula that they don't have.
    alone = plan.formulation == "slope" and not (features.general or rk4 or forces)
    force, at, ignore = np.full(n, -1), np.zeros(n), np.full(n, -1)
    lanes: slice | np.ndarray = slice(None)
    for attempt in range(_ATTEMPTS):
        if attempt == _ATTEMPTS - 1:
            force[lanes], ignore[lanes] = -1, plan.steps
        part = out if attempt == 0 else np.empty((ensemble.RESULTS, len(lanes)))
        ensemble.integrate(
            np.ascontiguousarray(raw[:, lanes]), plan.steps, duration, on_loss, project_energy,
            force[lanes], at[lanes], ignore[lanes], part,
            *features.model, *(1 if flag else None for flag in (rk4, features.load, forces, features.momentum, alone)),
        )  # fmt: skip
        if part is not out:
            out[:, lanes] = part
        lanes = np.flatnonzero(out[ensemble.STATUS] == ensemble.RERUN)
        if not len(lanes):
            break
        force[lanes], at[lanes] = out[ensemble.RERUN_FORCE, lanes].astype(np.int64), out[ensemble.RERUN_AT, lanes]
        ignore[lanes] = np.maximum(ignore[lanes], out[ensemble.RERUN_IGNORE, lanes].astype(np.int64))
    out[ensemble.SPIN_ERROR] = 0.0  # where Omega is conserved, these equations have it as a constant
    return out


@dataclass(frozen=True)
class _Records:
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


def _published_records(parameters: np.ndarray, plan: Plan, duration: float) -> _Records:
    tableau, n = TABLEAUX[plan.method], plan.steps + 1
    q, qd, axis = np.empty((n, 5)), np.empty((n, 5)), np.empty((n, 3))
    force, multipliers, energy, work = np.empty((n, 2)), np.empty((n, 2)), np.empty(n), np.empty(n)
    q[0], qd[0] = published.start(parameters)
    regular = plan.formulation == "published-regular"
    status, rows = published.integrate(
        parameters, duration / plan.steps, tableau.matrix, tableau.b, regular,
        q, qd, axis, force, multipliers, energy, work,
    )  # fmt: skip
    return _Records(status, rows, q, qd, axis, force, multipliers, energy, work)


def _published_results(raw, plan: Plan, forces: bool, duration: float, on_loss: int) -> np.ndarray:
    """Results (ensemble.RESULTS, n) of the columns of ``raw`` in the paper's coordinates.

    One motion after the other: these formulations are for comparison. A motion that ends at a singular set has no
    statistics; its status says which set, its end time when.
    """
    out = np.full((ensemble.RESULTS, raw.shape[1]), np.nan)
    step = duration / plan.steps
    for i in range(raw.shape[1]):
        parameters = np.ascontiguousarray(raw[:, i])
        records = _published_records(parameters, plan, duration)
        status, rows = records.status, records.rows
        quantities = []
        if status == published.OK and forces:
            sampled_status, quantities = _published_quantities(parameters, plan, records, step)
            lost = [quantity.first_gap() for quantity in quantities]
            if min(lost) < plan.steps:
                status, rows = sampled_status, 1 + min(lost)
        if status != published.OK:
            out[ensemble.STATUS, i] = _PUBLISHED_STATUS[status]
            out[ensemble.END_TIME, i] = max(rows - 1, 0) * step
            continue
        drift = np.abs(records.energy - records.work - records.energy[0]).max()
        out[ensemble.ENERGY_ERROR, i] = drift / _kinetic_scale(records, parameters) if drift else 0.0
        out[ensemble.MOMENTUM_ERROR, i], out[ensemble.SPIN_ERROR, i] = _published_invariants(records, parameters)
        out[ensemble.ENERGY_CORRECTION, i] = 0.0
        d, e, r = *_ends(records, parameters), parameters[P.RADIUS]
        out[ensemble.CONSTRAINT_ERROR, i] = max(np.abs(np.hypot(*end.T) / r - 1).max() for end in (d, e))
        out[ensemble.ORIGIN_X : ensemble.ORIGIN_Y + 1, i] = records.q[-1, :2]
        out[ensemble.AXIS_X : ensemble.AXIS_Z + 1, i] = records.axis[-1]
        out[ensemble.END_TIME, i], out[ensemble.STATUS, i] = duration, ensemble.OK
        if not forces:
            continue
        tilt, *sides = quantities
        losses = [side.first_root() for side in sides]
        loss = np.nan if np.isnan(losses).all() else float(np.nanmin(losses))
        until = duration if np.isnan(loss) or on_loss == ensemble.CONTINUE else loss
        for k, side in enumerate(sides):
            mean = side.integral(until) / until if until > 0 else side.records[0]
            square = side.squared().integral(until) / until if until > 0 else side.records[0] ** 2
            # The polynomial through the squares of a coarse step may turn negative.
            rms = math.sqrt(max(square, 0.0))
            out[4 * k : 4 * k + 4, i] = side.maximum(until), -side.negative().maximum(until), mean, rms
        out[ensemble.TILT_MAX, i] = tilt.maximum(until if on_loss == ensemble.END else duration)
        out[ensemble.LOSS_TIME, i] = loss
        if not np.isnan(loss):
            out[ensemble.STATUS, i], out[ensemble.END_TIME, i] = ensemble.CONTACT_LOST, loss
    return out


def _published_invariants(records: _Records, parameters: np.ndarray) -> tuple[float, float]:
    """Relative change of the angular momentum about Z and of Omega between the start and the end of a motion."""
    body = published.body_matrix(parameters)
    momenta, spins = [], []
    for q, speeds in zip(records.q[[0, -1]], records.qd[[0, -1]], strict=True):
        mass_matrix, _ = published.mass_matrix(q, body)
        turn = np.array([-q[1], q[0], 1.0, 0.0, 0.0])
        largest = math.sqrt((turn @ mass_matrix @ turn) * (speeds @ mass_matrix @ speeds))
        momenta.append((turn @ mass_matrix @ speeds, largest))
        spins.append((speeds[4] + speeds[2] * math.cos(q[3]), np.abs(speeds[2:]).max()))
    changes = []
    for (first, scale_first), (last, scale_last) in (momenta, spins):
        change = abs(last - first)
        changes.append(change / max(scale_first, scale_last) if change else 0.0)
    return tuple(changes)


def _published_quantities(parameters, plan: Plan, records: _Records, step: float) -> tuple[int, list[Sampled]]:
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
    tilt = Sampled(_tilt(records.axis), _tilt(axis), step)
    sides = [Sampled(records.contact_force[:, k], force[:, :, k], step) for k in range(2)]
    return status, [quantity.bridged() for quantity in (tilt, *sides)]


def _tilt(axis: np.ndarray) -> np.ndarray:
    return np.arctan2(np.hypot(axis[..., 0], axis[..., 1]), axis[..., 2])


def _ends(records: _Records, parameters: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """D and E at the records, (n, 2) each."""
    offset = parameters[P.HALF_LENGTH] * records.axis[:, :2] / records.axis[:, 2:]
    return records.q[:, :2] + offset, records.q[:, :2] - offset


def _kinetic_scale(records: _Records, parameters: np.ndarray) -> float:
    """Largest kinetic energy of a motion, J; without C Omega^2/2 where the body is symmetric, as in slope coordinates."""
    body = published.body_matrix(parameters)
    symmetric = parameters[P.COM_X] == parameters[P.COM_Y] == 0 and parameters[P.J_XX] == parameters[P.J_YY]
    symmetric = symmetric and not parameters[[P.J_XY, P.J_XZ, P.J_YZ]].any()
    spin = 0.5 * parameters[P.J_ZZ] * parameters[P.SPIN_RATE] ** 2 if symmetric else 0.0
    kinetic = [0.5 * v @ published.mass_matrix(x, body)[0] @ v for x, v in zip(records.q, records.qd, strict=True)]
    return max(max(kinetic) - spin, np.finfo(float).tiny)


def _difference(coarse: np.ndarray, fine: np.ndarray, radius: np.ndarray, forces: bool) -> np.ndarray:
    """Relative difference of two results, a number a sample: end of the motion, energy, and forces if there are any."""
    end = slice(ensemble.ORIGIN_X, ensemble.ORIGIN_Y + 1)
    axis = slice(ensemble.AXIS_X, ensemble.AXIS_Z + 1)
    worst = np.maximum(
        np.abs(coarse[end] - fine[end]).max(axis=0) / radius, np.abs(coarse[axis] - fine[axis]).max(axis=0)
    )
    worst = np.maximum(worst, coarse[ensemble.ENERGY_ERROR])
    if forces:
        same = coarse[ensemble.STATUS] == fine[ensemble.STATUS]
        scale = np.maximum(fine[ensemble.D_MAX], fine[ensemble.E_MAX])
        # Where one of the two loses contact and the other just not, their statistics do not measure the integration.
        tilt = np.abs(coarse[ensemble.TILT_MAX] - fine[ensemble.TILT_MAX])
        worst = np.maximum(worst, np.where(same, tilt, 0.0))
        force = np.abs(coarse[: ensemble.E_RMS + 1] - fine[: ensemble.E_RMS + 1]).max(axis=0)
        force = np.divide(force, scale, out=np.zeros_like(force), where=scale > 0)
        worst = np.where(same, np.maximum(worst, force), worst)
    return np.where(np.isfinite(worst), worst, np.inf)


def _first_guess(raw: np.ndarray, duration: float) -> np.ndarray:
    """Steps for half a radian of the fastest of a motion's rates: polar rates, pendulum and gyroscopic frequency; (n,)."""
    r, mass = raw[P.RADIUS], raw[P.MASS]
    load = sum(
        np.abs(mass * raw[P.GRAVITY_X + i] + raw[P.FORCE_X + i]) + np.abs(raw[P.TORQUE_X + i]) / raw[P.HALF_LENGTH]
        for i in range(3)
    )
    transverse = np.minimum(raw[P.J_XX], raw[P.J_YY]) + 1e-3 * mass * raw[P.HALF_LENGTH] ** 2
    rate = np.maximum(np.abs(raw[P.ALPHA_RATE]), np.abs(raw[P.BETA_RATE])) + np.sqrt(load / (mass * r))
    rate = rate + np.abs(raw[P.J_ZZ] * raw[P.SPIN_RATE]) / transverse
    steps = np.where(np.isfinite(rate), 0.5 * rate * duration, 0.0)
    return np.ceil(np.clip(steps, 4.0, _MOST_STEPS // 4))


def _pilot(raw, draft: Plan, forces, duration, on_loss, project_energy) -> Plan:
    """``draft`` with the fewest steps with which every column of ``raw`` meets its accuracy by step halving.

    A column whose error falls no further however short the step, or whose motion is far faster than the others' (a clearance
    of a few roundings, say), is set aside and counted as unresolved.
    """
    target = _PILOT_SHARE * draft.accuracy
    order = TABLEAUX[draft.method].order

    def results(steps):
        return _integrate(raw, replace(draft, steps=steps), forces, duration, on_loss, project_energy)

    guesses = _first_guess(raw, duration)
    fast = guesses > _FAR_FASTER * np.median(guesses)
    if fast.any():
        rest = np.ascontiguousarray(raw[:, ~fast])
        plan = _pilot(rest, draft, forces, duration, on_loss, project_energy)
        return replace(plan, unresolved=plan.unresolved + int(fast.sum()))
    steps = int(guesses.max())
    coarse = results(steps)
    stalled, previous = np.zeros(raw.shape[1], int), np.full(raw.shape[1], np.inf)
    while True:
        fine = results(2 * steps)
        errors = _difference(coarse, fine, raw[P.RADIUS], forces)
        error = float(errors.max())
        if error <= target:
            return replace(draft, steps=steps, pilot_error=error)
        stalled = np.where((errors <= target) | (errors < 0.5 * previous), 0, stalled + 1)
        hopeless = errors > target if 2 * steps >= _MOST_STEPS else stalled > _PATIENCE
        if hopeless.all():
            return replace(draft, steps=steps, pilot_error=error, unresolved=len(hopeless))
        if hopeless.any():
            rest = np.ascontiguousarray(raw[:, ~hopeless])
            plan = _pilot(rest, draft, forces, duration, on_loss, project_energy)
            return replace(plan, unresolved=plan.unresolved + int(hopeless.sum()))
        previous = errors
        if error < 1e-2:
            # Within the range where the order holds, go straight to the number of steps that it asks for.
            wanted = math.ceil(1.05 * steps * (error / target) ** (1 / order))
            if wanted < 2 * steps:
                steps = max(wanted, steps + 1)
                coarse = results(steps)
                continue
        steps, coarse = 2 * steps, fine


def _corners(scene: Scene, bounds: Mapping[str, tuple[float, float]]) -> dict[str, np.ndarray]:
    """The nominal sample and the corners of the box (of its first six sides; the others at both ends one at a time)."""
    sides = [name for name, (low, high) in bounds.items() if low != high]
    nominal = {name: scene.scalars[name] if name in sides else low for name, (low, _) in bounds.items()}
    points = [nominal]
    points += [nominal | dict(zip(sides[:6], c, strict=True)) for c in product(*(bounds[s] for s in sides[:6]))]
    points += [nominal | {side: end} for side in sides[6:] for end in bounds[side]]
    return {name: np.array([p[name] for p in points]) for name in bounds}


def plan_integration(
    scene: Scene,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    *,
    step: float | None = None,
    method: str = "rk8",
    formulation: str = "slope",
    accuracy: float | None = None,
    outputs: Sequence[str] | None = None,
    on_contact_loss: str = "stop",
    project_energy: bool = False,
    halving: bool = False,
) -> Plan:
    """Choose step and method for a scene whose scalars vary within ``bounds``.

    With ``step=None`` a pilot integrates the nominal and the corner dimensions with n and 2 n steps and takes the least n
    for which the reported quantities (end of the motion, statistics of the contact forces if they are asked for, energy)
    agree to ``accuracy``; ``method="auto"`` takes the method with the fewest evaluations. Where some of these motions meet it
    with no step at all, their number is ``unresolved`` and every sample is judged by step halving.

    Parameters
    ----------
    bounds : mapping from names in mechanism.SCALARS to (low, high), SI units
    step : float, s, or None
    accuracy : float
        Relative to r, to the largest contact force and to the energy. Default 1e-7 (with a given step: 1e-4, only judged).

    Raises
    ------
    ValueError
        Unknown names, or values out of range.
    """
    choice("formulation", formulation, FORMULATIONS)
    choice("method", method, (*METHODS, "auto"))
    choice("on_contact_loss", on_contact_loss, tuple(ON_CONTACT_LOSS))
    if formulation != "slope" and scene.joint.section == "exact":
        raise ValueError(f"formulation = {formulation!r} knows the circle only; with section = 'exact' use 'slope'.")
    if formulation != "slope" and (project_energy or halving):
        raise ValueError(f"project_energy and halving need formulation = 'slope', got {formulation!r}.")
    forces = wants_forces(outputs)
    if accuracy is not None:
        accuracy = positive_number("accuracy", accuracy)
    bounds = dict(bounds or {})
    for name in bounds:
        choice("bounds", name, SCALARS)
    varied = {name for name, (low, high) in bounds.items() if not low == high == scene.scalars[name]}
    features = _features(scene, varied, wants_pose(outputs))
    chosen = "rk8" if method == "auto" else method
    if step is not None:
        steps = step_count(scene.duration, step)
        return Plan(formulation, chosen, steps, accuracy or COARSE_ACCURACY, features=features, halving=halving)
    accuracy = accuracy or DEFAULT_ACCURACY
    columns = _corners(scene, bounds)
    raw, code = _raw(_scalars(scene, columns), max((len(c) for c in columns.values()), default=1))
    if not (code == ensemble.OK).any():
        return Plan(formulation, chosen, 1, accuracy, features=features)
    raw = np.ascontiguousarray(raw[:, code == ensemble.OK])
    loss = ON_CONTACT_LOSS[on_contact_loss]
    with np.errstate(all="ignore"):
        plans = [
            _pilot(
                raw,
                Plan(formulation, name, 1, accuracy, features=features),
                forces,
                scene.duration,
                loss,
                project_energy,
            )
            for name in (METHODS if method == "auto" else (method,))
        ]
    best = min(plans, key=lambda plan: plan.steps * TABLEAUX[plan.method].stages)
    halving = halving or (best.unresolved > 0 and formulation == "slope")
    return replace(best, halving=halving)


def wants_forces(outputs: Sequence[str] | None) -> bool:
    """Whether any requested output needs the contact forces along the motion."""
    return outputs is None or any(name in _FORCE_ROWS for name in outputs)


def wants_pose(outputs: Sequence[str] | None) -> bool:
    """Whether any requested output needs the pose's turn about Z at the end of the motion."""
    return outputs is not None and any(name in _END_ROWS for name in outputs)


def scene_outputs(plan: Plan, project_energy: bool) -> tuple[str, ...]:
    """All outputs that a scene has: :data:`OUTPUTS` and the further invariants that exist."""
    present = {
        "momentum_error": plan.features.momentum,
        "spin_error": plan.features.spin,
        "energy_correction": project_energy,
    }
    return (*OUTPUTS, *(name for name in INVARIANT_OUTPUTS if present[name]))


def _checked_outputs(outputs: Sequence[str] | None) -> tuple[str, ...] | None:
    if outputs is None:
        return None
    if isinstance(outputs, str):
        raise TypeError(f"outputs = {outputs!r} must be a sequence of names; write [{outputs!r}].")
    for name in outputs:
        choice("outputs", name, (*OUTPUTS, *INVARIANT_OUTPUTS, *END_OUTPUTS))
    return tuple(outputs)


def _valid_tilt(raw, valid):
    tilt = np.full(raw.shape[1], np.nan)
    if valid.any():
        tilt[valid] = geometry.tilt_angle(*raw[[P.BEARING_RADIUS, P.JOURNAL_RADIUS, P.HALF_LENGTH]][:, valid])
    return tilt


def _block_results(scene, values, n, outputs, plan, on_loss, project_energy) -> dict[str, np.ndarray]:
    """Columns of the outputs, status_time and status (its code) of ``n`` samples; valid until this thread's next block.

    Absurd numbers run through: what they make of a motion is seen in its status, not in warnings.
    """
    with np.errstate(all="ignore"):
        return _results_of_block(scene, values, n, outputs, plan, on_loss, project_energy)


def _results_of_block(scene, values, n, outputs, plan, on_loss, project_energy) -> dict[str, np.ndarray]:
    raw, code = _raw(values, n, _scratch("raw", P.COUNT, n))
    valid, joint = code == ensemble.OK, code != _INVALID
    columns: dict[str, np.ndarray] = {}
    geometric = {
        "effective_radius": lambda: raw[P.RADIUS],
        "tilt_angle": lambda: _valid_tilt(raw, joint),
        "approximate_radius": lambda: np.where(joint, raw[P.BEARING_RADIUS] - raw[P.JOURNAL_RADIUS], np.nan),
    }
    status_time = np.full(n, np.nan)
    results = None
    if any(name in _ROWS for name in outputs) and valid.any():
        everything = valid.all()
        inside = raw if everything else np.ascontiguousarray(raw[:, valid])
        forces = wants_forces(outputs)
        if plan.formulation == "slope":
            out = _scratch("results", ensemble.RESULTS, inside.shape[1])
            part = _integrate(inside, plan, forces, scene.duration, on_loss, project_energy, out)
            if plan.halving:
                finer = replace(plan, steps=2 * plan.steps)
                fine = _integrate(inside, finer, forces, scene.duration, on_loss, project_energy)
                part[ensemble.HALVING_ERROR] = _difference(part, fine, inside[P.RADIUS], forces)
        else:
            part = _published_results(inside, plan, forces, scene.duration, on_loss)
        results = part
        if not everything:
            results = np.full((ensemble.RESULTS, n), np.nan)
            results[:, valid] = part
        code[slice(None) if everything else valid] = part[ensemble.STATUS]
        status_time = np.where(code != ensemble.OK, results[ensemble.END_TIME], np.nan)
        code = _judged(code, results, raw, plan, forces)
    for name in outputs:
        if name in geometric:
            columns[name] = geometric[name]()
        else:
            columns[name] = np.full(n, np.nan) if results is None else results[_ROWS[name]]
    columns["status_time"] = status_time
    columns["status"] = code
    return columns


def _judged(code: np.ndarray, results: np.ndarray, raw: np.ndarray, plan: Plan, forces: bool) -> np.ndarray:
    """Codes of integrated samples whose numbers have been looked at; those that have no statistics lose them.

    Diverged: a number that is not finite. Inaccurate: an invariant or the step-halving difference above the accuracy, or
    statistics that contradict each other or the joint by more than it.
    """
    code = code.copy()
    features = plan.features
    checks = [ensemble.ENERGY_ERROR, ensemble.CONSTRAINT_ERROR, ensemble.ENERGY_CORRECTION]
    checks += [ensemble.MOMENTUM_ERROR] if features.momentum else []
    checks += [ensemble.SPIN_ERROR] if features.spin else []
    checks += [ensemble.HALVING_ERROR] if plan.halving else []
    worst = np.maximum.reduce([results[row] for row in checks])
    finite = np.isfinite(worst)
    if forces:
        finite &= np.isfinite(results[: ensemble.TILT_MAX + 1]).all(axis=0)
        worst = np.maximum(worst, _contradiction(results, raw))
    good = finite & (worst <= plan.accuracy)
    if not good.all():
        whole = code <= ensemble.CONTACT_LOST
        code[whole & ~finite] = ensemble.DIVERGED
        code[whole & finite & ~good] = _INACCURATE
    # A motion that has left the numbers' range or the coordinates' domain has no statistics.
    without = (code == ensemble.DIVERGED) | (code >= _SINGULAR_PSI)
    if without.any():
        results[: ensemble.LOSS_TIME + 1, without] = np.nan
    return code


def _contradiction(results: np.ndarray, raw: np.ndarray) -> np.ndarray:
    """By how much min <= mean <= max, |mean| <= rms <= max |N| and tilt_max <= tilt_angle are missed, relative."""
    miss = results[ensemble.TILT_MAX] - np.arctan2(raw[P.RADIUS], raw[P.HALF_LENGTH])
    for first in (ensemble.D_MAX, ensemble.E_MAX):
        highest, lowest, mean, rms = results[first : first + 4]
        largest = np.maximum(np.abs(highest), np.abs(lowest))
        force = np.maximum.reduce([mean - highest, lowest - mean, np.abs(mean) - rms, rms - largest])
        miss = np.maximum(miss, np.divide(force, largest, out=np.zeros_like(force), where=largest > 0))
    return miss


def _sample_columns(scene: Scene, columns: Mapping[str, object]) -> tuple[dict[str, np.ndarray], int]:
    arrays = {}
    for name, column in columns.items():
        choice("parameters", name, SCALARS)
        try:
            arrays[name] = np.asarray(column, float)
        except (TypeError, ValueError):
            raise TypeError(f"simulate_many: {name} must be an array of numbers in SI units, got {column!r}.") from None
    try:
        shape = np.broadcast_shapes(*(a.shape for a in arrays.values()))
    except ValueError:
        shapes = ", ".join(f"{name} {a.shape}" for name, a in arrays.items())
        raise ValueError(f"simulate_many: columns have different lengths: {shapes}; give one value a sample.") from None
    if len(shape) > 1:
        raise ValueError(f"simulate_many: columns must be one-dimensional, got shape {shape}.")
    n = shape[0] if shape else 1
    return {name: np.array(np.broadcast_to(a, (n,))) for name, a in arrays.items()}, n


def simulate_many(
    scene: Scene,
    *,
    bearing_radius,
    journal_radius,
    half_length,
    parameters: Mapping[str, object] | None = None,
    step: float | None = None,
    method: str = "rk8",
    formulation: str = "slope",
    outputs: Sequence[str] | None = None,
    workers: int = 1,
    accuracy: float | None = None,
    on_contact_loss: str = "stop",
    project_energy: bool = False,
    halving: bool = False,
    plan: Plan | None = None,
) -> pd.DataFrame:
    """Integrate one motion a sample and return its statistics, a row a sample in the order given.

    The start angles of the scene are kept when the dimensions vary, so every sample starts on its own circles.

    Parameters
    ----------
    bearing_radius, journal_radius, half_length : (n,) array_like, m
    parameters : mapping from further names in mechanism.SCALARS to (n,) array_like, SI units
    step : float, s
        Fixed step; None: chosen by a pilot on the nominal and the corner dimensions (:func:`plan_integration`).
    method : {"rk8", "rk4", "auto"}
        A symmetric body whose contact forces nobody asks for has a formula of order 8 that takes fewer steps.
    formulation : {"slope", "published", "published-regular"}
    outputs : names in :data:`OUTPUTS`, :data:`INVARIANT_OUTPUTS` or :data:`END_OUTPUTS`
        None: all that the scene has (:func:`scene_outputs`). What is not asked for is not computed; geometry alone
        integrates nothing.
    workers : int
        Threads; the results do not depend on it.
    accuracy : float
        A sample whose invariants (energy, constraints; angular momentum about Z and Omega where they are conserved) are
        missed by more, or whose statistics contradict each other by more, has status "inaccurate".
    on_contact_loss : {"stop", "continue", "end"}
        From the first instant at which a contact force turns negative: the force statistics stop there, go on two-sided
        (the paper's model), or the whole sample ends there.
    project_energy : bool
        Also project every step on the energy; ``energy_correction`` is what that took out in all, and is judged as an error.
    halving : bool
        Integrate every sample once more with twice the steps, at three times the cost; one whose end of motion, tilt or
        force statistics differ by more than ``accuracy`` is "inaccurate". Finds chaotic motions, whose invariants look well.
    plan : Plan
        Overrides step, method, formulation and accuracy (used by the Monte Carlo driver, which plans once).

    Returns
    -------
    pandas.DataFrame
        The inputs, the outputs (m, rad, N, s), ``status_time`` (s; NaN when ok) and ``status``: "ok", "contact lost",
        "diverged", "inaccurate", "geometry invalid", "body invalid", "singular: ..." (published formulations only).

    Raises
    ------
    ValueError, TypeError
        Before any work starts: unknown names, columns of different lengths, values out of range. A sample that cannot be
        integrated raises nothing: it has a status.
    """
    inputs = {"bearing_radius": bearing_radius, "journal_radius": journal_radius, "half_length": half_length}
    inputs, n = _sample_columns(scene, {**inputs, **(parameters or {})})
    names = _checked_outputs(outputs)
    if isinstance(workers, bool) or not isinstance(workers, (int, np.integer)) or workers < 1:
        raise ValueError(f"workers = {workers!r} is out of range; allowed: a whole number >= 1.")
    if plan is None:
        integrated = names is None or any(name in _ROWS for name in names)
        finite = {name: column[np.isfinite(column)] for name, column in inputs.items()}
        bounds = {name: (float(c.min()), float(c.max())) for name, c in finite.items() if len(c)}
        plan = plan_integration(
            scene, bounds, step=step if integrated else scene.duration, method=method, formulation=formulation,
            accuracy=accuracy, outputs=names, on_contact_loss=on_contact_loss, project_energy=project_energy,
            halving=halving,
        )  # fmt: skip
    columns = integrate_columns(
        scene, inputs, n, plan=plan, outputs=names or scene_outputs(plan, project_energy), workers=int(workers),
        on_contact_loss=on_contact_loss, project_energy=project_energy,
    )  # fmt: skip
    columns["status"] = _WORDS.take(columns["status"])  # pandas would look at every word of an object column
    return pd.DataFrame({**inputs, **columns}, copy=False)


def integrate_columns(
    scene: Scene,
    inputs: Mapping[str, np.ndarray],
    n: int,
    *,
    plan: Plan,
    outputs: Sequence[str],
    workers: int = 1,
    on_contact_loss: str = "stop",
    project_energy: bool = False,
) -> dict[str, np.ndarray]:
    """What :func:`simulate_many` does once everything is decided: ``n`` samples as bare columns.

    Parameters
    ----------
    inputs : mapping from names in mechanism.SCALARS to (n,) float arrays, SI units

    Returns
    -------
    dict
        The outputs, ``status_time``, and ``status`` as places in :data:`STATUSES`, (n,) each.
    """
    on_loss = ON_CONTACT_LOSS[choice("on_contact_loss", on_contact_loss, tuple(ON_CONTACT_LOSS))]

    size = min(_CHUNK, -(-n // (workers * ensemble.WIDTH)) * ensemble.WIDTH)
    columns = {name: np.empty(n) for name in (*outputs, "status_time")}
    columns["status"] = np.empty(n, np.int64)

    def chunk(first: int) -> None:
        part = {name: column[first : first + size] for name, column in inputs.items()}
        count = min(size, n - first)
        results = _block_results(scene, _scalars(scene, part), count, outputs, plan, on_loss, project_energy)
        for name, column in columns.items():
            column[first : first + count] = results[name]

    starts = range(0, n, max(size, 1))
    if workers == 1 or len(starts) <= 1:
        for first in starts:
            chunk(first)
    else:
        with ThreadPoolExecutor(workers) as threads:
            list(threads.map(chunk, starts))
    return columns


def simulate(
    scene: Scene,
    *,
    step: float | None = None,
    method: str = "rk8",
    formulation: str = "slope",
    accuracy: float | None = None,
    project_energy: bool = False,
) -> Trajectory:
    """Integrate one motion and return it step by step.

    Parameters as in :func:`simulate_many`. The model is two-sided: the motion goes on after a contact force has turned
    negative, and the status says when that happened first.
    """
    plan = plan_integration(
        scene, step=step, method=method, formulation=formulation, accuracy=accuracy, outputs=(*OUTPUTS, *END_OUTPUTS),
        on_contact_loss="continue", project_energy=project_energy,
    )  # fmt: skip
    raw, _ = _raw(scene.scalars, 1)
    time = np.linspace(0.0, scene.duration, plan.steps + 1)
    outputs = scene_outputs(plan, project_energy)
    summary = _block_results(scene, scene.scalars, 1, outputs, plan, ensemble.CONTINUE, project_energy)
    status = _sentence(summary, plan)
    if plan.formulation != "slope":
        records = _published_records(np.ascontiguousarray(raw[:, 0]), plan, scene.duration)
        rows = max(records.rows, 1)
        if summary["status"][0] >= _SINGULAR_PSI:
            rows = min(rows, 1 + round(summary["status_time"][0] / scene.duration * plan.steps))
        return Trajectory(
            time=time[:rows],
            origin=records.q[:rows, :2],
            axis=records.axis[:rows],
            contact_force=records.contact_force[:rows],
            multipliers=records.multipliers[:rows],
            tilt=_tilt(records.axis[:rows]),
            energy=records.energy[:rows],
            status=status,
        )
    with np.errstate(all="ignore"):
        return _traced(scene, raw, plan, project_energy, time, status)


def _traced(scene: Scene, raw, plan: Plan, project_energy: bool, time: np.ndarray, status: str) -> Trajectory:
    model, load = plan.features.model, 1 if plan.features.load else None
    n_state, n_coef = models.sizes.py_func(*model)
    states = np.empty((plan.steps + 1, n_state))
    coef = np.empty(n_coef * ensemble.WIDTH)
    rk4 = 1 if plan.method == "rk4" else None
    # The forces are not looked at here; with them the step is the one that the statistics have compiled.
    ensemble.trace(raw, plan.steps, scene.duration, project_energy, states, coef, *model, rk4, load, 1)
    seen = np.empty((11, plan.steps + 1))
    ensemble.observe(states, coef, seen, *model, load)
    x, y, u, v, n_d, n_e, lambda_d, lambda_e, kinetic, potential, w2 = seen
    length = scene.joint.half_length
    norm = np.sqrt(length * length + w2)
    symmetric = not plan.features.general
    spin_energy = 0.5 * scene.body.inertia[2, 2] * scene.motion.spin_rate**2 if symmetric else 0.0
    return Trajectory(
        time=time,
        origin=np.stack((x, y), axis=1),
        axis=np.stack((u / norm, v / norm, length / norm), axis=1),
        contact_force=np.stack((n_d, n_e), axis=1),
        multipliers=np.stack((lambda_d, lambda_e), axis=1),
        tilt=np.arctan(np.sqrt(np.maximum(w2, 0.0)) / length),
        energy=kinetic + potential + spin_energy,
        status=status,
    )


def _sentence(summary: Mapping[str, np.ndarray], plan: Plan) -> str:
    """Status of one motion in words, with the time where there is one."""
    status, at = STATUSES[summary["status"][0]], summary["status_time"][0]
    if status == "inaccurate":
        name = max((name for name in CHECKS if name in summary), key=lambda name: summary[name][0])
        if summary[name][0] > plan.accuracy:
            return f"inaccurate: {name.replace('_', ' ')} {summary[name][0]:.1e} above {plan.accuracy:.1e}"
        return f"inaccurate: a shorter step changes the results by more than {plan.accuracy:.1e}, or they contradict each other"
    if status == "ok" or math.isnan(at):
        return status
    if status.startswith("singular: "):
        return f"singular at t = {at:.9g} s: {status.removeprefix('singular: ')}"
    return f"{status} at t = {at:.9g} s"
