"""A study file (TOML) -> a validated :class:`Study`.

Numbers are SI; strings carry their unit ("20 mm", "-110 deg", "1500 rpm"). Whatever is unknown, missing, of the wrong
kind or out of range ends in a :class:`StudyError` that names the field, its value, what is allowed and what to do.
"""

from __future__ import annotations

import hashlib
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations_with_replacement
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, Field, StrictBool, ValidationInfo

from tolmc import units
from tolmc.errors import InputError
from tolmc.mechanism.scene import Body, Joint, Loads, Motion, Scene
from tolmc.study.dimensions import DimensionsTable
from tolmc.study.fields import (
    Faults,
    Inertia,
    Own,
    Section,
    check_names,
    in_section,
    place,
    quantity,
    validated,
    vector,
    whole,
)
from tolmc.tolerances.dimension import Tolerances

MAX_SAMPLES = 1_000_000_000

_SOBOL_ACCURACY = 1e-8

_MASS_AND_CENTER = ("mass", *(f"center_of_mass_{axis}" for axis in "xyz"))


class StudyError(InputError):
    """A study file that cannot be used; the message names the file, the field and the remedy."""


class _Model(Section):
    section: Literal["circle", "exact"] = "circle"
    formulation: Literal["slope", "published", "published-regular"] = "slope"


class _Cylinder(Section):
    radius: quantity("m", positive=True)
    length: quantity("m", positive=True)


class _Body(Section):
    mass: quantity("kg", positive=True)
    center_of_mass: vector("m") = (0.0, 0.0, 0.0)
    inertia: Inertia | None = None
    centroidal_inertia: Inertia | None = None
    solid_cylinder: _Cylinder | None = None


class _Loads(Section):
    gravity: vector("m/s^2") = (0.0, 0.0, 0.0)
    force: vector("N") | None = None
    force_point: vector("m") | None = None
    torque: vector("N m") | None = None


class _Motion(Section):
    alpha: quantity("rad")
    beta: quantity("rad")
    alpha_rate: quantity("rad/s") = 0.0
    beta_rate: quantity("rad/s") = 0.0
    spin: quantity("rad") = 0.0
    spin_rate: quantity("rad/s") = 0.0
    duration: quantity("s", positive=True)


def _read_statistic(value: object) -> str:
    percent = re.fullmatch(r"q(\d{1,2}(?:\.\d{1,12})?)", value) if isinstance(value, str) else None
    if value not in ("mean", "sd", "yield") and not (percent and float(percent[1]) > 0):
        raise ValueError('expected "mean", "sd", "yield" or a quantile in percent such as "q99.865"')
    return value


def _read_width(value: object, info: ValidationInfo) -> float:
    output = info.data.get("output")
    if output is None and info.data.get("statistic") != "yield":
        return 1.0  # the output is at fault, which is told, and the unit not known
    width = units.read(value, units.SI[output] if output else "1")
    if width <= 0:
        raise ValueError("expected a width > 0")
    return width


class _Until(Section):
    output: Literal[units.OUTPUTS] | None = None
    statistic: Annotated[str, BeforeValidator(_read_statistic)] = Field(
        description='give "mean", "sd", "yield" or a quantile in percent such as "q99.865"'
    )
    width: Annotated[float, BeforeValidator(_read_width)] = Field(
        description="give the largest width of the interval, in the output's unit"
    )


class _MonteCarlo(Section):
    samples: whole(1, MAX_SAMPLES) = 10_000
    sampling: Literal["random", "latin_hypercube", "sobol"] = "sobol"
    seed: whole(0, 2**63 - 1) = 0
    workers: whole(1, 1024) = 2
    accuracy: quantity("1", positive=True) | None = None
    step: quantity("s", positive=True) | None = None
    method: Literal["rk4", "rk8", "auto"] = "rk8"
    on_contact_loss: Literal["stop", "continue", "end"] = "stop"
    project_energy: StrictBool = False
    halving: StrictBool = False
    outputs: list[Literal[units.OUTPUTS]] | None = None
    until: _Until | None = None


class _Limits(Section):
    min: Own | None = None
    max: Own | None = None


class _File(Section):
    title: str | None = None
    dimensions: dict[str, Any]
    correlation: dict[str, Any] = Field(default_factory=dict)
    body: _Body
    loads: _Loads = _Loads()
    motion: _Motion
    model: _Model = _Model()
    monte_carlo: _MonteCarlo = _MonteCarlo()
    specification: dict[str, Any] = Field(default_factory=dict)
    allocation: dict[str, Any] = Field(default_factory=dict)


@dataclass(frozen=True)
class Until:
    """The interval that ends sampling when it is narrow enough.

    Attributes
    ----------
    statistic : "mean", "sd", a quantile in percent such as "q99.865", or "yield"
    width : float
        Of the interval, upper less lower bound, at most; in the output's SI unit, for the yield a number.
    output : str or None
        None for the yield, the share of samples that meet every requirement.
    """

    statistic: str
    width: float
    output: str | None = None

    @property
    def level(self) -> float:
        """Share of the samples below the quantile."""
        return float(self.statistic.removeprefix("q")) / 100


@dataclass(frozen=True, eq=False)
class Study:
    """A study, checked as a whole; SI units.

    Attributes
    ----------
    name : str
        The file's name without its ending.
    title : str
    scene : Scene
        With the nominal dimensions.
    tolerances : Tolerances
        Dimensions with their distributions, correlation and lots.
    specification : {output: {"min": limit, "max": limit}}
    samples, sampling, seed, workers, accuracy, step, method, formulation, on_contact_loss, project_energy, halving, outputs
        As :func:`tolmc.run` and :func:`tolmc.simulate_many` take them.
    until : Until or None
        Where given, sampling stops when this interval is narrow enough, and ``samples`` is the largest number.
    allocation : mapping
        The [allocation] table as written, for :mod:`tolmc.allocation.allocate`.
    inertia_law : {"origin", "centroid", "cylinder"}
        What stays when mass or centre of mass vary: the inertia about O, that about the centre of mass, or the cylinder's
        shape (its inertia about the centre of mass is then proportional to the mass).
    source : str
        Text of the file.
    data_files : {relative path: content}
        Files of measured values that the study names.
    """

    name: str
    title: str
    scene: Scene
    tolerances: Tolerances
    specification: Mapping[str, Mapping[str, float]]
    samples: int
    sampling: str
    seed: int
    workers: int
    accuracy: float | None
    step: float | None
    method: str
    formulation: str
    on_contact_loss: str
    project_energy: bool
    halving: bool
    outputs: tuple[str, ...] | None
    until: Until | None
    allocation: Mapping[str, Any]
    inertia_law: Literal["origin", "centroid", "cylinder"]
    source: str
    data_files: Mapping[str, bytes]

    @cached_property
    def sha256(self) -> str:
        """Hash of the study file and of the data files it names."""
        digest = hashlib.sha256(self.source.encode())
        for name, content in sorted(self.data_files.items()):
            digest.update(hashlib.sha256(name.encode()).digest() + hashlib.sha256(content).digest())
        return digest.hexdigest()

    @property
    def integration_accuracy(self) -> float | None:
        """The accuracy asked for; where it and the step are left open, an order below what sampling leaves.

        The intervals of a Sobol' run of 10^5 samples are down to some 1e-7 of a mean; those of independent ones are a thousand
        times wider. It must not depend on the number of samples: a longer run begins with the shorter one's.
        """
        if self.accuracy is not None or self.step is not None or self.sampling != "sobol":
            return self.accuracy
        return _SOBOL_ACCURACY

    def with_inertia(self, columns: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """The columns with the inertia about O that follows from them, J = J_C + m (|c|^2 I - c c^T).

        Parameters
        ----------
        columns : mapping from names in mechanism.SCALARS to (n,) arrays, SI units

        Returns
        -------
        dict
            The same, and ``inertia_xx`` ... where mass or centre of mass vary and the body is not given about O.
        """
        if self.inertia_law == "origin" or not any(name in columns for name in _MASS_AND_CENTER):
            return dict(columns)
        nominal = self.scene.scalars
        mass, *center = (np.asarray(columns.get(name, nominal[name]), float) for name in _MASS_AND_CENTER)
        growth = mass / self.scene.body.mass if self.inertia_law == "cylinder" else 1.0
        square = sum(c * c for c in center)
        derived = {}
        for i, j in combinations_with_replacement(range(3), 2):
            shift = mass * (square * (i == j) - center[i] * center[j])
            derived[f"inertia_{'xyz'[i]}{'xyz'[j]}"] = growth * self.scene.body.centroidal_inertia[i, j] + shift
        rows = np.broadcast_shapes(*(np.shape(column) for column in columns.values()))
        return {**columns, **{name: np.broadcast_to(values, rows).copy() for name, values in derived.items()}}

    def replaced(self, *, samples: int | None = None, seed: int | None = None, workers: int | None = None) -> Study:
        """The study with another number of samples, seed or number of workers; None keeps its own.

        A number of samples given here is the number drawn: it takes the place of ``until`` too.
        """
        given = {"samples": samples, "seed": seed, "workers": workers}
        given = {name: value for name, value in given.items() if value is not None}
        try:
            validated(_MonteCarlo, given, "monte_carlo")
        except Faults as faults:
            raise StudyError("\n".join(faults.sentences)) from None
        return replace(self, **given, until=None if "samples" in given else self.until)


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
        source = path.read_bytes().decode("utf-8")
        content = tomllib.loads(source)
    except OSError as error:
        raise StudyError(f"{path} cannot be read: {error.strerror or error}. Check the path of the study.") from None
    except UnicodeDecodeError as error:
        raise StudyError(f"{path} is no text in UTF-8 (byte {error.start}); a study is a TOML file.") from None
    except (ValueError, RecursionError) as error:
        raise StudyError(f"{path} is no valid TOML: {error}. See https://toml.io for the syntax.") from None
    try:
        return _study(path.stem, source, content, Path(data_folder or path.parent))
    except Faults as faults:
        raise StudyError("\n".join(f"{path}: {sentence}" for sentence in faults.sentences)) from None


def _study(name: str, source: str, content: dict[str, Any], data_folder: Path) -> Study:
    file = validated(_File, content)
    table = DimensionsTable(file.dimensions, data_folder)
    scene = _scene(file, table.joint)
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


def _scene(file: _File, joint: dict[str, float]) -> Scene:
    with in_section("dimensions"):
        joint = Joint(**joint, section=file.model.section)
    with in_section("body"):
        body = _body(file.body)
    with in_section("loads"):
        loads = Loads(**file.loads.model_dump())
    with in_section("motion"):
        start = file.motion.model_dump()
        return Scene(joint, body, loads, duration=start.pop("duration"), motion=Motion(**start))


def _body(section: _Body) -> Body:
    ways = {name: getattr(section, name) for name in ("inertia", "centroidal_inertia", "solid_cylinder")}
    given = [name for name, value in ways.items() if value is not None]
    if len(given) != 1:
        raise ValueError(f"{' and '.join(given) or 'no inertia'} given; give one of {', '.join(ways)}.")
    if section.solid_cylinder is not None:
        cylinder = section.solid_cylinder
        return Body.solid_cylinder(section.mass, cylinder.radius, cylinder.length, section.center_of_mass)
    if section.centroidal_inertia is not None:
        return Body.from_centroidal(section.mass, section.center_of_mass, section.centroidal_inertia)
    return Body(section.mass, section.center_of_mass, section.inertia)


def _inertia_law(body: _Body, dimensions: Mapping[str, Any]) -> str:
    law = (
        "cylinder"
        if body.solid_cylinder is not None
        else "centroid"
        if body.centroidal_inertia is not None
        else "origin"
    )
    given = [name for name in dimensions if name.startswith("inertia")]
    if law != "origin" and given and any(name in dimensions for name in _MASS_AND_CENTER):
        raise Faults(
            f"{place('dimensions', given[0])} has a tolerance beside mass or centre of mass, with which the body's inertia "
            "varies by itself. Give [body] inertia about O, or leave one of them out."
        )
    return law


def _specification(table: dict[str, Any], outputs: list[str] | None) -> dict[str, dict[str, float]]:
    check_names(table, units.OUTPUTS, "specification")
    specification = {}
    for name, limits in table.items():
        limits = validated(_Limits, limits, "specification", name, context=units.SI[name])
        given = limits.model_dump(exclude_none=True)
        if not given:
            raise Faults(f"{place('specification', name)} sets no limit; give min, max or both.")
        if given.get("min", -float("inf")) > given.get("max", float("inf")):
            raise Faults(f"{place('specification', name)}: min = {limits.min!r} is above max = {limits.max!r}.")
        if outputs is not None and name not in outputs:
            raise Faults(f"{place('specification', name)} is not among [monte_carlo] outputs; add it there.")
        specification[name] = given
    return specification


def _until(table: dict[str, Any] | None, settings: _MonteCarlo, specification: dict) -> Until | None:
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
