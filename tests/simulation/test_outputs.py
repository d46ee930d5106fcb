"""What a scene has of the registry's outputs, and what becomes of one that it lacks."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import REFERENCES

from tolmc import quantities, simulate_many, tilt_angle
from tolmc.mechanism.operating import Operating
from tolmc.quantities import CHECKS, END_OUTPUTS, GEOMETRY, OUTPUTS, Output
from tolmc.simulation import outputs
from tolmc.simulation.features import Features
from tolmc.simulation.plan import Plan

OPERATING = tuple(f"operating_{name}" for name in quantities.JOINT)

ALL = ("momentum", "spin", "one_sided", "stiffness", "friction", "driven", "wears")
#: What flights, impacts, friction, a drive and wear give.
CONTACT = {output.name for output in quantities.OUTPUT_ROWS if output.when in ALL[2:]}


def plan(formulation="slope", **features):
    return Plan(formulation, "rk8", 8, 1e-7, features=Features(**features))


@pytest.mark.parametrize(
    ("features", "project_energy", "absent"),
    [
        ({}, False, {"momentum_error", "spin_error", "energy_correction", *OPERATING, *CONTACT}),
        ({"momentum": True}, False, {"spin_error", "energy_correction", *OPERATING, *CONTACT}),
        ({"momentum": True, "spin": True, "operating": True}, True, set(CONTACT)),
        ({feature: True for feature in (*ALL, "operating")}, True, set()),
    ],
)
def test_a_scene_has_what_its_features_keep(features, project_energy, absent):
    found = outputs.scene_outputs(plan(**features), project_energy)
    assert found == tuple(name for name in OUTPUTS if name not in absent)


def test_what_is_asked_for_says_what_is_computed():
    assert not outputs.integrates(GEOMETRY)
    for name in (*CHECKS, *END_OUTPUTS):
        assert outputs.integrates([name]) and not outputs.wants_forces([name])
    assert outputs.wants_forces(["tilt_max"]) and outputs.wants_forces(None)
    assert outputs.wants_pose(["axis_x_end"]) and not outputs.wants_pose(None)


def test_an_output_that_the_scene_lacks_is_missing_and_judged_nowhere(monkeypatch):
    scene = next(iter(REFERENCES.values())).scene
    dimensions = {name: np.full(3, scene.scalars[name]) for name in quantities.JOINT}
    settings = {"step": 1e-3, "outputs": ["contact_force_D_max"], "halving": True}
    before = simulate_many(scene, **dimensions, **settings)
    # Its row holds NaN, as an unwritten one may: who looked at it would call the samples diverged.
    lacked = Output("impacts", "force", "Impacts", row="LOSS_TIME", group="statistics", when="axial")
    monkeypatch.setattr(quantities, "OUTPUT_ROWS", (*quantities.OUTPUT_ROWS, lacked))
    monkeypatch.setitem(quantities._ROWS, "impacts", lacked)
    monkeypatch.setitem(outputs.ROWS, "impacts", outputs.R.LOSS_TIME)
    monkeypatch.setattr(quantities, "OUTPUTS", (*quantities.OUTPUTS, "impacts"))
    settings["outputs"] = ["contact_force_D_max", "impacts"]
    after = simulate_many(scene, **dimensions, **settings)
    assert after["impacts"].isna().all()
    assert (after["status"] == before["status"]).all()
    assert (after["contact_force_D_max"] == before["contact_force_D_max"]).all()


def test_dimensions_in_operation_are_outputs_beside_the_drawn_ones():
    hot = Operating(bearing_temperature=120.0, bearing_expansion=1e-4, journal_wear=1e-5)
    scene = replace(next(iter(REFERENCES.values())).scene, operating=hot)
    bore = scene.joint.bearing_radius
    drawn = {name: [scene.scalars[name], np.nan] for name in quantities.JOINT}
    found = simulate_many(scene, **drawn, outputs=[*OPERATING, *GEOMETRY])
    assert found["bearing_radius"][0] == bore
    assert found["operating_bearing_radius"][0] == pytest.approx(1.01 * bore, rel=1e-14)
    assert found["operating_journal_radius"][0] == pytest.approx(scene.joint.journal_radius - 1e-5, rel=1e-14)
    assert found["tilt_angle"][0] == tilt_angle(*found.loc[0, list(OPERATING)].astype(float))
    assert found.loc[1, list(GEOMETRY)].isna().all()
    assert found["status"].tolist() == ["ok", "geometry invalid"]
