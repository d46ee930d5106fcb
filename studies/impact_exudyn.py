"""Flights and impacts of a symmetric body by Exudyn: its explicit DOPRI5 with adaptive steps, and two ways to meet the wall.

Exudyn has no impact law between bodies and finds no events: its contacts are springs.

- ``events``: a user function after every step stops the integration where a rim lies beyond the wall; a cubic and Newton's
  method, with a short integration each, find the time of the impact, and the impact law changes the speeds. The motion is
  that of the other methods.
- ``spring``: Hertz's spring with a dashpot, F = K d^(3/2) + a sqrt(m K) d^(1/4) d', a = -sqrt(5) ln e / sqrt(ln^2 e + pi^2),
  whose restitution is e at any speed (Antypov and Elliott, EPL 94, 2011); m is what one rim carries. An impact lasts, and
  its rim goes beyond the wall: the error falls with K^(-2/5) and no tolerance takes it away.

The motion is a first-order object (``ObjectGenericODE1``), its rates compiled by Numba, as in :mod:`impact_peer`. Exudyn's own
contacts are between points of bodies, and the rims' points slide along the axis; its symbolic user functions evaluate repeated
parts of an expression anew each time, and these rates repeat theirs thousands of times.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import exudyn
import numba as nb
import numpy as np
from exudyn.itemInterface import NodeGenericODE1, ObjectGenericODE1
from impact_peer import flight, rebounded, solved

from tolmc.mechanism.scene import Scene

#: Share of the duration below which the rest of the way to the wall is a straight line.
_SHORTEST = 1e-9
#: Steps at least with springs: a longer one goes so far beyond the wall that its stages overflow.
_SPRING_STEPS = 100


class _System(NamedTuple):
    """A system whose ninth coordinate is the radius; the container owns it and must stay referenced."""

    container: object
    system: object
    settings: object


@nb.njit(cache=True, error_model="numpy")
def _pressed(y, spring, body):
    """Rates of the speeds by springs that push both rims back."""
    stiffness, damping = spring
    o_x = o_y = w_x = w_y = 0.0
    for sign in (1.0, -1.0):
        x, y_, x_rate, y_rate = y[0] + sign * y[2], y[1] + sign * y[3], y[4] + sign * y[6], y[5] + sign * y[7]
        distance = math.hypot(x, y_)
        depth = distance - y[8]
        if depth > 0.0:
            n_x, n_y = x / distance, y_ / distance
            given = solved((y[2], y[3]), (n_x, n_y), (sign * n_x, sign * n_y), *body)
            carried = 1.0 / (n_x * given[0] + n_y * given[1] + sign * (n_x * given[2] + n_y * given[3]))
            force = stiffness * depth**1.5
            force += damping * math.sqrt(carried * stiffness) * depth**0.25 * (n_x * x_rate + n_y * y_rate)
            o_x, o_y = o_x - force * n_x, o_y - force * n_y
            w_x, w_y = w_x - sign * force * n_x, w_y - sign * force * n_y
    return solved((y[2], y[3]), (o_x, o_y), (w_x, w_y), *body)


@nb.njit(cache=True, error_model="numpy")
def _rates(y, constants, spring):
    """Rates of (X0, Y0, u, v), their speeds and the radius; no springs where their stiffness is 0."""
    rates = np.zeros(9)
    rates[:8] = flight(0.0, y, *constants)
    if spring[0] > 0.0:
        pushed = _pressed(y, spring, constants[:4])
        for i in range(4):
            rates[4 + i] += pushed[i]
    return rates


def _constants(scene: Scene) -> tuple[float, ...]:
    body = scene.body
    return (
        body.mass, scene.joint.half_length, body.center_of_mass[2], body.inertia[0, 0],
        body.inertia[2, 2] * scene.motion.spin_rate, scene.loads.gravity[1],
    )  # fmt: skip


def _built(scene: Scene, tolerance: float, spring: tuple[float, float], least_steps: int = 1) -> _System:
    constants = _constants(scene)
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    node = system.AddNode(
        NodeGenericODE1(referenceCoordinates=[0.0] * 9, initialCoordinates=[0.0] * 9, numberOfODE1Coordinates=9)
    )
    system.AddObject(
        ObjectGenericODE1(
            nodeNumbers=[node], rhsUserFunction=lambda _s, _t, _i, y: _rates(np.array(y), constants, spring)
        )
    )
    system.Assemble()
    settings = exudyn.SimulationSettings()
    settings.solution.file.write = False
    given = settings.timeIntegration
    given.numberOfSteps = least_steps
    given.relativeTolerance, given.absoluteTolerance = tolerance, 1e-3 * tolerance
    given.minimumStepSize = 1e-14
    given.explicit.computeEndOfStepAccelerations = False
    return _System(container, system, settings)


def _advance(made: _System, y: np.ndarray, begin: float, end: float, first: float) -> tuple[float, np.ndarray]:
    """Time and state at the end, or after the step that a user function has stopped at; ``first``: its first step."""
    made.system.systemData.SetODE1Coordinates(y, exudyn.ConfigurationType.Initial)
    given = made.settings.timeIntegration
    given.startTime, given.endTime, given.initialStepSize = begin, end, min(first, end - begin)
    made.system.SolveDynamic(made.settings, solverType=exudyn.DynamicSolverType.DOPRI5)
    return made.system.systemData.GetTime(), made.system.systemData.GetODE1Coordinates()


def _gap(y: np.ndarray, sign: float) -> tuple[float, float]:
    """r - |D| or r - |E|, and its rate."""
    x, y_ = y[0] + sign * y[2], y[1] + sign * y[3]
    distance = math.hypot(x, y_)
    return y[8] - distance, -(x * (y[4] + sign * y[6]) + y_ * (y[5] + sign * y[7])) / distance


def _beyond(y: np.ndarray, sign: float) -> bool:
    gap, rate = _gap(y, sign)
    return gap < 0.0 and rate < 0.0


def _first_root(before: tuple[float, float], after: tuple[float, float], h: float) -> float:
    """Share of a step at which the cubic through both ends' gaps and rates falls to 0."""
    (g0, r0), (g1, r1) = before, after
    r0, r1 = h * r0, h * r1
    roots = np.roots((2 * (g0 - g1) + r0 + r1, 3 * (g1 - g0) - 2 * r0 - r1, r0, g0))
    real = roots.real[np.abs(roots.imag) < 1e-12]
    return float(min(real[(real > 1e-9) & (real <= 1.0)], default=1.0))


def events(scene: Scene, tolerance: float) -> Callable[[np.ndarray], np.ndarray]:
    """A function of the radii (n,) that gives (X0, Y0, u, v) over the radius at the end, (n, 4); Newton's impact law."""
    made, constants = _built(scene, tolerance, (0.0, 0.0)), _constants(scene)
    seen: list[tuple[float, np.ndarray]] = []

    def watch(system, t):
        y = system.systemData.GetODE1Coordinates()
        seen.append((t, y))
        return not (_beyond(y, 1.0) or _beyond(y, -1.0))

    def struck(t: float, y: np.ndarray, end: float, beyond: np.ndarray) -> tuple[float, np.ndarray]:
        """The state after the impact within a step."""
        shares = [_first_root(_gap(y, s), _gap(beyond, s), end - t) if _beyond(beyond, s) else 2.0 for s in (1.0, -1.0)]
        sign = 1.0 if shares[0] < shares[1] else -1.0
        rest, shortest = min(shares) * (end - t), _SHORTEST * scene.duration
        gap, rate = math.inf, 1.0
        while abs(gap) > shortest * abs(rate):
            at, there = _advance(made, y, t, t + rest, rest)
            gap, rate = _gap(there, sign)
            rest = max(rest - gap / rate, shortest)
        there = there - gap / rate * _rates(there, constants, (0.0, 0.0))
        t, y = at - gap / rate, there
        return t, np.append(rebounded(y[:8], sign, scene.joint.restitution, constants[:4]), y[8])

    def pose(radius: float) -> np.ndarray:
        t, y, step = 0.0, _start(scene, radius), 1e-2 * scene.duration
        while t < scene.duration:
            seen[:] = [(t, y)]
            made.system.SetPostStepUserFunction(watch)
            end, beyond = _advance(made, y, t, scene.duration, step)
            made.system.SetPostStepUserFunction(0)
            if not (_beyond(beyond, 1.0) or _beyond(beyond, -1.0)):
                return beyond[:4] / radius
            t, y = seen[-2]
            step = end - t
            t, y = struck(t, y, end, beyond)
        return y[:4] / radius

    return lambda radii: np.array([pose(radius) for radius in radii])


def spring(scene: Scene, tolerance: float, stiffness: float) -> Callable[[np.ndarray], np.ndarray]:
    """The same by springs of a stiffness in N/m^1.5."""
    log = math.log(scene.joint.restitution)
    made = _built(scene, tolerance, (stiffness, -math.sqrt(5.0) * log / math.hypot(log, math.pi)), _SPRING_STEPS)
    made.settings.timeIntegration.absoluteTolerance = 1e-2 * tolerance

    def pose(radius: float) -> np.ndarray:
        return _advance(made, _start(scene, radius), 0.0, scene.duration, 1e-2 * scene.duration)[1][:4] / radius

    return lambda radii: np.array([pose(radius) for radius in radii])


def _start(scene: Scene, radius: float) -> np.ndarray:
    length, motion = scene.joint.half_length, scene.motion
    slopes = length * np.array((*motion.slope, *motion.slope_rate))
    return np.array((*motion.origin, *slopes[:2], *motion.origin_rate, *slopes[2:], radius))
