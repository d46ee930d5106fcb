"""How a scene is integrated: the plan that a whole study keeps."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

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
    #: How many times the error of a motion's roughest step its statistics err, as the pilot's motions show (NaN: not known).
    growth: float = math.nan
    features: Features = field(default_factory=Features)
    #: Of each place for a part of the loads that swings, whether its axes turn with the body; () where nothing swings.
    turning: tuple[bool, ...] = ()
    #: Whether every sample is integrated once more with twice the steps, and judged by the difference too.
    halving: bool = False
    #: Motions among the pilot's for which no number of steps met the accuracy.
    unresolved: int = 0
    #: Motions among the pilot's that impacts make chaotic: their energy balance is at rounding, halved steps still differ.
    chaotic: int = 0
    #: Whether the pilot ended at the bound of its work before all its motions met the accuracy or were given up.
    bounded: bool = False
    #: Time (s) up to which those of its motions agree with twice the steps that no step resolves; NaN: there are none.
    agrees_until: float = math.nan
    #: Impacts up to which the first of the chaotic motions agrees with twice the steps; -1: there is none.
    agreeing_impacts: int = -1

    def __post_init__(self) -> None:
        if isinstance(self.features, Mapping):  # as read back from a file
            object.__setattr__(self, "features", Features(**self.features))
            object.__setattr__(self, "turning", tuple(self.turning))

    def following(self, accuracy: float) -> Plan:
        """The same for a wall that only pushes, judged by this accuracy where its own is finer."""
        features = replace(self.features, one_sided=True, momentum=False)
        return replace(self, features=features, halving=False, accuracy=max(self.accuracy, accuracy))

    def unresolved_words(self) -> str:
        """What the pilot's unresolved motions mean, and what to do; empty without any."""
        if not self.unresolved:
            return ""
        if self.agrees_until > 0.0:
            why = (
                f"The motions become chaotic after t = {self.agrees_until:.2g} s: from then on every step, however short, "
                f"gives another motion ({self.unresolved} of those at the nominal and corner dimensions)"
            )
            remedy = (
                "Shorten [motion] duration to about that time; or give [contact] restitution, whose motions are judged by "
                "their energy balance, so that statistics over many of them stand"
            )
        elif self.bounded:
            why = (
                f"The pilot ended at its bound, a tenth of the run or two seconds, before {self.unresolved} of the motions at "
                f"the nominal and corner dimensions met the accuracy {self.accuracy:.3g}"
            )
            remedy = "Give [monte_carlo] step, a larger accuracy or a shorter duration"
        else:
            why = (
                f"{self.unresolved} of the motions at the nominal and corner dimensions met the accuracy {self.accuracy:.3g} "
                "with no step (a clearance near zero, or a chaotic motion)"
            )
            remedy = "A shorter duration or a larger accuracy may be within reach"
        judged = "integrated twice and judged by the difference" if self.halving else "judged by its invariants"
        return (
            f"{why}. The steps are fixed at {self.steps:,} a motion, and samples are judged one by one: each is {judged}, and "
            f"is inaccurate where it misses the accuracy. {remedy}."
        )

    def chaotic_words(self) -> str:
        """Up to where motions with impacts are reproducible, and what stands for them from there; empty without any."""
        if not self.chaotic or self.agreeing_impacts < 0:
            return ""
        count = "one impact" if self.agreeing_impacts == 1 else f"{self.agreeing_impacts:,} impacts"
        return (
            f"Impacts make {self.chaotic} of the motions at the nominal and corner dimensions chaotic: halved steps agree up "
            f"to {count} and part company after. Such samples are judged by their energy balance and stand for no single part; "
            "their statistics do (error budget)."
        )


def step_seconds(features: Features) -> float:
    """About what a step of a motion with all its statistics takes on one core, s."""
    return 0.8e-6 if features.general else 0.2e-6


def step_count(duration: float, step: float) -> int:
    """Number of equal steps of at most ``step`` (s) that end at ``duration`` exactly."""
    steps = max(1, math.ceil(duration / positive_number("step", step) * (1 - 1e-12)))
    if steps > 10**9:
        raise ValueError(f"step = {step!r} s asks for {steps} steps over {duration!r} s; allowed: at most 1e9 steps.")
    return steps
