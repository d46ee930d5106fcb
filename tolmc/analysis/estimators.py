"""Answers about an output's mean, standard deviation, quantiles and failure shares from few motions.

Every estimator draws from the tolerances, calls the model for true motions and gives an :class:`Answer` with its 95 %
interval to each :class:`Question`:

====================  ============================================================================================
:func:`plain`         independent samples: error c/sqrt(n), the yardstick of the others
:func:`sobol`         16 independent scramblings of a Sobol' sequence; intervals come from the scramblings
:func:`corrected`     a polynomial surrogate at many points, corrected by true motions at a few of them
:func:`importance`    tails alone: motions drawn where the tail is and weighted back, without a surrogate
====================  ============================================================================================

The corrected estimator is two-phase sampling with the difference estimator (Särndal, Swensson & Wretman 1992, ch. 9). The
surrogate s is evaluated at N points with weights w_i; each point is kept for a true motion f with its own probability pi_i, and

    E[phi(f)]  ~  (1/N) sum_i w_i phi(s_i)  +  (1/N) sum over the kept of (w_i/pi_i) (phi(f_i) - phi(s_i))

is unbiased whatever the surrogate is worth; a bad one only widens the interval. Moments use Sobol' points and keep all alike.
A tail uses points of a cross-entropy proposal, weighted back, and keeps those near its threshold most.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.special import stdtrit

from tolmc.analysis.surrogate import Model, MotionsFailed, Surrogate, fit, training_box
from tolmc.analysis.tail_search import LEVEL_SAMPLES, find_tail, upper_quantile
from tolmc.statistics.rows import Observations, Rows
from tolmc.statistics.summary import ALL_REQUIREMENTS, Specification
from tolmc.tolerances.dimension import Tolerances, from_standard_normal, sample
from tolmc.tolerances.unit_cube import SCRAMBLINGS

CONFIDENCE = 0.95
KINDS = ("mean", "sd", "quantile", "above", "below")
#: Evaluations of the surrogate for moments, for a tail, and for a level of the search for that tail.
MOMENT_POINTS, TAIL_POINTS, LEVEL_POINTS = SCRAMBLINGS * 1024, 2**14, 2000
#: A tail worth fewer independent samples than this has an unreliable interval.
MIN_EFFECTIVE = 50
#: A relative error of this size is the arithmetic's, not the surrogate's.
ROUNDING = 1e-13


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
    level: float | None = None

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
    def probability(self) -> float | None:
        """Probability of a quantile's tail."""
        return min(self.level, 1.0 - self.level) if self.kind == "quantile" else None

    @property
    def threshold(self) -> float | None:
        """Where the upper tail of sign * output begins, when its level says so."""
        return self.sign * self.level if self.kind in ("above", "below") else None


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


class _Moment(NamedTuple):
    """An estimated expectation, the variance of that estimate, and the degrees of freedom behind the variance."""

    value: float
    variance: float
    freedom: float

    @property
    def reach(self) -> float:
        """Half the width of the interval."""
        return float(stdtrit(self.freedom, 0.5 + 0.5 * CONFIDENCE)) * self.variance**0.5

    def __add__(self, other: _Moment) -> _Moment:
        """Sum of independent estimates, degrees of freedom by Welch and Satterthwaite."""
        variance = self.variance + other.variance
        spread = self.variance**2 / self.freedom + other.variance**2 / other.freedom
        return _Moment(self.value + other.value, variance, variance**2 / spread if spread > 0.0 else self.freedom)


@dataclass(frozen=True, eq=False)
class _Weighted:
    """Values with weights that average to one; ``scramblings`` interleaved independent parts, or independent rows (0)."""

    values: np.ndarray
    weights: np.ndarray
    scramblings: int = 0

    def expect(self, phi: Callable[[np.ndarray], np.ndarray]) -> _Moment:
        terms = self.weights * phi(self.values)
        parts = terms.reshape(-1, self.scramblings).mean(axis=0) if self.scramblings else terms
        return _Moment(float(parts.mean()), float(parts.var(ddof=1)) / len(parts), len(parts) - 1)

    def share_above(self, threshold: float) -> _Moment:
        return self.expect(lambda y: (y > threshold) + 0.0)

    def atoms(self) -> tuple[np.ndarray, np.ndarray]:
        """Values and the probability that each stands for."""
        return self.values, self.weights / len(self.values)


@dataclass(frozen=True, eq=False)
class _Corrected:
    """Surrogate values at every point, true ones at the points kept."""

    surrogate: _Weighted
    keep: np.ndarray  # (N,) probability of a true motion at each point
    kept: np.ndarray  # (m,) the rows drawn with it
    truth: np.ndarray  # (m,) their true values
    error: float  # root mean square error of the surrogate, as held out in training

    def expect(self, phi) -> _Moment:
        difference = phi(self.truth) - phi(self.surrogate.values[self.kept])
        scaled = self._scale * difference
        variance = float(np.sum((1.0 - self.keep[self.kept]) * scaled**2))
        return self.surrogate.expect(phi) + _Moment(float(scaled.sum()), variance, max(len(self.kept) - 1, 1))

    @property
    def _scale(self) -> np.ndarray:
        """Probability that each true motion stands for."""
        return self.surrogate.atoms()[1][self.kept] / self.keep[self.kept]

    def share_above(self, threshold: float) -> _Moment:
        """Its variance is never less than what the surrogate's error allows.

        Where no kept motion lies on the other side of the threshold than its surrogate value, the estimated variance
        is zero; but a point at the distance d may do so with the probability E[error^4]/d^4 (Markov's inequality).
        """
        moment, base = self.expect(lambda y: (y > threshold) + 0.0), self.surrogate.share_above(threshold)
        values, masses = self.surrogate.atoms()
        residual = np.append(self.truth - values[self.kept], self.error)
        error = float(np.mean(residual**4)) ** 0.25
        if error <= ROUNDING * np.abs(values).max():
            return moment
        crossing = (error / np.maximum(np.abs(values - threshold), error)) ** 4
        bound = float(np.sum(masses**2 * (1.0 - self.keep) / self.keep * crossing))
        return moment._replace(variance=max(moment.variance, base.variance + bound))

    def atoms(self) -> tuple[np.ndarray, np.ndarray]:
        values, masses = self.surrogate.atoms()
        return (
            np.concatenate([values, self.truth, values[self.kept]]),
            np.concatenate([masses, self._scale, -self._scale]),
        )


def _answer(design: _Weighted | _Corrected, question: Question) -> tuple[float, float, float]:
    """Value and interval from a design that holds the values times the question's sign."""
    if question.kind == "quantile":
        return _quantile(design, question)
    if question.is_tail:
        return _wilson(design.share_above(question.threshold), len(design.atoms()[0]))
    centre = float(np.median(design.atoms()[0]))  # sums about zero would cancel
    mean = design.expect(lambda y: y - centre)
    if question.kind == "mean":
        return centre + mean.value, centre + mean.value - mean.reach, centre + mean.value + mean.reach
    return _sd(design, centre + mean.value)


def _sd(design, mean: float) -> tuple[float, float, float]:
    sd = max(design.expect(lambda y: (y - mean) ** 2).value, 0.0) ** 0.5
    if sd == 0.0:
        return 0.0, 0.0, 0.0
    # The derivative of sd with respect to the distribution carries its variance (delta method).
    reach = design.expect(lambda y: ((y - mean) ** 2 - sd**2) / (2.0 * sd)).reach
    return sd, max(sd - reach, 0.0), sd + reach


def _quantile(design, question: Question) -> tuple[float, float, float]:
    """Woodruff's (1952) interval: the values where the estimated tail differs from the probability by its own error."""
    values, masses = design.atoms()
    value = upper_quantile(values, masses, question.probability)
    reach = design.share_above(value).reach
    inner = upper_quantile(values, masses, question.probability + reach)
    outer = upper_quantile(values, masses, question.probability - reach) if reach < question.probability else np.inf
    low, high = sorted((question.sign * inner, question.sign * outer))
    return question.sign * value, low, high


def _wilson(moment: _Moment, count: int) -> tuple[float, float, float]:
    """Wilson's interval at the number of independent samples that would have the moment's variance."""
    p = min(max(moment.value, 0.0), 1.0)
    if 0.0 < p < 1.0 and moment.variance > 0.0:
        count = p * (1.0 - p) / moment.variance
    z2 = float(stdtrit(moment.freedom, 0.5 + 0.5 * CONFIDENCE)) ** 2 / count
    centre, reach = p + 0.5 * z2, (z2 * (p * (1.0 - p) + 0.25 * z2)) ** 0.5
    return p, max((centre - reach) / (1.0 + z2), 0.0), min((centre + reach) / (1.0 + z2), 1.0)


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
        proposal, spent = find_tail(tail_value, dimension, **_target(question), samples=samples, rng=rng)
        z = proposal.draw(motions, rng)
        design = _Weighted(tail_value(z), proposal.weights(z))
        _refuse_failures("importance", design.values)
        notes = _weight_notes(design, question)
        answers.append(Answer(question, *_answer(design, question), spent + motions, "importance sampling", notes))
    return answers


def _target(question: Question) -> dict[str, float]:
    """The tail to crowd: for a quantile twice as probable, so that values on both sides of it are drawn."""
    if question.kind == "quantile":
        return {"probability": min(2.0 * question.probability, 0.5)}
    return {"threshold": question.threshold}


def _refuse_failures(method: str, values: np.ndarray) -> None:
    failed = int(np.isnan(values).sum())
    if failed:
        raise MotionsFailed(
            f"{method}: {failed} of {len(values)} motions failed, so the output is not known everywhere; use plain "
            "or sobol, which bound failed motions both ways, or narrow the tolerances."
        )


def _weight_notes(design: _Weighted, question: Question) -> tuple[str, ...]:
    """Self-check: how many independent samples the weights in the tail are worth, and whether all average to one."""
    values, masses = design.atoms()
    threshold = question.threshold
    if threshold is None:
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


@dataclass(frozen=True, eq=False)
class _Pool:
    """First-phase points with their surrogate outputs and weights; which of them get a true motion."""

    inputs: pd.DataFrame
    outputs: pd.DataFrame
    weights: np.ndarray
    scramblings: int
    keep: np.ndarray
    kept: np.ndarray

    def design(self, question: Question, truth: pd.DataFrame, error: float) -> _Corrected:
        surrogate, true = (question.sign * values[question.output].to_numpy(float) for values in (self.outputs, truth))
        _refuse_failures("corrected", true)
        return _Corrected(_Weighted(surrogate, self.weights, self.scramblings), self.keep, self.kept, true, error)


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
    pools = {}
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
        answers.append(Answer(question, *_answer(design, question), spent, "corrected surrogate", notes))
    return answers


def accelerated_summary(
    model: Model,
    tolerances: Tolerances,
    outputs: Sequence[str],
    *,
    motions: int = 256,
    training: int = 256,
    seed: int = 0,
) -> pd.DataFrame:
    """Mean, sd and the 0.135 % and 99.865 % quantiles of several outputs by :func:`corrected`, one surrogate for all.

    Returns
    -------
    pandas.DataFrame
        A row an output, in its unit: ``mean``, ``sd``, ``q0.135``, ``q99.865``, each with ``_low`` and ``_high``;
        ``degree`` and ``held_out_share`` of the surrogate (its held-out error over the output's spread); ``motions`` of
        the whole call.

    Raises
    ------
    ValueError
        As :func:`corrected`. An output that is missing in some motions (``contact_loss_time``) cannot be summarised.
    """
    surrogate = fit(model, training_box(tolerances), outputs, motions=training, seed=seed)
    kinds = {
        "mean": ("mean", None),
        "sd": ("sd", None),
        "q0.135": ("quantile", 0.00135),
        "q99.865": ("quantile", 0.99865),
    }
    questions = [Question(output, *kind) for output in outputs for kind in kinds.values()]
    answers = iter(corrected(model, tolerances, questions, motions=motions, seed=seed, surrogate=surrogate))
    table = surrogate.describe()
    rows = []
    for output in outputs:
        row = {}
        for name in kinds:
            answer = next(answers)
            row |= {name: answer.value, f"{name}_low": answer.low, f"{name}_high": answer.high}
        row |= table.loc[output, ["degree", "held_out_share"]].to_dict()
        rows.append(row | {"motions": training + answer.motions})
    return pd.DataFrame(rows, index=pd.Index(outputs, name="output"))


def accelerated_yield(
    model: Model,
    tolerances: Tolerances,
    specification: Specification,
    *,
    motions: int = 256,
    training: int = 256,
    seed: int = 0,
) -> pd.DataFrame:
    """Share of the parts that keep each requirement, and all of them, by a surrogate corrected by true motions.

    An output y with the limits L, U is out where its excess max(y - U, L - y) is above zero; any requirement is broken
    where the largest of the excesses, each over its output's spread, is. As in :func:`corrected`, the share of Sobol'
    points whose surrogate is out is corrected by true motions, most of them where the surrogate is near its limit.

    Parameters
    ----------
    specification : {output: {"min": limit, "max": limit}}
    motions : int
        Expected number of true motions that correct each share.

    Returns
    -------
    pandas.DataFrame, index ``requirement``
        The outputs, and "all requirements" where there are several: ``yield`` with ``_low`` and ``_high``.

    Raises
    ------
    ValueError
        When no dimension has a tolerance, and (MotionsFailed) when a true motion fails.
    """
    surrogate = fit(model, training_box(tolerances), list(specification), motions=training, seed=seed)
    inputs = sample(tolerances, MOMENT_POINTS, sampling="sobol", seed=seed)
    excess = _excess(surrogate(inputs), specification, surrogate.spread)
    error = pd.Series(surrogate.held_out) / pd.Series(surrogate.spread).replace(0.0, 1.0)
    error[ALL_REQUIREMENTS] = error.max()
    rng, ones = np.random.default_rng([seed, 0xE1]), np.ones(MOMENT_POINTS)
    rows = {}
    for name in excess:
        values = excess[name].to_numpy()
        keep = _keep_near(0.0, error[name], values, ones, motions)
        kept = _draw(keep, rng)
        truth = _excess(model(inputs.iloc[kept]), specification, surrogate.spread)[name].to_numpy()
        _refuse_failures("accelerated yield", truth)
        moment = _Corrected(_Weighted(values, ones, SCRAMBLINGS), keep, kept, truth, error[name]).share_above(0.0)
        out, low, high = _wilson(moment, MOMENT_POINTS)
        # Where no point is out, or none is in, the surrogate's error still allows some.
        low, high = min(low, max(out - moment.reach, 0.0)), max(high, min(out + moment.reach, 1.0))
        rows[name] = {"yield": 1.0 - out, "yield_low": 1.0 - high, "yield_high": 1.0 - low}
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("requirement")


def _excess(outputs: pd.DataFrame, specification: Specification, spread: Mapping[str, float]) -> pd.DataFrame:
    """How far each output is out of its limits (negative: in), over its spread, and the largest of them."""
    table = {
        name: np.maximum(
            outputs[name].to_numpy(float) - limits.get("max", np.inf),
            limits.get("min", -np.inf) - outputs[name].to_numpy(float),
        )
        / (spread[name] or 1.0)
        for name, limits in specification.items()
    }
    frame = pd.DataFrame(table)
    return frame.assign(**{ALL_REQUIREMENTS: frame.max(axis=1, skipna=False)}) if len(table) > 1 else frame


def _moment_pool(surrogate, tolerances, motions, seed, rng) -> _Pool:
    inputs = sample(tolerances, MOMENT_POINTS, sampling="sobol", seed=seed)
    keep = np.full(MOMENT_POINTS, min(motions / MOMENT_POINTS, 1.0))
    weights = np.ones(MOMENT_POINTS)
    return _Pool(inputs, surrogate(inputs), weights, SCRAMBLINGS, keep, _draw(keep, rng))


def _tail_pool(surrogate, tolerances, question, motions, rng) -> _Pool:
    def tail_value(z):
        return question.sign * surrogate(from_standard_normal(tolerances, z))[question.output].to_numpy()

    proposal, _ = find_tail(tail_value, len(tolerances.varied), **_target(question), samples=LEVEL_POINTS, rng=rng)
    z = proposal.draw(TAIL_POINTS, rng)
    inputs, weights = from_standard_normal(tolerances, z), proposal.weights(z)
    outputs = surrogate(inputs)
    values = question.sign * outputs[question.output].to_numpy()
    threshold = question.threshold
    if threshold is None:
        threshold = upper_quantile(values, weights / len(values), question.probability)
    keep = _keep_near(threshold, surrogate.held_out[question.output], values, weights, motions)
    return _Pool(inputs, outputs, weights, 0, keep, _draw(keep, rng))


def _keep_near(threshold: float, error: float, values, weights, motions: int) -> np.ndarray:
    """Neyman's allocation for a share, for half of the motions: weight times the deviation of a point's side.

    The variance of the side of the threshold is taken as (error/distance)^4, as in :meth:`_Corrected.share_above`. The
    other half is spread evenly: it would find a surrogate that is wrong elsewhere.
    """
    error = max(error, np.finfo(float).tiny)
    deviation = weights * (error / np.maximum(np.abs(values - threshold), error)) ** 2
    return np.minimum(0.5 * motions * (deviation / deviation.sum() + 1.0 / len(values)), 1.0)


def _draw(keep: np.ndarray, rng: np.random.Generator) -> np.ndarray:
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
