"""The motions of a study as a model: inputs -> outputs, for whatever asks for motions of its own choosing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from tolmc.analysis.surrogate import Model, training_box
from tolmc.errors import InputError
from tolmc.quantities import GEOMETRY, JOINT
from tolmc.simulation.ensemble import simulate_many
from tolmc.simulation.pilot import plan_integration
from tolmc.study.study import Study


def study_model(study: Study, outputs: Sequence[str], *, box: Mapping[str, tuple[float, float]] | None = None) -> Model:
    """Function that integrates a row of dimensions each with the study's settings.

    One pilot chooses the step, for the range of the study's tolerances or the box given in its place.

    Parameters
    ----------
    outputs : names in :data:`tolmc.quantities.OUTPUTS`, or of the study's own
        What the model returns, beside ``status``; nothing else is computed.

    Raises
    ------
    InputError
        When the study cannot be integrated.
    """
    derived = [output for output in study.derived if output.name in outputs]
    own = {output.name for output in derived}
    wanted = [*outputs, *(name for output in derived for name in output.outputs)]
    outputs = [name for name in dict.fromkeys(wanted) if name not in own]
    integrates = not set(outputs) <= set(GEOMETRY)
    options: dict[str, Any] = {"on_contact_loss": study.on_contact_loss, "project_energy": study.project_energy}
    try:
        plan = plan_integration(
            study.scene, training_box(study.tolerances) if box is None else box,
            step=study.step if integrates else study.scene.duration, method=study.method,
            formulation=study.formulation, accuracy=study.integration_accuracy, outputs=outputs, **options,
        )  # fmt: skip
    except ValueError as error:
        raise InputError(f"{study.title}: {error}") from None

    def model(inputs: pd.DataFrame) -> pd.DataFrame:
        columns = study.with_inertia({name: inputs[name].to_numpy() for name in inputs})
        joint: dict[str, Any] = {name: columns.pop(name) for name in JOINT}
        found = simulate_many(
            study.scene, **joint, parameters=columns, outputs=outputs, plan=plan, workers=study.workers, **options
        )
        known = {name: found[name].to_numpy() for name in found if name != "status"}
        return found.assign(
            **{output.name: output.values({**columns, **known}, study.scene.scalars) for output in derived}
        )

    return model
