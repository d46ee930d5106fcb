"""The mechanism: joint, body, loads, motion, and the scene that holds them.

Frozen dataclasses, validated once when they are made, so that everything downstream may trust them. SI units throughout.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike

from tolmc.mechanism import geometry
from tolmc.mechanism.checks import finite_number, finite_vector, plain_array, set_frozen
from tolmc.mechanism.loads import Loads, Vector
from tolmc.mechanism.motion import Motion
from tolmc.mechanism.operating import Operating, closing_sentence, operating_dimensions
from tolmc.quantities import CONTACT, DRIVE, FREE_START, JOINT, OPERATING, SCALARS, SPIN, START, SWINGING
from tolmc.units import read

SECTIONS = ("circle", "exact")


@dataclass(frozen=True)
class Joint:
    """A journal in a bearing, with clearance.

    Parameters
    ----------
    bearing_radius, journal_radius, half_length : float, m
        R*, r* (0 < r* < R*) and L > 0.
    section : {"circle", "exact"}
        ``"circle"``: the axis rests on circles of constant radius r, equations (1)-(3) (the paper's model).
        ``"exact"``: the bearing's rims touch the tilted cylinder (README, "Model").
    restitution : float or None
        None: the wall holds the journal, and a negative contact force says that contact is lost. A number e from 0 to 1: the
        wall only pushes; the journal leaves it, flies and hits it, and its normal speed after an impact is e times that
        before (Newton).
    contact_stiffness : float or None, N/m^1.5
        K of Hertz's law F = K delta^1.5 between journal and wall, for the peak forces of impacts; None: a rigid impact has an
        impulse and no force.
    friction : float
        Coefficient mu >= 0 of Coulomb friction between journal and wall, F = -mu N v/sqrt(|v|^2 + v_eps^2) at slip v; 0: none.
        Without restitution the motion ends where contact is lost.
    slip_speed : float, m/s, or str with a unit
        v_eps > 0, below which friction falls off with the slip: what it leaves of sticking is a creep of about this speed.
    wear_coefficient : float, m^3/(N m), or str with a unit
        k >= 0 of Archard's law: the worn volume is k times the integral of N |v| dt; 0: what wears is not asked.
    """

    bearing_radius: float
    journal_radius: float
    half_length: float
    section: str = "circle"
    restitution: float | None = None
    contact_stiffness: float | None = None
    friction: float = 0.0
    slip_speed: float = cast(float, "1 mm/s")
    wear_coefficient: float = 0.0

    if TYPE_CHECKING:  # what may be given is more than what is kept

        def __init__(
            self,
            bearing_radius: float,
            journal_radius: float,
            half_length: float,
            section: str = "circle",
            restitution: float | None = None,
            contact_stiffness: float | None = None,
            friction: float = 0.0,
            slip_speed: float | str = "1 mm/s",
            wear_coefficient: float | str = 0.0,
        ) -> None: ...

    def __post_init__(self) -> None:
        set_frozen(
            self,
            **{name: finite_number("Joint", name, getattr(self, name), positive=True) for name in JOINT},
        )
        if self.journal_radius >= self.bearing_radius:
            raise ValueError(
                f"Joint: journal_radius = {self.journal_radius!r} m must be smaller than bearing_radius = "
                f"{self.bearing_radius!r} m; without clearance there is nothing to tilt."
            )
        if self.section not in SECTIONS:
            raise ValueError(f"Joint: section = {self.section!r} is unknown; allowed: {', '.join(SECTIONS)}.")
        self._check_contact()
        self._check_friction()

    def _check_contact(self) -> None:
        if self.restitution is not None:
            set_frozen(self, restitution=finite_number("Joint", "restitution", self.restitution))
            if not 0.0 <= self.restitution <= 1.0:
                raise ValueError(
                    f"Joint: restitution = {self.restitution!r} is out of range; allowed: 0 (no rebound) to 1 (no loss). Leave "
                    "it out (None) for a wall that holds the journal."
                )
        if self.contact_stiffness is not None:
            stiffness = finite_number("Joint", "contact_stiffness", self.contact_stiffness, positive=True)
            set_frozen(self, contact_stiffness=stiffness)
            if self.restitution is None:
                raise ValueError(
                    f"Joint: contact_stiffness = {stiffness!r} N/m^1.5 is for impacts, which a joint without restitution "
                    "does not have; give restitution too."
                )

    def _check_friction(self) -> None:
        set_frozen(self, friction=finite_number("Joint", "friction", self.friction))
        if self.friction < 0.0:
            raise ValueError(
                f"Joint: friction = {self.friction!r} is out of range; allowed: 0 (none) or more. Friction opposes the slip "
                "whatever its direction: give the coefficient without a sign."
            )
        speed, wear = self._read("slip_speed", "m/s"), self._read("wear_coefficient", "m^2/N")
        set_frozen(self, slip_speed=finite_number("Joint", "slip_speed", speed, positive=True))
        set_frozen(self, wear_coefficient=finite_number("Joint", "wear_coefficient", wear))
        if self.wear_coefficient < 0.0:
            raise ValueError(
                f"Joint: wear_coefficient = {self.wear_coefficient!r} m^3/(N m) is out of range; allowed: 0 (what wears is not "
                "asked) or more."
            )

    def _read(self, name: str, unit: str) -> float:
        """A field that may be a text with a unit, as a number."""
        value = getattr(self, name)
        if not isinstance(value, str):
            return value
        try:
            return read(value, unit)
        except (ValueError, TypeError) as error:
            raise type(error)(f"Joint: {name} = {error}") from None

    @property
    def _dimensions(self) -> tuple[float, float, float]:
        return self.bearing_radius, self.journal_radius, self.half_length

    @property
    def tilt_angle(self) -> float:
        """psi of equation (2), rad."""
        return float(geometry.tilt_angle(*self._dimensions))

    @property
    def effective_radius(self) -> float:
        """r of equation (3), m."""
        return float(geometry.effective_radius(*self._dimensions))

    @property
    def approximate_radius(self) -> float:
        """R* - r*, m."""
        return float(geometry.approximate_radius(*self._dimensions))


def _inertia(value: ArrayLike) -> np.ndarray:
    inertia = plain_array("Body: inertia (3 numbers or a 3x3 matrix, kg m^2)", value).copy()
    if inertia.shape == (3,):
        inertia = np.diag(inertia)
    if inertia.shape != (3, 3):
        raise ValueError(f"Body: inertia must be 3 numbers or a 3x3 matrix, got shape {inertia.shape}.")
    if not np.all(np.isfinite(inertia)):
        raise ValueError("Body: inertia has an entry that is not finite.")
    scale = np.abs(inertia).max()
    if np.abs(inertia - inertia.T).max() > 1e-9 * scale:
        raise ValueError(f"Body: inertia must be symmetric, got {inertia.tolist()}.")
    inertia = 0.5 * (inertia + inertia.T)
    inertia.setflags(write=False)
    return inertia


@dataclass(frozen=True, eq=False)
class Body:
    """A rigid body on the journal.

    Parameters
    ----------
    mass : float, kg
    center_of_mass : 3 floats, m
        r_C in body axes, from the body point O that stays in the bearing's middle plane.
    inertia : 3 floats or 3x3, kg m^2
        Matrix of inertia **about O** in body axes: diagonal entries equal the moments of inertia, off-diagonal ones
        their products with a minus sign (J_xy = -integral of x y dm). The part about the centre of mass,
        J - m (|r_C|^2 I - r_C r_C^T), must be positive semidefinite and satisfy the triangle inequality.
    """

    mass: float
    center_of_mass: tuple[float, float, float] = (0.0, 0.0, 0.0)
    inertia: np.ndarray = field(default=cast(np.ndarray, (1.0, 1.0, 1.0)))

    if TYPE_CHECKING:  # what may be given is more than what is kept

        def __init__(
            self, mass: float, center_of_mass: Vector = (0.0, 0.0, 0.0), inertia: ArrayLike = (1.0, 1.0, 1.0)
        ) -> None: ...

    def __post_init__(self) -> None:
        set_frozen(
            self,
            mass=finite_number("Body", "mass", self.mass, positive=True),
            center_of_mass=finite_vector("Body", "center_of_mass", self.center_of_mass),
            inertia=_inertia(self.inertia),
        )
        moments = np.linalg.eigvalsh(self.centroidal_inertia)
        # Rounding in the shift from O to the centre of mass must not reject a point mass or a thin rod.
        slack = 1e-9 * np.abs(self.inertia).max()
        if moments[0] < -slack or moments[2] > moments[0] + moments[1] + slack or np.trace(self.inertia) <= 0:
            raise ValueError(
                f"Body: inertia about the centre of mass has principal moments {moments.tolist()} kg m^2; allowed: "
                "all >= 0, none larger than the sum of the other two. inertia is taken about O, the point in the "
                "bearing's middle plane: give moments about the centre of mass as such (centroidal_inertia in a study, "
                "Body.from_centroidal)."
            )

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Body)
            and (self.mass, self.center_of_mass) == (other.mass, other.center_of_mass)
            and np.array_equal(self.inertia, other.inertia)
        )

    def __hash__(self) -> int:
        return hash((self.mass, self.center_of_mass, self.inertia.tobytes()))

    @property
    def centroidal_inertia(self) -> np.ndarray:
        """Matrix of inertia about the centre of mass, body axes, kg m^2."""
        c = np.asarray(self.center_of_mass)
        return self.inertia - self.mass * (c @ c * np.eye(3) - np.outer(c, c))

    @property
    def is_symmetric(self) -> bool:
        """Whether the body is symmetric about the journal's axis: x_C = y_C = 0, J = diag(A, A, C)."""
        J = self.inertia
        return bool(
            self.center_of_mass[0] == 0
            and self.center_of_mass[1] == 0
            and J[0, 0] == J[1, 1]
            and J[0, 1] == J[0, 2] == J[1, 2] == 0
        )

    @classmethod
    def from_centroidal(cls, mass: float, center_of_mass: Vector, inertia: ArrayLike) -> Body:
        """Body from the inertia about its centre of mass (3 numbers or 3x3, kg m^2, body axes)."""
        c = np.asarray(finite_vector("Body", "center_of_mass", center_of_mass))
        m = finite_number("Body", "mass", mass, positive=True)
        with np.errstate(all="ignore"):  # an inertia that is not finite is refused below
            about_origin = _inertia(inertia) + m * (c @ c * np.eye(3) - np.outer(c, c))
        return cls(m, tuple(c), about_origin)

    @classmethod
    def solid_cylinder(
        cls, mass: float, radius: float, length: float, center_of_mass: Vector = (0.0, 0.0, 0.0)
    ) -> Body:
        """Homogeneous cylinder of the given mass (kg), radius and length (m) along the journal's axis."""
        m = finite_number("Body", "mass", mass, positive=True)
        a = finite_number("Body", "radius", radius, positive=True)
        h = finite_number("Body", "length", length, positive=True)
        transverse = m * (3 * a * a + h * h) / 12
        return cls.from_centroidal(m, center_of_mass, (transverse, transverse, 0.5 * m * a * a))


@dataclass(frozen=True)
class Scene:
    """A joint, a body on it, its loads, the start of its motion, and how long it lasts (s).

    ``operating``: temperatures and wear, which change the joint's dimensions from those drawn (:attr:`joint`) to those that
    move (:attr:`joint_in_operation`); None: as drawn.
    """

    joint: Joint
    body: Body
    loads: Loads
    motion: Motion
    duration: float
    operating: Operating | None = None

    def __post_init__(self) -> None:
        for name, kind in (("joint", Joint), ("body", Body), ("loads", Loads), ("motion", Motion)):
            if not isinstance(getattr(self, name), kind):
                raise TypeError(f"Scene: {name} must be a {kind.__name__}, got {getattr(self, name)!r}.")
        set_frozen(self, duration=finite_number("Scene", "duration", self.duration, positive=True))
        if self.operating is not None:
            if not isinstance(self.operating, Operating):
                raise TypeError(f"Scene: operating must be an Operating or None, got {self.operating!r}.")
            _ = self.joint_in_operation
        if self.motion.is_free and self.joint.restitution is None:
            raise ValueError(
                "Scene: a motion that starts within the clearance will hit the wall; give Joint(restitution=...), 0 to 1."
            )

    @property
    def rubs(self) -> bool:
        """Whether sliding at the wall counts, by friction or wear, or something drives or shakes the body."""
        sliding = self.joint.friction > 0.0 or self.joint.wear_coefficient > 0.0
        return sliding or self.loads.is_driven or bool(self.loads.terms)

    @cached_property
    def joint_in_operation(self) -> Joint:
        """The joint with the dimensions that temperature and wear make of the drawn ones.

        Raises
        ------
        ValueError
            Where they leave no clearance, or nothing of the journal; with the temperature at which the clearance closes.
        """
        if self.operating is None:
            return self.joint
        bore, journal, length = (float(value) for value in operating_dimensions(self.scalars))
        if not 0.0 < journal < bore or not length > 0.0:
            raise ValueError(f"Scene: {closing_sentence(self.scalars)}")
        return replace(self.joint, bearing_radius=bore, journal_radius=journal, half_length=length)

    @cached_property
    def scalars(self) -> Mapping[str, float]:
        """Value of every name in :data:`tolmc.quantities.SCALARS`, SI units and °C.

        Absent loads are zero, absent conditions those of the drawing.
        """
        joint, body, loads, motion = self.joint, self.body, self.loads, self.motion
        J = body.inertia
        vectors = {
            "center_of_mass": body.center_of_mass,
            "gravity": loads.gravity,
            "force": loads.force or (0.0, 0.0, 0.0),
            "force_point": loads.force_point or (0.0, 0.0, 0.0),
            "torque": loads.torque or (0.0, 0.0, 0.0),
        }
        pairs = {
            "origin": motion.origin or (0.0, 0.0), "slope": motion.slope or (0.0, 0.0),
            "origin_rate": motion.origin_rate, "slope_rate": motion.slope_rate,
        }  # fmt: skip
        values = {
            "bearing_radius": joint.bearing_radius,
            "journal_radius": joint.journal_radius,
            "half_length": joint.half_length,
            "restitution": joint.restitution or 0.0,
            "contact_stiffness": joint.contact_stiffness or 0.0,
            "friction": joint.friction, "slip_speed": joint.slip_speed, "wear_coefficient": joint.wear_coefficient,
            "mass": body.mass,
            "inertia_xx": J[0, 0], "inertia_yy": J[1, 1], "inertia_zz": J[2, 2],
            "inertia_xy": J[0, 1], "inertia_xz": J[0, 2], "inertia_yz": J[1, 2],
            **{f"{name}_{axis}": v for name, vector in vectors.items() for axis, v in zip("xyz", vector, strict=True)},
            **{f"{name}_{axis}": v for name, pair in pairs.items() for axis, v in zip("xy", pair, strict=True)},
            **{name: getattr(motion, name) for name in (*START, *SPIN)},
            **(self.operating or Operating()).scalars,
            **dict.fromkeys((*SWINGING, *DRIVE), 0.0), **loads.scalars,
        }  # fmt: skip
        return {name: float(values[name]) for name in SCALARS}

    def replaced(self, **scalars: float) -> Scene:
        """The scene with some scalars of :data:`tolmc.quantities.SCALARS` changed, validated again."""
        unknown = sorted(set(scalars) - set(SCALARS))
        if unknown:
            raise ValueError(f"Scene: unknown scalar {unknown[0]!r}; allowed: {', '.join(SCALARS)}.")
        for name in scalars:
            self.check_has(name)
        s = {**self.scalars, **scalars}

        def vector(name: str) -> tuple[float, ...]:
            return tuple(s[f"{name}_{axis}"] for axis in "xyz")

        def optional(name: str) -> tuple[float, ...] | None:
            changed = any(f"{name}_{axis}" in scalars for axis in "xyz")
            return vector(name) if changed or getattr(self.loads, name) is not None else None

        inertia = [
            [s["inertia_xx"], s["inertia_xy"], s["inertia_xz"]],
            [s["inertia_xy"], s["inertia_yy"], s["inertia_yz"]],
            [s["inertia_xz"], s["inertia_yz"], s["inertia_zz"]],
        ]
        operating = self.operating
        if any(name in scalars for name in OPERATING):
            operating = Operating(*(s[name] for name in OPERATING))
        return replace(
            self,
            joint=self._joint(s),
            body=Body(s["mass"], vector("center_of_mass"), inertia),
            loads=Loads(
                vector("gravity"),
                optional("force"),
                optional("force_point"),
                optional("torque"),
                *self.loads.swinging(s),
            ),
            motion=self._motion(s),
            operating=operating,
        )

    def _joint(self, s: Mapping[str, float]) -> Joint:
        contact: dict[str, Any] = {name: None if getattr(self.joint, name) is None else s[name] for name in CONTACT}
        return Joint(s["bearing_radius"], s["journal_radius"], s["half_length"], self.joint.section, **contact)

    def _motion(self, s: Mapping[str, float]) -> Motion:
        spin, rate = s["spin"], s["spin_rate"]
        if not self.motion.is_free:
            return Motion(s["alpha"], s["beta"], s["alpha_rate"], s["beta_rate"], spin, rate)
        origin, slope = (s["origin_x"], s["origin_y"]), (s["slope_x"], s["slope_y"])
        origin_rate, slope_rate = (s["origin_rate_x"], s["origin_rate_y"]), (s["slope_rate_x"], s["slope_rate_y"])
        return Motion.free(origin, slope, origin_rate, slope_rate, spin, rate)

    def check_has(self, name: str) -> None:
        """Raise ValueError if the scene has no such scalar: another kind of start, or no law of contact."""
        if name in CONTACT and getattr(self.joint, name) is None:
            raise ValueError(
                f"Scene: {name} varies, but the joint has none; give Joint({name}=...), in a study [contact] {name}."
            )
        if name in (*SWINGING, *DRIVE) and name not in self.loads.scalars:
            what = "drive = tolmc.Oscillation(...)" if name in DRIVE else "force_terms or torque_terms"
            raise ValueError(f"Scene: {name} varies, but the loads have none; give Loads({what}).")
        if name in START and self.motion.is_free:
            raise ValueError(f"Scene: {name} varies, but the motion starts within the clearance; vary origin or slope.")
        if name in FREE_START and not self.motion.is_free:
            raise ValueError(
                f"Scene: {name} varies, but the motion starts on the wall; vary alpha or beta, or use Motion.free."
            )
