"""Newton's and Euler's equations of a body that slides on two circles, by SciPy: none of the package's coordinates.

Unknown at every instant: the accelerations of O, the angular acceleration, both normal forces and the force that keeps O in the
middle plane. The state is O, its velocity, the matrix of rotation, the angular velocity, and what friction has done.
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp
from twins.vectors import cross, cross_matrix

SIDES = (1.0, -1.0)


class SlidingBody:
    """The motion of a scene on the circle, both contacts closed, its Omega free or held by a drive."""

    def __init__(self, scene):
        self.scene = scene
        self.held = scene.loads.is_driven
        joint, body = scene.joint, scene.body
        self.radius, self.length = joint.effective_radius, joint.half_length
        self.mass, self.center, self.inertia = body.mass, np.array(body.center_of_mass), np.array(body.inertia)

    def start(self):
        """The state at t = 0 from polar angles, rates, turn and spin rate."""
        motion, r, length = self.scene.motion, self.radius, self.length
        d, e = (r * np.array([np.cos(a), np.sin(a)]) for a in (motion.alpha, motion.beta))
        turned = np.array([[0.0, -1.0], [1.0, 0.0]])
        d_rate, e_rate = motion.alpha_rate * turned @ d, motion.beta_rate * turned @ e
        origin, slope, velocity, slope_rate = (d + e) / 2, (d - e) / 2, (d_rate + e_rate) / 2, (d_rate - e_rate) / 2
        long = np.sqrt(slope @ slope + length**2)
        axis = np.array([*slope, length]) / long
        axis_rate = np.array([*slope_rate, 0.0]) / long - axis * (slope @ slope_rate) / long**2
        # The smallest rotation from Z to the axis, then the turn about the axis.
        about = cross(np.array([0, 0, 1.0]), axis)
        smallest = np.eye(3) + cross_matrix(about) + cross_matrix(about) @ cross_matrix(about) / (1 + axis[2])
        c, s = np.cos(motion.spin), np.sin(motion.spin)
        rotation = smallest @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        omega = cross(axis, axis_rate) + motion.spin_rate * axis
        return np.concatenate([origin, velocity, rotation.ravel(), omega, np.zeros(5)])

    def loads(self, time, rotation):
        """Force at its point and torque, N and N m, fixed axes."""
        loads = self.scene.loads
        found = []
        for constant, terms in ((loads.force, loads.force_terms), (loads.torque, loads.torque_terms)):
            total = np.array(constant or (0.0, 0.0, 0.0))
            for term in terms:
                part = np.array(term.amplitude) * np.sin(2 * np.pi * term.frequency * time + term.phase)
                total = total + (rotation @ part if term.axes == "body" else part)
            found.append(total)
        return found

    def rates(self, time, y):
        """Rates of the state; the last five are those of N_D, N_E, slip work at D and E, and friction's work."""
        origin, velocity, rotation, omega = y[:2], y[2:4], y[4:13].reshape(3, 3), y[13:16]
        scene, axis = self.scene, rotation[:, 2]
        joint, mass, length = scene.joint, self.mass, self.length
        center, inertia = rotation @ self.center, rotation @ self.inertia @ rotation.T
        axis_rate = cross(omega, axis)
        force, torque = self.loads(time, rotation)
        point = rotation @ np.array(scene.loads.force_point or (0.0, 0.0, 0.0))
        weight = mass * np.array(scene.loads.gravity)
        # Columns: a_x, a_y, omega' (3), N_D, N_E, axial force, drive's torque.
        matrix, right = np.zeros((9, 9)), np.zeros(9)
        matrix[:3, :2] = mass * np.eye(3)[:, :2]
        matrix[:3, 2:5] = -mass * cross_matrix(center)
        matrix[:3, 7] = [0, 0, -1]
        right[:3] = weight + force - mass * cross(omega, cross(omega, center))
        matrix[3:6, :2] = mass * cross_matrix(center)[:, :2]
        matrix[3:6, 2:5] = inertia
        matrix[3:6, 8] = -axis
        right[3:6] = cross(center, weight) + cross(point, force) + torque
        right[3:6] -= cross(omega, inertia @ omega)
        slips, directions = [], []
        for side, sign in enumerate(SIDES):
            at = sign * length * axis[:2] / axis[2]
            rim = origin + at
            outward = np.array([*rim, -(rim @ axis[:2]) / axis[2]])
            outward /= np.linalg.norm(outward)
            contact = sign * axis * length / axis[2] + joint.journal_radius * outward
            slip = np.array([*velocity, 0.0]) + cross(omega, contact)
            slip -= outward * (slip @ outward)
            slips.append(np.linalg.norm(slip))
            direction = -outward - joint.friction * slip / np.hypot(np.linalg.norm(slip), joint.slip_speed)
            directions.append(direction)
            matrix[:3, 5 + side] = -direction
            matrix[3:6, 5 + side] = -cross(contact, direction)
            # d^2/dt^2 of |rim|^2/2, with w = +-L e_h/e_z and e'' = omega' x e + omega x (omega x e).
            slope = np.zeros((2, 3))
            slope[:, :2] = np.eye(2) / axis[2]
            slope[:, 2] = -axis[:2] / axis[2] ** 2
            slope *= sign * length
            at_rate = slope @ axis_rate
            curved = sign * length * (
                -2 * axis_rate[:2] * axis_rate[2] / axis[2] ** 2 + 2 * axis[:2] * axis_rate[2] ** 2 / axis[2] ** 3
            )  # fmt: skip
            matrix[6 + side, :2] = rim
            matrix[6 + side, 2:5] = -rim @ slope @ cross_matrix(axis)
            rim_rate = velocity + at_rate
            right[6 + side] = -(rim_rate @ rim_rate) - rim @ (slope @ cross(omega, axis_rate) + curved)
        if self.held:  # Omega' = omega'.e + omega.(omega x e), the second part being zero
            matrix[8, 2:5] = axis
        else:
            matrix[8, 8] = 1.0
        found = np.linalg.solve(matrix, right)
        normal = found[5:7]
        share = [slip / np.hypot(slip, joint.slip_speed) for slip in slips]
        heat = sum(joint.friction * n * s * slip for n, s, slip in zip(normal, share, slips, strict=True))
        work = [n * slip for n, slip in zip(normal, slips, strict=True)]
        turned = (cross_matrix(omega) @ rotation).ravel()
        return np.concatenate([velocity, found[:2], turned, found[2:5], normal, work, [heat]])

    def end(self):
        """What the motion has come to: pose, spin rate, mean forces, slip work, friction's work."""
        scene = self.scene
        y = solve_ivp(self.rates, (0, scene.duration), self.start(), "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
        rotation = y[4:13].reshape(3, 3)
        return {
            "origin_x_end": y[0], "origin_y_end": y[1],
            **{f"axis_{name}_end": value for name, value in zip("xyz", rotation[:, 2], strict=True)},
            "spin_end": y[13:16] @ rotation[:, 2],
            "contact_force_D_mean": y[16] / scene.duration, "contact_force_E_mean": y[17] / scene.duration,
            "slip_work_D": y[18], "slip_work_E": y[19], "friction_work": y[20],
        }  # fmt: skip
