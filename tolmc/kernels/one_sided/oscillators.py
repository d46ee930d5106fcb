"""What swings: pairs (cos, sin) of phases that are states of their own, turned at their frequencies by the equations.

    c' = -w s,   s' = w c

so that loads and drives that depend on time leave the equations autonomous, and of the formula's order. A drive that swings the
body by A sin(phase) has Omega = Omega_mean + A w c and Omega' = -A w^2 s.
"""

from __future__ import annotations

import math

from tolmc.kernels import parameters as P
from tolmc.kernels.jit import device
from tolmc.kernels.one_sided import layout as at

TAU = 2.0 * math.pi

#: Coefficients of a drive, from where a body's own end: w, A w (0 where it does not swing), Omega_mean.
FREQUENCY, RATE, MEAN = range(3)
DRIVE = 3


@device
def prepare_drive(raw, coef, first, lane, width):
    """The drive's coefficients from row ``first`` on."""
    frequency = TAU * raw[P.DRIVE_FREQUENCY * width + lane]
    coef[(first + FREQUENCY) * width + lane] = frequency
    coef[(first + RATE) * width + lane] = frequency * raw[P.DRIVE_AMPLITUDE * width + lane]
    coef[(first + MEAN) * width + lane] = raw[P.SPIN_RATE * width + lane]


@device
def orient(y, row, phase, lane, width):
    """A pair at its start, rows ``row`` and ``row + 1`` of the state."""
    y[row * width + lane], y[(row + 1) * width + lane] = math.cos(phase), math.sin(phase)


@device
def turn(y, row, frequency, h, k, first, lane, width):
    """h times a pair's rates into ``k[first:]``."""
    rate = h * frequency
    k[first + row * width + lane] = -rate * y[(row + 1) * width + lane]
    k[first + (row + 1) * width + lane] = rate * y[row * width + lane]


@device
def normalise(y, row, lane, width):
    """A pair back to cos^2 + sin^2 = 1."""
    cos, sin = y[row * width + lane], y[(row + 1) * width + lane]
    to_1 = 1.0 / math.sqrt(cos * cos + sin * sin)
    y[row * width + lane], y[(row + 1) * width + lane] = to_1 * cos, to_1 * sin


@device
def spun(y, row, coef, first, lane, width):
    """Omega'/kappa that a drive gives; 0 where the body turns as it will."""
    rate = coef[(first + FREQUENCY) * width + lane] * coef[(first + RATE) * width + lane]
    swing = coef[at.DRIVEN * width + lane] * rate / coef[at.KAPPA * width + lane]
    return -swing * y[(row + 1) * width + lane]


@device
def set_spin(y, row, coef, first, lane, width):
    """Omega as its drive's phase has it."""
    spin = coef[(first + MEAN) * width + lane] + coef[(first + RATE) * width + lane] * y[row * width + lane]
    driven = coef[at.DRIVEN * width + lane] > 0.0
    y[at.SPIN_RATE * width + lane] = spin if driven else y[at.SPIN_RATE * width + lane]
