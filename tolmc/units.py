"""Reading what people write: SI inside, strings that carry their unit from outside."""

from __future__ import annotations

import math
import re
from decimal import Decimal
from functools import cache

from tolmc.quantities import KINDS

_KINDS = {kind.unit: kind for kind in KINDS.values()}

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
    "s": {"s": Decimal(1), "ms": Decimal("1e-3"), "h": Decimal(3600)},
    "m/s": {"m/s": Decimal(1), "mm/s": Decimal("1e-3")},
    "rad": {"rad": Decimal(1), "deg": _PI / 180, "°": _PI / 180},
    "rad/s": {"rad/s": Decimal(1), "deg/s": _PI / 180, "rpm": _PI / 30},
    "N": {"N": Decimal(1), "kN": Decimal("1e3")},
    "N m": {"N m": Decimal(1), "N mm": Decimal("1e-3"), "kN m": Decimal("1e3")},
    "N s": {"N s": Decimal(1)},
    "J": {"J": Decimal(1), "mJ": Decimal("1e-3"), "kJ": Decimal("1e3")},
    "W": {"W": Decimal(1), "mW": Decimal("1e-3"), "kW": Decimal("1e3")},
    "Hz": {"Hz": Decimal(1), "kHz": Decimal("1e3")},
    "1/s": {"1/s": Decimal(1)},
    "m/s^2": {"m/s^2": Decimal(1)},
    "kg m^2": {"kg m^2": Decimal(1), "kg mm^2": Decimal("1e-6")},
    "N/m^1.5": {"N/m^1.5": Decimal(1)},
    "K": {"K": Decimal(1), "°C": Decimal(1), "degC": Decimal(1), "°F": Decimal(5) / 9, "degF": Decimal(5) / 9},
    "1/K": {"1/K": Decimal(1)},
    "m^2/N": {"mm^3/(N m)": Decimal("1e-9"), "mm³/(N m)": Decimal("1e-9")},
    "m^3/s": {"mm^3/h": Decimal("1e-9") / 3600, "mm³/h": Decimal("1e-9") / 3600},
    "1": {"": Decimal(1), "%": Decimal("1e-2")},
}
# Below this a number of kelvins is a difference that was put in a temperature's place: bearings are not that cold.
_COLDEST = 200
# Scales of temperature: degrees Celsius are (number - zero) times factor.
_TEMPERATURE = {
    **dict.fromkeys(("°C", "degC"), (Decimal(0), Decimal(1))),
    "K": (Decimal("273.15"), Decimal(1)),
    **dict.fromkeys(("°F", "degF"), (Decimal(32), Decimal(5) / 9)),
}

_FACTOR = r"[^\W\d_]+(?:(?:\^|\*\*)-?[1-9]\.[1-9]|(?:\^|\*\*)?-?[1-9]|[²³])?"
_QUANTITY = re.compile(
    rf"\s*([+-]?(?:\d{{1,40}}\.?\d{{0,40}}|\.\d{{1,40}})(?:[eE][+-]?\d{{1,4}})?)"
    rf"\s*(%|°[CF]?|(?:1\s*/\s*)?{_FACTOR}(?:\s*[*·/]\s*{_FACTOR}|\s+{_FACTOR})*"
    rf"(?:\s*/\s*\({_FACTOR}(?:(?:\s*[*·]\s*|\s+){_FACTOR})*\))?|)\s*",
)


def difference(unit: str) -> str:
    """Unit of the difference of two values in the SI unit ``unit``: temperatures in °C differ by K."""
    return "K" if unit == "°C" else unit


def kind(unit: str) -> str:
    """What the SI unit ``unit`` measures: "a length"."""
    return _KINDS[unit].words


def example(unit: str) -> str | float:
    """A quantity in the SI unit ``unit`` as a study file may give it."""
    return _KINDS[unit].example


def remedy(unit: str) -> str:
    """How a value in the SI unit ``unit`` may be given, for error messages."""
    if unit == "1":
        return "give a number"
    return f"give a number in {unit} or a string with a unit such as {_KINDS[unit].example!r}"


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
        raise ValueError(f"expected {_KINDS[unit].words}; {remedy(unit)}")
    if not (number == 0 or 1 / _LARGEST <= abs(number) <= _LARGEST):
        raise ValueError(f"expected a number of a size from {1 / _LARGEST:g} to {_LARGEST:g}, or 0; {remedy(unit)}")
    return number


def _read_string(text: str, unit: str) -> float:
    match = _QUANTITY.fullmatch(text.replace("\N{MINUS SIGN}", "-"))
    if match is None:
        raise ValueError(_slip(text, unit) or f"expected {_KINDS[unit].words}; {remedy(unit)}")
    number, written = Decimal(match[1]), " ".join(match[2].replace("μ", "µ").split())
    if not written and unit != "1":
        raise ValueError(f"it has no unit; {remedy(unit)}")
    if unit == "°C":
        return _read_temperature(number, written)
    # Decimal arithmetic: "0.07 mm" is the double nearest to 7e-5, not 0.07 times an inexact 0.001.
    factor = _COMMON.get(unit, {}).get(written)
    return float(number * (factor if factor is not None else _pint_factor(written, unit)))


def _read_temperature(number: Decimal, written: str) -> float:
    if written not in _TEMPERATURE:
        raise ValueError(f"its unit {written!r} is not that of a temperature; {remedy('°C')}")
    zero, factor = _TEMPERATURE[written]
    celsius = float((number - zero) * factor)
    if written == "K" and number < _COLDEST:
        raise ValueError(
            f"kelvins count from absolute zero, and {number:g} K is {celsius:g} °C; expected at least {_COLDEST} K, or a "
            "temperature in °C, such as '80 °C'"
        )
    return celsius


_NUMBER = r"[+-]?\d+(?:[.,]\d+)?"


def _slip(text: str, unit: str) -> str:
    """What is wrong with a text that is no quantity, where it shows one of the usual slips; otherwise nothing."""
    if mark := re.search(r"±|\+\s*/?\s*-", text):
        value, tolerance = text[: mark.start()].strip(), text[mark.end() :].strip()
        written = tolerance.lstrip("0123456789.,eE+- ")
        if not value:
            return f"a tolerance is given without its sign; write {tolerance!r}"
        value = f"{value} {written}" if re.fullmatch(_NUMBER, value) else value
        return f'a tolerance stands in a field of its own; write {{ nominal = "{value}", tolerance = "{tolerance}" }}'
    number = re.match(r"\s*[+-]?\d[\d.,'’_\s]*", text)
    if number is None:
        return ""
    digits, rest = number[0].strip().rstrip(".,"), text[number.end() :]
    if re.fullmatch(r"[+-]?\d+,\d+", digits):
        meant = f"{digits.replace(',', '.')} {rest.strip()}".strip()
        return f"its decimal sign is a comma; write {meant!r}"
    if re.search(r"\d[.,'’_\s]\d", digits) and not re.fullmatch(_NUMBER, digits):
        return f"its digits are parted by other signs than one decimal point; {remedy(unit)}"
    return ""


# What is written for a unit in other notations, without case, spaces and products' signs.
_ALIASES = {"u/min": "rpm", "1/min": "rpm", "min^-1": "rpm", "min-1": "rpm", "upm": "rpm", "rpm": "rpm", "grad": "deg"}


def _close_unit(written: str, unit: str) -> str:
    """``; did you mean 'N m'?`` where the unit is one of ours in another notation, otherwise nothing."""

    def plain(text: str) -> str:
        return re.sub(r"[\s*·.^]", "", text.replace("²", "2")).casefold()

    known = _COMMON.get(unit, {})
    close = [name for name in known if plain(name) == plain(written)]
    close += [
        name for alias, name in _ALIASES.items() if alias == written.casefold().replace(" ", "") and name in known
    ]
    return f"; did you mean {close[0]!r}?" if close else ""


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
        raise ValueError(f"its unit {written!r} is unknown{_close_unit(written, unit) or ';'} {remedy(unit)}") from None
    except (pint.PintError, ArithmeticError):
        raise ValueError(f"its unit {written!r} cannot be read; {remedy(unit)}") from None
    # Base units, not dimensions: pint would let 10 Hz pass for 10 rad/s, and a percentage for an angle.
    _, expected = registry.get_base_units(registry.Unit("" if unit == "1" else unit))
    if base != expected or factor is None:
        ambiguous = " (Hz and 1/s do not say whether turns or radians)" if unit == "rad/s" else ""
        close = _close_unit(written, unit) or ";"
        raise ValueError(f"its unit {written!r} is not that of {_KINDS[unit].words}{ambiguous}{close} {remedy(unit)}")
    return Decimal(factor)
