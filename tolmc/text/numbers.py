"""What numbers for people have in common, in whichever notation: see :mod:`tolmc.text.plain` and :mod:`tolmc.text.typeset`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from tolmc import quantities

#: In place of a number that does not exist.
NOTHING = "–"
#: A value below this share of the largest of its unit is a rounding error: of 16 digits a motion and the search for its
#: extremes lose a few.
NEGLIGIBLE = 1e-10


def without_rounding_errors(table: pd.DataFrame, columns: Sequence[str]) -> pd.DataFrame:
    """The table with 0 for values of the columns that are negligible against the largest of the same unit.

    What rounding leaves of a quantity that vanishes is no number worth reading.

    Parameters
    ----------
    table : index or index level ``output``
    columns : names of numeric columns, in the output's unit
    """
    values = table[list(columns)].to_numpy(float, copy=True)
    largest = np.where(np.isfinite(values), np.abs(values), 0.0).max(axis=1, initial=0.0)
    unit = [
        quantities.unit(name) if quantities.is_known(name) else name for name in table.index.get_level_values("output")
    ]
    scale = pd.Series(largest).groupby(unit).transform("max").to_numpy()
    values[np.abs(values) < NEGLIGIBLE * scale[:, None]] = 0.0
    return table.assign(**dict(zip(columns, values.T, strict=True)))


def fixed(value: float, decimals: int) -> str:
    """A number to so many decimals, without a sign where all of them are zero."""
    return f"{round(value, decimals) + 0.0:.{decimals}f}"
