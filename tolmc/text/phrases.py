"""Quantities, limits, distributions and verdicts in words."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import pandas as pd

from tolmc import quantities
from tolmc.statistics.intervals import Estimate
from tolmc.statistics.outcomes import (
    ALL_REQUIREMENTS,
    ANY_REQUIREMENT,
    CONTACT_LOSS,
    ENOUGH_COMPUTED,
    computed_share,
    of_unknown,
)
from tolmc.text import plain, typeset
from tolmc.text.typeset import number
from tolmc.tolerances.dimension import Dimension
from tolmc.tolerances.distributions import Beta, Measured, Normal, Scipy, Triangular

#: Where in a dimension failures lie, by the names of :func:`tolmc.analysis.failure_sources.failure_sources`.
PLACES = {
    "high": "{share} lie in the highest quarter",
    "low": "{share} lie in the lowest quarter",
    "middle": "{share} lie in the middle half",
    "both ends": "{share} lie in the two outer quarters",
}
SAMPLINGS = {"sobol": "scrambled Sobol' points", "latin_hypercube": "Latin hypercube", "random": "random sampling"}
#: What a sample may do, by the names that :mod:`tolmc.statistics` and :mod:`tolmc.analysis` have for it.
EVENTS = {
    ANY_REQUIREMENT: "Any requirement broken",
    ALL_REQUIREMENTS: "All requirements",
    CONTACT_LOSS: "Contact lost",
    "failed": "Motion not computed",
}
STATISTICS = {
    "mean": "mean",
    "sd": "sd",
    "min": "min",
    "max": "max",
    "q0.135": "0.135 %",
    "q5": "5 %",
    "q50": "median",
    "q95": "95 %",
    "q99.865": "99.865 %",
}
MET, BROKEN, OPEN = "met", "not met", "not decided"
#: How a verdict looks.
TONES = {MET: "good", BROKEN: "bad", OPEN: "open"}

#: What the outputs of a sample that lost contact say, by the study's on_contact_loss.
AFTER_LOSS = {
    "stop": "their outputs hold up to that instant, and what follows is not known",
    "end": "their motion ends there, as the study has it",
    "continue": "they go on as if the wall could pull, as the study has it",
    "follow": "they are followed through flight and impacts",
}

#: Outputs that a sentence names.
_NAMED = 3

#: Columns of requirements in which a model has its say.
_MODEL_TERMS = ("section", "contact_law")


def unit(name: str) -> str:
    """The unit in which people read the named quantity."""
    return quantities.shown(name)[0].replace("^2", "²")


def quantity(name: str, value: float, digits: int = 6) -> str:
    """A value of the named quantity with the unit in which people read it."""
    return f"{number(value * quantities.shown(name)[1], digits)} {unit(name)}".rstrip()


def phrase(name: str) -> str:
    """The named quantity within a sentence."""
    return quantities.of(name).phrase


def event(name: str) -> str:
    """What happened to a sample: one of :data:`EVENTS`, or the named output out of its limits."""
    return EVENTS.get(name) or f"{quantities.label(name)} out"


def place(where: str, share: float, *, otherwise: str = "") -> str:
    """Where in a dimension a share of the failures lies; ``otherwise`` where they lie nowhere in particular."""
    return PLACES[where].format(share=f"{100 * share:.0f} %") if where in PLACES else otherwise


def limits(name: str, minimum: float, maximum: float) -> str:
    """The limits of a requirement, NaN where there is none."""
    ends = [f"≥ {quantity(name, minimum)}"] if not math.isnan(minimum) else []
    ends += [f"≤ {quantity(name, maximum)}"] if not math.isnan(maximum) else []
    return " and ".join(ends)


def distribution(dimension: Dimension) -> str:
    """What the dimension follows, in words."""
    if not dimension.is_varied:
        return "exact"
    follows, name = dimension.distribution, dimension.shown_name
    match follows:
        case Normal():
            mean, sd = follows.process(dimension)
            kept = ", parts outside the limits rejected" if follows.truncated else ""
            return f"normal, mean {quantity(name, mean)}, sd {quantity(name, sd, 3)}{kept}"
        case Triangular():
            mode = dimension.nominal if follows.mode is None else follows.mode
            return f"triangular, most often {quantity(name, mode)}"
        case Beta():
            return f"beta, α = {number(follows.alpha)}, β = {number(follows.beta)}"
        case Scipy():
            arguments = ", ".join(f"{key} = {value:.6g}" for key, value in follows.arguments.items())
            kept = ", parts outside the limits rejected" if follows.truncated else ""
            return f"{follows.name} of scipy.stats ({arguments}; SI units){kept}"
        case Measured():
            way = {"bootstrap": "drawn as they are", "kernel": "smoothed by a Gaussian kernel"}[follows.method]
            return f"{len(follows.values):,} measured values, {way}"
    return type(follows).__name__.lower()


def cut_short(share: float, unknown: float = 0) -> str:
    """What it means for the outputs that a share of the samples lost contact; of ``unknown`` ones nobody knows."""
    beside = f" ({unknown:,.0f} more are unknown)" if unknown else ""
    return f"In {plain.share(share)[0]} of the samples{beside} contact is lost: outputs of the motion hold up to that instant."


def computed(counted: Mapping[str, float]) -> str:
    """The samples that could be computed, from their numbers ``samples`` and ``unknown``, within a sentence."""
    known = counted["samples"] - counted["unknown"]
    return f"the {known:,.0f} samples that could be computed" if counted["unknown"] else "all samples"


def share_between(counted: Mapping[str, float]) -> tuple[str, str]:
    """The share of an event with its interval; where samples are unknown, both counted both ways."""
    least = typeset.share(*(counted[f"share_least{end}"] for end in ("", "_low", "_high")))
    if not counted["unknown"]:
        return least
    ends = dict.fromkeys(typeset.share_of(counted[key], 1.0) for key in ("share_least", "share_most"))
    bounds = (typeset.share_of(counted[key], 1.0) for key in ("share_least_low", "share_most_high"))
    return " to ".join(ends), f"{' to '.join(bounds)}, the unknown counted both ways"


def model_doubt(counted: Mapping[str, object]) -> str:
    """ "not decided: the section matters (...)" and the same of the contact law, where these may turn a verdict; else empty."""
    found = [str(counted[term]) for term in _MODEL_TERMS if counted.get(term)]
    if not found:
        return ""
    first, *others = found
    return "; ".join([first, *(other.removeprefix("not decided: ") for other in others)])


def model_turns_target(counted: Mapping[str, object]) -> bool:
    """Whether the model of the joint may turn whether the target yield is reached."""
    return any(bool(counted.get(f"{term}_turns_target", False)) for term in _MODEL_TERMS)


def too_few_computed(statuses: pd.DataFrame) -> str:
    """What stands first where too few samples could be computed for statistics of the parts; empty elsewhere."""
    if computed_share(statuses) >= ENOUGH_COMPUTED:
        return ""
    total, unknown = int(statuses["count"].sum()), of_unknown(statuses)
    known = total - int(unknown.sum())
    others = joined(f"{count:,} {status}" for status, count in unknown.items())
    if not known:
        return f"None of the {total:,} samples could be computed ({others}): nothing is known of the parts."
    return (
        f"Only {typeset.share_of(known, total)} of the samples could be computed, {known:,} of {total:,} ({others}): "
        "statistics are of the samples that could be computed, shares count the others both ways."
    )


def jumps(shares: Mapping[str, float], meaning: str) -> str:
    """Which outputs jump, by their held-out errors (:mod:`tolmc.analysis.smoothness`), and what it means; empty without any."""
    if not len(shares):
        return ""
    names = sorted(shares.keys(), key=shares.__getitem__, reverse=True)
    shown = [f"the {phrase(name)}" for name in names[:_NAMED]]
    if more := len(names) - len(shown):
        shown.append(f"{more} other output{'s' * (more > 1)}")
    least, most = (f"{100 * shares[name]:.0f}" for name in (names[-1], names[0]))
    missed = f"{least} %" if least == most else f"{least} to {most} %"
    return (
        f"a polynomial in the dimensions misses {joined(shown)} of true motions "
        f"by {missed} of the spread (held-out error), as where impacts make outputs jump. {meaning}"
    )


def spoiled_by_jumps(sampling: str) -> str:
    """What jumping outputs mean for a run."""
    refused = "Surrogates, accelerated estimates and allocation refuse such outputs"
    if sampling != "sobol":
        return f"{refused}."
    return f"{refused}, and Sobol' points gain little on random ones; the intervals, of the scatter among scramblings, hold."


def joined(parts: Iterable[str], last: str = "and") -> str:
    """``a, b and c``."""
    *first, final = [*parts] or [""]
    return f"{', '.join(first)} {last} {final}" if first else final


def requirement(name: str, bounds: Mapping[str, float]) -> str:
    """A requirement within a sentence: ``the tilt angle ψ ≤ 24.45 deg``."""
    return f"the {phrase(name)} {limits(name, bounds.get('min', math.nan), bounds.get('max', math.nan))}"


def judged(found: Estimate, target: float) -> str:
    """Whether a yield reaches the target: decided only where its whole interval lies on one side."""
    if found.low >= target:
        return MET
    return BROKEN if found.high < target else OPEN
