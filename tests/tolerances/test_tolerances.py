"""Dimensions, distributions, correlation, lots, and the samples that come of them."""

import math
import pickle
import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats
from scipy.special import ndtr, ndtri
from scipy.stats import qmc

from tolmc.tolerances import unit_cube as sampling
from tolmc.tolerances.dimension import SCRAMBLINGS, Dimension, Tolerances
from tolmc.tolerances.distributions import Beta, Measured, Normal, Scipy, Triangular, Uniform
from tolmc.tolerances.draw import from_standard_normal, from_unit, lot_numbers, sample, unit_points

LOWER, NOMINAL, UPPER = 9.7e-3, 10e-3, 10.1e-3
WIDTH, MIDDLE = UPPER - LOWER, (LOWER + UPPER) / 2
DATA = np.random.default_rng(1).gamma(4.0, 0.05e-3, 200) + 9.9e-3

WITHIN_LIMITS = {
    "normal": Normal(),
    "capable normal": Normal(cp=1.67, cpk=1.33),
    "normal at the nominal": Normal(mean="nominal"),
    "normal near a limit": Normal(cp=0.4, mean=UPPER),
    "uniform": Uniform(),
    "triangular": Triangular(),
    "triangular at a limit": Triangular(mode=LOWER),
    "beta": Beta(2.0, 5.0),
    "truncated scipy": Scipy("gumbel_r", {"loc": 9.9e-3, "scale": 0.1e-3}, truncated=True),
}
UNBOUNDED = {
    "process": Normal(cpk=1.0, truncated=False),
    "scipy": Scipy("weibull_min", {"c": 1.8, "loc": 9.7e-3, "scale": 0.2e-3}),
    "bootstrap": Measured(DATA),
    "kernel": Measured(DATA, method="kernel"),
}
ALL = WITHIN_LIMITS | UNBOUNDED


def dimension(distribution=None, name="journal_radius", **options):
    if distribution is not None:
        options["distribution"] = distribution
    return Dimension(name, NOMINAL, LOWER, UPPER, **options)


def joint(**options):
    """Three dimensions, the second without tolerance, the others as different as possible."""
    return Tolerances(
        (
            Dimension.symmetric("bearing_radius", 20e-3, 0.05e-3),
            Dimension("half_length", 20e-3),
            Dimension.symmetric("mass", 0.5, 0.01, distribution=Uniform()),
            dimension(Scipy("lognorm", {"s": 0.3, "loc": 9.7e-3, "scale": 0.1e-3})),
        ),
        **options,
    )


CASES = {
    "independent": joint(),
    "correlated": joint(correlation={("bearing_radius", "mass"): 0.8, ("mass", "journal_radius"): -0.5}),
    "lots": Tolerances(
        [replace(d, lot_share=0.4) for d in joint().dimensions],
        {("bearing_radius", "mass"): 0.8},
        lot_size=7,
    ),
}

cases = pytest.mark.parametrize("tolerances", CASES.values(), ids=CASES)
samplings = pytest.mark.parametrize("kind", sampling.SAMPLINGS)
distributions = pytest.mark.parametrize("distribution", ALL.values(), ids=ALL)


# Samples


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


def test_sobol_rows_are_scipys_scrambled_sequences_interleaved():
    u = sampling.cube_points(5, 1000, sampling="sobol", seed=11)
    for k in range(SCRAMBLINGS):
        rng = np.random.default_rng(np.random.SeedSequence(11, spawn_key=(sampling._SOBOL, k)))
        expected = qmc.Sobol(5, bits=32, rng=rng).random(64)[: len(u[k::SCRAMBLINGS])]
        assert np.array_equal(u[k::SCRAMBLINGS], expected + 2.0**-33)


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


# Distributions


@pytest.mark.parametrize(
    ("distribution", "reference"),
    [
        (Normal(), stats.truncnorm(-3, 3, MIDDLE, WIDTH / 6)),
        (Normal(cp=1.2), stats.truncnorm(-3.6, 3.6, MIDDLE, WIDTH / 7.2)),
        (Normal(cp=1.5, cpk=1.0), stats.truncnorm(-6, 3, UPPER - WIDTH / 3, WIDTH / 9)),
        (Normal(cp=1.5, cpk=1.0, shift="lower"), stats.truncnorm(-3, 6, LOWER + WIDTH / 3, WIDTH / 9)),
        (Normal(mean="nominal"), stats.truncnorm(-4.5, 1.5, NOMINAL, WIDTH / 6)),
        (Normal(mean=NOMINAL, cpk=1.0), stats.truncnorm(-9, 3, NOMINAL, 0.1e-3 / 3)),
        (Normal(truncated=False), stats.norm(MIDDLE, WIDTH / 6)),
        (Uniform(), stats.uniform(LOWER, WIDTH)),
        (Triangular(), stats.triang((NOMINAL - LOWER) / WIDTH, LOWER, WIDTH)),
        (Triangular(mode=UPPER), stats.triang(1.0, LOWER, WIDTH)),
        (Beta(2.0, 5.0), stats.beta(2.0, 5.0, LOWER, WIDTH)),
        (Beta(0.5, 0.8), stats.beta(0.5, 0.8, LOWER, WIDTH)),
        (Scipy("lognorm", {"s": 0.3, "loc": 9e-3, "scale": 1e-3}), stats.lognorm(0.3, 9e-3, 1e-3)),
        (
            Scipy("norm", {"loc": NOMINAL, "scale": WIDTH / 6}, truncated=True),
            stats.truncnorm(-4.5, 1.5, NOMINAL, WIDTH / 6),
        ),
    ],
)
class TestAgainstScipy:
    def test_quantiles(self, distribution, reference):
        u = np.array([1e-9, 1e-4, 0.02, 0.3, 0.5, 0.77, 0.99, 1 - 1e-4, 1 - 1e-9])
        assert dimension(distribution).ppf(u) == pytest.approx(reference.ppf(u), rel=1e-10, abs=1e-12 * WIDTH)

    def test_upper_tail_from_standard_normal(self, distribution, reference):
        z = np.array([-8.0, -5.0, 0.0, 5.0, 8.0])
        values = from_standard_normal(Tolerances([dimension(distribution)]), z[:, None])["journal_radius"]
        expected = np.where(z < 0, reference.ppf(ndtr(z)), reference.isf(ndtr(-z)))
        assert values.to_numpy() == pytest.approx(expected, rel=1e-9)

    def test_moments(self, distribution, reference):
        d = dimension(distribution)
        assert d.mean == pytest.approx(reference.mean(), rel=1e-10)
        assert d.sd == pytest.approx(reference.std(), rel=1e-7)

    def test_sample_follows_it(self, distribution, reference):
        tolerances = Tolerances([dimension(distribution)])
        values = sample(tolerances, 5000, sampling="random", seed=8)["journal_radius"]
        assert stats.kstest(values, reference.cdf).pvalue > 0.01


def test_cpk_sets_the_share_out_of_limits():
    # Two-sided, centred: Cpk 1 -> 2699.80 ppm, 1.33 -> 66.07 ppm; both together: 3 Cpk and 6 Cp - 3 Cpk sigma.
    for normal, ppm in (
        (Normal(cpk=1.0, truncated=False), 2699.796),
        (Normal(cp=1.33, truncated=False), 66.073),
        (Normal(cp=1.5, cpk=1.0, truncated=False), 1e6 * (ndtr(-3) + ndtr(-6))),
    ):
        d = dimension(normal)
        mean, sd = normal.process(d)
        outside = ndtr((d.lower - mean) / sd) + ndtr((mean - d.upper) / sd)
        assert 1e6 * outside == pytest.approx(ppm, rel=1e-5)
        u = sample(Tolerances([d]), 2**16, sampling="sobol", seed=4)["journal_radius"]
        assert 1e6 * (~u.between(d.lower, d.upper)).mean() == pytest.approx(ppm, abs=60)


def test_capability_sets_mean_and_sd_of_the_process():
    mean, sd = Normal(cp=1.6, cpk=1.2).process(dimension())
    assert WIDTH / (6 * sd) == pytest.approx(1.6, rel=1e-12)
    assert min(UPPER - mean, mean - LOWER) / (3 * sd) == pytest.approx(1.2, rel=1e-12)
    assert mean > MIDDLE
    assert Normal(cpk=1.2).process(dimension()) == pytest.approx((MIDDLE, WIDTH / 7.2), rel=1e-12)


@given(u=st.lists(st.floats(1e-12, 1 - 1e-12), min_size=2, max_size=20), name=st.sampled_from(sorted(ALL)))
@settings(deadline=None)
def test_quantiles_are_monotone(u, name):
    values = dimension(ALL[name]).ppf(np.sort(u))
    assert np.all(np.diff(values) >= -1e-15)


def test_bootstrap_gives_the_measured_values_equally_often():
    d = dimension(Measured(DATA))
    values = d.ppf((np.arange(20 * len(DATA)) + 0.5) / (20 * len(DATA)))
    assert np.array_equal(values, np.repeat(np.sort(DATA), 20))
    assert (d.mean, d.sd) == pytest.approx((DATA.mean(), DATA.std()), rel=1e-12)


def kernel_cdf(x, data, bandwidth):
    return ndtr((np.asarray(x)[:, None] - data) / bandwidth).mean(axis=1)


@pytest.mark.parametrize(
    "data", [DATA, np.array([1.0, 1.1, 5.0, 40.0]) * 1e-3, np.array([-1.0, 1.0])], ids=["many", "gaps", "two"]
)
def test_kernel_density_is_inverted(data):
    distribution = Measured(data, method="kernel", bandwidth=0.1 * np.std(data) if len(data) < 10 else None)
    z = np.linspace(-7, 7, 201)
    p, q = ndtr(z), ndtr(-z)
    x = distribution.quantile(p, q, None)
    # Off the flat parts, where x is free, the distribution function returns p, in both tails.
    below = kernel_cdf(x, data, distribution.bandwidth)
    above = kernel_cdf(-x, -data, distribution.bandwidth)
    assert below == pytest.approx(p, rel=1e-3, abs=2e-6)
    assert above == pytest.approx(q, rel=1e-3, abs=2e-6)


def test_kernel_density_follows_scipys():
    d = dimension(Measured(DATA, method="kernel"))
    reference = stats.gaussian_kde(DATA, bw_method="silverman")
    assert d.distribution.bandwidth == pytest.approx(math.sqrt(reference.covariance[0, 0]), rel=1e-12)
    middle = d.ppf(0.5)
    assert reference.integrate_box_1d(-np.inf, middle) == pytest.approx(0.5, abs=1e-6)
    z = ndtri((np.arange(4096) + 0.5) / 4096)
    values = from_standard_normal(Tolerances([d]), z[:, None])["journal_radius"]
    assert values.mean() == pytest.approx(d.mean, rel=1e-6)
    assert values.std() == pytest.approx(d.sd, rel=5e-3)


def test_measured_values_from_csv(tmp_path):
    path = tmp_path / "shafts.csv"
    path.write_text("part, diameter\n1, 19.93\n2, 19.95\n3, 19.94\n")
    distribution = Measured.from_csv(path, "diameter", unit=0.5e-3)
    assert distribution.values == pytest.approx([9.965e-3, 9.97e-3, 9.975e-3], rel=1e-14)
    with pytest.raises(ValueError, match=r"no column 'radius'.*part, diameter"):
        Measured.from_csv(path, "radius")
    path.write_text("diameter\n19.93\n19.95 mm\n")
    with pytest.raises(ValueError, match=r"line 3, column 'diameter' holds '19.95 mm'"):
        Measured.from_csv(path, "diameter")


def test_natural_limits_of_a_distribution_with_its_own_scale():
    d = Dimension("mass", 0.5, distribution=Scipy("norm", {"loc": 0.5, "scale": 0.01}))
    assert d.is_varied
    assert (d.lower, d.upper) == pytest.approx((0.47, 0.53), abs=1e-6)
    assert Dimension("mass", 0.5, 0.4, 0.6, distribution=d.distribution).upper == 0.6


# Correlation


@pytest.mark.parametrize("kind", ["random", "sobol"])
@pytest.mark.parametrize("rho", [-0.9, 0.3, 0.99])
def test_correlation_of_normal_dimensions(rho, kind):
    normal = Normal(truncated=False)
    tolerances = Tolerances(
        [dimension(normal), dimension(normal, "bearing_radius")],
        correlation={("bearing_radius", "journal_radius"): rho},
    )
    frame = sample(tolerances, 2**14, sampling=kind, seed=2)
    assert np.corrcoef(frame.to_numpy().T)[0, 1] == pytest.approx(rho, abs=0.02)


@given(rho=st.floats(-0.99, 0.99), a=st.sampled_from(sorted(ALL)), b=st.sampled_from(sorted(ALL)))
@settings(max_examples=25, deadline=None)
def test_rank_correlation_and_margins_of_any_dimensions(rho, a, b):
    tolerances = Tolerances(
        [dimension(ALL[a]), dimension(ALL[b], "bearing_radius")], correlation=[[1.0, rho], [rho, 1.0]]
    )
    frame = sample(tolerances, 4096, sampling="sobol", seed=6)
    spearman = stats.spearmanr(frame["journal_radius"], frame["bearing_radius"]).statistic
    assert spearman == pytest.approx(6 / np.pi * np.arcsin(rho / 2), abs=0.03)
    for d in tolerances.dimensions:
        assert frame[d.name].mean() == pytest.approx(d.mean, abs=0.02 * d.sd)
        assert frame[d.name].std() == pytest.approx(d.sd, rel=0.03)


def test_perfect_correlation():
    tolerances = Tolerances(
        [Dimension.symmetric("bearing_radius", 20e-3, 1e-4), Dimension.symmetric("half_length", 20e-3, 1e-4)],
        correlation={("bearing_radius", "half_length"): -1.0},
    )
    frame = sample(tolerances, 100, sampling="random", seed=2)
    assert (frame.sum(axis=1) - 40e-3).abs().max() < 1e-12


def test_correlation_skips_dimensions_without_tolerance():
    tolerances = joint(correlation={("bearing_radius", "mass"): 0.5, ("bearing_radius", "half_length"): 0.7})
    without = joint(correlation={("bearing_radius", "mass"): 0.5})
    args = {"sampling": "sobol", "seed": 1}
    pd.testing.assert_frame_equal(sample(tolerances, 50, **args), sample(without, 50, **args), check_exact=True)


def test_zero_correlation_changes_nothing():
    args = {"sampling": "sobol", "seed": 1}
    given = sample(joint(correlation=np.eye(4)), 50, **args)
    pd.testing.assert_frame_equal(given, sample(joint(), 50, **args), check_exact=True)


@cases
def test_standard_normal_and_unit_coordinates_agree(tolerances):
    u = unit_points(tolerances, 200, sampling="random", seed=4)
    frame = from_unit(tolerances, u)
    np.testing.assert_allclose(from_standard_normal(tolerances, ndtri(u)), frame, rtol=1e-12)
    if tolerances.lot_size is None:
        pd.testing.assert_frame_equal(frame, sample(tolerances, 200, sampling="random", seed=4))


def test_far_scores_stay_finite():
    tolerances = Tolerances([dimension(d) for d in [Normal(truncated=False)]])
    values = from_standard_normal(tolerances, np.array([[-50.0], [50.0]]))["journal_radius"]
    assert np.isfinite(values).all()


# Lots


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


# Construction and errors


def test_ways_to_write_a_dimension():
    assert Dimension.symmetric("bearing_radius", 20e-3, 0.05e-3) == Dimension(
        "bearing_radius", 20e-3, 20e-3 - 0.05e-3, 20e-3 + 0.05e-3, Normal()
    )
    assert Dimension.from_deviations("journal_radius", 10e-3, -0.03e-3, 0).upper == 10e-3
    limits = Dimension.from_limits("half_length", 19e-3, 21e-3, distribution=Uniform())
    assert (limits.nominal, limits.distribution) == (pytest.approx(20e-3, rel=1e-15), Uniform())
    half_length = Dimension.from_tolerance_class("half_length", "40 h9")
    assert (half_length.lower, half_length.upper) == pytest.approx((19.969e-3, 20e-3), rel=1e-14)


def test_fit_gives_both_radii():
    bearing, journal = Dimension.from_fit("40 H7/d9", distribution=Triangular())
    assert (bearing.name, journal.name) == ("bearing_radius", "journal_radius")
    assert (bearing.lower, bearing.upper) == pytest.approx((20e-3, 20.0125e-3), rel=1e-14)
    assert (journal.lower, journal.upper) == pytest.approx((19.929e-3, 19.96e-3), rel=1e-14)
    assert bearing.nominal == pytest.approx(20.00625e-3, rel=1e-14)
    assert journal == Dimension.from_tolerance_class("journal_radius", "40 d9", distribution=Triangular())
    assert (bearing.toleranced_size, journal.toleranced_size) == ("40 H7", "40 d9")
    assert sample(Tolerances([bearing, journal]), 9, sampling="random", seed=0).shape == (9, 2)


def test_nominal_may_lie_outside_the_limits():
    d = Dimension.from_deviations("journal_radius", 20e-3, -71e-6, -40e-6)
    assert (d.nominal, d.mean) == (20e-3, pytest.approx(20e-3 - 55.5e-6, rel=1e-12))
    with pytest.raises(ValueError, match=r"mode = 0\.02.*Give a mode within"):
        replace(d, distribution=Triangular())


@pytest.mark.parametrize("tolerances", [*CASES.values(), Tolerances([dimension(UNBOUNDED["kernel"])])])
def test_tolerances_travel_to_other_processes(tolerances):
    copy = pickle.loads(pickle.dumps(tolerances))
    assert copy == tolerances
    args = {"sampling": "sobol", "seed": 1}
    pd.testing.assert_frame_equal(sample(copy, 20, **args), sample(tolerances, 20, **args), check_exact=True)
    assert hash(copy) == hash(tolerances)


def test_limits_can_be_replaced():
    narrow = replace(dimension(Normal(cpk=1.5)), lower=9.99e-3, upper=10.01e-3)
    assert narrow.sd == pytest.approx(0.02e-3 / 9, rel=1e-3)


@pytest.mark.parametrize(
    ("build", "says"),
    [
        (lambda: Dimension("radius", 1.0), ["'radius'", "bearing_radius"]),
        (lambda: Dimension("mass", math.nan), ["mass", "nan", "finite"]),
        (lambda: Dimension("mass", "heavy"), ["mass", "'heavy'", "number"]),
        (lambda: Dimension("mass", 1.0, 0.9), ["mass", "only one limit"]),
        (lambda: Dimension("mass", 1.0, 1.1, 0.9), ["mass", "1.1", "0.9", "exchange"]),
        (lambda: Dimension("mass", 1.0, 1.1, 1.1), ["mass", "1.1", "nominal = 1.0"]),
        (lambda: Dimension.symmetric("mass", 1.0, 1.5), ["mass", "-0.5", "> 0"]),
        (lambda: Dimension.symmetric("mass", 1.0, -0.1), ["mass", "-0.1", ">= 0"]),
        (lambda: Dimension("mass", 1.0, 0.9, 1.1, "normal"), ["mass", "'normal'", "tolmc.tolerances.distributions"]),
        (lambda: Dimension("mass", 1.0, 0.9, 1.1, lot_share=1.2), ["mass", "lot_share = 1.2", "0 to 1.0"]),
        (lambda: Dimension("mass", 1.0, 0.9, 1.1, lot_share=-0.1), ["mass", "lot_share = -0.1"]),
        (lambda: Dimension("mass", 1.0, 0.9, 1.1, lot_sd=0.2), ["mass", "lot_sd = 0.2", "0 to 0.03"]),
        (lambda: Dimension("mass", 1.0, 0.9, 1.1, lot_sd=0.01, lot_share=0.1), ["mass", "leave one out"]),
        (lambda: Dimension.from_tolerance_class("mass", "40 H7"), ["mass", "40 H7", "half_length"]),
        (
            lambda: replace(Dimension.from_tolerance_class("journal_radius", "40 d9"), upper=20e-3),
            ["journal_radius", "'40 d9'", "0.01996", "Leave toleranced_size out"],
        ),
        (lambda: Normal(cp=0), ["cp = 0", "> 0"]),
        (lambda: Normal(cp=1.0, cpk=1.2), ["cpk = 1.2", "cp = 1.0"]),
        (lambda: Normal(cp=1.0, cpk=0.9, mean=1.0), ["leave one out"]),
        (lambda: Normal(shift="up"), ["'up'", "upper, lower"]),
        (lambda: dimension(Normal(mean=11e-3)), ["journal_radius", "0.011", "0.0097", "0.0101"]),
        (lambda: dimension(Normal(mean=UPPER, cpk=1.0)), ["journal_radius", "strictly between"]),
        (lambda: dimension(Normal(cp=1e-3)), ["journal_radius", "100 times", "uniform"]),
        (lambda: dimension(Triangular(mode=9e-3)), ["journal_radius", "0.009", "mode within"]),
        (lambda: Beta(2.0, -1.0), ["beta = -1.0", "> 0"]),
        (lambda: Scipy("poisson", {"mu": 2}), ["'poisson'", "continuous"]),
        (lambda: Scipy("lognorm", {"scale": 1.0}), ["lognorm", "scale", "s, loc, scale"]),
        (lambda: Scipy("norm", {"sigma": 1.0}), ["norm", "sigma", "loc, scale"]),
        (lambda: Scipy("norm", {"scale": -1.0}), ["norm", "-1.0", "scipy.stats.norm"]),
        (
            lambda: dimension(Scipy("norm", {"loc": 10.0, "scale": 0.1}, truncated=True)),
            ["journal_radius", "norm", "SI units"],
        ),
        (lambda: Measured([1.0, math.nan]), ["2 values", "1 of them finite"]),
        (lambda: Measured([1.0, 1.0]), ["two different"]),
        (lambda: Measured([1.0, 2.0], method="histogram"), ["'histogram'", "bootstrap, kernel"]),
        (lambda: Measured([1.0, 2.0], bandwidth=-1.0), ["bandwidth = -1.0", "> 0"]),
        (lambda: Tolerances(["mass"]), ["'mass'", "Dimension"]),
        (lambda: Tolerances([dimension(), dimension()]), ["journal_radius", "twice"]),
        (lambda: Tolerances([dimension(lot_share=0.5)]), ["journal_radius", "lot_size"]),
        (lambda: Tolerances([dimension()], lot_size=0), ["lot_size = 0", "1 or more"]),
        (lambda: Tolerances([dimension()], lot_size=2.5), ["lot_size", "2.5", "whole"]),
        (lambda: joint(correlation=np.eye(3)), ["(3, 3)", "(4, 4)", "bearing_radius, half_length"]),
        (lambda: joint(correlation={("mass", "length"): 0.5}), ["mass and length", "journal_radius"]),
        (lambda: joint(correlation={("mass", "mass"): 0.5}), ["mass and mass", "different"]),
        (
            lambda: joint(correlation={("mass", "half_length"): 0.5, ("half_length", "mass"): 0.5}),
            ["half_length and mass", "once"],
        ),
        (lambda: joint(correlation={("mass", "half_length"): 1.5}), ["mass and half_length", "1.5", "-1 to 1"]),
        (lambda: joint(correlation=2 * np.eye(4)), ["bearing_radius with itself", "2.0"]),
        (
            lambda: joint(correlation=np.eye(4) + np.triu(np.full((4, 4), 0.1), 1)),
            ["bearing_radius and half_length", "0.1", "symmetric"],
        ),
    ],
)
def test_errors_name_object_value_and_remedy(build, says):
    with pytest.raises((ValueError, TypeError)) as error:
        build()
    assert all(word in str(error.value) for word in says), str(error.value)


def test_contradicting_correlations_name_the_pair_and_its_range():
    pairs = {
        ("bearing_radius", "mass"): 0.8,
        ("mass", "journal_radius"): 0.8,
        ("bearing_radius", "journal_radius"): -0.5,
    }
    with pytest.raises(ValueError, match="correlation of") as error:
        joint(correlation=pairs)
    # 0.8, 0.8 leaves 0.28 to 1; 0.8, -0.5 leaves -0.92 to 0.12.
    first, second, low, high = re.search(
        r"of (\w+) and (\w+) = .*allowed: (\S+) to (\S+) with", str(error.value)
    ).groups()
    for edge in (float(low), float(high)):
        joint(correlation=pairs | {(first, second): 0.999 * edge})
        if abs(edge) < 0.99:
            with pytest.raises(ValueError, match="contradicts"):
                joint(correlation=pairs | {(first, second): 1.001 * edge})
    with pytest.raises(ValueError, match="others contradict each other too"):
        joint(
            correlation=pairs
            | {("half_length", "mass"): 0.9, ("half_length", "bearing_radius"): -0.9}
            | {("half_length", "journal_radius"): 0.9}
        )


def test_lots_that_contradict_the_correlation_name_the_pair():
    names = ("bearing_radius", "journal_radius")
    dimensions = [
        Dimension.symmetric(name, 20e-3, 1e-4, lot_share=share) for name, share in zip(names, (1.0, 0), strict=True)
    ]
    with pytest.raises(ValueError, match=r"bearing_radius and journal_radius.*closer lot shares"):
        Tolerances(dimensions, {names: 0.5}, lot_size=10)
    Tolerances([replace(d, lot_share=0.8) for d in dimensions], {names: 0.5}, lot_size=10)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"sampling": "latin", "seed": 0}, ["'latin'", "latin_hypercube"]),
        ({"sampling": "random", "seed": -1}, ["seed = -1", "0 or more"]),
        ({"sampling": "random", "seed": 1.5}, ["seed", "1.5", "whole"]),
        ({"sampling": "random", "seed": 0, "start": -1}, ["start = -1"]),
        ({"sampling": "latin_hypercube", "seed": 0, "start": 5}, ["total", "row 5"]),
        ({"sampling": "latin_hypercube", "seed": 0, "start": 5, "total": 10}, ["15", "total = 10", "sobol"]),
    ],
)
def test_sampling_errors(options, says):
    with pytest.raises((ValueError, TypeError)) as error:
        sample(joint(), 10, **options)
    assert all(word in str(error.value) for word in says), str(error.value)


def test_coordinate_errors():
    with pytest.raises(ValueError, match=r"\(5, 2\).*\(n, 3\).*bearing_radius, mass, journal_radius"):
        from_unit(joint(), np.full((5, 2), 0.5))
    with pytest.raises(ValueError, match="unit cube"):
        from_unit(joint(), np.full((5, 3), 1.5))
    with pytest.raises(ValueError, match="unit cube"):
        from_unit(joint(), np.full((5, 3), np.nan))
    with pytest.raises(ValueError, match="finite"):
        from_standard_normal(joint(), np.full((5, 3), np.inf))
