"""Mean, spread and lots of truncated scipy.stats dimensions, against 10^6 of their own quantiles."""

import numpy as np
import pytest
from scipy import stats

from tolmc.tolerances.dimension import Dimension, Tolerances
from tolmc.tolerances.distributions import Scipy
from tolmc.tolerances.draw import sample

LOC, SCALE = 20.2e-3, 5e-6

# Their quantiles take up to seconds each, or scipy.stats has none that can be relied on.
SLOW = {
    "argus", "dpareto_lognorm", "exponnorm", "gausshyper", "genhyperbolic", "geninvgauss", "ksone", "kstwo", "landau",
    "levy_stable", "ncf", "nct", "norminvgauss", "studentized_range", "rel_breitwigner", "recipinvgauss", "vonmises",
    "foldcauchy", "foldnorm", "vonmises_line", "kappa4", "skewcauchy", "irwinhall",
    "normal_inverse_gamma", "skewnorm", "pearson3", "crystalball",
}  # fmt: skip


def shapes_of(name: str) -> dict[str, float] | None:
    """Shape parameters that the distribution accepts; None where we know none."""
    distribution = getattr(stats, name)
    names = distribution.shapes.split(", ") if distribution.shapes else []
    for start in (2.0,) if name == "erlang" else (2.5, 0.4):
        shapes = {shape: start + 0.7 * k for k, shape in enumerate(names)}
        if np.isfinite(distribution(**shapes).ppf([0.01, 0.5, 0.9])).all():
            return shapes
    return None


CONTINUOUS = sorted(n for n, d in vars(stats).items() if isinstance(d, stats.rv_continuous) and n not in SLOW)


def truncated(name: str, low: float, high: float) -> Dimension | None:
    """A radius that follows the distribution between two of its quantiles; at 0 and 1 the limits lie outside the support."""
    shapes = shapes_of(name)
    if shapes is None:
        return None
    unit = getattr(stats, name)(**shapes)
    support = unit.support()
    lower = unit.ppf(low) if low or not np.isfinite(support[0]) else support[0] - 30
    upper = unit.ppf(high) if high < 1 or not np.isfinite(support[1]) else support[1] + 30
    if not np.isfinite([lower, upper]).all():
        lower, upper = unit.ppf([0.001, 0.999])
    law = Scipy(name, {**shapes, "loc": LOC, "scale": SCALE}, truncated=True)
    return Dimension("center_of_mass_x", LOC, LOC + SCALE * lower, LOC + SCALE * upper, law)


@pytest.mark.nightly
@pytest.mark.parametrize("name", CONTINUOUS)
def test_moments_are_those_of_the_quantiles(name, low=0.0, high=0.9, count=1_000_000):
    dimension = truncated(name, low, high)
    if dimension is None:
        pytest.skip("no shape parameters known")
    quantiles = dimension.ppf((np.arange(count) + 0.5) / count)
    spread = quantiles.std()
    assert dimension.mean == pytest.approx(quantiles.mean(), abs=2e-4 * spread)
    assert dimension.sd == pytest.approx(spread, rel=2e-4)


@pytest.mark.parametrize(
    "name", ["halfnorm", "expon", "gamma", "weibull_min", "dweibull", "cauchy", "uniform", "loguniform"]
)
def test_moments_of_common_distributions(name):
    test_moments_are_those_of_the_quantiles(name, 0.0, 0.95, count=100_000)  # whose own are good to 4e-6


WORN = Scipy("halfnorm", {"loc": LOC, "scale": SCALE}, truncated=True)


@pytest.mark.parametrize("reach", [0.15e-3, 1.0e-3, 20e-3])
def test_limits_beyond_the_support_leave_mean_spread_and_lots(reach):
    """Half-normal wear of 5 um: mean loc + s sqrt(2/pi), sd s sqrt(1 - 2/pi), however far the limits are."""
    worn = Dimension("bearing_radius", LOC, LOC - reach, LOC + reach, WORN, lot_sd=2e-6)
    assert worn.mean == pytest.approx(LOC + SCALE * np.sqrt(2 / np.pi), rel=1e-12)
    assert worn.sd == pytest.approx(SCALE * np.sqrt(1 - 2 / np.pi), rel=1e-9)
    lots = sample(Tolerances([worn], lot_size=50), 100_000, sampling="random", seed=1).bearing_radius.to_numpy()
    within = worn.sd**2 * (1 - worn.between_lots) / 50
    between = np.sqrt(lots.reshape(-1, 50).mean(axis=1).var() - within)
    assert between == pytest.approx(2e-6, rel=0.05)


@pytest.mark.slow
def test_far_limits_of_a_distribution_that_scipy_integrates():
    """Normal-inverse Gaussian, mean b/sqrt(a^2 - b^2), variance a^2/(a^2 - b^2)^1.5; SciPy's own cdf(300) is 4e-12."""
    law = Scipy("norminvgauss", {"a": 1.0, "b": 0.9, "loc": LOC, "scale": SCALE}, truncated=True)
    dimension = Dimension("center_of_mass_x", LOC, LOC - 9 * SCALE, LOC + 300 * SCALE, law)
    assert dimension.mean == pytest.approx(LOC + SCALE * 0.9 / 0.19**0.5, rel=1e-9)
    assert dimension.sd == pytest.approx(SCALE * 0.19**-0.75, rel=1e-5)


@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e6])
@pytest.mark.parametrize("loc", [0.0, 1e3, -1e3])
def test_moments_scale_with_the_unit(unit, loc):
    """The same normal distribution cut at +-1 sd, in any unit and anywhere."""
    law = Scipy("norm", {"loc": loc * unit, "scale": unit}, truncated=True)
    dimension = Dimension("alpha", loc * unit, (loc - 1) * unit, (loc + 1) * unit, law)
    assert dimension.mean == pytest.approx(loc * unit, abs=1e-9 * unit)
    assert dimension.sd == pytest.approx(0.5395604 * unit, rel=1e-6)


def test_a_distribution_without_a_standard_deviation_has_no_lot_sd():
    with pytest.raises(ValueError, match=r"no standard deviation; give lot_share"):
        Dimension("alpha", 1.0, distribution=Scipy("cauchy", {"loc": 1.0, "scale": 0.01}), lot_sd=0.01)
