"""A study's samples through the simulation: the plan that all of them keep, their motions, and their statuses in words."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import numpy as np
import pandas as pd
import pyarrow as pa

from tolmc.simulation.ensemble import integrate_columns
from tolmc.simulation.features import Features, features_of
from tolmc.simulation.judge import STATUSES
from tolmc.simulation.outputs import scene_outputs, wants_pose
from tolmc.simulation.pilot import plan_integration
from tolmc.simulation.plan import Plan
from tolmc.study.study import Study, StudyError


def study_features(study: Study) -> Features:
    """What the kernels must compute for a study, known before any of them runs; StudyError where it cannot be integrated."""
    scalars = study.scene.scalars
    varied = {each.name for each in study.tolerances.dimensions if not each.lower == each.upper == scalars[each.name]}
    with _of_study(study):
        return features_of(study.scene, varied, wants_pose(study.outputs))


@contextmanager
def _of_study(study: Study) -> Iterator[None]:
    try:
        yield
    except ValueError as error:
        raise StudyError(f"{study.title}: {error}") from None


def study_plan(study: Study, worn: Mapping[str, tuple[float, float]] | None = None) -> Plan:
    """The plan of integration that holds for all samples of a study; ``worn`` are bounds in place of those on the drawing.

    Raises
    ------
    StudyError
        Where the study cannot be integrated as it says.
    """
    bounds = {dimension.name: (dimension.lower, dimension.upper) for dimension in study.tolerances.dimensions}
    with _of_study(study):
        return plan_integration(
            study.scene,
            bounds | dict(worn or {}),
            step=study.step if study.integrates else study.scene.duration,
            method=study.method,
            formulation=study.formulation,
            accuracy=study.integration_accuracy,
            outputs=study.outputs,
            on_contact_loss=study.on_contact_loss,
            project_energy=study.project_energy,
            halving=study.halving,
            samples=study.samples,
        )


def integrate_study(study: Study, plan: Plan, dimensions: pd.DataFrame, *, workers: int = 1) -> dict[str, np.ndarray]:
    """Columns of the dimensions and of what their motions give; ``status`` as places in simulation.STATUSES."""
    inputs = {name: dimensions[name].to_numpy() for name in dimensions}
    outputs = integrate_columns(
        study.scene, study.with_inertia(inputs), len(dimensions), plan=plan,
        outputs=study.outputs or scene_outputs(plan, study.project_energy), workers=workers,
        on_contact_loss=study.on_contact_loss, project_energy=study.project_energy,
    )  # fmt: skip
    return study.with_derived({**inputs, **outputs})


def status_words(codes: np.ndarray) -> pa.DictionaryArray:
    """Statuses as a dictionary of those that occur, in alphabetical order."""
    present = sorted(np.flatnonzero(np.bincount(codes)), key=STATUSES.__getitem__)
    place = np.zeros(len(STATUSES), np.int8)
    place[present] = np.arange(len(present))
    return pa.DictionaryArray.from_arrays(place[codes], [STATUSES[code] for code in present])
