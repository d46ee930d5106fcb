"""Samples: rows that depend on nothing but the seed, streams, points of the unit cube."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats
from scipy.stats import qmc
from tolerance_cases import CASES, LOWER, UPPER, WITHIN_LIMITS, cases, dimension, distributions, joint, samplings

from tolmc.quantities import SCALARS
from tolmc.tolerances import unit_cube as sampling
from tolmc.tolerances.dimension import SCRAMBLINGS, Dimension, Tolerances
from tolmc.tolerances.distributions import Uniform
from tolmc.tolerances.draw import from_unit, sample, unit_points


@given(
    count=st.integers(0, 300),
    cut=st.integers(0, 300),
    seed=st.integers(0, 2**63),
    kind=st.sampled_from(sampling.SAMPLINGS),
    case=st.sampled_from(sorted(CASES)),
)
@settings(max_examples=60, deadline=None)
def test_blocks_give_the_same_rows_bit_for_bit(count, cut, seed, kind, case):
    cut = min(cut, count)
    whole = sample(CASES[case], count, sampling=kind, seed=seed)
    head = sample(CASES[case], cut, sampling=kind, seed=seed, total=count)
    tail = sample(CASES[case], count - cut, sampling=kind, seed=seed, start=cut, total=count)
    pd.testing.assert_frame_equal(whole, pd.concat([head, tail], ignore_index=True), check_exact=True)


@distributions
def test_every_distribution_is_the_same_in_blocks(distribution):
    tolerances = Tolerances([dimension(distribution)], lot_size=3)
    whole = sample(tolerances, 203, sampling="random", seed=3)["journal_radius"].to_numpy()
    blocks = [sample(tolerances, 29, sampling="random", seed=3, start=start) for start in range(0, 203, 29)]
    assert np.array_equal(whole, pd.concat(blocks)["journal_radius"])


@pytest.mark.parametrize("kind", ["random", "sobol"])
@cases
def test_longer_run_begins_with_the_shorter(tolerances, kind):
    short = sample(tolerances, 100, sampling=kind, seed=5)
    long = sample(tolerances, 1000, sampling=kind, seed=5)
    pd.testing.assert_frame_equal(short, long[:100], check_exact=True)


def test_rows_far_ahead_need_no_rows_before():
    for kind in ("random", "sobol"):
        ahead = unit_points(joint(), 40, sampling=kind, seed=5, start=1_000_003)
        again = unit_points(joint(), 20, sampling=kind, seed=5, start=1_000_023)
        assert np.array_equal(ahead[20:], again)


@samplings
@cases
def test_seeds_differ(tolerances, kind):
    first, second = (sample(tolerances, 64, sampling=kind, seed=seed) for seed in (1, 2))
    varied = [d.name for d in tolerances.varied]
    assert not np.any(first[varied].to_numpy() == second[varied].to_numpy())


def test_samplings_and_lots_draw_from_different_streams():
    points = [unit_points(joint(), 50, sampling=kind, seed=9) for kind in sampling.SAMPLINGS]
    points.append(sampling.lot_rows(3, np.arange(50), 9))
    for k, a in enumerate(points):
        assert not any(np.isin(a, b).any() for b in points[:k])


@samplings
@cases
def test_columns_are_all_dimensions_in_order(tolerances, kind):
    frame = sample(tolerances, 33, sampling=kind, seed=0)
    assert list(frame) == ["bearing_radius", "half_length", "mass", "journal_radius"]
    assert np.all(frame["half_length"] == 20e-3)
    assert frame.dtypes.eq(float).all()
    assert unit_points(tolerances, 33, sampling=kind, seed=0).shape == (33, 3)


@samplings
def test_without_tolerances_every_sample_is_nominal(kind):
    tolerances = Tolerances(
        [
            Dimension("bearing_radius", 20e-3),
            Dimension.symmetric("spin_rate", 80.0, 0.0),
            Dimension("half_length", 20e-3, 20e-3, 20e-3, distribution=Uniform()),
        ]
    )
    frame = sample(tolerances, 10, sampling=kind, seed=0)
    assert unit_points(tolerances, 10, sampling=kind, seed=0).shape == (10, 0)
    assert np.all(frame == [20e-3, 80.0, 20e-3])


@given(
    distribution=st.sampled_from(sorted(WITHIN_LIMITS)),
    kind=st.sampled_from(sampling.SAMPLINGS),
    seed=st.integers(0, 2**32),
)
@settings(max_examples=40, deadline=None)
def test_samples_stay_within_limits(distribution, kind, seed):
    tolerances = Tolerances([dimension(WITHIN_LIMITS[distribution])])
    values = sample(tolerances, 400, sampling=kind, seed=seed)["journal_radius"]
    assert values.min() >= LOWER
    assert values.max() <= UPPER
    assert values.nunique() > 390


@pytest.mark.parametrize("distribution", WITHIN_LIMITS.values(), ids=WITHIN_LIMITS)
def test_limits_hold_at_the_ends_of_the_unit_interval(distribution):
    tolerances = Tolerances([dimension(distribution)])
    ends = from_unit(tolerances, np.array([[0.0], [2.0**-60], [1 - 2.0**-53], [1.0]]))["journal_radius"]
    assert ends.between(LOWER, UPPER).all()
    assert ends.is_monotonic_increasing


def test_random_points_are_uniform_and_independent():
    u = sampling.cube_points(2, 20_000, sampling="random", seed=3)
    assert stats.kstest(u[:, 0], "uniform").pvalue > 0.01
    assert abs(np.corrcoef(u.T)[0, 1]) < 0.02
    assert abs(np.corrcoef(u[:-1, 0], u[1:, 0])[0, 1]) < 0.02


def test_latin_hypercube_fills_every_layer_once():
    u = sampling.cube_points(3, 500, sampling="latin_hypercube", seed=3)
    layers = np.sort((u * 500).astype(int), axis=0)
    assert np.array_equal(layers, np.tile(np.arange(500)[:, None], 3))


@pytest.mark.parametrize("columns", [1, 5, len(SCALARS)])
def test_sobol_rows_are_scipys_scrambled_sequences_interleaved(columns):
    u = sampling.cube_points(columns, 1000, sampling="sobol", seed=11)
    for k in range(SCRAMBLINGS):
        rng = np.random.default_rng(np.random.SeedSequence(11, spawn_key=(sampling._SOBOL, k)))
        expected = qmc.Sobol(columns, bits=32, rng=rng).random(64)[: len(u[k::SCRAMBLINGS])]
        assert np.array_equal(u[k::SCRAMBLINGS], expected + 2.0**-33)


def test_more_columns_than_there_are_direction_numbers_are_refused():
    with pytest.raises(ValueError, match="81 columns are too many for sobol; allowed: at most 80"):
        sampling.cube_points(81, 16, sampling="sobol", seed=1)


def test_each_scrambling_is_balanced():
    u = sampling.cube_points(2, 64 * SCRAMBLINGS, sampling="sobol", seed=2)
    for k in range(SCRAMBLINGS):
        cells = (u[k::SCRAMBLINGS] * 8).astype(int)
        assert np.all(np.unique(cells, axis=0, return_counts=True)[1] == 1)


@pytest.mark.slow
def test_scramblings_are_independent():
    # Estimates of one scrambling against another's over many seeds: uncorrelated, of equal spread.
    points = [sampling.cube_points(2, 16 * 32, sampling="sobol", seed=seed) for seed in range(400)]
    means = np.array([np.prod(u, axis=1).reshape(-1, SCRAMBLINGS).mean(axis=0) for u in points])
    correlations = np.corrcoef(means.T)[np.triu_indices(SCRAMBLINGS, 1)]
    assert np.sqrt(400) * np.abs(correlations).max() < 4.5
    assert np.sqrt(400) * abs(correlations.mean()) < 1
    # and the mean of 16 has the error of 16 independent ones
    ratio = means.mean(axis=1).std() / means.std(axis=0).mean() * np.sqrt(SCRAMBLINGS)
    assert 0.85 < ratio < 1.15


def test_sobol_is_far_more_accurate_than_random():
    tolerances = joint()
    exact = [d.mean for d in tolerances.varied]
    names = [d.name for d in tolerances.varied]
    random, sobol = (
        np.abs(sample(tolerances, 4096, sampling=kind, seed=1)[names].mean() - exact)
        / [d.sd for d in tolerances.varied]
        for kind in ("random", "sobol")
    )
    assert random.max() > 3e-3
    assert sobol.max() < 1e-3
