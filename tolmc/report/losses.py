"""When contact is lost: the share of the samples that have lost it, over the time of the motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from tolmc.report.curves import HEIGHT, WIDTH
from tolmc.statistics.outcomes import contact_lost
from tolmc.text import phrases, typeset

_POINTS = 200


@dataclass(frozen=True)
class Losses:
    """A sentence, and the curve in a frame of WIDTH by HEIGHT: ``points``, the texts at the frame's right and top end."""

    sentence: str
    points: str
    right: str
    top: str


def losses(samples: pd.DataFrame, duration: float) -> Losses | None:
    """From the samples' ``contact_loss_time`` and ``status``; None where no sample says when it lost contact."""
    if "contact_loss_time" not in samples:
        return None
    times = np.sort(samples["contact_loss_time"].to_numpy(float)[contact_lost(samples)])
    times = times[np.isfinite(times)]
    if not len(times):
        return None
    share = len(times) / len(samples)
    grid = np.linspace(0.0, duration, _POINTS)
    lost = np.searchsorted(times, grid, side="right") / len(times)
    return Losses(
        sentence=_sentence(times, len(samples)),
        points=" ".join(
            f"{WIDTH * t / duration:.1f},{HEIGHT * (1.0 - part):.1f}" for t, part in zip(grid, lost, strict=True)
        ),
        right=phrases.quantity("contact_loss_time", duration, 3),
        top=f"{typeset.number(100.0 * share, 3)} %",
    )


def _sentence(times: np.ndarray, samples: int) -> str:
    first, middle, last = (phrases.quantity("contact_loss_time", t, 3) for t in (times[0], np.median(times), times[-1]))
    count = f"Contact is lost in {len(times):,} of {samples:,} samples"
    if len(times) == 1:
        return f"{count}, at {first}."
    return f"{count}: in the first at {first}, in half of these by {middle}, in the last at {last}."
