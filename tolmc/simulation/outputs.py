"""What may be asked of a motion, what a scene has of it, and where the kernels leave it."""

from __future__ import annotations

from collections.abc import Sequence

from tolmc import quantities
from tolmc.kernels import results as R
from tolmc.mechanism.checks import choice
from tolmc.simulation.plan import Plan

#: Row of the kernels' results that holds an output.
ROWS = {
    output.name: getattr(R, output.row) for output in quantities.OUTPUT_ROWS if output.name not in quantities.GEOMETRY
}


def integrates(outputs: Sequence[str] | None) -> bool:
    """Whether any requested output needs a motion; geometry alone does not."""
    return outputs is None or any(name in ROWS for name in outputs)


def wants_forces(outputs: Sequence[str] | None) -> bool:
    """Whether any requested output needs the contact forces along the motion."""
    return outputs is None or any(quantities.of(name).group == "statistics" for name in outputs)


def wants_pose(outputs: Sequence[str] | None) -> bool:
    """Whether any requested output needs the pose's turn about Z at the end of the motion."""
    return outputs is not None and any(quantities.of(name).group == "end" for name in outputs)


def scene_outputs(plan: Plan, project_energy: bool) -> tuple[str, ...]:
    """All outputs that a scene has, but for those on request."""
    has = _has(plan, project_energy)
    return tuple(output.name for output in quantities.OUTPUT_ROWS if has[output.when])


def present(plan: Plan, group: str) -> list[quantities.Output]:
    """The outputs of a group for which a scene's kernels have numbers; other rows of the results hold nothing."""
    has = _has(plan, project_energy=True)
    return [output for output in quantities.OUTPUT_ROWS if output.group == group and has[output.when]]


def lacking(plan: Plan) -> set[str]:
    """Statistics that a scene does not have."""
    has = _has(plan, project_energy=True)
    return {row.name for row in quantities.OUTPUT_ROWS if row.group == "statistics" and not has[row.when]}


def _has(plan: Plan, project_energy: bool) -> dict[str, bool]:
    """What ``Output.when`` may name, and whether a scene has it."""
    return {
        "": True,
        quantities.ON_REQUEST: False,
        **vars(plan.features),
        "slope": plan.formulation == "slope",
        "project_energy": project_energy,
    }


def checked_outputs(outputs: Sequence[str] | None) -> tuple[str, ...] | None:
    if outputs is None:
        return None
    if isinstance(outputs, str):
        raise TypeError(f"outputs = {outputs!r} must be a sequence of names; write [{outputs!r}].")
    for name in outputs:
        choice("outputs", name, (*quantities.OUTPUTS, *quantities.END_OUTPUTS))
    return tuple(dict.fromkeys(outputs))
