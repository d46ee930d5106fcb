"""Roots and extrema within a step, and the two problems of complementarity: which contacts stay, and what an impact does.

Scalar functions of one lane: they are called where something happens, not in every round.
"""

from __future__ import annotations

import math

from tolmc.kernels.jit import device, routine

_SCAN = 12  # places at which a polynomial is looked at for its first change of sign
_REFINEMENTS = 4  # of Newton's for a minimum, from a twelfth of a step away
_ITERATIONS = 40  # of Newton's for a root: four or so, where it stays in its bracket


@device
def _horner(c, s):
    c0, c1, c2, c3, c4, c5 = c
    return c0 + s * (c1 + s * (c2 + s * (c3 + s * (c4 + s * c5))))


@device
def hermite(g0, r0, a0, g1, r1, a1, h):
    """Coefficients in s = t/h of the quintic with given value, first and second derivative at both ends of a step."""
    c1, c2 = r0 * h, 0.5 * a0 * h * h
    d0, d1, d2 = g1 - g0 - c1 - c2, r1 * h - c1 - 2.0 * c2, a1 * h * h - 2.0 * c2
    c3, c4 = 10.0 * d0 - 4.0 * d1 + 0.5 * d2, 7.0 * d1 - 15.0 * d0 - d2
    return g0, c1, c2, c3, c4, 6.0 * d0 - 3.0 * d1 + 0.5 * d2


@routine
def first_fall(c):
    """First s in (0, 1] where the polynomial falls through zero; 0 where it is negative from the start, 2 where it does not."""
    low = 0.0
    if _horner(c, low) < 0.0:
        return 0.0
    for place in range(1, _SCAN + 1):
        high = place / _SCAN
        if _horner(c, high) < 0.0:
            return _fall_between(c, low, high)
        low = high
    return 2.0


@routine
def _fall_between(c, low, high):
    """The root between two places of which the second alone is negative: Newton's from there, kept between them."""
    _, c1, c2, c3, c4, c5 = c
    s = high
    for _ in range(_ITERATIONS):
        value = _horner(c, s)
        if value == 0.0:
            return s
        low, high = (low, s) if value < 0.0 else (s, high)
        slope = c1 + s * (2.0 * c2 + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)))
        moved = s - value / slope
        if not low < moved < high:
            moved = 0.5 * (low + high)
        if abs(moved - s) <= 1e-9:  # the next one would be by rounding: the iteration is quadratic
            return moved
        s = moved
    return s


@routine
def lowest(c):
    """(least value, its place) of the polynomial on [0, 1]: the least of the scanned places, then Newton's for the slope."""
    best, at = _horner(c, 0.0), 0.0
    for place in range(1, _SCAN + 1):
        s = place / _SCAN
        value = _horner(c, s)
        if value < best:
            best, at = value, s
    _, c1, c2, c3, c4, c5 = c
    low, high, s = max(at - 1.0 / _SCAN, 0.0), min(at + 1.0 / _SCAN, 1.0), at
    for _ in range(_REFINEMENTS):
        slope = c1 + s * (2.0 * c2 + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)))
        bend = 2.0 * c2 + s * (6.0 * c3 + s * (12.0 * c4 + s * 20.0 * c5))
        s = min(max(s - slope / bend, low), high) if bend > 0.0 else s
        value = _horner(c, s)
        if value < best:
            best, at = value, s
    return best, at


@device
def stays(a, acc, can_d, can_e):
    """(D closed, E closed, violation): which of the contacts that touch at rest stay closed.

    0 <= lambda, A lambda + acc >= 0, complementary, by enumeration. ``violation`` is by how much the chosen case misses, as an
    acceleration; of cases that miss by nothing but rounding the one with more contacts counts.
    """
    a_dd, a_de, a_ed, a_ee = a
    acc_d, acc_e = acc
    slack = 1e-12 * (abs(acc_d) + abs(acc_e))
    missed = max(-acc_d if can_d else 0.0, -acc_e if can_e else 0.0)
    best, d, e = missed, False, False
    if can_e and a_ee > 0.0:
        force = -acc_e / a_ee
        missed = max(acc_e, -(acc_d + a_de * force) if can_d else -math.inf)
        if missed <= best + slack:
            best, d, e = missed, False, True
    if can_d and a_dd > 0.0:
        force = -acc_d / a_dd
        missed = max(acc_d, -(acc_e + a_ed * force) if can_e else -math.inf)
        if missed <= best + slack:
            best, d, e = missed, True, False
    if can_d and can_e:
        det = a_dd * a_ee - a_de * a_ed
        if det > 0.0 and a_dd > 0.0 and a_ee > 0.0:
            missed = max(
                -(a_de * acc_e - a_ee * acc_d) / det * a_dd, -(a_ed * acc_d - a_dd * acc_e) / det * a_ee
            )  # fmt: skip
            if missed <= best + slack:
                best, d, e = missed, True, True
    return d, e, best - slack


@device
def impulses(a, b_d, b_e, on_d, on_e):
    """(Lambda_D, Lambda_E, violation): 0 <= Lambda, A Lambda + b >= 0, complementary, over the contacts at the wall.

    By selects, for loops over lanes.
    """
    a_dd, a_de, a_ed, a_ee = a
    slack = 1e-14 * (abs(b_d) + abs(b_e))
    best, l_d, l_e = max(-b_d if on_d else 0.0, -b_e if on_e else 0.0), 0.0, 0.0
    alone = -b_d / a_dd
    missed = max(b_d, -(b_e + a_ed * alone) if on_e else -math.inf)
    better = on_d & (a_dd > 0.0) & (missed <= best - slack)
    best, l_d = missed if better else best, max(alone, 0.0) if better else l_d
    alone = -b_e / a_ee
    missed = max(b_e, -(b_d + a_de * alone) if on_d else -math.inf)
    better = on_e & (a_ee > 0.0) & (missed <= best - slack)
    best, l_d, l_e = missed if better else best, 0.0 if better else l_d, max(alone, 0.0) if better else l_e
    det = a_dd * a_ee - a_de * a_ed
    inverse = 1.0 / det
    both_d, both_e = (a_de * b_e - a_ee * b_d) * inverse, (a_ed * b_d - a_dd * b_e) * inverse
    missed = max(-both_d * a_dd, -both_e * a_ee)
    better = on_d & on_e & (det > 0.0) & (a_dd > 0.0) & (a_ee > 0.0) & (missed <= best + slack)
    best, l_d, l_e = (
        missed if better else best, max(both_d, 0.0) if better else l_d, max(both_e, 0.0) if better else l_e,
    )  # fmt: skip
    return l_d, l_e, best - slack


@device
def brought_to_rest(a, rate_d, rate_e, on_d, on_e):
    """Impulses that take the contacts' speeds away, of either sign."""
    a_dd, a_de, a_ed, a_ee = a
    a_dd, a_ee = a_dd if on_d else 1.0, a_ee if on_e else 1.0
    a_de, a_ed = a_de if on_d and on_e else 0.0, a_ed if on_d and on_e else 0.0
    r_d, r_e = -rate_d if on_d else 0.0, -rate_e if on_e else 0.0
    inverse = 1.0 / (a_dd * a_ee - a_de * a_ed)
    return (a_ee * r_d - a_de * r_e) * inverse, (a_dd * r_e - a_ed * r_d) * inverse
