"""The first lines of a report: what was asked, and the answer in plain language."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import pandas as pd

from tolmc import quantities
from tolmc.analysis.from_samples import INTERACTIONS, contributions
from tolmc.mechanism.circle_error import section_error_estimate
from tolmc.statistics.intervals import Estimate
from tolmc.statistics.outcomes import ANY_REQUIREMENT, CONTACT_LOSS
from tolmc.study.study import Study
from tolmc.tables.dimensions import drawn_class
from tolmc.text import phrases, typeset

#: Relative error of the contact forces by the model of the section from which on the answer warns of it.
NOTEWORTHY = 0.01

# What to do where a model of the joint may turn a verdict, by what it is called there.
_REMEDIES = {"section": 'set [model] section = "exact"', "contact law": "give [contact] restitution"}


@dataclass(frozen=True)
class Answer:
    """A headline with its tone ("good", "bad", "open", "" for no judgement) and the sentences that support it."""

    tone: str
    headline: str
    sentences: tuple[str, ...]


def question(study: Study) -> str:
    """What the study asks."""
    names = [
        " ".join(filter(None, (phrases.phrase(dimension.shown_name), _in_brackets(drawn_class(dimension)))))
        for dimension in study.tolerances.varied
    ]
    varied = f"the limits of {phrases.joined(names)}" if names else "the nominal dimensions"
    if not study.specification:
        return f"What do parts made to {varied} do to tilt and contact forces?"
    kept = phrases.joined(phrases.requirement(name, limits) for name, limits in study.specification.items())
    return f"Do parts made to {varied} keep {kept}?"


def _in_brackets(text: str) -> str:
    return f"({text})" if text else ""


def answer(
    study: Study,
    *,
    shares: pd.DataFrame,
    capability: pd.DataFrame,
    indices: pd.DataFrame | None,
    failure_sources: pd.DataFrame | None,
    target: float,
    watches_contact: bool,
    warning: str = "",
) -> Answer:
    """The verdict on all requirements together, and what stands behind it.

    Parameters
    ----------
    shares : from :func:`tolmc.statistics.summary.summarise_requirements`
    capability : from :func:`tolmc.statistics.capability.capability`
        The last row is judged; empty when the study has no requirement.
    indices, failure_sources : from :func:`tolmc.analysis.from_samples.first_order`,
        :func:`tolmc.analysis.failure_sources.failure_sources`
        None when no dimension varies.
    target : float
        Yield that is asked for.
    watches_contact : bool
        Whether a loss of contact would have been seen.
    warning : str
        What goes before the verdict: that too few samples could be computed.
    """
    found = _answer(study, shares, capability, indices, failure_sources, target, watches_contact)
    return replace(found, headline=f"{warning} {found.headline}".strip())


def _answer(
    study: Study,
    shares: pd.DataFrame,
    capability: pd.DataFrame,
    indices: pd.DataFrame | None,
    failure_sources: pd.DataFrame | None,
    target: float,
    watches_contact: bool,
) -> Answer:
    sentences: list[str] = []
    if indices is not None:
        sentences += _influence(study, shares, contributions(indices).drop(columns=INTERACTIONS).dropna())
    if failure_sources is not None and study.specification:
        sentences += _origin(study, failure_sources)
    sentences += _contact(shares, watches_contact, study.on_contact_loss)
    sentences += _model_error(study)
    if capability.empty:
        return Answer("", "The study sets no requirement: see the outputs below.", tuple(sentences))
    row = capability.iloc[-1]
    found = Estimate(row["yield"], row["yield_low"], row["yield_high"])
    together = shares.loc[ANY_REQUIREMENT]
    doubt = phrases.model_doubt(together)
    if doubt and not phrases.model_turns_target(together):
        sentences.insert(0, f"As for whether most parts keep every requirement: {doubt}.")
    elif doubt:
        return Answer(
            phrases.TONES[phrases.OPEN],
            _open_by_model(doubt, found, shares, target),
            (_yield(study, found, together, target), *sentences),
        )
    verdict = phrases.judged(found, target)
    return Answer(
        phrases.TONES[verdict],
        _headline(verdict, together, shares.loc[CONTACT_LOSS], target),
        (_yield(study, found, together, target), *sentences),
    )


def _open_by_model(doubt: str, found: Estimate, shares: pd.DataFrame, target: float) -> str:
    """The headline where a model of the joint may turn the verdict, or leaves it open."""
    what = phrases.joined(what for term, what in _REMEDIES.items() if f"the {term} matters" in doubt)
    remedy = f"{what[0].upper()}{what[1:]} and run again."
    if phrases.judged(found, target) != phrases.OPEN:
        return f"{doubt[0].upper()}{doubt[1:]}. {remedy}"
    why = doubt.removeprefix("not decided: ")
    headline = _headline(phrases.OPEN, shares.loc[ANY_REQUIREMENT], shares.loc[CONTACT_LOSS], target)
    return f"{headline} {why[0].upper()}{why[1:]}. {remedy}"


def _headline(verdict: str, together: pd.Series, lost: pd.Series, target: float) -> str:
    """The verdict, never without the share of the samples that lost contact."""
    left = f"in {typeset.share_of(lost['out'], lost['samples'])} of the samples the journal leaves the wall"
    if verdict == phrases.MET:
        return f"Yes, the tolerances are good enough{f', though {left}' if lost['out'] else ''}."
    if verdict == phrases.BROKEN:
        return f"No, the tolerances are not good enough{f'; {left}' if lost['out'] else ''}."
    if not 1 - together["share_most"] < target <= 1 - together["share_least"]:
        return f"Not decided: more samples are needed{f'; {left}' if lost['out'] else ''}."
    # What is not known decides, however many samples there are.
    reasons = [f"{left}, and what follows is not known"] if together["unknown"] > lost["unknown"] else []
    if lost["unknown"]:
        reasons.append(f"{typeset.share_of(lost['unknown'], lost['samples'])} of the samples could not be computed")
    return f"Not decided: {'; '.join(reasons)}."


def _yield(study: Study, found: Estimate, together: pd.Series, target: float) -> str:
    value, interval = typeset.share(*found)
    what = "every requirement" if len(study.specification) > 1 else "the requirement"
    asked = f"(95 % interval {interval}); {100 * target:.6g} % are asked for."
    if not together["unknown"]:
        return f"{value} of the parts meet {what} {asked}"
    least, most = (typeset.share_of(row, together["samples"]) for row in _bounds(together))
    shown = least if least == most else f"At least {least} and at most {most}"
    return f"{shown} of the samples meet {what} {asked}"


def _bounds(counted: pd.Series) -> tuple[float, float]:
    """Samples known to be in, and samples not known to be out."""
    most = counted["samples"] - counted["out"]
    return most - counted["unknown"], most


def _influence(study: Study, shares: pd.DataFrame, percent: pd.DataFrame) -> Iterator[str]:
    """Which dimension matters most for the requirement that is broken most often, else for how many outputs."""
    requirements = [name for name in study.specification if name in percent.index]
    if requirements:
        worst = shares.loc[requirements, "out"].idxmax()
        first, of_variance = percent.loc[worst].idxmax(), percent.loc[worst].max()
        broken = ", the requirement broken most often" if len(requirements) > 1 and shares.loc[worst, "out"] else ""
        yield (
            f"The {phrases.phrase(first)} matters most: it makes {of_variance:.0f} % of the variance of the "
            f"{phrases.phrase(worst)}{broken}."
        )
    elif len(percent):
        counts = percent.idxmax(axis=1).value_counts()
        yield (
            f"The {phrases.phrase(counts.index[0])} matters most: it is the main source of variance of {counts.iloc[0]} of "
            f"{len(percent)} outputs."
        )


def _origin(study: Study, sources: pd.DataFrame) -> Iterator[str]:
    """Where the samples lie that break a requirement."""
    event = ANY_REQUIREMENT if len(study.specification) > 1 else next(iter(study.specification))
    strongest = sources.loc[event].iloc[0]
    if strongest["where"] in phrases.PLACES:
        place = phrases.place(strongest["where"], strongest["share"])
        yield f"Of the parts that break a requirement, {place} of the {phrases.phrase(strongest.name)}."


def _contact(shares: pd.DataFrame, is_watched: bool, on_contact_loss: str) -> Iterator[str]:
    row = shares.loc[CONTACT_LOSS]
    value, interval = phrases.share_between(row)
    if row["out"]:
        yield (
            f"In {value} of the samples ({interval}) the journal leaves the wall during the motion; "
            f"{phrases.AFTER_LOSS[on_contact_loss]}."
        )
    elif is_watched and row["unknown"] < row["samples"]:
        seen = phrases.computed(row) if row["unknown"] else "the samples"
        yield f"In none of {seen} does the journal leave the wall."
    if row["unknown"]:
        one = row["unknown"] == 1
        unknown = "1 sample" if one else f"{row['unknown']:,.0f} samples"
        yield f"{unknown} could not be computed: {'it' if one else 'they'} may meet the requirements or not."


def _model_error(study: Study) -> Iterator[str]:
    """A warning where the circle of constant radius may decide a requirement on a contact force."""
    joint = study.scene.joint_in_operation
    error = section_error_estimate(joint)["contact_force"]
    if (
        joint.section == "circle"
        and error > NOTEWORTHY
        and any(_follows_contact(quantities.output(name)) for name in study.specification)
    ):
        yield (
            f"With a clearance this large the circle of constant radius may itself misstate the contact forces by "
            f'{typeset.number(100 * error, 2)} %: confirm with section = "exact".'
        )


def _follows_contact(output: quantities.Output) -> bool:
    return output.kind == "force" or output.event
