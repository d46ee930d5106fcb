"""Geometry of the tilted journal: equations (1)-(3).

The journal (radius r*) touches the bearing (radius R*, half-length L) at its largest tilt psi when
R* cos(psi) - L sin(psi) - r* = 0; its axis then rests on circles of radius r = R* - r*/cos(psi) = L tan(psi).
"""

from __future__ import annotations

from typing import overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tolmc.mechanism.checks import plain_array

_Array = NDArray[np.float64]


def _checked(
    bearing_radius: ArrayLike, journal_radius: ArrayLike, half_length: ArrayLike
) -> tuple[_Array, _Array, _Array]:
    R, r, L = np.broadcast_arrays(
        plain_array("bearing_radius", bearing_radius),
        plain_array("journal_radius", journal_radius),
        plain_array("half_length", half_length),
    )
    valid = np.isfinite(R) & np.isfinite(r) & np.isfinite(L) & (r > 0) & (r < R) & (L > 0)
    if not np.all(valid):
        i = np.unravel_index(np.argmin(valid), valid.shape)
        where = f" at index {tuple(int(k) for k in i)}" if valid.ndim else ""
        raise ValueError(
            f"geometry invalid{where}: bearing_radius={float(R[i])!r} m, journal_radius={float(r[i])!r} m, "
            f"half_length={float(L[i])!r} m; allowed: 0 < journal_radius < bearing_radius, half_length > 0, "
            "all finite. Check the dimensions and that the tolerances leave a clearance."
        )
    return R, r, L


def _in_range(R: _Array, r: _Array, L: _Array) -> tuple[_Array, _Array, _Array, _Array | float]:
    """The lengths and the power of two that they were divided by: 1, unless their squares would leave a double's range."""
    largest = np.maximum(R, L)
    if largest.size == 0 or (largest.max() < 1e100 and min(r.min(), L.min()) > 1e-100):
        return R, r, L, 1.0
    scale = np.exp2(np.floor(np.log2(largest)))
    return R / scale, r / scale, L / scale, scale


def _half_tangent(R: _Array, r: _Array, L: _Array) -> _Array:
    # (R* + r*) t^2 + 2 L t - (R* - r*) = 0 with t = tan(psi/2): the root in this form cancels nothing, so it keeps
    # full relative precision at any clearance. hypot would not: (R* - r*)(R* + r*) is a difference of squares.
    clearance = R - r
    return clearance / (L + np.sqrt(L * L + clearance * (R + r)))


@overload
def tilt_angle(bearing_radius: float, journal_radius: float, half_length: float) -> float: ...
@overload
def tilt_angle(bearing_radius: ArrayLike, journal_radius: ArrayLike, half_length: ArrayLike) -> _Array: ...
def tilt_angle(bearing_radius: ArrayLike, journal_radius: ArrayLike, half_length: ArrayLike) -> float | _Array:
    """Largest tilt psi of the journal's axis that the clearance allows, equation (2).

    R* cos(psi) - L sin(psi) - r* = 0, solved by the half-angle form without cancellation.

    Parameters
    ----------
    bearing_radius, journal_radius, half_length : array_like, m
        R*, r*, L; broadcast against each other. Valid: 0 < r* < R*, L > 0, all finite.

    Returns
    -------
    numpy.ndarray or float, rad
        In the broadcast shape.

    Raises
    ------
    ValueError
        When an element is outside the valid range; the message names it.
    """
    R, r, L, _ = _in_range(*_checked(bearing_radius, journal_radius, half_length))
    return 2.0 * np.arctan(_half_tangent(R, r, L))


@overload
def effective_radius(bearing_radius: float, journal_radius: float, half_length: float) -> float: ...
@overload
def effective_radius(bearing_radius: ArrayLike, journal_radius: ArrayLike, half_length: ArrayLike) -> _Array: ...
def effective_radius(bearing_radius: ArrayLike, journal_radius: ArrayLike, half_length: ArrayLike) -> float | _Array:
    """Radius r = R* - r*/cos(psi) = L tan(psi) of the circles on which the axis rests, equation (3).

    Parameters, shapes and errors as in :func:`tilt_angle`; returns m.
    """
    return radius_of_valid(*_checked(bearing_radius, journal_radius, half_length))


def radius_of_valid(R: _Array, r: _Array, L: _Array) -> _Array:
    """:func:`effective_radius` of arrays of one shape that are known to be valid."""
    R, r, L, scale = _in_range(R, r, L)
    # L tan(psi) with the half-angle tangent inserted: only positive terms are left, at any clearance and length.
    squares = (R - r) * (R + r)
    return scale * (squares * L / (R * L + r * np.sqrt(L * L + squares)))


@overload
def approximate_radius(bearing_radius: float, journal_radius: float, half_length: float | None = None) -> float: ...
@overload
def approximate_radius(
    bearing_radius: ArrayLike, journal_radius: ArrayLike, half_length: ArrayLike | None = None
) -> _Array: ...
def approximate_radius(
    bearing_radius: ArrayLike, journal_radius: ArrayLike, half_length: ArrayLike | None = None
) -> float | _Array:
    """The usual small-clearance value R* - r* in place of equation (3), m.

    ``half_length`` is accepted so that the three functions of this module take the same arguments; it plays no part.
    """
    R, r, _ = _checked(bearing_radius, journal_radius, 1.0 if half_length is None else half_length)
    return R - r
