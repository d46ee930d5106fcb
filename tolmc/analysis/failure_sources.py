"""Which dimension drives what goes wrong: failures, losses of contact, broken requirements."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import pandas as pd
from scipy import special

from tolmc.analysis.index_table import index_table, varied_names
from tolmc.statistics.outcomes import (
    ANY_REQUIREMENT,
    CONTACT_LOSS,
    Specification,
    contact_lost,
    failed,
    out_of_specification,
)


def failure_sources(
    samples: pd.DataFrame,
    *,
    inputs: Iterable[str],
    specification: Specification | None = None,
    lot_size: int = 1,
    on_contact_loss: str = "stop",
) -> pd.DataFrame:
    """Which dimensions the failures come from: broken requirements, contact loss, failed samples.

    Compares each dimension's distribution in the samples with the event and in those without (regional
    sensitivity, Hornberger & Spear 1981) by the Kolmogorov-Smirnov distance: 0 when the dimension has
    nothing to do with the event, 1 when a value of it separates the two.

    Returns
    -------
    DataFrame, index ``event``, ``dimension``, the events' dimensions by descending distance
        ``events``, their number; ``distance``; ``p_value``, probability of such a distance without
        influence (rows of a lot count once; too high for Sobol' and Latin hypercube rows); ``where``, in
        which part of the dimension the events lie: "high", "low", "middle", "both ends" or "anywhere";
        ``share``, how many of them lie there (upper or lower quarter, middle half, outer quarters);
        ``finding``, in words. "Anywhere" stands where the p-value exceeds 0.01 divided by the number of
        dimensions.
    """
    names = varied_names(samples, inputs)
    events = _events(samples, specification or {}, on_contact_loss)
    orders = {name: np.argsort(samples[name].to_numpy(float), kind="stable") for name in names}
    table = {}
    for event, (happened, known) in events.items():
        found = {name: _shift(happened[o], known[o], lot_size, SIGNIFICANCE / len(names)) for name, o in orders.items()}
        for name in sorted(found, key=lambda name: -found[name]["distance"]):
            table[event, name] = found[name] | {"finding": _in_words(event, name, found[name])}
    columns = ("events", "distance", "p_value", "where", "share", "finding")
    return index_table(table, ("event", "dimension"), (), *columns)


def _events(
    samples: pd.DataFrame, specification: Specification, on_contact_loss: str
) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Rows in which each event happened, and rows in which it is known whether it did."""
    out, known = out_of_specification(samples, specification, on_contact_loss=on_contact_loss)
    events = {name: (out[name], known[name]) for name in specification}
    if len(specification) > 1:
        any_out = np.any(list(out.values()), axis=0)
        events[ANY_REQUIREMENT] = any_out, any_out | np.all(list(known.values()), axis=0)
    unusable = failed(samples)
    return events | {CONTACT_LOSS: (contact_lost(samples), ~unusable), FAILED: (unusable, np.ones(len(samples), bool))}


def _shift(happened: np.ndarray, known: np.ndarray, lot_size: int, significance: float) -> dict:
    """Distance between the rows with and without an event, which come in ascending order of a dimension."""
    happened = happened[known]
    n, m = len(happened), np.count_nonzero(happened)
    if m in (0, n):
        return {"events": m, "distance": 0.0, "p_value": 1.0, "where": "anywhere", "share": math.nan}
    lag = np.cumsum(~happened) / (n - m) - np.cumsum(happened) / m  # positive where the events come later
    above, below = max(lag.max(), 0.0), max(-lag.min(), 0.0)
    distance = float(max(above, below))
    p_value = float(special.kolmogorov(distance * math.sqrt(m * (n - m) / n / lot_size)))
    where, share = _part(happened, lag, above, below) if p_value <= significance else ("anywhere", math.nan)
    return {"events": m, "distance": distance, "p_value": p_value, "where": where, "share": share}


def _part(happened: np.ndarray, lag: np.ndarray, above: float, below: float) -> tuple[str, float]:
    lowest, *middle, highest = (np.count_nonzero(part) for part in np.array_split(happened, 4))
    total = np.count_nonzero(happened)
    if min(above, below) > 0.5 * max(above, below):
        if lag.argmax() < lag.argmin():
            return "middle", sum(middle) / total
        return "both ends", (lowest + highest) / total
    return ("high", highest / total) if above > below else ("low", lowest / total)


def _in_words(event: str, name: str, found: dict) -> str:
    if found["events"] == 0:
        return f"{event}: no such sample"
    return f"{event}: {_PARTS[found['where']].format(name=name, share=100 * found['share'])}"


FAILED = "failed"
# Evidence below which a dimension is said to have no influence on failures.
SIGNIFICANCE = 0.01
_PARTS = {
    "high": "the upper quarter of {name} holds {share:.0f} % of it (25 % without influence)",
    "low": "the lower quarter of {name} holds {share:.0f} % of it (25 % without influence)",
    "middle": "the middle half of {name} holds {share:.0f} % of it (50 % without influence)",
    "both ends": "the two outer quarters of {name} hold {share:.0f} % of it (50 % without influence)",
    "anywhere": "{name} shows no influence",
}
