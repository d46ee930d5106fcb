"""From a study file (TOML) to a validated :class:`Study`.

Numbers are SI; strings carry their unit ("20 mm", "-110 deg", "1500 rpm"). Whatever is unknown, missing, of the wrong
kind or out of range ends in a :class:`StudyError` that names the field, its value, what is allowed and what to do.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal, cast

from tolmc import quantities
from tolmc.encoding import decoded
from tolmc.mechanism.operating import Operating
from tolmc.mechanism.scene import Body, Joint, Loads, Motion, Scene
from tolmc.quantities import JOINT
from tolmc.study.dimensions import DimensionsTable
from tolmc.study.fields import (
    Faults,
    OwnUnit,
    check_names,
    in_section,
    place,
    short,
    validated,
)
from tolmc.study.sections import BodySection, LimitsSection, MonteCarloSection, StudyFile
from tolmc.study.study import MASS_AND_CENTER, Study, StudyError, Until


def load_study(path: str | Path, *, data_folder: str | Path | None = None) -> Study:
    """Read and check a study file.

    Parameters
    ----------
    path : path of a TOML file
    data_folder : path, optional
        Folder to which the names of data files are relative; that of the study file when not given.

    Raises
    ------
    StudyError
        With everything that is wrong in the first section that has faults.
    """
    path = Path(path)
    try:
        source = decoded(path.read_bytes())
    except OSError as error:
        raise StudyError(f"{path} cannot be read: {error.strerror or error}. Check the path of the study.") from None
    except ValueError as error:
        raise StudyError(f"{path} has {error}. A study is a TOML file.") from None
    try:
        content = tomllib.loads(source)
    except (ValueError, RecursionError) as error:
        raise StudyError(f"{path} is no valid TOML: {error}.{_toml_remedy(str(error), source)}") from None
    try:
        return _study(path.stem, source, content, Path(data_folder or path.parent))
    except Faults as faults:
        raise StudyError("\n".join(f"{path}: {sentence}" for sentence in faults.sentences)) from None


def _toml_remedy(error: str, source: str) -> str:
    """What to do about a sentence of the TOML reader, by the line that it names."""
    at = re.search(r"at line (\d+)", error)
    line = source.splitlines()[int(at[1]) - 1].strip() if at and int(at[1]) <= len(source.splitlines()) else ""
    if error.startswith("Cannot overwrite"):
        key = line.partition("=")[0].strip()
        return f" {key} is given twice in its table: {short(line)} and before; keep one."
    if error.startswith("Cannot declare"):
        return f" {line.partition('#')[0].strip()} is there twice; put everything of it below one."
    if "\\" in line and '"' in line:
        return f" In {short(line)} a backslash starts an escape; write paths with / or in single quotes."
    if re.search("[\u2018\u2019\u201c\u201d\u201e]", line):
        return f' {short(line)} has typographic quotes; write ".'
    if re.search(r"=\s*[+-]?[0-9.]+\s*[A-Za-z°µ%]", line):
        return f' In {short(line)} a value with a unit needs quotes, such as "20 mm".'
    if re.search(r"=\s*[+-]?[0-9]+,[0-9]", line):
        return f" In {short(line)} the decimal sign is a comma; write a point."
    return " See https://toml.io for the syntax."


def _study(name: str, source: str, content: dict[str, Any], data_folder: Path) -> Study:
    file = validated(StudyFile, content)
    table = DimensionsTable(file.dimensions, data_folder)
    scene = _scene(file, content, table.joint)
    settings = file.monte_carlo.model_dump()
    outputs = settings.pop("outputs")
    specification = _specification(file.specification, outputs)
    return Study(
        name=name,
        title=file.title or name,
        scene=scene,
        tolerances=table.tolerances({**scene.scalars, **table.joint}, file.correlation),
        specification=specification,
        formulation=file.model.formulation,
        outputs=None if outputs is None else tuple(outputs),
        until=_until(settings.pop("until"), file.monte_carlo, specification),
        allocation=file.allocation,
        inertia_law=_inertia_law(file.body, file.dimensions),
        source=source,
        data_files=table.data_files,
        **settings,
    )


def _scene(file: StudyFile, content: dict[str, Any], joint: dict[str, float]) -> Scene:
    written = {name: content["dimensions"].get(name, content["dimensions"].get("fit")) for name in JOINT}
    with in_section("dimensions", written=written):
        joined = Joint(**joint, section=file.model.section)
    with in_section("body", written=content["body"]):
        body = _body(file.body)
    with in_section("loads", written=content.get("loads")):
        loads = Loads(**file.loads.model_dump())
    with in_section("motion", written=content["motion"]):
        start = file.motion.model_dump()
        scene = Scene(joined, body, loads, duration=start.pop("duration"), motion=Motion(**start))
    if file.operating is None:
        return scene
    with in_section("operating"):
        return replace(scene, operating=Operating(**file.operating.model_dump()))


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


def _specification(table: dict[str, Any], outputs: list[str] | None) -> dict[str, dict[str, float]]:
    check_names(table, quantities.OUTPUTS, "specification")
    specification = {}
    for name, written in table.items():
        limits = validated(LimitsSection, written, "specification", name, context=OwnUnit.of(name))
        given = limits.model_dump(exclude_none=True)
        if not given:
            raise Faults(f"{place('specification', name)} sets no limit; give min, max or both.")
        if given.get("min", -float("inf")) > given.get("max", float("inf")):
            low, high = short(written["min"]), short(written["max"])
            raise Faults(f"{place('specification', name)}: min = {low} is above max = {high}; exchange them.")
        if outputs is not None and name not in outputs:
            raise Faults(f"{place('specification', name)} is not among [monte_carlo] outputs; add it there.")
        specification[name] = given
    return specification


def _until(table: dict[str, Any] | None, settings: MonteCarloSection, specification: dict) -> Until | None:
    if table is None:
        return None
    until, field = Until(**table), place("monte_carlo", "until")
    if settings.sampling == "latin_hypercube":
        raise Faults(
            f"{field} adds samples until an interval is narrow enough, and a Latin hypercube is made for its number of "
            'samples; use sampling = "sobol" or "random".'
        )
    if settings.samples < 2:
        raise Faults(
            f"{place('monte_carlo', 'samples')} = {settings.samples!r}: with until, the largest number; give > 1."
        )
    if until.statistic == "yield":
        if until.output is not None:
            raise Faults(f"{field}.output = {until.output!r}: the yield is that of all requirements; leave output out.")
        if not specification:
            raise Faults(f"{field}.statistic = 'yield' needs requirements; add limits under [specification].")
    elif until.output is None:
        raise Faults(f"{field}.output is missing; name the output whose {until.statistic!r} is meant.")
    elif settings.outputs is not None and until.output not in settings.outputs:
        raise Faults(f"{field}.output = {until.output!r} is not among [monte_carlo] outputs; add it there.")
    return until
