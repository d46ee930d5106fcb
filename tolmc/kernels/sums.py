"""The weighted sums that a step is made of.

A tableau's rows become straight-line code at compile time: zero weights vanish, sums stay in registers. Summing row by row
from a tableau in memory cost three times as much as the right-hand side itself.
"""

from __future__ import annotations

import numpy as np

from tolmc.kernels.jit import inlined


def _terms(row: dict[int, float]) -> tuple[np.ndarray, np.ndarray]:
    """Columns and values of a tableau's row."""
    return np.array(sorted(row), dtype=np.int64), np.array([row[j] for j in sorted(row)], dtype=float)


def weighted_sum(row: dict[int, float]):
    """Device function of element m of y + sum_j row[j] k_j, k flat (stage, state, lane) with ``size`` numbers a stage."""
    columns, values = _terms(row)
    terms = len(columns)

    @inlined
    def weighted_sum_at(y, k, size, m):
        total = y[m]
        for t in range(terms):
            total += values[t] * k[columns[t] * size + m]
        return total

    return weighted_sum_at
