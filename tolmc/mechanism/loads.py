"""What acts on the body: gravity, a force, a torque, and the drive that turns it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tolmc.mechanism.checks import finite_vector, set_frozen

DRIVES = ("free", "constant speed")

#: What may be given as a vector (x, y, z).
Vector = Sequence[float] | np.ndarray


@dataclass(frozen=True)
class Loads:
    """Loads on the body; what is absent costs nothing.

    Parameters
    ----------
    gravity : 3 floats, m/s^2
        Uniform field in fixed axes.
    force : 3 floats or None, N
        Constant force of fixed direction (fixed axes), acting at the body point ``force_point`` (m, body axes; O
        when None).
    torque : 3 floats or None, N m
        Constant torque in fixed axes.
    drive : {"free", "constant speed"}
        Whether the body turns about its axis as it will, or a drive holds Omega at the motion's spin_rate by a torque along
        the axis, which is an output.
    """

    gravity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    force: tuple[float, float, float] | None = None
    force_point: tuple[float, float, float] | None = None
    torque: tuple[float, float, float] | None = None
    drive: str = "free"

    if TYPE_CHECKING:

        def __init__(
            self,
            gravity: Vector = (0.0, 0.0, 0.0),
            force: Vector | None = None,
            force_point: Vector | None = None,
            torque: Vector | None = None,
            drive: str = "free",
        ) -> None: ...

    def __post_init__(self) -> None:
        set_frozen(self, gravity=finite_vector("Loads", "gravity", self.gravity))
        for name in ("force", "force_point", "torque"):
            if getattr(self, name) is not None:
                set_frozen(self, **{name: finite_vector("Loads", name, getattr(self, name))})
        if self.force_point is not None and self.force is None:
            raise ValueError("Loads: force_point is given without force; give the force (N) that acts there.")
        if self.drive not in DRIVES:
            raise ValueError(f"Loads: drive = {self.drive!r} is unknown; allowed: {', '.join(DRIVES)}.")
