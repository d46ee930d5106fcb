"""The sections of a study file, field by field: types, units, defaults and what is allowed."""

from __future__ import annotations

import re
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, StrictBool, ValidationInfo

from tolmc import units
from tolmc.study.fields import Inertia, Own, Section, quantity, vector, whole

MAX_SAMPLES = 1_000_000_000


class _Model(Section):
    section: Literal["circle", "exact"] = "circle"
    formulation: Literal["slope", "published", "published-regular"] = "slope"


class _Cylinder(Section):
    radius: quantity("m", positive=True)
    length: quantity("m", positive=True)


class BodySection(Section):
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


class MonteCarloSection(Section):
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


class LimitsSection(Section):
    min: Own | None = None
    max: Own | None = None


class StudyFile(Section):
    title: str | None = None
    dimensions: dict[str, Any]
    correlation: dict[str, Any] = Field(default_factory=dict)
    body: BodySection
    loads: _Loads = _Loads()
    motion: _Motion
    model: _Model = _Model()
    monte_carlo: MonteCarloSection = MonteCarloSection()
    specification: dict[str, Any] = Field(default_factory=dict)
    allocation: dict[str, Any] = Field(default_factory=dict)
