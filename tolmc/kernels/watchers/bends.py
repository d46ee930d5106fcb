"""What values, rates and the mean of a quantity at two ends of a step say of what it does between them."""

from __future__ import annotations

import numpy as np

from tolmc.kernels.jit import device

#: Sum of both rates, over the change between two ends, up to which the values are taken to change one way.
_MONOTONE = 2.5
#: Share of the change between two ends by which the mean between them may miss the cubic's: that of a step that is resolved is
#: less, but where the change is next to nothing.
_SWING = 0.05
#: What a maximum beside an end adds at most, over the rate there. A parabola's adds up to a half; three quarters are allowed
#: for.
_RISE = 0.75
#: Share of the other rate up to which an end counts as one without a rate.
_FLAT = 1e-3


@device
def may_bend(n0, n1, m0, m1):
    """Whether the values at two ends change so little, or so much the other way, that their rates may turn between.

    A parabola's rates add up to twice the change; up to three times the cubic through both ends is monotone (Fritsch and
    Carlson, SIAM J. Numer. Anal. 17, 1980). Short of that there may be a small maximum that no cubic has; also beside an end
    without a rate, where a motion starts from rest.
    """
    both, flatter, steeper = m0 + m1, min(abs(m0), abs(m1)), max(abs(m0), abs(m1))
    return (_MONOTONE * (n1 - n0) * both < both * both) | (flatter <= _FLAT * steeper)


@device
def swings(n0, n1, m0, m1, mean):
    """Whether the mean between two ends is far from that of the cubic through them: there is more than they tell."""
    return abs(mean - 0.5 * (n0 + n1) - (m0 - m1) / 12.0) > _SWING * abs(n1 - n0)


@device
def rise(m):
    """What a maximum, or a minimum, on either side of an end with rate ``m`` may differ by at most from the value there.

    No interval promises more, in :func:`highest_of`, than both of its ends do.
    """
    return _RISE * abs(m)


@device
def highest_of(n0, n1, m0, m1, does_swing):
    """:func:`highest` of a force, of whose mean between the ends is known whether it :func:`swings`.

    Where it does the rates may be anything, also rounding: there may be a maximum whichever way they point.
    """
    bends = does_swing | may_bend(n0, n1, m0, m1)
    turns_over, rises, falls = (m0 > 0.0) & (m1 < 0.0), m0 > 0.0, m1 < 0.0
    top = n0 + rise(m0) if does_swing | rises & (turns_over | bends) else -np.inf
    return max(top, n1 + rise(m1)) if does_swing | falls & (turns_over | bends) else top


@device
def highest(n0, n1, m0, m1):
    """What a maximum between two ends may be at most, from the values and rates at both (-inf: there is none).

    Between two ends that both rise, or both fall, is one only where they may bend.
    """
    return highest_of(n0, n1, m0, m1, False)
