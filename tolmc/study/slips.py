"""What a study says that can be computed and is hardly meant: another unit, angles in degrees that were taken for radians."""

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
