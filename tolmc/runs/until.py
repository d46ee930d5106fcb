"""Sampling that stops when an interval is narrow enough: ``until`` of a study, and how it ended."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
import pandas as pd

from tolmc import quantities
from tolmc.statistics.intervals import Estimate
from tolmc.statistics.looks import Looks, SequentialEstimate, sample_until
from tolmc.statistics.observations import Observations
from tolmc.statistics.outcomes import ANY_REQUIREMENT, failed
from tolmc.statistics.rows import Rows
from tolmc.statistics.summary import summarise_requirements
from tolmc.study.study import Study, Until

#: Samples at the first look; each look doubles them. Of the points of a Sobol' run, powers of two are spread best.
FIRST_LOOK = 1024


@dataclass(frozen=True)
class Sequential:
    """How a sequential run ended.

    Attributes
    ----------
    until : Until
        What was asked for.
    looks : Looks
        Where the run looked; each interval has the level ``looks.look_confidence``, so that all of them hold together.
    found : SequentialEstimate
        Estimate and interval at the last look, the samples it took, whether the interval is narrow enough.
    """

    until: Until
    looks: Looks
    found: SequentialEstimate

    def sentence(self) -> str:
        """How many samples the run took, and whether its interval became as narrow as asked for."""
        unit, factor = ("", 1.0) if self.until.output is None else quantities.shown(self.until.output)
        _, low, high = self.found.estimate
        confidence = f"{100 * self.looks.confidence:g} %"
        ended = "stopped" if self.found.reached else "ended without the width asked for"
        width, most = (f"{factor * value:.2g} {unit}".rstrip() for value in (high - low, self.until.width))
        return (
            f"Sampling {ended} after {self.found.count:,} of at most {self.looks.largest:,} samples: the {confidence} interval "
            f"of {self._quantity()} is {width} wide, at most {most} was asked for. Intervals hold at {confidence} whichever "
            "look the run stops at."
        )

    def _quantity(self) -> str:
        if self.until.output is None:
            return "the yield"
        names = {"mean": "the mean", "sd": "the standard deviation"}
        name = names.get(self.until.statistic) or f"the quantile {self.until.statistic[1:]} %"
        return f"{name} of {quantities.label(self.until.output)}"


def looks_of(study: Study) -> Looks:
    """Where a run of a study with ``until`` looks: from 1024 samples on, doubled each time, to ``study.samples``."""
    return Looks(min(FIRST_LOOK, study.samples), study.samples)


def sample_study(study: Study, draw: Callable[[int], pd.DataFrame]) -> Sequential:
    """Draw samples of a study until the interval that its ``until`` names is narrow enough.

    ``draw(count)`` gives the first ``count`` samples of the run.
    """
    looks = looks_of(study)

    def estimate(samples: pd.DataFrame, confidence: float) -> Estimate:
        return _estimate(study, samples, confidence)

    until = _until(study)
    return Sequential(until, looks, sample_until(draw, estimate, width=until.width, looks=looks))


def outcome(study: Study, samples: pd.DataFrame) -> Sequential:
    """How a run of a study with ``until`` ended that stopped at these ``samples``."""
    until, looks = _until(study), looks_of(study)
    found = _estimate(study, samples, looks.look_confidence)
    reached = found.high - found.low <= until.width
    return Sequential(until, looks, SequentialEstimate(found, len(samples), reached))


def _until(study: Study) -> Until:
    return cast(Until, study.until)  # nobody comes here with a study that has none


def _estimate(study: Study, samples: pd.DataFrame, confidence: float) -> Estimate:
    rows: dict[str, Any] = {
        "sampling": study.sampling,
        "confidence": confidence,
        "lot_size": study.tolerances.lot_size or 1,
    }
    until = _until(study)
    if until.statistic == "yield":
        out = summarise_requirements(
            samples, specification=study.specification, on_contact_loss=study.on_contact_loss, **rows
        ).loc[ANY_REQUIREMENT]
        return Estimate(1 - out["share_most"], 1 - out["share_most_high"], 1 - out["share_least_low"])
    seen = Observations(np.where(failed(samples), np.nan, samples[until.output].to_numpy(float)), Rows(**rows))
    if until.statistic == "mean":
        return seen.mean()
    return seen.sd() if until.statistic == "sd" else seen.quantile(until.level)
