"""Every formulation of the registry, by being listed: order, energy, drift, the NumPy twin, and bits alone and in any block.

The cases are small, so that they also run without compilation (``NUMBA_DISABLE_JIT=1``).
"""

import sys
from dataclasses import replace

import numba as nb
import numpy as np
import pytest
from places import STUDIES
from scenes import LOADED, PAPER_JOINT, SYMMETRIC
from twins import section_twin, slope_twin
from twins.newton_euler import SlidingBody
from uncompiled import run_uncompiled

from tolmc import Joint, Loads
from tolmc.kernels import engine, jit
from tolmc.kernels import results as R
from tolmc.kernels.formulations import FORMULATIONS
from tolmc.kernels.lanes import WIDTH
from tolmc.kernels.one_sided import hand_over, layout, start
from tolmc.kernels.seen import RATE_D, RATE_E, RATE_W2
from tolmc.kernels.tableaux import METHODS, RK8
from tolmc.simulation.features import features_of
from tolmc.simulation.packing import pack

sys.path.append(str(STUDIES))

from operations import step_operations

EXACT = Joint(PAPER_JOINT.bearing_radius, PAPER_JOINT.journal_radius, PAPER_JOINT.half_length, "exact")
#: A scene for each formulation that the choice by features leads to it.
SCENES = {
    "slope_symmetric": SYMMETRIC,
    "slope_axial": replace(SYMMETRIC, loads=Loads((0, 0, -9.81))),
    "slope_general": LOADED,
    "slope_rubbing": replace(SYMMETRIC, joint=replace(PAPER_JOINT, friction=0.1)),
    "exact_symmetric": replace(SYMMETRIC, joint=EXACT),
    "exact_general": replace(LOADED, joint=EXACT),
}
every_formulation = pytest.mark.parametrize("name", FORMULATIONS)


def every_kernel(*chosen):
    """Cases (name, method, forces) of every formulation with each (method, forces) that is ``chosen``.

    Of rk4 with contact forces the suite compiles one, of motions alone those that other tests need too. The formula with the
    other equations :func:`test_order` compiles, their watchers of forces rk8; the nightly run has all, and
    :func:`test_the_formulations_run_without_compilation`.
    """

    def is_compiled(name, method, forces):
        if not forces:
            return name in ("slope_symmetric", "slope_general")
        return method == "rk8" or name == "slope_symmetric"

    return pytest.mark.parametrize(
        ("name", "method", "forces"),
        [
            pytest.param(name, method, forces, marks=() if is_compiled(name, method, forces) else pytest.mark.nightly)
            for method, forces in chosen
            for name in FORMULATIONS
            if forces or not FORMULATIONS[name].RUBS  # friction follows the contact forces
        ],
    )


def integrated(
    name, raw, steps, duration, *, method="rk8", load=True, forces=True, momentum=False, project_energy=False
):  # fmt: skip
    """Results of every column of ``raw``."""
    n = raw.shape[1]
    out = np.full((R.RESULTS, n), np.nan)
    kernel = engine.build(name, method, load=load, forces=forces)
    kernel(np.ascontiguousarray(raw), steps, duration, R.CONTINUE, project_energy, momentum, out)
    return out


def observed(name, scene, steps, method="rk8"):
    """What is observed at the ends of all steps, (11, steps + 1)."""
    equations, (raw, _) = FORMULATIONS[name], pack(scene.scalars, 1)
    states, coef = np.empty((steps + 1, equations.STATE)), np.empty(equations.COEFFICIENTS * WIDTH)
    engine.build_trace(name, method, load=True)(raw, steps, scene.duration, False, states, coef)
    out = np.empty((11, steps + 1))
    engine.build_observe(name, load=True)(states, coef, out)
    return out


@every_formulation
def test_a_state_has_the_motion_that_it_starts_with(name):
    """What a motion is handed over with where contact is lost, against the polar angles and rates of its start."""
    equations, scene = FORMULATIONS[name], SCENES[name]
    raw, _ = pack(scene.scalars, 1)
    states, coef = np.empty((2, equations.STATE)), np.empty(equations.COEFFICIENTS * WIDTH)
    engine.build_trace(name, "rk8", load=True)(raw, 1, 1e-3, False, states, coef)
    found, given = np.zeros((2, layout.GIVEN, 1))
    hand_over.build(name)(raw, np.ascontiguousarray(states[:1].T), found)
    start.build_from_angles()(raw, given, scene.joint.section == "exact")
    pose, rates = slice(layout.START_X, layout.START_V + 1), slice(layout.START_X_RATE, layout.START_V_RATE + 1)
    if name == "slope_axial":  # it knows no turn about Z
        for rows in (found, given):
            axes = np.array([[rows[0, 0], rows[1, 0]], [-rows[1, 0], rows[0, 0]]]) / np.hypot(rows[0, 0], rows[1, 0])
            for first in range(0, 8, 2):
                rows[first : first + 2] = axes @ rows[first : first + 2]
    for part in (pose, rates):
        np.testing.assert_allclose(found[part], given[part], rtol=1e-12, atol=1e-13 * np.abs(given[part]).max())
    if equations.TORQUE:
        assert equations.RUBS or found[layout.CHI, 0] % (2 * np.pi) == pytest.approx(
            given[layout.CHI, 0] % (2 * np.pi), abs=1e-12
        )
        assert found[layout.OMEGA, 0] == pytest.approx(given[layout.OMEGA, 0], rel=1e-15)


@every_formulation
def test_a_scene_leads_to_each_formulation(name):
    assert features_of(SCENES[name], set(), pose=False).formulation == name


@every_formulation
@pytest.mark.parametrize(("method", "order", "allowed"), [("rk8", 8, 1.0), ("rk4", 4, 0.4)])
def test_order(name, method, order, allowed):
    """The error of the pose, of the energies and of the contact forces, root mean square over all times, by halving."""
    scene = replace(SCENES[name], duration=0.1)
    # Where terms of higher order have died away and rounding has not begun.
    steps = 24 if method == "rk4" else {"slope_axial": 3, "slope_general": 16, "exact_general": 16}.get(name, 6)
    # Four times as fine is 2^-8 of an error of order eight away.
    coarse, fine, finer = (observed(name, scene, n * steps, method)[:, ::n] for n in (1, 2, 4 if order == 8 else 8))
    scale = np.abs(finer).max(axis=1, keepdims=True)
    scale[scale == 0] = 1.0
    errors = [np.sqrt(np.mean(((a - finer) / scale) ** 2)) for a in (coarse, fine)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=allowed)


@every_kernel(*((method, True) for method in METHODS))
def test_energy_and_drift(name, method, forces):
    """The balance of energy within the method's error, over three times as long no more than ten times that; none projected."""
    raw, _ = pack(SCENES[name].scalars, 1)
    steps, duration = {"rk8": (10, 0.1), "rk4": (20, 0.1 / 3) if nb.config.DISABLE_JIT else (60, 0.1)}[method]
    short = integrated(name, raw, steps, duration, method=method, forces=forces)[:, 0]
    long = integrated(name, raw, 3 * steps, 3 * duration, method=method, forces=forces)[:, 0]
    assert short[R.ENERGY_ERROR] < 1e-6
    assert long[R.ENERGY_ERROR] < 1e-5
    assert max(short[R.CONSTRAINT_ERROR], long[R.CONSTRAINT_ERROR]) < 1e-12
    projected = integrated(name, raw, steps, duration, method=method, forces=forces, project_energy=True)[:, 0]
    assert projected[R.ENERGY_ERROR] < 1e-12
    assert 0 <= projected[R.ENERGY_CORRECTION] < 1e-6


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if name == "slope_axial" else pytest.mark.nightly) for name in FORMULATIONS]
)
def test_no_load_is_a_load_of_nothing(name):
    raw, _ = pack(replace(SCENES[name], loads=Loads()).scalars, 1)
    without, with_nothing = (integrated(name, raw, 3, 0.03, load=load) for load in (False, True))
    # How many steps are as rough is a ratio of what nearly vanishes.
    rough, other = without[R.AS_ROUGH], with_nothing[R.AS_ROUGH]
    np.testing.assert_allclose(rough, other, rtol=1e-6)
    without[R.AS_ROUGH], with_nothing[R.AS_ROUGH] = 0.0, 0.0
    np.testing.assert_allclose(without, with_nothing, rtol=1e-11, atol=1e-14)


@every_formulation
def test_contact_forces_and_energy_of_the_twin(name):
    """At the start, where the twin needs no integration."""
    scene, scalars = replace(SCENES[name], duration=1e-3), SCENES[name].scalars
    k = slope_twin.Mechanism.from_scalars(scalars)
    _, _, _, _, n_d, n_e, _, _, kinetic, potential, _ = observed(name, scene, 1)[:, 0]
    if scene.joint.section == "exact":
        bearing = section_twin.Bearing(*(scalars[key] for key in ("bearing_radius", "journal_radius", "half_length")))
        body = section_twin.Body(k.mass, k.center, k.inertia, k.gravity, k.force, k.force_point, k.torque)
        pose = section_twin.start(bearing, *(scalars[key] for key in ("alpha", "beta", "alpha_rate", "beta_rate")))
        spin = scalars["spin"], scalars["spin_rate"]
        _, expected = section_twin.accelerations(bearing, body, *pose, *spin)
        energy = section_twin.energy(bearing, body, *pose, *spin)
    elif FORMULATIONS[name].RUBS:
        sliding = SlidingBody(scene)
        expected = sliding.rates(0.0, sliding.start())[-5:-3]
        energy = slope_twin.integrate(scalars, np.array([0.0, 1e-3])).energy[0]
    else:
        twin = slope_twin.integrate(scalars, np.array([0.0, 1e-3]))
        expected, energy = twin.contact_force[0], twin.energy[0]
    if not FORMULATIONS[name].TORQUE:  # a symmetric body's constant spin energy is left out
        energy -= 0.5 * scalars["inertia_zz"] * scalars["spin_rate"] ** 2
    np.testing.assert_allclose([n_d, n_e], expected, rtol=1e-10)
    assert kinetic + potential == pytest.approx(energy, rel=1e-10)


@every_formulation
def test_a_look_sees_the_rates_of_the_motion(name):
    """Of N_D, N_E and |w|^2, against differences of what a trace observes."""
    system, scene, steps = engine._system(name, "rk8", True, True), SCENES[name], 40
    h, rows, see = scene.duration / 2000, system.layout.rows, system.stepper.see
    raw, _ = pack(scene.scalars, 1)
    states, coef = np.empty((steps + 1, system.equations.STATE)), np.empty(system.equations.COEFFICIENTS * WIDTH)
    engine.build_trace(name, "rk8", load=True)(raw, steps, steps * h, False, states, coef)
    values = np.empty((11, steps + 1))
    engine.build_observe(name, load=True)(states, coef, values)

    @nb.njit(**jit._OPTIONS)
    def look(y, coef, h, seen, work):
        see(y, coef, h, seen, work)

    at, found = range(2, steps - 1), np.empty((system.seen, WIDTH))
    for n in at:
        look(np.repeat(states[n], WIDTH), coef, np.full(WIDTH, h), found.reshape(-1), np.empty(rows * WIDTH))
        near = values[[4, 5, 10], n - 2 : n + 3]
        expected = (8 * (near[:, 3] - near[:, 1]) - (near[:, 4] - near[:, 0])) / 12
        size = np.abs(values[[4, 5, 10]]).max(axis=1) * h / scene.duration
        np.testing.assert_array_less(np.abs(found[[RATE_D, RATE_E, RATE_W2], 0] - expected), 1e-4 * size)


@every_kernel(("rk8", True), ("rk4", True), ("rk8", False))
def test_a_lane_does_not_see_its_neighbours(name, method, forces):
    """Bit for bit: a column alone, in a full block, and at another place of another block."""
    n, steps = WIDTH + 2, 9
    scene = SCENES[name]
    large = scene.joint.bearing_radius * (1 + 0.05 * np.random.default_rng(3).uniform(-1, 1, n))
    raw, _ = pack({**scene.scalars, "bearing_radius": large}, n)
    whole = integrated(name, raw, steps, 0.03, method=method, forces=forces)
    turned = integrated(name, raw[:, ::-1], steps, 0.03, method=method, forces=forces)[:, ::-1]
    alone = integrated(name, raw[:, 1:2], steps, 0.03, method=method, forces=forces)
    np.testing.assert_array_equal(whole, turned)
    np.testing.assert_array_equal(whole[:, 1:2], alone)


@pytest.mark.slow
def test_the_formulations_run_without_compilation():
    run_uncompiled(__file__, "-k", "not without and not order and not (drift and rk8)")  # those are compiled


def test_operations_are_counted_on_the_equations_as_they_stand():
    """Whatever functions they are made of: twelve right-hand sides of 80 to 120 operations, and the sums between."""
    sums = 2 * 6 * (sum(map(len, RK8.rows)) + len(RK8.weights))
    assert 12 * 80 < step_operations("rk8") - sums < 12 * 120
