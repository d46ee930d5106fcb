"""Numbers as a terminal shows them: few digits, powers of ten as a keyboard has them, intervals as ±."""

from __future__ import annotations

import math

from tolmc.text.numbers import NOTHING, fixed


def number(value: float | None, digits: int = 5) -> str:
    """A number to so many significant digits, without trailing zeros."""
    return NOTHING if value is None or math.isnan(value) else f"{value + 0.0:.{digits}g}"  # no -0


def to_decimals(value: float, decimals: int) -> str:
    """A number to so many decimals."""
    return NOTHING if math.isnan(value) else fixed(value, decimals)


def estimate(value: float, low: float, high: float, *, digits: int = 5) -> tuple[str, str]:
    """An estimate, and the half-width of its interval to two digits, as far as the estimate's digits go.

    The estimate has at most ``digits`` significant ones; an interval without an end is called open.
    """
    if math.isnan(value):
        return NOTHING, ""
    half = max(high - value, value - low)
    decimals = digits - 1 - (math.floor(math.log10(abs(value))) if value else 0)
    if 0 < half < math.inf:
        decimals = min(decimals, 1 - math.floor(math.log10(half)))
    if value == 0 and not 0 < half < math.inf:
        text = "0"
    else:
        text = fixed(value, decimals) if 0 <= decimals <= 7 else f"{value:.{digits if decimals < 0 else 2}g}"
    if math.isinf(half):
        return text, "open"
    if half < 0.5 * 10**-decimals:
        return text, ""
    return text, f"±{half:.{decimals}f}" if 0 <= decimals <= 7 else f"±{half:.1g}"


def share(value: float, low: float = math.nan, high: float = math.nan) -> tuple[str, str]:
    """A share in percent, or in parts per million where that reads better; its interval has a column of its own."""
    if math.isnan(value):
        return NOTHING, ""
    return f"{100 * value:.3g} %" if value == 0 or value >= 1e-3 else f"{1e6 * value:.3g} ppm", ""
