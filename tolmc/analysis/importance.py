"""Answers about tails alone: motions drawn where the tail is and weighted back, without a surrogate."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tolmc.analysis.designs import Weighted, answer_of
from tolmc.analysis.questions import Answer, Question
from tolmc.analysis.surrogate import Model, MotionsFailed
from tolmc.analysis.tail_search import LEVEL_SAMPLES, find_tail, upper_quantile
from tolmc.tolerances.dimension import Tolerances
from tolmc.tolerances.draw import from_standard_normal

#: A tail worth fewer independent samples than this has an unreliable interval.
MIN_EFFECTIVE = 50


def importance(
    model: Model,
    tolerances: Tolerances,
    questions: Sequence[Question],
    *,
    motions: int,
    seed: int,
) -> list[Answer]:
    """Importance sampling of tails by the cross-entropy method (:mod:`tolmc.analysis.tail_search`), without a surrogate.

    Parameters
    ----------
    motions : int
        For the answer to each question. The search for its tail comes on top: half as many, and enough for the fit, for
        each power of ten of the tail's probability.

    Raises
    ------
    ValueError
        For a mean or sd, when no motion reaches a threshold, and (MotionsFailed) when a motion fails.
    """
    for question in questions:
        if not question.is_tail:
            raise ValueError(
                f"importance: the {question.kind} of {question.output} is no tail; use sobol or corrected."
            )
    rng = np.random.default_rng([seed, 0x15])
    dimension = len(tolerances.varied)
    answers = []
    for question in questions:

        def tail_value(z, question=question):
            return question.sign * model(from_standard_normal(tolerances, z))[question.output].to_numpy(float)

        samples = max(motions // 2, LEVEL_SAMPLES * (dimension + 1))
        proposal, spent = find_tail(tail_value, dimension, **target_of(question), samples=samples, rng=rng)
        z = proposal.draw(motions, rng)
        design = Weighted(tail_value(z), proposal.weights(z))
        refuse_failures("importance", design.values)
        notes = weight_notes(design, question)
        answers.append(Answer(question, *answer_of(design, question), spent + motions, "importance sampling", notes))
    return answers


def target_of(question: Question) -> dict[str, float]:
    """The tail to crowd: for a quantile twice as probable, so that values on both sides of it are drawn."""
    if question.kind == "quantile":
        return {"probability": min(2.0 * question.probability, 0.5)}
    return {"threshold": question.threshold}


def refuse_failures(method: str, values: np.ndarray) -> None:
    failed = int(np.isnan(values).sum())
    if failed:
        raise MotionsFailed(
            f"{method}: {failed} of {len(values)} motions failed, so the output is not known everywhere; use plain "
            "or sobol, which bound failed motions both ways, or narrow the tolerances."
        )


def weight_notes(design: Weighted, question: Question) -> tuple[str, ...]:
    """Self-check: how many independent samples the weights in the tail are worth, and whether all average to one."""
    values, masses = design.atoms()
    threshold = question.threshold
    if question.kind == "quantile":
        threshold = upper_quantile(values, masses, question.probability)
    tail = design.weights[values >= threshold]
    effective = float(tail.sum() ** 2 / np.sum(tail**2)) if len(tail) else 0.0
    notes = [f"tail worth {effective:.0f} independent samples; a part of it that no level of the search met is missing"]
    if effective < MIN_EFFECTIVE:
        notes.append(f"worth fewer than {MIN_EFFECTIVE}: the interval is unreliable, use more motions")
    total = design.expect(np.ones_like)
    if abs(total.value - 1.0) > 5.0 * total.variance**0.5:
        notes.append(f"weights average to {total.value:.3g}, not 1: the interval is unreliable, use more motions")
    return tuple(notes)
