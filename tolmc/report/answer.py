"""The first lines of a report: what was asked, and the answer in plain language."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import pandas as pd

from tolmc.intervals import Estimate
from tolmc.report import words
from tolmc.section_estimate import section_error_estimate
from tolmc.sensitivity import INTERACTIONS, contributions
from tolmc.statistics import ANY_REQUIREMENT, CONTACT_LOSS
from tolmc.study import Study

#: Relative error of the contact forces by the model of the section from which on the answer warns of it.
NOTEWORTHY = 0.01

_HEADLINES = {
    words.MET: ("good", "Yes, the tolerances are good enough."),
    words.BROKEN: ("bad", "No, the tolerances are not good enough."),
    words.OPEN: ("open", "Not decided: more samples are needed."),
}


@dataclass(frozen=True)
class Answer:
    """A headline with its tone ("good", "bad", "open", "" for no judgement) and the sentences that support it."""

    tone: str
    headline: str
    sentences: tuple[str, ...]


def question(study: Study) -> str:
    """What the study asks."""
    names = [words.phrase(dimension.name) for dimension in study.tolerances.varied]
    varied = f"the limits of {words.joined(names)}" if names else "the nominal dimensions"
    if not study.specification:
        return f"What do parts made to {varied} do to tilt and contact forces?"
    kept = words.joined(words.requirement(name, limits) for name, limits in study.specification.items())
    return f"Do parts made to {varied} keep {kept}?"


def answer(
    study: Study,
    *,
    shares: pd.DataFrame,
    capability: pd.DataFrame,
    indices: pd.DataFrame | None,
    failure_sources: pd.DataFrame | None,
    target: float,
    watches_contact: bool,
) -> Answer:
    """The verdict on all requirements together, and what stands behind it.

    Parameters
    ----------
    shares : from :func:`tolmc.statistics.summarise_requirements`
    capability : from :func:`tolmc.capability.capability`
        The last row is judged; empty when the study has no requirement.
    indices, failure_sources : from :func:`tolmc.sensitivity.first_order`, :func:`tolmc.sensitivity.failure_sources`
        None when no dimension varies.
    target : float
        Yield that is asked for.
    watches_contact : bool
        Whether a loss of contact would have been seen.
    """
    sentences = []
    if indices is not None:
        sentences += _influence(study, shares, contributions(indices).drop(columns=INTERACTIONS).dropna())
    if failure_sources is not None and study.specification:
        sentences += _origin(study, failure_sources)
    sentences += _contact(shares, watches_contact)
    sentences += _model_error(study)
    if capability.empty:
        return Answer("", "The study sets no requirement: see the outputs below.", tuple(sentences))
    row = capability.iloc[-1]
    found = Estimate(row["yield"], row["yield_low"], row["yield_high"])
    tone, headline = _HEADLINES[words.judged(found, target)]
    return Answer(tone, headline, (_yield(study, found, target), *sentences))


def _yield(study: Study, found: Estimate, target: float) -> str:
    value, interval = words.share(*found)
    what = "every requirement" if len(study.specification) > 1 else "the requirement"
    return f"{value} of the parts meet {what} (95 % interval {interval}); {100 * target:.6g} % are asked for."


def _influence(study: Study, shares: pd.DataFrame, percent: pd.DataFrame) -> Iterator[str]:
    """Which dimension matters most for the requirement that is broken most often, else for how many outputs."""
    requirements = [name for name in study.specification if name in percent.index]
    if requirements:
        worst = shares.loc[requirements, "out"].idxmax()
        first, of_variance = percent.loc[worst].idxmax(), percent.loc[worst].max()
        broken = ", the requirement broken most often" if len(requirements) > 1 and shares.loc[worst, "out"] else ""
        yield (
            f"The {words.phrase(first)} matters most: it makes {of_variance:.0f} % of the variance of the "
            f"{words.phrase(worst)}{broken}."
        )
    elif len(percent):
        counts = percent.idxmax(axis=1).value_counts()
        yield (
            f"The {words.phrase(counts.index[0])} matters most: it is the main source of variance of {counts.iloc[0]} of "
            f"{len(percent)} outputs."
        )


def _origin(study: Study, sources: pd.DataFrame) -> Iterator[str]:
    """Where the samples lie that break a requirement."""
    event = ANY_REQUIREMENT if len(study.specification) > 1 else next(iter(study.specification))
    strongest = sources.loc[event].iloc[0]
    if strongest["where"] in words.PLACES:
        place = words.PLACES[strongest["where"]].format(share=f"{100 * strongest['share']:.0f} %")
        yield f"Of the parts that break a requirement, {place} of the {words.phrase(strongest.name)}."


def _contact(shares: pd.DataFrame, is_watched: bool) -> Iterator[str]:
    row = shares.loc[CONTACT_LOSS]
    value, interval = words.share(*(row[f"share_least{end}"] for end in ("", "_low", "_high")))
    if row["out"]:
        yield (
            f"In {value} of the samples ({interval}) the journal leaves the wall during the motion; their outputs hold up to "
            "that instant."
        )
    elif is_watched:
        yield "In no sample does the journal leave the wall."
    if row["unknown"]:
        yield f"{row['unknown']:,.0f} samples could not be computed and count as out."


def _model_error(study: Study) -> Iterator[str]:
    """A warning where the circle of constant radius may decide a requirement on a contact force."""
    joint = study.scene.joint
    error = section_error_estimate(joint)["contact_force"]
    if (
        joint.section == "circle"
        and error > NOTEWORTHY
        and any(name.startswith("contact") for name in study.specification)
    ):
        yield (
            f"With a clearance this large the circle of constant radius may itself misstate the contact forces by "
            f'{words.number(100 * error, 1)} %: confirm with section = "exact".'
        )
