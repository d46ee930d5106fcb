"""What a run says beyond its own samples: four answers side by side, and which tolerance matters.

Worst case, root sum square, Monte Carlo and the accelerated estimate of every output; Sobol' indices; one-at-a-time curves.
Together they take a few thousand motions of their own, next to nothing beside a run's samples.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd

from tolmc import quantities
from tolmc.analysis.accelerated import accelerated_summary, accelerated_yield
from tolmc.analysis.linear import linearise
from tolmc.analysis.model import study_model
from tolmc.analysis.one_at_a_time import one_at_a_time
from tolmc.analysis.side_by_side import side_by_side
from tolmc.analysis.sobol import sobol_indices
from tolmc.analysis.surrogate import Model, MotionsFailed, OutputsJump
from tolmc.analysis.tail_search import TailNotReached
from tolmc.analysis.worst_case import worst_case
from tolmc.statistics.outcomes import ALL_REQUIREMENTS, ANY_REQUIREMENT, without_value
from tolmc.study.study import Study

_INDEX_ROWS = 1024  # times the dimensions and two: intervals of a few percent


@dataclass(frozen=True)
class Answers:
    """Tables of :func:`four_answers`; None where the study leaves nothing to say.

    ``stackup``: :func:`tolmc.analysis.side_by_side.side_by_side`; ``sobol_indices`` and ``one_at_a_time``: the functions of
    that name in :mod:`tolmc.analysis`; ``yields``: by Monte Carlo and accelerated, a row a requirement; ``no_yields``: why
    there is no accelerated yield, where the study sets requirements; ``contact_lost``: share of the run's samples whose outputs
    hold up to the loss of contact only.
    """

    stackup: pd.DataFrame | None = None
    sobol_indices: pd.DataFrame | None = None
    one_at_a_time: pd.DataFrame | None = None
    yields: pd.DataFrame | None = None
    no_yields: str = ""
    contact_lost: float = 0.0

    def files(self) -> dict[str, pd.DataFrame]:
        """File name -> table, for those there are."""
        tables = {
            "stackup.csv": self.stackup,
            "sobol_indices.csv": self.sobol_indices,
            "one_at_a_time.csv": self.one_at_a_time,
            "yields.csv": self.yields,
        }
        return {name: table for name, table in tables.items() if table is not None}


def four_answers(study: Study, summary: pd.DataFrame, requirements: pd.DataFrame) -> Answers:
    """The answers for every output of ``summary`` (:func:`tolmc.statistics.summary.summarise` of the study's run).

    ``requirements`` are from :func:`tolmc.statistics.summary.summarise_requirements`.

    Correlated dimensions have no Sobol' indices. Where motions fail there is no accelerated estimate, and the table says why.
    """
    outputs = quantities.responses_among(summary.index)
    tolerances = study.tolerances
    # The paper's own coordinates are integrated one motion after the other, for comparison.
    if not outputs or not tolerances.varied or study.formulation != "slope":
        return Answers()
    model = study_model(study, outputs)
    accelerated, missing = _accelerated(model, study, outputs)
    yields, unknown = _yields(model, study, requirements)
    return Answers(
        stackup=side_by_side(
            worst_case(model, tolerances, outputs=outputs, interior=True),
            linearise(model, tolerances, outputs=outputs).root_sum_square(),
            summary.loc[outputs],
            accelerated=accelerated,
            missing=missing,
        ),
        sobol_indices=None
        if tolerances.correlation is not None
        else sobol_indices(model, tolerances, outputs=outputs, count=_INDEX_ROWS, seed=study.seed),
        one_at_a_time=one_at_a_time(model, tolerances, outputs=outputs),
        yields=yields,
        no_yields=unknown,
        contact_lost=float(summary["contact_loss"].max()) if study.on_contact_loss == "stop" else 0.0,
    )


def _accelerated(model: Model, study: Study, outputs: Sequence[str]) -> tuple[pd.DataFrame | None, str]:
    """The accelerated estimate, or why there is none."""
    try:
        return accelerated_summary(model, study.tolerances, outputs, seed=study.seed), ""
    except (MotionsFailed, OutputsJump, TailNotReached) as error:
        return None, str(error)


def _yields(model: Model, study: Study, requirements: pd.DataFrame) -> tuple[pd.DataFrame | None, str]:
    """Yield by Monte Carlo and accelerated, or why the second is not known; None without a requirement."""
    specification = study.specification
    if not specification:
        return None, ""
    for name in specification:
        if quantities.output(name).event:
            return None, f"{name} is missing where that never happens, so that no surrogate follows it"
    judged: dict[str, Any] = {"specification": specification, "on_contact_loss": study.on_contact_loss}

    def known(inputs: pd.DataFrame) -> pd.DataFrame:
        found = model(inputs)
        return found.assign(**{name: found[name].mask(without_value(found, name, **judged)) for name in specification})

    try:
        accelerated = accelerated_yield(known, study.tolerances, specification, seed=study.seed)
    except OutputsJump as error:
        return None, str(error)
    except MotionsFailed as error:
        return None, f"{error} (Motions that lose contact count as failed here.)"
    counted = requirements.rename(index={ANY_REQUIREMENT: ALL_REQUIREMENTS}).loc[accelerated.index]
    monte_carlo = {
        "monte_carlo": 1 - counted["share_most"],
        "monte_carlo_low": 1 - counted["share_most_high"],
        "monte_carlo_high": 1 - counted["share_least_low"],
    }
    names = {old: old.replace("yield", "accelerated") for old in accelerated}
    return pd.DataFrame(monte_carlo).join(accelerated.rename(columns=names)), ""
