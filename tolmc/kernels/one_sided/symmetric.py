"""Body symmetric about its axis, free to move: mass matrix, its inverse, and the forces that depend on pose and speeds.

With the units of :mod:`layout`, n = e_z = 1/sqrt(1 + kappa^2 |w|^2), y = n^2, B = A/(m L^2), Z = z_C/L and
Gamma = C Omega/(m L^2):

    M = [[I, k1 P], [k1 P, k2 P]],   P = I - kappa^2 y w w^T,   k1 = Z n,   k2 = B y
    f_o = F + Z n (2 rho (w' - rho w) + w |e'|^2)
    P^-1 f_w = n (G - kappa^2 G_z w) + 2 B rho y w' + Gamma n y (J w' + kappa^2 (w.Jw') w)
    rho = kappa^2 y w.w',   |e'|^2 = kappa^2 y |w'|^2 - rho^2,   J(x, y) = (-y, x)

(README, "Model"). P^-1 = I + kappa^2 w w^T, so that no direction of the tilt is needed and no pose is singular; the body must
have moments of inertia about its centre of mass, B > Z^2.
"""

from __future__ import annotations

import math

from tolmc.kernels import parameters as P
from tolmc.kernels.jit import device, strict
from tolmc.kernels.one_sided import layout as at

SPINS = False  # whether the spin's rate is part of the body's equations even without friction
SWINGS = False  # whether loads or a drive swing
STATE = 8
COEFFICIENTS = at.FIRST + 6

_B, _Z, _IB, _Z2, _GYRO, _INVERSE_SPIN = range(at.FIRST, at.FIRST + 6)


@device
def prepare(raw, given, i, coef, lane, width):
    """Coefficients of lane ``lane``; those of the joint and the loads are there already."""
    mass, length = raw[P.MASS, i], raw[P.HALF_LENGTH, i]
    per_inertia = 1.0 / (mass * length * length)
    b, z, spin = raw[P.J_XX, i] * per_inertia, raw[P.COM_Z, i] / length, raw[P.J_ZZ, i] * per_inertia
    coef[_B * width + lane], coef[_Z * width + lane] = b, z
    coef[_IB * width + lane], coef[_Z2 * width + lane] = 1.0 / (b - z * z), z * z
    coef[_GYRO * width + lane] = spin
    free = spin > 0.0 and coef[at.DRIVEN * width + lane] == 0.0
    coef[_INVERSE_SPIN * width + lane] = 1.0 / spin if free else 0.0


@device
def orient(y, given, i, lane, width):
    """The part of the start that belongs to the turn about the axis: none here."""


@strict
def free(y, spin, coef, lane, width):
    """As :func:`solve`, of the forces that act without contact, and what it needs for others.

    To the same bits in a block that flies and in one that does not.
    """
    wx, wy = y[at.W_X * width + lane], y[at.W_Y * width + lane]
    vx, vy = y[at.WV_X * width + lane], y[at.WV_Y * width + lane]
    kappa2, b, z = coef[at.KAPPA2 * width + lane], coef[_B * width + lane], coef[_Z * width + lane]
    z2 = coef[_Z2 * width + lane]
    g = 1.0 + kappa2 * (wx * wx + wy * wy)
    bottom = b * g - z2
    inverse = 1.0 / (g * bottom)
    n2 = inverse * bottom
    n = math.sqrt(n2)
    i1, i2 = g * coef[_IB * width + lane], z2 * g * g * inverse * kappa2 * n2
    k1 = z * n
    rho = kappa2 * n2 * (wx * vx + wy * vy)
    turning = kappa2 * n2 * (vx * vx + vy * vy) - rho * rho
    lever = k1 * turning - 2.0 * k1 * rho * rho
    fx = coef[at.FX * width + lane] + 2.0 * k1 * rho * vx + lever * wx
    fy = coef[at.FY * width + lane] + 2.0 * k1 * rho * vy + lever * wy
    gyro = coef[_GYRO * width + lane] * spin * n * n2
    along = kappa2 * (gyro * (wy * vx - wx * vy) - n * coef[at.GZ * width + lane])
    damp = 2.0 * b * rho * n2
    gx = n * coef[at.GX * width + lane] + damp * vx - gyro * vy + along * wx
    gy = n * coef[at.GY * width + lane] + damp * vy + gyro * vx + along * wy
    factors = (
        wx,
        wy,
        kappa2,
        kappa2 * n2,
        i1,
        i2,
        k1,
        coef[_INVERSE_SPIN * width + lane],
        coef[at.DRIVEN * width + lane],
    )
    ax, ay, bx, by = _strictly_solved(fx, fy, gx - k1 * fx, gy - k1 * fy, factors)
    return ax, ay, bx, by, 0.0, 0.0, factors


def _solved(fx, fy, sx, sy, factors):
    wx, wy, _, kn, i1, i2, k1, _, _ = factors
    along = i2 * (wx * sx + wy * sy)
    bx, by = i1 * (sx - along * wx), i1 * (sy - along * wy)
    along = kn * (wx * bx + wy * by)
    return fx - k1 * (bx - along * wx), fy - k1 * (by - along * wy), bx, by


_contracted, _strictly_solved = device(_solved), strict(_solved)


@device
def solve(fx, fy, gx, gy, spin, factors):
    """M^-1 times the generalised forces on o, w and Omega/kappa, and what holds Omega where a drive does."""
    wx, wy, kappa2, _, _, _, k1, inverse_spin, driven = factors
    along = kappa2 * (wx * gx + wy * gy)
    ax, ay, bx, by = _contracted(fx, fy, gx + along * wx - k1 * fx, gy + along * wy - k1 * fy, factors)
    return ax, ay, bx, by, spin * inverse_spin, -driven * spin


@device
def energies(y, spin, spins, coef, lane, width):
    """T, V and the torque's power; without ``spins`` T lacks the constant C Omega^2/2."""
    wx, wy = y[at.W_X * width + lane], y[at.W_Y * width + lane]
    ux, uy = y[at.OV_X * width + lane], y[at.OV_Y * width + lane]
    vx, vy = y[at.WV_X * width + lane], y[at.WV_Y * width + lane]
    kappa2, b, z = coef[at.KAPPA2 * width + lane], coef[_B * width + lane], coef[_Z * width + lane]
    w2, dot = wx * wx + wy * wy, wx * vx + wy * vy
    n2 = 1.0 / (1.0 + kappa2 * w2)
    n = math.sqrt(n2)
    rho = kappa2 * n2 * dot
    kinetic = 0.5 * (ux * ux + uy * uy) + z * n * (ux * (vx - rho * wx) + uy * (vy - rho * wy))
    kinetic += 0.5 * b * n2 * (vx * vx + vy * vy - rho * dot)
    if spins:
        kinetic += 0.5 * coef[_GYRO * width + lane] * spin * spin / kappa2
    potential = -(
        y[at.O_X * width + lane] * coef[at.FX * width + lane] + y[at.O_Y * width + lane] * coef[at.FY * width + lane]
    )
    potential -= n * (wx * coef[at.GX * width + lane] + wy * coef[at.GY * width + lane])
    return kinetic, potential + coef[at.GZ * width + lane] * kappa2 * w2 * n2 / (1.0 + n), 0.0


@device
def momentum(y, spin, coef, lane, width):
    """Angular momentum about Z less the constant C Omega, that of a unit turn about Z, and |C Omega|, over m c^2.

    A unit turn is o' = Jo, w' = Jw. C Omega (n - 1) = -C Omega kappa^2 |w|^2 y/(1 + n).
    """
    ox, oy, wx, wy = (
        y[at.O_X * width + lane],
        y[at.O_Y * width + lane],
        y[at.W_X * width + lane],
        y[at.W_Y * width + lane],
    )
    ux, uy = y[at.OV_X * width + lane], y[at.OV_Y * width + lane]
    vx, vy = y[at.WV_X * width + lane], y[at.WV_Y * width + lane]
    kappa2, b, z = coef[at.KAPPA2 * width + lane], coef[_B * width + lane], coef[_Z * width + lane]
    w2, dot = wx * wx + wy * wy, wx * vx + wy * vy
    n2 = 1.0 / (1.0 + kappa2 * w2)
    n = math.sqrt(n2)
    rho = kappa2 * n2 * dot
    px, py, turned = vx - rho * wx, vy - rho * wy, wx * vy - wy * vx
    about_z = ox * uy - oy * ux + z * n * (ox * py - oy * px + wx * uy - wy * ux) + b * n2 * turned
    gyro = coef[_GYRO * width + lane] * spin
    unit = ox * ox + oy * oy + 2.0 * z * n * (ox * wx + oy * wy) + b * n2 * w2
    return about_z - gyro * w2 * n2 / (1.0 + n), unit, abs(gyro) / kappa2


@device
def turn(y, spin, h, k, first, coef, lane, width):
    """h times the rates of cos(chi) and sin(chi): not part of the state here."""


@device
def normalise(y, coef, lane, width):
    """Back to cos^2 + sin^2 = 1: nothing to do here."""
