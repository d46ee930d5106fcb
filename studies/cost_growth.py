"""How cost grows: time against samples, steps and workers, with the constants of the straight lines through it."""

from __future__ import annotations

import os
import time

import numpy as np
import pandas as pd
from matplotlib import rc_context
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter, NullLocator
from study_tools import BLUE, GREY, STYLE, arguments, paper_joint, save, show

from tolmc.simulation.ensemble import simulate_many


def seconds(samples: int, steps: int, workers: int, rounds: int) -> float:
    """Least wall time of ``samples`` one-second motions with all statistics, s."""
    scene = paper_joint()
    joint, rng = scene.joint, np.random.default_rng(1)
    columns = {
        name: getattr(joint, name) * (1.0 + 1e-3 * rng.uniform(-1, 1, samples))
        for name in ("bearing_radius", "journal_radius", "half_length")
    }
    best = np.inf
    for _ in range(rounds + 1):
        began = time.perf_counter()
        simulate_many(scene, **columns, step=scene.duration / steps, workers=workers)
        best = min(best, time.perf_counter() - began)
    return best


def series(quick: bool) -> pd.DataFrame:
    """Times along each of the three directions from 64 steps, one worker."""
    rounds = 1 if quick else 4
    samples = (1_024, 4_096) if quick else (1_024, 4_096, 16_384, 65_536, 262_144)
    steps = (32, 64) if quick else (32, 64, 128, 256, 512)
    rows = [("samples", n, seconds(n, 64, 1, rounds)) for n in samples]
    rows += [("steps", n, seconds(4_096, n, 1, rounds)) for n in steps]
    # What else runs on a shared machine takes a second worker away now and then: twice as many rounds find it whole.
    batch = 8_192 if quick else 65_536
    rows += [("workers", n, seconds(batch, 64, n, 2 * rounds)) for n in range(1, (os.cpu_count() or 1) + 1)]
    return pd.DataFrame(rows, columns=["along", "number", "seconds"])


def line(part: pd.DataFrame) -> tuple[float, float]:
    """Slope and intercept of the straight line through a series, weighted for relative errors."""
    slope, intercept = np.polyfit(part["number"], part["seconds"], 1, w=1 / part["seconds"])
    return slope, intercept


def draw(table: pd.DataFrame) -> Figure:
    """Time against samples, steps and workers."""
    with rc_context(STYLE):
        figure = Figure(figsize=(11, 3.8), layout="constrained")
        for axes, along in zip(figure.subplots(1, 3), ("samples", "steps", "workers"), strict=True):
            part = table[table["along"] == along]
            axes.plot(part["number"], part["seconds"], "o", color=BLUE)
            if along == "workers":
                axes.plot(
                    part["number"],
                    part["seconds"].iloc[0] / part["number"],
                    color=GREY,
                    label="one worker's time, shared",
                )
                axes.set_xticks(part["number"])
                axes.set_ylim(0, None)
            else:
                slope, intercept = line(part)
                axes.plot(part["number"], intercept + slope * part["number"], color=GREY, label="straight line")
                axes.set(xscale="log", yscale="log")
                if along == "steps":
                    axes.set_xticks(part["number"], [f"{number}" for number in part["number"]])
                    axes.xaxis.set_minor_locator(NullLocator())
                    axes.yaxis.set_minor_formatter(NullFormatter())
            axes.set(xlabel=along, ylabel="time (s)", title=f"Time against {along}")
            axes.legend()
    return figure


def main() -> None:
    """Measure, print the tables and constants, draw the figure."""
    options = arguments(__doc__)
    table = series(options.quick)
    show("Time of one-second motions of the paper's joint with all statistics", table, {"seconds": ".4f"})
    slope, intercept = line(table[table["along"] == "samples"])
    print(f"64 steps, one worker: {1e6 * slope:.2f} µs a sample and {1e3 * intercept:.1f} ms a call")
    slope, intercept = line(table[table["along"] == "steps"])
    print(f"one worker: {1e9 * slope / 4096:.1f} ns a step and {1e6 * intercept / 4096:.2f} µs a motion")
    workers = table[table["along"] == "workers"]["seconds"]
    print(f"{len(workers)} workers: {workers.iloc[0] / workers.iloc[-1]:.2f} times one")
    save(draw(table), options.figures / "cost_growth.png")


if __name__ == "__main__":
    main()
