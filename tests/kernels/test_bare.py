"""Rows without an array: compiled and not, they hold what the array holds."""

from __future__ import annotations

import numpy as np

from tolmc.kernels import jit, kept
from tolmc.kernels.bare import Counts, Rows, Table

PLACE = slice(3, 5)


@jit.routine
def _turned(rows, table, whole, first):
    """Reads and writes one by one, from a place that is known and one that is not, and fills a place."""
    later, known = rows[first : first + 2], rows[PLACE]
    later[1] += 10.0 * later[0] + known[1]
    rows[PLACE] = 7
    known[0] -= 1
    table[1, first] = table[0, 2] + table[first, 0] + table.shape[0] * table.shape[1]
    whole[first] = whole[0] // 2
    whole[PLACE] = 9


def turned(rows: Rows, table: Table, whole: Counts, first: int):
    _turned(rows, table, whole, first)


def test_they_are_the_arrays_numbers(monkeypatch, tmp_path):
    monkeypatch.setattr(kept, "CACHE", tmp_path)
    rows, table, whole = np.arange(6.0), np.arange(6.0).reshape(2, 3), np.arange(5, 11)
    jit.entry(turned, "turned")(rows, table, whole, 1)
    np.testing.assert_array_equal(rows, [0.0, 1.0, 16.0, 6.0, 7.0, 5.0])
    np.testing.assert_array_equal(table, [[0.0, 1.0, 2.0], [3.0, 11.0, 5.0]])
    np.testing.assert_array_equal(whole, [5, 2, 7, 9, 9, 10])
