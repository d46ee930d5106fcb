"""Dimensions with tolerances, their correlation and lots -> samples of the dimensions.

Every sample goes the same way: a point of the unit cube (a coordinate for each varied dimension) -> standard
normal scores -> lots and correlation (a Gaussian copula) -> the dimensions' distributions. What has no
tolerance consumes no coordinate and stays exactly at its nominal value.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from operator import index
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike

from tolmc.mechanism.checks import finite_number, set_frozen
from tolmc.quantities import DRAWN, JOINT, SCALARS, SWINGING
from tolmc.tolerances import fits
from tolmc.tolerances import unit_cube as _sampling
from tolmc.tolerances.correlation import Pairs, correlation_matrix, is_semidefinite, lower_factor, worst_pair
from tolmc.tolerances.distributions import Distribution, Normal

SCRAMBLINGS = _sampling.SCRAMBLINGS

_POSITIVE = ("bearing_radius", "journal_radius", "half_length", "mass", "contact_stiffness", "slip_speed")
_NOT_NEGATIVE = (
    "restitution", "friction", "wear_coefficient", "bush_wall", "bearing_wear", "journal_wear", "drive_frequency",
    *(name for name in SWINGING if name.endswith("_frequency")),
)  # fmt: skip

# Halves of what a drawing gives and ISO 286 tolerates: bore, journal diameter, bearing length.
_HALVES = JOINT

# Shares below the natural tolerance limits: +-3 sigma of a normal distribution.
_NATURAL = np.array([0.00135, 0.99865])


@dataclass(frozen=True)
class Dimension:
    """A scalar of the scene with its limits and what it follows between them. SI units.

    Parameters
    ----------
    name : str
        One of :data:`tolmc.quantities.SCALARS`.
    nominal : float
        Value of the nominal motion, and of every sample without a tolerance; may lie outside the limits.
    lower, upper : float, optional
        Limits (values, not deviations). Without them, and for ``lower == upper == nominal``, there is no
        tolerance, unless the distribution has a scale of its own (measured data, scipy.stats): the limits are
        then its natural ones, the quantiles 0.135 % and 99.865 %.
    distribution : Distribution
        Normal with Cp = 1, truncated at the limits, when not given.
    lot_share : float, optional
        Share of the variance that lies between lots, 0 to 1 (of the standard normal score, which for a normal
        dimension is the same).
    lot_sd : float, optional
        Standard deviation between lots, in the dimension's unit; in place of `lot_share` = (lot_sd/sd)^2.
    toleranced_size : str, optional
        Size and ISO 286 tolerance class of the diameter (of the bearing's length 2 L), such as "40 H7", when
        the limits come from it.
    is_drawn : bool
        Whether it was given as a drawing does, the diameter or the bearing's length: people are then shown twice the values.

    Raises
    ------
    ValueError, TypeError
        The message names the dimension, the value, what is allowed and what to do.
    """

    name: str
    nominal: float
    lower: float = cast(float, None)  # None: the nominal value, or the distribution's own limits, from __post_init__ on
    upper: float = cast(float, None)
    distribution: Distribution = field(default_factory=Normal)
    lot_share: float | None = None
    lot_sd: float | None = None
    toleranced_size: str | None = None
    is_drawn: bool = False

    def __post_init__(self) -> None:
        if self.name not in SCALARS:
            raise ValueError(f"Dimension: {self.name!r} is unknown; allowed: {', '.join(SCALARS)}.")
        if not isinstance(self.distribution, Distribution):
            raise TypeError(
                f"{self._owner}: distribution must be one of tolmc.tolerances.distributions, got {self.distribution!r}."
            )
        set_frozen(self, nominal=finite_number(self._owner, "nominal", self.nominal), **self._limits())
        self._check_limits()
        if self.toleranced_size is not None:
            self._check_toleranced_size(self.toleranced_size)
        if self.is_varied:
            self.distribution.check(self)
        self._check_lots()

    @property
    def _owner(self) -> str:
        return f"Dimension {self.name}"

    def _limits(self) -> dict[str, float]:
        names = ("lower", "upper")
        if (self.lower is None) != (self.upper is None):
            raise ValueError(f"{self._owner}: only one limit is given; give lower and upper, or neither.")
        if self.lower is not None:
            return {name: finite_number(self._owner, name, getattr(self, name)) for name in names}
        if self.distribution.stands_alone:
            return dict(zip(names, self.ppf(_NATURAL).tolist(), strict=True))
        return {name: finite_number(self._owner, "nominal", self.nominal) for name in names}

    def _check_limits(self) -> None:
        if self.lower > self.upper:
            raise ValueError(
                f"{self._owner}: lower = {self.lower:.10g} is above upper = {self.upper:.10g}; exchange the limits."
            )
        if not self.is_varied and self.lower != self.nominal:
            raise ValueError(
                f"{self._owner}: lower = upper = {self.lower!r} differs from nominal = {self.nominal!r}; "
                "allowed: the three equal, for no tolerance. Give the nominal that value, or a tolerance."
            )
        least, most = min(self.lower, self.nominal), max(self.upper, self.nominal)
        if self.name in _POSITIVE and least <= 0:
            allowed = "> 0"
        elif self.name in _NOT_NEGATIVE and least < 0:
            allowed = ">= 0"
        elif self.name == "restitution" and most > 1:
            allowed = "0 to 1"
        else:
            return
        raise ValueError(
            f"{self._owner}: nominal = {self.nominal:.10g}, limits {self.lower:.10g} to {self.upper:.10g}; "
            f"allowed: {allowed}. Check the units and the signs of the deviations, or narrow the tolerance."
        )

    def _check_toleranced_size(self, toleranced_size: str) -> None:
        limits = _class_limits(self.name, toleranced_size)
        if not np.allclose((self.lower, self.upper), limits, rtol=1e-12, atol=0.0):
            raise ValueError(
                f"{self._owner}: lower = {self.lower!r}, upper = {self.upper!r} are not the limits of its "
                f"toleranced_size {self.toleranced_size!r}; allowed: {limits[0]!r} and {limits[1]!r}. Leave "
                "toleranced_size out (None) when the limits are others."
            )

    def _check_lots(self) -> None:
        if self.lot_share is not None and self.lot_sd is not None:
            raise ValueError(f"{self._owner}: lot_share and lot_sd are given; leave one out.")
        for name, largest in (("lot_share", 1.0), ("lot_sd", self.sd if self.lot_sd is not None else 0.0)):
            if getattr(self, name) is None:
                continue
            if not np.isfinite(largest):
                raise ValueError(
                    f"{self._owner}: its distribution has no standard deviation; give lot_share for {name}."
                )
            value = finite_number(self._owner, name, getattr(self, name))
            if not 0 <= value <= largest and self.is_varied:
                raise ValueError(
                    f"{self._owner}: {name} = {value!r} is out of range; allowed: 0 to {largest!r}, the "
                    "whole variation. Reduce it, or widen the tolerance."
                )
            set_frozen(self, **{name: value})

    @property
    def shown_name(self) -> str:
        """Name of the quantity that people are shown: what the drawing gives, where the dimension came from there."""
        return DRAWN[self.name] if self.is_drawn or self.toleranced_size is not None else self.name

    @property
    def is_varied(self) -> bool:
        """Whether samples differ in this dimension."""
        return self.distribution.stands_alone or self.upper > self.lower

    @property
    def between_lots(self) -> float:
        """Share of the variance between lots."""
        if self.lot_sd is None or not self.is_varied:
            return self.lot_share or 0.0
        return (self.lot_sd / self.sd) ** 2

    @property
    def mean(self) -> float:
        """Mean of the samples."""
        return self._moments[0]

    @property
    def sd(self) -> float:
        """Standard deviation of the samples."""
        return self._moments[1]

    @cached_property
    def _moments(self) -> tuple[float, float]:
        return self.distribution.moments(self) if self.is_varied else (self.nominal, 0.0)

    def ppf(self, u: ArrayLike) -> np.ndarray:
        """Value below which the share u of the samples lies, 0 < u < 1."""
        p = np.asarray(u, float)
        return self.quantile(p, 1.0 - p)[()]

    def quantile(self, p: np.ndarray, q: np.ndarray) -> np.ndarray:
        """:meth:`ppf` of p, given q = 1 - p too, which keeps the precision of the upper tail."""
        return self.distribution.quantile(p, q, self) if self.is_varied else np.full(np.shape(p), self.nominal)

    @classmethod
    def symmetric(cls, name: str, nominal: float, tolerance: float, **options: Any) -> Dimension:
        """nominal +- tolerance; `options` as in the class."""
        tolerance = finite_number(f"Dimension {name}", "tolerance", tolerance)
        if tolerance < 0:
            raise ValueError(f"Dimension {name}: tolerance = {tolerance!r} is out of range; allowed: >= 0.")
        return cls.from_deviations(name, nominal, -tolerance, tolerance, **options)

    @classmethod
    def from_deviations(cls, name: str, nominal: float, lower: float, upper: float, **options: Any) -> Dimension:
        """nominal with lower and upper deviation, such as -0.03e-3 and 0; `options` as in the class."""
        owner = f"Dimension {name}"
        nominal = finite_number(owner, "nominal", nominal)
        lower, upper = finite_number(owner, "lower deviation", lower), finite_number(owner, "upper deviation", upper)
        return cls(name, nominal, nominal + lower, nominal + upper, **options)

    @classmethod
    def from_limits(cls, name: str, lower: float, upper: float, **options: Any) -> Dimension:
        """Limits alone; the nominal is their middle. `options` as in the class."""
        owner = f"Dimension {name}"
        lower, upper = finite_number(owner, "lower", lower), finite_number(owner, "upper", upper)
        return cls(name, lower + (upper - lower) / 2, lower, upper, **options)

    @classmethod
    def from_tolerance_class(cls, name: str, designation: str, **options: Any) -> Dimension:
        """A radius or half-length from the size on the drawing, such as ``"40 H7"`` for bearing_radius.

        The nominal is the middle of the limits: equal basic sizes of hole and shaft leave no clearance.
        """
        return cls.from_limits(name, *_class_limits(name, designation), toleranced_size=designation, **options)

    def in_class(self, designation: str) -> Dimension:
        """The dimension in another tolerance class, such as "40 H7"; its distribution keeps its shape.

        Raises
        ------
        ValueError
            When the class is none of this dimension, or its distribution has limits of its own (measured values).
        """
        if self.distribution.stands_alone:
            raise ValueError(
                f"{self._owner}: its distribution has limits of its own, which no tolerance class changes."
            )
        named = Dimension.from_tolerance_class(self.name, designation)
        lots: dict[str, Any] = {"lot_sd": None, "lot_share": self.between_lots} if self.lot_sd is not None else {}
        distribution = self.distribution.in_zone(self, named.lower, named.upper) if self.is_varied else Normal()
        return replace(
            self, nominal=named.nominal, lower=named.lower, upper=named.upper, distribution=distribution,
            toleranced_size=designation, **lots,
        )  # fmt: skip

    @classmethod
    def from_fit(cls, designation: str, **options: Any) -> tuple[Dimension, Dimension]:
        """bearing_radius and journal_radius of an ISO 286 fit such as ``"40 H7/d9"``.

        The nominals are the middles of the limits: the fit's nominal diameter, common to both, leaves no
        clearance. `options` as in the class, for both.
        """
        hole, shaft = fits.fit(designation).toleranced_sizes
        return (
            cls.from_tolerance_class("bearing_radius", hole, **options),
            cls.from_tolerance_class("journal_radius", shaft, **options),
        )


def _class_limits(name: str, designation: str) -> tuple[float, float]:
    """Limits of a radius or half-length, m: half of those of the toleranced size."""
    if name not in _HALVES:
        raise ValueError(
            f"Dimension {name}: the tolerance class {designation!r} is for a size; allowed: for "
            f"{', '.join(_HALVES)}. Give limits instead."
        )
    is_hole = fits.is_hole(designation)
    if (name, is_hole) in (("bearing_radius", False), ("journal_radius", True)):
        taken, meant = ("hole", "shaft") if is_hole else ("shaft", "hole")
        raise ValueError(
            f"Dimension {name}: the class of {designation!r} is that of a {taken}; {name} is a {meant}'s, whose letter is "
            f"{'small' if is_hole else 'a capital'}. Write {fits.exchanged(designation)!r}, or give limits."
        )
    _, lower, upper = fits.size_limits(designation)
    return lower / 2, upper / 2


@dataclass(frozen=True)
class Tolerances:
    """The dimensions of a study, how they correlate, and their lots.

    Parameters
    ----------
    dimensions : sequence of Dimension
        Each scalar once.
    correlation : mapping of name pairs, or (k, k) matrix in the order of `dimensions`, optional
        Correlation rho of the standard normal scores (Gaussian copula): Pearson's for normal dimensions; for
        any, Spearman's is (6/pi) asin(rho/2). Entries of dimensions without tolerance have no effect.
    lot_size : int, optional
        Parts in a lot; needed when a dimension varies between lots. The parts of a lot share its shift; every
        dimension's distribution and the correlations are those without lots.

    Raises
    ------
    ValueError, TypeError
        The message names the dimension or the pair, the value, what is allowed and what to do.
    """

    dimensions: tuple[Dimension, ...]
    correlation: Pairs | ArrayLike | None = None
    lot_size: int | None = None

    if TYPE_CHECKING:  # any sequence may be given, a tuple is kept

        def __init__(
            self,
            dimensions: Sequence[Dimension],
            correlation: Pairs | ArrayLike | None = None,
            lot_size: int | None = None,
        ) -> None: ...

    def __post_init__(self) -> None:
        set_frozen(self, dimensions=tuple(self.dimensions))
        for dimension in self.dimensions:
            if not isinstance(dimension, Dimension):
                raise TypeError(f"Tolerances: dimensions must be Dimension objects, got {dimension!r}.")
        for k, name in enumerate(self.names):
            if name in self.names[:k]:
                raise ValueError(f"Tolerances: dimension {name} is given twice; leave one out.")
        if self.correlation is not None:
            matrix = correlation_matrix(self.names, self.correlation)
            set_frozen(self, correlation=tuple(map(tuple, matrix.tolist())))
        if self.lot_size is not None:
            set_frozen(self, lot_size=_lot_size(self.lot_size))
        self._check_lots()

    def _check_lots(self) -> None:
        if self.lot_size is None and self._between_lots.any():
            name = self.varied[int(np.argmax(self._between_lots))].name
            raise ValueError(f"Tolerances: {name} varies between lots, but lot_size is missing; give it.")
        if not is_semidefinite(self._within_lots):
            a, b = worst_pair(tuple(dimension.name for dimension in self.varied), self._within_lots)
            raise ValueError(
                f"Tolerances: the correlation of {a} and {b} cannot be met, as one varies mostly between "
                "lots and the other mostly within; give them closer lot shares, or a smaller correlation."
            )

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all dimensions, varied or not: the columns of a sample."""
        return tuple(dimension.name for dimension in self.dimensions)

    @property
    def shown_names(self) -> dict[str, str]:
        """What people are shown in place of a dimension's name: {name: :attr:`Dimension.shown_name`}."""
        return {dimension.name: dimension.shown_name for dimension in self.dimensions}

    @cached_property
    def varied(self) -> tuple[Dimension, ...]:
        """The dimensions with a tolerance: the coordinates of a sample."""
        return tuple(dimension for dimension in self.dimensions if dimension.is_varied)

    @cached_property
    def _between_lots(self) -> np.ndarray:
        return np.array([dimension.between_lots for dimension in self.varied])

    @property
    def lot_correlation(self) -> float:
        """Bound on the correlation of anything in two parts of a lot, 0 to 1.

        Of functions of jointly normal variables none are correlated more than the variables in their most correlated
        combination; for independent dimensions that is the largest share of a variance between lots.
        """
        largest = float(self._between_lots.max(initial=0.0))
        return 1.0 if largest > 0.0 and self._copula is not None else largest

    @cached_property
    def _scores(self) -> np.ndarray:
        """Correlation matrix of the varied dimensions' standard normal scores."""
        if self.correlation is None:
            return np.eye(len(self.varied))
        varied = [k for k, dimension in enumerate(self.dimensions) if dimension.is_varied]
        return np.array(self.correlation)[np.ix_(varied, varied)]

    @cached_property
    def _within_lots(self) -> np.ndarray:
        """Covariance of the scores within lots; between lots it is s_i s_j rho_ij, s_i^2 the shares."""
        lot_sd = np.sqrt(self._between_lots)
        return self._scores * (1.0 - np.outer(lot_sd, lot_sd))

    @cached_property
    def _copula(self) -> np.ndarray | None:
        """Factor of the scores' correlation matrix; None: independent."""
        return lower_factor(self._scores) if np.tril(self._scores, -1).any() else None

    @cached_property
    def _lots(self) -> tuple[np.ndarray, np.ndarray] | None:
        """Factors of the covariances within and between lots; None: no lots."""
        if not self._between_lots.any():
            return None
        lot_sd = np.sqrt(self._between_lots)
        return lower_factor(self._within_lots), lot_sd[:, None] * lower_factor(self._scores)


def _lot_size(value: Any) -> int:
    try:
        size = index(value)
    except TypeError:
        raise TypeError(f"Tolerances: lot_size must be a whole number, got {value!r}.") from None
    if size < 1:
        raise ValueError(f"Tolerances: lot_size = {size} is out of range; allowed: 1 or more.")
    return size
