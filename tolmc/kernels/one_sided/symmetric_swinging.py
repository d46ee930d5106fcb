"""The symmetric body whose drive swings: :mod:`symmetric` with the phase of its drive as two states more."""

from __future__ import annotations

from tolmc.kernels.jit import device
from tolmc.kernels.one_sided import layout as at
from tolmc.kernels.one_sided import oscillators, symmetric

SPINS, SWINGS = True, True
_PHASE = at.SPIN_RATE + 1
STATE = _PHASE + 2
_DRIVE = symmetric.COEFFICIENTS
COEFFICIENTS = _DRIVE + oscillators.DRIVE

solve, energies, momentum = symmetric.solve, symmetric.energies, symmetric.momentum
_prepare, _free, _gyro = symmetric.prepare, symmetric.free, symmetric._GYRO


@device
def prepare(raw, given, coef, lane, width):
    """As :func:`symmetric.prepare`, and the drive."""
    _prepare(raw, given, coef, lane, width)
    oscillators.prepare_drive(raw, coef, _DRIVE, lane, width)


@device
def orient(y, given, lane, width):
    """The drive's phase at the start."""
    oscillators.orient(y, _PHASE, given[at.PHASE_DRIVE * width + lane], lane, width)


@device
def free(y, spin, coef, lane, width):
    """As :func:`symmetric.free`; the drive's moment along the axis meets no other inertia than the spin's own."""
    ax, ay, bx, by, _, _, factors = _free(y, spin, coef, lane, width)
    spun = oscillators.spun(y, _PHASE, coef, _DRIVE, lane, width)
    return ax, ay, bx, by, spun, coef[_gyro * width + lane] * spun, factors


@device
def turn(y, spin, h, k, first, coef, lane, width):
    """h times the rates of the drive's phase."""
    oscillators.turn(y, _PHASE, coef[(_DRIVE + oscillators.FREQUENCY) * width + lane], h, k, first, lane, width)


@device
def normalise(y, coef, lane, width):
    """The drive's phase back to a unit pair, and Omega to what it says."""
    oscillators.normalise(y, _PHASE, lane, width)
    oscillators.set_spin(y, _PHASE, coef, _DRIVE, lane, width)
