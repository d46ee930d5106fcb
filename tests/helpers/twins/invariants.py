"""Plain NumPy twin of what stays constant, from the motion of the journal's axis alone.

Vector mechanics in fixed axes; velocities come from splines through the positions, so nothing is shared with an integrator.
Written for a body symmetric about its axis, r_C = z_C e, J about O = A (1 - e e^T) + C e e^T.
"""

import mpmath
import numpy as np
from scipy.interpolate import make_interp_spline


def angular_momentum_z(body, time, origin, axis, spin_rate):
    """Angular momentum about the fixed Z axis at ``time``, kg m^2/s: O x m v_C + r_C x m v_O + J omega."""
    padded = np.column_stack([origin, np.zeros(len(time))])
    origin_of, axis_of = (make_interp_spline(time, values, k=9) for values in (padded, axis))
    position, velocity = origin_of(time), origin_of(time, 1)
    direction, turn = axis_of(time), axis_of(time, 1)
    transverse, axial = body.inertia[0, 0], body.inertia[2, 2]
    r_C, v_C = body.center_of_mass[2] * direction, velocity + body.center_of_mass[2] * turn
    momentum = (
        body.mass * (np.cross(position, v_C) + np.cross(r_C, velocity))
        + transverse * np.cross(direction, turn)
        + axial * spin_rate * direction
    )
    return momentum[:, 2]


class FreeSymmetricBody:
    """The integrable motion: symmetric body with z_C = 0 and no transverse load.

    With alpha = sigma - s, beta = sigma + s the axis has O = r cos(s) along sigma and tan(theta) = (r/L) sin(s), so that
    the energy is G(s) s'^2/2 + V(s), where G = m r^2 sin^2 s + A (r/L)^2 cos^2 s cos^4 theta and
    V = (H - C Omega cos(theta))^2/(2 (m r^2 cos^2 s + A sin^2 theta)), H the angular momentum about Z.
    """

    digits = 30  # energy - potential vanishes at the amplitude

    def __init__(self, scene):
        joint, body, motion = scene.joint, scene.body, scene.motion
        self.r, self.L, self.m = joint.effective_radius, joint.half_length, body.mass
        self.A, self.gyro = body.inertia[0, 0], body.inertia[2, 2] * motion.spin_rate
        with mpmath.workdps(self.digits):
            s = mpmath.mpf(motion.beta - motion.alpha) / 2
            s_rate, sigma_rate = (motion.beta_rate - motion.alpha_rate) / 2, (motion.beta_rate + motion.alpha_rate) / 2
            self.momentum = self._precession_inertia(s) * sigma_rate + self.gyro * self._cos_tilt(s)
            self.energy = self._inertia(s) * s_rate**2 / 2 + self._potential(s)
            self.amplitude = mpmath.findroot(lambda x: self._potential(x) - self.energy, s)

    def _cos_tilt(self, s):
        return 1 / mpmath.sqrt(1 + (self.r / self.L * mpmath.sin(s)) ** 2)

    def _inertia(self, s):
        swing = self.r / self.L * mpmath.cos(s) * self._cos_tilt(s) ** 2
        return self.m * (self.r * mpmath.sin(s)) ** 2 + self.A * swing**2

    def _precession_inertia(self, s):
        return self.m * (self.r * mpmath.cos(s)) ** 2 + self.A * (1 - self._cos_tilt(s) ** 2)

    def _potential(self, s):
        return (self.momentum - self.gyro * self._cos_tilt(s)) ** 2 / (2 * self._precession_inertia(s))

    def rate(self, s):
        """|s'| at s, rad/s."""
        return mpmath.sqrt(2 * (self.energy - self._potential(s)) / self._inertia(s))

    def period(self):
        """Period of beta - alpha, s: four times the time from s = 0 to the amplitude, s = amplitude sin(x)."""
        with mpmath.workdps(self.digits):

            def time(x):
                return self.amplitude * mpmath.cos(x) / self.rate(self.amplitude * mpmath.sin(x))

            return float(4 * mpmath.quad(time, [0, mpmath.pi / 2], method="gauss-legendre"))
