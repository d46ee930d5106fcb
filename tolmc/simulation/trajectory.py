"""One motion, step by step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from tolmc.mechanism.scene import Scene
from tolmc.quantities import END_OUTPUTS, OUTPUTS
from tolmc.shown import Shown
from tolmc.simulation.block import block_columns
from tolmc.simulation.integration import trace
from tolmc.simulation.judge import SINGULAR_PSI, leaves, sentence
from tolmc.simulation.one_sided import flown, no_events
from tolmc.simulation.outputs import scene_outputs
from tolmc.simulation.packing import pack
from tolmc.simulation.pilot import plan_integration
from tolmc.simulation.plan import Plan


@dataclass(frozen=True)
class Trajectory(Shown):
    """One motion, a row a step; the last row is at the scene's duration exactly.

    ``time`` (n,) s, ``origin`` (n, 2) m, ``axis`` (n, 3), ``contact_force`` (n, 2) N_D and N_E in N, ``multipliers`` (n, 2) in
    the formulation's own rows, ``tilt`` (n,) rad, ``energy`` (n,) J, ``status`` "ok" or what happened and when, ``scene`` what
    moved so.
    ``closed`` (n, 2) bool, whether D and E are on the wall. A motion that leaves the wall has two rows at every event, before
    and after it, and its multipliers are the contact forces. ``events``: a record array with ``time`` (s), ``kind`` ("impact",
    "release" or "closing"), ``ends`` that take part ("D", "E", "DE"), and ``impulse`` (N s) and ``speed`` of approach (m/s),
    at D and at E. ``spin_rate`` (n,) rad/s, of a motion that is not held on the wall; else None.
    """

    time: np.ndarray
    origin: np.ndarray
    axis: np.ndarray
    contact_force: np.ndarray
    multipliers: np.ndarray
    tilt: np.ndarray
    energy: np.ndarray
    status: str
    closed: np.ndarray
    events: np.recarray
    scene: Scene | None = None
    spin_rate: np.ndarray | None = None

    def __repr__(self) -> str:
        tilt, force = np.degrees(self.tilt.max()), self.contact_force
        forces = ", ".join(
            f"N_{end} {force[:, i].min():.4g} to {force[:, i].max():.4g} N" for i, end in enumerate("DE")
        )
        rows = f"{len(self.time):,} rows over {self.time[-1]:.4g} s"
        return f"<Trajectory {self.status}: {rows}; tilt up to {tilt:.4g} deg; {forces}>"

    def to_frame(self) -> pd.DataFrame:
        """The trajectory as a table, SI units."""
        return pd.DataFrame(
            {
                "time": self.time,
                "origin_x": self.origin[:, 0],
                "origin_y": self.origin[:, 1],
                **{f"axis_{c}": self.axis[:, i] for i, c in enumerate("xyz")},
                "contact_force_D": self.contact_force[:, 0],
                "contact_force_E": self.contact_force[:, 1],
                "tilt": self.tilt,
                "energy": self.energy,
                **{f"closed_{end}": self.closed[:, side] for side, end in enumerate("DE")},
            }
        )


def simulate(
    scene: Scene,
    *,
    step: float | None = None,
    method: str = "rk8",
    formulation: str = "slope",
    accuracy: float | None = None,
    project_energy: bool = False,
) -> Trajectory:
    """Integrate one motion and return it step by step.

    Parameters as in :func:`simulate_many`. Without restitution the model is two-sided: the motion goes on after a contact
    force has turned negative, and the status says when that happened first; with friction, wear, a drive or loads that
    swing it ends there. With it
    the journal leaves the wall, flies and hits it.
    """
    holds = scene.joint.restitution is None and not scene.rubs
    on_loss = "continue" if holds else "stop"
    plan = plan_integration(
        scene, step=step, method=method, formulation=formulation, accuracy=accuracy, outputs=(*OUTPUTS, *END_OUTPUTS),
        on_contact_loss=on_loss, project_energy=project_energy,
    )  # fmt: skip
    raw, _ = pack(scene.scalars, 1)
    time = np.linspace(0.0, scene.duration, plan.steps + 1)
    outputs = scene_outputs(plan, project_energy)
    summary = block_columns(scene, {}, 1, outputs, plan, on_loss, project_energy)
    status = sentence(summary, plan)
    if plan.features.rubs or (plan.features.one_sided and leaves(summary)):
        with np.errstate(all="ignore"):
            return _flown(scene, raw, plan, status)
    if plan.formulation != "slope":
        return _recorded(scene, raw, plan, summary, time, status)
    with np.errstate(all="ignore"):
        return _traced(scene, raw, plan, project_energy, time, status)


def _recorded(
    scene: Scene, raw: np.ndarray, plan: Plan, summary: dict[str, np.ndarray], time: np.ndarray, status: str
) -> Trajectory:
    """The motion in the paper's coordinates, up to the singular set that ends it."""
    from tolmc.simulation.published import published_records, tilt_of  # and with it Numba, half a second

    records = published_records(np.ascontiguousarray(raw[:, 0]), plan, scene.duration)
    rows = max(records.rows, 1)
    if summary["status"][0] >= SINGULAR_PSI:
        rows = min(rows, 1 + round(summary["status_time"][0] / scene.duration * plan.steps))
    return Trajectory(
        time=time[:rows],
        origin=records.q[:rows, :2],
        axis=records.axis[:rows],
        contact_force=records.contact_force[:rows],
        multipliers=records.multipliers[:rows],
        tilt=tilt_of(records.axis[:rows]),
        energy=records.energy[:rows],
        status=status,
        closed=np.ones((rows, 2), bool),
        events=no_events(),
        scene=scene,
    )


def _traced(
    scene: Scene, raw: np.ndarray, plan: Plan, project_energy: bool, time: np.ndarray, status: str
) -> Trajectory:
    """The motion in slope coordinates."""
    x, y, u, v, n_d, n_e, lambda_d, lambda_e, kinetic, potential, w2 = trace(raw, plan, scene.duration, project_energy)
    length = scene.joint_in_operation.half_length
    norm = np.sqrt(length * length + w2)
    symmetric = not plan.features.general
    spin_energy = 0.5 * scene.body.inertia[2, 2] * scene.motion.spin_rate**2 if symmetric else 0.0
    return Trajectory(
        time=time,
        origin=np.stack((x, y), axis=1),
        axis=np.stack((u / norm, v / norm, length / norm), axis=1),
        contact_force=np.stack((n_d, n_e), axis=1),
        multipliers=np.stack((lambda_d, lambda_e), axis=1),
        tilt=np.arctan(np.sqrt(np.maximum(w2, 0.0)) / length),
        energy=kinetic + potential + spin_energy,
        status=status,
        closed=np.ones((len(time), 2), bool),
        events=no_events(),
        scene=scene,
    )


def _flown(scene: Scene, raw: np.ndarray, plan: Plan, status: str) -> Trajectory:
    """The motion with flights, impacts and friction."""
    rows, events = flown(raw, plan, scene.duration)
    norm = np.sqrt(1.0 + rows.slope[0] ** 2 + rows.slope[1] ** 2)
    lacks_spin = not (plan.features.general or plan.features.rubs)
    spin_energy = 0.5 * scene.body.inertia[2, 2] * scene.motion.spin_rate**2 if lacks_spin else 0.0
    return Trajectory(
        time=rows.time,
        origin=rows.origin.T.copy(),
        axis=np.stack((rows.slope[0] / norm, rows.slope[1] / norm, 1.0 / norm), axis=1),
        contact_force=rows.force.T.copy(),
        multipliers=rows.force.T.copy(),
        tilt=np.arctan(np.hypot(*rows.slope)),
        energy=rows.energy + spin_energy,
        status=status,
        closed=rows.closed.T.copy(),
        events=events,
        scene=scene,
        spin_rate=rows.spin_rate.copy(),
    )
