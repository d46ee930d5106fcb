"""Numbers, limits, distributions and verdicts as a reader of the report meets them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from tolmc import quantities
from tolmc.statistics.intervals import Estimate
from tolmc.tolerances.dimension import Dimension
from tolmc.tolerances.distributions import Beta, Measured, Normal, Scipy, Triangular

MINUS, NOTHING = "\u2212", "–"
#: Where in a dimension failures lie, by the words of :func:`tolmc.analysis.failure_sources.failure_sources`.
PLACES = {
    "high": "{share} lie in the highest quarter",
    "low": "{share} lie in the lowest quarter",
    "middle": "{share} lie in the middle half",
    "both ends": "{share} lie in the two outer quarters",
}
SAMPLINGS = {"sobol": "scrambled Sobol' points", "latin_hypercube": "Latin hypercube", "random": "random sampling"}
MET, BROKEN, OPEN = "met", "not met", "not decided"

#: What the outputs of a sample that lost contact say, by the study's on_contact_loss.
AFTER_LOSS = {
    "stop": "their outputs hold up to that instant, and what follows is not known",
    "end": "their motion ends there, as the study has it",
    "continue": "they go on as if the wall could pull, as the study has it",
}

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


def estimate(
    value: float,
    low: float,
    high: float,
    *,
    factor: float = 1.0,
    suffix: str = "",
    digits: int = 6,
    exact: Iterable[float] = (0.0,),
) -> tuple[str, str]:
    """An estimate and its interval as two texts, in ``factor`` times their unit.

    The half-width decides the digits: two of its own, as long as the estimate has no more than ``digits``; a half-width
    that these do not show is written as such. Values in ``exact`` go without decimals.
    """
    value, low, high = value * factor, low * factor, high * factor
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
    return estimate(value, low, high, factor=100.0, suffix=" %", exact=(0.0, 100.0))


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


def unit(name: str) -> str:
    """The unit in which people read the named quantity."""
    return quantities.shown(name)[0].replace("^2", "²")


def quantity(name: str, value: float, digits: int = 6) -> str:
    """A value of the named quantity with the unit in which people read it."""
    return f"{number(value * quantities.shown(name)[1], digits)} {unit(name)}".rstrip()


def phrase(name: str) -> str:
    """The named quantity within a sentence."""
    return quantities.of(name).phrase


def limits(name: str, minimum: float, maximum: float) -> str:
    """The limits of a requirement, NaN where there is none."""
    ends = [f"≥ {quantity(name, minimum)}"] if not math.isnan(minimum) else []
    ends += [f"≤ {quantity(name, maximum)}"] if not math.isnan(maximum) else []
    return " and ".join(ends)


def deviations(nominal: float, lower: float, upper: float) -> tuple[str, ...]:
    """Limit deviations as on a drawing: one text where they are symmetric, otherwise upper and lower."""
    below, above = number(lower - nominal), number(upper - nominal)
    if below == above == "0":
        return ()
    if below == f"{MINUS}{above}":
        return (f"±{above}",)
    return tuple(text if text == "0" or text.startswith(MINUS) else f"+{text}" for text in (above, below))


def distribution(dimension: Dimension) -> str:
    """What the dimension follows, in words."""
    if not dimension.is_varied:
        return "exact"
    follows, name = dimension.distribution, dimension.name
    match follows:
        case Normal():
            mean, sd = follows.process(dimension)
            kept = ", parts outside the limits rejected" if follows.truncated else ""
            return f"normal, mean {quantity(name, mean)}, sd {quantity(name, sd, 3)}{kept}"
        case Triangular():
            mode = dimension.nominal if follows.mode is None else follows.mode
            return f"triangular, most often {quantity(name, mode)}"
        case Beta():
            return f"beta, α = {number(follows.alpha)}, β = {number(follows.beta)}"
        case Scipy():
            arguments = ", ".join(f"{key} = {value:.6g}" for key, value in follows.arguments.items())
            kept = ", parts outside the limits rejected" if follows.truncated else ""
            return f"{follows.name} of scipy.stats ({arguments}; SI units){kept}"
        case Measured():
            way = {"bootstrap": "drawn as they are", "kernel": "smoothed by a Gaussian kernel"}[follows.method]
            return f"{len(follows.values):,} measured values, {way}"
    return type(follows).__name__.lower()


def joined(parts: Iterable[str], last: str = "and") -> str:
    """``a, b and c``."""
    *first, final = [*parts] or [""]
    return f"{', '.join(first)} {last} {final}" if first else final


def requirement(name: str, bounds: Mapping[str, float]) -> str:
    """A requirement within a sentence: ``the tilt angle ψ ≤ 24.45 deg``."""
    return f"the {phrase(name)} {limits(name, bounds.get('min', math.nan), bounds.get('max', math.nan))}"


def judged(found: Estimate, target: float) -> str:
    """Whether a yield reaches the target: decided only where its whole interval lies on one side."""
    if found.low >= target:
        return MET
    return BROKEN if found.high < target else OPEN
