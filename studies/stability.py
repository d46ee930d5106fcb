"""Stress suite: where each formulation holds, judged by an independent integration of every scene.

    python studies/stability.py [--quick]

Every scene runs in slope coordinates, in the paper's coordinates with the regular constraint rows and with the published
ones, and in slope coordinates on the exact section. A verdict is one of

- right: position over r, tilt over its range and contact forces over the largest one agree with the reference along the whole
  motion, and a loss of contact is reported when and only when there is one;
- status: the motion ended, or is marked, with a status that is true: the singular set that is named is near, or the error is
  as large as the status says;
- WRONG: numbers that are wrong under a status that lets them pass, or a status that is not true.

The reference of the circle is a plain NumPy form of the equations (tests/helpers/twins) under SciPy's DOP853 at 1e-13, that of
the exact section the same motion in a third of the step. Long runs show the drift of energy, momentum about Z and constraints.
Prints the tables, draws figures/stability.png, and fails when anything is wrong.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable
from dataclasses import asdict, dataclass, replace

import numpy as np
import pandas as pd
from matplotlib import rc_context
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle
from rich.console import Console
from rich.progress import track
from stability_drift import draw_drift, drift_table, long_runs
from stability_scenes import Case, suite
from study_tools import ROOT, STYLE, arguments, save, show

from tolmc.mechanism.scene import Joint, Scene
from tolmc.simulation.trajectory import Trajectory, simulate

sys.path.insert(0, str(ROOT / "tests" / "helpers"))
from twins import slope_twin

FORMULATIONS = ("slope", "published-regular", "published", "exact section")
ACCURACY = 1e-8  # asked for where the pilot chooses the step
COARSE_ACCURACY = 1e-4  # what a motion with a given step is judged by: tolmc's default
WITHIN = 10  # times the accuracy: deviation of a right number
ROWS = 40  # instants at which motions are compared
NEAR = 0.1  # distance within which a named singular set has to be
COLOURS = {"right": "#a6d3ee", "status": "#f5c767", "WRONG": "black"}


@dataclass(frozen=True)
class Outcome:
    """What a formulation made of a scene."""

    verdict: str  # "right", "status" or "WRONG"
    status: str
    error: float  # largest deviation from the reference
    constraint: float  # largest relative constraint error

    @property
    def word(self) -> str:
        """The status without its time and numbers."""
        return self.status.split(" at t")[0].split(":")[0]


def run(case: Case, formulation: str) -> Trajectory:
    """The motion of a case in a formulation."""
    scene = case.scene
    if formulation == "exact section":
        scene, formulation = on_exact_section(scene), "slope"
    accuracy = ACCURACY if case.step is None else None
    return simulate(scene, step=case.step, method=case.method, formulation=formulation, accuracy=accuracy)


def on_exact_section(scene: Scene) -> Scene:
    """The scene with the exact section."""
    return replace(scene, joint=replace(scene.joint, section="exact"))


def compared_rows(trajectory: Trajectory) -> np.ndarray:
    """Rows at which a motion is compared: some forty, the first and the last among them."""
    return np.unique(np.linspace(0, len(trajectory.time) - 1, ROWS).round().astype(int))


@dataclass(frozen=True)
class Motions:
    """Positions over r, slopes of the axis over r/L, contact forces in N at given times, arrays (n, 2)."""

    time: np.ndarray
    origin: np.ndarray
    slope: np.ndarray
    contact_force: np.ndarray
    status: str = "ok"

    @classmethod
    def of(cls, motion, joint: Joint, rows=slice(None)) -> Motions:
        r, L = joint.effective_radius, joint.half_length
        with np.errstate(invalid="ignore"):  # the axis of a motion that has diverged
            slope = motion.axis[rows, :2] / motion.axis[rows, 2:]
        return cls(motion.time[rows], motion.origin[rows] / r, slope * (L / r), motion.contact_force[rows])

    def at(self, times: np.ndarray) -> Motions:
        """The same motion at some of its times, as close as rounding lets them be."""
        rows = np.abs(self.time[:, None] - times).argmin(axis=0)
        return Motions(self.time[rows], self.origin[rows], self.slope[rows], self.contact_force[rows])


def deviation(found: Motions, exact: Motions) -> float:
    """Largest deviation of positions, slopes and, over the largest one, forces."""
    scale = np.abs(exact.contact_force).max()
    force = np.abs(found.contact_force - exact.contact_force).max() / (scale or 1.0)
    state = max(np.abs(found.origin - exact.origin).max(), np.abs(found.slope - exact.slope).max())
    worst = max(state, force)
    return worst if np.isfinite(worst) else math.inf


def status_time(status: str) -> float:
    """Time that a status names, NaN when it names none."""
    return float(status.split(" t = ")[1].split(" s")[0]) if " t = " in status else math.nan


def circle_reference(scene: Scene, found: Iterable[Trajectory]) -> Motions:
    """The independent motion at the times at which the found ones are compared, and where their statuses point."""
    times = [time for t in found for time in (*t.time[compared_rows(t)], status_time(t.status))]
    times = np.unique([0.0, *(t for t in times if 0 <= t <= scene.duration)])
    return Motions.of(slope_twin.integrate(scene.scalars, times), scene.joint)


def section_reference(scene: Scene, found: Trajectory) -> Motions:
    """The motion on the exact section in a third of the step or less, at the times at which the found one is compared."""
    steps = len(found.time) - 1
    finer = max(3, math.ceil(600 / steps))
    motion = simulate(scene, step=scene.duration / (finer * steps), accuracy=1.0)
    return replace(Motions.of(motion, scene.joint, finer * compared_rows(found)), status=motion.status)


def singular_distance(reference: Motions, joint: Joint, name: str, time: float) -> float:
    """Distance of the motion from a singular set around a time."""
    near = np.argsort(np.abs(reference.time - time))[:3]
    x, y = reference.origin[near].T
    psi = np.arctan2(y, x)
    distances = {
        "psi = k pi/2": np.minimum(np.abs(np.sin(psi)), np.abs(np.cos(psi))),
        "X0 = Y0 = 0": np.hypot(x, y),
        "theta = 0": np.hypot(*reference.slope[near].T) * joint.effective_radius / joint.half_length,
    }
    return float(distances[name].min())


def contact_is_told(status: str, reference: Motions) -> bool:
    """Whether a loss of contact is reported when the reference has one and only then, at the right time."""
    told, time = status.startswith("contact lost"), status_time(status)
    if reference.status.startswith("contact lost"):
        return told and abs(time - status_time(reference.status)) <= 1e-5 * reference.time[-1]
    smallest = reference.contact_force.min(axis=1) / np.abs(reference.contact_force).max()
    before = reference.time < time if told else slice(None)
    kept = np.all(smallest[before] > -1e-6)
    return bool(kept and (not told or smallest[np.abs(reference.time - time).argmin()] < 1e-5))


def judge(case: Case, found: Trajectory, reference: Motions) -> Outcome:
    """Verdict on a motion."""
    joint = case.scene.joint
    accuracy = ACCURACY if case.step is None else COARSE_ACCURACY
    own = Motions.of(found, joint, compared_rows(found))
    error = deviation(own, reference.at(own.time))
    ends = np.hypot(*(own.origin + own.slope).T), np.hypot(*(own.origin - own.slope).T)
    constraint = max(np.abs(end - 1).max() for end in ends)
    outcome = Outcome("status", found.status, error, constraint)
    if outcome.word in ("ok", "contact lost"):
        # With a coarse step a force that nearly vanishes may do so or not.
        told = case.step is not None or contact_is_told(found.status, reference)
        return replace(outcome, verdict="right" if error <= WITHIN * accuracy and told else "WRONG")
    if outcome.word == "singular":
        name = found.status.split("s: ")[1]
        near = singular_distance(reference, joint, name, status_time(found.status)) < NEAR
        # What was found up to there must be right as well.
        return replace(outcome, verdict="status" if near and error <= WITHIN * accuracy else "WRONG")
    return outcome


def examine(cases: list[Case]) -> pd.DataFrame:
    """Outcomes of all formulations on cases that share a scene, a row a case and formulation."""
    scene = cases[0].scene
    found = [{f: run(case, f) for f in FORMULATIONS} for case in cases]
    circle = circle_reference(scene, [t for motions in found for f, t in motions.items() if f != "exact section"])
    rows = []
    for case, motions in zip(cases, found, strict=True):
        for formulation, motion in motions.items():
            exact = formulation == "exact section"
            reference = section_reference(on_exact_section(scene), motion) if exact else circle
            outcome = judge(case, motion, reference)
            if exact:  # the ends do not lie on circles there
                outcome = replace(outcome, constraint=math.nan)
            place = {"group": case.group, "row": case.row, "column": case.column, "formulation": formulation}
            rows.append({**place, **asdict(outcome), "word": outcome.word})
    return pd.DataFrame(rows)


def stress(cases: list[Case]) -> pd.DataFrame:
    """Outcomes of the whole suite."""
    shared: dict[int, list[Case]] = {}
    for case in cases:
        shared.setdefault(id(case.scene), []).append(case)
    progress = track(shared.values(), "Scenes", console=Console(stderr=True))
    return pd.concat([examine(group) for group in progress], ignore_index=True)


# --- Reporting -------------------------------------------------------------------------------------------------------


def counts_table(outcomes: pd.DataFrame) -> pd.DataFrame:
    """Verdicts of each group and formulation, and the largest deviation and constraint error of what is right."""
    rows = []
    for (group, formulation), part in outcomes.groupby(["group", "formulation"], sort=False):
        verdicts = part.verdict.value_counts()
        right = part[part.verdict == "right"]
        words = part[part.verdict == "status"].word.value_counts()
        rows.append(
            {"scenes": group, "formulation": formulation, **{v: int(verdicts.get(v, 0)) for v in COLOURS},
             "largest deviation": right.error.max(), "constraint error": right.constraint.max(),
             "statuses": ", ".join(f"{word} {n}" for word, n in words.items())}
        )  # fmt: skip
    return pd.DataFrame(rows)


def draw(outcomes: pd.DataFrame, runs: dict[str, pd.DataFrame]) -> Figure:
    """A map of verdicts for each group and formulation, and the long runs."""
    groups = {name: part for name, part in outcomes.groupby("group", sort=False)}
    heights = [0.9 + part.row.nunique() * 0.24 for part in groups.values()]
    with rc_context({**STYLE, "axes.grid": False}):
        figure = Figure(figsize=(17, sum(heights) + 6.0), layout="constrained")
        figure.suptitle("Where each formulation holds")
        maps, long = figure.subfigures(2, 1, height_ratios=[sum(heights) + 0.9, 4.4])
        axes = maps.subplots(len(groups), len(FORMULATIONS), squeeze=False, height_ratios=heights)
        for line, (name, part) in zip(axes, groups.items(), strict=True):
            for axis, formulation in zip(line, FORMULATIONS, strict=True):
                _draw_map(axis, part[part.formulation == formulation])
                axis.set_xlabel(name)
            for axis in line[1:]:
                axis.set_yticklabels([])
        for axis, formulation in zip(axes[0], FORMULATIONS, strict=True):
            axis.set_title(formulation, fontsize=13)
        words = {
            "right": "right (number: agreeing digits)",
            "status": "true status (s: singular set named, i: inaccurate, d: diverged)",
            "WRONG": "wrong",
        }
        handles = [Patch(facecolor=COLOURS[verdict], label=label) for verdict, label in words.items()]
        maps.legend(handles=handles, loc="outside upper center", ncols=3)
        draw_drift(*long.subplots(1, 2), runs)
    return figure


def _draw_map(axis, part: pd.DataFrame) -> None:
    rows, columns = list(part.row.unique()), list(part.column.unique())
    for outcome in part.itertuples():
        x, y = columns.index(outcome.column), rows.index(outcome.row)
        axis.add_patch(Rectangle((x, y), 1, 1, facecolor=COLOURS[outcome.verdict], edgecolor="white"))
        text = outcome.word[0] if outcome.verdict == "status" else f"{-math.log10(max(outcome.error, 1e-16)):.0f}"
        colour = "white" if outcome.verdict == "WRONG" else "black"
        axis.text(x + 0.5, y + 0.5, text, ha="center", va="center", fontsize=7, color=colour)
    axis.set(xlim=(0, len(columns)), ylim=(len(rows), 0))
    axis.set_xticks(np.arange(len(columns)) + 0.5, columns, rotation=90, fontsize=7)
    axis.set_yticks(np.arange(len(rows)) + 0.5, rows, fontsize=8)
    axis.tick_params(length=0)
    axis.spines[:].set_visible(False)


def main() -> None:
    """The suite, the long runs, tables and figure."""
    options = arguments(__doc__)
    outcomes = stress(suite(options.quick))
    show(
        f"Verdicts (right: within {WITHIN} times the accuracy asked for)",
        counts_table(outcomes), {"largest deviation": ".1e", "constraint error": ".1e"},
    )  # fmt: skip
    wrong = outcomes[outcomes.verdict == "WRONG"]
    if len(wrong):
        show("Wrong", wrong.drop(columns=["verdict", "word"]), {"error": ".1e", "constraint": ".1e"})
    runs = long_runs(options.quick)
    show(
        "Long runs: largest error, the power of the number of steps that it grows with, and its rate",
        drift_table(runs), {"steps": ",d", "drift": ".1e", "exponent": ".2f", "a step": ".1e"},
    )  # fmt: skip
    save(draw(outcomes, runs), options.figures / "stability.png")
    if len(wrong):
        sys.exit(f"{len(wrong)} outcomes are wrong.")


if __name__ == "__main__":
    main()
