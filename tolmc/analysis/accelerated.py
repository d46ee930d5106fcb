"""A run's statistics and shares from few motions, one surrogate for all of them (:mod:`tolmc.analysis.corrected`)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from tolmc.analysis.corrected import MOMENT_POINTS, corrected, draw_kept, keep_near
from tolmc.analysis.designs import Corrected, Weighted, wilson_interval
from tolmc.analysis.importance import refuse_failures
from tolmc.analysis.questions import Question
from tolmc.analysis.surrogate import Model, fit, refuse_rough, training_box
from tolmc.statistics.outcomes import ALL_REQUIREMENTS, Specification
from tolmc.tolerances.dimension import Tolerances
from tolmc.tolerances.draw import sample
from tolmc.tolerances.unit_cube import SCRAMBLINGS


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
        As :func:`corrected`, and (OutputsJump) where no surrogate follows an output. An output that is missing in some
        motions (``contact_loss_time``) cannot be summarised.
    """
    surrogate = fit(model, training_box(tolerances), outputs, motions=training, seed=seed)
    refuse_rough("accelerated summary", surrogate)
    kinds: dict[str, tuple[str, Any]] = {
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
        row: dict[str, float] = {}
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
        When no dimension has a tolerance, (MotionsFailed) when a true motion fails, and (OutputsJump) where no surrogate
        follows an output.
    """
    surrogate = fit(model, training_box(tolerances), list(specification), motions=training, seed=seed)
    refuse_rough("accelerated yield", surrogate)
    inputs = sample(tolerances, MOMENT_POINTS, sampling="sobol", seed=seed)
    excess = _excess(surrogate(inputs), specification, surrogate.spread)
    error = pd.Series(surrogate.held_out) / pd.Series(surrogate.spread).replace(0.0, 1.0)
    error[ALL_REQUIREMENTS] = error.max()
    rng, ones = np.random.default_rng([seed, 0xE1]), np.ones(MOMENT_POINTS)
    rows = {}
    for name in excess:
        values = excess[name].to_numpy()
        keep = keep_near(0.0, error[name], values, ones, motions)
        kept = draw_kept(keep, rng)
        truth = _excess(model(inputs.iloc[kept]), specification, surrogate.spread)[name].to_numpy()
        refuse_failures("accelerated yield", truth)
        moment = Corrected(Weighted(values, ones, SCRAMBLINGS), keep, kept, truth, error[name]).share_above(0.0)
        out, low, high = wilson_interval(moment, MOMENT_POINTS)
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
