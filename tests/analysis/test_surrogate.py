import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tolmc import tilt_angle
from tolmc.analysis import surrogate
from tolmc.tolerances.dimension import Dimension, Tolerances
from tolmc.tolerances.distributions import Normal, Uniform

BOX = {"bearing_radius": (19.95e-3, 20.05e-3), "journal_radius": (9.97e-3, 10e-3), "half_length": (19.9e-3, 20.1e-3)}


def tilt(inputs):
    return pd.DataFrame({"tilt": tilt_angle(*(inputs[name].to_numpy() for name in BOX))})


def points(box, count, seed):
    rng = np.random.default_rng(seed)
    return pd.DataFrame({name: rng.uniform(*limits, count) for name, limits in box.items()})


def test_polynomial_is_reproduced_at_its_own_degree():
    def cubic(inputs):
        x, y = inputs["alpha"], inputs["beta"]
        return pd.DataFrame({"low": 1.0 + x * y, "high": x**3 - 2.0 * x * y**2 + y})

    box = {"alpha": (-1.0, 3.0), "beta": (0.0, 0.5)}
    fitted = surrogate.fit(cubic, box, ("low", "high"), motions=64)
    assert fitted.degree == {"low": 2, "high": 3}
    new = points(box, 200, seed=1)
    pd.testing.assert_frame_equal(fitted(new), cubic(new), atol=1e-12)


def test_tilt_angle_of_the_paper_joint_to_1e_7_of_its_spread_from_64_motions():
    fitted = surrogate.fit(tilt, BOX, ("tilt",), motions=64)
    new = points(BOX, 1000, seed=2)
    error = np.abs(fitted(new)["tilt"] - tilt(new)["tilt"]).max()
    assert error < 1e-7 * fitted.spread["tilt"]


def test_error_falls_with_the_motions():
    wide = {**BOX, "journal_radius": (5e-3, 15e-3)}
    errors = [surrogate.fit(tilt, wide, ("tilt",), motions=motions).held_out["tilt"] for motions in (16, 64, 256)]
    assert errors[0] > 10 * errors[1] > 100 * errors[2]


def test_held_out_error_is_that_of_new_points():
    """Points drawn as the training's are the held-out error's population."""
    wide = {**BOX, "journal_radius": (2e-3, 18e-3)}
    fitted = surrogate.fit(tilt, wide, ("tilt",), motions=128)
    new = surrogate.training_points(wide, 4096, seed=77)
    actual = np.sqrt(np.mean((fitted(new)["tilt"] - tilt(new)["tilt"]) ** 2))
    assert actual == pytest.approx(fitted.held_out["tilt"], rel=0.5)


def test_leave_one_out_errors_are_those_of_refits():
    rng = np.random.default_rng(3)
    design, values = rng.normal(size=(20, 6)), rng.normal(size=(20, 1))
    left_out = []
    for row in range(20):
        others = np.arange(20) != row
        coefficients = np.linalg.lstsq(design[others][:, :3], values[others], rcond=None)[0]
        left_out.append(values[row] - design[row, :3] @ coefficients)
    *_, held_out = surrogate.least_squares(design, values, [3])
    assert held_out[0] == pytest.approx(np.sqrt(np.mean(np.square(left_out))), rel=1e-12)


@given(
    degree=st.integers(0, 5),
    x=st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3),
)
@settings(max_examples=50, deadline=None)
def test_basis_is_the_product_of_chebyshev_polynomials(degree, x):
    exponents = surrogate.multi_indices(3, degree)
    assert len({tuple(a) for a in exponents}) == len(exponents) == (degree + 1) * (degree + 2) * (degree + 3) // 6
    values = surrogate.basis(np.array(x)[:, None], exponents)[:, 0]
    angles = np.arccos(x)
    np.testing.assert_allclose(values, np.prod(np.cos(exponents * angles), axis=1), atol=1e-12)


def test_rows_do_not_depend_on_how_many_there_are():
    fitted = surrogate.fit(tilt, BOX, ("tilt",))
    new = points(BOX, 3 * surrogate.CHUNK + 5, seed=4)
    whole = fitted(new)["tilt"].to_numpy()
    one = fitted(new.iloc[[-1]])["tilt"].to_numpy()
    assert whole[-1] == pytest.approx(one[0], rel=1e-14)


def test_inputs_that_do_not_vary_and_constant_outputs():
    def model(inputs):
        assert (inputs["mass"] == 0.5).all()
        return pd.DataFrame({"linear": 2.0 * inputs["alpha"] * inputs["mass"], "constant": 7.0}, index=inputs.index)

    fitted = surrogate.fit(model, {"mass": (0.5, 0.5), "alpha": (0.0, 1.0)}, ("linear", "constant"))
    assert fitted.varied == ("alpha",)
    new = pd.DataFrame({"alpha": [0.25], "mass": [0.5]})
    assert fitted(new).iloc[0].to_dict() == pytest.approx({"linear": 0.25, "constant": 7.0})
    table = fitted.describe()
    assert table.loc["linear", "held_out_share"] < 1e-12
    assert np.isnan(table.loc["constant", "held_out_share"])


def test_failed_motions_are_left_out_and_counted():
    def model(inputs):
        x = inputs["alpha"]
        return pd.DataFrame({"y": np.where(x > 0.9, np.nan, x**2)})

    fitted = surrogate.fit(model, {"alpha": (0.0, 1.0)}, ("y",), motions=64)
    assert 5 < fitted.failed < 25
    assert fitted(pd.DataFrame({"alpha": [0.5]}))["y"][0] == pytest.approx(0.25)


def test_errors_say_what_to_do():
    with pytest.raises(ValueError, match=r"no input varies.*give a dimension a tolerance"):
        surrogate.fit(tilt, {name: (low, low) for name, (low, _) in BOX.items()}, ("tilt",))
    with pytest.raises(ValueError, match=r"0 of 32 training motions succeeded; at least 8 are needed for 3 varied"):
        surrogate.fit(lambda inputs: pd.DataFrame({"tilt": np.nan}, index=inputs.index), BOX, ("tilt",), motions=32)


def test_training_box_holds_the_limits_or_all_but_a_millionth():
    tolerances = Tolerances(
        (
            Dimension("alpha", 1.0, 0.0, 4.0, Uniform()),
            Dimension("beta", 0.0, -3.0, 3.0, Normal(truncated=False)),
            Dimension("mass", 0.5),
        )
    )
    box = surrogate.training_box(tolerances)
    assert box["alpha"] == pytest.approx((0.0, 4.0), abs=1e-5)
    assert box["beta"] == pytest.approx((-4.7534, 4.7534), abs=1e-4)
    assert box["mass"] == (0.5, 0.5)
