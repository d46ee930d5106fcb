"""The exact section: the bearing's rims touch the tilted journal.

In the plane of a rim the journal is an ellipse about p with support function r* q(n), q^2 = 1 + (s.n)^2, and the gap is

    g = min over n of (R* - n.p - r* q),  in units of c = R* - r*:  1 - (r*/c) (s.n)^2/(1 + q) - n.p

At the minimum n'(angle) = Jn gives f' = -p.Jn - (r*/c) (s.n)(s.Jn)/q = 0. By the envelope theorem the gap's row in (o', w') is
-(n, lever n), lever = 1 + (r*/L) (s.n)/q, and at zero acceleration

    g'' = -j^2/f'' - (r*/c) (t.n)^2/q^3,   j = v.Jn + (r*/c) [(t.n)(s.Jn)/q^3 + (s.n)(t.Jn)/q]
    f'' = p.n - (r*/c) [(s.Jn)^2/q^3 - (s.n)^2/q]

with v = p', t = s' (the angle turns at j/f''). The wall's force is N = q lambda: its part in the plane of the rim is N/q.
"""

from __future__ import annotations

import math

from tolmc.kernels import parameters as P
from tolmc.kernels.jit import device
from tolmc.kernels.one_sided import layout as at

_ITERATIONS = 4  # Newton's from the direction of p: 3 reach rounding on the paper's joint at its largest tilt
_TINY = 1e-30

FAR = 0.8
UNIT = True


@device
def size(raw, i):
    """c, m."""
    return raw[P.BEARING_RADIUS, i] - raw[P.JOURNAL_RADIUS, i]


@device
def _nearest(px, py, sx, sy, round_):
    """Direction n in which the rim is nearest, and s.n, s.Jn, p.n, q, 1/q there."""
    p2 = px * px + py * py
    inverse = 1.0 / math.sqrt(max(p2, _TINY))
    nx, ny = px * inverse, py * inverse
    nx = nx if p2 > _TINY else 1.0
    for _ in range(_ITERATIONS):
        sn, st = sx * nx + sy * ny, sy * nx - sx * ny
        pn, pt = px * nx + py * ny, py * nx - px * ny
        q2 = 1.0 + sn * sn
        q = math.sqrt(q2)
        # -f'/f'' times q^3/q^3; far from the wall f'' need not be positive and n is not needed
        steep = max(q * q2 * pn - round_ * (st * st - q2 * (sn * sn)), 1e-3)
        fall = 0.5 * (q * q2 * pt + round_ * q2 * (sn * st))
        fall = min(max(fall, -0.3 * steep), 0.3 * steep)
        # Turned by an angle whose half has the tangent fall/steep.
        turn = 1.0 / (steep * steep + fall * fall)
        cos, sin = (steep * steep - fall * fall) * turn, 2.0 * steep * fall * turn
        nx, ny = cos * nx - sin * ny, cos * ny + sin * nx
    sn, st = sx * nx + sy * ny, sy * nx - sx * ny
    q2 = 1.0 + sn * sn
    q = math.sqrt(q2)
    return nx, ny, sn, st, px * nx + py * ny, q, 1.0 / q


@device
def touch(px, py, vx, vy, sx, sy, tx, ty, coef, lane, width):
    """As in :mod:`circle`."""
    round_ = coef[at.ROUND * width + lane]
    nx, ny, sn, st, pn, q, iq = _nearest(px, py, sx, sy, round_)
    iq3 = iq * iq * iq
    tn, tt, vt = tx * nx + ty * ny, ty * nx - tx * ny, vy * nx - vx * ny
    steep = max(pn - round_ * (st * st * iq3 - sn * sn * iq), 1e-3)
    j = vt + round_ * (tn * st * iq3 + sn * tt * iq)
    gap = 1.0 - round_ * sn * sn / (1.0 + q) - pn
    lever = 1.0 + round_ * coef[at.KAPPA * width + lane] * sn * iq
    return nx, ny, lever, q, gap, -j * j / steep - round_ * tn * tn * iq3


@device
def gap(px, py, sx, sy, round_):
    """The gap alone."""
    _, _, sn, _, pn, q, _ = _nearest(px, py, sx, sy, round_)
    return 1.0 - round_ * sn * sn / (1.0 + q) - pn
