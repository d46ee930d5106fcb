"""The start of a motion on the wall: from polar angles and rates to (X0, Y0, u, v) and their rates."""

from __future__ import annotations

import math
from collections.abc import Callable

from tolmc.kernels import jit, names
from tolmc.kernels import parameters as P
from tolmc.kernels.bare import Table
from tolmc.kernels.formulations import exact_section
from tolmc.kernels.once import once
from tolmc.kernels.one_sided import layout as at
from tolmc.kernels.one_sided.exact import gap as exact_gap


def from_angles(raw: Table, given: Table, exact: bool):
    """Rows START_X to START_V_RATE of ``given`` (layout.GIVEN, n), SI units, of the pose that touches the wall at D and E.

    ``exact``: whether the section is exact. The rows of spin are filled too.
    """
    for i in range(raw.shape[1]):
        alpha, beta, alpha_rate, beta_rate = raw[P.ALPHA, i], raw[P.BETA, i], raw[P.ALPHA_RATE, i], raw[P.BETA_RATE, i]
        length = raw[P.HALF_LENGTH, i]
        if exact:
            journal = raw[P.JOURNAL_RADIUS, i] / length
            clearance = (raw[P.BEARING_RADIUS, i] - raw[P.JOURNAL_RADIUS, i]) / length
            c_x, c_y, cos_d, sin_d, sin_e, swing, nu = exact_section.start(
                alpha, beta, alpha_rate, beta_rate, clearance, journal
            )
            ox, oy, wx, wy, ux, uy, vx, vy = exact_section.motion(
                c_x, c_y, cos_d, sin_d, sin_e, swing, nu, clearance, journal
            )
        else:
            length = raw[P.RADIUS, i]
            cos_m, sin_m = math.cos(0.5 * (alpha + beta)), math.sin(0.5 * (alpha + beta))
            cos_h, sin_h = math.cos(0.5 * (alpha - beta)), math.sin(0.5 * (alpha - beta))
            s, d = 0.5 * (alpha_rate + beta_rate), 0.5 * (alpha_rate - beta_rate)
            ox, oy, wx, wy = cos_h * cos_m, cos_h * sin_m, -sin_h * sin_m, sin_h * cos_m
            ux, uy, vx, vy = -s * oy - d * wy, s * ox + d * wx, -s * wy - d * oy, s * wx + d * ox
        given[at.START_X, i], given[at.START_Y, i] = length * ox, length * oy
        given[at.START_U, i], given[at.START_V, i] = length * wx, length * wy
        given[at.START_X_RATE, i], given[at.START_Y_RATE, i] = length * ux, length * uy
        given[at.START_U_RATE, i], given[at.START_V_RATE, i] = length * vx, length * vy
        given[at.CHI, i], given[at.OMEGA, i] = raw[P.SPIN, i], raw[P.SPIN_RATE, i]
        given[at.ON_D, i], given[at.ON_E, i] = 1.0, 1.0


def gaps(raw: Table, given: Table, exact: bool, out: Table):
    """Gaps at D and E over c of the starts in ``given``, (2, n)."""
    for i in range(raw.shape[1]):
        length, journal = raw[P.HALF_LENGTH, i], raw[P.JOURNAL_RADIUS, i]
        for side in range(2):
            sign = 1.0 if side == 0 else -1.0
            u, v = sign * given[at.START_U, i], sign * given[at.START_V, i]
            if exact:
                c = raw[P.BEARING_RADIUS, i] - journal
                px, py = (given[at.START_X, i] + u) / c, (given[at.START_Y, i] + v) / c
                out[side, i] = exact_gap(px, py, u / length, v / length, journal / c)
            else:
                c = raw[P.RADIUS, i]
                px, py = (given[at.START_X, i] + u) / c, (given[at.START_Y, i] + v) / c
                out[side, i] = 0.5 * (1.0 - px * px - py * py)


@once
def build_from_angles() -> Callable:
    """Entry :func:`from_angles`."""
    return jit.entry(from_angles, names.FROM_ANGLES)


@once
def build_gaps() -> Callable:
    """Entry :func:`gaps`."""
    return jit.entry(gaps, names.GAPS)
