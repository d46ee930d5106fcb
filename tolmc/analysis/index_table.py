"""Tables of sensitivity: a row a pair of names, an estimate three columns."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import pandas as pd


def index_table(table: dict, names: Sequence[str], estimates: Sequence[str], *others: str) -> pd.DataFrame:
    columns = [f"{name}{end}" for name in estimates for end in ("", "_low", "_high")]
    index = pd.MultiIndex.from_tuples(list(table), names=names)
    return pd.DataFrame(list(table.values()), index=index, columns=[*columns, *others])


def varied_names(samples: pd.DataFrame, inputs: Iterable[str]) -> list[str]:
    return [name for name in inputs if samples[name].min() < samples[name].max()]
