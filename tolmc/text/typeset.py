"""Numbers as a page shows them: minus signs, powers of ten, thousands apart, both ends of an interval."""

from __future__ import annotations

import math
from collections.abc import Iterable

from tolmc.text.numbers import NOTHING, fixed

MINUS = "\u2212"

_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def number(value: float | None, digits: int = 5) -> str:
    """A number to so many significant digits, without trailing zeros."""
    if value is None or math.isnan(value):
        return NOTHING
    value += 0.0  # no -0
    if math.isinf(value):
        return f"{MINUS if value < 0 else ''}∞"
    if 10**digits <= abs(value) < 1e9:
        text = f"{round(value, digits - 1 - math.floor(math.log10(abs(value)))):,.0f}"
    else:
        mantissa, _, exponent = f"{value:.{digits}g}".partition("e")
        text = f"{mantissa}·10{str(int(exponent)).translate(_SUPERSCRIPT)}" if exponent else mantissa
    return text.replace("-", MINUS)


def to_decimals(value: float, decimals: int) -> str:
    """A number to so many decimals."""
    return NOTHING if math.isnan(value) else fixed(value, decimals).replace("-", MINUS)


def estimate(
    value: float,
    low: float,
    high: float,
    *,
    suffix: str = "",
    digits: int = 6,
    exact: Iterable[float] = (0.0,),
) -> tuple[str, str]:
    """An estimate and its interval as two texts.

    The half-width decides the digits: two of its own, as long as the estimate has no more than ``digits``; a half-width
    that these do not show is written as such. Values in ``exact`` go without decimals.
    """
    if math.isnan(value):
        return NOTHING, ""
    ends = [abs(end - value) for end in (low, high) if math.isfinite(end)]
    half = max(ends, default=0.0)
    if not ends:
        return f"{number(value)}{suffix}", "open"
    if half == 0:
        return f"{number(value, digits)}{suffix}", ""
    most = digits - 1 - (math.floor(math.log10(abs(value))) if value else 0)
    decimals = min(most, 1 - math.floor(math.log10(half)))
    if decimals > 9:
        return f"{number(value, digits)}{suffix}", f"±{number(half, 2)}{suffix}"

    def text(x: float) -> str:
        places = 0 if x in exact else max(decimals, 0)
        return f"{round(x, decimals) + 0.0:,.{places}f}{suffix}".replace("-", MINUS)

    if math.isinf(low):
        return text(value), f"up to {text(high)}"
    if math.isinf(high):
        return text(value), f"from {text(low)}"
    if half < 0.5 * 10.0**-decimals:
        return text(value), f"±{number(half, 2)}{suffix}"
    return text(value), f"{text(low)} to {text(high)}"


def share(value: float, low: float, high: float) -> tuple[str, str]:
    """A share with its interval in percent."""
    return estimate(100.0 * value, 100.0 * low, 100.0 * high, suffix=" %", exact=(0.0, 100.0))


def share_of(count: float, total: float) -> str:
    """A count of the samples in percent: 100 % for all of them alone, 0 % for none."""
    digits = 3
    while count < total and number(100 * count / total, digits) == "100":
        digits += 1
    return f"{number(100 * count / total, digits)} %"


def span(low: float, high: float, digits: int = 4) -> str:
    """A range, to so many digits of its width."""
    places = max(digits - 1 - math.floor(math.log10(high - low)), 0)
    ends = [f"{end:.{places}f}" for end in (low, high)]
    while "." in ends[0] and all(end[-1] in "0." for end in ends):
        ends = [end[:-1] for end in ends]
    return " to ".join(ends).replace("-", MINUS)


def deviations(nominal: float, lower: float, upper: float) -> tuple[str, ...]:
    """Limit deviations as on a drawing: one text where they are symmetric, otherwise upper and lower."""
    below, above = number(lower - nominal), number(upper - nominal)
    if below == above == "0":
        return ()
    if below == f"{MINUS}{above}":
        return (f"±{above}",)
    return tuple(text if text == "0" or text.startswith(MINUS) else f"+{text}" for text in (above, below))
