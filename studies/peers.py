"""Peers: other people's integrators on the motion of a joint with a symmetric body.

Each is prepared for a scene, its samples and a tolerance (compilation and a warm run happen here) and gives back a function
that runs all samples and returns :class:`Motions`. Each gets the form of the equations that suits it best, and some a second
one for comparison. heyoka: Taylor series, eight samples at a time. SciPy: DOP853 with a compiled right-hand side, with NumPy,
with NumPy matrices as the equations are printed, and with all samples stacked into one system. SUNDIALS: IDA on the
differential-algebraic equations. Exudyn: DOPRI5 on a user-defined system of first order; of its multibody elements none
constrains an axis to circles in two planes.
"""

from __future__ import annotations

import importlib.util
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache, partial
from importlib import metadata

import numba
import numpy as np
import peer_equations as equations
from peer_equations import Coefficients, Samples
from peer_statistics import force_statistics, lobatto_grid
from scipy.integrate import solve_ivp

from tolmc.mechanism.scene import Scene


@dataclass(frozen=True)
class Motions:
    """Results for n samples.

    ``state`` (n, 5): origin/r (x, y) and axis (x, y, z) at the end. ``peak``, ``mean`` (n, 2), N: maxima and means over time
    of the contact forces N_D, N_E; None where they were not asked for or the peer offers no way.
    """

    state: np.ndarray
    peak: np.ndarray | None = None
    mean: np.ndarray | None = None


@dataclass(frozen=True)
class Peer:
    """An integrator: how to prepare it, the tolerances to try, and how many samples keep one run short."""

    name: str
    package: str
    samples: int
    tolerances: tuple[float, ...]
    prepare: Callable[[Scene, Samples, float, bool], Callable[[], Motions]]
    statistics: bool = True

    @property
    def version(self) -> str | None:
        """Version of the package, None where it is not installed."""
        module = {"scikit-sundae": "sksundae"}.get(self.package, self.package)
        return metadata.version(self.package) if importlib.util.find_spec(module) else None


def _motions(scene: Scene, samples: Samples, k: Coefficients, x, forces=None) -> Motions:
    state = equations.pose(x, k.s)
    if forces is None:
        return Motions(state)
    unit = scene.body.mass * equations.effective_radius(samples)[:, None]
    return Motions(state, *(values * unit for values in forces))


# --- heyoka ----------------------------------------------------------------------------------------------------------

LANES = 8


@lru_cache
def _heyoka_integrator(cartesian: bool, tolerance: float):
    import heyoka

    x = heyoka.make_vars(*(f"x{i}" for i in range(8)))
    # Dimensions are runtime parameters: every lane has its own.
    kind = equations.CartesianCoefficients if cartesian else Coefficients
    k = kind(*(heyoka.par[i] for i in range(len(kind._fields))))
    if cartesian:
        rates = equations.cartesian_rates(x, lambda square: square**-0.5, k)
    else:
        rates = equations.canonical_rates(x, (1.0 + k.inverse_s * (0.5 - 0.5 * x[4])) ** -0.5, k)
    # Measured: fast_math gains some 10 %, compact_mode halves the speed, high_accuracy costs 5 % and gains no digit.
    return heyoka.taylor_adaptive_batch(
        list(zip(x, rates, strict=True)),
        np.zeros((8, LANES)),
        pars=np.ones((len(k), LANES)),
        tol=tolerance,
        fast_math=True,
    )


def prepare_heyoka(scene, samples, tolerance, statistics, *, cartesian=False) -> Callable[[], Motions]:
    """``taylor_adaptive_batch``; statistics (canonical form only) from its dense output on a grid, ``propagate_grid``.

    Its continuous output is no alternative: it compiles a function for every batch, ten times the motion's own cost.
    """
    count = len(samples["half_length"])
    padded = {name: np.resize(values, -(-count // LANES) * LANES) for name, values in samples.items()}
    k = equations.coefficients(scene, padded)
    if cartesian:
        x0, parameters = equations.cartesian_start(scene, k), np.array(equations.cartesian_coefficients(k))
    else:
        x0, parameters = equations.canonical_start(scene, k), np.array(k)
    integrator = _heyoka_integrator(cartesian, tolerance)
    grid = lobatto_grid(scene.duration, tolerance)
    times = np.repeat(grid.times[:, None], LANES, axis=1)
    with_forces = statistics and not cartesian

    def run() -> Motions:
        x = np.empty_like(x0)
        forces = np.empty((2, x.shape[1], 2)) if with_forces else None
        for first in range(0, x.shape[1], LANES):
            lanes = slice(first, first + LANES)
            integrator.set_time(0.0)
            integrator.state[:] = x0[:, lanes]
            integrator.pars[:] = parameters[:, lanes]
            if with_forces:
                on_grid = integrator.propagate_grid(times)[1]
                x[:, lanes] = on_grid[-1]
                forces[:, lanes] = force_statistics(on_grid, parameters[:, lanes].copy(), grid)
            else:
                integrator.propagate_until(scene.duration)
                x[:, lanes] = integrator.state
        motions = _motions(scene, padded, k, x, forces)
        return Motions(*(None if values is None else values[:count] for values in vars(motions).values()))

    run()
    return run


# --- SciPy's DOP853 --------------------------------------------------------------------------------------------------


@numba.njit(**equations.FLAGS)
def _rates_numba(t, x, p):
    k = equations.unpacked(p)
    n = 1.0 / math.sqrt(1.0 + k.inverse_s * (0.5 - 0.5 * x[4]))
    return np.array(equations.canonical_rates(x, n, k))


def _rates_numpy(t, x, k):
    n = 1 / np.sqrt(1 + k.inverse_s * (0.5 - 0.5 * x[4]))
    return np.array(equations.canonical_rates(x, n, k))


def _rates_stacked(t, x, k):
    return _rates_numpy(t, x.reshape(8, -1), k).ravel()


def _rates_matrices(t, y, k):
    q, v = y[:5], y[5:]
    return np.concatenate([v[:4], [equations.chi_rate(q, v, k)], equations.accelerations(y, k)[0]])


def _dop853(rates, y0, scale, k, times, tolerance, max_step=np.inf) -> np.ndarray:
    # scale: size of each component, so that the absolute part of the tolerance is the same share of all.
    solution = solve_ivp(
        rates, (0.0, times[-1]), y0, method="DOP853", t_eval=times, args=(k,), rtol=max(tolerance, 3e-14),
        atol=0.1 * tolerance * scale, max_step=max_step,
    )  # fmt: skip
    if not solution.success:
        raise RuntimeError(f"solve_ivp DOP853 at rtol {tolerance!r}: {solution.message}")
    return solution.y.T


def _canonical_scale(x0: np.ndarray) -> np.ndarray:
    return np.repeat([1.0, np.abs(x0[6:]).max()], [6, 2])


def _arrays(k: Coefficients) -> list[np.ndarray]:
    # One array crosses into compiled code at a third of a named tuple's cost.
    return list(np.array(k).T.copy())


def _tuples(k: Coefficients) -> list[Coefficients]:
    return [Coefficients(*map(float, values)) for values in zip(*k, strict=True)]


def prepare_scipy(scene, samples, tolerance, statistics, *, compiled, max_step=np.inf) -> Callable[[], Motions]:
    """One sample after another, canonical form; right-hand side by Numba or in NumPy."""
    k = equations.coefficients(scene, samples)
    x0 = equations.canonical_start(scene, k)
    scale = _canonical_scale(x0)
    rates, each = (_rates_numba, _arrays(k)) if compiled else (_rates_numpy, _tuples(k))
    grid = lobatto_grid(scene.duration, tolerance)
    times = grid.times if statistics else np.array([scene.duration])

    def run() -> Motions:
        x = [_dop853(rates, x0[:, i], scale, each[i], times, tolerance, max_step) for i in range(len(each))]
        x = np.stack(x, axis=2)
        return _motions(scene, samples, k, x[-1], force_statistics(x, np.array(k), grid) if statistics else None)

    run()
    return run


def prepare_scipy_stacked(scene, samples, tolerance, statistics) -> Callable[[], Motions]:
    """All samples stacked into one system: NumPy at its best, at the price of one step size for all."""
    k = equations.coefficients(scene, samples)
    x0 = equations.canonical_start(scene, k)
    scale = np.repeat(_canonical_scale(x0), x0.shape[1])
    grid = lobatto_grid(scene.duration, tolerance)
    times = grid.times if statistics else np.array([scene.duration])

    def run() -> Motions:
        x = _dop853(_rates_stacked, x0.ravel(), scale, k, times, tolerance).reshape(len(times), 8, -1)
        return _motions(scene, samples, k, x[-1], force_statistics(x, np.array(k), grid) if statistics else None)

    run()
    return run


def reference(scene: Scene, samples: Samples) -> Motions:
    """The motions that errors are measured against: DOP853 at rounding level, steps short enough for its dense output."""
    return prepare_scipy(scene, samples, 1e-14, True, compiled=True, max_step=2e-3)()


# --- Slope coordinates with multipliers: SciPy on matrices, SUNDIALS IDA ---------------------------------------------


def _slope_scale(scene: Scene, k: equations.Constants) -> np.ndarray:
    motion = scene.motion
    rate = max(abs(motion.alpha_rate), abs(motion.beta_rate), math.sqrt(math.hypot(*scene.loads.gravity) / k.r))
    return np.array([k.r] * 4 + [1.0] + [k.r * rate] * 4 + [max(1.0, abs(motion.spin_rate))])


def _prepare_slope(integrate, scene, samples, tolerance, statistics) -> Callable[[], Motions]:
    k, each = equations.coefficients(scene, samples), equations.constants(scene, samples)
    r = equations.effective_radius(samples)
    grid = lobatto_grid(scene.duration, tolerance)
    times = grid.times if statistics else np.linspace(0.0, scene.duration, 3)  # IDA keeps every step if given two

    def run() -> Motions:
        y = np.stack(
            [integrate(equations.slope_start(scene, c), _slope_scale(scene, c), c, times, tolerance) for c in each]
        )
        y = np.moveaxis(y, 0, 2)
        # The pose comes from the integrated coordinates: their distance from the circles is part of the error.
        x = np.concatenate([(y[-1, 0:2] + y[-1, 2:4]) / r, (y[-1, 0:2] - y[-1, 2:4]) / r])
        forces = None
        if statistics:
            states = np.moveaxis(equations.canonical_state(np.moveaxis(y, 1, 0), r, k), 0, 1)
            forces = force_statistics(np.ascontiguousarray(states), np.array(k), grid)
        return _motions(scene, samples, k, x, forces)

    run()
    return run


def prepare_scipy_matrices(scene, samples, tolerance, statistics) -> Callable[[], Motions]:
    """The equations as printed: M and B as matrices, multipliers by ``numpy.linalg.solve``, one sample after another."""
    return _prepare_slope(partial(_dop853, _rates_matrices), scene, samples, tolerance, statistics)


_slope_equations_numba = numba.njit(equations.slope_equations)
_chi_rate_numba = numba.njit(equations.chi_rate)


@numba.njit
def _residual(y, rate, k, out):
    # y = (q, v, lambda): index 1, the constraints differentiated twice.
    M, F, B, b = _slope_equations_numba(y[:5], y[5:10], k)
    out[0:4] = rate[0:4] - y[5:9]
    out[4] = rate[4] - _chi_rate_numba(y[:5], y[5:10], k)
    for i in range(5):
        total = -F[i] - B[0, i] * y[10] - B[1, i] * y[11]
        for j in range(5):
            total += M[i, j] * rate[5 + j]
        out[5 + i] = total
    for i in range(2):
        total = -b[i]
        for j in range(5):
            total += B[i, j] * rate[5 + j]
        out[10 + i] = total


@numba.njit
def _jacobian(y, rate, residual, cj, scale, k, out):
    # One-sided differences, as SUNDIALS would take them, but without a Python call for every column.
    moved, moved_rate, changed = y.copy(), rate.copy(), np.empty(12)
    for j in range(12):
        step = 1e-8 * scale[j]
        moved[j] += step
        moved_rate[j] += cj * step
        _residual(moved, moved_rate, k, changed)
        out[:, j] = (changed - residual) / step
        moved[j], moved_rate[j] = y[j], rate[j]


def _ida(y0, scale, k, times, tolerance) -> np.ndarray:
    from sksundae.ida import IDA

    rate0 = np.append(_rates_matrices(0.0, y0, k), [0.0, 0.0])
    y0 = np.append(y0, equations.accelerations(y0, k)[1])
    scale = np.append(scale, [np.linalg.norm(k.force)] * 2)

    def residual(t, y, rate, out):
        _residual(y, rate, k, out)

    def jacobian(t, y, rate, res, cj, out):
        _jacobian(y, rate, res, cj, scale, k, out)

    solver = IDA(
        residual, jacfn=jacobian, algebraic_idx=[10, 11], rtol=tolerance, atol=0.1 * tolerance * scale,
        max_num_steps=10**6,
    )  # fmt: skip
    solution = solver.solve(times, y0, rate0)
    if not solution.success:
        raise RuntimeError(f"IDA at rtol {tolerance!r}: {solution.message}")
    return solution.y


def prepare_ida(scene, samples, tolerance, statistics) -> Callable[[], Motions]:
    """SUNDIALS IDA on the five-coordinate differential-algebraic equations, residual and Jacobian compiled by Numba."""
    return _prepare_slope(_ida, scene, samples, tolerance, statistics)


# --- Exudyn ----------------------------------------------------------------------------------------------------------


def _exudyn_motion(x0, k, duration, tolerance) -> np.ndarray:
    import exudyn
    from exudyn.itemInterface import NodeGenericODE1, ObjectGenericODE1

    # The container owns the system: it must stay referenced until the end.
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    node = system.AddNode(
        NodeGenericODE1(referenceCoordinates=[0.0] * 8, initialCoordinates=x0.tolist(), numberOfODE1Coordinates=8)
    )
    system.AddObject(
        ObjectGenericODE1(
            nodeNumbers=[node], rhsUserFunction=lambda system, t, item, x: _rates_numba(t, np.array(x), k)
        )
    )
    system.Assemble()
    settings = exudyn.SimulationSettings()
    settings.solution.file.write = False
    settings.timeIntegration.endTime = duration
    settings.timeIntegration.numberOfSteps = 20  # the longest step; the tolerance chooses below it
    settings.timeIntegration.relativeTolerance = tolerance
    settings.timeIntegration.absoluteTolerance = 0.1 * tolerance
    system.SolveDynamic(settings, solverType=exudyn.DynamicSolverType.DOPRI5)
    return np.array(system.systemData.GetODE1Coordinates())


def prepare_exudyn(scene, samples, tolerance, statistics) -> Callable[[], Motions]:
    """DOPRI5 on a user-defined first-order system, canonical form, right-hand side in Numba; end of the motion only."""
    k = equations.coefficients(scene, samples)
    x0, each = equations.canonical_start(scene, k), _arrays(k)

    def run() -> Motions:
        x = [_exudyn_motion(x0[:, i], each[i], scene.duration, tolerance) for i in range(len(each))]
        return _motions(scene, samples, k, np.stack(x, axis=1))

    run()
    return run


# ---------------------------------------------------------------------------------------------------------------------

#: Tolerances just above those at which heyoka's order changes: each order at the longest steps it allows itself.
_HEYOKA_TOLERANCES = tuple(1.2 * math.exp(-2 * order) for order in range(5, 15))

PEERS = (
    Peer("heyoka, canonical", "heyoka", 1024, _HEYOKA_TOLERANCES, prepare_heyoka),
    Peer(
        "heyoka, Cartesian", "heyoka", 1024, _HEYOKA_TOLERANCES, partial(prepare_heyoka, cartesian=True), statistics=False
    ),
    Peer("DOP853, Numba", "scipy", 8, (1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10), partial(prepare_scipy, compiled=True)),
    Peer("DOP853, NumPy", "scipy", 4, (1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10), partial(prepare_scipy, compiled=False)),
    Peer("DOP853, NumPy matrices", "scipy", 1, (1e-6, 1e-7, 1e-8, 1e-9, 1e-10), prepare_scipy_matrices),
    Peer("DOP853, NumPy stacked", "scipy", 1024, (1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10), prepare_scipy_stacked),
    Peer("SUNDIALS IDA", "scikit-sundae", 2, (1e-6, 1e-7, 1e-8, 1e-9, 1e-10), prepare_ida),
    Peer("Exudyn DOPRI5", "exudyn", 4, (1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10), prepare_exudyn, statistics=False),
)  # fmt: skip
