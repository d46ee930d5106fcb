"""A million one-second motions end to end (sampling, integration, statistics, files, pictures) against their kernels alone.

Every round integrates the samples, runs the study in this process and runs the command in a new one, so that all three see
the same machine; the kernels integrate what the study draws, with its plan and its workers.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib import rc_context
from matplotlib.figure import Figure
from study_tools import BLUE, GREY, ROOT, STYLE, arguments, save, show

from tolmc import load_study
from tolmc.runs import run as monte_carlo
from tolmc.simulation.ensemble import integrate_columns
from tolmc.simulation.outputs import scene_outputs
from tolmc.study.study import Study
from tolmc.tolerances.draw import sample

STUDY = ROOT / "studies" / "paper_joint.toml"
KERNELS, RUN, COMMAND = "kernels alone", "run, in a process that has run before", "command, in a new process"

# A process is charged with the memory of the one that starts it: a small one stands between.
LAUNCHER = """
import os, sys
silence = [(os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0)]
process = os.posix_spawn(sys.argv[1], sys.argv[1:], os.environ, file_actions=silence)
_, status, used = os.wait4(process, 0)
print(used.ru_utime + used.ru_stime, used.ru_maxrss / 1024)
sys.exit(status != 0)
"""


def kernels(study: Study) -> Callable[[], None]:
    """Integrates the samples of the study and nothing else."""
    plan = monte_carlo.run(study.replaced(samples=1_000)).plan
    drawn = sample(study.tolerances, study.samples, sampling=study.sampling, seed=study.seed, total=study.samples)
    columns = {name: drawn[name].to_numpy() for name in drawn}
    outputs = scene_outputs(plan, study.project_energy)

    def integrate() -> None:
        integrate_columns(study.scene, columns, study.samples, plan=plan, outputs=outputs, workers=study.workers)

    return integrate


def measured(work: Callable[[], None]) -> tuple[float, float]:
    """Wall and processor seconds of ``work`` in this process."""
    wall, processor = time.perf_counter(), time.process_time()
    work()
    return time.perf_counter() - wall, time.process_time() - processor


def command(study: Study, folder: Path) -> tuple[float, float, float]:
    """Wall and processor seconds and peak memory (MB) of ``tolmc run``."""
    call = [Path(sys.executable).with_name("tolmc"), "run", STUDY, "--samples", str(study.samples), "--out", folder]
    wall = time.perf_counter()
    done = subprocess.run([sys.executable, "-S", "-c", LAUNCHER, *call], stdout=subprocess.PIPE, text=True, check=True)
    wall = time.perf_counter() - wall
    processor, peak = map(float, done.stdout.split())
    return wall, processor, peak


def rounds(study: Study, count: int) -> pd.DataFrame:
    """A row a round and way: seconds, processor seconds, peak memory of the new process."""
    integrate, rows = kernels(study), []
    with tempfile.TemporaryDirectory() as folder:
        monte_carlo.run(study.replaced(samples=20_000), out=Path(folder) / "warm")
        for number in range(count):
            directories = Path(folder) / f"run{number}", Path(folder) / f"command{number}"
            rows.append((number, KERNELS, *measured(integrate), np.nan))
            rows.append((number, RUN, *measured(lambda out=directories[0]: monte_carlo.run(study, out=out)), np.nan))
            rows.append((number, COMMAND, *command(study, directories[1])))
    return pd.DataFrame(rows, columns=["round", "what", "seconds", "processor", "peak MB"])


def summary(table: pd.DataFrame) -> pd.DataFrame:
    """A row a way: least time, its ratio to the kernels' least, and the median of the ratios within a round."""
    seconds = table.pivot(index="round", columns="what", values="seconds")
    ways = table.groupby("what", sort=False)
    least = ways["seconds"].min()
    return pd.DataFrame(
        {
            "seconds": least,
            "processor s": ways["processor"].min(),
            "ratio": least / least[KERNELS],
            "ratio, median of rounds": seconds.div(seconds[KERNELS], axis=0).median(),
            "peak MB": ways["peak MB"].max(),
        },
        index=least.index,
    ).reset_index()


def draw(table: pd.DataFrame, samples: int) -> Figure:
    """Times of the three ways."""
    with rc_context(STYLE):
        figure = Figure(figsize=(8, 2.6), layout="constrained")
        axes = figure.subplots()
        axes.barh(table["what"], table["seconds"], color=[GREY, BLUE, BLUE])
        for place, row in table.iterrows():
            against = "" if row["what"] == KERNELS else f", {row['ratio']:.2f} times the kernels"
            axes.text(row["seconds"], place, f" {row['seconds']:.1f} s{against}", va="center")
        axes.set(
            xlabel="wall time (s)", title=f"{samples:,} one-second motions", xlim=(0, 1.6 * table["seconds"].max())
        )
        axes.invert_yaxis()
        axes.grid(axis="y", visible=False)
    return figure


def main() -> None:
    """Measure, print the table, draw the figure."""
    options = arguments(__doc__)
    study = load_study(STUDY).replaced(samples=20_000 if options.quick else 1_000_000)
    table = summary(rounds(study, 1 if options.quick else 5))
    title = f"{study.samples:,} one-second motions of the paper's joint, {study.workers} workers"
    show(
        title,
        table,
        {"seconds": ".2f", "processor s": ".2f", "ratio": ".2f", "ratio, median of rounds": ".2f", "peak MB": ".0f"},
    )
    save(draw(table, study.samples), options.figures / "end_to_end.png")


if __name__ == "__main__":
    main()
