"""Sums of the one-sided kernels' formulas: coordinates that are integrated twice are those of the tableau."""

import numba as nb
import numpy as np
import pytest

from tolmc.kernels import jit
from tolmc.kernels.one_sided import formula
from tolmc.kernels.one_sided.layout import WIDTH
from tolmc.kernels.tableaux import CLASSICAL, DORMAND_PRINCE


def compiled(routine):
    """A routine as a function that Python may call."""
    return routine if nb.config.DISABLE_JIT else nb.njit(**jit._OPTIONS)(routine.py_func)


@pytest.mark.parametrize(
    ("tableau", "row"),
    [
        *((tableau, row) for tableau in (CLASSICAL, DORMAND_PRINCE) for row in (*tableau.rows[1:], tableau.weights)),
        (CLASSICAL, CLASSICAL.midpoint),
    ],
)
def test_coordinates_and_speeds_are_those_of_the_tableau(tableau, row):
    rng, n_state, speeds = np.random.default_rng(1), 9, 4 * WIDTH
    y, h = rng.normal(size=n_state * WIDTH), np.tile(rng.uniform(0.1, 1.0, WIDTH), 4)
    k = rng.normal(size=(tableau.stages, 5 * WIDTH))
    weights = np.array([row.get(j, 0.0) for j in range(tableau.stages)])
    v = y[speeds:]
    rates = v + tableau.matrix @ k
    expected = np.concatenate((y[:speeds] + h * (weights @ rates)[:speeds], v + weights @ k))
    for first in (0, 2):
        found = np.full_like(y, np.nan)
        compiled(formula._argument(tableau, row, n_state, first))(y, h, k.ravel(), found)
        there = np.r_[first * WIDTH : speeds, (4 + first) * WIDTH : n_state * WIDTH]
        np.testing.assert_allclose(found[there], expected[there], rtol=0, atol=1e-12)
        assert np.isnan(np.delete(found, there)).all()
