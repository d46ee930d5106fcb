"""The equations of motion in every mode of contact, assembled from a body, a section and friction.

With the gaps' rows G, the directions H = G^T + q T of the contacts' generalised forces (T: friction per unit normal force, q
the normal force per unit multiplier), and lambda >= 0:

    M a = f + H lambda,   G a = -g''_0 for closed contacts,   A = G M^-1 H

The 2 x 2 system for lambda has 1 on the diagonal and 0 beside it where a contact is open: one straight line for all modes, lane
by lane.
"""

from __future__ import annotations

from typing import NamedTuple

from tolmc.kernels import parameters as P
from tolmc.kernels.jit import device, dot, fma, strict
from tolmc.kernels.once import once
from tolmc.kernels.one_sided import circle, exact, general, general_swinging, symmetric, symmetric_swinging
from tolmc.kernels.one_sided import layout as at
from tolmc.kernels.one_sided.friction import sliding


class Equations(NamedTuple):
    """Device functions of one kind of scene, and what they need."""

    state: int
    coefficients: int
    samples: int
    seen: int
    spins: bool
    works: bool
    glimpsed: bool
    rubs: bool
    swings: bool
    far: float
    unit: bool
    prepare: object
    start: object
    orient: object
    advance: object
    fly: object
    look: object
    glimpse: object
    free: object
    forces: object
    reach: object
    system: object
    multipliers: object
    kick: object
    place: object
    project: object
    momentum: object


def _given(section, body, spins):
    """Device functions that take a sample's scalars and start into its lane."""
    size, body_prepare = section.size, body.prepare

    @device
    def prepare(raw, given, coef, lane, width):
        """A lane's coefficients from its parameters and what is given, (row, lane) flat."""
        c, length, mass = size(raw, lane, width), raw[P.HALF_LENGTH * width + lane], raw[P.MASS * width + lane]
        coef[at.C * width + lane], coef[at.FORCE * width + lane] = c, mass * c
        coef[at.ENERGY * width + lane] = mass * c * c
        coef[at.KAPPA * width + lane], coef[at.KAPPA2 * width + lane] = c / length, (c / length) ** 2
        coef[at.ROUND * width + lane] = raw[P.JOURNAL_RADIUS * width + lane] / c
        coef[at.BOUNCE * width + lane] = given[at.RESTITUTION * width + lane]
        coef[at.HERTZ * width + lane] = given[at.STIFFNESS * width + lane]
        coef[at.MU * width + lane] = given[at.FRICTION * width + lane]
        coef[at.SLIP * width + lane] = given[at.SLIP_SPEED * width + lane] / c
        coef[at.REST_HEIGHT * width + lane] = given[at.REST * width + lane]
        coef[at.DRIVEN * width + lane] = given[at.HELD * width + lane]
        z, z_force, force = raw[P.COM_Z * width + lane], raw[P.POINT_Z * width + lane] / mass, 1.0 / (mass * c)
        gx, gy, gz = raw[P.GRAVITY_X * width + lane], raw[P.GRAVITY_Y * width + lane], raw[P.GRAVITY_Z * width + lane]
        kx, ky, kz = raw[P.FORCE_X * width + lane], raw[P.FORCE_Y * width + lane], raw[P.FORCE_Z * width + lane]
        coef[at.FX * width + lane], coef[at.FY * width + lane] = gx / c + kx * force, gy / c + ky * force
        coef[at.GX * width + lane] = (z * gx + z_force * kx) / (c * length)
        coef[at.GY * width + lane] = (z * gy + z_force * ky) / (c * length)
        coef[at.GZ * width + lane] = (z * gz + z_force * kz) / (c * c)
        body_prepare(raw, given, coef, lane, width)

    @device
    def start(given, y, coef, lane, width):
        """State at the start, but for turns; both contacts open until the caller has looked."""
        per_c = 1.0 / coef[at.C * width + lane]
        for component in range(8):
            y[component * width + lane] = per_c * given[(at.START_X + component) * width + lane]
        if spins:
            y[at.SPIN_RATE * width + lane] = given[at.OMEGA * width + lane]
        else:
            coef[at.OMEGA_FIXED * width + lane] = given[at.OMEGA * width + lane]
        coef[at.CLOSED_D * width + lane], coef[at.CLOSED_E * width + lane] = 0.0, 0.0

    return prepare, start


def build(section, body, rubs: bool) -> Equations:
    """The equations of one kind of scene."""
    swings = body.SWINGS
    spins = body.SPINS or rubs
    works = body.SPINS or rubs
    touch, free, solve, energies, turn = section.touch, body.free, body.solve, body.energies, body.turn
    normalise = body.normalise
    prepare, start = _given(section, body, spins)
    state = max(body.STATE, at.SPIN_RATE + 1 if spins else 0)
    turns = body.STATE > at.COS

    @(strict if section.GLIMPSED else device)
    def reach(y, ax, ay, bx, by, coef, lane, width):
        """Of both ends: wall's normal, its lever, N/lambda; gaps, their rates, and second derivatives at free accelerations.

        To the same bits in a block that flies and in one that does not.
        """
        ox, oy, wx, wy = y[lane], y[width + lane], y[2 * width + lane], y[3 * width + lane]
        ux, uy, vx, vy = y[4 * width + lane], y[5 * width + lane], y[6 * width + lane], y[7 * width + lane]
        kappa = coef[at.KAPPA * width + lane]
        sx, sy, tx, ty = kappa * wx, kappa * wy, kappa * vx, kappa * vy
        ndx, ndy, ld, qd, gap_d, bias_d = touch(ox + wx, oy + wy, ux + vx, uy + vy, sx, sy, tx, ty, coef, lane, width)
        nex, ney, le, qe, gap_e, bias_e = touch(
            ox - wx, oy - wy, ux - vx, uy - vy, -sx, -sy, -tx, -ty, coef, lane, width
        )
        rate_d = -dot(ndx, ndy, fma(ld, vx, ux), fma(ld, vy, uy))
        rate_e = -dot(nex, ney, fma(-le, vx, ux), fma(-le, vy, uy))
        acc_d = bias_d - dot(ndx, ndy, fma(ld, bx, ax), fma(ld, by, ay))
        acc_e = bias_e - dot(nex, ney, fma(-le, bx, ax), fma(-le, by, ay))
        return (ndx, ndy, ld, qd), (nex, ney, le, qe), (gap_d, gap_e), (rate_d, rate_e), (acc_d, acc_e)

    @device
    def system(y, coef, lane, width):
        """Everything about one lane that does not depend on which contacts are closed."""
        wx, wy = y[2 * width + lane], y[3 * width + lane]
        ux, uy, vx, vy = y[4 * width + lane], y[5 * width + lane], y[6 * width + lane], y[7 * width + lane]
        spin = y[at.SPIN_RATE * width + lane] if spins else coef[at.OMEGA_FIXED * width + lane]
        kappa = coef[at.KAPPA * width + lane]
        sx, sy, tx, ty = kappa * wx, kappa * wy, kappa * vx, kappa * vy
        ax, ay, bx, by, a_spin, hold, factors = free(y, spin, coef, lane, width)
        (ndx, ndy, ld, qd), (nex, ney, le, qe), gap, rate, acc = reach(y, ax, ay, bx, by, coef, lane, width)
        mdx, mdy, mex, mey = ld * ndx, ld * ndy, -le * nex, -le * ney
        hd0, hd1, hd2, hd3, hd4 = -ndx, -ndy, -mdx, -mdy, 0.0
        he0, he1, he2, he3, he4 = -nex, -ney, -mex, -mey, 0.0
        power_d, power_e, slide_d, slide_e, torque_d, torque_e = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        if rubs:
            round_ = coef[at.ROUND * width + lane]
            f_e, f_b, v_e, v_b, b_x, b_y, e_x, e_y, arm_x, arm_y = sliding(
                ndx, ndy, ld, sx, sy, tx, ty, ux, uy, vx, vy, spin, coef, lane, width
            )
            hd0, hd1 = hd0 + qd * (f_e * e_x + f_b * b_x), hd1 + qd * (f_e * e_y + f_b * b_y)
            hd2, hd3 = hd2 + qd * (ld * f_b * b_x - f_e * arm_x), hd3 + qd * (ld * f_b * b_y - f_e * arm_y)
            torque_d = -round_ * f_b
            hd4 = qd * kappa * torque_d
            power_d, slide_d = f_e * v_e + f_b * v_b, v_e * v_e + v_b * v_b
            f_e, f_b, v_e, v_b, b_x, b_y, e_x, e_y, arm_x, arm_y = sliding(
                nex, ney, le, -sx, -sy, -tx, -ty, ux, uy, -vx, -vy, spin, coef, lane, width
            )
            he0, he1 = he0 + qe * (f_e * e_x + f_b * b_x), he1 + qe * (f_e * e_y + f_b * b_y)
            he2, he3 = he2 - qe * (le * f_b * b_x - f_e * arm_x), he3 - qe * (le * f_b * b_y - f_e * arm_y)
            torque_e = -round_ * f_b
            he4 = qe * kappa * torque_e
            power_e, slide_e = f_e * v_e + f_b * v_b, v_e * v_e + v_b * v_b
        pd = solve(hd0, hd1, hd2, hd3, hd4, factors)
        pe = solve(he0, he1, he2, he3, he4, factors)
        a_dd = -(ndx * pd[0] + ndy * pd[1] + mdx * pd[2] + mdy * pd[3])
        a_de = -(ndx * pe[0] + ndy * pe[1] + mdx * pe[2] + mdy * pe[3])
        a_ed = -(nex * pd[0] + ney * pd[1] + mex * pd[2] + mey * pd[3])
        a_ee = -(nex * pe[0] + ney * pe[1] + mex * pe[2] + mey * pe[3])
        return (
            (ax, ay, bx, by, a_spin, hold), pd, pe, (a_dd, a_de, a_ed, a_ee), acc, gap, rate, (qd, qe),
            (power_d, power_e, slide_d, slide_e, torque_d, torque_e), spin,
            (hd0, hd1, hd2, hd3, hd4, 0.0), (he0, he1, he2, he3, he4, 0.0),
        )  # fmt: skip

    @device
    def multipliers(a, acc, coef, lane, width):
        """lambda_D, lambda_E of the closed contacts, 0 of the open ones."""
        a_dd, a_de, a_ed, a_ee = a
        d, e = coef[at.CLOSED_D * width + lane] > 0.0, coef[at.CLOSED_E * width + lane] > 0.0
        a_dd, a_ee = a_dd if d else 1.0, a_ee if e else 1.0
        a_de, a_ed = a_de if d and e else 0.0, a_ed if d and e else 0.0
        r_d, r_e = -acc[0] if d else 0.0, -acc[1] if e else 0.0
        inverse = 1.0 / (a_dd * a_ee - a_de * a_ed)
        return (a_ee * r_d - a_de * r_e) * inverse, (a_dd * r_e - a_ed * r_d) * inverse

    @device
    def rates(y, h, k, first, lane, width, a, pd, pe, l_d, l_e, spin, coef):
        """h times the rates of the speeds, and of what follows them in the state, into ``k[first:]``."""
        for c in range(4):
            k[first + c * width + lane] = h * (a[c] + l_d * pd[c] + l_e * pe[c])
        if spins:
            rate = a[4] + l_d * pd[4] + l_e * pe[4]
            k[first + (at.SPIN_RATE - at.OV_X) * width + lane] = h * coef[at.KAPPA * width + lane] * rate
        if turns:
            turn(y, spin, h, k, first - at.OV_X * width, coef, lane, width)

    @device
    def whirl(y, coef, lane, width):
        """Sum of the polar rates of the ends that are closed."""
        ox, oy, wx, wy = y[lane], y[width + lane], y[2 * width + lane], y[3 * width + lane]
        ux, uy, vx, vy = y[4 * width + lane], y[5 * width + lane], y[6 * width + lane], y[7 * width + lane]
        d, e = coef[at.CLOSED_D * width + lane] > 0.0, coef[at.CLOSED_E * width + lane] > 0.0
        dx, dy, ex, ey = ox + wx, oy + wy, ox - wx, oy - wy
        d2, e2 = dx * dx + dy * dy if d else 1.0, ex * ex + ey * ey if e else 1.0
        turn_d = dx * (uy + vy) - dy * (ux + vx) if d else 0.0
        turn_e = ex * (uy - vy) - ey * (ux - vx) if e else 0.0
        return turn_d / d2 + turn_e / e2

    @device
    def advance(y, coef, h, k, samples, lane, width):
        """h times the speeds' rates into ``k`` and what the statistics want of this stage into ``samples``."""
        a, pd, pe, matrix, acc, _, _, q, rub, spin, _, _ = system(y, coef, lane, width)
        l_d, l_e = multipliers(matrix, acc, coef, lane, width)
        rates(y, h, k, 0, lane, width, a, pd, pe, l_d, l_e, spin, coef)
        n_d, n_e = q[0] * l_d, q[1] * l_e
        samples[lane], samples[width + lane] = n_d, n_e
        if works:
            _, _, power = energies(y, spin, spins, coef, lane, width)
            heat = n_d * rub[0] + n_e * rub[1]
            if rubs:
                drive = (a[5] + l_d * pd[5] + l_e * pe[5]) / coef[at.KAPPA * width + lane]
                power += drive * spin
                samples[at.S_DRIVE * width + lane] = drive
                if swings:
                    samples[at.S_DRIVE_POWER * width + lane] = drive * spin
                samples[at.S_WHIRL * width + lane] = whirl(y, coef, lane, width)
                samples[at.S_SLIP_D * width + lane] = n_d * rub[2] ** 0.5
                samples[at.S_SLIP_E * width + lane] = n_e * rub[3] ** 0.5
                samples[at.S_HEAT * width + lane] = -heat
                samples[at.S_TORQUE * width + lane] = abs(n_d * rub[4] + n_e * rub[5])
            samples[at.S_POWER * width + lane] = power + heat

    @device
    def fly(y, coef, h, k, lane, width):
        """As :func:`advance` of a lane without contact, friction and torque, to the same bits; o and o' are not looked at."""
        ax, ay, bx, by, _, _, _ = free(y, coef[at.OMEGA_FIXED * width + lane], coef, lane, width)
        k[lane], k[width + lane], k[2 * width + lane], k[3 * width + lane] = h * ax, h * ay, h * bx, h * by

    @device
    def see(y, spin, n_d, n_e, gap, rate, acc, coef, f, seen, lane, width):
        """What every kind of scene sees; the torque's power."""
        for c in range(4):
            f[c * width + lane] = y[(c + 4) * width + lane]
        seen[at.N_D * width + lane], seen[at.N_E * width + lane] = n_d, n_e
        seen[at.GAP_D * width + lane], seen[at.GAP_E * width + lane] = gap[0], gap[1]
        seen[at.RATE_D * width + lane], seen[at.RATE_E * width + lane] = rate[0], rate[1]
        seen[at.ACC_D * width + lane], seen[at.ACC_E * width + lane] = acc[0], acc[1]
        wx, wy = y[2 * width + lane], y[3 * width + lane]
        seen[at.W2 * width + lane] = dot(wx, wy, wx, wy)
        seen[at.W2_RATE * width + lane] = 2.0 * dot(wx, wy, y[6 * width + lane], y[7 * width + lane])
        kinetic, potential, power = energies(y, spin, spins, coef, lane, width)
        seen[at.KINETIC * width + lane], seen[at.POTENTIAL * width + lane] = kinetic, potential
        return power

    @device
    def glimpse(y, coef, f, seen, lane, width):
        """As :func:`look` of a lane without contact, friction and torque, to the same bits."""
        spin = coef[at.OMEGA_FIXED * width + lane]
        ax, ay, bx, by, _, _, _ = free(y, spin, coef, lane, width)
        _, _, gap, rate, acc = reach(y, ax, ay, bx, by, coef, lane, width)
        f[4 * width + lane], f[5 * width + lane], f[6 * width + lane], f[7 * width + lane] = ax, ay, bx, by
        see(y, spin, 0.0, 0.0, gap, rate, acc, coef, f, seen, lane, width)

    @device
    def look(y, coef, f, seen, lane, width):
        """y' into ``f``, and gaps, forces and energies into ``seen``."""
        a, pd, pe, matrix, acc, gap, rate, q, rub, spin, _, _ = system(y, coef, lane, width)
        l_d, l_e = multipliers(matrix, acc, coef, lane, width)
        rates(y, 1.0, f, 4 * width, lane, width, a, pd, pe, l_d, l_e, spin, coef)
        a_dd, a_de, a_ed, a_ee = matrix
        n_d, n_e = q[0] * l_d, q[1] * l_e
        acc = acc[0] + a_dd * l_d + a_de * l_e, acc[1] + a_ed * l_d + a_ee * l_e
        power = see(y, spin, n_d, n_e, gap, rate, acc, coef, f, seen, lane, width)
        if works:
            heat = n_d * rub[0] + n_e * rub[1]
            if rubs:
                drive = (a[5] + l_d * pd[5] + l_e * pe[5]) / coef[at.KAPPA * width + lane]
                power += drive * spin
                seen[at.DRIVE * width + lane], seen[at.WHIRL * width + lane] = drive, whirl(y, coef, lane, width)
                if swings:
                    seen[at.DRIVE_POWER * width + lane] = drive * spin
                seen[at.SLIP_D * width + lane], seen[at.SLIP_E * width + lane] = (
                    n_d * rub[2] ** 0.5,
                    n_e * rub[3] ** 0.5,
                )
                seen[at.HEAT * width + lane], seen[at.TORQUE * width + lane] = -heat, abs(n_d * rub[4] + n_e * rub[5])
                d, e = coef[at.CLOSED_D * width + lane] > 0.0, coef[at.CLOSED_E * width + lane] > 0.0
                margin = min(a_dd if d else 1.0, a_ee if e else 1.0)
                seen[at.MARGIN * width + lane] = min(margin, a_dd * a_ee - a_de * a_ed) if d and e else margin
                slip = coef[at.SLIP * width + lane]
                slow_d, slow_e = rub[2] ** 0.5 - slip if d else slip, rub[3] ** 0.5 - slip if e else slip
                seen[at.SLOW * width + lane] = min(slow_d, slow_e)
            seen[at.POWER * width + lane] = power + heat

    @device
    def forces(y, coef, lane, width):
        """N_D, N_E, and with friction the size of its moment about the axis and the moment that holds Omega."""
        a, pd, pe, matrix, acc, _, _, q, rub, _, _, _ = system(y, coef, lane, width)
        l_d, l_e = multipliers(matrix, acc, coef, lane, width)
        n_d, n_e, torque, drive = q[0] * l_d, q[1] * l_e, 0.0, 0.0
        if rubs:
            torque = abs(n_d * rub[4] + n_e * rub[5])
            drive = (a[5] + l_d * pd[5] + l_e * pe[5]) / coef[at.KAPPA * width + lane]
        return n_d, n_e, torque, drive

    @device
    def kick(y, l_d, l_e, pd, pe, coef, lane, width):
        """Change the speeds by the impulses lambda."""
        for c in range(4):
            y[(c + 4) * width + lane] += l_d * pd[c] + l_e * pe[c]
        if spins:
            y[at.SPIN_RATE * width + lane] += coef[at.KAPPA * width + lane] * (l_d * pd[4] + l_e * pe[4])

    @device
    def rows_at(y, coef, on_d, on_e, lane, width):
        """Rows, gaps and (G G^T)^-1 of the closed contacts at a lane's pose; of an open one 1 and 0."""
        kappa = coef[at.KAPPA * width + lane]
        ox, oy, wx, wy = y[lane], y[width + lane], y[2 * width + lane], y[3 * width + lane]
        ux, uy, vx, vy = y[4 * width + lane], y[5 * width + lane], y[6 * width + lane], y[7 * width + lane]
        sx, sy, tx, ty = kappa * wx, kappa * wy, kappa * vx, kappa * vy
        ndx, ndy, ld, _, gap_d, _ = touch(ox + wx, oy + wy, ux + vx, uy + vy, sx, sy, tx, ty, coef, lane, width)
        nex, ney, le, _, gap_e, _ = touch(ox - wx, oy - wy, ux - vx, uy - vy, -sx, -sy, -tx, -ty, coef, lane, width)
        g_dd = (ndx * ndx + ndy * ndy) * (1.0 + ld * ld) if on_d else 1.0
        g_ee = (nex * nex + ney * ney) * (1.0 + le * le) if on_e else 1.0
        g_de = (ndx * nex + ndy * ney) * (1.0 - ld * le) if on_d and on_e else 0.0
        inverse = 1.0 / (g_dd * g_ee - g_de * g_de)
        rows = ndx, ndy, ld * ndx, ld * ndy, nex, ney, -le * nex, -le * ney
        return rows, (gap_d if on_d else 0.0, gap_e if on_e else 0.0), (g_dd * inverse, g_ee * inverse, g_de * inverse)

    @device
    def add(y, first, rows, miss_d, miss_e, inverse, lane, width):
        """Add to four rows of the state what the least squares change of them makes of two misses."""
        g_dd, g_ee, g_de = inverse
        l_d, l_e = g_ee * miss_d - g_de * miss_e, g_dd * miss_e - g_de * miss_d
        for c in range(4):
            y[(first + c) * width + lane] += l_d * rows[c] + l_e * rows[c + 4]

    @device
    def place(y, coef, on_d, on_e, lane, width):
        """The pose put back on the closed contacts from next to them, along their rows."""
        rows, gap, inverse = rows_at(y, coef, on_d, on_e, lane, width)
        add(y, at.O_X, rows, gap[0], gap[1], inverse, lane, width)

    @device
    def project(y, coef, on_d, on_e, lane, width):
        """Pose and speeds put back on the closed contacts along their rows; Newton's iteration, quadratic."""
        place(y, coef, on_d, on_e, lane, width)
        # Now the pose is right to more than rounding, and the rows with it.
        rows, gap, inverse = rows_at(y, coef, on_d, on_e, lane, width)
        add(y, at.O_X, rows, gap[0], gap[1], inverse, lane, width)
        rate_d, rate_e = 0.0, 0.0
        for c in range(4):
            rate_d -= rows[c] * y[(c + 4) * width + lane]
            rate_e -= rows[c + 4] * y[(c + 4) * width + lane]
        add(y, at.OV_X, rows, rate_d if on_d else 0.0, rate_e if on_e else 0.0, inverse, lane, width)
        normalise(y, coef, lane, width)

    samples = 10 if swings else 9 if rubs else 3 if works else 2
    seen = at.SEEN if rubs else at.POWER + 1 if works else at.POWER
    glimpsed = section.GLIMPSED and not works
    return Equations(
        state, body.COEFFICIENTS, samples, seen, spins, works, glimpsed, rubs, swings, section.FAR, section.UNIT,
        prepare, start, body.orient, advance, fly, look, glimpse, free, forces, reach, system, multipliers, kick, place,
        project, body.momentum,
    )  # fmt: skip


@once
def equations_of(is_exact: bool, is_general: bool, rubs: bool, swings: bool) -> Equations:
    """Those on the exact section or the circle, of any body or a symmetric one, with friction, with what swings."""
    bodies = (symmetric_swinging, general_swinging) if swings else (symmetric, general)
    return build(exact if is_exact else circle, bodies[is_general], rubs)
