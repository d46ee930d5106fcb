"""Rows without an array: compiled and not, they hold what the array holds."""

import numba as nb
import numpy as np
import pytest

from tolmc.kernels import jit
from tolmc.kernels.bare import bare

PLACE = slice(3, 5)


@jit.routine
def _turned(rows, table, first):
    """Reads and writes one by one, from a place that is known and one that is not, and fills a place."""
    later, known = rows[first : first + 2], rows[PLACE]
    later[1] += 10.0 * later[0] + known[1]
    rows[PLACE] = 7
    known[0] -= 1
    table[1, first] = table[0, 2] + table[first, 0]


@jit.kernel
def turned(rows, table, first):
    _turned(bare(rows), bare(table), first)


def test_they_are_the_arrays_numbers():
    rows, table = np.arange(6.0), np.arange(6.0).reshape(2, 3)
    turned(rows, table, 1)
    np.testing.assert_array_equal(rows, [0.0, 1.0, 16.0, 6.0, 7.0, 5.0])
    np.testing.assert_array_equal(table, [[0.0, 1.0, 2.0], [3.0, 5.0, 5.0]])


@pytest.mark.skipif(bool(nb.config.DISABLE_JIT), reason="looks at compiled code")
@pytest.mark.parametrize("array", [np.arange(6), np.arange(6.0)[::2], np.zeros((2, 3), order="F"), np.zeros((2, 2, 2))])
def test_only_contiguous_floats_are_taken(array):
    """Others would be read as what they are not."""

    @nb.njit
    def take(of):
        return bare(of)

    with pytest.raises(nb.TypingError):
        take(array)
