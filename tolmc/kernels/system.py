"""What the parts of one kernel share: equations, stepper, and the rows that more than one of them uses."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType

from tolmc.kernels.jit import device
from tolmc.kernels.lanes import WIDTH, Layout
from tolmc.kernels.once import once
from tolmc.kernels.seen import SEEN, SEEN_RUBBING, viewer
from tolmc.kernels.steppers import Stepper


@once
def observer(equations: ModuleType, load: bool) -> Callable:
    """What the equations observe of one lane, ``observe(y, coef, lane)``: (O_x, O_y, u, v, N_D, N_E, ..., T, V, |w|^2).

    Taken over as a whole: optimised anew for each use of a part of it, LLVM contracts its arithmetic in other ways.
    """
    of_equations = equations.observe

    @device
    def observe(y, coef, lane):
        return of_equations(y, coef, lane, WIDTH, load)

    return observe


@dataclass(frozen=True)
class System:
    """The parts of one kernel see each other through this.

    A lane's motion may end within a step: ``until`` steps from the start. The share of that step that it still moved is one
    more step, of ``part_h`` (s, 0: there is none) from ``part_start``, with ``part_seen`` as what a step sees.
    """

    equations: ModuleType
    load: bool
    stepper: Stepper
    layout: Layout
    #: How much is seen at the end of a step, and the view of it in a window.
    seen: int
    at: Callable
    #: What is observed of a lane: :func:`observer`.
    observe: Callable
    #: Places of the states at a step's two ends, of the coefficients and of the step's length, as arrays.
    y: slice
    end: slice
    coef: slice
    h: slice
    #: Where a lane's motion ends (steps), and the first end of a step at which its numbers are no longer finite (-1: none).
    until: int
    bad_step: int
    #: Largest kinetic energy so far, or the size of the potential energy's variation if that is more (J).
    energy_scale: int
    part_h: slice
    part_start: slice
    part_seen: slice
    #: The state at the end of a lane's motion, and what is seen there.
    end_state: slice
    end_seen: slice

    @classmethod
    def of(cls, equations: ModuleType, load: bool, stepper: Stepper, layout: Layout) -> System:
        """A system whose rows follow the stepper's."""
        state, seen = equations.STATE, SEEN_RUBBING if equations.RUBS else SEEN
        return cls(
            equations, load, stepper, layout, seen, viewer(seen), observer(equations, load),
            y=layout.block(state), end=layout.block(state), coef=layout.block(equations.COEFFICIENTS), h=layout.block(1),
            until=layout.row(), bad_step=layout.row(), energy_scale=layout.row(),
            part_h=layout.block(1), part_start=layout.block(state), part_seen=layout.block(seen),
            end_state=layout.block(state), end_seen=layout.block(seen),
        )  # fmt: skip
