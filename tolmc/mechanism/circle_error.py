"""How much the paper's circle of constant radius misstates on a given joint, from its dimensions alone.

The constant r of equation (3) is exact at the largest tilt. With the journal parallel to the bore the axis is R* - r* away
from the bore's axis, and that is where the circle is off most: by

    (R* - r* - r)/(R* - r*) = r* (1/cos(psi) - 1)/(R* - r*)  ~  r* (R* - r*)/(2 L^2)

At the largest tilt it is the lever of the contact forces that is off, by twice as much.
"""

from __future__ import annotations

import math

from tolmc.mechanism.scene import Joint

#: Error of a contact-force peak over the position's: nine out of ten motions of a body with its centre of mass inside the
#: bearing stay below it, half of them below a third of it, at every clearance and length (studies/section_error.py).
CONTACT_FORCE_SHARE = 1.0


def section_error_estimate(joint: Joint) -> dict[str, float]:
    """Relative errors that the circle of constant radius makes on a joint, against the exact section.

    Parameters
    ----------
    joint : Joint
        Its dimensions count, not its section.

    Returns
    -------
    dict of float, relative (1 is 100 %)
        ``position``: largest error of the axis's distance from the bore's axis in the planes Z = +-L at given polar angles of
        D and E, met with the journal parallel to the bore: r* (1/cos(psi) - 1)/(R* - r*). ``tilt``: largest error of the
        tilt at given polar angles, met at small tilt: the same number. ``contact_force``: error of the peaks of the contact
        forces, ``CONTACT_FORCE_SHARE`` times the position's, which nine out of ten motions stay below; for a body that
        hangs over the bearing's end and rests at the largest tilt it may be ten times as much.

    Notes
    -----
    For usual clearances the circle is good to a share q where (R* - r*)/r* <= 2 q (L/r*)^2.
    """
    psi = joint.tilt_angle
    # 1/cos(psi) - 1 = 2 sin(psi/2)^2/cos(psi), which cancels nothing at small tilt.
    rise = 2.0 * math.sin(0.5 * psi) ** 2 / math.cos(psi)
    position = joint.journal_radius * rise / joint.approximate_radius
    return {"position": position, "tilt": position, "contact_force": CONTACT_FORCE_SHARE * position}
