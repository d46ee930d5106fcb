"""The equations of motion that a lane can follow, chosen at compile time by what the scene has.

``general``, ``axial`` and ``exact`` are None or 1. With all None the body is symmetric about its axis
(:mod:`slope_symmetric`), ``axial`` adds that all load is axial (:mod:`slope_axial`), ``general`` is any body and load
(:mod:`slope_general`); ``exact`` replaces the circles by the exact section (:mod:`exact_symmetric`, :mod:`exact_general`).
Numba does not compile the branches of what is None.
"""

from __future__ import annotations

from tolmc.kernels.formulations import exact_general, exact_symmetric, slope_axial, slope_general, slope_symmetric
from tolmc.kernels.jit import device


@device
def sizes(general, axial, exact):
    """Components of the state and rows of the coefficients."""
    if exact is not None and general is not None:
        return exact_general.STATE, exact_general.COEFFICIENTS
    elif exact is not None:
        return exact_symmetric.STATE, exact_symmetric.COEFFICIENTS
    elif general is not None:
        return slope_general.STATE, slope_general.COEFFICIENTS
    elif axial is not None:
        return slope_axial.STATE, slope_axial.COEFFICIENTS
    else:
        return slope_symmetric.STATE, slope_symmetric.COEFFICIENTS


@device
def prepare(raw, i, coef, y, lane, width, general, axial, exact):
    """Coefficients and start of lane ``lane`` from column ``i`` of the parameters."""
    if exact is not None and general is not None:
        exact_general.prepare(raw, i, coef, lane, width)
        exact_general.start(raw, i, y, lane, width)
    elif exact is not None:
        exact_symmetric.prepare(raw, i, coef, lane, width)
        exact_symmetric.start(raw, i, y, lane, width)
    elif general is not None:
        slope_general.prepare(raw, i, coef, lane, width)
        slope_general.start(raw, i, y, lane, width)
    elif axial is not None:
        slope_axial.prepare(raw, i, coef, lane, width)
        slope_axial.start(raw, i, y, coef, lane, width)
    else:
        slope_symmetric.prepare(raw, i, coef, lane, width)
        slope_symmetric.start(raw, i, y, coef, lane, width)


@device
def advance(y, coef, h, k, first, lane, width, general, axial, exact, load):
    """h y' into ``k[first:]``; returns N_D, N_E, |w|^2 and the power of the torque."""
    if exact is not None and general is not None:
        return exact_general.advance(y, coef, h, k, first, lane, width, load is not None)
    elif exact is not None:
        return exact_symmetric.advance(y, coef, h, k, first, lane, width, load is not None)
    elif general is not None:
        return slope_general.advance(y, coef, h, k, first, lane, width, load is not None)
    elif axial is not None:
        return slope_axial.advance(y, coef, h, k, first, lane, width, load is not None)
    else:
        return slope_symmetric.advance(y, coef, h, k, first, lane, width, load is not None)


@device
def project(y, coef, lane, width, general, axial, exact):
    """Put the state back on its constraints; returns the relative error left."""
    if exact is not None and general is not None:
        return exact_general.project(y, coef, lane, width)
    elif exact is not None:
        return exact_symmetric.project(y, coef, lane, width)
    elif general is not None:
        return slope_general.project(y, coef, lane, width)
    elif axial is not None:
        return slope_axial.project(y, coef, lane, width)
    else:
        return slope_symmetric.project(y, coef, lane, width)


@device
def momentum(y, coef, lane, width, general, axial, exact):
    """Angular momentum about Z (kg m^2/s) less its constant part, that of a unit turn about Z (kg m^2), the constant part."""
    if exact is not None and general is not None:
        return exact_general.momentum(y, coef, lane, width)
    elif exact is not None:
        return exact_symmetric.momentum(y, coef, lane, width)
    elif general is not None:
        return slope_general.momentum(y, coef, lane, width)
    elif axial is not None:
        return slope_axial.momentum(y, coef, lane, width)
    else:
        return slope_symmetric.momentum(y, coef, lane, width)


@device
def scale_speeds(y, factor, lane, width, general, axial, exact):
    """Multiply the speeds by ``factor``."""
    if exact is not None and general is not None:
        exact_general.scale_speeds(y, factor, lane, width)
    elif exact is not None:
        exact_symmetric.scale_speeds(y, factor, lane, width)
    elif general is not None:
        slope_general.scale_speeds(y, factor, lane, width)
    elif axial is not None:
        slope_axial.scale_speeds(y, factor, lane, width)
    else:
        slope_symmetric.scale_speeds(y, factor, lane, width)


@device
def observe(y, coef, lane, width, general, axial, exact, load):
    """(O_x, O_y, u, v, N_D, N_E, lambda_D, lambda_E, T, V, |w|^2) of one lane.

    In the axial form, which does not know the pose's turn about Z, O and (u, v) are (|O|, 0) and (|w|, 0).
    """
    if exact is not None and general is not None:
        return exact_general.observe(y, coef, lane, width, load is not None)
    elif exact is not None:
        return exact_symmetric.observe(y, coef, lane, width, load is not None)
    elif general is not None:
        return slope_general.observe(y, coef, lane, width, load is not None)
    elif axial is not None:
        return slope_axial.observe(y, coef, lane, width, load is not None)
    else:
        return slope_symmetric.observe(y, coef, lane, width, load is not None)
