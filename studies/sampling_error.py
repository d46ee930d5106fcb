"""Run time against error of statistics: every estimator and plain Monte Carlo on the paper's joint, in one run on one core.

    python studies/sampling_error.py [--repeats N] [--quick]

What is asked of the largest contact force N_D: its mean, sd, 99.865 % quantile, and the share of motions above a limit that
about one in ten thousand exceeds. Every estimator answers at several sizes, each repeated with other seeds; an error is the
root mean square of the differences from the truth, a time the median of whole calls (drawing, integrating, estimating).
All integrate with the same step, chosen to 1e-8 beforehand, and everything is compiled before the first clock starts.

The truth: mean and sd from millions of motions at Sobol' points, quantile and share from importance sampling with hundreds of
thousands of motions (their seeds are used nowhere else, no surrogate takes part); both are printed with their intervals,
and both methods' answers to the latter side by side. The error of a million plain motions follows from the truth's moments and
density; its time is measured. Prints the table and writes figures/sampling_error.csv and figures/sampling_error.png.
"""

from __future__ import annotations

import argparse
import os
import platform
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib import metadata
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from tolmc.analysis.corrected import corrected
from tolmc.analysis.direct import plain, sobol
from tolmc.analysis.importance import importance
from tolmc.analysis.model import study_model
from tolmc.analysis.questions import Answer, Question
from tolmc.analysis.surrogate import Model
from tolmc.study.file import load_study
from tolmc.study.study import Study
from tolmc.tolerances.draw import sample

ROOT = Path(__file__).parents[1]
OUTPUT = "contact_force_D_max"
MILLION = 1_000_000
TARGETS = {"mean": 100, "sd": 100, "quantile": 20, "above": 20}
TITLES = {"mean": "mean", "sd": "standard deviation", "quantile": "99.865 % quantile", "above": "share above the limit"}
TRUTH_SEED, FIRST_SEED = 990_000, 1
#: Sizes of each estimator (motions; for the surrogate: training, correcting) and the share of the repeats that they get.
SIZES = {
    "plain Monte Carlo": {(10_000,): 1.0, (100_000,): 0.5, (MILLION,): 0.125},
    "Sobol'": {(2**10,): 1.0, (2**12,): 1.0, (2**14,): 1.0, (2**16,): 0.5, (2**18,): 0.25},
    "corrected surrogate": {(20, 16): 1.0, (64, 64): 1.0, (256, 256): 1.0},
    "importance sampling": {(60,): 1.0, (250,): 1.0, (1000,): 1.0, (4000,): 1.0},
}


def answer(method: str, size: tuple[int, ...], model: Model, study: Study, questions, seed: int) -> list[Answer]:
    """The questions' answers by a method at a size."""
    if method == "corrected surrogate":
        training, motions = size
        return corrected(model, study.tolerances, questions, training=training, motions=motions, seed=seed)
    estimator = {"plain Monte Carlo": plain, "Sobol'": sobol, "importance sampling": importance}[method]
    return estimator(model, study.tolerances, questions, motions=size[0], seed=seed)


def drawn_values(model: Model, study: Study, count: int) -> np.ndarray:
    """The output at Sobol' points, drawn in blocks so that memory stays small."""
    values = np.empty(count)
    for start in range(0, count, 2**16):
        block = min(2**16, count - start)
        inputs = sample(study.tolerances, block, sampling="sobol", seed=TRUTH_SEED, start=start)
        values[start : start + block] = model(inputs)[OUTPUT]
    return values


def questions_and_truth(model: Model, study: Study, quick: bool) -> tuple[dict[Question, float], pd.Series, list[str]]:
    """What is asked, the true answers, the errors of a million plain motions, and lines that say how true."""
    values = drawn_values(model, study, 2**17 if quick else 2**22)
    limit = float(f"{np.quantile(values, 0.9999):.6g}")
    mean, sd = values.mean(), values.std()
    kurtosis = np.mean((values - mean) ** 4) / sd**4
    tails = [Question(OUTPUT, "quantile", 0.99865), Question(OUTPUT, "above", limit)]
    motions = 2**15 if quick else 2**19
    answers = importance(model, study.tolerances, tails, motions=motions, seed=TRUTH_SEED)
    by_scrambling = values.reshape(-1, 16)
    p = 1.0 - 0.99865
    step = 0.25 * p
    density = 2.0 * step / np.subtract(*np.quantile(values, [0.99865 + step, 0.99865 - step]))
    truth = {
        Question(OUTPUT, "mean"): mean,
        Question(OUTPUT, "sd"): sd,
        **{question: found.value for question, found in zip(tails, answers, strict=True)},
    }
    errors = [sd, 0.5 * sd * (kurtosis - 1.0) ** 0.5, (p * (1.0 - p)) ** 0.5 / density, answers[1].value ** 0.5]
    reference = pd.Series(np.array(errors) / MILLION**0.5, index=[question.kind for question in truth])
    spread = by_scrambling.mean(axis=0).std(ddof=1) / 4.0, by_scrambling.std(axis=0).std(ddof=1) / 4.0
    lines = [
        f"Truth, {len(values):,} Sobol' motions: mean {mean:.10g} +- {spread[0]:.1g} N, sd {sd:.8g} +- {spread[1]:.1g} N",
        f"Truth, importance sampling with {motions:,} motions: 99.865 % quantile {_interval(answers[0])} N, "
        f"share above {limit:.6g} N {_interval(answers[1])}",
        f"The Sobol' motions say: {np.quantile(values, 0.99865):.8g} N and {np.mean(values > limit):.4g}",
    ]
    return truth, reference, lines


def _interval(found: Answer) -> str:
    return f"{found.value:.8g} ({found.low:.8g} to {found.high:.8g})"


def measure(model: Model, study: Study, truth: dict[Question, float], repeats: int) -> pd.DataFrame:
    """A row a method, size and question: motions, median time, root mean square error, share of intervals that cover."""
    rows = []
    for method, sizes in SIZES.items():
        for size, share in sizes.items():
            for questions in _calls(method, list(truth)):
                rows += _repeated(method, size, model, study, questions, truth, max(round(share * repeats), 2))
    return pd.DataFrame(rows)


def _calls(method: str, questions: list[Question]) -> list[list[Question]]:
    """Plain samples answer all questions in one call; the others work for one at a time."""
    if method in ("plain Monte Carlo", "Sobol'"):
        return [questions]
    return [[question] for question in questions if question.is_tail or method != "importance sampling"]


def _repeated(method, size, model, study, questions, truth, repeats) -> list[dict]:
    answer(method, size, model, study, questions, FIRST_SEED)
    times, found = [], []
    for seed in range(FIRST_SEED, FIRST_SEED + repeats):
        began = time.perf_counter()
        found.append(answer(method, size, model, study, questions, seed))
        times.append(time.perf_counter() - began)
    rows = []
    for i, question in enumerate(questions):
        values = np.array([answers[i].value for answers in found])
        covered = [answers[i].low <= truth[question] <= answers[i].high for answers in found]
        rows.append(
            {
                "question": question.kind,
                "method": method,
                "size": "+".join(map(str, size)),
                "motions": np.mean([answers[i].motions for answers in found]),
                "time": np.median(times),
                "error": np.sqrt(np.mean((values - truth[question]) ** 2)),
                "covered": np.mean(covered),
                "repeats": repeats,
            }
        )
    return rows


def summary(results: pd.DataFrame, reference: pd.Series) -> str:
    """For each question and method: the fastest size whose error is that of a million plain motions, and the ratio."""
    million = results[(results.method == "plain Monte Carlo") & (results["size"] == str(MILLION))]
    slowest = million.set_index("question")["time"]
    lines = []
    for kind, error in reference.items():
        lines.append(
            f"\n{TITLES[kind]}: a million plain motions have the error {error:.3g} after {slowest[kind]:.3g} s"
        )
        lines.append(
            f"{'method':22}{'size':>10}{'motions':>10}{'time, s':>10}{'error / plain':>15}{'covered':>9}{'ratio':>8}"
        )
        for method, group in results[results.question == kind].groupby("method", sort=False):
            if method == "plain Monte Carlo":
                row, ratio = group.iloc[-1], 1.0
            else:
                reached = group[group.error <= error]
                row = group.loc[(reached if len(reached) else group.tail(1))["time"].idxmin()]
                # Short of it at its largest size: the time to go on to it at the rate of independent motions.
                needed = row.time * max(row.error / error, 1.0) ** 2
                ratio = slowest[kind] / needed
            lines.append(
                f"{method:22}{row['size']:>10}{row.motions:>10.0f}{row.time:>10.3g}{row.error / error:>15.2g}"
                f"{row.covered:>8.0%} {ratio:>7.0f}"
            )
        best = max(_ratios(results, kind, error, slowest[kind]), default=0.0)
        lines.append(f"target: {TARGETS[kind]} times less; reached: {best:.0f}")
    return "\n".join(lines)


def _ratios(results: pd.DataFrame, kind: str, error: float, slowest: float) -> list[float]:
    reached = results[(results.question == kind) & (results.error <= error) & (results.method != "plain Monte Carlo")]
    return (slowest / reached["time"]).tolist()


def draw(results: pd.DataFrame, reference: pd.Series) -> Figure:
    """Time against error, a panel a question; the dotted line is a million plain motions."""
    figure = Figure(figsize=(11, 7.6), layout="constrained")
    axes = figure.subplots(2, 2).flat
    colours = dict(zip(SIZES, ("#666666", "#0072B2", "#D55E00", "#009E73"), strict=True))
    for axis, (kind, error) in zip(axes, reference.items(), strict=True):
        for method, group in results[results.question == kind].groupby("method", sort=False):
            axis.loglog(group["time"], group["error"] / error, "o-", color=colours[method], label=method)
        axis.axhline(1.0, color="black", linestyle=":", linewidth=1)
        axis.set(title=TITLES[kind], xlabel="time, s", ylabel="error / error of $10^6$ plain motions")
        axis.grid(True, color="#e4e4e4")
        axis.spines[["top", "right"]].set_visible(False)
    handles, labels = figure.axes[-1].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, frameon=False)
    figure.suptitle("Largest contact force $N_D$ of the paper's joint: run time against error, one core")
    return figure


def machine() -> str:
    """Processor and versions."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    models = [line.split(":")[1].strip() for line in lines if line.startswith("model name")] or [platform.processor()]
    versions = ", ".join(f"{package} {metadata.version(package)}" for package in ("tolmc", "numba", "numpy", "scipy"))
    return f"{models[0]}, {platform.system()}, Python {platform.python_version()}, {versions}"


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, print the table, write the figure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=32, help="repeats of the small sizes (default 32)")
    parser.add_argument("--quick", action="store_true", help="small truth, few repeats, nothing written: a smoke test")
    options = parser.parse_args(arguments)
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    study = replace(load_study(ROOT / "studies/paper_joint.toml"), workers=1, step=None, accuracy=1e-8)
    model: Callable = study_model(study, (OUTPUT,))
    print(machine())
    truth, reference, lines = questions_and_truth(model, study, options.quick)
    print(*lines, sep="\n")
    results = measure(model, study, truth, 2 if options.quick else options.repeats)
    print(summary(results, reference))
    if not options.quick:
        results.to_csv(ROOT / "figures/sampling_error.csv", index=False, float_format="%.4g")
        draw(results, reference).savefig(ROOT / "figures/sampling_error.png", dpi=150)


if __name__ == "__main__":
    main()
