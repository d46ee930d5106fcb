"""Any body whose loads or drive swing: :mod:`general` with the phases of what swings as states more.

A part of the force is A sin(phase) at the force's point, a part of the torque the same; the axes of A are fixed or turn with
the body. Their power counts as work, as the torque's does.
"""

from __future__ import annotations

from tolmc.kernels import parameters as P
from tolmc.kernels.jit import device
from tolmc.kernels.one_sided import general, oscillators
from tolmc.kernels.one_sided import layout as at

SPINS, SWINGS = True, True
_PHASES = general.STATE  # of the parts of force and torque, two each, and of the drive
_DRIVE_PHASE = _PHASES + 8
STATE = _DRIVE_PHASE + 2
_TERM = 5  # rows of the parameters of a part: amplitude x, y, z, frequency, phase
_TERMS = general.COEFFICIENTS  # rows of a part: w, the amplitude in fixed axes, the one that turns
_ROWS = 7
_DRIVE = _TERMS + 4 * _ROWS
COEFFICIENTS = _DRIVE + oscillators.DRIVE

solve, momentum = general.solve, general.momentum
_prepare, _orient, _moved, _energies, _turn = (
    general.prepare, general.orient, general.moved, general.energies, general.turn
)  # fmt: skip
_normalise, _body, _in_frame, _cross = general.normalise, general._body, general._in_frame, general._cross


@device
def prepare(raw, given, coef, lane, width):
    """As :func:`general.prepare`, and what swings."""
    _prepare(raw, given, coef, lane, width)
    mass, c, length = raw[P.MASS * width + lane], coef[at.C * width + lane], raw[P.HALF_LENGTH * width + lane]
    for term in range(4):
        row, first = P.FORCE_TERM_1_X + term * _TERM, _TERMS + term * _ROWS
        coef[first * width + lane] = oscillators.TAU * raw[(row + 3) * width + lane]
        unit = 1.0 / (mass * c) if term < 2 else 1.0 / (mass * c * length)
        turns = given[(at.TURNS_1 + term) * width + lane]
        for axis in range(3):
            coef[(first + 1 + axis) * width + lane] = (1.0 - turns) * unit * raw[(row + axis) * width + lane]
            coef[(first + 4 + axis) * width + lane] = turns * unit * raw[(row + axis) * width + lane]
    oscillators.prepare_drive(raw, coef, _DRIVE, lane, width)


@device
def orient(y, given, lane, width):
    """The turn about the axis and all phases at the start."""
    _orient(y, given, lane, width)
    for oscillator in range(5):
        oscillators.orient(y, _PHASES + 2 * oscillator, given[(at.PHASE_1 + oscillator) * width + lane], lane, width)


@device
def _pair(y, coef, term, row, lane, width):
    """Both parts of the force (``term`` 0) or of the torque (2), three amplitudes from ``row`` on."""
    first, second = (_TERMS + term * _ROWS + row) * width + lane, (_TERMS + (term + 1) * _ROWS + row) * width + lane
    a, b = y[(_PHASES + 2 * term + 1) * width + lane], y[(_PHASES + 2 * term + 3) * width + lane]
    return (
        a * coef[first] + b * coef[second],
        a * coef[first + width] + b * coef[second + width],
        a * coef[first + 2 * width] + b * coef[second + 2 * width],
    )


@device
def _turned(vector, y, lane, width):
    """A vector that turns with the body, in the frame of the smallest rotation."""
    cos, sin = y[at.COS * width + lane], y[at.SIN * width + lane]
    return cos * vector[0] - sin * vector[1], sin * vector[0] + cos * vector[1], vector[2]


@device
def _swinging(y, coef, lane, width):
    """Force and torque that swing: in fixed axes, in the frame, and again."""
    return (
        _pair(y, coef, 0, 1, lane, width), _turned(_pair(y, coef, 0, 4, lane, width), y, lane, width),
        _pair(y, coef, 2, 1, lane, width), _turned(_pair(y, coef, 2, 4, lane, width), y, lane, width),
    )  # fmt: skip


@device
def free(y, spin, coef, lane, width):
    """As :func:`general.free`, with what swings."""
    force, turned_force, torque, turned_torque = _swinging(y, coef, lane, width)
    spun = oscillators.spun(y, _DRIVE_PHASE, coef, _DRIVE, lane, width)
    return _moved(y, spin, spun, force, turned_force, torque, turned_torque, coef, lane, width)


@device
def energies(y, spin, spins, coef, lane, width):
    """As :func:`general.energies`; the power is that of the torque and of all that swings."""
    kinetic, potential, power = _energies(y, spin, spins, coef, lane, width)
    e_x, e_y, n, _, f11, f12, f22, _, _, w1, w2, p = _body(y, coef, lane, width)
    w3 = spin / coef[at.KAPPA * width + lane]
    force, turned_force, torque, turned_torque = _swinging(y, coef, lane, width)
    k1, k2, k3 = _in_frame(force[0], force[1], force[2], e_x, e_y, n, f11, f12, f22)
    t1, t2, t3 = _in_frame(torque[0], torque[1], torque[2], e_x, e_y, n, f11, f12, f22)
    k1, k2, k3 = k1 + turned_force[0], k2 + turned_force[1], k3 + turned_force[2]
    m1, m2, m3 = _cross(p[0], p[1], p[2], k1, k2, k3)
    m1, m2, m3 = m1 + t1 + turned_torque[0], m2 + t2 + turned_torque[1], m3 + t3 + turned_torque[2]
    fx, fy = f11 * k1 + f12 * k2 + e_x * k3, f12 * k1 + f22 * k2 + e_y * k3
    power += fx * y[at.OV_X * width + lane] + fy * y[at.OV_Y * width + lane]
    return kinetic, potential, power + w1 * m1 + w2 * m2 + w3 * m3


@device
def turn(y, spin, h, k, first, coef, lane, width):
    """h times the rates of the turn about the axis and of all phases."""
    _turn(y, spin, h, k, first, coef, lane, width)
    for term in range(4):
        frequency = coef[(_TERMS + term * _ROWS) * width + lane]
        oscillators.turn(y, _PHASES + 2 * term, frequency, h, k, first, lane, width)
    frequency = coef[(_DRIVE + oscillators.FREQUENCY) * width + lane]
    oscillators.turn(y, _DRIVE_PHASE, frequency, h, k, first, lane, width)


@device
def normalise(y, coef, lane, width):
    """Turn and phases back to unit pairs, and Omega to what a drive's phase says."""
    _normalise(y, coef, lane, width)
    for oscillator in range(5):
        oscillators.normalise(y, _PHASES + 2 * oscillator, lane, width)
    oscillators.set_spin(y, _DRIVE_PHASE, coef, _DRIVE, lane, width)
