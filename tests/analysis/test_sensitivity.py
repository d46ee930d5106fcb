import numpy as np
import pandas as pd
import pytest
from scipy import stats

from tolmc.analysis.failure_sources import failure_sources
from tolmc.analysis.from_samples import contributions, first_order, rank_correlation
from tolmc.analysis.linear import linearise
from tolmc.analysis.one_at_a_time import one_at_a_time
from tolmc.analysis.sobol import sobol_indices
from tolmc.statistics.outcomes import ANY_REQUIREMENT, CONTACT_LOSS
from tolmc.tolerances.dimension import Dimension, Tolerances
from tolmc.tolerances.distributions import Normal, Uniform
from tolmc.tolerances.draw import sample

NAMES = ("alpha", "beta", "spin")
CUBE = Tolerances(tuple(Dimension(name, 0.0, -np.pi, np.pi, Uniform()) for name in NAMES))


def ishigami(inputs):
    """sin x1 + 7 sin^2 x2 + 0.1 x3^4 sin x1 (Ishigami & Homma 1990)."""
    x1, x2, x3 = (inputs[name].to_numpy() for name in NAMES)
    return pd.DataFrame({"y": np.sin(x1) + 7 * np.sin(x2) ** 2 + 0.1 * x3**4 * np.sin(x1)})


def known_indices():
    v1 = 0.5 * (1 + 0.1 * np.pi**4 / 5) ** 2
    v2 = 7**2 / 8
    v13 = 0.1**2 * np.pi**8 * (1 / 18 - 1 / 50)
    total = v1 + v2 + v13
    return {
        "first": np.array([v1, v2, 0.0]) / total,
        "total": np.array([v1 + v13, v2, v13]) / total,
    }


def test_known_indices_of_ishigami():
    assert known_indices()["first"] == pytest.approx([0.3139, 0.4424, 0.0], abs=1e-4)
    assert known_indices()["total"] == pytest.approx([0.5576, 0.4424, 0.2437], abs=1e-4)


def test_sobol_indices_of_ishigami():
    found = sobol_indices(ishigami, CUBE, outputs=["y"], count=8192, seed=2).loc["y"]
    for kind, truth in known_indices().items():
        assert found[kind].to_numpy() == pytest.approx(truth, abs=0.01)
        assert (found[f"{kind}_low"] <= truth).all()
        assert (truth <= found[f"{kind}_high"]).all()
        assert (found[f"{kind}_high"] - found[f"{kind}_low"] < 0.08).all()
    assert found.index.tolist() == list(NAMES)


def test_bootstrap_intervals_hold_at_least_their_level():
    truth = known_indices()
    covered = []
    for seed in range(60):
        found = sobol_indices(ishigami, CUBE, outputs=["y"], count=256, seed=seed, resamples=300).loc["y"]
        covered.append([(found[f"{k}_low"] <= t) & (t <= found[f"{k}_high"]) for k, t in truth.items()])
    assert (np.mean(covered, axis=0) >= 0.9).all()


def test_failed_evaluations_leave_their_rows_out():
    def fails(inputs):
        outputs = ishigami(inputs)
        return outputs.assign(z=outputs["y"].where(inputs["beta"] < 3.0))

    found = sobol_indices(fails, CUBE, outputs=["y", "z"], count=512)
    assert found.loc[("y", "alpha"), "used"] == 512
    assert 400 < found.loc[("z", "alpha"), "used"] < 512


def test_outputs_that_do_not_vary_have_no_indices():
    found = sobol_indices(lambda x: ishigami(x).assign(y=1.0), CUBE, outputs=["y"], count=64)
    assert found[["first", "total_high"]].isna().all(axis=None)


def test_without_tolerances_the_tables_are_empty():
    fixed = Tolerances(tuple(Dimension(name, 0.5) for name in NAMES))
    indices = sobol_indices(ishigami, fixed, outputs=["y"])
    assert indices.empty
    assert list(indices.columns[:3]) == ["first", "first_low", "first_high"]
    samples = drawn(64, "random", 1, tolerances=fixed)
    for table in (first_order, rank_correlation):
        assert table(samples, inputs=NAMES, outputs=["y"]).empty
    assert failure_sources(samples, inputs=NAMES).empty


def test_correlated_dimensions_are_refused():
    tolerances = Tolerances(CUBE.dimensions, correlation={("alpha", "beta"): 0.5})
    with pytest.raises(ValueError, match="use first_order"):
        sobol_indices(ishigami, tolerances, outputs=["y"])


def drawn(count, sampling, seed, tolerances=CUBE, model=ishigami):
    inputs = sample(tolerances, count, sampling=sampling, seed=seed, total=count)
    return pd.concat([inputs, model(inputs)], axis=1)


@pytest.mark.parametrize("sampling", ["random", "sobol"])
def test_first_order_indices_of_ishigami_from_a_sample(sampling):
    found = first_order(drawn(2**15, sampling, 3), inputs=NAMES, outputs=["y"], sampling=sampling).loc["y"]
    assert found["first"].to_numpy() == pytest.approx(known_indices()["first"], abs=0.015)


@pytest.mark.slow
@pytest.mark.parametrize("sampling", ["random", "sobol"])
def test_given_data_intervals_cover(sampling):
    def model(inputs):
        return pd.DataFrame({"y": inputs["alpha"] + 0.5 * inputs["beta"] + 0.2 * inputs["spin"]})

    truth = np.array([1, 0.25, 0.04]) / 1.29
    samples = [drawn(2048, sampling, seed, model=model) for seed in range(120)]
    rho = drawn(2**19, "sobol", 999, model=model)[[*NAMES, "y"]].corr("spearman")["y"].to_numpy()[:3]
    ranked = [rank_correlation(s, inputs=NAMES, outputs=["y"], sampling=sampling) for s in samples]
    covered = [(r["correlation_low"] <= rho) & (rho <= r["correlation_high"]) for r in ranked]
    assert np.mean(covered, axis=0) == pytest.approx(0.95, abs=0.05)
    shares = [first_order(s, inputs=NAMES, outputs=["y"], sampling=sampling) for s in samples]
    covered = [(f["first_low"] <= truth) & (truth <= f["first_high"]) for f in shares]
    assert (np.mean(covered, axis=0) >= 0.91).all()


def test_variation_in_one_group_alone_has_no_interval():
    samples = pd.DataFrame({"alpha": np.linspace(0, 1, 160), "y": np.arange(160.0) == 48})
    found = first_order(samples, inputs=["alpha"], outputs=["y"]).iloc[0]
    assert (found["first_low"], found["first_high"]) == (-np.inf, np.inf)


def test_rank_correlation_is_spearmans():
    samples = drawn(3000, "random", 4)
    samples.loc[::7, "y"] = np.nan
    found = rank_correlation(samples, inputs=NAMES, outputs=["y"]).loc["y"]
    used = samples.dropna()
    for name in NAMES:
        assert found.at[name, "correlation"] == pytest.approx(stats.spearmanr(used[name], used["y"]).statistic)
    assert (found["used"] == len(used)).all()


def test_a_monotone_output_has_rank_correlation_one():
    samples = drawn(500, "random", 5, model=lambda x: pd.DataFrame({"y": np.exp(x["alpha"]), "z": -x["alpha"]}))
    found = rank_correlation(samples, inputs=NAMES, outputs=["y", "z"])["correlation"]
    assert found["y", "alpha"] == pytest.approx(1.0)
    assert found["z", "alpha"] == pytest.approx(-1.0)


def test_failed_samples_and_fixed_dimensions_are_left_out():
    samples = drawn(1000, "random", 6).assign(mass=1.0, status="ok")
    samples.loc[:99, ["y", "status"]] = 1e9, "diverged"
    for table in (rank_correlation, first_order):
        found = table(samples, inputs=[*NAMES, "mass"], outputs=["y"]).loc["y"]
        assert found.index.tolist() == list(NAMES)
        assert (found["used"] == 900).all()
        clean = table(samples[100:], inputs=NAMES, outputs=["y"]).loc["y"]
        pd.testing.assert_frame_equal(found, clean)


def test_outputs_without_variation_have_no_given_data_indices():
    samples = drawn(300, "random", 7).assign(y=2.0, never=np.nan)
    for table in (rank_correlation, first_order):
        assert table(samples, inputs=NAMES, outputs=["y", "never"]).iloc[:, :3].isna().all(axis=None)


def test_contributions_are_percents_with_the_interactions():
    table = contributions(sobol_indices(ishigami, CUBE, outputs=["y"], count=8192)).loc["y"]
    assert table[list(NAMES)].to_numpy() == pytest.approx(100 * known_indices()["first"], abs=1)
    assert table["interactions"] == pytest.approx(24.37, abs=2)
    assert table.sum() == pytest.approx(100)


def test_contributions_of_a_linear_model_are_those_of_its_tangent():
    tolerances = Tolerances(
        tuple(Dimension(name, 0.0, -w, w, Normal()) for name, w in zip(NAMES, (1, 2, 3), strict=True))
    )

    def model(inputs):
        return pd.DataFrame({"y": inputs[list(NAMES)].sum(axis=1)})

    tangent = linearise(model, tolerances, outputs=["y"]).contributions().loc["y"]
    assert tangent.to_numpy() == pytest.approx(100 * np.array([1, 4, 9]) / 14)
    sampled = contributions(sobol_indices(model, tolerances, outputs=["y"], count=4096)).loc["y"]
    assert sampled[list(NAMES)].to_numpy() == pytest.approx(tangent.to_numpy(), abs=0.5)


def test_one_at_a_time_moves_one_dimension_between_its_limits():
    curves = one_at_a_time(ishigami, CUBE, outputs=["y"], points=9)
    assert curves["dimension"].tolist() == [name for name in NAMES for _ in range(9)]
    beta = curves[curves["dimension"] == "beta"]
    assert beta["value"].to_numpy() == pytest.approx(np.linspace(-np.pi, np.pi, 9))
    assert beta["y"].to_numpy() == pytest.approx(7 * np.sin(beta["value"]) ** 2)
    # x1 = 0 silences x3.
    assert curves.loc[curves["dimension"] == "spin", "y"].to_numpy() == pytest.approx(np.zeros(9), abs=1e-12)
    assert one_at_a_time(ishigami, Tolerances((Dimension("alpha", 0.0),)), outputs=["y"]).empty
    with pytest.raises(ValueError, match="points = 1"):
        one_at_a_time(ishigami, CUBE, outputs=["y"], points=1)


@pytest.fixture
def troubled():
    """y is out where alpha is high, contact is lost in the middle of beta, motions fail at both ends of spin."""
    samples = drawn(4000, "random", 8, model=lambda x: pd.DataFrame({"y": x["alpha"]}))
    lost = samples["beta"].abs() < 0.3
    broken = samples["spin"].abs() > 3.0
    status = np.where(broken, "diverged", np.where(lost, "contact lost", "ok"))
    return samples.assign(status=status)


def test_failures_are_traced_to_their_dimensions(troubled):
    found = failure_sources(troubled, inputs=NAMES, specification={"y": {"max": 2.8}})
    first = found.groupby(level="event", sort=False).head(1).reset_index("dimension")
    assert first["dimension"].to_dict() == {"y": "alpha", CONTACT_LOSS: "beta", "failed": "spin"}
    assert first["where"].to_dict() == {"y": "high", CONTACT_LOSS: "middle", "failed": "both ends"}
    assert first["share"].tolist() == [1.0, 1.0, 1.0]
    # Out are the upper 5.4 % of alpha: its distribution in all other samples has nothing there.
    assert first.at["y", "distance"] == pytest.approx(1.0)
    assert first.at["y", "finding"] == "y: the upper quarter of alpha holds 100 % of it (25 % without influence)"
    rest = found.drop(index=[("y", "alpha"), (CONTACT_LOSS, "beta"), ("failed", "spin")])
    assert (rest["where"] == "anywhere").all()
    assert "shows no influence" in rest["finding"].iloc[0]


def test_distances_are_those_of_kolmogorov_and_smirnov(troubled):
    found = failure_sources(troubled, inputs=NAMES).loc["failed"]
    failed = troubled["status"] == "diverged"
    for name in NAMES:
        expected = stats.ks_2samp(troubled.loc[failed, name], troubled.loc[~failed, name], method="asymp")
        assert found.at[name, "distance"] == pytest.approx(expected.statistic)
        assert found.at[name, "p_value"] == pytest.approx(expected.pvalue, rel=0.2, abs=1e-12)


def test_low_values_can_be_the_source(troubled):
    found = failure_sources(troubled, inputs=["alpha"], specification={"y": {"min": -2.0}, "spin": {"min": -9}})
    assert found.at[("y", "alpha"), "where"] == "low"
    assert found.at[("spin", "alpha"), "finding"] == "spin: no such sample"
    assert found.at[(ANY_REQUIREMENT, "alpha"), "events"] == found.at[("y", "alpha"), "events"]


def test_chance_alone_shows_no_influence():
    samples = drawn(2000, "random", 9).assign(status="ok")
    rng = np.random.default_rng(10)
    traced = 0
    for _ in range(100):
        samples["status"] = np.where(rng.random(2000) < 0.05, "contact lost", "ok")
        traced += (failure_sources(samples, inputs=NAMES).loc[CONTACT_LOSS, "where"] != "anywhere").any()
    assert traced <= 3


def test_rows_of_a_lot_count_once():
    lots = np.repeat(np.random.default_rng(11).random((40, 1)), 50, axis=0)
    samples = pd.DataFrame({"alpha": lots[:, 0], "y": np.repeat(np.random.default_rng(12).random(40), 50)})
    specification = {"y": {"max": 0.7}}
    together = failure_sources(samples, inputs=["alpha"], specification=specification, lot_size=50)
    apart = failure_sources(samples, inputs=["alpha"], specification=specification)
    assert apart.at[("y", "alpha"), "p_value"] < 1e-6
    assert together.at[("y", "alpha"), "p_value"] > 0.01
