"""From the content of a study file to what a study is made of: scene, tolerances, requirements, settings."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal, cast

from tolmc import quantities
from tolmc.mechanism.loads import Harmonic, Loads, Oscillation
from tolmc.mechanism.operating import Operating
from tolmc.mechanism.scene import Body, Joint, Motion, Scene
from tolmc.quantities import JOINT, MASS_AND_CENTER, START
from tolmc.study.derived import Derived, read_outputs
from tolmc.study.dimensions import DimensionsTable
from tolmc.study.fields import Faults, OwnUnit, check_names, form, in_section, place, short, suggestion, validated
from tolmc.study.sections import BodySection, LimitsSection, MotionSection, SpecificationSection, StudyFile
from tolmc.study.unbalance import with_unbalance
from tolmc.study.until import read_until


def study_fields(content: dict[str, Any], data_folder: Path) -> dict[str, Any]:
    """The fields of a :class:`tolmc.study.study.Study` but its name and source, from the content of its file.

    Raises
    ------
    Faults
        With everything that is wrong in the first section that has faults.
    """
    file = validated(StudyFile, content)
    dimensions = with_unbalance(file.dimensions, file.body.center_of_mass, file.motion.spin_rate)
    table = DimensionsTable(dimensions, data_folder)
    scene = _scene(file, content, table)
    with in_section("dimensions"):
        for varied in table.entries:
            scene.check_has(varied)
    if file.life is not None and not scene.joint.wear_coefficient and "wear_coefficient" not in table.entries:
        raise Faults(
            '[life] follows a wear that the joint has not: give [contact] wear_coefficient = "1e-6 mm^3/(N m)".'
        )
    if file.monte_carlo.step is not None and file.monte_carlo.step > file.motion.duration:
        raise Faults(
            f"{place('monte_carlo', 'step')} = {short(content['monte_carlo']['step'])}: expected a step of at most "
            f"{place('motion', 'duration')} = {short(content['motion']['duration'])}; shorten it, or give accuracy."
        )
    settings = file.monte_carlo.model_dump() | {"on_contact_loss": _on_contact_loss(file)}
    outputs = settings.pop("outputs")
    derived = read_outputs(file.outputs)
    if outputs is not None:
        outputs = list(dict.fromkeys([*outputs, *(name for output in derived for name in output.outputs)]))
    requirements = dict(file.specification)
    target = _target(requirements, file.allocation)
    specification = _specification(requirements, outputs, derived)
    return settings | {
        "title": file.title,
        "scene": scene,
        "tolerances": table.tolerances({**scene.scalars, **table.joint}, file.correlation),
        "specification": specification,
        "derived": derived,
        "target": target,
        "formulation": file.model.formulation,
        "outputs": None if outputs is None else tuple(outputs),
        "until": read_until(settings.pop("until"), file.monte_carlo, specification),
        "life": file.life,
        "allocation": file.allocation,
        "inertia_law": _inertia_law(file.body, dimensions),
        "data_files": table.data_files,
    }


def _on_contact_loss(file: StudyFile) -> str:
    """With restitution the motion is followed through flight and impacts, and without it it cannot be."""
    given, follows = file.monte_carlo.on_contact_loss, file.contact.restitution is not None
    field = f"{place('monte_carlo', 'on_contact_loss')} = {given!r}"
    if follows and given in ("continue", "end"):
        raise Faults(f"{field} is for a wall that holds the journal; with [contact] restitution leave it out.")
    rubs = file.contact.friction > 0.0 or file.contact.wear_coefficient > 0.0 or file.loads.drive != "free"
    rubs = rubs or bool(file.loads.force_terms or file.loads.torque_terms)
    if rubs and not follows and given == "continue":
        raise Faults(
            f"{field} is for a wall without friction that holds the journal; with friction, wear, a drive or loads that swing "
            "the motion ends where contact is lost. Leave it out, or give [contact] restitution."
        )
    if given == "follow" and not follows:
        raise Faults(f"{field} needs [contact] restitution, 0 to 1; add it.")
    return "follow" if follows else given


def _scene(file: StudyFile, content: dict[str, Any], table: DimensionsTable) -> Scene:
    written = {table.words[name]: table.written(name) for name in JOINT}
    with in_section("dimensions", written=written):
        joined = Joint(**table.joint, section=file.model.section)
    with in_section("contact", written=content.get("contact")):
        joined = replace(joined, **file.contact.model_dump())
    with in_section("body", written=content["body"]):
        body = _body(file.body)
    with in_section("loads", written=content.get("loads")):
        loads = _loads(file.loads.model_dump())
    with in_section("motion", written=content["motion"]):
        scene = Scene(joined, body, loads, _motion(file.motion.model_dump(exclude_none=True)), file.motion.duration)
    if file.operating is None:
        return scene
    with in_section("operating"):
        return replace(scene, operating=Operating(**file.operating.model_dump()))


def _loads(given: dict[str, Any]) -> Loads:
    drive = given["drive"]
    terms = {name: tuple(Harmonic(**term) for term in given[name]) for name in ("force_terms", "torque_terms")}
    return Loads(**{**given, **terms, "drive": Oscillation(**drive) if isinstance(drive, dict) else drive})


def _motion(start: dict[str, Any]) -> Motion:
    """The start on the wall, or within the clearance where its origin or slope is given."""
    start.pop("duration")
    free = "origin" in start or "slope" in start
    needed, others = (("origin", "slope"), START) if free else (("alpha", "beta"), ("origin_rate", "slope_rate"))
    missing = [name for name in needed if name not in start]
    if missing:
        written = [(name, form(MotionSection.model_fields[name])) for name in missing]
        raise Faults(
            *(f"{place('motion', name)} is missing; {how.remedy if how else 'add it'}." for name, how in written)
        )
    stray = [name for name in others if name in start]
    if stray:
        raise Faults(f"{place('motion', stray[0])} does not go with {' and '.join(needed)}; leave one of them out.")
    return Motion.free(**start) if free else Motion(**start)


def _body(section: BodySection) -> Body:
    ways = {name: getattr(section, name) for name in ("inertia", "centroidal_inertia", "solid_cylinder")}
    given = [name for name, value in ways.items() if value is not None]
    if len(given) != 1:
        raise ValueError(f"{' and '.join(given) or 'no inertia'} given; give one of {', '.join(ways)}.")
    if section.solid_cylinder is not None:
        cylinder = section.solid_cylinder
        return Body.solid_cylinder(section.mass, cylinder.radius, cylinder.length, section.center_of_mass)
    if section.centroidal_inertia is not None:
        return Body.from_centroidal(section.mass, section.center_of_mass, section.centroidal_inertia)
    return Body(section.mass, section.center_of_mass, cast(tuple, section.inertia))


def _inertia_law(body: BodySection, dimensions: Mapping[str, Any]) -> Literal["origin", "centroid", "cylinder"]:
    law: Literal["origin", "centroid", "cylinder"] = (
        "cylinder"
        if body.solid_cylinder is not None
        else "centroid"
        if body.centroidal_inertia is not None
        else "origin"
    )
    given = [row.name for row in quantities.SCALAR_ROWS if row.kind == "inertia" and row.name in dimensions]
    if law != "origin" and given and any(name in dimensions for name in MASS_AND_CENTER):
        raise Faults(
            f"{place('dimensions', given[0])} has a tolerance beside mass or centre of mass, with which the body's inertia "
            "varies by itself. Give [body] inertia about O, or leave one of them out."
        )
    return law


def _target(requirements: dict[str, Any], allocation: Mapping[str, Any]) -> float | None:
    """The share of the parts that has to keep the limits, taken out of the table of these."""
    if "target" not in requirements:
        return None
    if "target_yield" in allocation:
        raise Faults(f"{place('specification', 'target')} and [allocation] target_yield are the same; leave one out.")
    return validated(SpecificationSection, {"target": requirements.pop("target")}, "specification").target


def _specification(
    table: dict[str, Any], outputs: list[str] | None, derived: tuple[Derived, ...]
) -> dict[str, dict[str, float]]:
    own = [output.name for output in derived]
    allowed = (*quantities.OUTPUTS, *own, "target")
    for name in table:
        if name not in allowed and not suggestion(name, allowed):
            raise Faults(
                f"{place('specification', name)} = {short(table[name])} is the limit of an output that is not there; give it "
                f'under [outputs], such as {name} = "800 mm * sin(tilt_angle)", or limit one of {", ".join(allowed)}.'
            )
    check_names(table, allowed, "specification")
    specification = {}
    for name, written in table.items():
        limits = validated(LimitsSection, written, "specification", name, context=OwnUnit.of(name))
        given = limits.model_dump(exclude_none=True)
        if not given:
            raise Faults(f"{place('specification', name)} sets no limit; give min, max or both.")
        if given.get("min", -float("inf")) > given.get("max", float("inf")):
            low, high = short(written["min"]), short(written["max"])
            raise Faults(f"{place('specification', name)}: min = {low} is above max = {high}; exchange them.")
        _check_reach(name, given, written)
        if outputs is not None and name not in outputs and name not in own:
            raise Faults(f"{place('specification', name)} is not among [monte_carlo] outputs; add it there.")
        specification[name] = given
    return specification


def _check_reach(name: str, given: Mapping[str, float], written: Mapping[str, Any]) -> None:
    """Faults where a limit lies where the output never is."""
    output = quantities.output(name)
    low, high = output.range
    is_positive = output.kind in ("angle", "length")
    for side, limit in given.items():
        if not (limit > high if side == "min" else limit <= low if is_positive else limit < low):
            continue
        field = f"{place('specification', name, side)} = {short(written[side])}"
        factor, unit = quantities.shown(name)[1], quantities.shown(name)[0]
        reach = f"above {factor * low:g}" if is_positive else f"at least {factor * low:g}"
        reach += f" {unit}".rstrip() if math.isinf(high) else f" and at most {factor * high:g} {unit}".rstrip()
        raise Faults(f"{field}: no part could keep it, {name} is always {reach}; give a limit there, or leave it out.")
