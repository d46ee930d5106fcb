"""The choice of step and method: a pilot integrates the nominal and the corner dimensions with n and 2 n steps."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from tolmc.kernels import parameters as P
from tolmc.kernels import results as R
from tolmc.kernels.tableaux import TABLEAUX
from tolmc.mechanism.checks import choice, positive_number
from tolmc.mechanism.scene import Scene
from tolmc.quantities import ON_CONTACT_LOSS, SCALARS
from tolmc.simulation.features import Features, features_of
from tolmc.simulation.integration import WIDTH, integrate
from tolmc.simulation.judge import GEOMETRY_INVALID, difference, one_sided_difference
from tolmc.simulation.one_sided import agreeing_impacts, has_room
from tolmc.simulation.outputs import wants_forces, wants_pose
from tolmc.simulation.packing import pack
from tolmc.simulation.plan import (
    COARSE_ACCURACY,
    DEFAULT_ACCURACY,
    FORMULATIONS,
    METHODS,
    Plan,
    step_count,
    step_seconds,
)

_MOST_STEPS = 2_000_000
_PATIENCE = 6  # halvings of the step without gain after which the pilot gives a motion up
_FAR_FASTER = 64  # how much faster than the middle one a motion may be for the pilot to follow it
_EXACT_BALANCE = 1e-12  # energy error of a motion whose steps cannot be shortened with any gain
_PATIENCE_AT_ROUNDING = 2  # the same patience with a motion whose energy error is there
_REST_BALANCE = 1e-10  # energy error that contacts leave that come to rest from 1e-11 of the clearance, at any step
_HELP = 4.0  # by how much half the step lessens the error of a motion with impacts where it still helps
_IN_ORDER = 1e-2  # error below which it falls as the method's order says
#: What the pilot may take of the run that it serves, and what in any case.
_OF_RUN, _SECONDS = 0.1, 2.0
# Shares of the duration at which chaotic motions are asked whether they still agree.
_SHARES = 2.0 ** np.arange(-8.0, 0.0, 0.5)
#: Share of the accuracy to which the energy of motions with friction, drives and loads that swing is kept.
_BALANCE_SHARE = 0.01
_PILOT_SHARE = 0.3  # the pilot aims below the stated accuracy, for samples between its corners
_TELLING = 1e-2  # share of the aim from which on an error tells how errors grow: below it is rounding
_ROOM = 2.0  # how much rougher than any of the pilot's a sample's step may be, however errors grow


def _first_guess(raw: np.ndarray, duration: float) -> np.ndarray:
    """Steps for half a radian of the fastest of a motion's rates: polar rates, pendulum and gyroscopic frequency; (n,)."""
    r, mass = raw[P.RADIUS], raw[P.MASS]
    load = sum(
        np.abs(mass * raw[P.GRAVITY_X + i] + raw[P.FORCE_X + i]) + np.abs(raw[P.TORQUE_X + i]) / raw[P.HALF_LENGTH]
        for i in range(3)
    )
    transverse = np.minimum(raw[P.J_XX], raw[P.J_YY]) + 1e-3 * mass * raw[P.HALF_LENGTH] ** 2
    rate = np.maximum(np.abs(raw[P.ALPHA_RATE]), np.abs(raw[P.BETA_RATE])) + np.sqrt(load / (mass * r))
    rate = rate + np.abs(raw[P.J_ZZ] * raw[P.SPIN_RATE]) / transverse
    rate = rate + np.hypot(raw[P.ORIGIN_RATE_X], raw[P.ORIGIN_RATE_Y]) / r
    rate = rate + np.hypot(raw[P.SLOPE_RATE_X], raw[P.SLOPE_RATE_Y]) * raw[P.HALF_LENGTH] / r
    swings = (P.FORCE_TERM_1_FREQUENCY, P.FORCE_TERM_2_FREQUENCY, P.TORQUE_TERM_1_FREQUENCY, P.TORQUE_TERM_2_FREQUENCY)
    rate = rate + 2.0 * math.pi * np.max([raw[row] for row in (*swings, P.DRIVE_FREQUENCY)], axis=0)
    steps = np.where(np.isfinite(rate), 0.5 * rate * duration, 0.0)
    return np.ceil(np.clip(steps, 4.0, _MOST_STEPS // 4))


@dataclass
class _Bound:
    """What a pilot may take: a tenth of the run of so many ``samples`` that it serves, or two seconds, whichever is more."""

    samples: int
    spent: float = 0.0

    def take(self, plan: Plan, motions: int) -> None:
        """Count what ``motions`` cost by the plan."""
        self.spent += _work(plan, motions)

    def allows(self, plan: Plan, motions: int) -> bool:
        """Whether ``motions`` may be run once more, with four times the steps of a plan that the samples would then keep."""
        run = self.samples * plan.steps * step_seconds(plan.features)
        spent = self.spent + 4 * _work(plan, motions)
        return 4 * plan.steps <= _MOST_STEPS and spent <= max(_SECONDS, _OF_RUN * run)


def _work(plan: Plan, motions: int) -> float:
    """What motions cost, s: they run in whole calls of the kernels' lanes."""
    return plan.steps * -(-motions // WIDTH) * WIDTH * step_seconds(plan.features)


def _pilot(raw, draft: Plan, forces, duration, on_contact_loss, project_energy, bound: _Bound) -> Plan:
    """``draft`` with the fewest steps with which every column of ``raw`` meets its accuracy by step halving.

    A column whose error falls no further however short the step, or whose motion is far faster than the others' (a clearance
    of a few roundings, say), is set aside and counted as unresolved; so is what has not met the accuracy when the pilot has
    reached its ``bound``. Nothing is begun again without it: the steps are those with which the last of the others met it, or,
    where none did, those with which most came nearest; or, at the bound, what the order of the method makes of the errors.
    """
    target = _PILOT_SHARE * draft.accuracy
    order = TABLEAUX[draft.method].order

    def results(steps: int, columns: np.ndarray, share: float = 1.0) -> np.ndarray:
        plan = replace(draft, steps=steps)
        bound.take(plan, len(columns))
        inside = np.ascontiguousarray(raw[:, columns])
        return integrate(inside, plan, forces, share * duration, on_contact_loss, project_energy)

    guesses = _first_guess(raw, duration)
    left = np.flatnonzero(guesses <= _FAR_FASTER * np.median(guesses))
    steps, count = int(guesses[left].max()), raw.shape[1]
    met, met_error, is_chaotic = np.zeros(count, int), np.full(count, np.inf), np.zeros(count, bool)
    of_step = np.full(count, np.nan)
    nearest, best_steps, ended, asked = np.inf, steps, False, 0
    stalled, best = np.zeros(len(left), int), np.full(len(left), np.inf)
    coarse = results(steps, left)
    while True:
        fine = results(2 * steps, left)
        errors = difference(coarse, fine, raw[P.RADIUS, left], forces)
        good = errors <= target
        first = good & (met[left] == 0)
        met[left[first]] = steps
        met_error[left] = np.where(good, errors, met_error[left])
        of_step[left] = np.where(good, np.maximum(coarse[R.ROUGHEST], coarse[R.DOUBT]), of_step[left])
        if np.median(errors) < nearest:
            nearest, best_steps = float(np.median(errors)), steps
        if good.all():
            break
        stalled = np.where(good | (errors < 0.5 * best), 0, stalled + 1)
        best = np.minimum(best, errors)
        exact = coarse[R.ENERGY_ERROR] <= _EXACT_BALANCE
        hopeless = stalled > np.where(exact, _PATIENCE_AT_ROUNDING, _PATIENCE)
        ended = not bound.allows(replace(draft, steps=steps), len(left))
        is_chaotic[left] = exact & ((stalled > 0) if ended else hopeless)
        if ended:
            slower = errors[~good & ~is_chaotic[left] & (errors < _IN_ORDER)]
            asked = _by_order(steps, slower.max(initial=0.0), target, order)
        kept = good if ended else ~hopeless
        left, errors, stalled, best = left[kept], errors[kept], stalled[kept], best[kept]
        if not len(left) or (errors <= target).all():
            break
        coarse, fine = coarse[:, kept], fine[:, kept]
        # Within the range where the order holds, go straight to the number of steps that it asks for.
        wanted = _by_order(steps, float(errors.max()), target, order) if errors.max() < _IN_ORDER else 2 * steps
        if wanted < 2 * steps:
            steps = max(wanted, steps + 1)
            coarse = results(steps, left)
            continue
        steps, coarse = 2 * steps, fine
    found = replace(
        draft,
        unresolved=count - len(left),
        bounded=ended and len(left) + int(is_chaotic.sum()) < count,
        agrees_until=_agreement(results, raw, draft, forces, duration, np.flatnonzero(is_chaotic), steps // 4),
    )
    if not len(left):
        return replace(found, steps=max(best_steps, asked), pilot_error=nearest)
    found = replace(found, growth=_growth(met_error[left], of_step[left], draft.accuracy))
    return replace(found, steps=max(int(met[left].max()), asked), pilot_error=float(met_error[left].max()))


def _growth(errors: np.ndarray, of_step: np.ndarray, accuracy: float) -> float:
    """By how much more the statistics of motions err than their roughest step, at most; NaN where no error tells it."""
    tells = (errors > _TELLING * _PILOT_SHARE * accuracy) & (of_step > 0.0)
    if not tells.any():
        return math.nan
    return min(float((errors[tells] / of_step[tells]).max()), accuracy / (_ROOM * float(of_step.max())))


def _by_order(steps: int, error: float, target: float, order: int) -> int:
    """The steps with which an error that falls as the method's order says meets the target."""
    return min(math.ceil(1.05 * steps * (error / target) ** (1 / order)), _MOST_STEPS)


def _agreement(
    results: Callable[..., np.ndarray], raw, draft: Plan, forces, duration: float, columns: np.ndarray, steps: int
) -> float:
    """Until when (s) the motions of these columns agree with twice the steps; NaN without any, or where they never do."""
    if not len(columns):
        return math.nan
    agrees = math.nan
    for share in _SHARES:
        part = max(1, round(share * steps))
        coarse, fine = (results(n, columns, share) for n in (part, 2 * part))
        if not (difference(coarse, fine, raw[P.RADIUS, columns], forces) <= draft.accuracy).all():
            break
        agrees = share * duration
    return agrees


def _balanced(steps: int, balance: np.ndarray, draft: Plan) -> int:
    """Steps with which motions whose energy balance misses by ``balance`` keep it to a hundredth of the accuracy."""
    worst, order = float(balance.max(initial=0.0)), TABLEAUX[draft.method].order
    return max(steps, _by_order(steps, worst, _BALANCE_SHARE * draft.accuracy, order))


def _pilot_one_sided(raw, draft: Plan, forces, duration, bound: _Bound) -> Plan:
    """The same where the wall only pushes.

    Impacts amplify what a step leaves: after enough of them halved steps part company however short they are. A motion is
    therefore judged by halving while that helps, and by its energy balance alone where it does not and the balance is at
    rounding; how many motions are of the second kind is ``chaotic``, and up to which impact the first of them agrees
    ``agreeing_impacts``.
    """
    target, count = _PILOT_SHARE * draft.accuracy, raw.shape[1]

    def results(steps: int) -> np.ndarray:
        plan = replace(draft, steps=steps)
        bound.take(plan, count)
        return integrate(raw, plan, forces, duration, "stop", False)

    steps = int(_first_guess(raw, duration).max())
    # Of every motion: the steps that are enough, by halving or by its balance alone, and the error there.
    enough, error = np.full(count, _MOST_STEPS), np.full(count, np.inf)
    before, balance_before = np.full(count, np.inf), np.full(count, np.inf)
    known, by_balance, helps = (np.zeros(count, bool) for _ in range(3))
    coarse = results(steps)
    while True:
        fine = results(2 * steps)
        errors = one_sided_difference(coarse, fine, raw[P.RADIUS], draft)
        balance = np.where(np.isfinite(coarse[R.ENERGY_ERROR]), coarse[R.ENERGY_ERROR], np.inf)
        meets = ~known & (errors <= target) & (balance <= target)
        stays = (balance <= _REST_BALANCE) & (balance > balance_before / _HELP)
        first = ~known & ~meets & ~by_balance & ((balance <= _EXACT_BALANCE) | stays)
        known, by_balance = known | meets, (by_balance & ~meets) | first
        helps = by_balance & (errors < before / _HELP)
        before, balance_before = errors, balance
        better = meets | first | helps
        enough, error = np.where(better, steps, enough), np.where(better, np.where(meets, errors, balance), error)
        is_judged = bool((known | (by_balance & ~helps)).all())
        if is_judged or not bound.allows(replace(draft, steps=steps), count):
            break
        steps, coarse = 2 * steps, fine
    judged = known | by_balance
    error = np.where(judged, error, balance)
    steps = int(enough.max()) if judged.all() else steps
    if draft.features.rubs:
        steps = _balanced(steps, balance[known], draft)
    found = replace(
        draft, steps=steps, pilot_error=float(error.max()), unresolved=int((~judged).sum()),
        chaotic=int(by_balance.sum()), bounded=not is_judged,
    )  # fmt: skip
    amplified = np.flatnonzero(by_balance)[:1]
    agreeing = (
        agreeing_impacts(raw[:, amplified], found, duration) if len(amplified) and draft.features.one_sided else -1
    )
    return replace(found, agreeing_impacts=agreeing)


def _corners(scene: Scene, bounds: Mapping[str, tuple[float, float]]) -> dict[str, np.ndarray]:
    """The nominal sample and the corners of the box (of its first six sides; the others at both ends one at a time)."""
    sides = [name for name, (low, high) in bounds.items() if low != high]
    nominal = {name: scene.scalars[name] if name in sides else low for name, (low, _) in bounds.items()}
    points = [nominal]
    points += [nominal | dict(zip(sides[:6], c, strict=True)) for c in product(*(bounds[s] for s in sides[:6]))]
    points += [nominal | {side: end} for side in sides[6:] for end in bounds[side]]
    return {name: np.array([p[name] for p in points]) for name in bounds}


def plan_integration(
    scene: Scene,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    *,
    step: float | None = None,
    method: str = "rk8",
    formulation: str = "slope",
    accuracy: float | None = None,
    outputs: Sequence[str] | None = None,
    on_contact_loss: str = "stop",
    project_energy: bool = False,
    halving: bool = False,
    samples: int = 1,
) -> Plan:
    """Choose step and method for a scene whose scalars vary within ``bounds``.

    With ``step=None`` a pilot integrates the nominal and the corner dimensions with n and 2 n steps and takes the least n
    for which the reported quantities (end of the motion, statistics of the contact forces if they are asked for, energy)
    agree to ``accuracy``; ``method="auto"`` takes the method with the fewest evaluations. Where some of these motions meet it
    with no step at all, their number is ``unresolved`` and every sample is judged by step halving.

    Parameters
    ----------
    bounds : mapping from names in quantities.SCALARS to (low, high), SI units
    step : float, s, or None
    accuracy : float
        Relative to r, to the largest contact force and to the energy. Default 1e-7 (with a given step: 1e-4, only judged).
    samples : int
        Motions that the plan is for. The pilot takes a tenth of their work or two seconds at most, whichever is more; only
        where it ends there (``bounded``) does the plan depend on it.

    Raises
    ------
    ValueError
        Unknown names, or values out of range.
    """
    forces = wants_forces(outputs)
    if accuracy is not None:
        accuracy = positive_number("accuracy", accuracy)
    bounds = dict(bounds or {})
    for name in bounds:
        choice("bounds", name, SCALARS)
    varied = {name for name, (low, high) in bounds.items() if not low == high == scene.scalars[name]}
    features = features_of(scene, varied, wants_pose(outputs))
    _check_choices(scene, features, method, formulation, on_contact_loss, project_energy or halving)
    draft = Plan(
        formulation, "rk8" if method == "auto" else method, 1, accuracy or DEFAULT_ACCURACY, features=features,
        turning=scene.loads.turning,
    )  # fmt: skip
    if step is not None:
        steps = step_count(scene.duration, step)
        return replace(draft, steps=steps, accuracy=accuracy or COARSE_ACCURACY, halving=halving)
    columns = _corners(scene, bounds)
    raw, code = pack({**scene.scalars, **columns}, max((len(c) for c in columns.values()), default=1))
    if not (code == R.OK).any():
        return draft
    if features.free:
        code[(code == R.OK) & ~has_room(raw, draft)] = GEOMETRY_INVALID
    if not (code == R.OK).any():
        return draft
    raw = np.ascontiguousarray(raw[:, code == R.OK])
    # Halving is the pilot's own, whatever the samples have.
    drafts = [replace(draft, method=name, halving=True) for name in (METHODS if method == "auto" else (method,))]
    bounds_of_work = [_Bound(samples) for _ in drafts]
    with np.errstate(all="ignore"):
        if features.one_sided or features.rubs:
            plans = [
                _pilot_one_sided(raw, each, forces, scene.duration, bound)
                for each, bound in zip(drafts, bounds_of_work, strict=True)
            ]
        else:
            plans = [
                _pilot(raw, each, forces, scene.duration, on_contact_loss, project_energy, bound)
                for each, bound in zip(drafts, bounds_of_work, strict=True)
            ]
    halvable = formulation == "slope" and not (features.one_sided or features.rubs)
    best = min(plans, key=lambda plan: plan.steps * TABLEAUX[plan.method].stages)
    return replace(best, halving=halving or (best.unresolved > 0 and halvable))


def _check_choices(
    scene: Scene, features: Features, method: str, formulation: str, on_contact_loss: str, slope_only: bool
) -> None:
    choice("formulation", formulation, FORMULATIONS)
    choice("method", method, (*METHODS, "auto"))
    choice("on_contact_loss", on_contact_loss, ON_CONTACT_LOSS)
    if formulation != "slope" and scene.joint.section == "exact":
        raise ValueError(f"formulation = {formulation!r} knows the circle only; with section = 'exact' use 'slope'.")
    if on_contact_loss == "follow" and not features.one_sided:
        raise ValueError("on_contact_loss = 'follow' needs impacts; give Joint(restitution=...), 0 to 1.")
    if features.one_sided or features.rubs:
        _check_one_sided(features, formulation, on_contact_loss, slope_only)
    if formulation != "slope" and slope_only:
        raise ValueError(f"project_energy and halving need formulation = 'slope', got {formulation!r}.")


def _check_one_sided(features: Features, formulation: str, on_contact_loss: str, slope_only: bool) -> None:
    """What a wall that only pushes has no use for."""
    if formulation != "slope":
        what, cause = (
            ("impacts", "restitution") if features.one_sided else ("friction, wear, drive or loads that swing", "them")
        )
        raise ValueError(f"formulation = {formulation!r} knows no {what}; with {cause} use 'slope'.")
    if not features.one_sided and on_contact_loss not in ("stop", "end"):
        raise ValueError(
            f"on_contact_loss = {on_contact_loss!r} is for a wall without friction that holds the journal; with friction, "
            "wear, a drive or loads that swing the motion ends where contact is lost, or goes on with Joint(restitution=...). "
            "Leave it out."
        )
    if features.one_sided and on_contact_loss not in ("stop", "follow"):
        raise ValueError(
            f"on_contact_loss = {on_contact_loss!r} is for a wall that holds the journal; with restitution the motion goes on "
            "through flight and impacts. Leave it out."
        )
    if slope_only:
        raise ValueError(
            "project_energy and halving do not go with restitution, friction, wear, a drive or loads that swing: the energy "
            "balance watches every sample."
        )
