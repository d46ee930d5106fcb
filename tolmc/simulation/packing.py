"""From scalars by name to the kernels' parameter array, and which samples cannot be integrated."""

from __future__ import annotations

import threading
from collections.abc import Mapping

import numpy as np

from tolmc.kernels import parameters as P
from tolmc.kernels import results as R
from tolmc.mechanism import geometry
from tolmc.mechanism.operating import operating_dimensions
from tolmc.quantities import SCALAR_ROWS
from tolmc.simulation.judge import BODY_INVALID, GEOMETRY_INVALID

#: Rows that hold a scalar as it is; the joint's hold what operating conditions make of its dimensions.
_ROWS = {scalar.name: getattr(P, scalar.row) for scalar in SCALAR_ROWS if scalar.row and scalar.group != "joint"}
_FREQUENCIES = tuple(getattr(P, scalar.row) for scalar in SCALAR_ROWS if scalar.kind == "frequency")
_BODY_SCALARS = tuple(scalar.name for scalar in SCALAR_ROWS if scalar.group == "body")

_SCRATCH = threading.local()


def scratch(name: str, rows: int, n: int) -> np.ndarray:
    """An array (rows, n) that this thread uses again in every block: page faults of a fresh one took a tenth of the time."""
    kept = getattr(_SCRATCH, name, None)
    if kept is None or kept.size < rows * n:
        kept = np.empty(rows * n)
        setattr(_SCRATCH, name, kept)
    return kept[: rows * n].reshape(rows, n)


def pack(
    values: Mapping[str, np.ndarray | float], n: int, raw: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Parameter array (parameters.COUNT, n) and the code of each sample: OK, or why it cannot be integrated."""
    raw = np.empty((P.COUNT, n)) if raw is None else raw
    raw[P.BEARING_RADIUS], raw[P.JOURNAL_RADIUS], raw[P.HALF_LENGTH] = operating_dimensions(values)
    finite = np.ones(n, bool)
    for name, row in _ROWS.items():
        raw[row] = values[name]
        if np.ndim(values[name]):  # a scene's own scalars are finite
            finite &= np.isfinite(values[name])
    large, small, length = raw[P.BEARING_RADIUS], raw[P.JOURNAL_RADIUS], raw[P.HALF_LENGTH]
    joint = np.isfinite(large) & np.isfinite(small) & np.isfinite(length) & (small > 0) & (small < large) & (length > 0)
    finite &= (raw[P.RESTITUTION] >= 0.0) & (raw[P.RESTITUTION] <= 1.0) & (raw[P.CONTACT_STIFFNESS] >= 0.0)
    finite &= (raw[P.FRICTION] >= 0.0) & (raw[P.SLIP_SPEED] > 0.0) & (raw[P.WEAR_COEFFICIENT] >= 0.0)
    for row in _FREQUENCIES:
        finite &= raw[row] >= 0.0
    code = np.where(joint, np.where(finite, R.OK, BODY_INVALID), GEOMETRY_INVALID)
    if any(np.ndim(values[name]) for name in _BODY_SCALARS):
        inside = code == R.OK
        code[inside] = np.where(_is_body(raw[:, inside]), R.OK, BODY_INVALID)
    raw[P.RADIUS] = np.nan
    if joint.any():
        inside = slice(None) if joint.all() else joint
        raw[P.RADIUS, inside] = geometry.effective_radius(large[inside], small[inside], length[inside])
    raw[P.HELD] = 0.0
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
