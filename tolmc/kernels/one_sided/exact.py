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

_ITERATIONS = 2  # of Newton's after two of Halley's: rounding for c <= L, 1e-10 for c = 2 L
_TINY = 1e-30
_FARTHEST = 0.66  # change of the direction's tangent in one iteration

FAR = 0.8
UNIT = True
GLIMPSED = False


@device
def size(raw, lane, width):
    """c, m."""
    return raw[P.BEARING_RADIUS * width + lane] - raw[P.JOURNAL_RADIUS * width + lane]


@device
def _nearest(px, py, sx, sy, round_):
    """Direction n in which the rim is nearest, and s.n, s.Jn, p.n, q, 1/q there.

    n = (p + x Jp)/|p + x Jp|. With P = |p|^2, a = s.p, b = s.Jp, rho = r*/c and W = |p + x Jp| q, which has no other root than

        W^2 = P (1 + x^2) + (a + b x)^2,

    x is the root of P x W - rho (ab + (b^2 - a^2) x - ab x^2). Halley's iteration from 0 and once more; then Newton's, whose
    1/W and 1/slope follow by their own iterations, without roots and divisions.
    """
    p2 = px * px + py * py
    # In the middle of the bearing any direction will do.
    px, p2 = px if p2 > _TINY else 1.0, p2 if p2 > _TINY else 1.0
    a, b = sx * px + sy * py, sy * px - sx * py
    ab, difference, w2_0, bend = a * b, b * b - a * a, p2 + a * a, p2 + b * b
    w = math.sqrt(w2_0)
    # Far from the wall the gap need not have a minimum nearby and n is not needed.
    slope = max(p2 * w - round_ * difference, 1e-3 * w)
    fall = round_ * ab
    square = slope * slope * w
    x = fall * slope * w / min(square + fall * ab * (p2 + round_ * w), 1.5 * square)
    x = min(max(x, -_FARTHEST), _FARTHEST)
    w2, h = w2_0 + x * (2.0 * ab + bend * x), ab + bend * x
    w = math.sqrt(w2)
    fall = p2 * x * w - round_ * (ab + x * (difference - ab * x))
    slope = max(p2 * (w2 + x * h) - round_ * (difference - 2.0 * ab * x) * w, 1e-3)
    curvature = p2 * (2.0 * h * w2 + x * (bend * w2 - h * h)) + 2.0 * round_ * ab * w2 * w
    square = slope * slope * w
    bottom = min(max(square - 0.5 * fall * curvature, 0.5 * square), 1.5 * square)
    inverse = 1.0 / (slope * w * bottom)
    per_w, per_slope = inverse * slope * bottom, inverse * w2 * bottom
    change = fall * slope * w2 * (inverse * slope * w)
    x -= min(max(change, -_FARTHEST), _FARTHEST)
    for _ in range(_ITERATIONS):
        per_w = _improved(per_w, w2_0 + x * (2.0 * ab + bend * x))
        fall = p2 * x - round_ * (ab + x * (difference - ab * x)) * per_w
        slope = p2 * (1.0 + x * (ab + bend * x) * per_w * per_w) - round_ * (difference - 2.0 * ab * x) * per_w
        per_slope *= 2.0 - slope * per_slope
        x -= min(max(fall * per_slope, -_FARTHEST), _FARTHEST)
    w2 = w2_0 + x * (2.0 * ab + bend * x)
    per_w = _improved(per_w, w2)
    long2 = p2 * (1.0 + x * x)
    scale = 1.0 / math.sqrt(long2)
    sn, st = (a + b * x) * scale, (b - a * x) * scale
    return (px - x * py) * scale, (py + x * px) * scale, sn, st, p2 * scale, w2 * per_w * scale, long2 * scale * per_w


@device
def _improved(inverse, square):
    """1/sqrt(square) from next to it, to third order."""
    t = square * inverse * inverse
    return inverse * (1.875 - t * (1.25 - 0.375 * t))


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
