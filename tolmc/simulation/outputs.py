"""What may be asked of a motion, what a scene has of it, and where the kernels leave it."""

from __future__ import annotations

from collections.abc import Sequence

from tolmc.mechanism.checks import choice
from tolmc.simulation import results as R
from tolmc.simulation.plan import Plan

GEOMETRY_OUTPUTS = ("tilt_angle", "effective_radius", "approximate_radius")
_FORCE_ROWS = {
    "contact_force_D_max": R.D_MAX,
    "contact_force_D_min": R.D_MIN,
    "contact_force_D_mean": R.D_MEAN,
    "contact_force_D_rms": R.D_RMS,
    "contact_force_E_max": R.E_MAX,
    "contact_force_E_min": R.E_MIN,
    "contact_force_E_mean": R.E_MEAN,
    "contact_force_E_rms": R.E_RMS,
    "tilt_max": R.TILT_MAX,
    "contact_loss_time": R.LOSS_TIME,
}
_MOTION_ROWS = {"energy_error": R.ENERGY_ERROR, "constraint_error": R.CONSTRAINT_ERROR}
#: Further invariants: columns of the scenes that have them.
_INVARIANT_ROWS = {
    "momentum_error": R.MOMENTUM_ERROR,
    "spin_error": R.SPIN_ERROR,
    "energy_correction": R.ENERGY_CORRECTION,
}
#: State at the end of the motion; computed only on request.
END_OUTPUTS = ("origin_x_end", "origin_y_end", "axis_x_end", "axis_y_end", "axis_z_end")
_END_ROWS = dict(zip(END_OUTPUTS, range(R.ORIGIN_X, R.AXIS_Z + 1), strict=True))
ROWS = {**_FORCE_ROWS, **_MOTION_ROWS, **_INVARIANT_ROWS, **_END_ROWS}
#: Output columns of :func:`simulate_many` that every scene has, in their order.
OUTPUTS = (*GEOMETRY_OUTPUTS, *_FORCE_ROWS, *_MOTION_ROWS)
#: Those that a scene has where the quantity is conserved, or is projected on.
INVARIANT_OUTPUTS = tuple(_INVARIANT_ROWS)
#: The outputs that watch the integration.
CHECKS = (*_MOTION_ROWS, *INVARIANT_OUTPUTS)


def integrates(outputs: Sequence[str] | None) -> bool:
    """Whether any requested output needs a motion; geometry alone does not."""
    return outputs is None or any(name in ROWS for name in outputs)


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


def checked_outputs(outputs: Sequence[str] | None) -> tuple[str, ...] | None:
    if outputs is None:
        return None
    if isinstance(outputs, str):
        raise TypeError(f"outputs = {outputs!r} must be a sequence of names; write [{outputs!r}].")
    for name in outputs:
        choice("outputs", name, (*OUTPUTS, *INVARIANT_OUTPUTS, *END_OUTPUTS))
    return tuple(outputs)
