"""Flights and impacts of a symmetric body by heyoka: Taylor series, terminal events at both rims, scalar or in batches.

The integrator is compiled once; each motion, or batch of them, starts from its own state and radius. The impact law,
compiled by Numba, is the event's callback. Equations as in :mod:`impact_peer`.
"""

from __future__ import annotations

from collections.abc import Callable

import heyoka
import numba as nb
import numpy as np
from impact_peer import rebounded

from tolmc.mechanism.scene import Scene


def _start(scene: Scene) -> np.ndarray:
    length, motion = scene.joint.half_length, scene.motion
    slopes = length * np.array((*motion.slope, *motion.slope_rate))
    return np.array((*motion.origin, *slopes[:2], *motion.origin_rate, *slopes[2:]))


def _flight(scene: Scene) -> tuple[list, list]:
    """The system of equations, and r^2 - |D|^2 and r^2 - |E|^2."""
    x, y, u, v, x_rate, y_rate, u_rate, v_rate = heyoka.make_vars("x", "y", "u", "v", "x'", "y'", "u'", "v'")
    mass, length, z = scene.body.mass, scene.joint.half_length, scene.body.center_of_mass[2]
    a, gyro = scene.body.inertia[0, 0], scene.body.inertia[2, 2] * scene.motion.spin_rate
    load = mass * scene.loads.gravity[1]
    ell2 = length * length + u * u + v * v
    per_ell = 1.0 / heyoka.sqrt(ell2)
    e_x, e_y, e_z = u * per_ell, v * per_ell, length * per_ell
    rho = (u * u_rate + v * v_rate) / ell2
    d_x, d_y, d_z = u_rate * per_ell - rho * e_x, v_rate * per_ell - rho * e_y, -rho * e_z
    turning = d_x * d_x + d_y * d_y + d_z * d_z
    f_x = mass * z * (2.0 * rho * d_x + e_x * turning)
    f_y = mass * z * (2.0 * rho * d_y + e_y * turning) + load
    g_x = (-z * e_x * e_y * load + 2.0 * a * rho * d_x - gyro * (d_y * e_z - d_z * e_y)) * per_ell
    g_y = (z * load * (1.0 - e_y * e_y) + 2.0 * a * rho * d_y - gyro * (d_z * e_x - d_x * e_z)) * per_ell
    k1, k2, e_z2 = mass * z * per_ell, a / ell2, e_z * e_z
    c = k1 * k1 / mass
    along = (g_x * e_x + g_y * e_y) / e_z2
    s_x, s_y = g_x - k1 / mass * f_x + e_x * along, g_y - k1 / mass * f_y + e_y * along
    along = c * (e_x * s_x + e_y * s_y) / (k2 - c * e_z2)
    b_x, b_y = (s_x - e_x * along) / (k2 - c), (s_y - e_y * along) / (k2 - c)
    along = e_x * b_x + e_y * b_y
    o_x, o_y = (f_x - k1 * (b_x - e_x * along)) / mass, (f_y - k1 * (b_y - e_y * along)) / mass
    rates = [x_rate, y_rate, u_rate, v_rate, o_x, o_y, b_x, b_y]
    r = heyoka.par[0]
    gaps = [r * r - (x + s * u) ** 2 - (y + s * v) ** 2 for s in (1.0, -1.0)]
    return list(zip((x, y, u, v, x_rate, y_rate, u_rate, v_rate), rates, strict=True)), gaps


@nb.njit(cache=True)
def _strike(states, lane, sign, law):
    """The impact law on one column of the states."""
    states[:, lane] = rebounded(states[:, lane], sign, law[0], (law[1], law[2], law[3], law[4]))


def prepare(scene: Scene, tolerance: float, batch: bool) -> Callable[[np.ndarray], np.ndarray]:
    """A function of the radii (n,) that gives (X0, Y0, u, v) over the radius at the end, (n, 4); n a multiple of the batch."""
    system, gaps = _flight(scene)
    start = _start(scene)
    body = (scene.body.mass, scene.joint.half_length, scene.body.center_of_mass[2], scene.body.inertia[0, 0])
    law = np.array((scene.joint.restitution, *body))
    event = heyoka.t_event_batch if batch else heyoka.t_event

    states = None

    def strike(sign):
        def struck(_, *found):
            _strike(states, found[-1] if batch else 0, sign, law)
            return True

        return struck

    falling = heyoka.event_direction.negative
    events = [event(gap, callback=strike(sign), direction=falling) for gap, sign in zip(gaps, (1.0, -1.0), strict=True)]
    width = heyoka.recommended_simd_size() if batch else 1
    kind = heyoka.taylor_adaptive_batch if batch else heyoka.taylor_adaptive
    begun = np.repeat(start[:, None], width, axis=1) if batch else start
    pars = np.full((1, width), 1.0) if batch else [1.0]
    integrator = kind(system, begun, tol=tolerance, t_events=events, pars=pars)
    states = integrator.state.reshape(8, width)  # the integrator's own memory

    def poses(radii: np.ndarray) -> np.ndarray:
        found = np.empty((len(radii), 4))
        for first in range(0, len(radii) // width * width, width):
            chosen = radii[first : first + width]
            if batch:
                integrator.set_time(0.0)
                integrator.pars[0, :] = chosen
            else:
                integrator.time, integrator.pars[0] = 0.0, chosen[0]
            integrator.state[:] = begun
            integrator.reset_cooldowns()
            integrator.propagate_until(np.full(width, scene.duration) if batch else scene.duration)
            found[first : first + width] = (integrator.state[:4].reshape(4, width) / chosen).T
        return found

    return poses
