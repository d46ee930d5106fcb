"""When each part breaks a limit, from samples of the same parts at a sequence of running times."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from tolmc.statistics.outcomes import Specification, out_of_specification


def part_lives(
    frames: Sequence[pd.DataFrame], times: np.ndarray, *, specification: Specification, on_contact_loss: str = "stop"
) -> tuple[np.ndarray, np.ndarray]:
    """Earliest and latest time at which every part breaks its first limit, (parts,) each.

    The instant lies between two times where the output that breaks its limit, taken as linear, meets it. A part that is not
    known to keep its limits at some time may have broken one right after the time before, or not at all: that is what tells
    the earliest from the latest. One that breaks none has the last of the times.

    Parameters
    ----------
    frames : of the same parts in the same order, one for each of ``times``
    """
    parts = len(frames[0])
    earliest, latest = np.full(parts, times[-1]), np.full(parts, times[-1])
    alive, sure = np.ones(parts, bool), np.ones(parts, bool)  # not known broken yet; nor possibly broken
    before: pd.DataFrame | None = None
    for place, frame in enumerate(frames):
        out, known = out_of_specification(frame, specification, on_contact_loss=on_contact_loss)
        since = times[max(place - 1, 0)]
        broken_at = np.full(parts, np.inf)
        for name, limits in specification.items():
            met = (
                np.full(parts, times[place])
                if before is None
                else _met(before, frame, name, limits, since, times[place])
            )
            broken_at = np.where(out[name], np.minimum(broken_at, met), broken_at)
        breaks = alive & np.isfinite(broken_at)
        latest[breaks] = broken_at[breaks]
        unknown = ~np.all(list(known.values()), axis=0)
        first = np.where(unknown, since, np.where(np.isfinite(broken_at), broken_at, np.inf))
        ends = sure & np.isfinite(first)
        earliest[ends] = first[ends]
        alive, sure, before = alive & ~breaks, sure & ~ends, frame
    return np.minimum(earliest, latest), latest


def _met(before: pd.DataFrame, after: pd.DataFrame, name: str, limits, since: float, until: float) -> np.ndarray:
    """When the output, linear between both times, meets the limit that it is beyond after."""
    first, last = before[name].to_numpy(float), after[name].to_numpy(float)
    low, high = limits.get("min"), limits.get("max")
    limit = np.where(last > (np.inf if high is None else high), high, low).astype(float)
    with np.errstate(invalid="ignore", divide="ignore"):
        share = (limit - first) / (last - first)
    # What had no number before, or was beyond the limit already, is late where it is seen first.
    return since + np.where((share >= 0.0) & (share <= 1.0), share, 1.0) * (until - since)
