"""What acts on the body: gravity, a force, a torque, what of them swings, and the drive that turns the body."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from tolmc.mechanism.checks import finite_number, finite_vector, set_frozen
from tolmc.quantities import LOAD_TERMS

DRIVES = ("free", "constant speed")
AXES = ("fixed", "body")

#: What may be given as a vector (x, y, z).
Vector = Sequence[float] | np.ndarray


@dataclass(frozen=True)
class Oscillation:
    """A drive that swings the body about its axis, as an arm swings its pin.

    The body's turn is that of the motion's spin_rate and ``amplitude`` sin(2 pi ``frequency`` t + ``phase``):
    Omega = spin_rate + 2 pi frequency amplitude cos(2 pi frequency t + phase).

    Parameters
    ----------
    amplitude : float, rad
        Half of the whole swing.
    frequency : float, Hz
        >= 0.
    phase : float, rad
    """

    amplitude: float
    frequency: float
    phase: float = 0.0

    def __post_init__(self) -> None:
        for name in ("amplitude", "frequency", "phase"):
            set_frozen(self, **{name: finite_number("Oscillation", name, getattr(self, name))})
        _check_frequency("Oscillation", self.frequency)


@dataclass(frozen=True)
class Harmonic:
    """A part of a force or torque that swings: ``amplitude`` sin(2 pi ``frequency`` t + ``phase``).

    Parameters
    ----------
    amplitude : 3 floats, N or N m
    frequency : float, Hz
        >= 0; 0 with a phase of pi/2 is a constant part.
    phase : float, rad
    axes : {"fixed", "body"}
        Whether the amplitude's axes are those of the bearing, or turn with the body.
    """

    amplitude: tuple[float, float, float]
    frequency: float
    phase: float = 0.0
    axes: Literal["fixed", "body"] = "fixed"

    if TYPE_CHECKING:

        def __init__(
            self, amplitude: Vector, frequency: float, phase: float = 0.0, axes: Literal["fixed", "body"] = "fixed"
        ) -> None: ...

    def __post_init__(self) -> None:
        set_frozen(self, amplitude=finite_vector("Harmonic", "amplitude", self.amplitude))
        for name in ("frequency", "phase"):
            set_frozen(self, **{name: finite_number("Harmonic", name, getattr(self, name))})
        _check_frequency("Harmonic", self.frequency)
        if self.axes not in AXES:
            raise ValueError(f"Harmonic: axes = {self.axes!r} is unknown; allowed: {', '.join(AXES)}.")


def _check_frequency(owner: str, frequency: float) -> None:
    if frequency < 0.0:
        raise ValueError(f"{owner}: frequency = {frequency!r} Hz is out of range; allowed: >= 0.")


@dataclass(frozen=True)
class Loads:
    """Loads on the body; what is absent costs nothing.

    Parameters
    ----------
    gravity : 3 floats, m/s^2
        Uniform field in fixed axes.
    force : 3 floats or None, N
        Constant force of fixed direction (fixed axes), acting at the body point ``force_point`` (m, body axes; O
        when None).
    torque : 3 floats or None, N m
        Constant torque in fixed axes.
    drive : {"free", "constant speed"} or Oscillation
        Whether the body turns about its axis as it will, or a drive holds Omega at the motion's spin_rate, or swings the body,
        by a torque along the axis, which is an output.
    force_terms, torque_terms : Harmonics, at most two of each
        What swings of the force, at ``force_point``, and of the torque.
    """

    gravity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    force: tuple[float, float, float] | None = None
    force_point: tuple[float, float, float] | None = None
    torque: tuple[float, float, float] | None = None
    drive: str | Oscillation = "free"
    force_terms: tuple[Harmonic, ...] = ()
    torque_terms: tuple[Harmonic, ...] = ()

    if TYPE_CHECKING:

        def __init__(
            self,
            gravity: Vector = (0.0, 0.0, 0.0),
            force: Vector | None = None,
            force_point: Vector | None = None,
            torque: Vector | None = None,
            drive: str | Oscillation = "free",
            force_terms: Iterable[Harmonic] = (),
            torque_terms: Iterable[Harmonic] = (),
        ) -> None: ...

    def __post_init__(self) -> None:
        set_frozen(self, gravity=finite_vector("Loads", "gravity", self.gravity))
        for name in ("force", "force_point", "torque"):
            if getattr(self, name) is not None:
                set_frozen(self, **{name: finite_vector("Loads", name, getattr(self, name))})
        self._check_terms()
        if self.force_point is not None and self.force is None and not self.force_terms:
            raise ValueError("Loads: force_point is given without force; give the force (N) that acts there.")
        if not isinstance(self.drive, Oscillation) and self.drive not in DRIVES:
            raise ValueError(
                f"Loads: drive = {self.drive!r} is unknown; allowed: {', '.join(DRIVES)}, or an Oscillation."
            )

    def _check_terms(self) -> None:
        most = LOAD_TERMS // 2
        for name in ("force_terms", "torque_terms"):
            terms = getattr(self, name)
            terms = (terms,) if isinstance(terms, Harmonic) else tuple(terms)
            if not all(isinstance(term, Harmonic) for term in terms):
                raise TypeError(f"Loads: {name} = {terms!r} must be tolmc.Harmonic, one or several.")
            if len(terms) > most:
                raise ValueError(f"Loads: {name} has {len(terms)} terms; allowed: at most {most}.")
            set_frozen(self, **{name: terms})

    @property
    def is_driven(self) -> bool:
        """Whether a drive says how the body turns about its axis."""
        return self.drive != "free"

    @property
    def terms(self) -> dict[str, Harmonic]:
        """The parts that swing, by the name that their scalars begin with."""
        kinds = {"force_term": self.force_terms, "torque_term": self.torque_terms}
        return {f"{name}_{place}": term for name, terms in kinds.items() for place, term in enumerate(terms, 1)}

    @property
    def turning(self) -> tuple[bool, ...]:
        """Of each place for a term, whether the axes of what stands there turn with the body; () without terms."""
        if not self.terms:
            return ()
        places = [(*terms, *[None] * (LOAD_TERMS // 2 - len(terms))) for terms in (self.force_terms, self.torque_terms)]
        return tuple(term is not None and term.axes == "body" for terms in places for term in terms)

    @property
    def scalars(self) -> dict[str, float]:
        """The numbers of the drive and of what swings, by name; those that are absent left out."""
        found = {}
        if isinstance(self.drive, Oscillation):
            found = {f"drive_{name}": getattr(self.drive, name) for name in ("amplitude", "frequency", "phase")}
        for name, term in self.terms.items():
            found |= {f"{name}_{axis}": value for axis, value in zip("xyz", term.amplitude, strict=True)}
            found |= {f"{name}_frequency": term.frequency, f"{name}_phase": term.phase}
        return found

    def swinging(
        self, scalars: Mapping[str, float]
    ) -> tuple[str | Oscillation, tuple[Harmonic, ...], tuple[Harmonic, ...]]:
        """Drive and terms with other numbers, by the names of :attr:`scalars`."""
        drive = self.drive
        if isinstance(drive, Oscillation):
            drive = Oscillation(*(scalars[f"drive_{name}"] for name in ("amplitude", "frequency", "phase")))
        changed = {
            name: Harmonic(
                tuple(scalars[f"{name}_{axis}"] for axis in "xyz"), scalars[f"{name}_frequency"], scalars[f"{name}_phase"],
                term.axes,
            )
            for name, term in self.terms.items()
        }  # fmt: skip
        force, torque = (
            tuple(term for name, term in changed.items() if name.startswith(kind))
            for kind in ("force_term", "torque_term")
        )
        return drive, force, torque
