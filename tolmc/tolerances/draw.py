"""From points of the unit cube, or of standard normal space, to samples of the dimensions."""

from __future__ import annotations

import numpy as np
import pandas as pd
from scipy import special

from tolmc.mechanism.checks import plain_array
from tolmc.tolerances import unit_cube as _sampling
from tolmc.tolerances.correlation import combine
from tolmc.tolerances.dimension import Tolerances


def unit_points(
    tolerances: Tolerances, count: int, *, sampling: str, seed: int, start: int = 0, total: int | None = None
) -> np.ndarray:
    """Rows start ... start + count - 1 of the points behind :func:`sample`, (count, varied dimensions).

    0 < u < 1; parameters and errors as in :func:`tolmc.tolerances.unit_cube.cube_points`.
    """
    columns = len(tolerances.varied)
    return _sampling.cube_points(columns, count, sampling=sampling, seed=seed, start=start, total=total)


def from_unit(tolerances: Tolerances, u: np.ndarray) -> pd.DataFrame:
    """Dimensions of points u (n, varied dimensions) of the unit cube, each a part of a lot of its own.

    Returns
    -------
    pandas.DataFrame
        A row a point, a column a dimension in their order, SI units. Coordinate j drives the j-th varied
        dimension and, through correlations, those after it.

    Raises
    ------
    ValueError
        When u has another shape or leaves [0, 1].
    """
    u = _coordinates(tolerances, u)
    if not np.all((u >= 0) & (u <= 1)):
        raise ValueError("from_unit: u leaves the unit cube; allowed: 0 <= u <= 1, no NaN.")
    u = np.clip(u, 2.0**-64, 1.0 - 2.0**-53)
    if tolerances._copula is None:
        return _frame(tolerances, u, 1.0 - u)
    return _from_scores(tolerances, combine(tolerances._copula, special.ndtri(u)))


def from_standard_normal(tolerances: Tolerances, z: np.ndarray) -> pd.DataFrame:
    """Dimensions of independent standard normal scores z (n, varied dimensions).

    The same as ``from_unit(tolerances, Phi(z))``, but precise in both tails. The density of the inputs in
    these coordinates is that of independent standard normal variables.

    Raises
    ------
    ValueError
        When z has another shape or is not finite.
    """
    z = _coordinates(tolerances, z)
    if not np.all(np.isfinite(z)):
        raise ValueError("from_standard_normal: z has entries that are not finite; allowed: finite numbers.")
    return _from_scores(tolerances, z if tolerances._copula is None else combine(tolerances._copula, z))


def sample(
    tolerances: Tolerances, count: int, *, sampling: str, seed: int, start: int = 0, total: int | None = None
) -> pd.DataFrame:
    """Rows start ... start + count - 1 of a sample of the dimensions.

    Row i depends on the seed and i alone (Latin hypercube: on the total as well), bit for bit, and needs no
    row before it. With lots, the rows of a lot depend on each other: see :func:`lot_numbers`.

    Parameters
    ----------
    count, start : int
        Number of rows and index of the first.
    sampling : {"random", "latin_hypercube", "sobol"}
        See :mod:`tolmc.tolerances.unit_cube`.
    seed : int
        0 or more.
    total : int, optional
        Rows of the whole run, for "latin_hypercube".

    Returns
    -------
    pandas.DataFrame
        A row a sample, a column a dimension in their order, SI units.
    """
    u = unit_points(tolerances, count, sampling=sampling, seed=seed, start=start, total=total)
    if tolerances._lots is None or len(u) == 0:
        return from_unit(tolerances, u)
    lots = lot_numbers(tolerances, count, sampling=sampling, start=start)
    shift = special.ndtri(_sampling.lot_rows(len(tolerances.varied), lots, seed))
    within, between = tolerances._lots
    return _from_scores(tolerances, combine(within, special.ndtri(u)) + combine(between, shift))


def lot_numbers(tolerances: Tolerances, count: int, *, sampling: str, start: int = 0) -> np.ndarray:
    """Lot of each of the rows start ... start + count - 1, (count,); without lots every row is its own.

    Row i is in lot i // lot_size; in a Sobol' run lots are counted within each scrambling, so that the
    scramblings stay independent.
    """
    return _sampling.lot_numbers(tolerances.lot_size or 1, count, sampling=sampling, start=start)


def _coordinates(tolerances: Tolerances, values) -> np.ndarray:
    values = plain_array("Tolerances: coordinates", values)
    columns = len(tolerances.varied)
    if values.ndim != 2 or values.shape[1] != columns:
        raise ValueError(
            f"Tolerances: coordinates have the shape {values.shape}; allowed: (n, {columns}), a column for "
            f"each of {', '.join(dimension.name for dimension in tolerances.varied) or 'no dimensions'}."
        )
    return values


def _from_scores(tolerances: Tolerances, z: np.ndarray) -> pd.DataFrame:
    # Past 1e-300 the quantiles of unbounded distributions would be infinite.
    return _frame(tolerances, *(np.maximum(special.ndtr(x), 1e-300) for x in (z, -z)))


def _frame(tolerances: Tolerances, p: np.ndarray, q: np.ndarray) -> pd.DataFrame:
    """Values of all dimensions from the tail probabilities of the varied ones."""
    # As one array, of which pandas makes a frame in a third of the time that it takes for columns.
    values = np.empty((len(tolerances.dimensions), len(p)))
    tails = zip(p.T, q.T, strict=True)
    for row, dimension in zip(values, tolerances.dimensions, strict=True):
        row[:] = dimension.quantile(*next(tails)) if dimension.is_varied else dimension.nominal
    return pd.DataFrame(values.T, columns=[dimension.name for dimension in tolerances.dimensions], copy=False)
