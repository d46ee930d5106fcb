"""From scalars by name to the kernels' parameter array, and which samples cannot be integrated."""

from __future__ import annotations

import math
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
#: Least and largest value of scalars with which a sample can be integrated.
_ALLOWED = {
    "restitution": (0.0, 1.0), "contact_stiffness": (0.0, math.inf), "friction": (0.0, math.inf),
    "slip_speed": (math.nextafter(0.0, 1.0), math.inf), "wear_coefficient": (0.0, math.inf),
    **{scalar.name: (0.0, math.inf) for scalar in SCALAR_ROWS if scalar.kind == "frequency"},
}  # fmt: skip
_BODY_SCALARS = tuple(scalar.name for scalar in SCALAR_ROWS if scalar.group == "body")

_SCRATCH = threading.local()


def scratch(name: str, rows: int, n: int) -> np.ndarray:
    """An array (rows, n) that this thread uses again in every block: page faults of a fresh one took a tenth of the time."""
    kept = getattr(_SCRATCH, name, None)
    if kept is None or kept.size < rows * n:
        kept = np.empty(rows * n)
        setattr(_SCRATCH, name, kept)
    return kept[: rows * n].reshape(rows, n)


def pack_again(values: Mapping[str, np.ndarray | float], n: int) -> tuple[np.ndarray, np.ndarray]:
    """As :func:`pack`, into this thread's array: rows that hold the number that they held in its last block stay as they are.

    For those who write to no row of a scalar.
    """
    raw = scratch("raw", P.COUNT, n)
    place, constant = getattr(_SCRATCH, "constant", (None, {}))
    if place != (raw.ctypes.data, n):
        _SCRATCH.constant = (raw.ctypes.data, n), (constant := {})
    return _packed(values, n, raw, constant)


def pack(values: Mapping[str, np.ndarray | float], n: int) -> tuple[np.ndarray, np.ndarray]:
    """Parameter array (parameters.COUNT, n) and the code of each sample: OK, or why it cannot be integrated."""
    return _packed(values, n, np.empty((P.COUNT, n)), {})


def _packed(
    values: Mapping[str, np.ndarray | float], n: int, raw: np.ndarray, constant: dict[int, tuple[float, float]]
) -> tuple[np.ndarray, np.ndarray]:
    """:func:`pack` into ``raw``, of which the rows ``constant`` hold one number each, and its sign; kept up to date."""
    raw[P.BEARING_RADIUS], raw[P.JOURNAL_RADIUS], raw[P.HALF_LENGTH] = operating_dimensions(values)
    finite = np.ones(n, bool)
    for name, row in _ROWS.items():
        value = values[name]
        _put(value, row, raw, constant)
        if isinstance(value, np.ndarray):  # a scene's own scalars are finite
            finite &= np.isfinite(value)
    for name, (least, most) in _ALLOWED.items():
        finite &= (values[name] >= least) & (values[name] <= most)
    large, small, length = raw[P.BEARING_RADIUS], raw[P.JOURNAL_RADIUS], raw[P.HALF_LENGTH]
    joint = np.isfinite(large) & np.isfinite(small) & np.isfinite(length) & (small > 0) & (small < large) & (length > 0)
    code = np.where(joint, np.where(finite, R.OK, BODY_INVALID), GEOMETRY_INVALID)
    if any(isinstance(values[name], np.ndarray) for name in _BODY_SCALARS):
        inside = code == R.OK
        code[inside] = np.where(_is_body(raw[:, inside]), R.OK, BODY_INVALID)
    if joint.all():
        raw[P.RADIUS] = geometry.radius_of_valid(large, small, length)
    else:
        raw[P.RADIUS] = np.nan
        raw[P.RADIUS, joint] = geometry.radius_of_valid(large[joint], small[joint], length[joint])
    raw[P.HELD] = 0.0
    raw[P.LOAD_ENERGY] = _load_energy(values, raw[P.RADIUS], length)
    alpha, beta = 0.5 * values["alpha"], 0.5 * values["beta"]
    with np.errstate(invalid="ignore"):  # an infinite angle is the sample's status to tell
        _put(np.cos(alpha + beta), P.COS_MEAN, raw, constant)
        _put(np.sin(alpha + beta), P.SIN_MEAN, raw, constant)
        _put(np.cos(alpha - beta), P.COS_HALF, raw, constant)
        _put(np.sin(alpha - beta), P.SIN_HALF, raw, constant)
    return raw, code


def _put(value: np.ndarray | float, row: int, raw: np.ndarray, constant: dict[int, tuple[float, float]]) -> None:
    """A scalar into its row, unless it is one number that stands there already."""
    if isinstance(value, np.ndarray):
        constant.pop(row, None)
        raw[row] = value
    elif constant.get(row) != (there := (float(value), math.copysign(1.0, value))):
        raw[row], constant[row] = value, there


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
