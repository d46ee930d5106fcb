"""What is asked of an output, and the answer with its interval.

Every estimator draws from the tolerances, calls the model for true motions and gives an :class:`Answer` with its 95 %
interval to each :class:`Question`:

==============  ===================================================================================================
``direct``      true motions alone: independent samples, the yardstick of the others, or scrambled Sobol' points
``corrected``   a polynomial surrogate at many points, corrected by true motions at a few of them
``importance``  tails alone: motions drawn where the tail is and weighted back, without a surrogate
==============  ===================================================================================================
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import cast

CONFIDENCE = 0.95
KINDS = ("mean", "sd", "quantile", "above", "below")


@dataclass(frozen=True)
class Question:
    """What is asked of an output.

    Parameters
    ----------
    output : str
    kind : {"mean", "sd", "quantile", "above", "below"}
        ``"above"``, ``"below"``: the share of motions whose output lies above or below the level.
    level : float or None
        Probability of the quantile, or a value in the output's unit.
    """

    output: str
    kind: str
    level: float = cast(float, None)  # only moments have none

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise ValueError(f"Question: kind = {self.kind!r} is unknown; allowed: {', '.join(KINDS)}.")
        if (self.level is None) == self.is_tail:
            raise ValueError(
                f"Question: {self.kind} of {self.output} {'needs a' if self.is_tail else 'takes no'} level."
            )
        if self.kind == "quantile" and not 0.0 < self.level < 1.0:
            raise ValueError(f"Question: quantile level = {self.level!r} of {self.output}; allowed: 0 < level < 1.")

    @property
    def is_tail(self) -> bool:
        return self.kind not in ("mean", "sd")

    @property
    def sign(self) -> float:
        """The factor that turns the tail into an upper one."""
        return -1.0 if self.kind == "below" or (self.kind == "quantile" and self.level < 0.5) else 1.0

    @property
    def probability(self) -> float:
        """Probability of a quantile's tail; NaN for other questions."""
        return min(self.level, 1.0 - self.level) if self.kind == "quantile" else math.nan

    @property
    def threshold(self) -> float:
        """Where the upper tail of sign * output begins, when its level says so; NaN for other questions."""
        return self.sign * self.level if self.kind in ("above", "below") else math.nan


@dataclass(frozen=True)
class Answer:
    """Value and 95 % interval, the true motions that they took, and what a reader must know about them.

    The motions are those of the whole call: its answers share them.
    """

    question: Question
    value: float
    low: float
    high: float
    motions: int
    method: str
    notes: tuple[str, ...] = ()
