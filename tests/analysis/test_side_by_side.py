import numpy as np
import pandas as pd
import pytest

from tolmc.analysis.linear import linearise
from tolmc.analysis.side_by_side import side_by_side
from tolmc.analysis.worst_case import worst_case
from tolmc.mechanism.geometry import tilt_angle
from tolmc.quantities import SCALARS
from tolmc.statistics.summary import summarise
from tolmc.tolerances.dimension import Dimension, Tolerances
from tolmc.tolerances.distributions import Normal, Uniform
from tolmc.tolerances.draw import sample

JOINT = Tolerances(
    (
        Dimension.symmetric("bearing_radius", 20e-3, 0.05e-3),
        Dimension.from_deviations("journal_radius", 10e-3, -0.03e-3, 0.0),
        Dimension("half_length", 20e-3),
    )
)


def tilt(inputs):
    return pd.DataFrame({"tilt_angle": tilt_angle(*(inputs[name].to_numpy() for name in JOINT.names))})


def in_unit_box(**dimensions):
    """Tolerances 0 .. 1 with nominal 0.5 on scalars that may have any value."""
    return Tolerances(tuple(Dimension(name, 0.5, 0.0, 1.0, d) for name, d in dimensions.items()))


def polynomial(inputs):
    x, y = inputs["alpha"].to_numpy(), inputs["beta"].to_numpy()
    return pd.DataFrame({"linear": 3 * x - 2 * y + 1, "bowl": (x - 0.3) ** 2 + (y - 0.6) ** 2, "fixed": 0 * x})


def test_worst_case_of_a_monotone_output_is_at_the_corners():
    row = worst_case(tilt, JOINT, outputs=["tilt_angle"]).loc["tilt_angle"]
    assert row["nominal"] == tilt_angle(20e-3, 10e-3, 20e-3)
    assert row["max"] == pytest.approx(tilt_angle(20.05e-3, 9.97e-3, 20e-3), rel=1e-14)
    assert row["min"] == pytest.approx(tilt_angle(19.95e-3, 10e-3, 20e-3), rel=1e-14)
    assert row["max_at"] == "bearing_radius at its upper limit, journal_radius at its lower limit"
    assert row["failed"] == 0


def test_an_extreme_inside_the_limits_needs_the_interior():
    tolerances = in_unit_box(alpha=Uniform(), beta=Uniform())
    corners = worst_case(polynomial, tolerances, outputs=["bowl"]).loc["bowl"]
    interior = worst_case(polynomial, tolerances, outputs=["bowl"], interior=True).loc["bowl"]
    assert corners["min"] == pytest.approx(0.3**2 + 0.4**2)
    assert interior["min"] == pytest.approx(0.0, abs=1e-5)
    assert corners["max"] == interior["max"] == pytest.approx(0.7**2 + 0.6**2)
    assert interior["max_at"] == "alpha at its upper limit, beta at its lower limit"


def test_corners_without_a_value_are_counted():
    def fails_above(inputs):
        return polynomial(inputs).where(inputs["alpha"] < 0.9)

    tolerances = in_unit_box(alpha=Uniform(), beta=Uniform())
    row = worst_case(fails_above, tolerances, outputs=["linear"]).loc["linear"]
    assert (row["failed"], row["max"]) == (2, 1.0)
    assert (row["corners_failed"], row["corners"]) == (2, 4)
    nothing = worst_case(lambda x: polynomial(x) * np.nan, tolerances, outputs=["linear"]).loc["linear"]
    assert np.isnan(nothing["max"])
    assert nothing["max_at"] == "not known"


def test_a_search_of_several_starts_finds_the_higher_of_two_hills():
    def hills(inputs):
        x, y = inputs["alpha"].to_numpy(), inputs["beta"].to_numpy()
        wide, narrow = (np.exp(-(((x - a) ** 2 + (y - a) ** 2) / w**2)) for a, w in ((0.2, 0.3), (0.75, 0.1)))
        return pd.DataFrame({"height": wide + 1.1 * narrow})

    tolerances = in_unit_box(alpha=Uniform(), beta=Uniform())
    row = worst_case(hills, tolerances, outputs=["height"], interior=True).loc["height"]
    assert row["max"] == pytest.approx(1.1, rel=1e-2)


def test_many_dimensions_take_the_corners_of_the_sensitivities():
    names = SCALARS[4:22]  # 2^18 corners
    signs = np.where(np.arange(18) % 2, 1.0, -1.0)

    def model(inputs):
        x = inputs[list(names)].to_numpy()
        return pd.DataFrame({"linear": x @ signs, "bowl": ((x - 1.5) ** 2).sum(axis=1)})

    tolerances = Tolerances(tuple(Dimension(name, 1.5, 1.0, 2.0, Uniform()) for name in names))
    worst = worst_case(model, tolerances, outputs=["linear", "bowl"])
    assert worst.loc["linear", ["min", "max"]].tolist() == pytest.approx([-9.0, 9.0])
    assert worst.loc["bowl", ["min", "max"]].tolist() == [pytest.approx(0.0, abs=1e-3), pytest.approx(18 / 4)]
    assert not worst["all_corners"].any()
    verdicts = compared(model, tolerances, ["linear"], count=2048)["verdict"]
    assert verdicts["linear", "upper limit"].endswith("(corners by the signs of the sensitivities)")


def test_root_sum_square_of_a_linear_model_is_exact():
    tolerances = in_unit_box(alpha=Uniform(), beta=Normal(cp=1.0, mean=0.6, truncated=False))
    row = linearise(polynomial, tolerances, outputs=["linear"]).root_sum_square().loc["linear"]
    assert row["nominal"] == pytest.approx(1.5)
    assert row["mean"] == pytest.approx(3 * 0.5 - 2 * 0.6 + 1)
    assert row["sd"] == pytest.approx(np.sqrt(9 / 12 + 4 / 36))
    assert row["high"] - row["low"] == pytest.approx(6 * row["sd"])


def test_correlation_enters_the_root_sum_square():
    dimensions = in_unit_box(alpha=Normal(truncated=False), beta=Normal(truncated=False)).dimensions
    tolerances = Tolerances(dimensions, correlation={("alpha", "beta"): 0.5})
    found = linearise(polynomial, tolerances, outputs=["linear"])
    sampled = polynomial(sample(tolerances, 2**15, sampling="sobol", seed=1))["linear"]
    assert found.root_sum_square().at["linear", "sd"] == pytest.approx(sampled.std(), rel=1e-3)
    assert found.contributions().loc["linear"].tolist() == pytest.approx([100 * 6 / 7, 100 / 7])


def test_contributions_are_shares_of_the_variance():
    tolerances = in_unit_box(alpha=Uniform(), beta=Uniform())
    table = linearise(polynomial, tolerances, outputs=["linear", "fixed"]).contributions()
    assert table.loc["linear"].tolist() == pytest.approx([100 * 9 / 13, 100 * 4 / 13])
    assert table.loc["fixed"].isna().all()


def test_gradient_of_the_tilt():
    gradient = linearise(tilt, JOINT, outputs=["tilt_angle"]).gradient.loc["tilt_angle"]
    # d psi of R* cos(psi) - L sin(psi) - r* = 0.
    psi = tilt_angle(20e-3, 10e-3, 20e-3)
    slope = 20e-3 * np.sin(psi) + 20e-3 * np.cos(psi)
    assert gradient.tolist() == pytest.approx([np.cos(psi) / slope, -1 / slope], rel=1e-8)


def test_dimensions_without_tolerance_leave_the_nominal():
    fixed = Tolerances((Dimension("alpha", 0.2), Dimension("beta", 0.1)))
    row = worst_case(polynomial, fixed, outputs=["linear"], interior=True).loc["linear"]
    assert row["min"] == row["max"] == row["nominal"] == pytest.approx(1.4)
    assert linearise(polynomial, fixed, outputs=["linear"]).root_sum_square().at["linear", "sd"] == 0.0


def test_unusable_step_is_refused():
    with pytest.raises(ValueError, match=r"step = 0\.0"):
        linearise(tilt, JOINT, outputs=["tilt_angle"], step=0.0)


def compared(model, tolerances, outputs, count=2**14, **options):
    samples = model(sample(tolerances, count, sampling="sobol", seed=2))
    return side_by_side(
        worst_case(model, tolerances, outputs=outputs),
        linearise(model, tolerances, outputs=outputs).root_sum_square(),
        summarise(samples, outputs=outputs, sampling="sobol"),
        **options,
    )


def test_linear_answers_agree_where_the_model_is_linear_and_normal():
    tolerances = in_unit_box(alpha=Normal(truncated=False), beta=Normal(truncated=False))
    table = compared(polynomial, tolerances, ["linear"]).loc["linear"]
    assert (table["error_percent"].abs() < 1.5).all()
    assert not table["verdict"].str.contains("root sum square misleads").any()
    # +-3 sd of each of two parts add to 5 sigma_0 / sqrt(13) sigma_0 of the joint spread.
    excess = 50 * (5 / np.sqrt(13) - 1)
    assert table["excess_percent"].dropna().tolist() == pytest.approx([excess, excess], abs=1.5)


def test_verdicts_say_where_and_how_far_linear_answers_mislead():
    tolerances = in_unit_box(alpha=Uniform(), beta=Uniform())
    table = compared(polynomial, tolerances, ["bowl", "fixed"])
    bowl = table.loc["bowl"]
    assert bowl.at["mean", "verdict"].startswith("root sum square misleads")
    assert "too low" in bowl.at["mean", "verdict"]
    spread = bowl.at["upper limit", "monte_carlo"] - bowl.at["lower limit", "monte_carlo"]
    # The tangent at (0.5, 0.5) gives 0.05, the truth is 2/12 + 0.05.
    assert bowl.at["mean", "error_percent"] == pytest.approx(-100 / 6 / spread, rel=1e-3)
    assert "samples go" in bowl.at["lower limit", "verdict"]
    assert "of the sd" in bowl.at["sd", "verdict"]
    assert (table.loc["fixed", "verdict"] == "does not vary").all()


def test_a_worst_case_with_failed_corners_is_not_known():
    def fails_above(inputs):
        return polynomial(inputs).where(inputs["alpha"] < 0.9)

    tolerances = in_unit_box(alpha=Uniform(), beta=Uniform())
    limit = compared(fails_above, tolerances, ["linear"]).loc["linear", :].loc["upper limit"]
    assert np.isnan(limit["worst_case"]) and limit["worst_case_is"] == "not known"
    assert "worst case not known: 2 of 4 corners have no value" in limit["verdict"]


def test_samples_beyond_the_worst_case_are_told():
    tolerances = in_unit_box(alpha=Normal(truncated=False), beta=Normal(truncated=False))
    limit = compared(polynomial, tolerances, ["linear"]).loc["linear", :].loc["upper limit"]
    assert limit["worst_case_is"] == "wider"
    inner = in_unit_box(alpha=Uniform(), beta=Uniform())
    bowl = compared(polynomial, inner, ["bowl"]).loc["bowl", :]
    assert bowl["worst_case_is"].to_dict() == {"mean": "", "sd": "", "lower limit": "exceeded", "upper limit": "wider"}
    assert bowl.at["lower limit", "beyond_percent"] > 10


def test_a_small_sample_cannot_tell():
    tolerances = in_unit_box(alpha=Normal(), beta=Normal())
    verdict = compared(polynomial, tolerances, ["linear"], count=256).at[("linear", "upper limit"), "verdict"]
    assert "too small to tell" in verdict


def test_the_accelerated_estimate_stands_beside():
    tolerances = in_unit_box(alpha=Normal(), beta=Normal())
    columns = {"mean": [1.5], "mean_low": [1.4], "mean_high": [1.6], "degree": [3], "held_out_share": [0.01]}
    estimate = pd.DataFrame(columns, index=["linear"])
    table = compared(polynomial, tolerances, ["linear", "bowl"], accelerated=estimate)
    names = ["accelerated", "accelerated_low", "accelerated_high"]
    assert table.loc[("linear", "mean"), names].tolist() == [1.5, 1.4, 1.6]
    assert table.loc["bowl", "accelerated"].isna().all()
    assert table.loc[("linear", "sd"), ["accelerated_degree", "accelerated_held_out"]].tolist() == [3, 0.01]
