"""Correlation matrices of the dimensions: read, checked, factorised."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from tolmc.mechanism.checks import finite_number, plain_array

Pairs = Mapping[tuple[str, str], float]

# Eigenvalues of a matrix given with few digits may be negative by rounding.
_SLACK = 1e-9


def correlation_matrix(names: tuple[str, ...], correlation: Pairs | ArrayLike) -> np.ndarray:
    """Correlation matrix (k, k) in the order of the names, checked.

    Parameters
    ----------
    names : k strings
    correlation : mapping of name pairs to coefficients, or (k, k) matrix

    Raises
    ------
    ValueError, TypeError
        When it is no correlation matrix (symmetric, 1 on the diagonal, positive semidefinite); the message
        names the pair and what the others leave for it.
    """
    matrix = _from_pairs(names, correlation) if isinstance(correlation, Mapping) else _from_array(names, correlation)
    if not is_semidefinite(matrix):
        a, b = worst_pair(names, matrix)
        value = float(matrix[names.index(a), names.index(b)])
        raise ValueError(
            f"Tolerances: correlation of {a} and {b} = {value!r} contradicts the other correlations (the "
            f"matrix is not positive semidefinite); allowed: {_allowed(names, matrix, a, b)}."
        )
    return matrix


def _from_pairs(names: tuple[str, ...], pairs: Pairs) -> np.ndarray:
    matrix, seen = np.eye(len(names)), set()
    for pair, value in pairs.items():
        known = len(pair) == 2 and pair[0] != pair[1] and set(pair) <= set(names)
        if not known or frozenset(pair) in seen:
            raise ValueError(
                f"Tolerances: correlation of {' and '.join(map(str, pair))} is not understood; allowed: a "
                f"pair of two different dimensions, each pair once, of {', '.join(names)}."
            )
        seen.add(frozenset(pair))
        a, b = map(names.index, pair)
        matrix[a, b] = matrix[b, a] = _coefficient(*pair, value)
    return matrix


def _from_array(names: tuple[str, ...], values: ArrayLike) -> np.ndarray:
    matrix = plain_array("Tolerances: correlation", values)
    if matrix.shape != (len(names), len(names)):
        raise ValueError(
            f"Tolerances: correlation has the shape {matrix.shape}; allowed: ({len(names)}, {len(names)}), "
            f"in the order {', '.join(names)}, or a mapping of name pairs."
        )
    for i, a in enumerate(names):
        if matrix[i, i] != 1:
            raise ValueError(
                f"Tolerances: correlation of {a} with itself = {float(matrix[i, i])!r} is out of range; allowed: 1."
            )
        for j, b in enumerate(names[:i]):
            above, below = _coefficient(b, a, matrix[j, i]), _coefficient(b, a, matrix[i, j])
            if above != below:
                raise ValueError(
                    f"Tolerances: correlation of {b} and {a} is {above!r} above and {below!r} below the "
                    "diagonal; allowed: a symmetric matrix."
                )
    return matrix


def _coefficient(a: str, b: str, value) -> float:
    value = finite_number("Tolerances", f"correlation of {a} and {b}", value)
    if abs(value) > 1:
        raise ValueError(f"Tolerances: correlation of {a} and {b} = {value!r} is out of range; allowed: -1 to 1.")
    return value


def is_semidefinite(matrix: np.ndarray) -> bool:
    """Whether no eigenvalue of a symmetric matrix is negative beyond rounding."""
    return len(matrix) == 0 or bool(np.linalg.eigvalsh(matrix)[0] > -_SLACK)


def worst_pair(names: tuple[str, ...], matrix: np.ndarray) -> tuple[str, str]:
    """The pair of names that contributes most to the negative eigenvalue."""
    v = np.linalg.eigh(matrix)[1][:, 0]
    contributions = np.tril(matrix * np.outer(v, v), -1)
    i, j = np.unravel_index(np.argmin(contributions), contributions.shape)
    return names[j], names[i]


def _allowed(names: tuple[str, ...], matrix: np.ndarray, a: str, b: str) -> str:
    """Range of a pair's coefficient that the others leave: where their partial correlation is -1 to 1."""
    pair = [names.index(a), names.index(b)]
    others = [k for k in range(len(names)) if k not in pair]
    cross = matrix[np.ix_(pair, others)]
    explained = cross @ np.linalg.pinv(matrix[np.ix_(others, others)]) @ cross.T
    left = 1.0 - np.diag(explained)
    if left.min() < 0 or not is_semidefinite(matrix[np.ix_(others, others)]):
        return "smaller correlations; others contradict each other too"
    middle, half_width = explained[0, 1], np.sqrt(left.prod())
    return f"{middle - half_width:.4f} to {middle + half_width:.4f} with the others as they are"


def lower_factor(matrix: np.ndarray) -> np.ndarray:
    """Lower-triangular F with F F^T = matrix: Cholesky, with zero columns where the matrix is singular."""
    factor = np.zeros_like(matrix)
    for j in range(len(matrix)):
        pivot = matrix[j, j] - factor[j, :j] @ factor[j, :j]
        if pivot > _SLACK:
            factor[j:, j] = (matrix[j:, j] - factor[j:, :j] @ factor[j, :j]) / np.sqrt(pivot)
    return factor


def combine(factor: np.ndarray, z: np.ndarray) -> np.ndarray:
    """z factor^T of scores (n, k) for a lower-triangular factor, column by column.

    A matrix product rounds differently for different numbers of rows; a row must not depend on the block.
    """
    out = z * np.diag(factor)
    for i, j in zip(*np.nonzero(np.tril(factor, -1)), strict=True):
        out[:, i] += factor[i, j] * z[:, j]
    return out
