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
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise TypeError(f"{owner}: {name} must be a number in SI units, got {value!r}.") from None
    if not math.isfinite(number) or (positive and number <= 0):
        allowed = "a finite number > 0" if positive else "a finite number"
        raise ValueError(f"{owner}: {name} = {value!r} is out of range; allowed: {allowed}.")
    return number


def finite_vector(owner: str, name: str, value: object) -> tuple[float, float, float]:
    """Three finite numbers (x, y, z)."""
    values = tuple(value) if isinstance(value, (tuple, list, np.ndarray)) else None
    if values is None or len(values) != 3:
        raise ValueError(f"{owner}: {name} must be three numbers (x, y, z), got {value!r}.")
    x, y, z = (finite_number(owner, f"{name}[{axis}]", v) for axis, v in zip("xyz", values, strict=True))
    return x, y, z


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
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise TypeError(f"{name} must be a number, got {value!r}.") from None
    if not (math.isfinite(number) and number > 0):
        raise ValueError(f"{name} = {value!r} is out of range; allowed: a finite number > 0.")
    return number
