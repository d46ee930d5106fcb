"""How a scene is integrated: the plan that a whole study keeps."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from tolmc.kernels.tableaux import TABLEAUX
from tolmc.mechanism.checks import positive_number
from tolmc.simulation.features import Features

FORMULATIONS = ("slope", "published", "published-regular")
METHODS = tuple(TABLEAUX)
#: Accuracy aimed at when nothing is said, relative to r, to 1 (axis), to the largest contact force and to the energy.
DEFAULT_ACCURACY = 1e-7
#: Energy error above which a sample counts as inaccurate when the step is given and no accuracy is stated.
COARSE_ACCURACY = 1e-4


@dataclass(frozen=True)
class Plan:
    """How a scene is integrated: formulation, method, number of equal steps, and the accuracy it is judged by.

    One plan serves a whole study: all its samples run through the same kernel, so that a block of samples, or one alone,
    repeats bitwise.
    """

    formulation: str
    method: str
    steps: int
    accuracy: float
    #: Largest error that step halving showed on the pilot's motions (NaN when the step was given).
    pilot_error: float = math.nan
    features: Features = field(default_factory=Features)
    #: Whether every sample is integrated once more with twice the steps, and judged by the difference too.
    halving: bool = False
    #: Motions among the pilot's for which no number of steps met the accuracy.
    unresolved: int = 0
    #: Motions among the pilot's that impacts make chaotic: their energy balance is at rounding, halved steps still differ.
    chaotic: int = 0

    def __post_init__(self) -> None:
        if isinstance(self.features, Mapping):  # as read back from a file
            object.__setattr__(self, "features", Features(**self.features))


def step_count(duration: float, step: float) -> int:
    """Number of equal steps of at most ``step`` (s) that end at ``duration`` exactly."""
    steps = max(1, math.ceil(duration / positive_number("step", step) * (1 - 1e-12)))
    if steps > 10**9:
        raise ValueError(f"step = {step!r} s asks for {steps} steps over {duration!r} s; allowed: at most 1e9 steps.")
    return steps
