"""The start of a motion where the two-sided kernels have lost contact: from their state there.

:func:`start_from` is a template: :func:`build` makes an entry of it for each formulation with that one's parts.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from tolmc.kernels import jit, names
from tolmc.kernels.bare import Rows, Table
from tolmc.kernels.formulations import FORMULATIONS
from tolmc.kernels.once import once
from tolmc.kernels.one_sided import layout as at

prepare: Any = None
motion: Any = None
state = spins = None


def start_from(raw: Table, states: Table, given: Table, coef: Rows, y: Rows):
    """Rows START_X to START_V_RATE of ``given`` (layout.GIVEN, n), SI units, and those of the spin where it is no constant.

    ``states`` (rows, n) are in the coordinates of the formulation; both ends touch the wall.
    """
    for i in range(raw.shape[1]):
        for c in range(state):
            y[c] = states[c, i]
        prepare(raw, i, coef, 0, 1)
        x, z, u, v, x_rate, z_rate, u_rate, v_rate, chi, spin_rate = motion(y, coef, 0, 1)
        given[at.START_X, i], given[at.START_Y, i], given[at.START_U, i], given[at.START_V, i] = x, z, u, v
        given[at.START_X_RATE, i], given[at.START_Y_RATE, i] = x_rate, z_rate
        given[at.START_U_RATE, i], given[at.START_V_RATE, i] = u_rate, v_rate
        if spins:
            given[at.CHI, i], given[at.OMEGA, i] = chi, spin_rate


@once
def build(formulation: str) -> Callable:
    """Entry ``start_from(raw, states, given)`` of a formulation."""
    equations = FORMULATIONS[formulation]
    return jit.entry(
        start_from, names.start_from(formulation), buffers=[equations.COEFFICIENTS, equations.STATE],
        prepare=equations.prepare, motion=equations.motion, state=equations.STATE, spins=equations.TORQUE,
    )  # fmt: skip
