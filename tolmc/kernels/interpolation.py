"""Polynomials through what is known at given places: the matrices of their coefficients.

In rational arithmetic, rounded once: a linear algebra library's inverse differs in its last digits from one processor to the
next, and with it would every extremum of a force.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np


def through(places: Sequence[float], *, rates: bool = False) -> np.ndarray:
    """Coefficients, lowest first, of the polynomial through values at ``places`` and, with ``rates``, through slopes there too.

    Returns
    -------
    (m, m) array
        Row: the power; column: the value, then the slope, by which its coefficient goes.
    """
    exact = [Fraction(float(place)) for place in places]
    count = len(exact) * (2 if rates else 1)
    rows = [[place**power for power in range(count)] for place in exact]
    if rates:
        rows += [[Fraction(0)] + [power * place ** (power - 1) for power in range(1, count)] for place in exact]
    return np.array(_inverse(rows), dtype=float)


def slope_through(count: int, place: int) -> np.ndarray:
    """Weights of ``count`` values, at 0, 1, ..., and of the means between them: the slope at ``place``.

    Of the polynomial, of degree 2 ``count`` - 2, that has these values and means.
    """
    ends, powers = [Fraction(end - place) for end in range(count)], range(2 * count - 1)
    rows = [[end**power for power in powers] for end in ends]
    rows += [[((end + 1) ** (power + 1) - end ** (power + 1)) / (power + 1) for power in powers] for end in ends[:-1]]
    return np.array(_inverse(rows)[1], dtype=float)


def _inverse(rows: list[list[Fraction]]) -> list[list[Fraction]]:
    """By Gauss and Jordan."""
    n = len(rows)
    table = [[*row, *(Fraction(int(i == j)) for j in range(n))] for i, row in enumerate(rows)]
    for column in range(n):
        pivot = next(i for i in range(column, n) if table[i][column] != 0)
        table[column], table[pivot] = table[pivot], table[column]
        head = table[column][column]
        table[column] = [value / head for value in table[column]]
        for i in range(n):
            if i != column and table[i][column] != 0:
                factor = table[i][column]
                table[i] = [value - factor * above for value, above in zip(table[i], table[column], strict=True)]
    return [row[n:] for row in table]
