"""What the kernels must compute for a scene: what it does not have is not compiled into them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tolmc.mechanism.loads import Oscillation
from tolmc.mechanism.scene import Scene
from tolmc.quantities import OPERATING, SCALAR_ROWS


@dataclass(frozen=True)
class Features:
    """What the kernels must compute; what is False is not compiled into them."""

    general: bool = False
    axial: bool = False
    exact: bool = False
    load: bool = True
    #: Whether the angular momentum about Z, and Omega, are conserved.
    momentum: bool = False
    spin: bool = False
    #: Whether temperature or wear change the drawn dimensions.
    operating: bool = False
    #: Whether the wall only pushes, whether the motion starts within the clearance, and whether impacts have a peak force.
    one_sided: bool = False
    free: bool = False
    stiffness: bool = False
    #: Whether there is friction, whether a drive holds Omega, and whether it is asked what wears.
    friction: bool = False
    driven: bool = False
    wears: bool = False
    #: Whether parts of the loads swing, and whether the drive does.
    shaken: bool = False
    swings: bool = False

    @property
    def rubs(self) -> bool:
        """Whether sliding counts, Omega is held or something swings."""
        return self.friction or self.driven or self.wears or self.shaken

    @property
    def alone(self) -> bool:
        """Whether motions are the one-sided kernels' from their start: no formulation that keeps contact has what they need."""
        return self.free or self.shaken or self.swings or (self.rubs and (self.general or self.exact))

    @property
    def formulation(self) -> str:
        """Name of the equations of motion that keep contact, in :data:`tolmc.kernels.formulations.FORMULATIONS`."""
        if self.rubs:
            return "slope_rubbing"
        section, body = "exact" if self.exact else "slope", "general" if self.general else "symmetric"
        return "slope_axial" if self.axial else f"{section}_{body}"


_UNSYMMETRIC = {
    "center_of_mass_x", "center_of_mass_y", "inertia_xy", "inertia_xz", "inertia_yz", "inertia_xx", "inertia_yy",
    "torque_x", "torque_y", "torque_z", "force_point_x", "force_point_y",
}  # fmt: skip


def features_of(scene: Scene, varied: set[str], pose: bool) -> Features:
    """What the kernels must compute for a scene whose scalars ``varied`` vary from sample to sample.

    ``general``: the body is not symmetric, or a load turns with it or has a moment along its axis; ``axial``: all load is
    axial and nobody asks for the ``pose`` itself; ``exact``: the section is exact; ``load``: there is any load.
    """
    body, loads = scene.body, scene.loads
    loaded = [row for row in SCALAR_ROWS if row.vector in ("gravity", "force", "torque")]
    present = [row for row in loaded if row.name in varied or scene.scalars[row.name]]
    off_axis = any(row.vector == "force" for row in present) and any((loads.force_point or (0.0, 0.0))[:2])
    torque = any(row.vector == "torque" for row in present)
    shaken = bool(loads.terms)
    general = not body.is_symmetric or off_axis or torque or shaken or bool(varied & _UNSYMMETRIC)
    transverse = any(row.axis != "z" for row in present)
    exact = scene.joint.section == "exact"
    if general and not scene.scalars["inertia_zz"] > 0:
        raise ValueError(
            "Body: inertia[2, 2] = 0 kg m^2 has no spin dynamics under this body or load; allowed: > 0 unless the body is "
            "symmetric about the journal's axis and no load has a moment along it. Give the journal's own inertia."
        )
    turned = any((row.axis == "z") == (row.vector == "torque") for row in present)
    axial = not (general or transverse or pose or exact)
    symmetric = body.is_symmetric and not (varied & _UNSYMMETRIC) and not (off_axis or torque)
    for name in varied:
        scene.check_has(name)
    operating = scene.operating is not None or bool(varied & set(OPERATING))
    one_sided = scene.joint.restitution is not None
    friction, driven = scene.joint.friction > 0.0 or "friction" in varied, loads.is_driven
    wears = scene.joint.wear_coefficient > 0.0 or "wear_coefficient" in varied
    rubs = friction or driven or wears or shaken
    if one_sided or rubs:
        _check_free_body(scene)
    if friction and not driven and not scene.scalars["inertia_zz"] > 0:
        raise ValueError(
            "Body: inertia[2, 2] = 0 kg m^2 has no spin dynamics under friction; allowed: > 0. Give the journal's own inertia, "
            'or let a drive hold its speed, Loads(drive="constant speed").'
        )
    return Features(
        general, axial and not rubs, exact, bool(present),
        momentum=not (turned or rubs), spin=symmetric and not rubs, operating=operating, one_sided=one_sided,
        free=scene.motion.is_free, stiffness=scene.joint.contact_stiffness is not None, friction=friction, driven=driven,
        wears=wears, shaken=shaken, swings=isinstance(loads.drive, Oscillation),
    )  # fmt: skip


def has_free_body(scene: Scene) -> bool:
    """Whether the body has moments of inertia about its centre of mass, as the one-sided kernels' equations need it."""
    moments = np.linalg.eigvalsh(scene.body.centroidal_inertia[:2, :2])
    return bool(moments[0] > 1e-9 * np.abs(scene.body.inertia).max())


def _check_free_body(scene: Scene) -> None:
    if not has_free_body(scene):
        moments = np.linalg.eigvalsh(scene.body.centroidal_inertia[:2, :2])
        raise ValueError(
            f"Body: the moments of inertia about the centre of mass across the axis are {moments.tolist()} kg m^2; a journal "
            "that may leave the wall, or has friction, wear, a drive or loads that swing, needs them > 0. Give the body's own "
            "inertia."
        )
