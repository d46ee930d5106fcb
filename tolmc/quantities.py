"""Every quantity that has a name, a row each: the scalars of a scene and the outputs of a sample.

What study files may name, what tables call it, in which unit people read it, what a loss of contact leaves of it and where the
kernels have it follows from its row. A new output joins by having one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol


class _Names(Protocol):
    """What knows whether it has a name: a list, a table, the columns of a run."""

    def __contains__(self, name: str, /) -> bool: ...


@dataclass(frozen=True)
class Kind:
    """What a quantity measures: SI unit, words and an example for messages; the unit people read, and how many of it one is."""

    unit: str
    words: str
    example: str | float
    shown: str
    factor: float = 1.0


KINDS = {
    "length": Kind("m", "a length", "20 mm", "mm", 1e3),
    "mass": Kind("kg", "a mass", "0.5 kg", "kg"),
    "time": Kind("s", "a time", "1 s", "s"),
    "angle": Kind("rad", "an angle", "30 deg", "deg", 180.0 / math.pi),
    "frequency": Kind("Hz", "a frequency", "25 Hz", "Hz"),
    "angular velocity": Kind("rad/s", "an angular velocity", "1500 rpm", "rad/s"),
    "force": Kind("N", "a force", "12 N", "N"),
    "torque": Kind("N m", "a torque", "0.2 N m", "N m"),
    "rate": Kind("1/s", "a rate", "5 1/s", "1/s"),
    "contact stiffness": Kind("N/m^1.5", "a contact stiffness", "1e9 N/m^1.5", "N/m^1.5"),
    "acceleration": Kind("m/s^2", "an acceleration", "9.81 m/s^2", "m/s^2"),
    "inertia": Kind("kg m^2", "a moment of inertia", "120 kg mm^2", "kg m^2"),
    "speed": Kind("m/s", "a speed", "0.2 m/s", "m/s"),
    "impulse": Kind("N s", "an impulse", "0.1 N s", "N s"),
    "energy": Kind("J", "an energy", "0.2 J", "J"),
    "power": Kind("W", "a power", "5 W", "W"),
    "ratio": Kind("1", "a plain number", 0.5, ""),
    "wear coefficient": Kind("m^2/N", "a wear coefficient", "1e-6 mm^3/(N m)", "mm³/(N m)", 1e9),
    "volume rate": Kind("m^3/s", "a volume per time", "1 mm^3/h", "mm³/h", 3.6e12),
    "temperature": Kind("°C", "a temperature", "80 °C", "°C"),
    "temperature difference": Kind("K", "a temperature difference", "5 K", "K"),
    "expansion": Kind("1/K", "an expansion coefficient", "12e-6 1/K", "1/K"),
    "count": Kind("1", "a plain number", 1.0, ""),
    "share": Kind("1", "a plain number", 1.0, "%", 100.0),
    "error": Kind("1", "a plain number", 1.0, ""),  # relative
    "component": Kind("1", "a plain number", 1.0, ""),  # of a unit vector
}


@dataclass(frozen=True)
class Quantity:
    """A named quantity.

    ``kind`` is a name in :data:`KINDS`, ``label`` what tables call it, ``symbol`` the model's, ``row`` the kernels' name of the
    row that holds it, ``group`` what it belongs to, ``within`` what a sentence calls it (the label when not given), ``times``
    how many of the model's it is.
    """

    name: str
    kind: str
    label: str
    symbol: str = ""
    row: str = ""
    group: str = ""
    within: str = ""
    times: float = 1.0

    @property
    def phrase(self) -> str:
        """The quantity within a sentence."""
        return self.within or self.label[0].lower() + self.label[1:]


@dataclass(frozen=True)
class Scalar(Quantity):
    """A number that describes a scene, and may carry a tolerance.

    Groups: "joint", "contact", "body", "loads", "load terms" that swing, the "drive" that does, "start" of a motion on the
    wall, "free start" of one within the clearance, "spin" of both, "operating" conditions.

    A component of a vector in x, y, z says which ``axis`` of which ``vector`` it is.
    """

    vector: str = ""
    axis: str = ""


#: What may happen where contact is lost: the statistics stop, they go on two-sided, or the sample ends.
ON_CONTACT_LOSS = ("stop", "continue", "end", "follow")
#: ``Output.when`` of what is computed for those who name it alone.
ON_REQUEST = "on request"


@dataclass(frozen=True)
class Output(Quantity):
    """A number that a motion gives.

    Groups: "geometry" follows from the dimensions without a motion, and is a row of the kernels' parameters or a function of
    tolmc.mechanism.geometry; "statistics" are gathered along the motion from its
    contact forces; "integration" watches the integration; "end" is the state at the end of the motion.

    ``when``: what a scene must have for it to exist, a feature of the simulation or one of its options, "slope" the coordinates
    that are not the paper's; "" always.
    ``settled``: what of its value holds where contact is lost before the motion has ended: "at start" and "at loss" all of
    it, "grows" that it is at least as large, "falls" at most as large, "at end" nothing.
    ``event``: it is the time of something that need not happen, and NaN says that it did not.
    ``signed``: it may be negative.
    """

    when: str = ""
    settled: str = "at end"
    event: bool = False
    signed: bool = False

    @property
    def range(self) -> tuple[float, float]:
        """Between which values it always lies, SI unit: a tilt is no larger than a right angle, a share than 1."""
        if self.signed or self.group == "derived":
            return -math.inf, math.inf
        return 0.0, {"angle": 0.5 * math.pi, "share": 1.0}.get(self.kind, math.inf)


def _vector(
    name: str, kind: str, label: str, symbol: str, row: str, group: str, axes: str = "xyz"
) -> tuple[Scalar, ...]:
    return tuple(
        Scalar(f"{name}_{axis}", kind, f"{label} {axis}", f"{symbol}_{axis}", f"{row}_{axis.upper()}", group,
               vector=name, axis=axis)
        for axis in axes
    )  # fmt: skip


#: Places for parts of the loads that swing: the first half for the force, the second for the torque.
LOAD_TERMS = 4


def _term(kind: str, place: int) -> tuple[Scalar, ...]:
    """A part of a load that swings: amplitude, frequency, phase."""
    name, label, row = f"{kind}_term_{place}", f"{kind.capitalize()} term {place}", f"{kind.upper()}_TERM_{place}"
    return (
        *_vector(name, kind, label, "F" if kind == "force" else "M", row, "load terms"),
        Scalar(f"{name}_frequency", "frequency", f"{label}, frequency", "f", f"{row}_FREQUENCY", "load terms"),
        Scalar(f"{name}_phase", "angle", f"{label}, phase", "", f"{row}_PHASE", "load terms"),
    )


#: In the order in which tables show them.
SCALAR_ROWS = (
    Scalar("bearing_radius", "length", "Bearing radius R*", "R*", "BEARING_RADIUS", "joint"),
    Scalar("journal_radius", "length", "Journal radius r*", "r*", "JOURNAL_RADIUS", "joint"),
    Scalar("half_length", "length", "Half length L", "L", "HALF_LENGTH", "joint"),
    Scalar("restitution", "ratio", "Restitution e", "e", "RESTITUTION", "contact"),
    Scalar("contact_stiffness", "contact stiffness", "Contact stiffness K", "K", "CONTACT_STIFFNESS", "contact"),
    Scalar("friction", "ratio", "Friction μ", "μ", "FRICTION", "contact"),
    Scalar("slip_speed", "speed", "Slip speed v_ε", "v_ε", "SLIP_SPEED", "contact"),
    Scalar("wear_coefficient", "wear coefficient", "Wear coefficient k", "k", "WEAR_COEFFICIENT", "contact"),
    Scalar("mass", "mass", "Mass", "m", "MASS", "body"),
    *_vector("center_of_mass", "length", "Center of mass", "r_C", "COM", "body"),
    *(
        Scalar(f"inertia_{axes}", "inertia", f"Inertia {axes}", f"J_{axes}", f"J_{axes.upper()}", "body")
        for axes in ("xx", "yy", "zz", "xy", "xz", "yz")
    ),
    *_vector("gravity", "acceleration", "Gravity", "g", "GRAVITY", "loads"),
    *_vector("force", "force", "Force", "F", "FORCE", "loads"),
    *_vector("force_point", "length", "Force point", "r_F", "POINT", "loads"),
    *_vector("torque", "torque", "Torque", "M", "TORQUE", "loads"),
    *(
        scalar
        for kind in ("force", "torque")
        for place in range(1, LOAD_TERMS // 2 + 1)
        for scalar in _term(kind, place)
    ),
    Scalar("drive_amplitude", "angle", "Swing of the drive, amplitude", "φ_d", "DRIVE_AMPLITUDE", "drive"),
    Scalar("drive_frequency", "frequency", "Swing of the drive, frequency", "f_d", "DRIVE_FREQUENCY", "drive"),
    Scalar("drive_phase", "angle", "Swing of the drive, phase", "", "DRIVE_PHASE", "drive"),
    Scalar("alpha", "angle", "Start angle α", "α", "ALPHA", "start"),
    Scalar("beta", "angle", "Start angle β", "β", "BETA", "start"),
    Scalar("alpha_rate", "angular velocity", "Start rate of α", "α̇", "ALPHA_RATE", "start"),
    Scalar("beta_rate", "angular velocity", "Start rate of β", "β̇", "BETA_RATE", "start"),
    *_vector("origin", "length", "Start origin", "O", "ORIGIN", "free start", "xy"),
    *_vector("slope", "ratio", "Start slope", "s", "SLOPE", "free start", "xy"),
    *_vector("origin_rate", "speed", "Start rate of origin", "Ȯ", "ORIGIN_RATE", "free start", "xy"),
    *_vector("slope_rate", "rate", "Start rate of slope", "ṡ", "SLOPE_RATE", "free start", "xy"),
    Scalar("spin", "angle", "Start spin χ", "χ", "SPIN", "spin"),
    Scalar("spin_rate", "angular velocity", "Spin rate Ω", "Ω", "SPIN_RATE", "spin"),
    Scalar("bearing_temperature", "temperature", "Bearing temperature", "T_B", group="operating"),
    Scalar("journal_temperature", "temperature", "Journal temperature", "T_J", group="operating"),
    Scalar("bearing_expansion", "expansion", "Bearing expansion", "α_B", group="operating"),
    Scalar("journal_expansion", "expansion", "Journal expansion", "α_J", group="operating"),
    Scalar("bush_wall", "length", "Bush wall", "s", group="operating"),
    Scalar("bearing_wear", "length", "Bearing wear", "w_B", group="operating"),
    Scalar("journal_wear", "length", "Journal wear", "w_J", group="operating"),
)


def _contact_force(end: str, statistic: str, word: str, settled: str = "at end") -> Output:
    return Output(
        f"contact_force_{end}_{statistic}", "force", f"Contact force N_{end}, {statistic}", f"N_{end}",
        f"{end}_{statistic.upper()}", "statistics", f"{word} contact force N_{end}", settled=settled,
        signed=statistic != "rms",
    )  # fmt: skip


def _impacts(end: str) -> tuple[Output, ...]:
    """What impacts at one end leave; N_D and N_E of a motion that never touches there have no largest, smallest and rms."""

    def row(name: str, kind: str, label: str, within: str, when: str = "one_sided") -> Output:
        short = name.replace(f"_{end}", "").upper()
        return Output(name, kind, label, f"N_{end}", f"{end}_{short}", "statistics", within, when=when)

    return (
        row(f"impacts_{end}", "count", f"Impacts at {end}", f"number of impacts at {end}"),
        row(f"impact_speed_{end}_max", "speed", f"Impact speed at {end}, max", f"largest impact speed at {end}"),
        row(f"impulse_{end}_max", "impulse", f"Impulse at {end}, max", f"largest impulse at {end}"),
        row(f"impulse_{end}_total", "impulse", f"Impulse at {end}, total", f"sum of the impulses at {end}"),
        row(f"closed_share_{end}", "share", f"Share of time closed at {end}", f"share of time closed at {end}"),
        row(
            f"impact_force_{end}_max",
            "force",
            f"Impact force at {end}, max",
            f"largest impact force at {end}",
            "stiffness",
        ),
    )


def _friction() -> tuple[Output, ...]:
    """What friction does at the closed contacts, impacts left out, what the drive of the spin gives, and what wears."""

    def row(
        name: str,
        kind: str,
        label: str,
        symbol: str,
        key: str,
        settled: str,
        when: str = "friction",
        signed: bool = False,
    ) -> Output:
        what, _, statistic = label.partition(", ")
        word = {"max": "largest", "mean": "mean"}.get(statistic)
        within = f"{word} {what[0].lower()}{what[1:]}" if word else ""
        return Output(name, kind, label, symbol, key, "statistics", within, when=when, settled=settled, signed=signed)

    return (
        row("friction_torque_max", "torque", "Friction torque, max", "M_f", "FRICTION_TORQUE_MAX", "grows"),
        row("friction_torque_mean", "torque", "Friction torque, mean", "M_f", "FRICTION_TORQUE_MEAN", "at end"),
        row("friction_power_mean", "power", "Friction power, mean", "P_f", "FRICTION_POWER_MEAN", "at end"),
        row("friction_work", "energy", "Friction work", "W_f", "FRICTION_WORK", "grows"),
        row("slip_work_D", "energy", "Slip work at D", "N_D", "D_SLIP_WORK", "grows"),
        row("slip_work_E", "energy", "Slip work at E", "N_E", "E_SLIP_WORK", "grows"),
        row("slow_share", "share", "Share of time below the slip speed", "", "SLOW_SHARE", "at end"),
        row("whirl_rate_mean", "angular velocity", "Whirl rate, mean", "", "WHIRL_RATE_MEAN", "at end", signed=True),
        row("spin_end", "angular velocity", "Spin rate at the end", "Ω", "SPIN_END", "at end", signed=True),
        row("drive_torque_max", "torque", "Drive torque, max", "M_d", "DRIVE_TORQUE_MAX", "grows", "driven", True),
        row("drive_torque_mean", "torque", "Drive torque, mean", "M_d", "DRIVE_TORQUE_MEAN", "at end", "driven", True),
        row("drive_power_mean", "power", "Drive power, mean", "P_d", "DRIVE_POWER_MEAN", "at end", "driven", True),
        row("wear_rate", "volume rate", "Worn volume per time", "V̇", "WEAR_RATE", "at end", "wears"),
    )


#: In the order in which tables show them.
OUTPUT_ROWS = (
    *(
        Output(f"operating_{name}", "length", f"{label} in operation", symbol, name.upper(), "geometry", when="operating",
               settled="at start")
        for name, label, symbol in (("bearing_radius", "Bearing radius", "R*"), ("journal_radius", "Journal radius", "r*"),
                                    ("half_length", "Half length", "L"))
    ),
    Output("tilt_angle", "angle", "Tilt angle ψ", "ψ", group="geometry", settled="at start"),
    Output("effective_radius", "length", "Effective radius r", "r", "RADIUS", "geometry", settled="at start"),
    Output("approximate_radius", "length", "Approx. radius R* − r*", "R* − r*", group="geometry", settled="at start"),
    *(
        _contact_force(end, *statistic)
        for end in "DE"
        for statistic in (("max", "largest", "grows"), ("min", "smallest", "falls"), ("mean", "mean"), ("rms", "rms"))
    ),
    Output("tilt_max", "angle", "Largest tilt in motion", row="TILT_MAX", group="statistics", settled="grows"),
    Output(
        "contact_loss_time", "time", "Contact loss time", row="LOSS_TIME", group="statistics", settled="at loss", event=True
    ),
    *(row for end in "DE" for row in _impacts(end)),
    Output("free_share", "share", "Share of time free", row="FREE_SHARE", group="statistics", when="one_sided"),
    Output(
        "first_impact_time", "time", "First impact time", row="FIRST_IMPACT", group="statistics", when="one_sided", event=True
    ),
    Output("impact_energy_loss", "energy", "Energy lost in impacts", row="IMPACT_LOSS", group="statistics", when="one_sided"),
    *_friction(),
    Output("energy_error", "error", "Energy error", row="ENERGY_ERROR", group="integration"),
    Output("constraint_error", "error", "Constraint error", row="CONSTRAINT_ERROR", group="integration"),
    Output("step_error", "error", "Step error", row="STEP_ERROR", group="integration", when="slope"),
    Output("momentum_error", "error", "Momentum error", row="MOMENTUM_ERROR", group="integration", when="momentum"),
    Output("spin_error", "error", "Spin error", row="SPIN_ERROR", group="integration", when="spin"),
    Output(
        "energy_correction", "error", "Energy correction", row="ENERGY_CORRECTION", group="integration", when="project_energy",
        signed=True,
    ),
    *(
        Output(f"origin_{axis}_end", "length", f"Origin {axis} end", row=f"ORIGIN_{axis.upper()}", group="end",
               when=ON_REQUEST, signed=True)
        for axis in "xy"
    ),
    *(
        Output(f"axis_{axis}_end", "component", f"Axis {axis} end", row=f"AXIS_{axis.upper()}", group="end",
               when=ON_REQUEST, signed=True)
        for axis in "xyz"
    ),
)  # fmt: skip

#: What a drawing gives of the joint: twice the model's scalar, in whose numbers it is kept.
DRAWN_ROWS = (
    Quantity("bearing_diameter", "length", "Bearing diameter 2 R*", "2 R*", group="joint", times=2.0),
    Quantity("journal_diameter", "length", "Journal diameter 2 r*", "2 r*", group="joint", times=2.0),
    Quantity("bearing_length", "length", "Bearing length 2 L", "2 L", group="joint", times=2.0),
)

_OTHERS = (*DRAWN_ROWS, Quantity("duration", "time", "Duration"), Quantity("status_time", "time", "Status time"))

_ROWS: dict[str, Quantity] = {row.name: row for row in (*SCALAR_ROWS, *OUTPUT_ROWS, *_OTHERS)}

#: Every scalar of a scene that may vary from sample to sample.
SCALARS = tuple(row.name for row in SCALAR_ROWS)
#: Scalars of the joint, of the laws of contact, of the start of a motion on the wall and of one within the clearance, of the
#: turn about the axis, of the conditions in operation, of loads that swing and of a drive that does.
JOINT, CONTACT, START, FREE_START, SPIN, OPERATING, SWINGING, DRIVE = (
    tuple(row.name for row in SCALAR_ROWS if row.group == group)
    for group in ("joint", "contact", "start", "free start", "spin", "operating", "load terms", "drive")
)
#: What a drawing calls each scalar of the joint.
DRAWN = dict(zip(JOINT, (row.name for row in DRAWN_ROWS), strict=True))
#: What a body's inertia about O depends on beside its shape.
CENTER = tuple(f"center_of_mass_{axis}" for axis in "xyz")
MASS_AND_CENTER = ("mass", *CENTER)
#: Every output that a study may name.
OUTPUTS = tuple(row.name for row in OUTPUT_ROWS if row.when != ON_REQUEST)
#: Those that every scene has.
ALWAYS = tuple(row.name for row in OUTPUT_ROWS if not row.when)
#: State at the end of the motion; computed only on request.
END_OUTPUTS = tuple(row.name for row in OUTPUT_ROWS if row.group == "end")
#: Those that need no motion.
GEOMETRY = tuple(row.name for row in OUTPUT_ROWS if row.group == "geometry")
#: Those that watch the integration.
CHECKS = tuple(row.name for row in OUTPUT_ROWS if row.group == "integration")
#: Those that every motion has and that say something of the joint: what drives them can be asked.
RESPONSES = tuple(row.name for row in OUTPUT_ROWS if row.name in OUTPUTS and row.name not in CHECKS and not row.event)


_DERIVED: dict[str, Output] = {}


def derive(row: Output) -> None:
    """Make an output of a study's own known by its name, in place of another study's by that name."""
    _DERIVED[row.name] = _ROWS[row.name] = row


def derived() -> tuple[Output, ...]:
    """Outputs of a study's own that are known."""
    return tuple(_DERIVED.values())


def is_derived(name: str) -> bool:
    """Whether a study has defined the output."""
    return name in _DERIVED


def outputs_among(names: _Names) -> list[str]:
    """The outputs among the names, in the order in which tables show them, those of a study's own last."""
    return [name for name in (*OUTPUTS, *_DERIVED) if name in names]


def responses_among(names: _Names) -> list[str]:
    """The :data:`RESPONSES` among the names, and the outputs of a study's own."""
    return [name for name in (*RESPONSES, *_DERIVED) if name in names]


def of(name: str) -> Quantity:
    """The row of the named quantity."""
    return _ROWS[name]


def is_known(name: str) -> bool:
    """Whether a quantity has that name."""
    return name in _ROWS


def output(name: str) -> Output:
    """The row of the named output; one of which nothing is known but the name, for any other column of samples."""
    row = _ROWS.get(name)
    return row if isinstance(row, Output) else Output(name, "component", label(name))


def unit(name: str) -> str:
    """SI unit of the named quantity."""
    return KINDS[_ROWS[name].kind].unit


def shown(name: str) -> tuple[str, float]:
    """Unit in which the named quantity is shown to people, and its number in one SI unit."""
    row = _ROWS[name]
    kind = KINDS[row.kind]
    return kind.shown, kind.factor * row.times


def label(name: str) -> str:
    """What people call the named quantity; of any other name, its words."""
    return _ROWS[name].label if name in _ROWS else name.replace("_", " ").capitalize()
