"""Where the coefficients of tolmc's formula of order 8 for motions alone come from, and what they gain.

    python studies/rk8_formula.py [--search GENERATIONS] [--quick]

Twelve stages of the sparsity of Dormand and Prince's, within the simplifying conditions of Hairer, Norsett & Wanner, Solving
Ordinary Differential Equations I, section II.5 (stages counted from 1; a . c^m stands for sum_j a_j c_j^m):

    C(m)  a_i . c^m = c_i^(m+1)/(m+1) for m = 1, 2 (i >= 4) and m = 3 (i >= 6), with c3 = 2/3 c4 and c4 from c5, c6
    b     the quadrature of order 8 on the nodes c1 = 0, c6 .. c12 = 1; b2 = .. = b5 = 0
    D(1)  sum_i b_i a_ij = b_j (1 - c_j)
    d_j = sum_i b_i c_i a_ij:  d4 = d5 = 0, d . c^m = 1/((m+1)(m+3)) for m <= 5, d11 = b11 (1 - c11)
    sum_i b_i c_i^2 a_ij = 0 and sum_i d_i a_ij = 0 for j = 4, 5;  sum b_i c_i^2 a_ij c_j^4 = 1/40, sum d_i a_ij c_j^4 = 1/240

Given the nodes, d is known and all of it is linear in rows 8 to 12: one number there stays free, and one node, c7, is what
makes the equations agree. So there are eight free numbers. FREE holds them, to three digits; ``--search`` looks for better
ones: least error on random motions of the joint at equal steps, coefficients and nodes kept within bounds.

Prints the derived coefficients' distance from those in tolmc, what is left of the 200 order conditions, and the steps that
equal errors take against the formula of DOP853: on the motions of the search, on others, and on the paper's joint. Writes
figures/rk8_formula.png.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import matplotlib
import mpmath as mp
import numba
import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from scipy.integrate._ivp import dop853_coefficients as dop853
from scipy.optimize import differential_evolution
from study_tools import BLUE, GREY, ORANGE, STYLE, arguments, paper_joint, save, show

from tolmc.kernels import parameters as P
from tolmc.kernels.formulations import slope_symmetric as slope
from tolmc.kernels.tableaux import RK8
from tolmc.mechanism import geometry

#: c2, c5, c6, c8, c9, c10, c11 and a_12,7.
FREE = ("0.030", "0.389", "0.464", "0.982", "0.842", "0.894", "0.970", "-2.408")
C7_NEAR = "0.1567"
STAGES = 12

# --- The family ------------------------------------------------------------------------------------------------------
# Indices count from 0 here. All of it runs in floating point for the search and with any number of digits for the result.

_QUADRATURE = [0, *range(5, 12)]  # stages with a weight
_UNKNOWN = [(i, j) for i in range(7, 12) for j in range(3, i)]
_FREE_PLACE = (11, 6)


def _solve(matrix, right):
    """Solution of a square or overdetermined consistent system."""
    if isinstance(right[0], mp.mpf):
        return list(mp.lu_solve(mp.matrix(matrix), mp.matrix(right)))
    matrix, right = np.array(matrix, float), np.array(right, float)
    scale = 1 / np.abs(matrix).max(axis=1)
    return list(np.linalg.lstsq(matrix * scale[:, None], right * scale, rcond=1e-13)[0])


def _by_moments(nodes, targets):
    """Weights on ``nodes`` whose moments of power 1, 2, .. are ``targets``."""
    return _solve([[c ** (m + 1) for c in nodes] for m in range(len(targets))], targets)


def _conditions(free, c7):
    """Nodes, rows 1 to 7 and weights; the linear equations for the unknowns; and the one that c7 has to satisfy."""
    c2, c5, c6, c8, c9, c10, c11, _ = free
    one, zero = c7**0, c7 * 0
    c4 = (3 * c6 * c6 - 4 * c5 * c6) / (4 * c6 - 6 * c5)
    c = [zero, c2, 2 * c4 / 3, c4, c5, c6, c7, c8, c9, c10, c11, one]
    a = [[zero] * STAGES for _ in range(STAGES)]
    a[1][0] = c2
    a[2][1] = c[2] ** 2 / (2 * c2)
    for i, columns in ((3, [2]), (4, [2, 3]), (5, [3, 4]), (6, [3, 4, 5])):
        targets = [c[i] ** (m + 1) / (m + 1) for m in range(1, len(columns) + 1)]
        for j, value in zip(columns, _by_moments([c[j] for j in columns], targets), strict=True):
            a[i][j] = value
    b = [zero] * STAGES
    weights = _solve([[c[j] ** k for j in _QUADRATURE] for k in range(8)], [one / (k + 1) for k in range(8)])
    for j, value in zip(_QUADRATURE, weights, strict=True):
        b[j] = value
    d = [zero] * STAGES
    inner = range(5, 11)
    matrix = [[c[j] ** m for j in inner] for m in range(1, 6)] + [[zero] * 5 + [one]]
    right = [one / ((m + 1) * (m + 3)) for m in range(1, 6)] + [b[10] * (1 - c11)]
    for j, value in zip(inner, _solve(matrix, right), strict=True):
        d[j] = value

    rows, targets = [], []

    def condition(factors: dict, target):
        row = dict.fromkeys(_UNKNOWN, zero)
        for place, factor in factors.items():
            if place in row:
                row[place] = factor
            else:
                target = target - factor * a[place[0]][place[1]]
        rows.append(list(row.values()))
        targets.append(target)

    for i in range(7, 12):
        for m in (1, 2, 3):
            condition({(i, j): c[j] ** m for j in range(3, i)}, c[i] ** (m + 1) / (m + 1))
    for j in range(3, 11):
        condition({(i, j): b[i] for i in range(max(j + 1, 5), 12)}, b[j] * (1 - c[j]))
        condition({(i, j): b[i] * c[i] for i in range(max(j + 1, 5), 12)}, d[j])
    for j in (3, 4):
        condition({(i, j): b[i] * c[i] ** 2 for i in range(5, 12)}, zero)
        condition({(i, j): d[i] for i in range(5, 11)}, zero)
    condition({(i, j): b[i] * c[i] ** 2 * c[j] ** 4 for i in range(5, 12) for j in range(3, i)}, one / 40)
    condition({(i, j): d[i] * c[j] ** 4 for i in range(5, 11) for j in range(3, i)}, one / 240)
    return c, a, b, rows, targets


def _complete(free, c7):
    """a, b and how far the last condition is from being met."""
    c, a, b, rows, targets = _conditions(free, c7)
    place = _UNKNOWN.index(_FREE_PLACE)
    unknown = [k for k in range(len(_UNKNOWN)) if k != place]
    right = [target - row[place] * free[7] for row, target in zip(rows, targets, strict=True)]
    found = _solve([[row[k] for k in unknown] for row in rows[:-1]], right[:-1])
    found.insert(place, free[7])
    for (i, j), value in zip(_UNKNOWN, found, strict=True):
        a[i][j] = value
    for i in range(1, STAGES):
        a[i][0] = c[i] - sum(a[i][1:])
    return a, b, sum(factor * value for factor, value in zip(rows[-1], found, strict=True)) - targets[-1]


def formula(free: Sequence, c7, steps: int = 12):
    """Coefficients a (12, 12) and weights b (12,) of the member of the family ``free``; c7 by secants from near ``c7``.

    ValueError where no node c7 is found.
    """
    before, gap_before = c7, _complete(free, c7)[2]
    now = c7 * (1 + type(c7)(1) / 4096)
    for _ in range(steps):
        a, b, gap = _complete(free, now)
        if gap == gap_before:
            break
        before, gap_before, now = now, gap, now - gap * (now - before) / (gap - gap_before)
        if not abs(now - c7) < 0.1:
            break
        if abs(now - before) < (1e-13 if isinstance(now, float) else 1e-32):
            return a, b
    raise ValueError(f"formula: no node c7 near {c7} for {free}.")


# --- Order conditions ------------------------------------------------------------------------------------------------


@cache
def trees(order: int) -> tuple[tuple, ...]:
    """Rooted trees of ``order`` vertices, each as the sorted tuple of its root's branches."""

    def forests(left: int, largest: int):
        if left == 0:
            yield ()
        for size in range(min(left, largest), 0, -1):
            for tree in trees(size):
                for rest in forests(left - size, size):
                    yield (tree, *rest)

    return tuple(sorted({tuple(sorted(forest)) for forest in forests(order - 1, order - 1)}))


def _order(tree: tuple) -> int:
    return 1 + sum(map(_order, tree))


def _density(tree: tuple) -> int:
    return _order(tree) * int(np.prod([_density(branch) for branch in tree], dtype=object))


def residuals(a: np.ndarray, b: np.ndarray, order: int) -> np.ndarray:
    """What is left of the conditions gamma(t) b . Phi(t) = 1 of all trees t up to ``order`` (Butcher)."""

    @cache
    def stages(tree):
        value = np.ones(len(b), dtype=a.dtype)
        for branch in tree:
            value = value * (a @ stages(branch))
        return value

    return np.array([_density(t) * (b @ stages(t)) - 1 for n in range(1, order + 1) for t in trees(n)])


# --- Motions ---------------------------------------------------------------------------------------------------------


@numba.njit(error_model="numpy")
def _states(raw, duration, steps, a, b, states):
    """States (step, component) at the ends of ``steps`` equal steps of the motion in column 0 of ``raw``."""
    y, k, argument = np.empty(slope.STATE), np.zeros(len(b) * slope.STATE), np.empty(slope.STATE + slope.HELD)
    coef = np.empty(slope.COEFFICIENTS)
    slope.prepare(raw, 0, coef, 0, 1)
    slope.start(raw, 0, y, coef, 0, 1)
    for step in range(steps):
        for i in range(len(b)):
            for c in range(slope.STATE):
                argument[c] = y[c]
                for j in range(i):
                    argument[c] += a[i, j] * k[j * slope.STATE + c]
            slope.begin(argument, argument, coef, 0, 1, True)
            slope.finish(argument, argument, coef, duration / steps, k, i * slope.STATE, 0, 1, True)
        for c in range(slope.STATE):
            for j in range(len(b)):
                y[c] += b[j] * k[j * slope.STATE + c]
        slope.project(y, coef, 0, 1)
        states[step] = y


_FINEST = 2400
_STEPS = [n for n in range(6, 401) if _FINEST % n == 0]
DOP853 = np.ascontiguousarray(dop853.A[:STAGES, :STAGES]), np.ascontiguousarray(dop853.B)


class ExactMotion:
    """A motion (column of parameters) over a duration, and its states at the ends of 2,400 steps."""

    def __init__(self, raw: np.ndarray, duration: float) -> None:
        self.raw, self.duration = raw, duration
        mean, half = 0.5 * (raw[P.ALPHA] + raw[P.BETA]), 0.5 * (raw[P.ALPHA] - raw[P.BETA])
        raw[P.COS_MEAN], raw[P.SIN_MEAN], raw[P.COS_HALF], raw[P.SIN_HALF] = (
            np.cos(mean), np.sin(mean), np.cos(half), np.sin(half),
        )  # fmt: skip
        self.states = np.empty((_FINEST, slope.STATE))
        _states(raw, duration, _FINEST, *DOP853, self.states)

    def error(self, steps: int, a, b) -> float:
        """Root mean square over the steps of the state's error."""
        states = np.empty((steps, slope.STATE))
        _states(self.raw, self.duration, steps, a, b, states)
        every = _FINEST // steps
        with np.errstate(over="ignore"):  # a motion that explodes at coarse steps
            return float(np.linalg.norm(states - self.states[every - 1 :: every]) / np.sqrt(steps))


@dataclass(frozen=True)
class Case:
    """A motion and the number of steps to judge at."""

    motion: ExactMotion
    steps: int

    def error(self, a, b) -> float:
        return self.motion.error(self.steps, a, b)


def cases(motions: Sequence[ExactMotion]) -> list[Case]:
    """Each motion at the steps at which DOP853's formula errs by less than 1e-7, 1e-8 and 1e-10, as far as it can."""
    found = []
    for motion in motions:
        errors = [motion.error(steps, *DOP853) for steps in _STEPS]
        for target in (1e-7, 1e-8, 1e-10):
            found += [Case(motion, n) for n, error in zip(_STEPS, errors, strict=True) if error < target][:1]
    return found


def random_motions(count: int, seed: int) -> list[ExactMotion]:
    """Some ten radians of joints with r = m = 1: clearances, inertias, centres of mass, spins, loads, starts of all kinds."""
    rng = np.random.default_rng(seed)
    motions = []
    for _ in range(count):
        raw = np.zeros((P.COUNT, 1))
        length = 10 ** rng.uniform(0.25, 2)  # r/L from 1/100 to 0.56
        inertia, off_centre = 10 ** rng.uniform(-0.5, 0.7), rng.uniform(-0.7, 0.7) * (rng.random() < 0.7)
        raw[[P.RADIUS, P.HALF_LENGTH, P.MASS]] = [[1], [length], [1]]
        raw[[P.J_XX, P.J_YY], 0] = inertia * length**2
        raw[P.COM_Z, 0] = off_centre * np.sqrt(inertia) * length  # |z_C| < rho: the mass matrix stays definite
        raw[[P.J_ZZ, P.SPIN_RATE], 0] = length**2, rng.uniform(-1, 1) * (rng.random() < 0.6)
        raw[[P.GRAVITY_X, P.GRAVITY_Y], 0] = rng.uniform(-1, 1, 2)
        raw[[P.FORCE_X, P.POINT_Z], 0] = rng.uniform(-0.5, 0.5), rng.uniform(-1, 1) * length
        mean, half = rng.uniform(0, 2 * np.pi), rng.uniform(-1.2, 1.2) * rng.random()
        mean_rate, half_rate = rng.uniform(-2, 2), rng.uniform(-1, 1)
        raw[[P.ALPHA, P.BETA], 0] = mean + half, mean - half
        raw[[P.ALPHA_RATE, P.BETA_RATE], 0] = mean_rate + half_rate, mean_rate - half_rate
        motions.append(ExactMotion(raw, 6.0))
    return motions


def paper_motion() -> ExactMotion:
    """The paper's joint."""
    scene = paper_joint()
    joint, body, motion = scene.joint, scene.body, scene.motion
    raw = np.zeros((P.COUNT, 1))
    raw[P.RADIUS] = geometry.effective_radius(joint.bearing_radius, joint.journal_radius, joint.half_length)
    raw[[P.HALF_LENGTH, P.MASS, P.COM_Z], 0] = joint.half_length, body.mass, body.center_of_mass[2]
    raw[[P.J_XX, P.J_YY, P.J_ZZ], 0] = np.diag(body.inertia)
    raw[[P.GRAVITY_X, P.GRAVITY_Y, P.GRAVITY_Z], 0] = scene.loads.gravity
    raw[[P.ALPHA, P.BETA, P.ALPHA_RATE, P.BETA_RATE, P.SPIN_RATE], 0] = (
        motion.alpha, motion.beta, motion.alpha_rate, motion.beta_rate, motion.spin_rate,
    )  # fmt: skip
    return ExactMotion(raw, scene.duration)


def step_ratio(a, b, motions: Sequence[Case]) -> float:
    """Steps that equal errors take against DOP853's formula, geometric mean: errors go with the eighth power of the step."""
    return float(np.exp(np.mean([np.log(case.error(a, b) / case.error(*DOP853)) for case in motions]) / 8))


# --- Search ----------------------------------------------------------------------------------------------------------


def search(motions: Sequence[Case], generations: int) -> np.ndarray:
    """Free numbers of least error near FREE: differential evolution, coefficients bounded to keep rounding small."""
    start = np.array(FREE, float)
    width = np.array([0.02, 0.02, 0.02, 0.017, 0.03, 0.03, 0.02, 1.0])

    def cost(free):
        try:
            a, b = arrays(formula(free.tolist(), float(C7_NEAR)))
        except ValueError:
            return 10.0
        excess = np.maximum(np.abs(a) - 25, 0).sum() + np.maximum(np.abs(b) - 12, 0).sum()
        return step_ratio(a, b, motions) + 1e-3 * excess

    bounds = list(zip(start - width, start + width, strict=True))
    return differential_evolution(cost, bounds, x0=start, maxiter=generations, seed=1, tol=0, polish=False).x


def draw(motions: Mapping[str, Sequence[ExactMotion]], formulas: Mapping[str, tuple]) -> Figure:
    """Error against steps, geometric mean over each group of motions."""
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(11, 4.6), layout="constrained")
        for ax, (title, group) in zip(figure.subplots(1, len(motions)), motions.items(), strict=True):
            for (name, coefficients), colour in zip(formulas.items(), (GREY, BLUE, ORANGE), strict=False):
                errors = np.array([[motion.error(steps, *coefficients) for steps in _STEPS] for motion in group])
                mean = np.exp(np.log(np.maximum(errors, 1e-16)).mean(axis=0))
                shown = (mean > 1e-13) & (mean < 1e-2)
                ax.loglog(np.array(_STEPS)[shown], mean[shown], marker="o", markersize=4, color=colour, label=name)
            ax.set(title=title, xlabel="steps of the motion", ylabel="error of the state, root mean square")
            ax.set_xticks([10, 20, 50, 100, 200], labels=["10", "20", "50", "100", "200"])
            ax.minorticks_off()
            ax.legend()
    return figure


def arrays(coefficients) -> tuple[np.ndarray, np.ndarray]:
    """Coefficients and weights as floating-point arrays."""
    return tuple(np.array(part, dtype=float) for part in coefficients)


def main() -> None:
    """Derive, compare, print."""
    options = arguments(
        __doc__,
        search={
            "type": int,
            "metavar": "GENERATIONS",
            "help": "look for better free numbers (a quarter of a minute each)",
        },
    )
    mp.mp.dps = 50
    exact = formula([mp.mpf(number) for number in FREE], mp.mpf(C7_NEAR))
    left = max(abs(value) for value in residuals(*(np.array(part, dtype=object) for part in exact), 8))
    a, b = arrays(exact)
    own = RK8
    print(f"{len(FREE)} free numbers: {', '.join(FREE)}; c7 = {mp.nstr(sum(exact[0][6]), 16)}")
    print(
        f"Order conditions up to 8, {sum(len(trees(n)) for n in range(1, 9))} trees: {mp.nstr(left, 2)} is left of them"
    )
    distance = max(np.abs(a - own.matrix).max(), np.abs(b - own.b).max())
    print(f"Distance from the coefficients in tolmc: {distance:.1e}")
    count = 20 if options.quick else 150
    searched, others, paper = random_motions(count, 1), random_motions(count, 2), [paper_motion()]
    motions = {
        "random motions of the search": cases(searched),
        "other random motions": cases(others),
        "the paper's joint": cases(paper),
    }
    formulas = {"DOP853": DOP853, "tolmc": (own.matrix, own.b)}
    if options.search:
        free = search(motions["random motions of the search"], options.search)
        print(f"Found: {', '.join(f'{number:.3f}' for number in free)}")
        formulas["found"] = arrays(formula(free.tolist(), float(C7_NEAR)))
    table = pd.DataFrame(
        [
            {
                "formula": name,
                **{f"steps on {title}": step_ratio(*coefficients, chosen) for title, chosen in motions.items()},
                "largest |a|": np.abs(coefficients[0]).max(),
                "largest |b|": np.abs(coefficients[1]).max(),
            }
            for name, coefficients in formulas.items()
        ]
    )
    show("Steps at equal error, relative to the formula of DOP853", table, {name: ".3f" for name in table})
    groups = {"Random motions, others than the search's": others, "The paper's joint": paper}
    save(draw(groups, formulas), options.figures / "rk8_formula.png")


if __name__ == "__main__":
    main()
