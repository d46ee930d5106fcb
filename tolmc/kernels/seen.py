"""What is seen of a lane at the end of a step, and of the step from there: rows of an array (row, lane).

A block keeps the last steps' ends, states and what was seen at them, in a :class:`Window`: the watchers look at whole windows,
so that what happens between two ends is covered by exact values on both sides.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from tolmc.kernels.jit import device
from tolmc.kernels.lanes import WIDTH

# N_D, N_E, |w|^2, their rates of change (of one whole step), kinetic energy, energy; of the step from there the integrals of
# N_D, N_D^2, N_E, N_E^2 and of the torque's power, both forces as the last stage has them, and the constraint error left.
# A rate stands three rows after its value.
N_D, N_E, W2, RATE_D, RATE_E, RATE_W2, KINETIC, ENERGY, SUM_D, SUM_D2, SUM_E, SUM_E2, WORK, LATE_D, LATE_E, ERROR = (
    range(16)
)
SEEN = 16
# With friction also its moment about the axis and that one's rate, again three rows after; how much faster than the slip speed
# the slower contact slides, and how far the contact forces are from undetermined (positive: they are determined); of the step
# from there the integrals of N |v| at both ends, of the heat, of the moment, of its size and of s.
TORQUE, SLOW, MARGIN, RATE_TORQUE, SLIP_D, SLIP_E, HEAT, SUM_TORQUE, SUM_SIZE, SUM_S = range(SEEN, SEEN + 10)
SEEN_RUBBING = SEEN + 10

#: Rows of the polynomials between two ends: two ends on either side.
SUPPORT = 4
#: The forces' rates at an end are those of the polynomial through the ends and means of as many steps on either side.
REACH = 3
#: Steps from one look at a window to the next; states and what is seen of as many stay in the second-level cache.
STEPS = 64
#: Ends in a window: those of the steps, and those that the next look still needs.
ROWS = STEPS + SUPPORT + REACH


class Window(NamedTuple):
    """Ends of steps ``first``, ``first`` + 1, ... of a block: ``states`` (row, state, lane), ``seen`` (row, what, lane), flat.

    The watchers look at the intervals from row ``head`` to row ``tail`` + 1; ``last`` is the last row with what is seen and its
    rates, ``end`` the last with what is seen.
    """

    states: np.ndarray
    seen: np.ndarray
    first: int
    head: int
    tail: int
    last: int
    end: int


@device
def of(seen, variable):
    """Values and rates of one variable. As arrays of their own: a row known only at run time would be gathered lane by lane."""
    return seen[variable * WIDTH : (variable + 1) * WIDTH], seen[(variable + 3) * WIDTH : (variable + 4) * WIDTH]


def viewer(count: int) -> Callable:
    """Function ``at(seen, row)``: what is seen at one row, (count, lane), flat."""

    @device
    def at(seen, row):
        return seen[row * count * WIDTH : (row + 1) * count * WIDTH]

    return at
