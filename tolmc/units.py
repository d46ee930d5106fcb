"""What each named quantity is called and measured in: SI inside, strings with units from people and to people."""

from __future__ import annotations

import math
import re
from decimal import Decimal
from functools import cache

#: Outputs that watch the integration; the last three only where the quantity is conserved, or is projected on.
CHECKS = ("energy_error", "constraint_error", "momentum_error", "spin_error", "energy_correction")

#: Every output of a sample, in the order in which tables show them.
OUTPUTS = (
    "tilt_angle", "effective_radius", "approximate_radius",
    *(f"contact_force_{end}_{kind}" for end in "DE" for kind in ("max", "min", "mean", "rms")),
    "tilt_max", "contact_loss_time", *CHECKS,
)  # fmt: skip

#: SI unit of every scalar of a scene and of every output, by name.
SI = {
    **dict.fromkeys(("bearing_radius", "journal_radius", "half_length"), "m"),
    "mass": "kg",
    **{f"{vector}_{axis}": "m" for vector in ("center_of_mass", "force_point") for axis in "xyz"},
    **{f"inertia_{axes}": "kg m^2" for axes in ("xx", "yy", "zz", "xy", "xz", "yz")},
    **{f"gravity_{axis}": "m/s^2" for axis in "xyz"},
    **{f"force_{axis}": "N" for axis in "xyz"},
    **{f"torque_{axis}": "N m" for axis in "xyz"},
    **dict.fromkeys(("alpha", "beta", "spin"), "rad"),
    **dict.fromkeys(("alpha_rate", "beta_rate", "spin_rate"), "rad/s"),
    **dict.fromkeys(("tilt_angle", "tilt_max"), "rad"),
    **dict.fromkeys(("effective_radius", "approximate_radius"), "m"),
    **{f"contact_force_{end}_{kind}": "N" for end in "DE" for kind in ("max", "min", "mean", "rms")},
    **dict.fromkeys(("contact_loss_time", "status_time"), "s"),
    **dict.fromkeys(CHECKS, "1"),
}

#: What people read in place of an SI unit, and how many of it one SI unit is.
ENGINEERING = {"m": ("mm", 1e3), "rad": ("deg", 180.0 / math.pi), "1": ("", 1.0)}

#: What people call the quantities whose name alone does not say it, with the model's symbol.
LABEL = {
    "bearing_radius": "Bearing radius R*", "journal_radius": "Journal radius r*", "half_length": "Half length L",
    "tilt_angle": "Tilt angle ψ", "effective_radius": "Effective radius r",
    "approximate_radius": "Approx. radius R* − r*", "tilt_max": "Largest tilt in motion",
    "alpha": "Start angle α", "beta": "Start angle β", "alpha_rate": "Start rate of α", "beta_rate": "Start rate of β",
    "spin": "Start spin χ", "spin_rate": "Spin rate Ω",
    **{
        f"contact_force_{end}_{kind}": f"Contact force N_{end}, {word}"
        for end in "DE"
        for kind, word in (("max", "max"), ("min", "min"), ("mean", "mean"), ("rms", "rms"))
    },
}  # fmt: skip

_KIND = {
    "m": "a length", "kg": "a mass", "s": "a time", "rad": "an angle", "rad/s": "an angular velocity", "N": "a force",
    "N m": "a torque", "m/s^2": "an acceleration", "kg m^2": "a moment of inertia", "1": "a plain number",
}  # fmt: skip
_EXAMPLE = {
    "m": "20 mm", "kg": "0.5 kg", "s": "1 s", "rad": "30 deg", "rad/s": "1500 rpm", "N": "12 N",
    "N m": "0.2 N m", "m/s^2": "9.81 m/s^2", "kg m^2": "120 kg mm^2",
}  # fmt: skip

# Products of several quantities must stay within the range of a double.
_LARGEST = 1e30

_PI = Decimal("3.14159265358979323846264338328")
# The units that nearly every study file uses. Pint, which reads all others, costs 0.4 s of a start.
_COMMON = {
    "m": {
        "m": Decimal(1),
        "cm": Decimal("1e-2"),
        "mm": Decimal("1e-3"),
        "um": Decimal("1e-6"),
        "µm": Decimal("1e-6"),
    },
    "kg": {"kg": Decimal(1), "g": Decimal("1e-3")},
    "s": {"s": Decimal(1), "ms": Decimal("1e-3")},
    "rad": {"rad": Decimal(1), "deg": _PI / 180, "°": _PI / 180},
    "rad/s": {"rad/s": Decimal(1), "deg/s": _PI / 180, "rpm": _PI / 30},
    "N": {"N": Decimal(1), "kN": Decimal("1e3")},
    "N m": {"N m": Decimal(1), "N mm": Decimal("1e-3")},
    "m/s^2": {"m/s^2": Decimal(1)},
    "kg m^2": {"kg m^2": Decimal(1), "kg mm^2": Decimal("1e-6")},
    "1": {"": Decimal(1), "%": Decimal("1e-2")},
}

_FACTOR = r"[^\W\d_]+(?:(?:\^|\*\*)?-?[1-9]|[²³])?"
_QUANTITY = re.compile(
    rf"\s*([+-]?(?:\d{{1,40}}\.?\d{{0,40}}|\.\d{{1,40}})(?:[eE][+-]?\d{{1,4}})?)"
    rf"\s*(%|°|(?:1\s*/\s*)?{_FACTOR}(?:\s*[*·/]\s*{_FACTOR}|\s+{_FACTOR})*|)\s*",
)


def shown(name: str) -> tuple[str, float]:
    """Unit in which the named quantity is shown to people, and its number in one SI unit."""
    return ENGINEERING.get(SI[name], (SI[name], 1.0))


def label(name: str) -> str:
    """What people call the named quantity."""
    return LABEL.get(name, name.replace("_", " ").capitalize())


def kind(unit: str) -> str:
    """What the SI unit ``unit`` measures: "a length"."""
    return _KIND[unit]


def example(unit: str) -> str | float:
    """A quantity in the SI unit ``unit`` as a study file may give it."""
    return _EXAMPLE.get(unit, 1.0)


def remedy(unit: str) -> str:
    """How a value in the SI unit ``unit`` may be given, for error messages."""
    if unit == "1":
        return "give a number"
    return f"give a number in {unit} or a string with a unit such as {_EXAMPLE[unit]!r}"


def read(value: object, unit: str) -> float:
    """Value in the SI unit ``unit`` of a number (taken as SI) or of a string that carries its unit.

    Raises
    ------
    ValueError
        When the value is no quantity, has no unit where one is needed, measures something else, or is too large
        or small.
    """
    if isinstance(value, str):
        number = _read_string(value, unit)
    elif isinstance(value, (int, float)) and not isinstance(value, bool):
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
    else:
        raise ValueError(f"expected {_KIND[unit]}; {remedy(unit)}")
    if not (number == 0 or 1 / _LARGEST <= abs(number) <= _LARGEST):
        raise ValueError(f"expected a number of a size from {1 / _LARGEST:g} to {_LARGEST:g}, or 0; {remedy(unit)}")
    return number


def _read_string(text: str, unit: str) -> float:
    match = _QUANTITY.fullmatch(text)
    if match is None:
        raise ValueError(f"expected {_KIND[unit]}; {remedy(unit)}")
    number, written = Decimal(match[1]), " ".join(match[2].replace("μ", "µ").split())
    if not written and unit != "1":
        raise ValueError(f"it has no unit; {remedy(unit)}")
    # Decimal arithmetic: "0.07 mm" is the double nearest to 7e-5, not 0.07 times an inexact 0.001.
    factor = _COMMON[unit].get(written)
    return float(number * (factor if factor is not None else _pint_factor(written, unit)))


@cache
def _registry():
    import pint

    registry = pint.UnitRegistry(non_int_type=Decimal)
    registry.define("rev = revolution")
    return registry


def _pint_factor(written: str, unit: str) -> Decimal:
    import pint

    registry = _registry()
    try:
        factor, base = registry.get_base_units(registry.Unit(written.replace("·", "*")))
    except pint.UndefinedUnitError:
        raise ValueError(f"its unit {written!r} is unknown; {remedy(unit)}") from None
    except (pint.PintError, ArithmeticError):
        raise ValueError(f"its unit {written!r} cannot be read; {remedy(unit)}") from None
    # Base units, not dimensions: pint would let 10 Hz pass for 10 rad/s, and a percentage for an angle.
    _, expected = registry.get_base_units(registry.Unit("" if unit == "1" else unit))
    if base != expected or factor is None:
        ambiguous = " (Hz and 1/s do not say whether turns or radians)" if unit == "rad/s" else ""
        raise ValueError(f"its unit {written!r} is not that of {_KIND[unit]}{ambiguous}; {remedy(unit)}")
    return Decimal(factor)
