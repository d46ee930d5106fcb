"""Friction in the one-sided kernels: reference motions, and an impact whose friction never turns the sliding round."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from tolmc.kernels import parameters as P
from tolmc.kernels import results as R
from tolmc.kernels.one_sided import engine, start
from tolmc.kernels.one_sided import layout as at
from tolmc.mechanism.geometry import effective_radius

_CASES = json.loads((Path(__file__).parents[1] / "data" / "one_sided.json").read_text())
ROUGH = {name: case for name, case in _CASES.items() if case["friction"]}


def columns(case):
    """Parameters and what is given besides, of one sample."""
    raw, given = np.zeros((P.COUNT, 1)), np.zeros((at.GIVEN, 1))
    sizes = [case[name] for name in ("bearing_radius", "journal_radius", "half_length")]
    raw[[P.BEARING_RADIUS, P.JOURNAL_RADIUS, P.HALF_LENGTH], 0] = sizes
    raw[P.RADIUS], raw[P.MASS] = effective_radius(*sizes), case["mass"]
    raw[P.COM_X : P.COM_Z + 1, 0], raw[P.GRAVITY_X : P.GRAVITY_Z + 1, 0] = case["center_of_mass"], case["gravity"]
    inertia = np.array(case["inertia"])
    raw[P.J_XX : P.J_ZZ + 1, 0] = inertia.diagonal()
    raw[P.LOAD_ENERGY] = case["mass"] * 9.81 * raw[P.RADIUS]
    for name, value in case["motion"].items():
        raw[getattr(P, name.upper())] = value
    start.build_from_angles()(raw, given, case["section"] == "exact")
    given[at.RESTITUTION], given[at.FRICTION], given[at.SLIP_SPEED] = (
        case["restitution"], case["friction"], case["slip_speed"],
    )  # fmt: skip
    given[at.LOSS], given[at.REST] = -1.0, 1e-11
    return raw, given


def integrated(case, steps):
    raw, given = columns(case)
    out, counts = np.empty((R.RESULTS, 1)), np.zeros(3, np.int64)
    nothing = np.empty((at.RECORD, 0)), np.empty((at.EVENT, 0))
    kernel = engine.build(exact=case["section"] == "exact", general=False, rubs=True, swings=False, rk4=False)
    kernel(raw, given, steps, case["duration"], 10_000, 1e-6, out, counts, *nothing)
    return out[:, 0]


@pytest.mark.parametrize("name", ROUGH)
def test_a_reference_motion_with_friction_is_met(name):
    case = ROUGH[name]
    expected, found = case["expected"], integrated(case, 200)
    assert found[R.STATUS] == at.OK
    assert found[R.ENERGY_ERROR] < 1e-12
    radius = effective_radius(case["bearing_radius"], case["journal_radius"], case["half_length"])
    allowed = max(1e-8, 10 * case["agreement"])
    assert found[[R.ORIGIN_X, R.ORIGIN_Y]] / radius == pytest.approx(np.divide(expected["origin"], radius), abs=allowed)
    assert found[[R.AXIS_X, R.AXIS_Y, R.AXIS_Z]] == pytest.approx(expected["axis"], abs=allowed)
    assert found[R.SPIN_END] == pytest.approx(expected["spin_rate"], rel=1e-8)
    assert found[R.FRICTION_WORK] == pytest.approx(expected["friction_work"], rel=1e-5)
    assert found[R.IMPACT_LOSS] == pytest.approx(expected["impact_energy_loss"], rel=1e-5, abs=1e-12)
    for side, end in enumerate("DE"):
        assert found[R.D_SLIP_WORK + side] == pytest.approx(expected[f"slip_work_{end}"], rel=1e-5)
        assert found[(R.D_IMPACT_SPEED_MAX, R.E_IMPACT_SPEED_MAX)[side]] == pytest.approx(
            expected[f"impact_speed_{end}_max"], rel=1e-5
        )
        assert found[(R.D_IMPULSE_MAX, R.E_IMPULSE_MAX)[side]] == pytest.approx(
            expected[f"impulse_{end}_max"], rel=1e-5
        )
        assert found[(R.D_MAX, R.E_MAX)[side]] == pytest.approx(expected[f"contact_force_{end}_max"], rel=1e-5)
        assert found[(R.D_MEAN, R.E_MEAN)[side]] == pytest.approx(expected[f"contact_force_{end}_mean"], rel=1e-5)


def test_backward_whirl_follows_its_closed_form():
    """Without load, whirl -w, spin Omega > 0: w = w0/(1 - mu w0 t), and C Omega + m c r* w is constant."""
    case = dict(
        ROUGH["friction_keeps_contact"], gravity=[0, 0, 0], center_of_mass=[0, 0, 0], slip_speed=1e-6, duration=0.05
    )
    whirl, spin, mu = 10.0, 80.0, case["friction"]
    case["motion"] = {
        "alpha": 0.0,
        "beta": 0.0,
        "alpha_rate": -whirl,
        "beta_rate": -whirl,
        "spin": 0,
        "spin_rate": spin,
    }
    found = integrated(case, 200)
    assert found[R.STATUS] == at.OK
    rate = whirl / (1 - mu * whirl * case["duration"])
    angle = math.log(1 - mu * whirl * case["duration"]) / mu
    radius = effective_radius(0.02, 0.01, 0.02)
    assert found[R.ORIGIN_X] == pytest.approx(radius * math.cos(angle), abs=1e-9 * radius)
    assert found[R.ORIGIN_Y] == pytest.approx(radius * math.sin(angle), abs=1e-9 * radius)
    moment = case["inertia"][2][2]
    lost = case["mass"] * radius * case["journal_radius"] * (rate - whirl) / moment
    assert found[R.SPIN_END] == pytest.approx(spin - lost, rel=1e-9)
