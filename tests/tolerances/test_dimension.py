"""Ways to write dimensions and tolerances, and what they refuse."""

import math
import pickle
import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from tolerance_cases import CASES, UNBOUNDED, UPPER, dimension, joint

from tolmc.tolerances.dimension import Dimension, Tolerances
from tolmc.tolerances.distributions import Beta, Measured, Normal, Scipy, Triangular, Uniform
from tolmc.tolerances.draw import from_standard_normal, from_unit, sample


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
