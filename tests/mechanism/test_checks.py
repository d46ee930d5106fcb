"""Arrays keep what they say, or are refused: masks, units, imaginary parts."""

import numpy as np
import pandas as pd
import pint
import pytest

import tolmc
from tolmc.mechanism.checks import finite_number, plain_array, positive_number
from tolmc.tolerances.dimension import Dimension
from tolmc.tolerances.distributions import Measured

REGISTRY = pint.get_application_registry()
MM = REGISTRY.mm

REFUSED = [
    (np.array([20.2, 20.3]) * MM, "carries a unit"),
    ([20.2 * MM, 20.3 * MM], "carries a unit"),
    (20.2 * MM, "carries a unit"),
    (np.array([20.2 * MM, 20.3 * MM], dtype=object), "carries a unit"),
    (np.ma.array([0.0202, 0.0203], mask=[False, True]), "masked"),
    (np.ma.masked_invalid([0.0202, np.nan]), "masked"),
    ([0.0202, np.ma.masked, 0.0203], "masked"),
    ([np.ma.array([0.0202, 0.0203], mask=[False, True])], "masked"),
    (np.array([20, 21], "m8[s]"), "carries a unit"),
    (pd.Series(pd.to_timedelta([20, 21], "ms")), "carries a unit"),
    ([10**400, 1], "array of numbers"),
    (pd.array([0.0202, None], dtype="Float64"), "masked|numbers"),
    (np.array([0.0202 + 0j, 0.0203]), "complex"),
    (["20.2 mm"], "array of numbers in SI units"),
]


@pytest.mark.parametrize(("values", "words"), REFUSED)
def test_what_would_lose_its_meaning_is_refused_everywhere(values, words):
    joint = {"journal_radius": 0.0199, "half_length": 0.03}
    with pytest.raises((ValueError, TypeError), match=words):
        tolmc.tilt_angle(values, **joint)
    with pytest.raises((ValueError, TypeError), match=words):
        Measured(values)
    scene = tolmc.Scene(
        tolmc.Joint(0.0202, 0.0199, 0.03),
        tolmc.Body(1.0, inertia=(1e-3,) * 3),
        tolmc.Loads(),
        tolmc.Motion(0.0, 0.0),
        0.1,
    )
    with pytest.raises((ValueError, TypeError), match=words):
        tolmc.simulate_many(scene, bearing_radius=values, **joint)


@pytest.mark.parametrize(
    "values",
    [
        [0.0202, 0.0203],
        np.ma.array([0.0202, 0.0203], mask=False),
        pd.Series([0.0202, 0.0203], index=["unit", "units"]),
        np.array([0.0202, 0.0203], np.longdouble),
        pd.array([0.0202, 0.0203], dtype="Float64"),
    ],
)
def test_plain_numbers_pass(values):
    assert plain_array("radius", values).tolist() == [0.0202, 0.0203]
    assert Measured(values).values.tolist() == [0.0202, 0.0203]


@pytest.mark.parametrize("value", [20.2 * MM, np.ma.masked, np.ma.array(1.0, mask=True)])
def test_a_single_number_is_plain_too(value):
    with pytest.raises(ValueError, match=r"unit|masked"):
        finite_number("Joint", "bearing_radius", value)


@pytest.mark.parametrize("value", [10**400, -(10**400)])
def test_a_number_too_large_for_a_float_is_out_of_range(value):
    with pytest.raises(ValueError, match=r"nominal = .* is out of range"):
        Dimension("bearing_radius", value)
    with pytest.raises(ValueError, match=r"step = .* is out of range"):
        positive_number("step", value)


@pytest.mark.parametrize("value", [20.2 * MM, np.ma.masked])
def test_an_argument_is_plain_too(value):
    with pytest.raises(ValueError, match=r"step .*(unit|masked)"):
        positive_number("step", value)


def test_an_inertia_with_a_unit_is_refused():
    with pytest.raises(ValueError, match=r"inertia .*carries a unit"):
        tolmc.Body(1.0, inertia=np.eye(3) * REGISTRY("kg mm^2"))
