"""What the parts of one kernel share: equations, stepper, and the rows that more than one of them uses."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType

from tolmc.kernels.lanes import Layout, observer
from tolmc.kernels.steppers import Stepper


@dataclass(frozen=True)
class System:
    """The parts of one kernel see each other through this.

    A lane's motion may end within a step. From then on its gates are shut, and the share of that step that it still moved is
    one more step, of ``part_h`` (s) from ``part_state``: ``part`` is 1 in the lanes that have one, else 0.
    """

    equations: ModuleType
    load: bool
    stepper: Stepper
    layout: Layout
    #: What is observed of a lane: :func:`tolmc.kernels.lanes.observer`.
    observe: Callable
    #: Places of the states at a step's two ends, of the coefficients and of the step's length, as arrays.
    y: slice
    end: slice
    coef: slice
    h: slice
    #: Gates: > 0 while a lane's force statistics, and its motion, go on; and where they ended (s).
    open_forces: int
    open_motion: int
    until_forces: int
    until_motion: int
    #: First step after which a lane's numbers are no longer finite, -1 if none.
    bad_step: int
    #: Largest kinetic energy so far, or the size of the potential energy's variation if that is more (J).
    energy_scale: int
    part: int
    part_h: slice
    part_state: slice

    @classmethod
    def of(cls, equations: ModuleType, load: bool, stepper: Stepper, layout: Layout) -> System:
        """A system whose rows follow the stepper's."""
        state = equations.STATE
        return cls(
            equations, load, stepper, layout, observer(equations, load),
            y=layout.block(state), end=layout.block(state), coef=layout.block(equations.COEFFICIENTS), h=layout.block(1),
            open_forces=layout.row(), open_motion=layout.row(), until_forces=layout.row(), until_motion=layout.row(),
            bad_step=layout.row(), energy_scale=layout.row(),
            part=layout.row(), part_h=layout.block(1), part_state=layout.block(state),
        )  # fmt: skip
