"""Sums of the one-sided kernels' formulas: coordinates that are integrated twice are those of the tableau."""

import numpy as np
import pytest

from tolmc.kernels.one_sided import formula
from tolmc.kernels.one_sided.layout import WIDTH
from tolmc.kernels.tableaux import CLASSICAL, DORMAND_PRINCE


@pytest.mark.parametrize(
    ("tableau", "row"),
    [
        *((tableau, row) for tableau in (CLASSICAL, DORMAND_PRINCE) for row in (*tableau.rows[1:], tableau.weights)),
        (CLASSICAL, CLASSICAL.midpoint),
    ],
)
def test_coordinates_and_speeds_are_those_of_the_tableau(tableau, row):
    rng, size = np.random.default_rng(1), 2 * WIDTH
    x, v, h = rng.normal(size=size), rng.normal(size=size), rng.uniform(0.1, 1.0, WIDTH)
    k = rng.normal(size=(tableau.stages, size))
    weights = np.array([row.get(j, 0.0) for j in range(tableau.stages)])
    out_x, out_v = np.empty(size), np.empty(size)
    getattr(made := formula._argument(tableau, row, size), "py_func", made)(x, v, h, k.ravel(), out_x, out_v)
    np.testing.assert_allclose(out_v, v + weights @ k, rtol=0, atol=1e-12)
    rates = v + tableau.matrix @ k
    np.testing.assert_allclose(out_x, x + np.tile(h, 2) * (weights @ rates), rtol=0, atol=1e-12)
