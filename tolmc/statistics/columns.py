"""The samples of a run as statistics read them: a column at a time, so that a million samples need little memory."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pandas as pd
import pyarrow as pa


class Columns:
    """As much of a DataFrame as statistics need: ``len`` is the number of samples, ``[name]`` reads a column.

    Parameters
    ----------
    read : function
        ``read(columns, rows)`` gives a table of these columns (None: all) and first rows (None: all).
    """

    def __init__(self, read: Callable[..., pa.Table]) -> None:
        self._read = read
        self._words: dict[str, pd.Series] = {}
        self._names = read(rows=0).column_names
        self._rows = read(columns=[]).num_rows

    def __len__(self) -> int:
        return self._rows

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __contains__(self, name: str) -> bool:
        return name in self._names

    def __getitem__(self, name: str) -> pd.Series:
        if name in self._words:
            return self._words[name]
        pa.default_memory_pool().release_unused()  # else Arrow keeps what was read before: 30 MB of a million samples
        column = self._read(columns=[name])[name]
        if pa.types.is_floating(column.type):
            return pd.Series(column.to_numpy(), name=name, copy=False)  # half the time and memory of to_pandas
        # Kept: statistics ask for the status again and again, and its codes take a byte a sample.
        return self._words.setdefault(name, column.to_pandas())
