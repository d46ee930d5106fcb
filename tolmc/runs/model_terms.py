"""What a run's numbers owe to the model of the joint: some of its samples by other models, beside the statistics."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import pandas as pd
import pyarrow as pa

from tolmc import quantities
from tolmc.runs.contact_law import CONTACT_LAW, contact_law_subset
from tolmc.runs.crew import Crew
from tolmc.runs.exact_subset import EXACT_SECTION, exact_subset
from tolmc.simulation.plan import Plan
from tolmc.statistics.columns import Columns
from tolmc.statistics.contact_law import by_restitution, law_differences, law_of_requirements
from tolmc.statistics.outcomes import contact_lost
from tolmc.statistics.section_effect import section_differences, section_of_requirements
from tolmc.study.sections import TARGET_YIELD
from tolmc.study.study import Study


@dataclass(frozen=True)
class ModelTerms:
    """Samples on the exact section, and with a wall that only pushes; None where there are none."""

    exact: pa.Table | None
    followed: pa.Table | None

    @property
    def files(self) -> dict[str, pa.Table]:
        """What a run directory keeps of them."""
        tables = {EXACT_SECTION: self.exact, CONTACT_LAW: self.followed}
        return {name: table for name, table in tables.items() if table is not None}


def model_terms(
    study: Study, plan: Plan, workforce: Crew, compute: Callable[..., pa.Table], read: Callable[..., pa.Table]
) -> ModelTerms:
    """Those of a run whose samples ``read`` gives."""
    exact = exact_subset(study, plan, workforce, compute)
    samples = Columns(read)
    loses = "status" in samples and bool(contact_lost(samples).any())
    return ModelTerms(exact, contact_law_subset(study, plan, workforce, compute) if loses else None)


def with_model_terms(
    summary: pd.DataFrame,
    requirements: pd.DataFrame,
    terms: ModelTerms,
    study: Study,
    read: Callable[..., pa.Table],
    **drawn: Any,
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Both tables with what the other models say of statistics and verdicts."""
    settings: dict[str, Any] = {
        "specification": study.specification,
        "on_contact_loss": study.on_contact_loss,
        "target": TARGET_YIELD if study.target is None else study.target,
        **drawn,
    }
    outputs = quantities.outputs_among(summary.index)
    if terms.exact is not None:
        frame = terms.exact.to_pandas()
        first = read(rows=len(frame)).to_pandas()
        summary = summary.join(section_differences(first, frame, _compared(outputs, frame), **drawn))
        of_section = section_of_requirements(Columns(read), first, frame, requirements, **settings)
        summary["section"] = of_section["section"].reindex(summary.index).fillna("")
        requirements = requirements.join(of_section)
    if terms.followed is not None:
        followed = by_restitution(terms.followed.to_pandas())
        count = min(len(frame) for frame in followed.values())
        first = read(rows=count).to_pandas()
        compared = _compared(outputs, next(iter(followed.values())))
        summary = summary.join(law_differences(first, followed, compared, **drawn))
        of_law = law_of_requirements(first, followed, requirements, **settings)
        summary["contact_law"] = of_law["contact_law"].reindex(summary.index).fillna("")
        requirements = requirements.join(of_law)
    return summary, requirements


def _compared(outputs: Iterable[str], other: pd.DataFrame) -> list[str]:
    """The outputs that a model may change: those of the motion, without what watches the integration."""
    return [name for name in outputs if name in other and quantities.output(name).group == "statistics"]
