"""Answers from true motions alone: independent samples, the yardstick of the others, and scrambled Sobol' points."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tolmc.analysis.questions import CONFIDENCE, Answer, Question
from tolmc.analysis.surrogate import Model
from tolmc.statistics.observations import Observations
from tolmc.statistics.rows import Rows
from tolmc.tolerances.dimension import Tolerances
from tolmc.tolerances.draw import sample


def plain(
    model: Model, tolerances: Tolerances, questions: Sequence[Question], *, motions: int, seed: int
) -> list[Answer]:
    """Plain Monte Carlo: independent samples, with the intervals of :mod:`tolmc.statistics.rows`."""
    return _direct(model, tolerances, questions, motions, seed, "random", "plain Monte Carlo")


def sobol(
    model: Model, tolerances: Tolerances, questions: Sequence[Question], *, motions: int, seed: int
) -> list[Answer]:
    """Scrambled Sobol' sequences; ``motions`` serve best when they are a power of two."""
    return _direct(model, tolerances, questions, motions, seed, "sobol", "Sobol'")


def _direct(model, tolerances, questions, motions, seed, sampling, method) -> list[Answer]:
    values = model(sample(tolerances, motions, sampling=sampling, seed=seed))
    rows = Rows(sampling, CONFIDENCE, tolerances.lot_size or 1)
    answers = []
    for question in questions:
        observed = Observations(values[question.output].to_numpy(float), rows)
        answer: tuple[float, float, float]
        if question.kind == "quantile":
            answer = observed.quantile(question.level)
        elif question.is_tail:
            answer = _bounded_share(observed, question)
        else:
            answer = getattr(observed, question.kind)()
        answers.append(Answer(question, *answer, motions, method, _failures(motions - observed.count)))
    return answers


def _bounded_share(observed: Observations, question: Question) -> tuple[float, float, float]:
    """Share beyond the threshold; the interval covers both fates of failed motions."""
    values, failed = question.sign * observed.values, np.isnan(observed.values)
    beyond = values > question.threshold
    share = observed.rows.share
    return share(beyond, known=~failed).value, share(beyond).low, share(beyond | failed).high


def _failures(count: int) -> tuple[str, ...]:
    if not count:
        return ()
    return (f"{count} motions failed: they are left out, but the interval of a share covers both their fates",)
