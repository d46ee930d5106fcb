"""Motions in the paper's coordinates: steps that stay on the branch (11), statuses where the formulation breaks."""

from __future__ import annotations

import numpy as np

from tolmc.kernels import parameters as P
from tolmc.kernels.jit import kernel
from tolmc.kernels.published.equations import (
    accelerations,
    body_matrix,
    constraint_moment,
    constraints,
    contact_forces,
    torque_power,
    total_energy,
)

OK, SINGULAR_PSI, SINGULAR_MAXIMUM_TILT, SINGULAR_THETA, DIVERGED = range(5)

# Measured against slope coordinates over 18,000 random states (distances 1 ... 1e-8 from the three sets, clearance
# ratios 1e-3 ... 10, spins up to 1e3 rad/s): where the condition number is 1e6 ... 1e7, accelerations and contact
# forces differ by 2e-11 in the median, by 2e-9 in 99 of 100 states and by 2e-8 at most. The number is about 6 over the
# distance from psi = k pi/2 or maximum tilt, and about 30 over the clearance ratio squared.
CONDITION_LIMIT = 1e7

# In units of r: Newton's method stays this near to the branch (11) even where CONDITION_LIMIT is met; the mirror
# branches of (12) are farther away.
BRANCH_LIMIT = 1e-10
# In units of r: a step whose stages or end lie farther off the branch is too long to mean anything.
DRIFT_LIMIT = 0.3
NEWTON_ITERATIONS = 8


@kernel
def retract(q, qd, r, L):
    """Bring q and qd onto the branch (11), in place; returns the distance moved, over r.

    (s, t) is normalised to length r and loses the radial part of its rate; psi and phi stay. The map is smooth
    around all of the branch, its singular sets included, so that a Runge-Kutta formula keeps its order when its
    stages are evaluated behind it.
    """
    c_psi, s_psi = np.cos(q[2]), np.sin(q[2])
    s, t = q[0] * c_psi + q[1] * s_psi, L * np.tan(q[3])
    s_rate, t_rate = qd[0] * c_psi + qd[1] * s_psi, L * qd[3] / np.cos(q[3]) ** 2
    length = np.sqrt(s * s + t * t)
    across, excess = q[0] * s_psi - q[1] * c_psi, length - r
    s, t = s * r / length, t * r / length
    radial = (s * s_rate + t * t_rate) / (r * r)
    s_rate, t_rate = s_rate - radial * s, t_rate - radial * t
    q[0], q[1], q[3] = s * c_psi, s * s_psi, np.arctan(t / L)
    qd[0], qd[1] = s_rate * c_psi - q[1] * qd[2], s_rate * s_psi + q[0] * qd[2]
    qd[3] = t_rate * np.cos(q[3]) ** 2 / L
    return np.sqrt(across * across + excess * excess) / r


@kernel
def project(q, r, L, regular):
    """Newton's method onto the formulation's own constraints, in place.

    Each correction is the smallest one, X0 and Y0 measured in r, psi in radians, theta in r/L.
    """
    weight = np.array([r * r, r * r, 1.0, (r / L) ** 2, 0.0])
    for _ in range(NEWTON_ITERATIONS):
        g, B, _ = constraints(q, np.zeros(5), r, L, regular)
        b00, b01, b11 = 0.0, 0.0, 0.0
        for i in range(5):
            b00 += B[0, i] * weight[i] * B[0, i]
            b01 += B[0, i] * weight[i] * B[1, i]
            b11 += B[1, i] * weight[i] * B[1, i]
        determinant = b00 * b11 - b01 * b01
        first, second = (b11 * g[0] - b01 * g[1]) / determinant, (b00 * g[1] - b01 * g[0]) / determinant
        for i in range(5):
            q[i] -= weight[i] * (B[0, i] * first + B[1, i] * second)


@kernel
def separation(q, other, r, L):
    """Distance of two positions, lengths measured in r, theta in r/L."""
    lengths = (q[0] - other[0]) ** 2 + (q[1] - other[1]) ** 2 + (L * (q[3] - other[3])) ** 2
    return np.sqrt(lengths / (r * r) + (q[2] - other[2]) ** 2)


@kernel
def failure(q, r, L, regular):
    """Status of the singular set nearest to q; DIVERGED when none is near (or q is not finite)."""
    c_psi, s_psi = np.cos(q[2]), np.sin(q[2])
    status, nearest = DIVERGED, 0.1
    if abs(np.tan(q[3])) < nearest:
        status, nearest = SINGULAR_THETA, abs(np.tan(q[3]))
    if not regular:
        radius, turn = abs(q[0] * c_psi + q[1] * s_psi) / r, min(abs(c_psi), abs(s_psi))
        if radius < nearest:
            status, nearest = SINGULAR_MAXIMUM_TILT, radius
        if turn < nearest:
            status = SINGULAR_PSI
    return status


@kernel
def advance(q, qd, qdd, step, A, b, p, body, regular):
    """One step of the explicit Runge-Kutta formula (A, b) with projection, in place; returns a status and the torque's work.

    qdd holds the accelerations at (q, qd). Newton's result has to lie on the branch (11), not on a mirror branch
    of (12), and about as near to the unprojected point as the branch is.
    """
    r, L, stages = p[P.RADIUS], p[P.HALF_LENGTH], b.size
    rate, speed_rate = np.empty((stages, 5)), np.empty((stages, 5))
    rate[0], speed_rate[0] = qd, qdd
    work = step * b[0] * torque_power(q, qd, p)
    for stage in range(1, stages):
        x, v = q.copy(), qd.copy()
        for previous in range(stage):
            x += step * A[stage, previous] * rate[previous]
            v += step * A[stage, previous] * speed_rate[previous]
        if not retract(x, v, r, L) <= DRIFT_LIMIT:
            return DIVERGED, work
        a, _, _, condition = accelerations(x, v, p, body, regular)
        if not condition <= CONDITION_LIMIT:
            return failure(x, r, L, regular), work
        rate[stage], speed_rate[stage] = v, a
        work += step * b[stage] * torque_power(x, v, p)
    for stage in range(stages):
        q += step * b[stage] * rate[stage]
        qd += step * b[stage] * speed_rate[stage]
    on_branch = q.copy()
    drift = retract(on_branch, qd.copy(), r, L)
    if not drift <= DRIFT_LIMIT:
        return DIVERGED, work
    project(q, r, L, regular)
    off_branch = retract(q, qd, r, L)
    moved = separation(q, on_branch, r, L)
    if not (off_branch <= BRANCH_LIMIT and moved <= 10 * drift + BRANCH_LIMIT):
        return failure(q, r, L, regular), work
    return OK, work


@kernel
def integrate(p, step, A, b, regular, q, qd, axis, contact_force, multipliers, energy, work):
    """One motion in fixed steps, recorded at its start and after every step.

    Parameters
    ----------
    p : (30,) or longer
        In the order of :mod:`tolmc.kernels.parameters`.
    step : float, s
    A, b : (stages, stages), (stages,)
        Tableau of an explicit Runge-Kutta formula.
    regular : bool
        Constraint rows: the regular pair instead of (13).
    q, qd : (n + 1, 5)
        Row 0 holds the start, as :func:`start` gives it; the other rows are filled.
    axis, contact_force, multipliers, energy, work : (n + 1, 3), (n + 1, 2), (n + 1, 2), (n + 1,), (n + 1,)
        Filled. The multipliers belong to the rows chosen by ``regular``; ``work`` (J) is the torque's since the start.

    Returns
    -------
    status : int
        ``OK``, or why the motion ends: ``SINGULAR_PSI`` (psi = k pi/2), ``SINGULAR_MAXIMUM_TILT`` (X0 = Y0 = 0),
        ``SINGULAR_THETA`` (theta = 0), ``DIVERGED``.
    rows : int
        Number of valid rows; those after them are NaN. A motion that ends does so in the step from its last valid
        row, or at its start when there is none.
    """
    r, L, body = p[P.RADIUS], p[P.HALF_LENGTH], body_matrix(p)
    q[1:], qd[1:] = np.nan, np.nan
    axis[:], contact_force[:], multipliers[:], energy[:], work[:] = np.nan, np.nan, np.nan, np.nan, np.nan
    x, v, a, done = q[0].copy(), qd[0].copy(), np.zeros(5), 0.0
    for row in range(energy.size):
        if row > 0:
            status, in_step = advance(x, v, a, step, A, b, p, body, regular)
            if status != OK:
                return status, row
            done += in_step
        a, multiplier, force, condition = accelerations(x, v, p, body, regular)
        if not condition <= CONDITION_LIMIT:
            return failure(x, r, L, regular), row
        q[row], qd[row], multipliers[row], energy[row] = x, v, multiplier, total_energy(x, v, p, body)
        work[row] = done
        contact_force[row] = contact_forces(x, force, constraint_moment(x, v, a, p, body), r, L)
        axis[row, 0], axis[row, 1] = np.sin(x[2]) * np.sin(x[3]), -np.cos(x[2]) * np.sin(x[3])
        axis[row, 2] = np.cos(x[3])
    return OK, energy.size


@kernel
def sample_steps(p, step, A, b, regular, q, qd, positions, origin, axis, contact_force):
    """The motion between its records: one step of ``positions[j] * step`` from every record but the last.

    Parameters as in :func:`integrate`; q, qd (n + 1, 5) as it filled them; positions (m,) in (0, 1). Fills origin
    (n, m, 2), axis (n, m, 3) and contact_force (n, m, 2), NaN where a sample meets a singular set. Returns the status.
    """
    body = body_matrix(p)
    r, L = p[P.RADIUS], p[P.HALF_LENGTH]
    worst = OK
    for row in range(origin.shape[0]):
        start_rate, _, _, _ = accelerations(q[row], qd[row], p, body, regular)
        for j in range(positions.size):
            x, v = q[row].copy(), qd[row].copy()
            status, _ = advance(x, v, start_rate, positions[j] * step, A, b, p, body, regular)
            a, _, force, condition = accelerations(x, v, p, body, regular)
            if status == OK and not condition <= CONDITION_LIMIT:
                status = failure(x, r, L, regular)
            if status != OK:
                worst = status
                origin[row, j], axis[row, j], contact_force[row, j] = np.nan, np.nan, np.nan
                continue
            origin[row, j, 0], origin[row, j, 1] = x[0], x[1]
            axis[row, j, 0], axis[row, j, 1] = np.sin(x[2]) * np.sin(x[3]), -np.cos(x[2]) * np.sin(x[3])
            axis[row, j, 2] = np.cos(x[3])
            contact_force[row, j] = contact_forces(x, force, constraint_moment(x, v, a, p, body), r, L)
    return worst
