"""Rank correlations of the samples: which input an output rises and falls with."""

from __future__ import annotations

import pandas as pd

#: Samples whose ranks are correlated: they give a correlation to +-0.01, and ranks of a million cost a second.
RANKED = 20_000


def rank_correlations(samples: pd.DataFrame, inputs: list[str], outputs: list[str]) -> pd.DataFrame:
    """Spearman's rank correlation of every output (rows) with every input (columns).

    Over the first :data:`RANKED` samples that have both; NaN where one of them does not vary.
    """
    return samples[inputs + outputs].iloc[:RANKED].corr(method="spearman").loc[outputs, inputs]
