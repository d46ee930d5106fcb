"""Flights and impacts of a symmetric body by SciPy: adaptive steps, terminal events, a right-hand side compiled by Numba.

How one would write it by hand for one motion: DOP853 to the first event, the impact law, and on from there. Slope coordinates
as in README, "Model", written for this comparison; the journal flies all the time, and its impacts are of one end alone.
"""

from __future__ import annotations

import math

import numba as nb
import numpy as np
from scipy.integrate import solve_ivp

from tolmc.mechanism.scene import Scene


@nb.njit(cache=True)
def solved(w, f_o, f_w, mass, length, z, a):
    """M^-1 (f_o, f_w) by elimination of the 4 x 4 matrix in closed form."""
    ell2 = length * length + w[0] * w[0] + w[1] * w[1]
    ell = math.sqrt(ell2)
    e_x, e_y, e_z2 = w[0] / ell, w[1] / ell, length * length / ell2
    k1, k2 = mass * z / ell, a / ell2
    c = k1 * k1 / mass
    s_x, s_y = f_w[0] - k1 / mass * f_o[0], f_w[1] - k1 / mass * f_o[1]
    along = (f_w[0] * e_x + f_w[1] * e_y) / e_z2
    s_x, s_y = s_x + e_x * along, s_y + e_y * along
    along = c * (e_x * s_x + e_y * s_y) / (k2 - c * e_z2)
    b_x, b_y = (s_x - e_x * along) / (k2 - c), (s_y - e_y * along) / (k2 - c)
    along = e_x * b_x + e_y * b_y
    return (f_o[0] - k1 * (b_x - e_x * along)) / mass, (f_o[1] - k1 * (b_y - e_y * along)) / mass, b_x, b_y


@nb.njit(cache=True)
def flight(_, y, mass, length, z, a, gyro, gravity):
    """Rates of (X0, Y0, u, v) and their speeds in flight."""
    w_x, w_y, v_x, v_y = y[2], y[3], y[6], y[7]
    ell2 = length * length + w_x * w_x + w_y * w_y
    ell = math.sqrt(ell2)
    e = (w_x / ell, w_y / ell, length / ell)
    rho = (w_x * v_x + w_y * v_y) / ell2
    d_x, d_y, d_z = v_x / ell - rho * e[0], v_y / ell - rho * e[1], -rho * e[2]
    turning = d_x * d_x + d_y * d_y + d_z * d_z
    f_x = mass * z * (2.0 * rho * d_x + e[0] * turning)
    f_y = mass * (gravity + z * (2.0 * rho * d_y + e[1] * turning))
    load = mass * gravity
    g_x = (-z * e[0] * load * e[1] + 2.0 * a * rho * d_x - gyro * (d_y * e[2] - d_z * e[1])) / ell
    g_y = (z * load * (1.0 - e[1] * e[1]) + 2.0 * a * rho * d_y - gyro * (d_z * e[0] - d_x * e[2])) / ell
    a_x, a_y, b_x, b_y = solved((w_x, w_y), (f_x, f_y), (g_x, g_y), mass, length, z, a)
    return np.array((y[4], y[5], y[6], y[7], a_x, a_y, b_x, b_y))


@nb.njit(cache=True)
def gap_d(_, y, radius):
    """r - |D|."""
    return radius - math.hypot(y[0] + y[2], y[1] + y[3])


@nb.njit(cache=True)
def gap_e(_, y, radius):
    """r - |E|."""
    return radius - math.hypot(y[0] - y[2], y[1] - y[3])


@nb.njit(cache=True)
def rebounded(y, sign, restitution, body):
    """The state after an impact at D (sign 1) or E (-1) alone."""
    x, y_ = y[0] + sign * y[2], y[1] + sign * y[3]
    distance = math.hypot(x, y_)
    row = (-x / distance, -y_ / distance, -sign * x / distance, -sign * y_ / distance)
    given = solved((y[2], y[3]), row[:2], row[2:], *body)
    approach, yielding = 0.0, 0.0
    for i in range(4):
        approach += row[i] * y[4 + i]
        yielding += row[i] * given[i]
    impulse = -(1.0 + restitution) * approach / yielding
    after = y.copy()
    for i in range(4):
        after[4 + i] += impulse * given[i]
    return after


def scipy_pose(scene: Scene, radius: float, tolerance: float) -> np.ndarray:
    """(X0, Y0, u, v) over the radius at the end of a motion whose impacts are each of one end alone."""
    length, motion = scene.joint.half_length, scene.motion
    body = (scene.body.mass, length, scene.body.center_of_mass[2], scene.body.inertia[0, 0])
    constants = (*body, scene.body.inertia[2, 2] * motion.spin_rate, scene.loads.gravity[1])
    slopes, rates = length * np.array(motion.slope), length * np.array(motion.slope_rate)
    y = np.concatenate((motion.origin, slopes, motion.origin_rate, rates))
    events = [lambda t, y, *_: gap_d(t, y, radius), lambda t, y, *_: gap_e(t, y, radius)]
    for event in events:
        event.terminal, event.direction = True, -1
    t, options = 0.0, {"rtol": tolerance, "atol": 1e-3 * tolerance, "events": events, "args": constants}
    while True:
        found = solve_ivp(flight, (t, scene.duration), y, "DOP853", **options)
        t, y = found.t[-1], found.y[:, -1]
        if found.status == 0:
            return y[:4] / radius
        sign = 1.0 if len(found.t_events[0]) else -1.0
        y = rebounded(y, sign, scene.joint.restitution, body)
