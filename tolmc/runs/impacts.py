"""The error of statistics of motions with impacts: the first samples once more, with twice the steps.

Impacts amplify what a step leaves, so that halved steps part company and a single motion does not tell how wrong it is.
Statistics do: with D the mean difference of an output between n and 2 n steps and s its standard error over the samples
compared, D^2 - s^2 estimates the square of the error of the mean that is no scatter.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pyarrow as pa

from tolmc import quantities
from tolmc.simulation.ensemble import integrate_columns
from tolmc.simulation.plan import Plan
from tolmc.study.study import Study

#: Samples that are integrated once more.
COMPARED = 512


def step_errors(study: Study, plan: Plan, read: Callable[..., pa.Table]) -> dict[str, float]:
    """Error of the mean of every output of the motion, in its unit, by halving the steps of the first samples."""
    first = read(rows=COMPARED).to_pandas()
    outputs = [
        row.name for row in quantities.OUTPUT_ROWS if row.group == "statistics" and row.name in first and not row.event
    ]
    if not outputs or len(first) < 2:
        return {}
    inputs = {dimension.name: first[dimension.name].to_numpy(float) for dimension in study.tolerances.dimensions}
    finer = integrate_columns(
        study.scene, study.with_inertia(inputs), len(first), plan=replace(plan, steps=2 * plan.steps),
        outputs=outputs, on_contact_loss=study.on_contact_loss,
    )  # fmt: skip
    errors = {}
    for name in outputs:
        change = finer[name] - first[name].to_numpy(float)
        change = change[np.isfinite(change)]
        if len(change) > 1:
            errors[name] = math.sqrt(max(change.mean() ** 2 - change.var(ddof=1) / len(change), 0.0))
    return errors
