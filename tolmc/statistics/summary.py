"""Summary tables of a run: what every output does, how many samples meet each requirement.

Every estimate stands with its interval: columns ``name``, ``name_low``, ``name_high``. A failed sample has no numbers, so it
enters no mean or quantile. A sample that lost contact has numbers up to that instant: they enter means and quantiles.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pandas as pd

from tolmc.statistics.intervals import Estimate
from tolmc.statistics.observations import Observations
from tolmc.statistics.outcomes import (
    ANY_REQUIREMENT,
    CONTACT_LOSS,
    Judged,
    Specification,
    contact_lost,
    failed,
    out_of_specification,
    rows_whose_status,
)
from tolmc.statistics.rows import Rows

QUANTILES = {"q0.135": 0.00135, "q5": 0.05, "q50": 0.5, "q95": 0.95, "q99.865": 0.99865}
NOTHING = Estimate(np.nan, np.nan, np.nan)


def as_columns(name: str, estimate: Estimate) -> dict[str, float]:
    """The estimate's columns in a table: ``name``, ``name_low``, ``name_high``."""
    return {name: estimate.value, f"{name}_low": estimate.low, f"{name}_high": estimate.high}


def _bounded_share(rows: Rows, events: np.ndarray, known: np.ndarray, method: str = "exact") -> dict[str, float]:
    """Share of ``events`` with the rows that are not known counted as none of them, and as all of them."""
    least = rows.share(events & known, method=method)
    most = least if known.all() else rows.share(events | ~known, method=method)
    return as_columns("share_least", least) | as_columns("share_most", most)


def summarise(
    samples: pd.DataFrame,
    *,
    outputs: Iterable[str],
    sampling: str = "random",
    specification: Specification | None = None,
    confidence: float = 0.95,
    accuracies: Mapping[str, float] | None = None,
    lot_size: int = 1,
    workers: int = 1,
    on_contact_loss: str = "stop",
    judged: Judged | None = None,
) -> pd.DataFrame:
    """A row an output: its estimates with their intervals, in the output's unit.

    Parameters
    ----------
    samples : DataFrame
        All rows of the run in their order, with ``status`` (when absent, every row is valid).
    outputs : names of columns
    sampling : "random", "latin_hypercube" or "sobol"
        How the rows were drawn; see :mod:`tolmc.statistics.rows` for what each allows.
    specification : {output: {"min": limit, "max": limit}}, optional
    confidence : float
    accuracies : {output: accuracy}, optional
        Error of the integration, in the output's unit.
    lot_size : int
        Consecutive rows that share a lot (of their scrambling for Sobol').
    workers : int
        Outputs that are summarised at a time.
    on_contact_loss : "stop", "continue" or "end"
        What the motions did then; "stop": a sample that lost contact is not known to keep a limit.
    judged : (out, known), optional
        What :func:`out_of_specification` says of these samples, where it is known already.

    Returns
    -------
    DataFrame, index ``output``
        ``samples``, ``used`` (rows with a value), ``failed``, ``integration_error``; then, each with
        ``_low`` and ``_high``: ``mean``, ``sd``, ``min``, ``max``, the quantiles ``q0.135`` .. ``q99.865``
        (percent); ``share_least`` and ``share_most``, the share out of specification with samples that are
        not known counted in and counted out (NaN without limits); ``contact_loss``, the share of samples
        that lost contact (failed ones counted as not).
    """
    rows = Rows(sampling, confidence, lot_size)
    outputs = list(outputs)
    missing = [name for name in outputs if name not in samples]
    if missing:
        raise ValueError(f"output {missing[0]!r} is no column of the samples; allowed: {list(samples)}.")
    out, known = judged or out_of_specification(samples, specification or {}, on_contact_loss=on_contact_loss)
    unusable = failed(samples)
    failures = int(np.count_nonzero(unusable))
    contact_loss = as_columns("contact_loss", rows.share(contact_lost(samples)))
    no_share = as_columns("share_least", NOTHING) | as_columns("share_most", NOTHING)

    def summary(name: str) -> dict[str, float]:
        values = samples[name].to_numpy(float)
        values = np.where(unusable, np.nan, values) if failures else values
        seen = Observations(values, rows)
        quantiles = seen.quantiles(list(QUANTILES.values()))
        return {
            "samples": len(samples),
            "used": seen.count,
            "failed": failures,
            "integration_error": (accuracies or {}).get(name, np.nan),
            **as_columns("mean", seen.mean()),
            **as_columns("sd", seen.sd()),
            **as_columns("min", seen.minimum()),
            **as_columns("max", seen.maximum()),
            **{k: v for q, e in zip(QUANTILES, quantiles, strict=True) for k, v in as_columns(q, e).items()},
            **(_bounded_share(rows, out[name], known[name]) if name in out else no_share),
            **contact_loss,
        }

    # Threads: selection and sums over a million samples run without the interpreter lock.
    with ThreadPoolExecutor(workers) as threads:
        table = dict(zip(outputs, threads.map(summary, outputs), strict=True))
    return pd.DataFrame.from_dict(table, orient="index").rename_axis("output")


def summarise_requirements(
    samples: pd.DataFrame,
    *,
    specification: Specification,
    sampling: str = "random",
    confidence: float = 0.95,
    lot_size: int = 1,
    method: str = "exact",
    on_contact_loss: str = "stop",
    judged: Judged | None = None,
) -> pd.DataFrame:
    """A row a requirement, then a row for any of them being broken and one for contact loss.

    ``judged``, where it is known already, is what :func:`out_of_specification` says of these samples.

    Returns
    -------
    DataFrame, index ``requirement``
        ``minimum``, ``maximum`` (NaN: none), ``samples``, ``out`` (rows known to be out), ``unknown`` (rows
        :func:`without_value`), ``share_least`` and ``share_most`` with ``_low`` and ``_high``: the share that is out
        with the unknown rows counted in and counted out. The truth for the whole run lies between
        ``share_least`` and ``share_most``; with the confidence stated, that of the population lies between
        ``share_least_low`` and ``share_most_high``. ``method`` is that of
        :func:`tolmc.statistics.intervals.binomial_interval`.
    """
    rows = Rows(sampling, confidence, lot_size)
    out, known = judged or out_of_specification(samples, specification, on_contact_loss=on_contact_loss)
    events = {name: (out[name], known[name]) for name in specification}
    if specification:
        any_out = np.any(list(out.values()), axis=0)
        events[ANY_REQUIREMENT] = any_out, any_out | np.all(list(known.values()), axis=0)
    events[CONTACT_LOSS] = contact_lost(samples), ~failed(samples)
    table = {}
    for name, (event, decided) in events.items():
        limits = specification.get(name, {})
        table[name] = {
            "minimum": limits.get("min"),
            "maximum": limits.get("max"),
            "samples": len(samples),
            "out": np.count_nonzero(event),
            "unknown": np.count_nonzero(~decided),
            **_bounded_share(rows, event, decided, method),
        }
    frame = pd.DataFrame.from_dict(table, orient="index").rename_axis("requirement")
    return frame.astype({"minimum": float, "maximum": float})


def error_budget(summary: pd.DataFrame) -> pd.DataFrame:
    """Sampling error beside integration error and the model's, from the frame of :func:`summarise`.

    Returns
    -------
    DataFrame, index ``output``
        ``integration`` and, for each of mean, sd and the quantiles, the half-width of its interval, all in
        the output's unit (infinite where the sample is too small); ``ratio`` = integration / the smallest
        of the half-widths: well below 1, sampling is what limits the run. Where the summary has it, the model's term
        of :func:`tolmc.statistics.section_effect.section_differences` and :func:`tolmc.statistics.contact_law.law_differences`
        too.
    """
    names = ["mean", "sd", *QUANTILES]
    budget = pd.DataFrame({name: 0.5 * (summary[f"{name}_high"] - summary[f"{name}_low"]) for name in names})
    budget.insert(0, "integration", summary["integration_error"].abs())
    budget["ratio"] = budget["integration"] / budget[names].min(axis=1)
    return budget.join(summary[[column for column in summary if column.startswith(("section_", "restitution_"))]])


def count_statuses(
    samples: pd.DataFrame, *, sampling: str = "random", confidence: float = 0.95, lot_size: int = 1
) -> pd.DataFrame:
    """A row a status, most frequent first: ``count`` and ``share`` with its interval; index ``status``."""
    rows = Rows(sampling, confidence, lot_size)
    table = {
        status: {"count": count, **as_columns("share", rows.share(rows_whose_status(samples, status.__eq__)))}
        for status, count in samples["status"].value_counts().items()
    }
    return pd.DataFrame.from_dict(table, orient="index").rename_axis("status")
