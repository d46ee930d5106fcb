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
from tolmc.kernels.jit import device, dot, fma, strict
from tolmc.kernels.one_sided import layout as at

SPINS = False  # whether the spin's rate is part of the body's equations even without friction
SWINGS = False  # whether loads or a drive swing
STATE = 8
COEFFICIENTS = at.FIRST + 8

_B, _Z, _IB, _Z2, _BK, _Z2K, _GYRO, _INVERSE_SPIN = range(at.FIRST, at.FIRST + 8)


@device
def prepare(raw, given, coef, lane, width):
    """Coefficients of lane ``lane``; those of the joint and the loads are there already."""
    mass, length = raw[P.MASS * width + lane], raw[P.HALF_LENGTH * width + lane]
    per_inertia = 1.0 / (mass * length * length)
    b, spin = raw[P.J_XX * width + lane] * per_inertia, raw[P.J_ZZ * width + lane] * per_inertia
    z = raw[P.COM_Z * width + lane] / length
    coef[_B * width + lane], coef[_Z * width + lane] = b, z
    coef[_IB * width + lane], coef[_Z2 * width + lane] = 1.0 / (b - z * z), z * z
    kappa2 = coef[at.KAPPA2 * width + lane]
    coef[_BK * width + lane], coef[_Z2K * width + lane] = b * kappa2, z * z * kappa2
    coef[_GYRO * width + lane] = spin
    free = (spin > 0.0) & (coef[at.DRIVEN * width + lane] == 0.0)
    coef[_INVERSE_SPIN * width + lane] = 1.0 / spin if free else 0.0


@device
def orient(y, given, lane, width):
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
    g = fma(kappa2, dot(wx, wy, wx, wy), 1.0)
    bottom = fma(b, g, -z2)
    inverse, root = 1.0 / (g * bottom), math.sqrt(g)
    n2, per_bottom = inverse * bottom, inverse * g
    # Not the root of n2, which would have to wait for the division.
    n, kn = n2 * root, kappa2 * n2
    i1, i2 = g * coef[_IB * width + lane], per_bottom * coef[_Z2K * width + lane]
    i3, k1 = per_bottom * coef[_BK * width + lane], z * n
    rho = kn * dot(wx, wy, vx, vy)
    swing, lever = 2.0 * k1 * rho, k1 * fma(-3.0 * rho, rho, kn * dot(vx, vy, vx, vy))
    fx = fma(lever, wx, fma(swing, vx, coef[at.FX * width + lane]))
    fy = fma(lever, wy, fma(swing, vy, coef[at.FY * width + lane]))
    gyro = coef[_GYRO * width + lane] * spin * n * n2
    along = kappa2 * fma(gyro, dot(wy, -wx, vx, vy), -n * coef[at.GZ * width + lane])
    damp = 2.0 * b * rho * n2
    gx = fma(along, wx, fma(-gyro, vy, fma(damp, vx, n * coef[at.GX * width + lane])))
    gy = fma(along, wy, fma(gyro, vx, fma(damp, vy, n * coef[at.GY * width + lane])))
    factors = wx, wy, kappa2, i1, i2, i3, k1, coef[_INVERSE_SPIN * width + lane], coef[at.DRIVEN * width + lane]
    ax, ay, bx, by = _solved(fx, fy, fma(-k1, fx, gx), fma(-k1, fy, gy), factors)
    return ax, ay, bx, by, 0.0, 0.0, factors


@strict
def _solved(fx, fy, sx, sy, factors):
    """The accelerations from f_o and s = P^-1 f_w - k1 f_o.

    w'' = i1 (I - i2 w w^T) s and P w'' = i1 (I - i3 w w^T) s, i1 = g/(B - Z^2), i2, i3 = kappa^2 (Z^2, B)/(B g - Z^2), g = 1/y.
    """
    wx, wy, _, i1, i2, i3, k1, _, _ = factors
    ws = dot(wx, wy, sx, sy)
    along, across, ik = i2 * ws, i3 * ws, k1 * i1
    ax, ay = fma(-ik, fma(-across, wx, sx), fx), fma(-ik, fma(-across, wy, sy), fy)
    return ax, ay, i1 * fma(-along, wx, sx), i1 * fma(-along, wy, sy)


@device
def solve(fx, fy, gx, gy, spin, factors):
    """M^-1 times the generalised forces on o, w and Omega/kappa, and what holds Omega where a drive does."""
    wx, wy, kappa2, _, _, _, k1, inverse_spin, driven = factors
    along = kappa2 * (wx * gx + wy * gy)
    ax, ay, bx, by = _solved(fx, fy, gx + along * wx - k1 * fx, gy + along * wy - k1 * fy, factors)
    return ax, ay, bx, by, spin * inverse_spin, -driven * spin


@strict
def energies(y, spin, spins, coef, lane, width):
    """T, V and the torque's power; without ``spins`` T lacks the constant C Omega^2/2."""
    wx, wy = y[at.W_X * width + lane], y[at.W_Y * width + lane]
    ux, uy = y[at.OV_X * width + lane], y[at.OV_Y * width + lane]
    vx, vy = y[at.WV_X * width + lane], y[at.WV_Y * width + lane]
    kappa2, b, z = coef[at.KAPPA2 * width + lane], coef[_B * width + lane], coef[_Z * width + lane]
    w2, wv = dot(wx, wy, wx, wy), dot(wx, wy, vx, vy)
    g = fma(kappa2, w2, 1.0)
    root = math.sqrt(g)
    inverse = 1.0 / (g * (g + root))
    n2 = inverse * (g + root)
    n, rho = n2 * root, kappa2 * n2 * wv
    lever = z * n * dot(ux, uy, fma(-rho, wx, vx), fma(-rho, wy, vy))
    kinetic = fma(0.5, dot(ux, uy, ux, uy), lever)
    kinetic = fma(0.5 * b * n2, fma(-rho, wv, dot(vx, vy, vx, vy)), kinetic)
    if spins:
        kinetic += 0.5 * coef[_GYRO * width + lane] * spin * spin / kappa2
    lift = dot(
        y[at.O_X * width + lane], y[at.O_Y * width + lane], coef[at.FX * width + lane], coef[at.FY * width + lane]
    )
    turned = n * dot(wx, wy, coef[at.GX * width + lane], coef[at.GY * width + lane])
    # kappa^2 |w|^2 y/(1 + n), which cancels nothing, is kappa^2 |w|^2/(g + root).
    return kinetic, fma(coef[at.GZ * width + lane] * kappa2 * w2, inverse * g, -lift - turned), 0.0


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
