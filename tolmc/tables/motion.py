"""A motion and a sample: what `simulate` and `replay` show."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from tolmc import quantities
from tolmc.mechanism.scene import Scene
from tolmc.tables.table import Column, Note, Number, Table, cells, plain
from tolmc.text.numbers import NEGLIGIBLE

if TYPE_CHECKING:
    from tolmc.simulation.trajectory import Trajectory

_INSTANTS = 11


def motion_blocks(trajectory: Trajectory, scene: Scene, *, title: str) -> Iterator[Table | Note]:
    """A motion at some instants, the extremes of its contact forces, and its status."""
    forces = np.where(
        np.abs(trajectory.contact_force) < NEGLIGIBLE * np.nanmax(np.abs(trajectory.contact_force), initial=0.0),
        0.0,
        trajectory.contact_force,
    )
    yield _instants(trajectory, forces, title)
    joint = scene.joint_in_operation
    yield Note(
        f"Largest tilt the clearance allows: {np.degrees(joint.tilt_angle):.7g} deg; "
        f"r = {1e3 * joint.effective_radius:.7g} mm (R* − r* = {1e3 * joint.approximate_radius:.7g} mm)"
    )
    for name, force in zip(("N_D", "N_E"), forces.T, strict=True):
        yield Note(f"{name} at the stored instants: {plain.number(force.min())} to {plain.number(force.max())} N")
    yield Note(f"Status: {trajectory.status}")


def _instants(trajectory: Trajectory, forces: np.ndarray, title: str) -> Table:
    rows = [
        cells(
            Number(trajectory.time[i], 4),
            *(Number(1e3 * x, decimals=5) for x in trajectory.origin[i]),
            Number(np.degrees(trajectory.tilt[i]), decimals=4),
            *(Number(force) for force in forces[i]),
        )
        for i in np.unique(np.linspace(0, len(trajectory.time) - 1, _INSTANTS).round().astype(int))
    ]
    return Table("motion", ("t, s", "X0, mm", "Y0, mm", "tilt, deg", "N_D, N", "N_E, N"), tuple(rows), title=title)


def extremes_table(trajectory: Trajectory) -> Table:
    """What a motion reaches, at its stored instants."""
    rows = [
        cells("Largest tilt", Number(float(np.degrees(trajectory.tilt.max()))), "deg"),
        *(
            cells(f"{what} {name}", Number(float(of(force))), "N")
            for name, force in zip(("N_D", "N_E"), trajectory.contact_force.T, strict=True)
            for what, of in (("Smallest", np.min), ("Largest", np.max))
        ),
        cells("Status", trajectory.status, ""),
    ]
    title = f"Motion of {trajectory.time[-1]:.4g} s, {len(trajectory.time):,} rows"
    return Table("extremes", ("", "", Column("unit", words=True)), tuple(rows), title=title)


def sample_table(row: Mapping[str, float | str]) -> Table:
    """One row of a run: its inputs and outputs."""
    rows = []
    for name, value in row.items():
        if isinstance(value, str):
            rows.append(cells(quantities.label(name), value, ""))
        else:
            unit, factor = quantities.shown(name)
            rows.append(cells(quantities.label(name), Number(value * factor), unit))
    columns = ("Quantity", "value", Column("unit", words=True))
    return Table("sample", columns, tuple(rows), title="The sample in the run")
