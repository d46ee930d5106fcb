import itertools
import math
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from tolmc.statistics.intervals import binomial_interval, signed_rank_interval
from tolmc.statistics.observations import Observations
from tolmc.statistics.order_statistics import OrderStatistics
from tolmc.statistics.rows import Rows
from tolmc.tolerances.unit_cube import SCRAMBLINGS, cube_points


def test_random_mean_is_students_interval():
    x = np.random.default_rng(1).gamma(2.0, size=40)
    expected = stats.t.interval(0.95, 39, x.mean(), stats.sem(x))
    assert Observations(x).mean() == pytest.approx((x.mean(), *expected), rel=1e-12)


def test_rows_that_are_not_used_change_nothing():
    x = np.random.default_rng(2).normal(size=50)
    gaps = np.full(150, np.nan)
    gaps[::3] = x
    bare, gapped = Observations(x), Observations(gaps)
    assert gapped.count == 50
    for estimate in ("mean", "sd", "minimum", "maximum"):
        assert getattr(gapped, estimate)() == pytest.approx(getattr(bare, estimate)(), rel=1e-12)
    assert gapped.quantile(0.4) == bare.quantile(0.4)


@pytest.mark.parametrize("draw", [stats.norm, stats.uniform, stats.expon], ids=lambda d: d.name)
def test_sd_interval_covers_without_normality(draw):
    x = draw.rvs(size=(2000, 300), random_state=3)
    covered = [e.low <= draw.std() <= e.high for e in (Observations(row).sd() for row in x)]
    assert np.mean(covered) == pytest.approx(0.945, abs=0.015)


def test_signed_rank_levels_by_enumeration():
    # All 2^8 sign patterns of 8 numbers are equally likely under symmetry about zero.
    sizes = np.array([0.3, 0.7, 1.1, 1.9, 2.3, 3.1, 4.3, 5.9])
    covered = []
    for signs in itertools.product((-1, 1), repeat=8):
        low, high = signed_rank_interval(sizes * signs, 1 - 2 * 5 / 256)
        covered.append(low <= 0 <= high)
    assert sum(covered) == 256 - 2 * 5  # P(W <= 3) = 5/256


def test_signed_rank_interval_keeps_its_level_for_long_tails():
    x = stats.t.rvs(1.5, size=(8000, SCRAMBLINGS), random_state=4)
    covered = np.mean([low <= 0 <= high for low, high in (signed_rank_interval(row, 0.95) for row in x)])
    assert covered == pytest.approx(0.95, abs=0.006)


def test_few_values_give_no_bound():
    assert signed_rank_interval(np.array([1.0, 2.0, 3.0]), 0.95) == (-math.inf, math.inf)
    assert Observations(np.array([1.0])).mean() == (1.0, -math.inf, math.inf)
    assert Observations(np.array([1.0])).sd()[1:] == (0.0, math.inf)
    empty = Observations(np.array([np.nan]))
    assert math.isnan(empty.mean().value)
    assert empty.quantile(0.5)[1:] == (-math.inf, math.inf)


@pytest.mark.parametrize("count,events", [(10, 0), (10, 3), (400, 399), (400, 400)])
def test_exact_share_is_clopper_pearson(count, events):
    expected = stats.binomtest(events, count).proportion_ci(0.9, "exact")
    assert binomial_interval(events, count, confidence=0.9) == pytest.approx(expected, abs=1e-12)


def test_share_of_rows_that_count():
    events = np.array([True, False, True, False, True])
    known = np.array([True, True, True, True, False])
    assert Rows().share(events, known=known) == (0.5, *binomial_interval(2, 4))
    assert Rows().share(events, known=np.zeros(5, bool))[1:] == (0.0, 1.0)


@pytest.mark.parametrize("method,least", [("exact", 0.95), ("jeffreys", 0.92)])
def test_share_interval_covers(method, least):
    count = 300
    bounds = np.array([binomial_interval(k, count, method=method) for k in range(count + 1)])
    coverage = [
        stats.binom.pmf(np.arange(count + 1), count, p)[(bounds[:, 0] <= p) & (p <= bounds[:, 1])].sum()
        for p in np.linspace(0.02, 0.5, 200)
    ]
    assert min(coverage) >= least
    assert np.mean(coverage) == pytest.approx(0.95, abs=0.001 if method == "jeffreys" else 0.01)


@given(st.integers(1, 300), st.floats(0.001, 0.999))
def test_quantile_interval_holds_its_estimate(count, level):
    x = np.random.default_rng(count).normal(size=count)
    value, low, high = Observations(x).quantile(level)
    assert value == pytest.approx(np.quantile(x, level), abs=1e-12)
    assert low <= value <= high


@cache
def large_samples():
    rng = np.random.default_rng(9)
    normal = rng.normal(size=200_000)
    return {
        "normal": normal,
        "ascending": np.sort(normal),
        "long tails": rng.standard_cauchy(200_000),
        "few values": rng.integers(0, 3, 200_000).astype(float),
        "one value": np.full(200_000, 0.1),
        "infinite": np.where(normal > 2, np.inf, np.where(normal < -2, -np.inf, normal)),
        # The part of the sample that says where to look holds nothing of what the rest is like.
        "misleading": np.where(np.arange(200_000) % (200_000 // 2**14 | 1) == 0, 10.0, normal),
    }


@pytest.mark.parametrize(
    "name", ["normal", "ascending", "long tails", "few values", "one value", "infinite", "misleading"]
)
def test_order_statistics_of_large_samples_are_those_of_a_sort(name):
    values = large_samples()[name]
    sample, ordered = OrderStatistics(values), np.sort(values)
    for first, last in ((0, 0), (250, 290), (9_900, 10_100), (99_000, 101_000), (199_700, 199_999), (60_000, 140_000)):
        start, window = sample.place(first, last)
        np.testing.assert_array_equal(window[first - start : last - start + 1], ordered[first : last + 1])
    for rank in np.random.default_rng(10).integers(0, len(values), 50):
        assert sample[int(rank)] == ordered[rank]


def test_large_samples_are_not_sorted_whole():
    values = np.random.default_rng(11).normal(size=1_000_000)
    assert len(OrderStatistics(values).place(498_000, 502_000)[1]) < 100_000


@pytest.mark.parametrize("count", [3, 16, 47, 5_000, 70_001])
def test_sums_of_groups_are_those_of_their_rows(count):
    values = np.random.default_rng(12).normal(size=count)
    for rows, group in (
        (Rows("sobol"), np.arange(count) % SCRAMBLINGS),
        (Rows(lot_size=5), np.arange(count) // 5),
        (Rows(), np.arange(count)),
    ):
        np.testing.assert_allclose(rows.group_sums(values), np.bincount(group, values), rtol=1e-12, atol=1e-12)
        np.testing.assert_array_equal(rows.group_sums(values > 0), np.bincount(group, values > 0))
        np.testing.assert_array_equal(rows.group_counts(None, count), np.bincount(group))
        np.testing.assert_array_equal(rows.group_counts(values > 0, count), np.bincount(group, values > 0))


def test_trimmed_kurtosis_is_that_of_the_sorted_middle():
    x = np.random.default_rng(13).standard_t(5, size=90_000)
    n, z = len(x), stats.norm.ppf(0.975)
    middle = np.sort(x)[(trimmed := int(n / (2 * math.sqrt(n - 4)))) : n - trimmed].mean()
    kurtosis = n * np.sum((x - middle) ** 4) / np.sum((x - x.mean()) ** 2) ** 2
    half_width = z * n / (n - z) * math.sqrt((kurtosis - (n - 3) / n) / (n - 1))  # Bonett (2006), of log s^2
    s = x.std(ddof=1)
    expected = [s, *(s * math.sqrt(n / (n - z)) * math.exp(side * 0.5 * half_width) for side in (-1, 1))]
    assert Observations(x).sd() == pytest.approx(expected, rel=1e-12)


def test_quantile_bounds_are_order_statistics():
    # n = 10, median: P(X_(2) <= m <= X_(9)) = 1 - 2 P(B(10, 1/2) <= 1) = 0.978515625, without interpolation.
    x = np.arange(1.0, 11.0)
    estimate = Observations(x, Rows(confidence=0.978515625)).quantile(0.5)
    assert estimate == pytest.approx((5.5, 2.0, 9.0), abs=1e-6)


def test_extreme_quantile_of_a_small_sample_has_no_outer_bound():
    x = np.random.default_rng(5).normal(size=2000)
    assert Observations(x).quantile(0.99865).high == math.inf
    assert math.isfinite(Observations(x).quantile(0.99865).low)
    assert Observations(x).quantile(0.00135).low == -math.inf
    # 1 - 0.99865^n >= 0.975 from n = 2731 on.
    assert math.isfinite(Observations(np.arange(2731.0)).quantile(0.99865).high)
    assert Observations(np.arange(2729.0)).quantile(0.99865).high == math.inf


def test_extremes_are_bounded_on_the_inside_only():
    seen = Observations(np.array([3.0, 1.0, 2.0]))
    assert seen.minimum() == (1.0, -math.inf, 1.0)
    assert seen.maximum() == (3.0, 3.0, math.inf)


def test_sobol_interval_comes_from_the_scramblings():
    x = np.random.default_rng(6).normal(size=(50, SCRAMBLINGS)) + np.arange(SCRAMBLINGS)
    estimate = Observations(x.ravel(), Rows("sobol")).mean()
    low, high = signed_rank_interval(x.mean(axis=0), 0.95)
    assert estimate == pytest.approx((x.mean(), low, high), rel=1e-12)
    assert estimate.high - estimate.low > 5 * np.diff(Observations(x.ravel()).mean()[1:])


def test_sobol_rows_may_end_within_a_round_and_have_gaps():
    u = cube_points(1, 1000, sampling="sobol", seed=7)[:, 0]
    u[u < 0.2] = np.nan
    mean = Observations(u, Rows("sobol")).mean()
    assert mean.low < 0.6 < mean.high
    assert mean.high - mean.low < 0.01


def test_sobol_share_is_narrower_than_a_random_one_and_never_of_no_width():
    u = cube_points(2, 4096, sampling="sobol", seed=8)
    events = u.sum(axis=1) < 0.5
    by_net, by_chance = (Rows(kind).share(events) for kind in ("sobol", "random"))
    assert by_net.low < 0.125 < by_net.high
    assert by_net.high - by_net.low < 0.4 * (by_chance.high - by_chance.low)
    exact_in_every_net = Rows("sobol").share(u[:, 0] < 0.25)
    assert exact_in_every_net.low < 0.25 < exact_in_every_net.high
    none = Rows("sobol").share(np.zeros(4096, bool))
    assert none == Rows("random").share(np.zeros(4096, bool))


def test_smooth_estimates_of_few_scramblings_have_no_bound():
    assert Observations(np.arange(4.0), Rows("sobol")).mean()[1:] == (-math.inf, math.inf)


def test_intervals_of_rows_in_lots_cover():
    # Half of the variance is between lots of 20: independent-row intervals are about three times too narrow.
    rng = np.random.default_rng(9)
    lots = np.sqrt(0.5) * rng.normal(size=(1500, 50, 1))
    x = (lots + np.sqrt(0.5) * rng.normal(size=(1500, 50, 20))).reshape(1500, -1)
    rows, naive = Rows(lot_size=20), Rows()
    truth = {"mean": 0.0, "sd": 1.0, "quantile": stats.norm.ppf(0.9), "share": 0.2}

    def estimates(row, rows):
        seen = Observations(row, rows)
        return {
            "mean": seen.mean(),
            "sd": seen.sd(),
            "quantile": seen.quantile(0.9),
            "share": rows.share(row > stats.norm.ppf(0.8)),
        }

    covered = [{k: e.low <= truth[k] <= e.high for k, e in estimates(row, rows).items()} for row in x]
    for name in truth:
        assert np.mean([c[name] for c in covered]) == pytest.approx(0.95, abs=0.025), name
    by_rows = [estimates(row, naive)["mean"] for row in x[:300]]
    assert np.mean([e.low <= 0 <= e.high for e in by_rows]) < 0.7


def test_few_lots_bound_no_outer_quantile():
    x = np.repeat(np.random.default_rng(13).normal(size=30), 100)
    seen = Observations(x, Rows(lot_size=100))
    assert math.isfinite(seen.quantile(0.5).low)
    assert seen.quantile(0.02).low == -math.inf
    assert Observations(x).quantile(0.02).low > -math.inf


def test_lots_without_any_event_count_once_each():
    assert Rows(lot_size=10).share(np.zeros(95, bool)).high == binomial_interval(0, 10)[1]


@pytest.mark.parametrize(
    "arguments,named",
    [({"sampling": "grid"}, "grid"), ({"confidence": 95}, "95"), ({"lot_size": 0}, "lot_size = 0")],
)
def test_unusable_rows_are_refused(arguments, named):
    with pytest.raises(ValueError, match=named):
        Rows(**arguments)


def test_unusable_counts_are_refused():
    with pytest.raises(ValueError, match="events = 11"):
        binomial_interval(11, 10)
    with pytest.raises(ValueError, match="wald"):
        binomial_interval(1, 10, method="wald")
