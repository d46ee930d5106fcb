"""Scenes of the stress suite: singular poses of the paper's coordinates, extreme joints, spins, bodies and steps.

Lengths, times and bodies follow the joint, so that a bearing a nanometre or ten metres wide sees motions of the same kind: a
swing of some periods under gravity across it, with rates and spin in units of 1/T, T = sqrt(r/g).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from study_tools import paper_joint

from tolmc.mechanism.scene import Body, Joint, Loads, Motion, Scene

GRAVITY, JOURNAL, MASS = 9.81, 0.01, 0.5


@dataclass(frozen=True)
class Case:
    """A scene of the suite and its place in the tables; without a step the pilot chooses it."""

    group: str
    row: str
    column: str
    scene: Scene
    step: float | None = None
    method: str = "rk8"


def short(number: float) -> str:
    """1e-9, 0.1, 1000, 1e5."""
    text = f"{number:g}" if number == 0 or 1e-3 < number < 1e4 else f"{number:.0e}"
    return text.replace("e-0", "e-").replace("e+0", "e")


# --- Singular poses --------------------------------------------------------------------------------------------------

SETS = {"psi = k pi/2": "ψ = kπ/2", "X0 = Y0 = 0": "X0 = Y0 = 0", "theta = 0": "θ = 0"}
_UNBALANCED = Body(
    0.5, (0.001, -0.0007, 0.004), [[4.1e-4, 2e-5, -1.2e-5], [2e-5, 3.3e-4, 3.1e-5], [-1.2e-5, 3.1e-5, 1.3e-4]]
)
_LOADS = Loads((1.0, -9.81, -2.0), (0.4, 0.3, -0.5), (0.01, -0.02, 0.03))


def singular_poses(distances: tuple[float, ...]) -> Iterator[Case]:
    """Motions through each singular set from a given distance on, and motions that turn around at that distance.

    psi is the polar angle of O, and delta half the angle from D to E: X0 = Y0 = 0 at delta = pi/2, theta = 0 at delta = 0.
    """
    centre = {"psi = k pi/2": (math.pi / 2, 0.6), "X0 = Y0 = 0": (0.7, math.pi / 2), "theta = 0": (0.7, 0.0)}
    for name, (psi, delta) in centre.items():
        for way, rate in (("through", -5.0), ("turning", 0.0)):
            for distance in distances:
                if name == "psi = k pi/2":
                    angles, rates = (psi + distance, delta), (rate, 2.0)
                else:
                    angles, rates = (psi, delta + distance), (1.0, rate)
                motion = Motion(
                    angles[0] - angles[1], angles[0] + angles[1], rates[0] - rates[1], rates[0] + rates[1], 0.7, 30.0
                )
                scene = Scene(paper_joint().joint, _UNBALANCED, _LOADS, motion, 0.05)
                yield Case("singular poses: distance", f"{SETS[name]}, {way}", short(distance), scene)


# --- Joints, spins, bodies -------------------------------------------------------------------------------------------


def swing(
    joint: Joint, *, general: bool, inertia=(2.04, 0.6), z=0.2, mass=MASS, spin_rate=None, periods=3.0, unbalance=0.3
) -> Scene:
    """A swing in the joint; inertia A/(m L^2), C/(m L^2) about O, z = z_C/L, spin in rad/s (2.5/T when None).

    The unbalance of a general body is of the size of the clearance: more would lift it off the wall at once.
    """
    r, L = joint.effective_radius, joint.half_length
    unit = math.sqrt(r / GRAVITY)
    A, C = inertia
    if general:
        x, y = unbalance * r / L, -0.7 * unbalance * r / L
        transverse = A - z * z
        # Moments that differ across the axis, as far as slender rods and flat discs can have them.
        difference = min(0.1 * transverse, 0.5 * C, 2 * transverse - C)
        centroidal = np.diag([transverse, transverse - difference, C])
        tensor = centroidal + (x * x + y * y + z * z) * np.eye(3) - np.outer((x, y, z), (x, y, z))
        body = Body(mass, (x * L, y * L, z * L), mass * L * L * tensor)
    else:
        body = Body(mass, (0, 0, z * L), mass * L * L * np.array([A, A, C]))
    spin = 2.5 / unit if spin_rate is None else spin_rate
    motion = Motion(math.radians(-110), math.radians(-50), 0.06 / unit, -0.1 / unit, 0.3, spin)
    return Scene(joint, body, Loads((0, -GRAVITY, 0)), motion, periods * unit)


KINDS = {"symmetric body": False, "any body": True}


def joints(ratios: tuple[float, ...], slenderness: tuple[float, ...]) -> Iterator[Case]:
    """Clearance ratios (R* - r*)/r* against L/r*."""
    for kind, general in KINDS.items():
        for L in slenderness:
            for ratio in ratios:
                joint = Joint(JOURNAL * (1 + ratio), JOURNAL, L * JOURNAL)
                yield Case(
                    f"joints, {kind}: clearance ratio", f"L/r* = {L:g}", short(ratio), swing(joint, general=general)
                )  # fmt: skip


def spins(rates: tuple[float, ...]) -> Iterator[Case]:
    """Spin rates in rad/s; the motion lasts a hundred radians of spin at most."""
    joint = paper_joint().joint
    unit = math.sqrt(joint.effective_radius / GRAVITY)
    for kind, general in KINDS.items():
        for rate in rates:
            periods = min(3.0, 100 / (unit * max(rate, 1.0)))
            scene = swing(joint, general=general, spin_rate=rate, periods=periods, unbalance=0.01)
            yield Case("spin, rad/s", kind, short(rate), scene)


def bodies() -> Iterator[Case]:
    """Slender and flat, light and heavy bodies, and centres of mass far beyond the bearing."""
    joint = paper_joint().joint
    settings = {f"C/A {ratio:g}": {"inertia": (2.04, 2.04 * ratio), "z": 0.0} for ratio in (1e-3, 1e-2, 0.1, 1.0, 2.0)}
    settings |= {f"{mass:g} kg": {"mass": mass} for mass in (1e-6, 1e6)}
    settings |= {f"z = {z:g} L": {"z": z, "inertia": (2.04 + z * z, 0.6)} for z in (-5.0, 1.5, 5.0, 50.0)}
    for kind, general in KINDS.items():
        for name, options in settings.items():
            yield Case(
                "bodies: inertia ratio, mass, centre of mass", kind, name, swing(joint, general=general, **options)
            )


# --- Steps -----------------------------------------------------------------------------------------------------------


def steps(counts: tuple[int, ...]) -> Iterator[Case]:
    """One second of the paper's joint in a given number of steps, from absurd to tiny ones."""
    scene = paper_joint()
    for method in ("rk8", "rk4"):
        for count in counts:
            yield Case("given steps a second", method, f"{count:d}", scene, scene.duration / count, method)


def suite(quick: bool) -> list[Case]:
    """All scenes, or a few of every group."""
    decades = (1e-1, 1e-6, 1e-12) if quick else tuple(float(f"1e-{k}") for k in range(1, 13))
    ratios = (1e-9, 1.0) if quick else (1e-9, 1e-7, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 0.5, 1.0, 3.0, 10.0)
    slenderness = (0.02, 1e4) if quick else (0.02, 0.1, 0.5, 2.0, 20.0, 1e2, 1e3, 1e4)
    rates = (0.0, 1e3) if quick else (0.0, 1e1, 1e2, 1e3, 1e4, 1e5)
    counts = (1, 100) if quick else (1, 2, 3, 5, 8, 12, 20, 30, 50, 100, 300, 1000, 3000)
    return [*singular_poses(decades), *joints(ratios, slenderness), *spins(rates), *bodies(), *steps(counts)]
