"""What became of a sample: its status, from the kernels' code and from what the numbers themselves say."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from tolmc.kernels import parameters as P
from tolmc.kernels import results as R
from tolmc.quantities import CHECKS
from tolmc.simulation.outputs import ROWS, present
from tolmc.simulation.plan import Plan

# Codes of a sample's status; the first three are the kernels' own.
INACCURATE = 3
GEOMETRY_INVALID = 4
BODY_INVALID = 5
SINGULAR_PSI = 6
SINGULAR_TILT = 7
SINGULAR_THETA = 8
#: Every status in words, in the order of the codes.
STATUSES = (
    "ok",
    "contact lost",
    "diverged",
    "inaccurate",
    "geometry invalid",
    "body invalid",
    "singular: psi = k pi/2",
    "singular: X0 = Y0 = 0",
    "singular: theta = 0",
    "too many impacts",
    "contact unresolved",
    "no contact forces",
)


def difference(coarse: np.ndarray, fine: np.ndarray, radius: np.ndarray, forces: bool) -> np.ndarray:
    """Relative difference of two results, a number a sample: end of the motion, energy, and forces if there are any."""
    end = slice(R.ORIGIN_X, R.ORIGIN_Y + 1)
    axis = slice(R.AXIS_X, R.AXIS_Z + 1)
    worst = np.maximum(
        np.abs(coarse[end] - fine[end]).max(axis=0) / radius, np.abs(coarse[axis] - fine[axis]).max(axis=0)
    )
    worst = np.maximum(worst, coarse[R.ENERGY_ERROR])
    if forces:
        # Where one of the two loses contact and the other just not, their statistics do not measure the integration.
        same = coarse[R.STATUS] == fine[R.STATUS]
        worst = np.where(same, np.maximum(worst, difference_of_statistics(coarse, fine)), worst)
    return np.where(np.isfinite(worst), worst, np.inf)


def difference_of_statistics(coarse: np.ndarray, fine: np.ndarray) -> np.ndarray:
    """Largest difference of tilts, and of contact forces relative to the largest, a number a sample."""
    forces = slice(R.D_MAX, R.E_RMS + 1)
    force, scale = np.abs(coarse[forces] - fine[forces]).max(axis=0), np.maximum(fine[R.D_MAX], fine[R.E_MAX])
    force = np.divide(force, scale, out=np.zeros_like(force), where=scale > 0)
    return np.maximum(np.abs(coarse[R.TILT_MAX] - fine[R.TILT_MAX]), force)


def one_sided_difference(coarse: np.ndarray, fine: np.ndarray, radius: np.ndarray, plan: Plan) -> np.ndarray:
    """Relative difference of two results with one-sided contact, a number a sample: end of the motion, tilt, mean forces.

    With friction also of its work, and of the spin rate at the end where no drive says it.
    """
    end, axis = slice(R.ORIGIN_X, R.ORIGIN_Y + 1), [R.AXIS_X, R.AXIS_Y, R.AXIS_Z, R.TILT_MAX]
    worst = np.abs(coarse[end] - fine[end]).max(axis=0) / radius
    worst = np.maximum(worst, np.abs(coarse[axis] - fine[axis]).max(axis=0))
    means = [R.D_MEAN, R.E_MEAN]
    scale = np.abs(fine[means]).max(axis=0)
    load = np.abs(coarse[means] - fine[means]).max(axis=0)
    worst = np.maximum(worst, np.divide(load, scale, out=np.zeros_like(load), where=scale > 0))
    if plan.features.rubs:
        for row in (R.FRICTION_WORK,) if plan.features.driven else (R.FRICTION_WORK, R.SPIN_END):
            change, scale = np.abs(coarse[row] - fine[row]), np.abs(fine[row])
            worst = np.maximum(worst, np.divide(change, scale, out=np.zeros_like(change), where=scale > 0))
    return np.where(np.isfinite(worst) & (coarse[R.STATUS] == fine[R.STATUS]), worst, np.inf)


def judged(code: np.ndarray, results: np.ndarray, raw: np.ndarray, plan: Plan, forces: bool) -> np.ndarray:
    """Codes of integrated samples whose numbers have been looked at; those that have no statistics lose them.

    Diverged: a number that is not finite. Inaccurate: an invariant or the step-halving difference above the accuracy, or
    statistics that contradict each other or the joint by more than it.
    """
    code = code.copy()
    checks = [ROWS[row.name] for row in present(plan, "integration")] + ([R.HALVING_ERROR] if plan.halving else [])
    statistics = present(plan, "statistics")
    worst = np.maximum.reduce([results[row] for row in checks])
    finite = np.isfinite(worst)
    if forces:
        numbers = [ROWS[row.name] for row in statistics if not row.event]
        one_sided = plan.features.one_sided or plan.features.rubs
        untouched = _untouched(results) if one_sided else {}
        finite &= np.logical_and.reduce([np.isfinite(results[row]) | untouched.get(row, False) for row in numbers])
        always = ~_has_left(results) if one_sided else np.ones(len(code), bool)
        worst = np.maximum(worst, _contradiction(results, raw, always))
    good = finite & (worst <= plan.accuracy)
    if not good.all():
        whole = code <= R.CONTACT_LOST
        code[whole & ~finite] = R.DIVERGED
        code[whole & finite & ~good] = INACCURATE
    # A motion that has left the numbers' range or the coordinates' domain has no statistics.
    without = (code == R.DIVERGED) | (code >= SINGULAR_PSI)
    if without.any():
        results[np.ix_([ROWS[row.name] for row in statistics], without)] = np.nan
    return code


def _untouched(results: np.ndarray) -> dict[int, np.ndarray]:
    """Rows that closed contact alone fills, and in which samples there was none."""
    never = {R.D_MAX: results[R.D_CLOSED_SHARE] == 0, R.E_MAX: results[R.E_CLOSED_SHARE] == 0}
    apart = (results[R.D_CLOSED_SHARE] == 0) & (results[R.E_CLOSED_SHARE] == 0)
    return {first + place: where for first, where in never.items() for place in (0, 1, 3)} | {R.WHIRL_RATE_MEAN: apart}


def _has_left(results: np.ndarray) -> np.ndarray:
    """Samples whose journal is not on the wall at both ends all the time."""
    return (results[R.D_CLOSED_SHARE] < 1) | (results[R.E_CLOSED_SHARE] < 1) | ~np.isnan(results[R.FIRST_IMPACT])


def _contradiction(results: np.ndarray, raw: np.ndarray, always: np.ndarray) -> np.ndarray:
    """By how much min <= mean <= max, |mean| <= rms <= max |N| and tilt_max <= tilt_angle are missed, relative.

    ``always``: whether contact holds all the time; else a mean with impulses and a largest force of closed contact do not
    belong together.
    """
    miss = results[R.TILT_MAX] - np.arctan2(raw[P.RADIUS], raw[P.HALF_LENGTH])
    # Relative to the larger rms of the two ends: a force that is 0 has nothing but rounding to compare. Not to the largest
    # force: where a motion is not resolved that may be anything, and beside it nothing is much.
    usual = results[[R.D_RMS, R.E_RMS]].max(axis=0)
    usual = np.where(usual > 0, usual, np.abs(results[[R.D_MAX, R.D_MIN, R.E_MAX, R.E_MIN]]).max(axis=0))
    compared = always & (usual > 0)
    for first in (R.D_MAX, R.E_MAX):
        highest, lowest, mean, rms = results[first : first + 4]
        beyond = rms - np.maximum(np.abs(highest), np.abs(lowest))
        excess = np.maximum.reduce([mean - highest, lowest - mean, beyond, np.abs(mean) - rms])
        miss = np.maximum(miss, np.divide(excess, usual, out=np.zeros_like(excess), where=compared))
    return miss


def leaves(summary: Mapping[str, np.ndarray]) -> bool:
    """Whether one motion leaves the wall, or starts away from it."""
    return not (summary["closed_share_D"][0] == 1.0 and summary["closed_share_E"][0] == 1.0)


def sentence(summary: Mapping[str, np.ndarray], plan: Plan) -> str:
    """Status of one motion in words, with the time where there is one."""
    status, at = STATUSES[summary["status"][0]], summary["status_time"][0]
    if status == "inaccurate":
        name = max((name for name in CHECKS if name in summary), key=lambda name: summary[name][0])
        if summary[name][0] > plan.accuracy:
            return f"inaccurate: {name.replace('_', ' ')} {summary[name][0]:.1e} above {plan.accuracy:.1e}"
        return f"inaccurate: a shorter step changes the results by more than {plan.accuracy:.1e}, or they contradict each other"
    if status == "ok" or math.isnan(at):
        return status
    if status.startswith("singular: "):
        return f"singular at t = {at:.9g} s: {status.removeprefix('singular: ')}"
    return f"{status} at t = {at:.9g} s"
