"""The full trajectory of one motion of a study."""

from __future__ import annotations

from typing import Any

from tolmc.mechanism.scene import Scene
from tolmc.simulation.pilot import plan_integration
from tolmc.simulation.trajectory import Trajectory, simulate
from tolmc.study.study import Study, StudyError

_CURVE_POINTS, _MOST_STORED = 2_000, 2_000_000


def study_motion(study: Study, scene: Scene | None = None) -> Trajectory:
    """The motion of ``scene``, the nominal one when not given, integrated as the study says.

    Raises
    ------
    StudyError
        When the scene cannot be integrated so, or its trajectory is too long to store.
    """
    scene = scene or study.scene
    settings: dict[str, Any] = {
        "method": study.method,
        "formulation": study.formulation,
        "accuracy": study.integration_accuracy,
    }
    try:
        plan = plan_integration(scene, step=study.step, **settings)
        if plan.steps > _MOST_STORED:
            raise ValueError(
                f"a trajectory of {plan.steps} steps is too long to store; allowed: {_MOST_STORED}. Take a larger step or a "
                "shorter duration."
            )
        # Steps that suffice for the statistics are too few for a smooth curve.
        step = study.step or scene.duration / max(plan.steps, _CURVE_POINTS)
        return simulate(scene, step=step, project_energy=study.project_energy, **settings)
    except ValueError as error:
        raise StudyError(f"{study.title}: {error}") from None
