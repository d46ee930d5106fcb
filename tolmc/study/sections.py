"""The sections of a study file, field by field: what each means, types, units, defaults and what is allowed.

`tolmc explain`, `tolmc schema` and studies/README.md say what stands here.
"""

from __future__ import annotations

import re
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, StrictBool, ValidationInfo

from tolmc import quantities, units
from tolmc.mechanism.operating import ABSOLUTE_ZERO, EXPANSION, HOTTEST, REFERENCE_TEMPERATURE
from tolmc.study.drawing import deviations
from tolmc.study.fields import (
    OWN_UNIT,
    Form,
    Inertia,
    Own,
    OwnDifference,
    Section,
    material,
    own_unit,
    pair,
    quantity,
    share,
    vector,
    whole,
)  # fmt: skip
from tolmc.study.load_sections import LoadsSection

MAX_SAMPLES = 1_000_000_000
#: A relative error beyond which no digit of a motion holds.
MAX_ACCURACY = 0.1
#: Numbers have 16 digits, of which every step takes its share.
MIN_ACCURACY = 1e-14
#: No pair of materials sticks like that.
MAX_FRICTION = 10.0
#: m²/N, 1 mm³ over a newton and a metre: a hundred times what tears a bearing apart.
MAX_WEAR_COEFFICIENT = 1e-9
#: Share of the parts that have to keep every limit, where a study does not say: ±3 sigma of a normal distribution.
TARGET_YIELD = 0.9973


def _read_deviations(value: object, info: ValidationInfo) -> tuple[float, float]:
    unit = own_unit(info)
    if isinstance(value, list):
        if len(value) != 2:
            raise ValueError("expected one tolerance, or two deviations [lower, upper]")
        lower, upper = (unit.read_difference(v) for v in value)
        return lower, upper
    if isinstance(value, str) and (written := deviations(value)) != value:
        return _read_deviations(written, info)
    tolerance = unit.read_difference(value)
    if tolerance < 0:
        raise ValueError("expected a tolerance >= 0; give two deviations [lower, upper] where they differ")
    return -tolerance, tolerance


def _read_unit(value: object, info: ValidationInfo) -> float:
    if not isinstance(value, str):
        raise ValueError('expected the unit of the column, such as "mm" (for diameters in mm: "0.5 mm")')
    unit = own_unit(info)
    if unit.unit == "°C" and value not in ("°C", "degC"):
        raise ValueError('expected a column of temperatures in "°C"')
    return unit.read(value if value[:1].isdigit() else f"1 {value}")


_Deviations = Annotated[
    tuple,
    BeforeValidator(_read_deviations),
    Form(
        'one value T for ±T, two deviations [lower, upper], or a text such as "±0.05 mm" or "+0.1/-0.2 mm"',
        {"anyOf": [OWN_UNIT, {"type": "array", "items": OWN_UNIT, "minItems": 2, "maxItems": 2}]},
    ),
]
_Unit = Annotated[
    float, BeforeValidator(_read_unit), Form('a unit, such as "mm" (for diameters in mm: "0.5 mm")', {"type": "string"})
]


def _read_part(value: object) -> float:
    part = units.read(value, "1")
    if not 0.0 <= part <= 1.0:
        raise ValueError(f"expected {_PART}")
    return part


_PART = "a number from 0 to 1, or a percentage"
_Part = Annotated[float, BeforeValidator(_read_part), Form(_PART, {"type": ["number", "string"]})]


class DimensionSection(Section):
    """One dimension: its nominal value, its limits, and what it follows between them."""

    size: str | None = None
    """Nominal value and tolerance in one text, as on the drawing: "40 ±0.05 mm", "40 +0.1/-0.2 mm", "⌀40 H7". A dimension
    that needs nothing else is this text, without a table."""
    nominal: Own | None = None
    """Value of the nominal motion. Of the joint's dimensions alone; every other scalar has it in its own table."""
    tolerance: _Deviations | None = None
    """Limits as deviations from the nominal value."""
    lower: Own | None = None
    """Lower limit, in place of a tolerance; `upper` goes with it. Without `nominal` their middle is the nominal value."""
    upper: Own | None = None
    """Upper limit."""
    diameter: str | None = None
    """Size and ISO 286 tolerance class of the diameter (of the bearing's length for half_length), such as "40 H7"."""
    distribution: str | None = None
    """What the dimension follows between its limits: "truncated_normal" (normal, cut at the limits), "normal", "uniform",
    "triangular", "beta", or the name of a continuous distribution of scipy.stats."""
    cp: quantity("1") | None = None
    """Process capability Cp of a normal distribution: the limits are 6 Cp standard deviations apart. 1 when not given."""
    cpk: quantity("1") | None = None
    """Process capability Cpk of a normal distribution, at most Cp: how far its mean is from the middle."""
    mean: Literal["nominal"] | Own | None = None
    """Mean of a normal distribution, or "nominal"; the middle of the limits when not given."""
    shift: Literal["upper", "lower"] | None = None
    """Towards which limit the mean is shifted, with `cpk`."""
    mode: Own | None = None
    """Most likely value of a triangular distribution; the middle of the limits when not given."""
    alpha: quantity("1") | None = None
    """First shape parameter of a beta distribution."""
    beta: quantity("1") | None = None
    """Second shape parameter of a beta distribution."""
    arguments: dict[str, Any] | None = None
    """Arguments of a distribution of scipy.stats, such as { loc = "20 mm", scale = "0.01 mm" }."""
    truncated: StrictBool | None = None
    """Whether a distribution of scipy.stats is cut at the limits."""
    data: str | None = None
    """CSV file of measured values, in the study's folder: samples are drawn from them."""
    column: str | None = None
    """Its column."""
    unit: _Unit | None = None
    """Unit of the column."""
    separator: Literal[",", ";", "\t", "|"] | None = None
    """What parts its columns: a comma, or a semicolon where the decimal sign is a comma, when not given."""
    decimal: Literal[".", ","] | None = None
    """Its decimal sign: a point when not given."""
    method: Literal["bootstrap", "kernel"] | None = None
    """Measured values themselves ("bootstrap"), or smoothed ("kernel")."""
    bandwidth: OwnDifference | None = None
    """Standard deviation of the smoothing; Silverman's when not given."""
    lot_share: quantity("1") | None = None
    """Share of the variance that lies between lots, 0 to 1; needs `[dimensions] lot_size`."""
    lot_sd: OwnDifference | None = None
    """Standard deviation between lots, in place of `lot_share`."""


class DimensionsSection(Section):
    """The joint's three dimensions, and every other scalar that has a tolerance: a table or a text each, by its name. The
    joint's may be given as on the drawing, bearing_diameter for bearing_radius, journal_diameter for journal_radius,
    bearing_length for half_length: everything in such a table is the diameter's or the whole length's."""

    fit: str | None = None
    """ISO 286 fit of bore and journal, such as "40 H7/d9": the limits of both radii."""
    unbalance: str | None = None
    """Balance grade of ISO 21940-11, such as "G6.3": the centre of mass lies off the axis by up to 6.3 mm/s / spin_rate."""
    lot_size: whole(1, 2**63 - 1) | None = None
    """Parts in a lot, where a dimension varies between lots."""


class _Model(Section):
    """How the joint is idealised."""

    section: Literal["circle", "exact"] = "circle"
    """"circle": the journal's axis rests on circles of constant radius, good for a small clearance; "exact": the bearing's
    rims touch the tilted cylinder."""
    formulation: Literal["slope", "published", "published-regular"] = "slope"
    """Coordinates of the equations of motion; the two others than "slope" are for comparison."""


class _Cylinder(Section):
    """A homogeneous cylinder along the journal's axis, whose inertia follows from its mass."""

    radius: quantity("m", positive=True)
    """Its radius."""
    length: quantity("m", positive=True)
    """Its length along the axis."""


class _Contact(Section):
    """What happens where the journal leaves the wall; without restitution the wall holds it."""

    restitution: quantity("1") | None = None
    """Speed after an impact over speed before, 0 to 1: the wall only pushes, and the motion goes on through flight and
    impacts."""
    contact_stiffness: quantity("N/m^1.5", positive=True) | None = None
    """Hertz's stiffness K between journal and wall, F = K δ^1.5, for the peak forces of impacts."""
    friction: quantity("1", least=0.0, most=MAX_FRICTION, example="0.1") = 0.0
    """Coefficient of Coulomb friction between journal and wall; without restitution the motion ends where contact is lost."""
    slip_speed: quantity("m/s", positive=True) = 1e-3
    """Slip below which friction falls off with it: what it leaves of sticking is a creep of about this speed."""
    wear_coefficient: quantity("m^2/N", least=0.0, most=MAX_WEAR_COEFFICIENT) = 0.0
    """Archard's k: worn volume over normal force times sliding distance, for `wear_rate` and `tolmc life`."""


class BodySection(Section):
    """The rigid body that turns in the bearing: journal and all that is fixed to it."""

    mass: quantity("kg", positive=True)
    """Its mass."""
    center_of_mass: vector("m") = (0.0, 0.0, 0.0)
    """Centre of mass from O, the point of the journal's axis in the bearing's middle plane; body axes, z along the axis."""
    inertia: Inertia | None = None
    """Inertia about O, body axes: three moments or a 3x3 matrix (off the diagonal -∫xy dm); one of three ways to give it."""
    centroidal_inertia: Inertia | None = None
    """The same about the centre of mass."""
    solid_cylinder: _Cylinder | None = None
    """The inertia of a homogeneous cylinder around the centre of mass."""


class MotionSection(Section):
    """The start of the motion, and how long it lasts. The journal's axis leaves the bearing at D (Z = +L) and E (Z = -L)."""

    alpha: quantity("rad") | None = None
    """Polar angle of D, from X towards Y: -90 deg is the bottom of a horizontal bore. With `beta`, a start on the wall."""
    beta: quantity("rad") | None = None
    """Polar angle of E."""
    alpha_rate: quantity("rad/s") | None = None
    """Rate of alpha; 0 when not given."""
    beta_rate: quantity("rad/s") | None = None
    """Rate of beta; 0 when not given."""
    origin: pair("m") | None = None
    """In place of alpha and beta, with `[contact] restitution`: where the journal's axis crosses the middle plane, anywhere
    within the clearance."""
    slope: pair("1") | None = None
    """With `origin`: dX/dZ and dY/dZ of the journal's axis."""
    origin_rate: pair("m/s") | None = None
    """Rate of origin; 0 when not given."""
    slope_rate: pair("1/s") | None = None
    """Rate of slope; 0 when not given."""
    spin: quantity("rad") = 0.0
    """Turn of the body about its axis."""
    spin_rate: quantity("rad/s") = 0.0
    """Angular velocity about its axis."""
    duration: quantity("s", positive=True)
    """How long the motion is followed."""


def _read_statistic(value: Any) -> str:
    percent = re.fullmatch(r"q(\d{1,2}(?:\.\d{1,12})?)", value) if isinstance(value, str) else None
    if value not in ("mean", "sd", "yield") and not (percent and float(percent[1]) > 0):
        raise ValueError(f"expected {_STATISTIC}")
    return value


_STATISTIC = '"mean", "sd", "yield" or a quantile in percent such as "q99.865"'


def _read_width(value: object, info: ValidationInfo) -> float:
    output = info.data.get("output")
    if output is None and info.data.get("statistic") != "yield":
        return 1.0  # the output is at fault, which is told, and the unit not known
    width = units.read(value, quantities.unit(output) if output else "1")
    if width <= 0:
        raise ValueError("expected a width > 0")
    return width


class _Until(Section):
    """The interval that ends sampling when it is narrow enough."""

    output: Literal[quantities.OUTPUTS] | None = None
    """Output whose statistic is meant; none for the yield."""
    statistic: Annotated[
        str, BeforeValidator(_read_statistic), Form(_STATISTIC, {"type": "string"}, f"give {_STATISTIC}")
    ]
    """Which statistic."""
    width: Annotated[
        float,
        BeforeValidator(_read_width),
        Form(
            "a width > 0, in the output's unit",
            {"type": ["number", "string"]},
            "give the largest width of the interval, in the output's unit",
        ),
    ]
    """Largest width of its 95 % interval, upper less lower bound."""


class MonteCarloSection(Section):
    """How many motions are sampled, and how they are integrated."""

    samples: whole(1, MAX_SAMPLES) = 10_000
    """Number of motions; with `until`, the largest."""
    sampling: Literal["random", "latin_hypercube", "sobol"] = "sobol"
    """How dimensions are drawn; "sobol" has by far the narrowest intervals."""
    seed: whole(0, 2**63 - 1) = 0
    """Seed of the draw: the same seed gives the same samples, bit for bit."""
    workers: whole(1, 1024) = 2
    """Parallel workers; the numbers do not depend on it."""
    accuracy: quantity("1", least=MIN_ACCURACY, most=MAX_ACCURACY, example="1e-6") | None = None
    """Relative error of a motion that a pilot chooses the step for; 1e-7 when not given, in Sobol' runs 1e-8."""
    step: quantity("s", positive=True) | None = None
    """Step of the integration, in place of `accuracy`."""
    method: Literal["rk4", "rk8", "auto"] = "rk8"
    """Runge-Kutta method."""
    on_contact_loss: Literal[quantities.ON_CONTACT_LOSS] = "stop"
    """What happens where the journal leaves the wall: the motion "stop"s there and its outputs count both ways, or "end"s and
    they count as they are, or may "continue" with a wall that pulls; "follow", through flight and impacts, is what
    `[contact] restitution` does."""
    project_energy: StrictBool = False
    """Whether every step is brought back to the energy at the start (and what the loads have done since)."""
    halving: StrictBool = False
    """Whether every motion is integrated with half the step too, and judged by the difference."""
    model_error: StrictBool = True
    """Whether some samples of a run on the circle run on the exact section too, and some of one that loses contact with
    restitutions of 0 and 0.5: the model's term of the error budget, for about a fiftieth of the time each."""
    outputs: list[Literal[quantities.OUTPUTS]] | None = None
    """Outputs to compute; all of them when not given. Geometry alone needs no motion and takes next to no time."""
    until: _Until | None = None
    """Sample only until an interval is narrow enough."""


class OutputSection(Section):
    """An output of the study's own, in `[outputs]`, where its text alone may stand for it."""

    value: str
    """Expression of dimensions and outputs with units: arithmetic, sin, cos, tan, asin, acos, atan, atan2, sqrt, abs, exp, log,
    hypot, min, max."""
    unit: str | None = None
    """Unit in which it is meant, where its dimension leaves that open: "deg" for an angle."""
    label: str | None = None
    """What tables call it; its name when not given."""


class SpecificationSection(Section):
    """What the motion has to keep: a table for each output that has limits, by its name, one of `[outputs]` too."""

    target: share(0.0) | None = None
    """Share of the parts that have to keep every limit, such as "99.7 %"; 99.73 % when not given."""


class LimitsSection(Section):
    """A requirement: the limits of one output."""

    min: Own | None = None
    """Lower limit."""
    max: Own | None = None
    """Upper limit."""


class OperatingSection(Section):
    """The joint in operation: what temperature and wear make of the dimensions on the drawing, which holds at 20 °C."""

    bearing_temperature: quantity("°C", least=ABSOLUTE_ZERO, most=HOTTEST) = REFERENCE_TEMPERATURE
    """Temperature of the bearing."""
    journal_temperature: quantity("°C", least=ABSOLUTE_ZERO, most=HOTTEST) = REFERENCE_TEMPERATURE
    """Temperature of the journal."""
    bearing_expansion: material(EXPANSION, "1/K") = 0.0
    """Linear expansion of the bearing, or of the bush."""
    journal_expansion: material(EXPANSION, "1/K") = 0.0
    """Linear expansion of the journal."""
    bush_wall: quantity("m", least=0.0, example='"2 mm"') = 0.0
    """Wall of a thin bush pressed into a stiff housing: its bore closes by 6 α ΔT times the wall. 0: the bearing
    grows freely."""
    bearing_wear: quantity("m", least=0.0, example='"0.05 mm"') = 0.0
    """Depth worn off the bore, on the radius."""
    journal_wear: quantity("m", least=0.0, example='"0.05 mm"') = 0.0
    """Depth worn off the journal, on the radius."""


class LifeSection(Section):
    """How the joint ages in running, for `tolmc life`: what wears off by `[contact] wear_coefficient` opens the clearance."""

    running_time: quantity("s", positive=True)
    """Running time up to which the wear is followed, such as "2000 h"."""
    steps: whole(1, 10_000) | None = None
    """Steps of equal length in which it is followed, each a study of its own; chosen on the nominal joint when not given."""
    broken_share: share(0.0, "0.05 or '5 %'") = 0.05
    """Share of the parts that may break a limit: the life is the running time until then."""
    journal_share: _Part = 0.0
    """Share of the worn volume that the journal loses, all round; the bore loses the rest."""
    contact_arc: quantity("rad") | None = None
    """Arc of the bore over which the contact wanders: there the wear is even, and at its ends the journal's own shape. That of
    the nominal motion when not given; 360 deg: all round."""


class StudyFile(Section):
    """A study: a TOML file. Numbers are in SI units; texts carry their unit."""

    title: str | None = None
    """What tables and pictures are headed with; the file's name when not given."""
    dimensions: dict[str, Any]
    correlation: dict[str, Any] = Field(default_factory=dict)
    """Correlation of two dimensions' standard normal scores (a Gaussian copula): `bearing_radius.journal_radius = 0.5`."""
    body: BodySection
    loads: LoadsSection = LoadsSection()
    motion: MotionSection
    contact: _Contact = _Contact()
    operating: OperatingSection | None = None
    life: LifeSection | None = None
    model: _Model = _Model()
    monte_carlo: MonteCarloSection = MonteCarloSection()
    outputs: dict[str, Any] = Field(default_factory=dict)
    """Outputs of the study's own, by a name of your choice: `sag = "800 mm * sin(tilt_angle)"`, or a table with value, unit and
    label. They may have limits. `tilt_angle` is the tilt that the clearance allows, `tilt_max` the largest that the motion
    reaches."""
    specification: dict[str, Any] = Field(default_factory=dict)
    allocation: dict[str, Any] = Field(default_factory=dict)
