"""Regularised Coulomb friction at the rims.

The contact point slides with v = v_e e + v_b b, b = e x nu, nu = (-n, s.n)/q the wall's normal; with the lever of the gap's
row

    v_e = o'.e_h - (r*/c) kappa e_z (w'.n)/q,   v_b = (o' + lever w').b_h - (r*/c) Omega,   b_h = -(e_z/q) J(n + (s.n) s)

(+w' at D, -w' at E; in units of c). The force per unit N is F = -mu v/sqrt(|v|^2 + slip^2), and by the same virtual velocities
it works on o', w' and Omega/kappa.
"""

from __future__ import annotations

import math

from tolmc.kernels.jit import device
from tolmc.kernels.one_sided import layout as at


@device
def sliding(nx, ny, lever, sx, sy, tx, ty, ux, uy, vx, vy, spin, coef, lane, width):
    """(F_e, F_b, v_e, v_b and the directions of the virtual velocities) at one end.

    s is the slope of the axis towards this end, (u, v) are o' and +-w' there; n need not be of unit length.
    """
    round_, kappa = coef[at.ROUND * width + lane], coef[at.KAPPA * width + lane]
    unit = 1.0 / math.sqrt(nx * nx + ny * ny)
    nx, ny = nx * unit, ny * unit
    sn = sx * nx + sy * ny
    iq = 1.0 / math.sqrt(1.0 + sn * sn)
    e_z = 1.0 / math.sqrt(1.0 + sx * sx + sy * sy)
    scale = e_z * iq
    bx, by = scale * (ny + sn * sy), -scale * (nx + sn * sx)
    ex, ey = e_z * sx, e_z * sy
    arm = round_ * kappa * scale
    v_e = ux * ex + uy * ey - arm * (vx * nx + vy * ny)
    v_b = (ux + lever * vx) * bx + (uy + lever * vy) * by - round_ * spin
    slip = coef[at.SLIP * width + lane]
    size = -coef[at.MU * width + lane] / math.sqrt(v_e * v_e + v_b * v_b + slip * slip)
    return size * v_e, size * v_b, v_e, v_b, bx, by, ex, ey, arm * nx, arm * ny
