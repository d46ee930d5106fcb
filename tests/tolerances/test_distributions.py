"""Distributions against SciPy's, their tails and moments, measured values."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats
from scipy.special import ndtr, ndtri
from tolerance_cases import ALL, DATA, LOWER, MIDDLE, NOMINAL, UPPER, WIDTH, dimension

from tolmc.tolerances.dimension import Dimension, Tolerances
from tolmc.tolerances.distributions import Beta, Measured, Normal, Scipy, Triangular, Uniform
from tolmc.tolerances.draw import from_standard_normal, sample


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
