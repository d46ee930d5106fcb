"""Equations of motion, a module a formulation.

A formulation has, with SI units at its borders and every array flat, (row, lane) with ``width`` lanes:

``STATE``, ``COEFFICIENTS``
    Rows of the state y and of the coefficients coef.
``TORQUE``
    Whether its loads may have a torque, or friction and a drive do work, which the energy balance then includes.
``RUBS``
    Whether it has friction. ``advance`` then returns in place of the power the slip powers N |v| at both ends, the heat and
    friction's moment about the axis, in the units that ``units(coef, lane, width)`` gives; half the sum of the polar rates, by
    how much the slower contact exceeds the slip speed, and the margin by which the contact forces are determined.
    ``sense(y, coef, lane, width, with_load)`` returns (N_D, N_E, |w|^2, the moment), ``spin_rate(y, coef, lane, width)`` Omega.
``prepare(raw, i, coef, lane, width)``, ``start(raw, i, y, coef, lane, width)``
    Coefficients and state at t = 0 of a lane from column i of the parameters.
``advance(y, coef, h, k, first, lane, width, with_load)``
    h y' into ``k[first:]``; returns N_D, N_E, |w|^2, T, V and the power of the torque.
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
