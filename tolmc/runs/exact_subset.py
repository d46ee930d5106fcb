"""The first samples of a run on the circle, once more on the exact section: what the run's error budget says of the model."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from dataclasses import replace

import pyarrow as pa

from tolmc.runs.crew import Crew
from tolmc.runs.progress import progress
from tolmc.simulation.features import Features
from tolmc.simulation.plan import Plan, step_seconds
from tolmc.study.study import Study

#: Where a run directory keeps them.
EXACT_SECTION = "exact_section.parquet"
#: Samples at most, and the part of the run's motions that they may cost.
_MOST, _PART = 1024, 0.02
# What a motion costs on the exact section, over one on the circle.
_DEARER = 1.5
# What they may cost whatever the run does: a fiftieth of the shortest run's half second.
_SECONDS = 0.01
# Whole rounds of the scramblings, or groups of the jackknife.
_ROUND = 16


def subset_size(study: Study, plan: Plan) -> int:
    """Samples of a run that run on the exact section too; 0 where that says nothing new.

    It depends on the number of samples, the steps and the body alone, never on a clock: the same run has the same ones.
    """
    if not says_something_new(study):
        return 0
    if plan.features.one_sided:  # chaotic motions, and a minute's compilation of the other section for them
        return 0
    count = int(max(_PART / _DEARER * study.samples, _SECONDS / _motion_seconds(plan), _ROUND))
    return min(count, _MOST, study.samples) // _ROUND * _ROUND


def says_something_new(study: Study) -> bool:
    """Whether the exact section is another model than the study's own, and is wanted."""
    on_circle = study.scene.joint.section == "circle" and study.formulation == "slope"
    return study.model_error and study.integrates and on_circle


def on_exact_section(features: Features) -> Features:
    """What the kernels must compute for the same scene there."""
    return replace(features, exact=True, axial=False)


def exact_subset(study: Study, plan: Plan, workforce: Crew, compute: Callable[..., pa.Table]) -> pa.Table | None:
    """The samples on the exact section, in their order; None where :func:`subset_size` is 0.

    ``compute(study, plan, start, count)`` integrates samples. The step is the run's own: its error on the exact section is
    about as small, and nothing beside what is looked for.
    """
    count = subset_size(study, plan)
    if count == 0:
        return None
    joint = replace(study.scene.joint, section="exact")
    exact = replace(study, scene=replace(study.scene, joint=joint))
    plan = replace(plan, features=on_exact_section(plan.features), halving=False)
    block = _block(count, plan)
    calls = ((exact, plan, start, min(block, count - start)) for start in range(0, count, block))
    title = f"{study.title}: exact section"
    with progress(title, count) as counted, closing(workforce.map(compute, calls)) as computed:
        return pa.concat_tables(list(counted(computed))).unify_dictionaries()


def _block(count: int, plan: Plan) -> int:
    """Samples in a block: two blocks, so that two workers have one each, where the work is worth it."""
    halves = -(-count // 32) * 16
    return halves if halves * _motion_seconds(plan) > _SECONDS else count


def _motion_seconds(plan: Plan) -> float:
    """About what a motion takes on the exact section, s."""
    return _DEARER * step_seconds(plan.features) * plan.steps
