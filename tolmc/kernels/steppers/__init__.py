"""Steps of a whole block of lanes, from one array of states to another.

A stepper is made for one set of equations; it has the function ``step(y, end, coef, h, work, watch)``, one step of ``h[lane]``
from ``y`` to ``end``, projected, and names the rows of ``work`` in which it leaves what was seen on the way.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from tolmc.kernels.tableaux import Tableau


@dataclass(frozen=True)
class Stepper:
    """A step and its rows."""

    tableau: Tableau
    step: Callable
    #: Constraint error left after the projection.
    error: slice
    #: N_D, N_E, |w|^2 and the torque's power at the stages, (stage, 4, lane): where they are looked at.
    samples: slice
    #: Increments over the step of the integrals of N_D, N_D^2, N_E, N_E^2 and of the torque's power, (5, lane).
    sums: slice
