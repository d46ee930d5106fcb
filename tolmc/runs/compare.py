"""Two runs side by side: what changed in the study, and every statistic and share with the interval of its difference.

The interval of a difference is made from the intervals of the two values ("method of variance estimates recovery", Zou and
Donner, Statistics in Medicine 27 (2008) 1693-1702): with d = b - a,

    d - sqrt((b - b_low)^2 + (a_high - a)^2)  ...  d + sqrt((b_high - b)^2 + (a - a_low)^2)

It takes the runs as independent. Runs from the same seed move together, so that their differences are known better than that.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from tolmc.errors import InputError
from tolmc.runs import directory as run_directory
from tolmc.runs.directory import RunDirectory
from tolmc.study.study import Study

STATISTICS = ("mean", "sd", "q0.135", "q50", "q99.865")
_MISSING = ""
# Difference of two values, as a share of them, that is rounding.
_ROUNDING = 1e-10


@dataclass(frozen=True)
class RunComparison:
    """Two runs side by side.

    Attributes
    ----------
    first, second : RunDirectory
    study : DataFrame, index ``field``
        ``first`` and ``second`` of every field of the study that differs, as written; empty where it is not given.
    statistics : DataFrame, index ``output``, ``statistic``
        ``first``, ``second`` and ``difference`` = second - first, each with ``_low`` and ``_high``, SI units.
    shares : DataFrame, index ``requirement``
        The same of the share of samples out of it; where samples are not known, of the least share.
    """

    first: RunDirectory
    second: RunDirectory
    study: pd.DataFrame
    statistics: pd.DataFrame
    shares: pd.DataFrame


def compare_runs(first: str | Path, second: str | Path) -> RunComparison:
    """Compare two finished runs by what their directories hold.

    Raises
    ------
    InputError
        When a directory holds no finished run.
    """
    runs = [_finished(path) for path in (first, second)]
    summaries = [pd.read_csv(run.path / "summary.csv").set_index("output") for run in runs]
    requirements = [pd.read_csv(run.path / "requirements.csv").set_index("requirement") for run in runs]
    studies = [run.study() for run in runs]
    outputs = [name for name in summaries[0].index if name in summaries[1].index and _is_same(name, *studies)]
    keys = pd.MultiIndex.from_product([outputs, STATISTICS], names=["output", "statistic"])
    statistics = [_estimates((summary.loc[name], key) for name, key in keys) for summary in summaries]
    common = [name for name in requirements[0].index if name in requirements[1].index]
    shares = [_estimates((table.loc[name], "share_least") for name in common) for table in requirements]
    return RunComparison(
        runs[0],
        runs[1],
        _changes(*(tomllib.loads(study.source) for study in studies)),
        difference(*statistics).set_index(keys),
        difference(*shares).set_index(pd.Index(common, name="requirement")),
    )


def _is_same(name: str, first: Study, second: Study) -> bool:
    """Whether both studies measure the same by an output's name: those of their own they may have for different things."""
    kinds = [{output.name: output.row.kind for output in study.derived}.get(name) for study in (first, second)]
    return kinds[0] == kinds[1]


def difference(first: np.ndarray, second: np.ndarray) -> pd.DataFrame:
    """Two columns of (value, low, high) side by side, with their difference (0 where it is rounding) and its interval."""
    (a, a_low, a_high), (b, b_low, b_high) = first.T, second.T
    change = np.where(np.abs(b - a) <= _ROUNDING * np.maximum(np.abs(a), np.abs(b)), 0.0, b - a)
    with np.errstate(invalid="ignore"):  # an interval without an end
        low = change - np.hypot(b - b_low, a_high - a)
        high = change + np.hypot(b_high - b, a - a_low)
    columns = {"first": first, "second": second, "difference": np.stack((change, low, high), axis=1)}
    ends = ("", "_low", "_high")
    return pd.DataFrame({f"{name}{end}": part[:, i] for name, part in columns.items() for i, end in enumerate(ends)})


def _finished(path: str | Path) -> RunDirectory:
    run = run_directory.read(path)
    if not run.is_complete or not (run.path / "summary.csv").exists():
        raise InputError(f"{path}: the run is not finished. Finish it with: tolmc run --resume {path}")
    return run


def _estimates(cells: Iterator[tuple[pd.Series, str]]) -> np.ndarray:
    rows = [[row[f"{key}{end}"] for end in ("", "_low", "_high")] for row, key in cells]
    return np.array(rows, float).reshape(-1, 3)


def _changes(first: Mapping[str, Any], second: Mapping[str, Any]) -> pd.DataFrame:
    """Fields of two studies that differ."""
    fields = [dict(_flat(content)) for content in (first, second)]
    differ = [field for field in {**fields[0], **fields[1]} if fields[0].get(field) != fields[1].get(field)]
    columns = {
        name: [part.get(field, _MISSING) for field in differ]
        for name, part in zip(("first", "second"), fields, strict=True)
    }
    return pd.DataFrame(columns, index=pd.Index(differ, name="field"), dtype=object)


def _flat(content: Mapping[str, Any], *where: str) -> Iterator[tuple[str, str]]:
    """``[body] mass`` and what stands there, for every field."""
    for name, value in content.items():
        if isinstance(value, Mapping):
            yield from _flat(value, *where, name)
        else:
            section, *inner = (*where, name)
            yield (f"[{section}] {'.'.join(inner)}" if inner else section), str(value)
