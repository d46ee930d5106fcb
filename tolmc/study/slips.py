"""What a study says that can be computed and is hardly meant: another unit, degrees for radians, sizes out of proportion."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator
from typing import Any

from tolmc import quantities
from tolmc.study.fields import place
from tolmc.study.study import Study

#: Ratios of the joint's lengths beyond which one of them is likely to be in another unit.
_BORE, _LENGTH = 10.0, 100.0
#: Numbers without a unit beyond which people mean another one than the SI unit that they are taken for.
_LARGEST = {"angle": 2.0 * math.pi, "length": 1.0, "acceleration": 100.0}
#: Angle between the journal's two ends, rad, below which it lies parallel to the bore.
_PARALLEL = 1e-6
#: Beyond these, values that no bearing is known to have: friction, slip speed (m/s), Archard's coefficient (m²/N), speed of the
#: journal's surface (m/s), linear expansion (1/K).
_FRICTION, _SLIP_SPEED, _WEAR, _SURFACE_SPEED, _EXPANSION = 1.0, 0.1, 1e-11, 300.0, (-1e-5, 3e-4)
_MEANT = {"angle": "deg", "length": "mm", "acceleration": "mm/s^2"}


def slips(study: Study) -> Iterator[str]:
    """A sentence for each value that is likely to be a slip; the study is computed as it stands."""
    joint = study.scene.joint
    for name, value in (("bearing_radius", joint.bearing_radius), ("half_length", joint.half_length)):
        limit = _BORE if name == "bearing_radius" else _LENGTH
        ratio = value / joint.journal_radius
        if ratio > limit or (name == "half_length" and ratio < 1.0 / limit):
            size = f"{ratio:.3g} times" if ratio > 1 else f"1/{1 / ratio:.3g} of"
            of = f"journal_radius = {_mm(joint.journal_radius)}"
            yield f"{name} = {_mm(value)} is {size} {of}. If that is not meant, check the units."
    yield from _parallel_start(study)
    yield from _idle_limits(study)
    yield from _contact(study)
    yield from _operating(study)
    for where, name, value in _bare_numbers(tomllib.loads(study.source)):
        kind = quantities.of(name).kind
        if kind in _LARGEST and abs(value) > _LARGEST[kind]:
            unit, meant = quantities.unit(name), _MEANT[kind]
            yield f'{where} = {value:.10g} is taken in {unit}. If {meant} is meant, write "{value:.10g} {meant}".'


def _parallel_start(study: Study) -> Iterator[str]:
    """Where limits are on the tilt that the motion reaches, and it starts without any."""
    start = study.scene.motion
    used = {*study.specification, *(name for output in study.derived for name in output.outputs)}
    turned = math.remainder(start.alpha - start.beta, 2.0 * math.pi)
    if "tilt_max" in used and abs(turned) < _PARALLEL:
        yield (
            "tilt_max is the largest tilt that the motion reaches, and the motion starts without any (alpha = beta). For the "
            "tilt that the clearance allows write tilt_angle."
        )


def _idle_limits(study: Study) -> Iterator[str]:
    """Limits that every part keeps, or that the motion is too short for."""
    for name, limits in study.specification.items():
        output = quantities.output(name)
        low, high = output.range
        for side, limit in limits.items():
            unit, factor = quantities.shown(name)
            field = f"{place('specification', name, side)} = {factor * limit:.6g} {unit}".rstrip()
            if limit <= low if side == "min" else limit >= high:
                yield f"{field} says nothing: every part keeps it."
            if output.event and limit > study.scene.duration:
                yield f"{field} is later than the motion ends, after {study.scene.duration:g} s: what happens then is not seen."
    for derived in study.derived:
        if not derived.names:
            yield f"{place('outputs', derived.name)} is the same number for all parts: no dimension or output is in it."


def _contact(study: Study) -> Iterator[str]:
    scene, joint = study.scene, study.scene.joint
    if joint.friction > _FRICTION:
        yield f"friction = {joint.friction:g} is more than dry metals have, 0.1 to 0.8."
    if joint.friction and joint.slip_speed > _SLIP_SPEED:
        yield (
            f"slip_speed = {joint.slip_speed:g} m/s: below it friction falls off with the slip, so that it should be far below "
            "the speeds of the motion. 1 mm/s is usual."
        )
    if joint.wear_coefficient > _WEAR:
        wear = 1e9 * joint.wear_coefficient
        yield f"wear_coefficient = {wear:.3g} mm³/(N m) is more than severe wear, 0.001 to 0.01 mm³/(N m)."
    weight = scene.body.mass * math.hypot(*scene.loads.gravity) + math.hypot(*(scene.loads.force or (0.0,)))
    if joint.contact_stiffness is not None:
        gives = (weight / joint.contact_stiffness) ** (2.0 / 3.0)
        if gives > joint.approximate_radius:
            yield (
                f"contact_stiffness = {joint.contact_stiffness:.3g} N/m^1.5: under {weight:.3g} N the contact gives way by "
                f"{_mm(gives)}, more than the clearance. Steel has 1e9 to 1e11."
            )
    speed = abs(scene.motion.spin_rate) * joint.journal_radius
    if speed > _SURFACE_SPEED:
        yield f"spin_rate = {scene.motion.spin_rate:.4g} rad/s is {speed:.3g} m/s at the journal's surface. Check the unit."


def _operating(study: Study) -> Iterator[str]:
    operating = study.scene.operating
    if operating is None:
        return
    for name in ("bearing_expansion", "journal_expansion"):
        value = float(operating.scalars[name])
        if not _EXPANSION[0] <= value <= _EXPANSION[1]:
            yield f"{name} = {value:g} 1/K is no metal's or plastic's: steel has 12e-6, PTFE 170e-6."
    if operating.bush_wall > study.scene.joint.bearing_radius:
        wall = _mm(operating.bush_wall)
        yield f"bush_wall = {wall} is thicker than its bore's radius. A bush that grows freely has bush_wall = 0."


def _mm(length: float) -> str:
    return f"{1e3 * length:.6g} mm"


def _bare_numbers(content: dict[str, Any]) -> Iterator[tuple[str, str, float]]:
    """Place, quantity and value of every number without a unit that stands for an angle, a length or an acceleration."""
    sections = {name: content.get(name, {}) for name in ("dimensions", "specification", "motion", "body", "loads")}
    for section, table in sections.items():
        for field, entry in table.items():
            if not isinstance(entry, dict):
                name = f"{field}_x" if quantities.is_known(f"{field}_x") else field
                yield from _numbers(place(section, field), name, entry)
            elif quantities.is_known(field):
                for key in ("nominal", "tolerance", "lower", "upper", "mode", "mean", "min", "max"):
                    yield from _numbers(place(section, field, key), field, entry.get(key))
            elif field == "solid_cylinder":
                yield from _numbers(place(section, field), "half_length", list(entry.values()))


def _numbers(where: str, name: str, written: object) -> Iterator[tuple[str, str, float]]:
    values = written if isinstance(written, list) else [written]
    if quantities.is_known(name):
        yield from ((where, name, float(v)) for v in values if isinstance(v, int | float) and not isinstance(v, bool))
