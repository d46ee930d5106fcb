"""The first samples of a run that loses contact, once more with a wall that only pushes: what the loss leaves open.

Without restitution nobody knows what follows a loss of contact. The same samples with a wall that swallows every blow, and with
one that gives half its speed back, say what is missed.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from dataclasses import replace

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from tolmc.runs.crew import Crew
from tolmc.runs.progress import progress
from tolmc.simulation.features import has_free_body
from tolmc.simulation.plan import Plan, step_seconds
from tolmc.statistics.contact_law import RESTITUTIONS
from tolmc.study.study import Study

#: Where a run directory keeps them, one after the other by the column ``restitution``.
CONTACT_LAW = "contact_law.parquet"
# Samples at most, and as many as intervals need; whole rounds of the scramblings.
_MOST, _LEAST, _ROUND = 1024, 64, 16
# The part of the run's work that they may cost, and the seconds in any case; how much more the least number of them may.
_PART, _SECONDS, _DEARER = 0.02, 0.1, 5.0
# The steps are those of motions on the wall; what impacts make of their error is nothing beside what is looked for.
_ACCURACY = 1e-6
# What an impact costs, in steps: the rounds that find it.
_IMPACT = 8
_IMPACTS = ("impacts_D", "impacts_E")


def contact_law_subset(study: Study, plan: Plan, workforce: Crew, compute: Callable[..., pa.Table]) -> pa.Table | None:
    """Samples with each of :data:`RESTITUTIONS`, in their order; None where that says nothing, or the model knows no impacts.

    ``compute(study, plan, start, count)`` integrates samples. Their number follows from the steps and impacts of those before,
    never from a clock: the same run has the same ones.
    """
    knows = study.model_error and study.formulation == "slope" and not plan.features.one_sided
    if not knows or study.samples < _ROUND or not has_free_body(study.scene):
        return None
    following = plan.following(_ACCURACY)
    studies = [_followed(study, restitution) for restitution in RESTITUTIONS]
    integrations = 3 if plan.halving else 1
    budget = max(_PART * study.samples * plan.steps * integrations, _SECONDS / step_seconds(plan.features))
    parts: list[list[pa.Table]] = [[] for _ in studies]
    start, size, spent = 0, _ROUND, 0
    with progress(f"{study.title}: contact law") as counted:
        while size > 0:
            calls = ((followed, following, start, size) for followed in studies)
            with closing(workforce.map(compute, calls)) as computed:
                for part, table in zip(parts, counted(computed), strict=True):
                    part.append(table)
                    spent += _work(table, plan.steps)
            start += size
            affordable = int((budget - spent) * start / spent)
            needed = _LEAST - start if spent < _DEARER * budget else 0
            size = min(start, max(affordable, needed), _MOST - start, study.samples - start) // _ROUND * _ROUND
    tables = (
        pa.concat_tables(part).append_column("restitution", pa.array(np.full(start, restitution)))
        for part, restitution in zip(parts, RESTITUTIONS, strict=True)
    )
    return pa.concat_tables(list(tables)).unify_dictionaries()


def _followed(study: Study, restitution: float) -> Study:
    joint = replace(study.scene.joint, restitution=restitution)
    outputs = study.outputs and tuple(dict.fromkeys((*study.outputs, *_IMPACTS)))
    return replace(
        study, scene=replace(study.scene, joint=joint), outputs=outputs, on_contact_loss="follow", project_energy=False
    )


def _work(table: pa.Table, steps: int) -> int:
    """Steps that the motions of a table took, an impact counted as some: those held by the wall, and those after the loss."""
    impacts = sum(pc.sum(table[name]).as_py() or 0.0 for name in _IMPACTS)
    return 2 * steps * table.num_rows + int(_IMPACT * np.nan_to_num(impacts))
