"""Comparison of tables of samples."""

import numpy as np
import pandas as pd


def assert_bitwise_equal(one: pd.DataFrame, other: pd.DataFrame):
    assert list(one) == list(other)
    assert len(one) == len(other)
    for name in one:
        if name == "status":
            assert (one[name].astype(str) == other[name].astype(str)).all()
        else:
            np.testing.assert_array_equal(one[name].to_numpy().view(np.int64), other[name].to_numpy().view(np.int64))
