"""Zones on offer: where they lie, what they cost, distributions within them."""

import numpy as np
import pytest

from tolmc.allocation.allocate import Curve, with_widths, zone
from tolmc.tolerances.dimension import Dimension, Tolerances
from tolmc.tolerances.distributions import Beta, Normal, Scipy, Triangular, Uniform
from tolmc.tolerances.draw import sample


@pytest.mark.parametrize(
    ("nominal", "lower", "upper", "anchor", "expected"),
    [
        (10.0, 9.0, 11.0, "nominal", (9.5, 10.5)),
        (10.0, 9.0, 10.0, "nominal", (9.0, 10.0)),
        (10.0, 9.8, 10.6, "nominal", (9.75, 10.75)),
        (10.0, 8.0, 9.0, "nominal", (8.0, 9.0)),
        (10.0, 7.0, 9.0, "nominal", (8.0, 9.0)),
        (10.0, 10.0, 10.0, "nominal", (9.5, 10.5)),
        (10.0, 9.0, 11.0, "lower", (9.0, 10.0)),
        (10.0, 9.0, 11.0, "upper", (10.0, 11.0)),
        (9.2, 9.0, 11.0, "middle", (9.5, 10.5)),
    ],
)
def test_zone_keeps_its_anchor(nominal, lower, upper, anchor, expected):
    assert zone(Dimension("alpha", nominal, lower, upper), 1.0, anchor) == pytest.approx(expected)


def test_distribution_and_lots_keep_their_shape():
    given = Tolerances((Dimension("alpha", 0.0, -3.0, 3.0, Normal(truncated=False), lot_sd=0.5),), lot_size=10)
    narrow = with_widths(given, [Curve("alpha", 0.1, 6.0, 1.0, 1.0)], [0.6])
    dimension = narrow.dimensions[0]
    assert (dimension.lower, dimension.upper, dimension.sd) == pytest.approx((-0.3, 0.3, 0.1))
    assert dimension.between_lots == pytest.approx(0.25)


@pytest.mark.parametrize(
    "distribution",
    [
        Triangular(),
        Triangular(mode=0.2),
        Normal(mean=0.8, cp=1.5),
        Normal(mean=0.7, cpk=1.2, truncated=False),
        Normal(mean="nominal"),
        Normal(cp=1.5, cpk=1.0),
        Beta(2.0, 5.0),
        Uniform(),
        Scipy("norm", {"loc": 0.4, "scale": 0.3}, truncated=True),
    ],
)
@pytest.mark.parametrize("anchor", ["nominal", "lower", "upper", "middle"])
def test_distributions_keep_their_shape_in_any_zone(distribution, anchor):
    wide = Dimension("alpha", 0.9, 0.0, 1.0, distribution)
    narrow = with_widths(Tolerances((wide,)), [Curve("alpha", 0.1, 1.0, 1.0, 1.0, anchor=anchor)], [0.1]).dimensions[0]
    u = np.linspace(0.01, 0.99, 9)
    assert (narrow.ppf(u) - narrow.lower) / 0.1 == pytest.approx(wide.ppf(u))


@pytest.mark.parametrize("law", ["reciprocal", "reciprocal-square", "exponential"])
def test_cost_laws_and_their_inverses(law):
    curve = Curve("alpha", 0.05, 2.0, at=0.1, variable=3.0, fixed=1.0, law=law)
    assert curve.cost(0.1) == pytest.approx(4.0)
    widths = np.linspace(0.05, 0.9, 20)
    costs = [curve.cost(width) for width in widths]
    assert np.all(np.diff(costs) < 0)
    for width, cost in zip(widths, costs, strict=True):
        assert curve.narrowest_below(cost) == pytest.approx(width)
    assert curve.narrowest_below(curve.cost(0.05) + 1.0) == 0.05
    assert curve.narrowest_below(0.9) == np.inf


def test_uniform_zones_narrow_too():
    given = Tolerances((Dimension("alpha", 0.5, 0.0, 1.0, Uniform()),))
    narrow = with_widths(given, [Curve("alpha", 0.1, 1.0, 1.0, 1.0)], [0.2])
    values = sample(narrow, 1000, sampling="random", seed=0)["alpha"]
    assert (values.min(), values.max()) == pytest.approx((0.4, 0.6), abs=1e-3)
