"""Outputs that jump are told from smooth ones by the held-out error of a polynomial."""

import numpy as np
import pandas as pd
import pytest

from tolmc.analysis.smoothness import held_out_shares, rough
from tolmc.analysis.sobol import sobol_indices
from tolmc.tables.influence import indices_table
from tolmc.text.phrases import jumps, spoiled_by_jumps
from tolmc.tolerances.dimension import Dimension, Tolerances
from tolmc.tolerances.distributions import Uniform

NAMES = ("alpha", "beta", "spin")


def answers(points):
    x, y, z = (points[name] for name in NAMES)
    # As after one impact more or less, and as of chaotic motions.
    return pd.DataFrame({
        "tilt_max": x + y * z, "impulse_D_max": np.floor(7 * x + 5 * y), "contact_force_D_max": 0.0 * x + 1.0,
        "contact_force_E_max": np.sin(1e4 * x * (y + 2) * (z + 3)),
    })  # fmt: skip


@pytest.fixture(scope="module")
def samples():
    points = pd.DataFrame(np.random.default_rng(1).uniform(-1, 1, (800, 3)), columns=list(NAMES))
    return points.join(answers(points)).assign(status="ok")


def test_the_held_out_share_is_small_for_smooth_outputs_alone(samples):
    outputs = ["tilt_max", "impulse_D_max", "contact_force_D_max", "contact_force_E_max"]
    shares = held_out_shares(samples, inputs=NAMES, outputs=outputs)
    assert shares["tilt_max"] < 1e-12
    assert 0.02 < shares["impulse_D_max"] < 0.3
    assert np.isnan(shares["contact_force_D_max"])
    assert 0.9 < shares["contact_force_E_max"] < 1.1
    assert list(rough(shares).index) == ["contact_force_E_max"]
    few = held_out_shares(samples.iloc[:7], inputs=NAMES, outputs=outputs)
    assert few.isna().all()


def test_samples_without_a_value_take_no_part(samples):
    broken = samples.copy()
    broken.loc[::5, "tilt_max"] = np.nan
    broken.loc[::7, ["status", "tilt_max", "impulse_D_max"]] = "diverged", 1e9, -1e9
    shares, whole = (held_out_shares(s, inputs=NAMES, outputs=["tilt_max", "impulse_D_max"]) for s in (broken, samples))
    assert shares["tilt_max"] < 1e-12
    assert shares["impulse_D_max"] == pytest.approx(whole["impulse_D_max"], rel=0.3)


def test_sobol_indices_say_which_outputs_jump():
    tolerances = Tolerances(tuple(Dimension(name, 0.0, -1.0, 1.0, Uniform()) for name in NAMES))
    found = sobol_indices(
        answers, tolerances, outputs=["tilt_max", "contact_force_E_max"], count=128, seed=1, resamples=50
    )
    assert found.loc["tilt_max", "held_out_share"].max() < 1e-12
    assert found.loc["contact_force_E_max", "held_out_share"].min() > 0.5
    caption = indices_table(found, ["tilt_max", "contact_force_E_max"]).caption
    assert "a polynomial in the dimensions misses the largest contact force N_E of true motions by" in caption
    assert "Jumps" not in indices_table(found, ["tilt_max"]).caption
    assert "Jumps" not in indices_table(found.drop(columns="held_out_share"), ["contact_force_E_max"]).caption


def test_the_sentence_names_the_worst_and_counts_the_others():
    shares = pd.Series({f"{name}_{end}_max": share for share, name, end in (
        (0.6, "contact_force", "D"), (0.9, "contact_force", "E"), (0.7, "impulse", "D"), (0.55, "impulse", "E"),
    )})  # fmt: skip
    said = jumps(shares, spoiled_by_jumps("sobol"))
    assert "the largest contact force N_E, the largest impulse at D, the largest contact force N_D and 1 other" in said
    assert "by 55 to 90 % of the spread" in said and "Sobol' points gain little" in said
    assert "Sobol'" not in jumps(shares, spoiled_by_jumps("random"))
    assert jumps(shares[:0], "") == ""
