"""The [loads] table of a study file, field by field: what is constant, what swings, and the drive."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import BeforeValidator, Field

from tolmc.mechanism.loads import DRIVES
from tolmc.study.fields import Section, quantity, validated, vector


class _Oscillation(Section):
    """A drive that swings the body about its axis, as an arm swings its pin; scalars drive_amplitude, drive_frequency and
    drive_phase in [dimensions]."""

    amplitude: quantity("rad")
    """Half of the whole swing: the body's turn is that of the spin_rate and amplitude sin(2 π frequency t + phase)."""
    frequency: quantity("Hz", least=0.0)
    """How many swings a second."""
    phase: quantity("rad") = 0.0
    """Phase at the start."""


class _ForceTerm(Section):
    """A part of the force that swings: amplitude sin(2 π frequency t + phase); scalars force_term_1_x, _y, _z, _frequency and
    _phase in [dimensions], force_term_2_x ... of the second."""

    amplitude: vector("N")
    """Its amplitude."""
    frequency: quantity("Hz", least=0.0)
    """Its frequency."""
    phase: quantity("rad") = 0.0
    """Its phase at the start."""
    axes: Literal["fixed", "body"] = "fixed"
    """Whether the amplitude's axes are the bearing's, or turn with the body."""


class _TorqueTerm(_ForceTerm):
    """A part of the torque that swings, as of the force; scalars torque_term_1_x ... in [dimensions]."""

    amplitude: vector("N m")
    """Its amplitude."""


def _read_drive(value: object) -> object:
    if isinstance(value, Mapping):
        return validated(_Oscillation, value, "loads", "drive")
    if value not in DRIVES:
        expected = ", ".join(f'"{word}"' for word in DRIVES)
        raise ValueError(f'expected {expected} or a table such as {{ amplitude = "30 deg", frequency = "0.5 Hz" }}')
    return value


class LoadsSection(Section):
    """Loads on the body, axes fixed in the bearing: Z along the bore, Y up in a horizontal one."""

    gravity: vector("m/s^2") = (0.0, 0.0, 0.0)
    """Acceleration of gravity."""
    force: vector("N") | None = None
    """A force of fixed direction."""
    force_point: vector("m") | None = None
    """Where it acts, from O in body axes; O when not given."""
    torque: vector("N m") | None = None
    """A torque of fixed direction."""
    force_terms: list[_ForceTerm] = Field(default_factory=list)
    """What of the force swings beside the constant, at force_point: at most two parts."""
    torque_terms: list[_TorqueTerm] = Field(default_factory=list)
    """What of the torque swings: at most two parts."""
    drive: Annotated[Literal["free", "constant speed"] | _Oscillation, BeforeValidator(_read_drive)] = "free"
    """Whether the body turns about its axis as it will, or a drive holds it at the spin_rate of its start, or swings it; the
    drive's torque is an output."""
