"""Correlation of dimensions through their scores."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats
from scipy.special import ndtri
from tolerance_cases import ALL, cases, dimension, joint

from tolmc.tolerances.dimension import Dimension, Tolerances
from tolmc.tolerances.distributions import Normal
from tolmc.tolerances.draw import from_standard_normal, from_unit, sample, unit_points


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
