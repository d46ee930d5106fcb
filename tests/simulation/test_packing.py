"""Parameters of a block: a thread's array, used again, holds what a fresh one would."""

import numpy as np
import pytest
from scenes import SYMMETRIC

from tolmc.kernels import parameters as P
from tolmc.kernels import results as R
from tolmc.simulation.judge import BODY_INVALID, GEOMETRY_INVALID
from tolmc.simulation.packing import pack, pack_again

N = 5


def test_a_block_after_others_is_packed_as_the_first():
    scalars, varied = SYMMETRIC.scalars, np.linspace(0.4, 0.6, N)
    blocks = (
        scalars, scalars | {"mass": varied, "alpha": varied}, scalars, scalars | {"mass": 2.0, "beta": 0.3},
        scalars | {"force_x": -0.0}, scalars | {"force_x": 0.0}, scalars | {"bush_wall": 0.001},
    )  # fmt: skip
    for values in blocks:
        (again, code), (first, first_code) = pack_again(values, N), pack(values, N)
        assert again.tobytes() == first.tobytes()
        assert code.tolist() == first_code.tolist()


@pytest.mark.parametrize(
    ("name", "wrong"),
    [("restitution", 1.1), ("friction", -0.1), ("slip_speed", 0.0), ("drive_frequency", -1.0), ("mass", np.nan)],
)
def test_what_is_out_of_range_cannot_be_integrated(name, wrong):
    column = np.full(N, SYMMETRIC.scalars[name])
    column[2] = wrong
    _, code = pack(SYMMETRIC.scalars | {name: column}, N)
    assert code.tolist() == [R.OK, R.OK, BODY_INVALID, R.OK, R.OK]


def test_a_journal_without_clearance_has_no_radius():
    raw, code = pack(SYMMETRIC.scalars | {"journal_radius": np.array([0.01, 0.03, 0.01])}, 3)
    assert code.tolist() == [R.OK, GEOMETRY_INVALID, R.OK]
    assert np.isnan(raw[P.RADIUS]).tolist() == [False, True, False]
