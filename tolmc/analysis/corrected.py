"""Answers from a polynomial surrogate at many points, corrected by true motions at a few of them.

The corrected estimator is two-phase sampling with the difference estimator (Särndal, Swensson & Wretman 1992, ch. 9). The
surrogate s is evaluated at N points with weights w_i; each point is kept for a true motion f with its own probability pi_i, and

    E[phi(f)]  ~  (1/N) sum_i w_i phi(s_i)  +  (1/N) sum over the kept of (w_i/pi_i) (phi(f_i) - phi(s_i))

is unbiased whatever the surrogate is worth; a bad one only widens the interval. Moments use Sobol' points and keep all alike.
A tail uses points of a cross-entropy proposal, weighted back, and keeps those near its threshold most.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from tolmc.analysis.designs import Corrected, Weighted, answer_of
from tolmc.analysis.importance import refuse_failures, target_of
from tolmc.analysis.questions import Answer, Question
from tolmc.analysis.surrogate import Model, Surrogate, fit, training_box
from tolmc.analysis.tail_search import find_tail, upper_quantile
from tolmc.tolerances.dimension import Tolerances
from tolmc.tolerances.draw import from_standard_normal, sample
from tolmc.tolerances.unit_cube import SCRAMBLINGS

#: Evaluations of the surrogate for moments, for a tail, and for a level of the search for that tail.
MOMENT_POINTS, TAIL_POINTS, LEVEL_POINTS = SCRAMBLINGS * 1024, 2**14, 2000


@dataclass(frozen=True, eq=False)
class _Pool:
    """First-phase points with their surrogate outputs and weights; which of them get a true motion."""

    inputs: pd.DataFrame
    outputs: pd.DataFrame
    weights: np.ndarray
    scramblings: int
    keep: np.ndarray
    kept: np.ndarray

    def design(self, question: Question, truth: pd.DataFrame, error: float) -> Corrected:
        surrogate, true = (question.sign * values[question.output].to_numpy(float) for values in (self.outputs, truth))
        refuse_failures("corrected", true)
        return Corrected(Weighted(surrogate, self.weights, self.scramblings), self.keep, self.kept, true, error)


def corrected(
    model: Model,
    tolerances: Tolerances,
    questions: Sequence[Question],
    *,
    motions: int = 256,
    training: int = 256,
    seed: int,
    surrogate: Surrogate | None = None,
) -> list[Answer]:
    """Surrogate corrected by true motions (see the module): any question from a few hundred motions.

    Parameters
    ----------
    motions : int
        Expected number of true motions that correct each tail; as many again correct all moments together.
    training : int
        Motions that train the surrogate, where none is handed over.
    surrogate : Surrogate
        Trained before over the tolerances' box for the questions' outputs.

    Raises
    ------
    ValueError
        When no dimension has a tolerance, when the surrogate reaches no threshold, and (MotionsFailed) when a correcting
        motion or too many training motions fail.
    """
    spent = 0
    if surrogate is None:
        outputs = list(dict.fromkeys(question.output for question in questions))
        surrogate = fit(model, training_box(tolerances), outputs, motions=training, seed=seed)
        spent = surrogate.motions
    rng = np.random.default_rng([seed, 0xC0])
    pools: dict[Question | None, _Pool] = {}
    for question in questions:
        if not question.is_tail and None not in pools:
            pools[None] = _moment_pool(surrogate, tolerances, motions, seed, rng)
        elif question.is_tail and question not in pools:
            pools[question] = _tail_pool(surrogate, tolerances, question, motions, rng)
    truth = _second_phase(model, pools)
    spent += sum(len(pool.kept) for pool in pools.values())
    answers = []
    for question in questions:
        key = question if question.is_tail else None
        design = pools[key].design(question, truth[key], surrogate.held_out[question.output])
        notes = _surrogate_notes(surrogate, question.output)
        answers.append(Answer(question, *answer_of(design, question), spent, "corrected surrogate", notes))
    return answers


def _moment_pool(surrogate, tolerances, motions, seed, rng) -> _Pool:
    inputs = sample(tolerances, MOMENT_POINTS, sampling="sobol", seed=seed)
    keep = np.full(MOMENT_POINTS, min(motions / MOMENT_POINTS, 1.0))
    weights = np.ones(MOMENT_POINTS)
    return _Pool(inputs, surrogate(inputs), weights, SCRAMBLINGS, keep, draw_kept(keep, rng))


def _tail_pool(surrogate, tolerances, question, motions, rng) -> _Pool:
    def tail_value(z):
        return question.sign * surrogate(from_standard_normal(tolerances, z))[question.output].to_numpy()

    proposal, _ = find_tail(tail_value, len(tolerances.varied), **target_of(question), samples=LEVEL_POINTS, rng=rng)
    z = proposal.draw(TAIL_POINTS, rng)
    inputs, weights = from_standard_normal(tolerances, z), proposal.weights(z)
    outputs = surrogate(inputs)
    values = question.sign * outputs[question.output].to_numpy()
    threshold = question.threshold
    if question.kind == "quantile":
        threshold = upper_quantile(values, weights / len(values), question.probability)
    keep = keep_near(threshold, surrogate.held_out[question.output], values, weights, motions)
    return _Pool(inputs, outputs, weights, 0, keep, draw_kept(keep, rng))


def keep_near(threshold: float, error: float, values, weights, motions: int) -> np.ndarray:
    """Neyman's allocation for a share, for half of the motions: weight times the deviation of a point's side.

    The variance of the side of the threshold is taken as (error/distance)^4, as in :meth:`Corrected.share_above`. The
    other half is spread evenly: it would find a surrogate that is wrong elsewhere.
    """
    error = max(error, np.finfo(float).tiny)
    deviation = weights * (error / np.maximum(np.abs(values - threshold), error)) ** 2
    return np.minimum(0.5 * motions * (deviation / deviation.sum() + 1.0 / len(values)), 1.0)


def draw_kept(keep: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    return np.flatnonzero(rng.random(len(keep)) < keep)


def _second_phase(model: Model, pools: dict) -> dict:
    """True outputs at the kept points of every pool, in one call of the model."""
    truth = model(pd.concat([pool.inputs.iloc[pool.kept] for pool in pools.values()], ignore_index=True))
    ends = np.cumsum([0, *(len(pool.kept) for pool in pools.values())])
    return {key: truth.iloc[ends[i] : ends[i + 1]] for i, key in enumerate(pools)}


def _surrogate_notes(surrogate: Surrogate, output: str) -> tuple[str, ...]:
    error, spread = surrogate.held_out[output], surrogate.spread[output]
    share_of_spread = f", {error / spread:.1g} of the output's spread" if spread > 0.0 else ""
    notes = [f"surrogate of degree {surrogate.degree[output]}, held-out error {error:.2g}{share_of_spread}"]
    if surrogate.failed:
        notes.append(f"{surrogate.failed} of {surrogate.motions} training motions failed")
    return tuple(notes)
