"""Run time against error: tolmc and other people's integrators on the paper's joint, in one run on one core.

    python studies/work_precision.py [--processes N] [--rounds N]

Every setting of every method is prepared and run once beforehand (compilation, warm caches); then all are timed in turn,
round after round. That is done in several processes one after another, and the best time of each setting counts: heyoka's
speed differs by up to 45 % from one process to the next. Errors are the largest over the first samples against DOP853 at
rounding level: of origin/r and axis at the end, and, relative to their own size, of the maxima and means over time of the
contact forces. Times at a given error are interpolated along each method's fastest settings, log against log.
Prints the tables and writes figures/work_precision.csv and figures/work_precision.png.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import platform
import time
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from importlib import metadata
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from operations import step_operations
from peer_equations import Samples, effective_radius
from peers import PEERS, Motions, reference
from threadpoolctl import threadpool_limits

from tolmc.mechanism.scene import Body, Joint, Loads, Motion, Scene
from tolmc.quantities import ALWAYS, END_OUTPUTS
from tolmc.simulation.ensemble import simulate_many

ROOT = Path(__file__).parents[1]
TARGETS = (1e-6, 1e-7, 1e-8, 1e-10)
CHECKED = 8  # samples whose errors are measured
QUANTITIES = {"state": "end of the motion", "peak": "contact-force peak", "mean": "contact-force mean"}

# --- tolmc: the only lines that know its interface -------------------------------------------------------------------

#: Method, formulation, number of samples, numbers of steps.
TOLMC = (
    ("rk8", "slope", 8192, (26, 30, 34, 38, 42, 50, 58, 66, 76, 90, 105, 125, 150, 180, 220)),
    ("rk4", "slope", 8192, (200, 400, 800, 1600, 3200, 6400)),
    ("rk8", "published-regular", 64, (40, 60, 80, 110, 160, 250)),
)
PEAKS = ["contact_force_D_max", "contact_force_E_max"]
MEANS = ["contact_force_D_mean", "contact_force_E_mean"]
#: Floating-point operations of one step of the slope formulation, motion only.
OPERATIONS_PER_STEP = {method: step_operations(method) for method in ("rk4", "rk8")}


def tolmc_motion(
    scene: Scene, samples: Samples, method: str, steps: int, statistics: bool, formulation: str = "slope"
) -> Motions:
    """The samples' motions by tolmc with equal steps; with statistics everything that it reports, else the end only."""
    results = simulate_many(
        scene, **samples, step=scene.duration / steps, method=method, formulation=formulation,
        outputs=(*ALWAYS, *END_OUTPUTS) if statistics else END_OUTPUTS,
    )  # fmt: skip
    state = np.stack([results[name].to_numpy() for name in END_OUTPUTS], axis=1)
    state[:, :2] /= effective_radius(samples)[:, None]
    if not statistics:
        return Motions(state)
    return Motions(state, results[PEAKS].to_numpy(), results[MEANS].to_numpy())


# --- Measuring -------------------------------------------------------------------------------------------------------


@dataclass
class Setting:
    """One method at one tolerance or number of steps."""

    method: str
    setting: float
    statistics: bool
    samples: int
    run: Callable[[], Motions]
    best: float = np.inf


def paper_joint() -> tuple[Scene, Motions]:
    """The paper's joint with gravity across the bearing, and its motion by an independent integrator."""
    case = json.loads((ROOT / "tests/data/trajectories.json").read_text())["paper_joint_tilted_start"]
    expected = case["expected"]
    origin = np.array(expected["origin"]) / expected["effective_radius"]
    motion = Motions(
        np.array([[*origin, *expected["axis"]]]),
        np.array([[expected[name] for name in PEAKS]]),
        np.array([[expected[name] for name in MEANS]]),
    )
    scene = Scene(
        Joint(case["bearing_radius"], case["journal_radius"], case["half_length"]),
        Body(case["mass"], case["center_of_mass"], case["inertia"]),
        Loads(tuple(case["gravity"])),
        Motion(**case["motion"]),
        case["duration"],
    )
    return scene, motion


def draw_samples(joint: Joint, count: int) -> Samples:
    """Dimensions within 0.5 % of nominal, the nominal joint first."""
    factor = 1 + 0.005 * np.random.default_rng(2026).uniform(-1, 1, (3, count))
    factor[:, 0] = 1
    names = ("bearing_radius", "journal_radius", "half_length")
    return {name: getattr(joint, name) * f for name, f in zip(names, factor, strict=True)}


def _first(samples: Samples, count: int) -> Samples:
    return {name: column[:count] for name, column in samples.items()}


def tolmc_settings(scene: Scene, samples: Samples) -> Iterable[Setting]:
    """tolmc's methods and formulations."""
    for method, formulation, count, all_steps in TOLMC:
        chosen = _first(samples, count)
        for steps in all_steps:
            for statistics in (False, True):
                run = partial(tolmc_motion, scene, chosen, method, steps, statistics, formulation)
                yield Setting(f"tolmc {method}, {formulation}", steps, statistics, count, run)


def peer_settings(scene: Scene, samples: Samples) -> Iterable[Setting]:
    """The peers that are installed."""
    for peer in PEERS:
        if peer.version is None:
            continue
        for tolerance in peer.tolerances:
            for statistics in (False, True)[: 1 + peer.statistics]:
                run = peer.prepare(scene, _first(samples, peer.samples), tolerance, statistics)
                yield Setting(peer.name, tolerance, statistics, peer.samples, run)


def errors(motions: Motions, exact: Motions) -> dict[str, float]:
    """Largest error of each quantity over the samples that both have; NaN for what was not computed."""
    found = {}
    for quantity, reference_values in vars(exact).items():
        values = getattr(motions, quantity)
        count = 0 if values is None else min(len(values), len(reference_values))
        if count == 0:
            found[quantity] = np.nan
            continue
        scale = 1 if quantity == "state" else reference_values[:count]
        found[quantity] = float(np.abs((values[:count] - reference_values[:count]) / scale).max())
    return found


def measure(settings: list[Setting], exact: Motions, rounds: int) -> pd.DataFrame:
    """A row a setting: its errors, and the time of one motion."""
    found = [errors(setting.run(), exact) for setting in settings]
    for _ in range(rounds):
        for setting in settings:
            begin = time.perf_counter()
            setting.run()
            setting.best = min(setting.best, time.perf_counter() - begin)
    return pd.DataFrame(
        {
            "method": s.method,
            "setting": s.setting,
            "statistics": s.statistics,
            "time": s.best / s.samples,
            **error,
        }
        for s, error in zip(settings, found, strict=True)
    )


def matrix_product_rate() -> float:
    """Floating-point operations a second of a 2,000 x 2,000 matrix product."""
    n = 2000
    a, b = np.random.default_rng(0).random((2, n, n))
    best = np.inf
    for _ in range(5):
        begin = time.perf_counter()
        a @ b
        best = min(best, time.perf_counter() - begin)
    return 2 * n**3 / best


# --- Reporting -------------------------------------------------------------------------------------------------------


def front(points: pd.DataFrame, quantity: str) -> pd.DataFrame:
    """Settings than which no faster one is as accurate, fastest first."""
    points = points[points[quantity] > 0].sort_values("time")
    return points[points[quantity] < points[quantity].cummin().shift(fill_value=np.inf)]


def time_at(points: pd.DataFrame, quantity: str, error: float) -> float:
    """Time of a motion at the error, s; NaN where no setting reaches it, the loosest setting's where all do."""
    points = front(points, quantity)
    if points.empty or points[quantity].min() > error:
        return np.nan
    log = np.log(points[[quantity, "time"]].to_numpy())[::-1]
    return float(np.exp(np.interp(np.log(error), log[:, 0], log[:, 1])))


def table(results: pd.DataFrame, quantity: str) -> str:
    """Markdown: samples a second of every method at each target error, and how many times tolmc's best that takes."""
    times = pd.DataFrame(
        {
            target: {m: time_at(p, quantity, target) for m, p in results.groupby("method", sort=False)}
            for target in TARGETS
        }
    )
    own = times[times.index.str.startswith("tolmc")].min()
    lines = ["| | " + " | ".join(f"{t:.0e}" for t in TARGETS) + " |", "|---|" + "---:|" * len(TARGETS)]
    for method, row in times.iterrows():
        cells = ["–" if np.isnan(t) else f"{1 / t:,.0f}/s, {t / own[target]:,.2f}" for target, t in row.items()]
        lines.append(f"| {method} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def draw(results: pd.DataFrame) -> Figure:
    """Work-precision diagrams of the three quantities."""
    figure = Figure(figsize=(15, 6.2), layout="constrained")
    methods = list(results.method.unique())
    axes = figure.subplots(1, len(QUANTITIES), sharey=True)
    for ax, (quantity, label) in zip(axes, QUANTITIES.items(), strict=True):
        chosen = results[results.statistics == (quantity != "state")]
        for method, points in chosen.groupby("method", sort=False):
            points = front(points, quantity)
            i = methods.index(method)
            own = method.startswith("tolmc")
            ax.loglog(
                points[quantity], points.time, marker="o" if own else ".", color=f"C{i}" if i < 10 else "k",
                linewidth=2 if own else 1, linestyle="-" if own else "--", label=method,
            )  # fmt: skip
        ax.set(xlabel=f"error of the {label}", xlim=(1e-12, 1e-3))
        ax.invert_xaxis()
        ax.grid(color="#e4e4e4")
    axes[0].set_ylabel("time of a motion of one second, s")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False)
    figure.suptitle("Run time against error, the paper's joint, one core")
    return figure


def machine() -> str:
    """Processor, and the versions of what was measured."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    models = [line.split(":")[1].strip() for line in lines if line.startswith("model name")] or [platform.processor()]
    packages = ["tolmc", "numba", "numpy", *dict.fromkeys(peer.package for peer in PEERS if peer.version)]
    versions = ", ".join(f"{package} {metadata.version(package)}" for package in packages)
    return f"{models[0]}, {platform.system()}, Python {platform.python_version()}, {versions}"


def machine_share(results: pd.DataFrame, rate: float) -> list[str]:
    """tolmc's floating-point operations a second against those of the matrix product."""
    lines = [f"2,000 x 2,000 matrix product on one core: {rate / 1e9:.1f} GFlop/s"]
    for method, operations in OPERATIONS_PER_STEP.items():
        points = results[(results.method == f"tolmc {method}, slope") & ~results.statistics]
        own = operations * (points.setting / points.time).max()
        lines.append(f"tolmc {method}, slope: {own / 1e9:.1f} GFlop/s, {own / rate:.2f} of it")
    return lines


def measure_once(rounds: int) -> tuple[pd.DataFrame, dict[str, float], float]:
    """All settings measured in this process; errors of the reference against the file's; rate of the matrix product."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    with threadpool_limits(1):
        scene, independent = paper_joint()
        samples = draw_samples(scene.joint, 8192)
        settings = [*tolmc_settings(scene, samples), *peer_settings(scene, samples)]
        exact = reference(scene, _first(samples, CHECKED))
        return measure(settings, exact, rounds), errors(exact, independent), matrix_product_rate()


def measure_in_processes(processes: int, rounds: int) -> tuple[pd.DataFrame, dict[str, float], float]:
    """:func:`measure_once` in processes one after another: each setting's best time, and in ``spread`` the worst over it."""
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=spawn, max_tasks_per_child=1) as pool:
        measured = [pool.submit(measure_once, rounds).result() for _ in range(processes)]
    times = np.array([results.time for results, _, _ in measured])
    results, agreement, _ = measured[0]
    results["time"], results["spread"] = times.min(axis=0), times.max(axis=0) / times.min(axis=0)
    return results, agreement, max(rate for _, _, rate in measured)


def main() -> None:
    """Measure, print the tables, write the figure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--processes", type=int, default=4, help="processes that measure in turn (default 4)")
    parser.add_argument("--rounds", type=int, default=2, help="times that each times every setting (default 2)")
    options = parser.parse_args()
    for peer in PEERS:
        if peer.version is None:
            print(f"{peer.name}: skipped, package {peer.package} is not installed (pip install '.[benchmark]')")
    results, agreement, rate = measure_in_processes(options.processes, options.rounds)
    print(machine())
    print(*machine_share(results, rate), sep="\n")
    found = ", ".join(f"{q} {error:.0e}" for q, error in agreement.items())
    print(f"Reference against tests/data/trajectories.json, nominal joint: {found}")
    spread = ", ".join(
        f"{method} {value:.2f}" for method, value in results.groupby("method", sort=False).spread.median().items()
    )
    print(f"Time in the slowest process over the best: {spread}")
    print("\nSamples a second at each error, and the time as a multiple of tolmc's best.")
    plain = results[~results.statistics]
    print(f"\nEnd of the motion, motion only\n\n{table(plain, 'state')}")
    with_statistics = results[results.statistics | ~results.method.str.startswith("tolmc")].copy()
    with_statistics.loc[~with_statistics.statistics, "method"] += " (motion only)"
    print(f"\nEnd of the motion, tolmc with all statistics\n\n{table(with_statistics, 'state')}")
    for quantity in ("peak", "mean"):
        print(f"\n{QUANTITIES[quantity].capitalize()}\n\n{table(results[results.statistics], quantity)}")
    results.drop(columns="spread").to_csv(ROOT / "figures/work_precision.csv", index=False, float_format="%.4g")
    draw(results).savefig(ROOT / "figures/work_precision.png", dpi=150)


if __name__ == "__main__":
    main()
