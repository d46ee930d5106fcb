"""What a dimension follows within (or without) its limits.

A distribution turns tail probabilities into values: ``quantile(p, q, dimension)`` takes p = P(X <= x) and
q = P(X > x) = 1 - p, both given, so that either tail keeps full precision. It is monotone in p, hence it
serves inverse-transform sampling, quasi-random points and copulas alike. `dimension` supplies name, nominal,
lower and upper.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import cast

import numpy as np
import scipy  # scipy.stats, half a second, is loaded when it is first asked for
from scipy import special

from tolmc.mechanism.checks import finite_number, plain_array, set_frozen
from tolmc.tolerances.csv_column import read_column


class Distribution:
    """Interface of the distributions below."""

    #: Whether the distribution has a scale of its own; the limits are then for the drawing only.
    @property
    def stands_alone(self) -> bool:
        return False

    def check(self, dimension) -> None:
        """Raise ValueError when the distribution does not fit the dimension."""

    def in_zone(self, dimension, lower: float, upper: float) -> Distribution:
        """The distribution with the same shape between other limits than those of the dimension."""
        return self

    def quantile(self, p: np.ndarray, q: np.ndarray, dimension) -> np.ndarray:
        """Value with probability p below and q = 1 - p above it, 0 < p, q < 1, in the dimension's unit."""
        raise NotImplementedError

    def moments(self, dimension) -> tuple[float, float]:
        """Mean and standard deviation, in the dimension's unit."""
        raise NotImplementedError


def _at_same_share(value: float, dimension, lower: float, upper: float) -> float:
    """The point that divides other limits as the value divides those of the dimension."""
    width = dimension.upper - dimension.lower
    share = (value - dimension.lower) / width if width > 0.0 else 0.5
    return min(max(lower + share * (upper - lower), lower), upper)


def _positive(owner: str, **values) -> dict[str, float]:
    return {name: finite_number(owner, name, v, positive=True) for name, v in values.items() if v is not None}


@dataclass(frozen=True)
class Normal(Distribution):
    """Normal process with capability indices, its parts outside the limits rejected or kept.

    With the limits l < u, the process has mean mu and standard deviation sigma such that
    Cp = (u - l)/(6 sigma) and Cpk = min(u - mu, mu - l)/(3 sigma).

    Parameters
    ----------
    cp, cpk : float, optional
        Cpk alone means Cp = Cpk, neither means Cp = 1 (limits at +-3 sigma). Both: the mean is off the middle
        by (u - l)/2 - 3 sigma Cpk towards `shift`. With `mean` given, one of them sets sigma.
    mean : float or "nominal", optional
        mu in the dimension's unit, within the limits; the middle of the limits when not given.
    shift : {"upper", "lower"}
        The limit towards which a Cpk below Cp moves the mean.
    truncated : bool
        True: parts outside the limits are rejected. mu and sigma stay those of the process before inspection.
    """

    cp: float | None = None
    cpk: float | None = None
    mean: float | str | None = None
    shift: str = "upper"
    truncated: bool = True

    def __post_init__(self) -> None:
        set_frozen(self, **_positive("Normal", cp=self.cp, cpk=self.cpk))
        if self.mean is not None and self.mean != "nominal":
            set_frozen(self, mean=finite_number("Normal", "mean", self.mean))
        if self.shift not in ("upper", "lower"):
            raise ValueError(f"Normal: shift = {self.shift!r} is unknown; allowed: upper, lower.")
        if self.cp is not None and self.cpk is not None:
            if self.mean is not None:
                raise ValueError("Normal: mean, cp and cpk are given, two of which set the third; leave one out.")
            if self.cpk > self.cp:
                raise ValueError(
                    f"Normal: cpk = {self.cpk!r} is larger than cp = {self.cp!r}; allowed: cpk <= cp, equal "
                    "when the process is centred."
                )

    def process(self, dimension) -> tuple[float, float]:
        """Mean and standard deviation of the process before inspection, in the dimension's unit."""
        lower, upper = dimension.lower, dimension.upper
        if self.mean is not None:
            mean = dimension.nominal if isinstance(self.mean, str) else self.mean
            margin = (upper - lower) / 2 if self.cpk is None else min(upper - mean, mean - lower)
            return mean, margin / (3 * (self.cpk or self.cp or 1.0))
        half = (upper - lower) / 2
        sd = half / (3 * (self.cp or self.cpk or 1.0))
        offset = half - 3 * sd * self.cpk if self.cp and self.cpk else 0.0
        return (lower + upper) / 2 + (offset if self.shift == "upper" else -offset), sd

    def in_zone(self, dimension, lower, upper):
        if self.mean is None:
            return self
        return replace(self, mean=_at_same_share(self.process(dimension)[0], dimension, lower, upper))

    def check(self, dimension) -> None:
        mean, sd = self.process(dimension)
        if not dimension.lower <= mean <= dimension.upper or sd <= 0:
            raise ValueError(
                f"Dimension {dimension.name}: mean = {mean:.10g} of the normal distribution is out of range; "
                f"allowed: {dimension.lower:.10g} to {dimension.upper:.10g}, with cpk strictly between. Give a "
                "mean within the limits."
            )
        if self.truncated and sd > 100 * (dimension.upper - dimension.lower):
            raise ValueError(
                f"Dimension {dimension.name}: standard deviation {sd!r} is more than 100 times the width of the "
                f"limits, {dimension.upper - dimension.lower!r}; check cp, cpk and mean, or say uniform."
            )

    def _standard_limits(self, dimension):
        mean, sd = self.process(dimension)
        return mean, sd, (dimension.lower - mean) / sd, (dimension.upper - mean) / sd

    def quantile(self, p, q, dimension):
        mean, sd, a, b = self._standard_limits(dimension)
        in_lower_half = p <= q
        if self.truncated:
            inside = special.ndtr(b) - special.ndtr(a)
            tail = np.where(in_lower_half, special.ndtr(a) + inside * p, special.ndtr(-b) + inside * q)
        else:
            tail = np.minimum(p, q)
        z = special.ndtri(tail)
        x = mean + sd * np.where(in_lower_half, z, -z)
        return np.clip(x, dimension.lower, dimension.upper) if self.truncated else x

    def moments(self, dimension):
        mean, sd, a, b = self._standard_limits(dimension)
        if not self.truncated:
            return mean, sd
        inside = special.ndtr(b) - special.ndtr(a)
        at_a, at_b = (math.exp(-x * x / 2) / math.sqrt(2 * math.pi) / inside for x in (a, b))
        offset = at_a - at_b
        return mean + sd * offset, sd * math.sqrt(1 + a * at_a - b * at_b - offset**2)


@dataclass(frozen=True)
class Uniform(Distribution):
    """Equally likely between the limits."""

    def quantile(self, p, q, dimension):
        x = dimension.lower + (dimension.upper - dimension.lower) * p
        return np.clip(x, dimension.lower, dimension.upper)

    def moments(self, dimension):
        return (dimension.lower + dimension.upper) / 2, (dimension.upper - dimension.lower) / math.sqrt(12)


@dataclass(frozen=True)
class Triangular(Distribution):
    """Triangular between the limits.

    Parameters
    ----------
    mode : float, optional
        Most likely value, within the limits, in the dimension's unit; the nominal when not given.
    """

    mode: float | None = None

    def __post_init__(self) -> None:
        if self.mode is not None:
            set_frozen(self, mode=finite_number("Triangular", "mode", self.mode))

    def _mode(self, dimension) -> float:
        return dimension.nominal if self.mode is None else self.mode

    def in_zone(self, dimension, lower, upper):
        return replace(self, mode=_at_same_share(self._mode(dimension), dimension, lower, upper))

    def check(self, dimension) -> None:
        mode = self._mode(dimension)
        if not dimension.lower <= mode <= dimension.upper:
            raise ValueError(
                f"Dimension {dimension.name}: mode = {mode:.10g} of the triangular distribution is out of "
                f"range; allowed: {dimension.lower:.10g} to {dimension.upper:.10g}. Give a mode within the limits."
            )

    def quantile(self, p, q, dimension):
        lower, upper, mode = dimension.lower, dimension.upper, self._mode(dimension)
        width = upper - lower
        rising = lower + np.sqrt(p * (width * (mode - lower)))
        falling = upper - np.sqrt(q * (width * (upper - mode)))
        return np.clip(np.where(p * width < mode - lower, rising, falling), lower, upper)

    def moments(self, dimension):
        width, mode = dimension.upper - dimension.lower, self._mode(dimension) - dimension.lower
        variance = (mode**2 + width**2 - mode * width) / 18
        return dimension.lower + (mode + width) / 3, math.sqrt(variance)


@dataclass(frozen=True)
class Beta(Distribution):
    """Beta distribution stretched over the limits, density ~ (x - l)^(alpha - 1) (u - x)^(beta - 1)."""

    alpha: float
    beta: float

    def __post_init__(self) -> None:
        set_frozen(self, **_positive("Beta", alpha=self.alpha, beta=self.beta))

    def quantile(self, p, q, dimension):
        lower, upper = dimension.lower, dimension.upper
        rising = lower + (upper - lower) * special.betaincinv(self.alpha, self.beta, np.minimum(p, 0.5))
        falling = upper - (upper - lower) * special.betaincinv(self.beta, self.alpha, np.minimum(q, 0.5))
        return np.clip(np.where(p <= q, rising, falling), lower, upper)

    def moments(self, dimension):
        total = self.alpha + self.beta
        mean = dimension.lower + (dimension.upper - dimension.lower) * self.alpha / total
        variance = self.alpha * self.beta / (total**2 * (total + 1))
        return mean, (dimension.upper - dimension.lower) * math.sqrt(variance)


@dataclass(frozen=True)
class Scipy(Distribution):
    """Any continuous distribution of scipy.stats, such as ``Scipy("lognorm", {"s": 0.2, "scale": 1e-3})``.

    Parameters
    ----------
    name : str
        Its name in scipy.stats.
    arguments : mapping
        Shape parameters, loc and scale by name; loc and scale in the dimension's unit.
    truncated : bool
        True: parts outside the dimension's limits are rejected.
    """

    name: str
    arguments: Mapping[str, float] = field(default_factory=dict, hash=False)
    truncated: bool = False

    def __post_init__(self) -> None:
        distribution = getattr(scipy.stats, self.name, None)
        if not isinstance(distribution, scipy.stats.rv_continuous):
            raise ValueError(
                f"Scipy: {self.name!r} is no continuous distribution of scipy.stats; allowed: such as norm, "
                "lognorm, weibull_min, gamma."
            )
        shapes = distribution.shapes.split(", ") if distribution.shapes else []
        allowed = {*shapes, "loc", "scale"}
        arguments = {key: finite_number(self.name, key, value) for key, value in self.arguments.items()}
        if not set(shapes) <= set(arguments) <= allowed:
            raise ValueError(
                f"Scipy: {self.name} has arguments {', '.join(arguments) or 'none'}; allowed: "
                f"{', '.join([*shapes, 'loc', 'scale'])}, of which {', '.join(shapes) or 'none'} must be "
                "given."
            )
        if not math.isfinite(distribution(**arguments).ppf(0.5)):
            raise ValueError(
                f"Scipy: {self.name} does not accept {arguments}; see scipy.stats.{self.name} for the ranges."
            )
        set_frozen(self, arguments=arguments)

    @property
    def stands_alone(self) -> bool:
        return not self.truncated

    def in_zone(self, dimension, lower, upper):
        width = dimension.upper - dimension.lower
        if not self.truncated or width == 0.0:
            return self
        ratio = (upper - lower) / width
        loc = lower + ratio * (self.arguments.get("loc", 0.0) - dimension.lower)
        return replace(
            self, arguments={**self.arguments, "loc": loc, "scale": ratio * self.arguments.get("scale", 1.0)}
        )

    @cached_property
    def _frozen(self):
        return getattr(scipy.stats, self.name)(**self.arguments)

    def _tails(self, dimension) -> tuple[float, float, float]:
        below, above = self._frozen.cdf(dimension.lower), self._frozen.sf(dimension.upper)
        # Within a tail the difference of that tail is the precise one. Across the middle neither tail is asked beyond
        # it, where those that SciPy integrates numerically may miss the peak of the density.
        if below > 0.5:
            inside = self._frozen.sf(dimension.lower) - above
        elif above > 0.5:
            inside = self._frozen.cdf(dimension.upper) - below
        else:
            inside = 1.0 - below - above
        return float(below), float(above), float(inside)

    def check(self, dimension) -> None:
        if self.truncated and not self._tails(dimension)[2] >= 1e-6:  # NaN as well
            raise ValueError(
                f"Dimension {dimension.name}: {self.name} has less than 1e-6 of its probability between the "
                f"limits {dimension.lower!r} and {dimension.upper!r}; check loc and scale, which are in SI "
                "units."
            )

    def quantile(self, p, q, dimension):
        if self.truncated:
            below, above, inside = self._tails(dimension)
            p, q = below + inside * p, above + inside * q
        x = np.where(p <= q, self._frozen.ppf(np.minimum(p, 0.5)), self._frozen.isf(np.minimum(q, 0.5)))
        return np.clip(x, dimension.lower, dimension.upper) if self.truncated else x

    def moments(self, dimension):
        if not self.truncated:
            return float(self._frozen.mean()), float(self._frozen.std())
        below, _, inside = self._tails(dimension)
        return _moments_of_quantile(
            lambda p, q: self.quantile(p, q, dimension), split=min(max((0.5 - below) / inside, 0.0), 1.0)
        )


@dataclass(frozen=True, eq=False)
class Measured(Distribution):
    """Measured values of the dimension.

    Parameters
    ----------
    values : array_like (n,)
        In the dimension's unit; finite, at least two different ones.
    method : {"bootstrap", "kernel"}
        "bootstrap": the measured values themselves, equally likely. "kernel": a Gaussian kernel around each,
        which also gives values between and beyond them.
    bandwidth : float, optional
        The kernel's standard deviation, in the dimension's unit; Silverman's sd (3n/4)^(-1/5) when not given.
    """

    values: np.ndarray
    method: str = "bootstrap"
    bandwidth: float = cast(float, None)  # None: the rule of thumb, for the kernel method alone

    stands_alone = True

    def __post_init__(self) -> None:
        values = np.sort(plain_array("Measured: values", self.values).ravel())
        if not np.all(np.isfinite(values)) or len(values) < 2 or values[0] == values[-1]:
            raise ValueError(
                f"Measured: {len(values)} values, {np.isfinite(values).sum()} of them finite; allowed: "
                "finite values, at least two different ones. Leave out what is missing, or give the "
                "dimension limits."
            )
        if self.method not in ("bootstrap", "kernel"):
            raise ValueError(f"Measured: method = {self.method!r} is unknown; allowed: bootstrap, kernel.")
        if self.method == "kernel" and self.bandwidth is None:
            set_frozen(self, bandwidth=float(np.std(values, ddof=1) * (0.75 * len(values)) ** -0.2))
        values.setflags(write=False)
        set_frozen(self, values=values, **_positive("Measured", bandwidth=self.bandwidth))

    @classmethod
    def from_csv(
        cls, path, column: str, *, unit: float = 1.0, separator: str | None = None, decimal: str = ".", **options
    ) -> Measured:
        """Values of a column of a CSV file with a header line, times `unit` (1e-3 for a column in mm).

        ``separator``, ``decimal`` and errors as in :func:`tolmc.tolerances.csv_column.read_column`.
        """
        values = read_column(Path(path).read_bytes(), f"Measured: {path}", column, separator=separator, decimal=decimal)
        return cls(values * unit, **options)

    def __eq__(self, other) -> bool:
        return (
            isinstance(other, Measured)
            and (self.method, self.bandwidth) == (other.method, other.bandwidth)
            and np.array_equal(self.values, other.values)
        )

    def __hash__(self) -> int:
        return hash((self.method, self.bandwidth, self.values.tobytes()))

    @cached_property
    def _kernel_quantile(self) -> scipy.interpolate.PchipInterpolator:
        # Against the standard normal score of its distribution function x is close to a line, even in the
        # tails where the function is flat: monotone cubics reproduce it to 2e-6.
        h, x = self.bandwidth, self.values
        spacing = max(h / 8, (x[-1] - x[0]) / 4096)
        nodes = np.arange(x[0] - 12 * h, x[-1] + 12 * h + spacing, spacing)
        below = np.array([special.ndtr((node - x) / h).mean() for node in nodes])
        above = np.array([special.ndtr((x - node) / h).mean() for node in nodes])
        scores = np.maximum.accumulate(_score(below, above))
        rising = np.diff(scores, prepend=-np.inf) > 1e-12  # flat in gaps between far values
        return scipy.interpolate.PchipInterpolator(scores[rising], nodes[rising])

    def quantile(self, p, q, dimension):
        if self.method == "bootstrap":
            n = len(self.values)
            return self.values[np.minimum((p * n).astype(np.int64), n - 1)]
        nodes = self._kernel_quantile.x
        return self._kernel_quantile(np.clip(_score(p, q), nodes[0], nodes[-1]))

    def moments(self, dimension):
        variance = np.var(self.values) + (self.bandwidth**2 if self.method == "kernel" else 0.0)
        return float(self.values.mean()), math.sqrt(variance)


def _double_exponential() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """p, 1 - p and weights of the integral over 0 < p < 1 that no singularity at its ends disturbs (Takahasi & Mori 1974)."""
    t = np.arange(-3.3, 3.3 + 1 / 32, 1 / 16)
    s = math.pi * np.sinh(t)
    p, q = special.expit(s), special.expit(-s)
    weights = np.cosh(t) * p * q
    return p, q, weights / weights.sum()


def _moments_of_quantile(quantile, *, split: float) -> tuple[float, float]:
    """Mean and standard deviation of a bounded quantile function, from itself.

    Integrals of the density in the dimension's own unit would look for a peak of micrometres somewhere in metres. The
    ``split`` is where a quantile function may have a cusp within (0, 1): where the density of a symmetric one vanishes.
    """
    p, q, weights = _double_exponential()
    values, masses = [], []
    for start, end in ((0.0, split), (split, 1.0)):
        if end > start:
            values.append(quantile(start + (end - start) * p, (1.0 - end) + (end - start) * q))
            masses.append((end - start) * weights)
    x, mass = np.concatenate(values), np.concatenate(masses)
    # Deviations from a value of its own: a spread of micrometres keeps its digits beside a mean of metres.
    deviations = x - x[len(x) // 2]
    offset = float(mass @ deviations)
    return float(x[len(x) // 2] + offset), math.sqrt(float(mass @ np.square(deviations - offset)))


def _score(p, q):
    """Standard normal score of the tail probabilities p below and q above."""
    z = special.ndtri(np.minimum(p, q))
    return np.where(p <= q, z, -z)
