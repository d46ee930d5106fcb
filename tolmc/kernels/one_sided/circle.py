"""The paper's circles: D and E stay within circles of radius r.

The gap is (1 - |D|^2)/2 in units of c = r, equal to first order to (r - |D|)/r at the wall: a polynomial of the coordinates,
smooth at the middle of the bearing too, with row -(D, D) and no square root. The multiplier on it is that of |D| at the wall.
"""

from __future__ import annotations

import math

from tolmc.kernels import parameters as P
from tolmc.kernels.jit import device, dot, fma, strict

#: Gaps above it are far from the wall: their second derivative foretells nothing.
FAR = 1.0
#: Whether the speed of approach is the gap's rate over N/lambda, or the rate itself.
UNIT = False
#: Whether a block that flies is looked at without contact. Its pieces are strict then, which the exact section's equations pay
#: with a twentieth of their time.
GLIMPSED = True


@device
def size(raw, lane, width):
    """c, m."""
    return raw[P.RADIUS * width + lane]


@strict
def touch(px, py, vx, vy, sx, sy, tx, ty, coef, lane, width):
    """(n_x, n_y, lever, N/lambda, gap, gap's second derivative at zero acceleration) at the end p of the axis.

    v = p', s the slope of the axis towards this end and t = s'. The row of the gap in (o', w') is -(n, lever n), with +w at
    D and -w at E.
    """
    p2, lean = dot(px, py, px, py), dot(sx, sy, px, py)
    return px, py, 1.0, math.sqrt(fma(lean, lean, p2)), fma(-0.5, p2, 0.5), -dot(vx, vy, vx, vy)
