"""Scrambled Sobol' sequences: the numbers whose sums over GF(2) are the points.

The same bits as ``scipy.stats.qmc.Sobol(columns, bits=32, rng=rng)``, without SciPy's statistics, which take half a second to
load: longer than a thousand motions.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

#: Binary digits of a coordinate.
BITS = 32


def scrambled(columns: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Shift (columns,) and direction numbers (BITS, columns) of one scrambling, uint32, of which 1 is the last digit.

    The point of which bit j alone of the Gray code of its number is set is the shift XOR the direction numbers of row j; number
    0 is the shift itself. Linear matrix scramble and digital shift (Matousek 1998, J. Complexity 14, 527).

    Raises
    ------
    ValueError
        For more columns than there are direction numbers.
    """
    (rng,) = rng.spawn(1)  # as SciPy does
    shift = rng.integers(2, size=(columns, BITS), dtype=np.uint32) @ (1 << np.arange(BITS, dtype=np.uint32))
    matrices = np.tril(rng.integers(2, size=(columns, BITS, BITS), dtype=np.uint32))
    matrices[:, range(BITS), range(BITS)] = 1
    # Digits in a row of their own, the first digit first, as the triangular matrices take them.
    places = np.arange(BITS - 1, -1, -1, dtype=np.uint32)
    digits = _direction_numbers(columns)[..., None] >> places & 1  # (columns, BITS, digit)
    words = (digits @ matrices.transpose(0, 2, 1) & 1) @ (1 << places)
    return shift, words.T


def _direction_numbers(columns: int) -> np.ndarray:
    """Direction numbers of the unscrambled sequence, (columns, BITS) uint32."""
    rows = _table()
    if columns > 1 + len(rows):
        raise ValueError(f"sampling: {columns} columns are too many for sobol; allowed: at most {1 + len(rows)}.")
    numbers = [[1] * BITS, *(_recurrence(*row) for row in rows[: columns - 1])]
    return np.array(numbers, np.uint32) << np.arange(BITS - 1, -1, -1, dtype=np.uint32)


def _recurrence(polynomial: int, first: tuple[int, ...]) -> list[int]:
    """m_1 ... m_BITS from the first s of them and the polynomial of degree s: m_j is below 2^j."""
    m, degree = list(first), len(first)
    for j in range(degree, BITS):
        new = m[j - degree]
        for k in range(1, degree + 1):
            if polynomial >> (degree - k) & 1:
                new ^= m[j - k] << k
        m.append(new)
    return m


@cache
def _table() -> tuple[tuple[int, tuple[int, ...]], ...]:
    """Polynomial and m_1 ... m_s of each coordinate from the second on."""
    text = (Path(__file__).parent / "direction_numbers.txt").read_text(encoding="utf-8")
    rows = (map(int, line.split()) for line in text.splitlines() if not line.startswith("#"))
    return tuple((polynomial, tuple(first)) for polynomial, *first in rows)
