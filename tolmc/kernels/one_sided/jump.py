"""The jump at an event: impact or release, and which contacts stay closed.

Impacts without friction are struck in all lanes at once; what remains of them, where a contact comes to rest or stays on the
wall, and all other events are of one lane.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from tolmc.kernels.jit import device, routine
from tolmc.kernels.one_sided import layout as at
from tolmc.kernels.one_sided.equations import Equations
from tolmc.kernels.one_sided.events import brought_to_rest, impulses, stays
from tolmc.kernels.one_sided.layout import WIDTH

TOGETHER = 1e-11  # gap over c below which another approaching contact belongs to the same impact
_FAR_ABOVE = 1e2  # times the height of rest: a contact that leaves its impact with the speed for so much does not rest


class Jump(NamedTuple):
    """Routines: ``jump`` and ``settle`` of one lane, ``strike`` of a block."""

    jump: object
    strike: object
    settle: object


def build(equations: Equations) -> Jump:
    """Jumps on given equations."""
    system, kick = equations.system, equations.kick
    project_lane, place_lane = equations.project, equations.place
    spins, unit, rubs = equations.spins, equations.unit, equations.rubs

    @routine
    def system_at(y, coef, lane):
        return system(y, coef, lane, WIDTH)

    @routine
    def project(y, coef, on_d, on_e, lane):
        project_lane(y, coef, on_d, on_e, lane, WIDTH)

    @routine
    def place(y, coef, on_d, on_e, lane):
        place_lane(y, coef, on_d, on_e, lane, WIDTH)

    @device
    def dot(y, coef, lane, h):
        """The power of a generalised force of unit size."""
        power = 0.0
        for c in range(4):
            power += y[(c + 4) * WIDTH + lane] * h[c]
        if spins:
            power += y[at.SPIN_RATE * WIDTH + lane] * h[4] / coef[at.KAPPA * WIDTH + lane]
        return power

    @device
    def blend(smooth, rough, share):
        """A generalised force, or what it does, with a share of its friction."""
        return (
            smooth[0] + share * (rough[0] - smooth[0]), smooth[1] + share * (rough[1] - smooth[1]),
            smooth[2] + share * (rough[2] - smooth[2]), smooth[3] + share * (rough[3] - smooth[3]),
            smooth[4] + share * (rough[4] - smooth[4]), smooth[5] + share * (rough[5] - smooth[5]),
        )  # fmt: skip

    @routine
    def held_back(y, coef, lane, b_d, b_e, on_d, on_e):
        """What impulses do in an impact with friction, which is held back where all of it would turn the sliding round.

        F.v along the force of before the impact is linear in the speeds and negative; each contact's share of its friction is
        the largest, found by bisection, that leaves it so.
        """
        mu = coef[at.MU * WIDTH + lane]
        _, pd1, pe1, a1, _, _, _, _, _, _, hd1, he1 = system_at(y, coef, lane)
        coef[at.MU * WIDTH + lane] = 0.0
        _, pd0, pe0, a0, _, _, _, _, _, _, hd0, he0 = system_at(y, coef, lane)
        coef[at.MU * WIDTH + lane] = mu
        share_d, share_e, low_d, low_e, high_d, high_e = 1.0, 1.0, 0.0, 0.0, 1.0, 1.0
        a = a1
        for _ in range(40):
            a = (
                a0[0] + share_d * (a1[0] - a0[0]), a0[1] + share_e * (a1[1] - a0[1]),
                a0[2] + share_d * (a1[2] - a0[2]), a0[3] + share_e * (a1[3] - a0[3]),
            )  # fmt: skip
            l_d, l_e, _ = impulses(a, b_d, b_e, on_d, on_e)
            pd, pe = blend(pd0, pd1, share_d), blend(pe0, pe1, share_e)
            after_d, after_e = (
                dot(y, coef, lane, hd1) - dot(y, coef, lane, hd0),
                dot(y, coef, lane, he1) - dot(y, coef, lane, he0),
            )
            for c in range(5):
                change = l_d * pd[c] + l_e * pe[c]
                after_d += (hd1[c] - hd0[c]) * change
                after_e += (he1[c] - he0[c]) * change
            turns_d, turns_e = l_d > 0.0 and after_d > 0.0, l_e > 0.0 and after_e > 0.0
            if share_d == 1.0 and share_e == 1.0 and not turns_d and not turns_e:
                break
            low_d, high_d = (low_d, share_d) if turns_d else (share_d, high_d)
            low_e, high_e = (low_e, share_e) if turns_e else (share_e, high_e)
            share_d, share_e = 0.5 * (low_d + high_d), 0.5 * (low_e + high_e)
        return (
            blend(pd0, pd1, share_d), blend(pe0, pe1, share_e), a, blend(hd0, hd1, share_d), blend(he0, he1, share_e),
        )  # fmt: skip

    @device
    def blow(y, coef, lanes, on_d, on_e, back, hits, lane):
        """The impact itself, if it ``hits``: (D can stay, E can stay, whether anything was struck, whether all leave).

        ``back``: of a contact that has left the wall and falls back at once, which hits it only with a speed from above the
        height of rest.
        """
        when = lanes[at.T * WIDTH + lane]
        _, pd, pe, a, acc, _, rate, q, _, _, hd, he = system(y, coef, lane, WIDTH)
        bounce, rest_height = coef[at.BOUNCE * WIDTH + lane], coef[at.REST_HEIGHT * WIDTH + lane]
        # A closed contact has no speed along its normal but rounding.
        g_d = 0.0 if coef[at.CLOSED_D * WIDTH + lane] > 0.0 else rate[0]
        g_e = 0.0 if coef[at.CLOSED_E * WIDTH + lane] > 0.0 else rate[1]
        b_d, b_e = g_d + bounce * min(g_d, 0.0), g_e + bounce * min(g_e, 0.0)
        if rubs:
            pd, pe, a, hd, he = held_back(y, coef, lane, b_d, b_e, on_d, on_e)
        l_d, l_e, missed = impulses(a, b_d, b_e, on_d, on_e)
        l_d, l_e = l_d if hits else 0.0, l_e if hits else 0.0
        struck(y, coef, lanes, l_d, l_e, pd, pe, hd, he, lane)
        least_d = math.sqrt(2.0 * rest_height * abs(acc[0])) if back else 0.0
        least_e = math.sqrt(2.0 * rest_height * abs(acc[1])) if back else 0.0
        tally(coef, lanes, 0, q[0], l_d, -g_d, a[0], least_d, on_d, hits, lane)
        tally(coef, lanes, 1, q[1], l_e, -g_e, a[3], least_e, on_e, hits, lane)
        any_hit = ((l_d > 0.0) & ((-g_d > least_d) | (not back))) | ((l_e > 0.0) & ((-g_e > least_e) | (not back)))
        first = lanes[at.HIT_AT * WIDTH + lane]
        lanes[at.HIT_AT * WIDTH + lane] = when if any_hit & (first != first) else first
        after_d, after_e = g_d + a[0] * l_d + a[1] * l_e, g_e + a[2] * l_d + a[3] * l_e
        small = 1e-12 * (abs(g_d) + abs(g_e))
        # Whether every contact that was hit leaves so fast that none can come to rest: no need to look again.
        least = _FAR_ABOVE * rest_height * (abs(acc[0]) + abs(acc[1]) + g_d * g_d + g_e * g_e)
        leaves = (not on_d) | ((after_d > 0.0) & (after_d * after_d > least))
        leaves &= (not on_e) | ((after_e > 0.0) & (after_e * after_e > least))
        status = lanes[at.STATUS * WIDTH + lane]
        wrong = hits & (missed > 1e-9 * (abs(g_d) + abs(g_e)))
        lanes[at.STATUS * WIDTH + lane] = at.NO_SOLUTION if wrong else status
        return on_d & (after_d <= small), on_e & (after_e <= small), any_hit, leaves

    @device
    def tally(coef, lanes, side, q, multiplier, rate_in, own, least, on, hits, lane):
        """What one end's impact adds to its statistics, and what is said of it as an event."""
        impulse, speed = q * multiplier, rate_in / q if unit else rate_in
        strikes = impulse > 0.0
        # A contact that rests on the wall and is pressed by the other's blow has not hit it.
        lanes[(at.COUNT_D + side) * WIDTH + lane] += 1.0 if strikes & (rate_in > least) else 0.0
        fastest = lanes[(at.SPEED_D + side) * WIDTH + lane]
        lanes[(at.SPEED_D + side) * WIDTH + lane] = max(fastest, speed) if strikes else fastest
        largest = lanes[(at.IMPULSE_D + side) * WIDTH + lane]
        lanes[(at.IMPULSE_D + side) * WIDTH + lane] = max(largest, impulse) if strikes else largest
        lanes[(at.TOTAL_D + side) * WIDTH + lane] += impulse
        # The square of the approach speed times the mass that it carries, for the peak of Hertz' force.
        energy, largest = (
            coef[at.ENERGY * WIDTH + lane] * rate_in * rate_in / own,
            lanes[(at.PEAK_D + side) * WIDTH + lane],
        )
        lanes[(at.PEAK_D + side) * WIDTH + lane] = max(largest, energy) if strikes & (speed > 0.0) else largest
        row = (at.LAST_EVENT + at.E_IMPULSE_D + side) * WIDTH + lane
        lanes[row] = coef[at.FORCE * WIDTH + lane] * impulse if hits else lanes[row]
        row = (at.LAST_EVENT + at.E_SPEED_D + side) * WIDTH + lane
        lanes[row] = (coef[at.C * WIDTH + lane] * max(speed, 0.0) if on else 0.0) if hits else lanes[row]
        row = (at.LAST_EVENT + at.E_D + side) * WIDTH + lane
        lanes[row] = (1.0 if on else 0.0) if hits else lanes[row]

    @device
    def struck(y, coef, lanes, l_d, l_e, pd, pe, hd, he, lane):
        """Impulses change the speeds; what they take is counted: minus half the sum of the speeds times them."""
        lost = -l_d * dot(y, coef, lane, hd) - l_e * dot(y, coef, lane, he)
        kick(y, l_d, l_e, pd, pe, coef, lane, WIDTH)
        lost -= l_d * dot(y, coef, lane, hd) + l_e * dot(y, coef, lane, he)
        lanes[at.IMPACT_LOSS * WIDTH + lane] += 0.5 * lost
        if rubs:
            drive = (l_d * pd[5] + l_e * pe[5]) / coef[at.KAPPA * WIDTH + lane]
            lanes[at.DRIVE_INTEGRAL * WIDTH + lane] += drive
            lanes[at.WORK * WIDTH + lane] += drive * y[at.SPIN_RATE * WIDTH + lane]
            lanes[at.DRIVE_WORK * WIDTH + lane] += drive * y[at.SPIN_RATE * WIDTH + lane]

    @device
    def on_the_wall(coef, lanes, seen, side, lane):
        """Whether a contact takes part in an impact: those closed, and those that come to the wall."""
        gap, rate = seen[(at.GAP_D + side) * WIDTH + lane], seen[(at.RATE_D + side) * WIDTH + lane]
        armed = lanes[(at.ARMED_D + side) * WIDTH + lane] > 0.0
        # A contact that has just left the wall, and is there still, takes part whatever its speed.
        comes = (gap <= TOGETHER) & ((rate < 0.0) | (not armed))
        return (coef[(at.CLOSED_D + side) * WIDTH + lane] > 0.0) | comes

    @routine
    def strike(y, coef, lanes, seen0, until, decision, calls):
        """Impacts without friction in lanes whose decision is IMPACT, at times before ``until``.

        Those whose contacts all leave the wall are through with it, and need no call; returns how many they are.
        """
        meet, count = 0, 0
        for lane in range(WIDTH):
            hits = (decision[lane] == at.IMPACT) & (lanes[at.T * WIDTH + lane] < until)
            on_d, on_e = (
                hits & on_the_wall(coef, lanes, seen0, 0, lane),
                hits & on_the_wall(coef, lanes, seen0, 1, lane),
            )
            lanes[at.HITS * WIDTH + lane] = 1.0 if hits else 0.0
            lanes[at.ON_THE_WALL_D * WIDTH + lane] = 1.0 if on_d else 0.0
            lanes[at.ON_THE_WALL_E * WIDTH + lane] = 1.0 if on_e else 0.0
            meet += on_d & on_e
        if meet > 0:
            # One contact alone is where its gap is zero; two are there to no more than TOGETHER.
            for lane in range(WIDTH):
                both = (lanes[at.ON_THE_WALL_D * WIDTH + lane] > 0.0) & (lanes[at.ON_THE_WALL_E * WIDTH + lane] > 0.0)
                place_lane(y, coef, both, both, lane, WIDTH)
        # Loops by themselves: with more arrays that are written, LLVM's alias checks exceed their limit.
        for lane in range(WIDTH):
            on_d, on_e = lanes[at.ON_THE_WALL_D * WIDTH + lane] > 0.0, lanes[at.ON_THE_WALL_E * WIDTH + lane] > 0.0
            hits = lanes[at.HITS * WIDTH + lane] > 0.0
            can_d, can_e, strikes, leaves = blow(y, coef, lanes, on_d, on_e, False, hits, lane)
            lanes[at.CAN_STAY_D * WIDTH + lane] = 1.0 if can_d else 0.0
            lanes[at.CAN_STAY_E * WIDTH + lane] = 1.0 if can_e else 0.0
            lanes[at.STRUCK * WIDTH + lane] = 1.0 if strikes else 0.0
            lanes[at.LEAVES * WIDTH + lane] = 1.0 if leaves & hits else 0.0
        for lane in range(WIDTH):
            leaves, armed = lanes[at.LEAVES * WIDTH + lane] > 0.0, lanes[at.STRUCK * WIDTH + lane]
            lanes[(at.LAST_EVENT + at.E_TIME) * WIDTH + lane] = lanes[at.T * WIDTH + lane]
            lanes[(at.LAST_EVENT + at.E_KIND) * WIDTH + lane] = 2.0 - 2.0 * armed
            for side in range(2):
                coef[(at.CLOSED_D + side) * WIDTH + lane] = 0.0 if leaves else coef[(at.CLOSED_D + side) * WIDTH + lane]
                met = leaves & (lanes[(at.ON_THE_WALL_D + side) * WIDTH + lane] > 0.0)
                lanes[(at.ARMED_D + side) * WIDTH + lane] = armed if met else lanes[(at.ARMED_D + side) * WIDTH + lane]
            lost = lanes[at.LOST_AT * WIDTH + lane]
            lanes[at.LOST_AT * WIDTH + lane] = lanes[at.T * WIDTH + lane] if leaves & (lost != lost) else lost
            lanes[at.EVENTS * WIDTH + lane] += 1.0 if leaves else 0.0
            lanes[at.TRIES * WIDTH + lane] = 0.0 if leaves else lanes[at.TRIES * WIDTH + lane]
            calls[lane] = 0 if leaves else calls[lane]
            count += leaves
        return count

    @routine
    def settle(y, coef, lanes, lane):
        """What becomes of the contacts of a lane that :func:`strike` has struck and not all of whose contacts leave."""
        on_d, on_e = lanes[at.ON_THE_WALL_D * WIDTH + lane] > 0.0, lanes[at.ON_THE_WALL_E * WIDTH + lane] > 0.0
        can_d, can_e = lanes[at.CAN_STAY_D * WIDTH + lane] > 0.0, lanes[at.CAN_STAY_E * WIDTH + lane] > 0.0
        strikes, settles = lanes[at.STRUCK * WIDTH + lane] > 0.0, coef[at.BOUNCE * WIDTH + lane] < 1.0
        staying(y, coef, lanes, on_d, on_e, can_d, can_e, strikes, settles, lane)

    @routine
    def jump(y, coef, lanes, seen0, lane, kind):
        """What happens at an event: impact or release, then which contacts stay closed, until nothing changes."""
        was_d, was_e = coef[at.CLOSED_D * WIDTH + lane] > 0.0, coef[at.CLOSED_E * WIDTH + lane] > 0.0
        on_d, on_e = was_d, was_e
        back = kind == at.FALL_BACK_D or kind == at.FALL_BACK_E
        hits = kind == at.IMPACT or kind == at.START
        if hits:
            on_d, on_e = on_the_wall(coef, lanes, seen0, 0, lane), on_the_wall(coef, lanes, seen0, 1, lane)
        if back:
            on_d, on_e = on_d or kind == at.FALL_BACK_D, on_e or kind == at.FALL_BACK_E
            lanes[at.HOLD * WIDTH + lane] = 1.0
        if on_d or on_e:
            if hits or back:
                place(y, coef, on_d, on_e, lane)
            else:
                project(y, coef, on_d, on_e, lane)
        for row in range(at.LAST_EVENT, at.LAST_EVENT + at.EVENT):
            lanes[row * WIDTH + lane] = 0.0
        lanes[(at.LAST_EVENT + at.E_TIME) * WIDTH + lane] = lanes[at.T * WIDTH + lane]
        log_kind, log_d = (at.LAST_EVENT + at.E_KIND) * WIDTH + lane, (at.LAST_EVENT + at.E_D) * WIDTH + lane
        can_d, can_e = on_d, on_e
        bounce = coef[at.BOUNCE * WIDTH + lane]
        settles, strikes = hits and bounce < 1.0, hits
        if hits or back:
            can_d, can_e, strikes, _ = blow(y, coef, lanes, on_d, on_e, back, True, lane)
            lanes[log_kind] = 0.0 if strikes else 2.0
            settles = settles or (back and (bounce < 1.0 or not strikes))
        else:
            can_d, can_e = can_d and kind == at.RELEASE_E, can_e and kind == at.RELEASE_D
            lanes[log_kind] = 1.0
            lanes[log_d] = 1.0 if was_d and not can_d else 0.0
            lanes[log_d + WIDTH] = 1.0 if was_e and not can_e else 0.0
        staying(y, coef, lanes, on_d, on_e, can_d, can_e, strikes, settles, lane)

    @routine
    def staying(y, coef, lanes, on_d, on_e, can_d, can_e, strikes, settles, lane):
        """Which contacts stay closed of those that can; if it ``settles``, also those that would next to not bounce."""
        d, e, wrong = False, False, False
        for _ in range(3):
            if can_d or can_e:
                project(y, coef, can_d, can_e, lane)
            _, pd, pe, a, acc, _, rate, q, _, _, hd, he = system_at(y, coef, lane)
            d, e, missed = stays(a, acc, can_d, can_e)
            wrong = wrong or missed > 1e-6 * (abs(acc[0]) + abs(acc[1]))
            l_d, l_e = brought_to_rest(a, acc[0], acc[1], d, e)
            acc_d, acc_e = acc[0] + a[0] * l_d + a[1] * l_e, acc[1] + a[2] * l_d + a[3] * l_e
            height = coef[at.REST_HEIGHT * WIDTH + lane]
            rest_d = settles and on_d and not can_d and acc_d < 0.0 and rate[0] * rate[0] < -2.0 * height * acc_d
            rest_e = settles and on_e and not can_e and acc_e < 0.0 and rate[1] * rate[1] < -2.0 * height * acc_e
            if not (rest_d or rest_e):
                break
            can_d, can_e = can_d or rest_d, can_e or rest_e
            l_d, l_e = brought_to_rest(a, rate[0], rate[1], can_d, can_e)
            struck(y, coef, lanes, l_d, l_e, pd, pe, hd, he, lane)
            # It stands for the bounces left out: with the force of a contact that is closed a little too early it comes to the
            # same impulse as they do.
            lanes[at.TOTAL_D * WIDTH + lane] += q[0] * l_d
            lanes[at.TOTAL_E * WIDTH + lane] += q[1] * l_e
        coef[at.CLOSED_D * WIDTH + lane], coef[at.CLOSED_E * WIDTH + lane] = 1.0 if d else 0.0, 1.0 if e else 0.0
        # A contact that stays open without a speed of its own has to open first.
        if on_d:
            lanes[at.ARMED_D * WIDTH + lane] = 0.0 if can_d or not strikes else 1.0
        if on_e:
            lanes[at.ARMED_E * WIDTH + lane] = 0.0 if can_e or not strikes else 1.0
        if math.isnan(lanes[at.LOST_AT * WIDTH + lane]) and not (d and e):
            lanes[at.LOST_AT * WIDTH + lane] = lanes[at.T * WIDTH + lane]
            if coef[at.BOUNCE * WIDTH + lane] < 0.0:
                lanes[at.STATUS * WIDTH + lane] = at.LOST
        if wrong:
            lanes[at.STATUS * WIDTH + lane] = at.NO_SOLUTION
        lanes[at.EVENTS * WIDTH + lane] += 1.0

    @routine
    def struck_one_by_one(y, coef, lanes, seen0, until, decision, calls):
        """Impacts with friction are left to :func:`jump`."""
        return 0

    return Jump(jump, struck_one_by_one if rubs else strike, settle)
