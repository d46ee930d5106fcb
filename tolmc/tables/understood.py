"""What a study is understood to say, without computing any motion: what `check` shows."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from itertools import product

import numpy as np

from tolmc import quantities
from tolmc.mechanism.circle_error import section_error_estimate
from tolmc.mechanism.geometry import tilt_angle
from tolmc.mechanism.loads import Harmonic, Oscillation
from tolmc.mechanism.scene import Scene
from tolmc.quantities import CENTER
from tolmc.study.slips import slips
from tolmc.study.study import Study
from tolmc.tables.dimensions import dimensions_table
from tolmc.tables.table import Column, Note, Table, cells
from tolmc.text.phrases import SAMPLINGS, quantity
from tolmc.text.typeset import span
from tolmc.tolerances.interference import interference_note

# What a motion costs, for a word about the time a run takes: the steps for a radian of its fastest oscillation at the default
# accuracy, seconds a step on one core with all statistics (symmetric body, any other), seconds of the start and the pictures,
# and of the pilot and the motions that judge the model.
_STEPS_A_RADIAN = 3.5
_STEP_SECONDS = {True: 0.2e-6, False: 0.8e-6}
_RUBBING = 3.0  # how much more with friction, wear, a drive, or loads that swing
_HOPPING = 10.0  # and with flight and impacts
_OVERHEAD, _PILOT = 2.0, 3.0


def understood_blocks(study: Study) -> Iterator[Table | Note]:
    """Dimensions, joint, body, loads and start, what will be computed and about how long that takes; what to mind."""
    yield Note(study.title, strong=study.title, is_apart=True)
    yield dimensions_table(study)
    facts = [
        *_joint(study),
        *_body(study),
        *_loads(study.scene),
        *_contact(study.scene),
        *_motion(study.scene),
        *_computed(study),
    ]
    yield Table(
        "understood",
        ("", Column("", words=True)),
        tuple(cells(*fact) for fact in facts),
        title="The rest",
        is_dense=True,
    )
    for sentence in notes(study):
        yield Note(f"Note: {sentence}", strong="Note", is_apart=True)
    yield Note("The study can be run.", is_apart=True)


def _joint(study: Study) -> Iterator[tuple[str, str]]:
    joint = study.scene.joint
    ends = {d.name: (d.lower, d.upper) for d in study.tolerances.dimensions}
    (least_bore, most_bore), (least_journal, most_journal) = ends["bearing_radius"], ends["journal_radius"]
    least, most = 2e3 * (least_bore - most_journal), 2e3 * (most_bore - least_journal)
    clearance = 2e3 * joint.approximate_radius
    share = 100 * joint.approximate_radius / joint.journal_radius
    yield "Clearance", f"{clearance:.4g} mm on the diameter, {least:.4g} to {most:.4g} mm; {share:.2g} % of the journal"
    corners = [
        tilt_angle(*corner) for corner in product(*(ends[name] for name in quantities.JOINT)) if corner[0] > corner[1]
    ]
    if corners:
        low, high = np.degrees(min(corners)), np.degrees(max(corners))
        yield "Tilt allowed", f"{math.degrees(joint.tilt_angle):.4g} deg, {low:.4g} to {high:.4g} deg"
    operating = study.scene.joint_in_operation
    if study.scene.operating is not None:
        clearance, tilt = 2e3 * operating.approximate_radius, math.degrees(operating.tilt_angle)
        yield "In operation", f"{clearance:.4g} mm on the diameter, {tilt:.4g} deg at the nominal temperatures and wear"
    error = 100 * section_error_estimate(operating)["position"]
    kind = "circles of constant radius" if joint.section == "circle" else "the bearing's rims"
    yield "Section", f"{joint.section}: {kind}; circles misstate the axis's position by up to {error:.2g} %"


def _body(study: Study) -> Iterator[tuple[str, str]]:
    body = study.scene.body
    varied = {dimension.name: dimension for dimension in study.tolerances.varied}
    off_axis = not {"center_of_mass_x", "center_of_mass_y"}.isdisjoint(varied)
    shape = f"{'' if body.is_symmetric and not off_axis else 'not '}symmetric about the journal's axis"
    center = ", ".join(
        span(1e3 * varied[name].lower, 1e3 * varied[name].upper) if name in varied else f"{1e3 * value:.4g}"
        for name, value in zip(CENTER, body.center_of_mass, strict=True)
    )
    yield "Body", f"{body.mass:.4g} kg, centre of mass ({center}) mm from the middle of the bearing, {shape}"


def _loads(scene: Scene) -> Iterator[tuple[str, str]]:
    loads = {
        "gravity": (scene.loads.gravity, "m/s^2"),
        "force": (scene.loads.force, "N"),
        "torque": (scene.loads.torque, "N m"),
    }
    words = [f"{name} {_vector(v)} {unit}" for name, (v, unit) in loads.items() if v and any(v)]
    for name, term in scene.loads.terms.items():
        axes = "" if term.axes == "fixed" else " in axes that turn with the body"
        words.append(
            f"{name.replace('_', ' ')} {_vector(term.amplitude)} {quantities.unit(f'{name}_x')}{_swing(term)}{axes}"
        )
    yield "Loads", "; ".join(words) or "none"
    drive = scene.loads.drive
    if isinstance(drive, Oscillation):
        yield "Drive", f"swings by ±{math.degrees(drive.amplitude):.4g} deg{_swing(drive)}"
    elif scene.loads.is_driven:
        yield "Drive", "holds the spin rate of the start"


def _vector(values: Iterable[float]) -> str:
    return f"({', '.join(f'{value:.4g}' for value in values)})"


def _swing(part: Oscillation | Harmonic) -> str:
    phase = f", phase {math.degrees(part.phase):.4g} deg" if part.phase else ""
    return f" at {part.frequency:.4g} Hz{phase}"


def _contact(scene: Scene) -> Iterator[tuple[str, str]]:
    joint, words = scene.joint, []
    if joint.restitution is not None:
        words.append(f"restitution {joint.restitution:.4g}")
    if joint.friction:
        words.append(f"friction {joint.friction:.4g} at slips above {quantity('slip_speed', joint.slip_speed)}")
    if joint.wear_coefficient:
        words.append(f"wear {quantity('wear_coefficient', joint.wear_coefficient, 4)}")
    if words:
        yield "Contact", ", ".join(words)


def _motion(scene: Scene) -> Iterator[tuple[str, str]]:
    start = scene.motion
    angles = f"α {math.degrees(start.alpha):.4g} deg, β {math.degrees(start.beta):.4g} deg"
    rates = f"rates {start.alpha_rate:.4g} and {start.beta_rate:.4g} rad/s"
    spin = f"spin {math.degrees(start.spin):.4g} deg at {start.spin_rate * 30 / math.pi:.4g} rpm"
    yield "Motion", f"{scene.duration:.4g} s from {angles}, {rates}, {spin}"


def _computed(study: Study) -> Iterator[tuple[str, str]]:
    most = "at most " if study.until is not None else ""
    what = "motions" if study.integrates else "joints (geometry alone)"
    yield (
        "Computed",
        f"{most}{study.samples:,} {what}, {SAMPLINGS[study.sampling]}, seed {study.seed}, {study.workers} workers",
    )
    for name, limits in study.specification.items():
        unit, factor = quantities.shown(name)
        words = [
            f"{sign} {factor * limits[end]:.6g} {unit}".strip()
            for end, sign in (("min", "≥"), ("max", "≤"))
            if end in limits
        ]
        yield "Requirement", f"{quantities.label(name)} {' and '.join(words)}"
    if study.specification and study.target is not None:
        yield "Target", f"{100 * study.target:.6g} % of the parts keep every limit"
    if study.life is not None:
        share = 100 * study.life.broken_share
        yield (
            "Life",
            f"tolmc life: hours until {share:.4g} % of the parts break a limit, up to {study.life.running_time / 3600:.4g} h",
        )
    yield "Takes", about(seconds(study), compiles=study.integrates)


def seconds(study: Study) -> float:
    """About how long a run takes, s: a guess from the fastest oscillation, good to a factor of about three."""
    if not study.integrates:
        return _OVERHEAD + 1e-6 * study.samples
    scene = study.scene
    steps = scene.duration / study.step if study.step else 10 + _STEPS_A_RADIAN * _fastest_rate(scene) * scene.duration
    each = steps * _STEP_SECONDS[scene.body.is_symmetric] * (2 if study.halving else 1)
    each *= (_RUBBING if scene.rubs else 1.0) * (1.0 if scene.joint.restitution is None else _HOPPING)
    return _OVERHEAD + _PILOT + study.samples * each / study.workers


def _fastest_rate(scene: Scene) -> float:
    """The fastest of what oscillates, rad/s: the journal rolling in its clearance, the whirl it starts with, precession."""
    body, loads, start = scene.body, scene.loads, scene.motion
    pull = np.linalg.norm(loads.gravity[:2])
    if loads.force is not None:
        pull += np.linalg.norm(loads.force[:2]) / body.mass
    transverse = max(body.inertia[0, 0], body.inertia[1, 1])
    return max(
        math.sqrt(pull / scene.joint_in_operation.effective_radius),
        abs(start.alpha_rate),
        abs(start.beta_rate),
        abs(start.spin_rate) * (body.inertia[2, 2] / transverse if body.is_symmetric else 1.0),
        *(2 * math.pi * value for name, value in loads.scalars.items() if name.endswith("frequency")),
    )


def about(time: float, *, compiles: bool = True) -> str:
    """A guessed time in words."""
    words = (
        f"{float(f'{time:.1g}'):.0f} s"
        if time < 90
        else f"{time / 60:.0f} min"
        if time < 5400
        else f"{time / 3600:.0f} h"
    )
    first = "; the first time up to a minute more, while the kernels are compiled" if compiles else ""
    return f"about {words} (a guess, good to a factor of three){first}"


def notes(study: Study) -> Iterator[str]:
    """What the author of a study should know before a run."""
    if note := interference_note(study.tolerances, study.scene.scalars):
        yield note[0].upper() + note[1:]
    yield from slips(study)
    if not study.tolerances.varied:
        yield "No dimension varies: all samples will be equal. Give one a tolerance."
    if not study.specification:
        yield "There are no requirements: shares inside limits will not be told. Add limits under [specification]."
