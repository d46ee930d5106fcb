"""The samples of a run as statistics read them: a column at a time, so that a million samples need little memory."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pandas as pd
import pyarrow as pa

# What every statistic of failures and losses asks for, and so is kept: the status takes a byte a sample.
_ASKED_AGAIN = ("status", "contact_loss_time")


class Columns:
    """As much of a DataFrame as statistics need: ``len`` is the number of samples, ``[name]`` reads a column.

    Parameters
    ----------
    read : function
        ``read(columns, rows)`` gives a table of these columns (None: all) and first rows (None: all).
    """

    def __init__(self, read: Callable[..., pa.Table]) -> None:
        self._read = read
        self._kept: dict[str, pd.Series] = {}
        self._names = read(rows=0).column_names
        self._rows = read(columns=[]).num_rows

    def __len__(self) -> int:
        return self._rows

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __contains__(self, name: str) -> bool:
        return name in self._names

    def __getitem__(self, name: str) -> pd.Series:
        if name in self._kept:
            return self._kept[name]
        pa.default_memory_pool().release_unused()  # else Arrow keeps what was read before: 30 MB of a million samples
        column = self._read(columns=[name])[name]
        is_number = pa.types.is_floating(column.type)  # to_pandas takes twice the time and memory for them
        series = pd.Series(column.to_numpy(), name=name, copy=False) if is_number else column.to_pandas()
        return self._kept.setdefault(name, series) if name in _ASKED_AGAIN else series
