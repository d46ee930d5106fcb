"""What the report says of friction, of the drive and of wear, and of the life that `tolmc life` has found."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pandas as pd

from tolmc.runs.record import RunDirectoryError
from tolmc.study.study import Study
from tolmc.text import phrases, typeset

#: What `tolmc life DIR` leaves in a run directory.
LIFE = "life.json"


def of_rubbing(study: Study, summary: pd.DataFrame | None) -> list[str]:
    """Friction, drive and wear over the parts, a sentence each; none of what the study does not have."""
    return [] if summary is None else list(_sentences(study, summary))


def _sentences(study: Study, summary: pd.DataFrame) -> Iterator[str]:
    joint = study.scene.joint
    if "friction_power_mean" in summary.index:
        slow = typeset.share_of(summary.at["slow_share", "q50"], 1.0)
        yield (
            f"Friction turns {_median(summary, 'friction_power_mean')} into heat; its torque about the journal's axis is at "
            f"most {_median(summary, 'friction_torque_max')}. In {slow} of the time a contact slides more slowly than "
            f"{phrases.quantity('slip_speed', joint.slip_speed)}, where the law is made regular."
        )
    if "drive_torque_max" in summary.index:
        yield (
            f"The drive gives at most {_median(summary, 'drive_torque_max')}, and "
            f"{_median(summary, 'drive_power_mean')} on average."
        )
    if "wear_rate" in summary.index:
        yield (
            f"By Archard's law with k = {phrases.quantity('wear_coefficient', joint.wear_coefficient, 4)} at the nominal part "
            f"{_median(summary, 'wear_rate')} wears off in running; impacts are left out."
        )


def _median(summary: pd.DataFrame, name: str) -> str:
    """Median of an output over the parts, and between what 90 % of them lie."""
    middle = phrases.quantity(name, summary.at[name, "q50"], 3)
    low, high = (phrases.quantity(name, summary.at[name, key], 3) for key in ("q5", "q95"))
    return f"{middle} (90 % of the parts: {low} to {high})"


def of_life(directory: Path) -> list[str]:
    """What `tolmc life` has said of a run; nothing where it was not asked.

    Raises
    ------
    RunDirectoryError
        Where its file is damaged.
    """
    path = directory / LIFE
    if not path.exists():
        return []
    try:
        return [str(sentence) for sentence in json.loads(path.read_text(encoding="utf-8"))["sentences"]]
    except (ValueError, KeyError, TypeError) as error:
        raise RunDirectoryError(
            f"{path} is damaged: {error}. Delete it, or run tolmc life {directory} again."
        ) from None
