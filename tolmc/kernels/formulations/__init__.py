"""Equations of motion, a module a formulation.

A formulation has, with SI units at its borders and every array flat, (row, lane) with ``width`` lanes:

``STATE``, ``COEFFICIENTS``
    Rows of the state y and of the coefficients coef.
``TORQUE``
    Whether its loads may have a torque, or friction and a drive do work, which the energy balance then includes.
``RUBS``
    Whether it has friction. The last part then returns N_D, N_E, the slip powers N |v| at both ends, the heat and friction's
    moment about the axis, in the units that ``units(coef, lane, width)`` gives, and half the sum of the polar rates;
    ``sense`` the moment besides. ``at_end(held, besides, y, coef, lane, width)`` is |w|^2, T, V, by how much the slower contact
    exceeds the slip speed and the margin by which the contact forces are determined, ``besides`` what the part before the last
    returns; ``spin_rate(y, coef, lane, width)`` is Omega.
``prepare(raw, i, coef, lane, width)``, ``start(raw, i, y, coef, lane, width)``
    Coefficients and state at t = 0 of a lane from column i of the parameters.
``PARTS``, ``HELD``
    The right-hand side in parts, each for a loop over lanes of its own: ``part(y, held, coef, lane, width, with_load)``, the
    last ``finish(y, held, coef, h, k, first, lane, width, with_load)``: h y' into ``k[first:]``; returns N_D, N_E, |w|^2, T,
    V and the power of the torque. The first, or None, shares the loop that sums up a stage's argument. ``held`` has what one
    part hands on to the next, in HELD rows after those of the state.
``sense(y, held, coef, lane, width, with_load)``
    In place of the last part: N_D, N_E.
``rate_of_w2(y, k, coef, lane, width)``
    The rate of |w|^2, of the length of the step in whose increments ``k`` the last part has put h y'.
``project(y, coef, lane, width)``
    Puts the state back on its constraints; returns the relative error left.
``momentum(y, coef, lane, width)``
    Angular momentum about Z (kg m^2/s) less its constant part, that of a unit turn about Z (kg m^2), the constant part.
``scale_speeds(y, factor, lane, width)``
    Multiplies the speeds by ``factor``.
``observe(y, coef, lane, width, with_load)``
    (O_x, O_y, u, v, N_D, N_E, lambda_D, lambda_E, T, V, |w|^2).
``motion(y, coef, lane, width)``
    (O_x, O_y, u, v, O_x', O_y', u', v', chi, Omega), the last two 0 where the spin is a constant.

What is listed in :data:`FORMULATIONS` is tested (order, energy, drift, twin, bits in any lane) and can be integrated.
"""

from __future__ import annotations

from tolmc.kernels.formulations import (
    exact_general,
    exact_symmetric,
    slope_axial,
    slope_general,
    slope_rubbing,
    slope_symmetric,
)

FORMULATIONS = {
    "slope_symmetric": slope_symmetric,
    "slope_axial": slope_axial,
    "slope_general": slope_general,
    "slope_rubbing": slope_rubbing,
    "exact_symmetric": exact_symmetric,
    "exact_general": exact_general,
}
