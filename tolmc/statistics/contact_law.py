"""What a loss of contact leaves open, from samples that were followed through flight and impacts too.

Part of the model's term of a run's error budget. A run without restitution ends a sample at the loss, or lets the wall pull;
with a restitution of 0 and of 0.5 the same samples go on as a wall that only pushes has it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import pandas as pd

from tolmc.statistics.intervals import Estimate
from tolmc.statistics.outcomes import CONTACT_LOSS, Specification
from tolmc.statistics.rows import Rows
from tolmc.statistics.section_effect import MOST, events, paired_differences, percent, share_difference, turns
from tolmc.statistics.summary import as_columns, summarise_requirements

#: A wall that swallows every blow, and one that gives half its speed back.
RESTITUTIONS = (0.0, 0.5)
_MATTERS = "not decided: the contact law matters"
_ENDS = {"stop": "ends at the loss", "end": "ends at the loss", "continue": "held by the wall"}


def prefix(restitution: float) -> str:
    """What the columns of a restitution begin with."""
    return f"restitution_{restitution:g}"


def by_restitution(followed: pd.DataFrame) -> dict[float, pd.DataFrame]:
    """The samples of each restitution, a row a sample in the order of the run."""
    return {e: followed[followed["restitution"] == e].reset_index(drop=True) for e in RESTITUTIONS}


def law_differences(
    samples: pd.DataFrame, followed: Mapping[float, pd.DataFrame], outputs: Iterable[str], **drawn: Any
) -> pd.DataFrame:
    """The run less the samples followed, of every statistic of the outputs, over the same samples.

    Parameters
    ----------
    samples : a row a sample, the first of the run
    followed : the same samples in the same order, by restitution
    outputs : names of columns of all
    drawn : ``sampling``, ``lot_size``, ``confidence`` of :class:`tolmc.statistics.rows.Rows`

    Returns
    -------
    DataFrame, index ``output``
        ``restitution_0_mean``, ``restitution_0.5_mean``, sd and the quantiles, each with ``_low`` and ``_high``, as
        :func:`tolmc.statistics.section_effect.section_differences` has them.
    """
    names = list(outputs)
    tables = [paired_differences(samples, frame, names, prefix(e), **drawn) for e, frame in followed.items()]
    return pd.concat(tables, axis=1).rename_axis("output")


def law_of_requirements(
    samples: pd.DataFrame,
    followed: Mapping[float, pd.DataFrame],
    shares: pd.DataFrame,
    *,
    specification: Specification,
    target: float,
    on_contact_loss: str = "stop",
    **drawn: Any,
) -> pd.DataFrame:
    """What walls that only push make of every requirement, and whether they could turn the verdict.

    Parameters
    ----------
    samples : a row a sample, the first of the run
    followed : the same samples, by restitution
    shares : :func:`tolmc.statistics.summary.summarise_requirements` of the whole run
    target : the yield that is asked for

    Returns
    -------
    DataFrame, index ``requirement``
        ``restitution_0_least``, ``restitution_0_most`` with ``_low`` and ``_high``: the share out, as ``share_least`` and
        ``share_most`` of the run; ``restitution_0_difference`` with its interval: the share out in the run less that, over the
        same samples; the same of 0.5; ``contact_law``: "not decided: the contact law matters (ends at the loss 3 %,
        restitution 0: 5 %, 0.5: 12 %)" where the loss of contact leaves the target yield open, or a wall that only pushes does
        not confirm what the run decides of it or of most parts; empty elsewhere. ``contact_law_turns_target``: whether that is
        so of the target yield.
    """
    rows = Rows(**drawn)
    own = events(samples, specification, on_contact_loss)
    laws = {e: events(frame, specification, "follow") for e, frame in followed.items()}
    judge = {"specification": specification, "on_contact_loss": "follow", **drawn}
    found = {e: summarise_requirements(frame, **judge) for e, frame in followed.items()}
    failures = shares.at[CONTACT_LOSS, "unknown"]
    table: dict[str, dict[str, Any]] = {}
    for name in shares.index:
        row: dict[str, Any] = {}
        bounds = {}
        for e, table_of_law in found.items():
            difference = _difference(rows, own[name], laws[e][name])
            row |= {
                f"{prefix(e)}_{key[6:]}": table_of_law.at[name, key] for key in table_of_law if key.startswith("share_")
            }
            row |= as_columns(f"{prefix(e)}_difference", difference)
            bounds[e] = _bounds(shares.loc[name], difference, own[name], laws[e][name])
        counted, is_event = shares.loc[name], name == CONTACT_LOSS
        of_target = not is_event and (
            any(turns(counted, of_law, target) for of_law in bounds.values()) or _leaves_open(counted, failures, target)
        )
        matters = of_target or (not is_event and any(turns(counted, of_law, MOST) for of_law in bounds.values()))
        laws_say = (f"{e:g}: {percent(found[e].loc[name])}" for e in found)
        says = f"{_ENDS[on_contact_loss]} {percent(shares.loc[name])}, restitution {', '.join(laws_say)}"
        row |= {"contact_law": f"{_MATTERS} ({says})" if matters else "", "contact_law_turns_target": of_target}
        table[str(name)] = row
    return pd.DataFrame.from_dict(table, orient="index").rename_axis("requirement")


_Event = tuple[np.ndarray, np.ndarray]


def _difference(rows: Rows, own: _Event, law: _Event) -> Estimate:
    """Share out in the run less that by the law, over samples that both know."""
    (out, known), (out_law, known_law) = own, law
    both = known & known_law
    return share_difference(rows, out & both, out_law & both)


def _bounds(counted: pd.Series, difference: Estimate, own: _Event, law: _Event) -> tuple[float, float]:
    """Bounds of the share out by the law in the whole run; the run's own where no sample shows a difference."""
    (out, known), (out_law, known_law) = own, law
    both = known & known_law
    low, high = counted["share_least_low"], counted["share_most_high"]
    if np.array_equal(out[both], out_law[both]):
        return low, high
    return max(low - difference.high, 0.0), min(high - difference.low, 1.0)


def _leaves_open(counted: pd.Series, failures: int, required: float) -> bool:
    """Whether samples that lost contact, counted in and counted out, leave a yield open."""
    allowed = 1.0 - required
    return counted["unknown"] > failures and counted["share_least"] <= allowed < counted["share_most"]
