"""The start of the motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from tolmc.mechanism.checks import finite_number, finite_pair, set_frozen
from tolmc.quantities import SPIN, START


@dataclass(frozen=True)
class Motion:
    """The start of the motion: on the wall at both ends; :meth:`free` starts it anywhere within the clearance.

    Parameters
    ----------
    alpha, beta : float, rad
        Polar angles of D and E (where the axis crosses Z = +L and Z = -L) on their circles.
    alpha_rate, beta_rate : float, rad/s
    spin : float, rad
        chi, the body's turn about the journal's axis against the frame of the smallest rotation from Z.
    spin_rate : float, rad/s
        Omega = omega . e, the angular velocity about the journal's axis.
    """

    alpha: float
    beta: float
    alpha_rate: float = 0.0
    beta_rate: float = 0.0
    spin: float = 0.0
    spin_rate: float = 0.0
    origin: tuple[float, float] | None = None
    slope: tuple[float, float] | None = None
    origin_rate: tuple[float, float] = (0.0, 0.0)
    slope_rate: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        for name in (*START, *SPIN):
            set_frozen(self, **{name: finite_number("Motion", name, getattr(self, name))})
        for name in ("origin", "slope", "origin_rate", "slope_rate"):
            if getattr(self, name) is not None:
                set_frozen(self, **{name: finite_pair("Motion", name, getattr(self, name))})
        if (self.origin is None) != (self.slope is None):
            raise ValueError("Motion: origin and slope go together; give both for a start within the clearance.")
        if not self.is_free and any((*self.origin_rate, *self.slope_rate)):
            raise ValueError(
                "Motion: origin_rate and slope_rate belong to a start within the clearance; give origin and slope."
            )
        if self.is_free and any(getattr(self, name) for name in START):
            raise ValueError(
                "Motion: alpha and beta place the journal on the wall, origin and slope anywhere; give one pair of both."
            )

    @property
    def is_free(self) -> bool:
        """Whether the motion starts within the clearance and not on the wall."""
        return self.origin is not None

    @classmethod
    def free(
        cls,
        origin: Sequence[float],
        slope: Sequence[float],
        origin_rate: Sequence[float] = (0.0, 0.0),
        slope_rate: Sequence[float] = (0.0, 0.0),
        spin: float = 0.0,
        spin_rate: float = 0.0,
    ) -> Motion:
        """A start anywhere within the clearance.

        Parameters
        ----------
        origin : 2 floats, m
            (X0, Y0), where the axis crosses the middle plane.
        slope : 2 floats
            (dX/dZ, dY/dZ) of the axis.
        origin_rate, slope_rate : 2 floats, m/s and 1/s
        spin, spin_rate : float, rad and rad/s
            As of a motion on the wall.
        """
        start = finite_pair("Motion", "origin", origin), finite_pair("Motion", "slope", slope)
        rates = finite_pair("Motion", "origin_rate", origin_rate), finite_pair("Motion", "slope_rate", slope_rate)
        return cls(0.0, 0.0, 0.0, 0.0, spin, spin_rate, *start, *rates)
