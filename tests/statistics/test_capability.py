import math

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from tolmc.statistics.capability import ALL_REQUIREMENTS, capability, cpk_from_ppm, ppm_from_cpk
from tolmc.statistics.intervals import Estimate, binomial_interval
from tolmc.statistics.looks import Looks, sample_until
from tolmc.statistics.observations import Observations
from tolmc.statistics.rows import Rows
from tolmc.statistics.tolerance_intervals import tolerance_interval, wilks_sample_size
from tolmc.tolerances.unit_cube import cube_points


def test_cpk_to_parts_per_million():
    assert ppm_from_cpk([1.0, 1.33]) == pytest.approx([2699.80, 66.07], abs=0.005)
    assert ppm_from_cpk(1.0, sides=1) == pytest.approx(1349.90, abs=0.005)
    assert cpk_from_ppm(ppm_from_cpk(np.linspace(0.1, 2, 20))) == pytest.approx(np.linspace(0.1, 2, 20))


@pytest.mark.parametrize(
    "share,confidence,sides,rank,expected",
    [
        (0.95, 0.95, 1, 1, 59),
        (0.95, 0.95, 2, 1, 93),
        (0.99, 0.95, 2, 1, 473),
        (0.99, 0.95, 1, 1, 299),
        (0.95, 0.95, 1, 2, 93),
        (0.95, 0.95, 1, 3, 124),
    ],
)
def test_wilks_sample_sizes(share, confidence, sides, rank, expected):
    assert wilks_sample_size(share, confidence, sides=sides, rank=rank) == expected


def test_tolerance_interval_begins_at_the_sample_size_of_wilks():
    x = np.random.default_rng(1).normal(size=93)
    assert tolerance_interval(x) == (x.min(), x.max())
    assert tolerance_interval(x[:92]) == (-math.inf, math.inf)
    assert tolerance_interval(x[:59], sides="upper") == (-math.inf, x[:59].max())
    assert tolerance_interval(x[:59], sides="lower") == (x[:59].min(), math.inf)
    # 181 allow the second extremes: P(B(181, 0.05) >= 4) = 0.9506.
    ordered = np.sort(np.random.default_rng(2).normal(size=181))
    assert tolerance_interval(ordered) == (ordered[1], ordered[-2])


@pytest.mark.parametrize("sides", ["both", "upper"])
def test_tolerance_intervals_hold_their_confidence(sides):
    x = np.random.default_rng(3).normal(size=(2000, 600))
    enclosed = [np.diff(stats.norm.cdf(tolerance_interval(row, share=0.9, sides=sides))) >= 0.9 for row in x]
    assert 0.95 - 0.01 <= np.mean(enclosed) <= 0.975


def test_tolerance_intervals_of_sobol_rows_hold_their_confidence():
    enclosed = []
    for seed in range(150):
        x = stats.norm.ppf(cube_points(2, 1024, sampling="sobol", seed=seed)).sum(axis=1) / math.sqrt(2)
        bounds = tolerance_interval(x, share=0.9, sides="upper", sampling="sobol")
        enclosed.append(stats.norm.cdf(bounds.high) >= 0.9)
    assert np.mean(enclosed) >= 0.92


def normal_samples(rng, count, mean=0.0):
    return pd.DataFrame({"tilt_max": rng.normal(mean, 1.0, count), "status": "ok"})


def test_indices_of_a_normal_output():
    samples = normal_samples(np.random.default_rng(4), 200_000, mean=0.5)
    specification = {"tilt_max": {"min": -3.0, "max": 3.5}}
    row = capability(samples, specification=specification).loc["tilt_max"]
    for name, truth in (("Cp", 6.5 / 6), ("Cpk", 1.0), ("Pp", 6.5 / 6), ("Ppk", 1.0)):
        assert row[f"{name}_low"] < truth < row[f"{name}_high"]
        assert row[f"{name}_high"] - row[f"{name}_low"] < 0.01
    out = 1e6 * (stats.norm.cdf(-3.5) + stats.norm.sf(3.0))
    assert row["ppm_if_normal"] == pytest.approx(out, rel=0.05)
    assert row["ppm_low"] < out < row["ppm_high"]
    assert row["yield"] == pytest.approx(1 - row["ppm"] * 1e-6, abs=1e-12)


@pytest.mark.parametrize("mean", [0.0, 0.7])
def test_index_intervals_cover(mean):
    studies = [f"study {k}" for k in range(1000)]
    samples = pd.DataFrame(np.random.default_rng(5).normal(mean, 1.0, (300, 1000)), columns=studies)
    table = capability(samples, specification={name: {"min": -4.0, "max": 4.0} for name in studies}).loc[studies]
    for name, truth in (("Pp", 4 / 3), ("Ppk", (4 - mean) / 3)):
        covered = (table[f"{name}_low"] <= truth) & (truth <= table[f"{name}_high"])
        assert covered.mean() == pytest.approx(0.95, abs=0.02), name


def test_lots_set_cp_apart_from_pp():
    rng = np.random.default_rng(6)
    values = rng.normal(0.0, 0.3, (2000, 10)) + rng.normal(0.0, 0.4, (2000, 1))
    samples = pd.DataFrame({"tilt_max": values.ravel()})
    row = capability(samples, specification={"tilt_max": {"min": -1.5, "max": 1.5}}, lot_size=10).loc["tilt_max"]
    assert row["Cp_low"] < 1.5 / 0.9 < row["Cp_high"]
    assert row["Pp_low"] < 1.5 / 1.5 < row["Pp_high"]
    assert row["Cpk_low"] < 1.5 / 0.9 < row["Cpk_high"]


def test_indices_need_their_limits_and_some_spread():
    samples = normal_samples(np.random.default_rng(7), 500).assign(tilt_angle=0.4)
    table = capability(samples, specification={"tilt_max": {"max": 3.0}, "tilt_angle": {"min": 0.0, "max": 1.0}})
    assert table.loc["tilt_max", ["Cp", "Pp"]].isna().all()
    assert table.loc["tilt_max", "Ppk"] == pytest.approx(
        (3 - samples["tilt_max"].mean()) / (3 * samples["tilt_max"].std())
    )
    assert table.loc["tilt_angle", ["Cp", "Cpk", "ppm_if_normal"]].isna().all()
    assert table.loc["tilt_angle", "yield"] == 1.0


def test_yield_is_joint_and_bounded_by_failed_samples():
    samples = pd.DataFrame(
        {
            "a": np.r_[np.zeros(80), np.ones(10), np.full(10, np.nan)],
            "b": np.r_[np.ones(5), np.zeros(85), np.full(10, np.nan)],
            "status": ["ok"] * 90 + ["diverged"] * 10,
        }
    )
    table = capability(samples, specification={"a": {"max": 0.5}, "b": {"max": 0.5}})
    assert table["yield"].to_dict() == pytest.approx({"a": 0.8, "b": 0.85, ALL_REQUIREMENTS: 0.75})
    row = table.loc[ALL_REQUIREMENTS]
    assert row["yield_low"] == pytest.approx(1 - binomial_interval(25, 100)[1])
    assert row["yield_high"] == pytest.approx(1 - binomial_interval(15, 100)[0])
    assert row["ppm_high"] == pytest.approx(1e6 * (1 - row["yield_low"]))
    assert math.isnan(row["Cpk"])


def test_samples_that_lost_contact_are_not_known_to_be_in():
    statuses = ["ok"] * 5 + ["contact lost"] * 5
    samples = pd.DataFrame({"tilt_max": np.linspace(0.0, 0.9, 10), "tilt_angle": 0.5, "status": statuses})
    specification = {"tilt_max": {"max": 1.0}, "tilt_angle": {"max": 1.0}}
    table = capability(samples, specification=specification)
    assert table["yield"].to_dict() == {"tilt_max": 0.5, "tilt_angle": 1.0, ALL_REQUIREMENTS: 0.5}
    assert table.loc["tilt_max", ["yield_low", "yield_high"]].tolist() == [1 - binomial_interval(5, 10)[1], 1.0]
    first = capability(samples[:5], specification={"tilt_max": {"max": 1.0}})
    assert table.at["tilt_max", "Ppk"] == pytest.approx(first.at["tilt_max", "Ppk"])
    chosen = capability(samples, specification=specification, on_contact_loss="continue")
    assert (chosen["yield"] == 1.0).all()


def test_looks_grow_to_the_largest_size():
    looks = Looks(100, 1000, growth=3.0, confidence=0.9)
    assert looks.sizes == (100, 300, 900, 1000)
    assert looks.look_confidence == pytest.approx(0.975)


def sequential_coverage(look_confidence=None):
    """Share of sequential studies of a standard normal output whose final interval contains its mean."""
    rng, looks = np.random.default_rng(8), Looks(5, 200, growth=1.5)
    covered = []
    for _ in range(2000):
        x = rng.normal(size=looks.largest)
        found = sample_until(
            lambda count, x=x: x[:count],
            lambda x, c: Observations(x, Rows(confidence=look_confidence or c)).mean(),
            width=1.0,
            looks=looks,
        )
        covered.append(found.estimate.low <= 0 <= found.estimate.high)
    return np.mean(covered)


def test_sequential_intervals_hold_their_level():
    assert sequential_coverage() >= 0.95
    # 95 % intervals at every look stop at samples that scatter too little by chance.
    assert sequential_coverage(0.95) < 0.935


@pytest.mark.slow
def test_sequential_sobol_means_hold_their_level_and_stop_early():
    looks = Looks(256, 4096)
    found = [
        sample_until(
            lambda count, seed=seed: cube_points(2, count, sampling="sobol", seed=seed).prod(axis=1),
            lambda x, confidence: Observations(x, Rows("sobol", confidence)).mean(),
            width=5e-4,
            looks=looks,
        )
        for seed in range(60)
    ]
    assert all(f.reached and f.estimate.high - f.estimate.low <= 5e-4 for f in found)
    assert np.mean([f.estimate.low <= 0.25 <= f.estimate.high for f in found]) >= 0.95
    assert np.median([f.count for f in found]) < looks.largest


def test_a_sequential_run_that_falls_short_says_so():
    x = np.random.default_rng(9).normal(size=400)
    found = sample_until(
        lambda count: x[:count],
        lambda x, c: Observations(x, Rows(confidence=c)).mean(),
        width=1e-6,
        looks=Looks(100, 400),
    )
    assert (found.count, found.reached) == (400, False)
    assert isinstance(found.estimate, Estimate)


@pytest.mark.parametrize(
    "call,named",
    [
        (lambda: wilks_sample_size(1.0, 0.95), "share = 1.0"),
        (lambda: wilks_sample_size(0.9, 95), "confidence = 95"),
        (lambda: wilks_sample_size(0.9, 0.9, sides=3), "sides = 3"),
        (lambda: tolerance_interval([1.0], sides="left"), "'left'"),
        (lambda: Looks(100, 50), "start = 100"),
        (lambda: Looks(100, 500, growth=1.0), "growth = 1.0"),
        (lambda: sample_until(None, None, width=0.0, looks=Looks(10, 20)), "width = 0.0"),
    ],
)
def test_unusable_arguments_are_named(call, named):
    with pytest.raises(ValueError, match=named):
        call()


@pytest.mark.parametrize("value", [0.00996, 1.0, -7.3, 0.0, 1e9])
@pytest.mark.parametrize("noise", [0.0, 1e-15])
def test_a_constant_output_has_no_indices(value, noise):
    values = value * (1 + noise * np.random.default_rng(1).standard_normal(1000))
    frame = pd.DataFrame({"tilt_angle": values})
    row = capability(frame, specification={"tilt_angle": {"min": -1e10, "max": 1e10}}).loc["tilt_angle"]
    assert row["is_constant"]
    assert row[["Cp", "Cpk", "Pp", "Ppk", "ppm_if_normal"]].isna().all()
    assert row["yield"] == 1


def test_what_varies_only_between_lots_has_no_index_within_them():
    values = np.repeat(np.random.default_rng(2).normal(1.0, 0.1, 50), 20)
    row = capability(
        pd.DataFrame({"tilt_angle": values}), specification={"tilt_angle": {"max": 2.0}}, lot_size=20
    ).iloc[0]
    assert np.isnan(row["Cpk"]) and row["Ppk"] == pytest.approx(3.3, rel=0.3) and not row["is_constant"]
