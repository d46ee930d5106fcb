"""Checks of numbers and names that people give: what is wrong, what is allowed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np


def finite_number(owner: str, name: str, value: Any, *, positive: bool = False) -> float:
    """``value`` as a float; ``owner`` and ``name`` say in the error what it was for.

    Raises TypeError for what is no number, ValueError for one that is not finite or, where asked, not positive.
    """
    _refuse_unit(f"{owner}: {name}", value)
    if np.ma.is_masked(value):
        raise ValueError(f"{owner}: {name} is masked; give a number.")
    number = _float(value, f"{owner}: {name} must be a number in SI units")
    if not math.isfinite(number) or (positive and number <= 0):
        allowed = "a finite number > 0" if positive else "a finite number"
        raise ValueError(f"{owner}: {name} = {value!r} is out of range; allowed: {allowed}.")
    return number


def plain_array(name: str, value: Any) -> np.ndarray:
    """``value`` as an array of floats that says no less than it did: without a mask, a unit or an imaginary part.

    Raises ValueError where one of these would be lost, TypeError for what are no numbers.
    """
    _refuse_unit(name, value)
    kind = getattr(getattr(value, "dtype", None), "kind", "")
    items = value if isinstance(value, (list, tuple)) or kind == "O" else ()
    if np.ma.is_masked(value) or any(np.ma.is_masked(item) for item in items):
        raise ValueError(f"{name} has masked entries; leave them out (values.compressed()), or fill them.")
    for item in items:
        _refuse_unit(name, item)
    if np.iscomplexobj(value):
        raise ValueError(f"{name} is complex; give its real part, or its size.")
    if kind in _TIMES:
        raise ValueError(f"{name} carries a unit ({value.dtype}); give plain numbers in SI units.")
    try:
        return np.asarray(value, float)
    except (TypeError, ValueError, OverflowError):
        raise TypeError(f"{name} must be an array of numbers in SI units, got {value!r}.") from None


#: Kinds of NumPy's arrays of dates and durations, whose numbers count days or nanoseconds.
_TIMES = ("m", "M")


def _float(value: Any, demand: str) -> float:
    """``float(value)``, infinite where it is too large for one; TypeError begins with ``demand``."""
    try:
        return float(value)
    except OverflowError:
        return math.inf
    except (TypeError, ValueError):
        raise TypeError(f"{demand}, got {value!r}.") from None


def _refuse_unit(name: str, value: Any) -> None:
    """ValueError for a quantity of pint, astropy, unyt and their like: its number alone may be in millimetres."""
    if isinstance(value, (int, float)):
        return
    unit = (
        getattr(value, "dtype", None)
        if hasattr(value, "iloc")
        else getattr(value, "units", getattr(value, "unit", None))
    )
    if unit is None or (hasattr(value, "iloc") and not str(unit).startswith("pint")):
        return
    raise ValueError(
        f"{name} carries a unit ({unit}); give plain numbers in SI units, such as x.to_base_units().magnitude of pint."
    )


def finite_vector(owner: str, name: str, value: object) -> tuple[float, float, float]:
    """Three finite numbers (x, y, z)."""
    x, y, z = _components(owner, name, value, "xyz", "three")
    return x, y, z


def finite_pair(owner: str, name: str, value: object) -> tuple[float, float]:
    """Two finite numbers (x, y)."""
    x, y = _components(owner, name, value, "xy", "two")
    return x, y


def _components(owner: str, name: str, value: object, axes: str, count: str) -> list[float]:
    values = tuple(value) if isinstance(value, (tuple, list, np.ndarray)) else None
    if values is None or len(values) != len(axes):
        raise ValueError(f"{owner}: {name} must be {count} numbers ({', '.join(axes)}), got {value!r}.")
    return [finite_number(owner, f"{name}[{axis}]", v) for axis, v in zip(axes, values, strict=True)]


def set_frozen(instance: object, **values: object) -> None:
    """Set attributes of a frozen dataclass from within its ``__post_init__``."""
    for name, value in values.items():
        object.__setattr__(instance, name, value)


def choice(name: str, value: str, allowed: Sequence[str]) -> str:
    """``value`` if it is one of ``allowed``; ValueError names what is."""
    if value not in allowed:
        raise ValueError(f"{name} = {value!r} is unknown; allowed: {', '.join(allowed)}.")
    return value


def positive_number(name: str, value: Any) -> float:
    """``value`` as a finite float > 0, for arguments that belong to no object."""
    if np.ma.is_masked(value):
        raise ValueError(f"{name} is masked; give a number.")
    _refuse_unit(name, value)
    number = _float(value, f"{name} must be a number")
    if not (math.isfinite(number) and number > 0):
        raise ValueError(f"{name} = {value!r} is out of range; allowed: a finite number > 0.")
    return number
