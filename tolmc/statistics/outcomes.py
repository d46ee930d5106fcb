"""What became of each sample: failed, contact lost, out of specification, or not known.

A failed sample has no numbers, so shares count it both ways, as lying in specification and as lying out of it. A sample that
lost contact has numbers up to that instant, which do not say what the whole motion would have done: shares count it both
ways too, unless what it did until then is out for good (:func:`out_of_specification`).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd

from tolmc import quantities

CONTACT_LOST = "contact lost"
#: Of samples with valid numbers; any other status is a failure.
_VALID = ("ok", CONTACT_LOST)
#: Share of the samples that must be computed (ok, or contact lost at a known instant) for a run to stand for the parts.
ENOUGH_COMPUTED = 0.9
ANY_REQUIREMENT = "any requirement"
ALL_REQUIREMENTS = "all requirements"
CONTACT_LOSS = "contact loss"
Specification = Mapping[str, Mapping[str, float | None]]
#: Rows out of the limits and rows known to be in or out, {output: (rows,) bool} each: :func:`out_of_specification`.
Judged = tuple[dict[str, np.ndarray], dict[str, np.ndarray]]


def _is_failure(status: str) -> bool:
    return status not in _VALID


def rows_whose_status(samples: pd.DataFrame, holds) -> np.ndarray:
    """Rows whose status ``holds``; a frame without a status column has none."""
    if "status" not in samples:
        return np.zeros(len(samples), bool)
    status = pd.Categorical(samples["status"])  # free where it is one already, as in a run's file
    of_categories = np.array([holds(word) for word in status.categories], bool)
    return of_categories[status.codes] if of_categories.any() else np.zeros(len(status), bool)


def failed(samples: pd.DataFrame) -> np.ndarray:
    """(rows,) bool: samples without valid numbers (diverged, inaccurate, geometry or body invalid, singular)."""
    return rows_whose_status(samples, _is_failure)


def contact_lost(samples: pd.DataFrame) -> np.ndarray:
    """(rows,) bool: the journal left the wall; such a sample holds up to ``contact_loss_time``."""
    lost = rows_whose_status(samples, CONTACT_LOST.__eq__)
    if "contact_loss_time" in samples:
        lost |= samples["contact_loss_time"].notna().to_numpy() & ~failed(samples)
    return lost


def computed_share(statuses: pd.DataFrame) -> float:
    """Share of the samples that could be computed, from :func:`tolmc.statistics.summary.count_statuses`."""
    return float(statuses["count"].reindex(list(_VALID)).sum() / statuses["count"].sum())


def of_unknown(statuses: pd.DataFrame) -> pd.Series:
    """How many samples each status has that leaves them without numbers."""
    return statuses["count"].drop(index=list(_VALID), errors="ignore")


def without_value(
    samples: pd.DataFrame, name: str, *, specification: Specification, on_contact_loss: str = "stop"
) -> np.ndarray:
    """(rows,) bool: samples that have no value of the output for the whole motion.

    They failed, or they lost contact where that stops the statistics. A study says what to make of a loss of
    contact by ``on_contact_loss`` "continue" or "end", or by limits of ``contact_loss_time``; the values of
    such samples then count as they are.

    Raises
    ------
    ValueError
        For an unknown ``on_contact_loss``.
    """
    if _outlives_contact(name, specification, on_contact_loss):
        return failed(samples)
    return failed(samples) | contact_lost(samples)


def _outlives_contact(name: str, specification: Specification, on_contact_loss: str) -> bool:
    """Whether the output's values count as they are where contact was lost."""
    if on_contact_loss not in quantities.ON_CONTACT_LOSS:
        raise ValueError(
            f"on_contact_loss = {on_contact_loss!r} is unknown; allowed: {', '.join(quantities.ON_CONTACT_LOSS)}."
        )
    settled = quantities.output(name).settled in ("at start", "at loss")
    return settled or on_contact_loss != "stop" or "contact_loss_time" in specification


def out_of_specification(
    samples: pd.DataFrame, specification: Specification, *, on_contact_loss: str = "stop"
) -> Judged:
    """For each specified output, rows that are out of its limits and rows that are known to be in or out.

    A sample is not known :func:`without_value`, with one exception: an extreme over the motion that leaves its
    limit before contact is lost is out, whatever follows. Nor is a sample without a number; only a missing time of
    an event says something: it did not happen, and no limit is broken.

    Raises
    ------
    ValueError
        For an output that the samples lack, unknown or absent limits, minimum above maximum.
    """
    broken = failed(samples)
    ended = broken | contact_lost(samples)
    out, known = {}, {}
    for name, limits in specification.items():
        low, high = _limits(samples, name, limits)
        values = samples[name].to_numpy(float)
        unknown = broken if _outlives_contact(name, specification, on_contact_loss) else ended
        unknown = unknown & (broken | ~_stays_out(name, values, low, high))
        if not quantities.output(name).event:
            unknown |= np.isnan(values)
        out[name] = ~unknown & ((values < low) | (values > high))
        known[name] = ~unknown
    return out, known


def _stays_out(name: str, values: np.ndarray, low: float, high: float) -> np.ndarray:
    """Rows that are out of the limits however the motion goes on."""
    settled = quantities.output(name).settled
    if settled == "grows":
        return values > high
    if settled == "falls":
        return values < low
    return np.zeros(len(values), bool)


def _limits(samples: pd.DataFrame, name: str, limits: Mapping[str, float | None]) -> tuple[float, float]:
    if name not in samples:
        raise ValueError(f"specification of {name!r}: the samples have no such column; allowed: {list(samples)}.")
    given = {key: float(limit) for key, limit in limits.items() if limit is not None}
    if not given or not given.keys() <= {"min", "max"}:
        raise ValueError(f"specification of {name!r}: got {dict(limits)!r}; give 'min', 'max' or both.")
    low, high = given.get("min", -np.inf), given.get("max", np.inf)
    if not low <= high:
        raise ValueError(f"specification of {name!r}: min = {low!r} must not lie above max = {high!r}.")
    return low, high
