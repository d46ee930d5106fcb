"""Lots: variance between and within, correlation, numbering."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats
from tolerance_cases import ALL, WIDTH, dimension

from tolmc.tolerances import unit_cube as sampling
from tolmc.tolerances.dimension import SCRAMBLINGS, Dimension, Tolerances
from tolmc.tolerances.distributions import Normal
from tolmc.tolerances.draw import lot_numbers, sample


def lots(share, distribution=None, **options):
    d = dimension(distribution or Normal(truncated=False), lot_share=share)
    return Tolerances([d, Dimension.symmetric("bearing_radius", 20e-3, 1e-4)], lot_size=50, **options)


@pytest.mark.parametrize("kind", sampling.SAMPLINGS)
@pytest.mark.parametrize("share", [0.2, 0.7])
def test_variance_between_and_within_lots(share, kind):
    tolerances = lots(share)
    count = 50 * 640
    frame = sample(tolerances, count, sampling=kind, seed=12)
    by_lot = frame["journal_radius"].groupby(lot_numbers(tolerances, count, sampling=kind))
    variance = tolerances.dimensions[0].sd ** 2
    assert by_lot.size().eq(50).all()
    assert by_lot.var().mean() / variance == pytest.approx(1 - share, abs=0.03)
    # The variance of the lots' means is that between lots and a 50th of that within.
    assert by_lot.mean().var() / variance == pytest.approx(share + (1 - share) / 50, rel=0.15)
    # Without a share of its own the other dimension does not shift.
    other = frame["bearing_radius"].groupby(lot_numbers(tolerances, count, sampling=kind)).mean()
    assert other.var() / tolerances.dimensions[1].sd ** 2 < 0.03


@pytest.mark.parametrize("distribution", ALL.values(), ids=ALL)
def test_lots_leave_the_distribution_as_it_is(distribution):
    d = dimension(distribution, lot_share=0.5)
    values = sample(Tolerances([d], lot_size=2), 20_000, sampling="random", seed=1)["journal_radius"]
    assert values.mean() == pytest.approx(d.mean, abs=0.05 * d.sd)
    assert values.std() == pytest.approx(d.sd, rel=0.05)
    # and pairs of a lot correlate as their scores do
    pairs = values.to_numpy().reshape(-1, 2)
    assert stats.spearmanr(*pairs.T).statistic == pytest.approx(6 / np.pi * np.arcsin(0.25), abs=0.04)


def test_lots_keep_the_correlation():
    names = ("bearing_radius", "journal_radius", "half_length")
    dimensions = [
        Dimension.symmetric(name, 20e-3, 1e-4, lot_share=share, distribution=Normal(truncated=False))
        for name, share in zip(names, (0.2, 0.5, 0.0), strict=True)
    ]
    pairs = {(names[0], names[1]): 0.7, (names[1], names[2]): -0.4}
    tolerances = Tolerances(dimensions, pairs, lot_size=1)
    frame = sample(tolerances, 50_000, sampling="random", seed=1)
    np.testing.assert_allclose(np.corrcoef(frame.to_numpy().T), tolerances.correlation, atol=0.02)


def test_lot_sd_is_the_standard_deviation_between_lots():
    d = dimension(Normal(truncated=False), lot_sd=WIDTH / 12)
    assert d.between_lots == pytest.approx(0.25, rel=1e-12)
    assert replace(d, lot_sd=None, lot_share=0.25).between_lots == 0.25


@given(st.integers(1, 50), st.integers(0, 1000), st.integers(1, 200), st.sampled_from(["random", "latin_hypercube"]))
def test_lots_are_consecutive(size, start, count, kind):
    numbers = sampling.lot_numbers(size, count, sampling=kind, start=start)
    assert np.array_equal(numbers, np.arange(start, start + count) // size)


@given(st.integers(1, 20))
def test_lots_of_a_sobol_run_stay_in_their_scrambling(size):
    numbers = sampling.lot_numbers(size, 16 * size * 3, sampling="sobol")
    rows = np.arange(len(numbers))
    for lot in np.unique(numbers):
        members = rows[numbers == lot]
        assert len(members) == size
        assert len(np.unique(members % SCRAMBLINGS)) == 1
