import numpy as np
import pandas as pd
import pyarrow as pa
import pytest

from tolmc.statistics.columns import Columns

FRAME = pd.DataFrame({"a": [1.0, np.nan, 3.0], "status": pd.Categorical(["ok", "diverged", "ok"])})


@pytest.fixture
def columns():
    table = pa.concat_tables([pa.Table.from_pandas(FRAME.iloc[:2]), pa.Table.from_pandas(FRAME.iloc[2:])])
    table = table.unify_dictionaries()

    def read(columns=None, rows=None):
        chosen = table if columns is None else table.select(columns)
        return chosen if rows is None else chosen.slice(0, rows)

    return Columns(read)


def test_columns_are_those_of_the_frame(columns):
    assert len(columns) == 3 and list(columns)[:2] == ["a", "status"]
    assert "a" in columns and "b" not in columns
    pd.testing.assert_series_equal(columns["a"], FRAME["a"])
    assert list(columns["status"]) == list(FRAME["status"])
    assert isinstance(columns["status"].dtype, pd.CategoricalDtype)
