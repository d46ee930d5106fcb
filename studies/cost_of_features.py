"""What each feature of a scene costs, as a ratio to the leanest scene at equal steps on one core.

What a scene does not use is not computed: such rows must show 1.00 up to the noise of the machine.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from matplotlib import rc_context
from matplotlib.figure import Figure
from study_tools import BLUE, GREY, ORANGE, STYLE, arguments, paper_joint, save, show

from tolmc.mechanism.scene import Body, Loads, Scene
from tolmc.quantities import END_OUTPUTS, GEOMETRY
from tolmc.simulation.ensemble import simulate_many

STEPS = 64
MOTION = ("energy_error",)


@dataclass(frozen=True)
class Feature:
    """A scene with settings; ``base`` names the feature that it is compared with beside the leanest."""

    name: str
    scene: Scene
    settings: dict
    base: str
    unused: bool = False


def features() -> list[Feature]:
    """Every feature, each as a change of the paper's joint."""
    gravity = paper_joint()
    bare = replace(gravity, loads=Loads())
    axial = replace(gravity, loads=Loads((0.0, 0.0, -9.81)))
    force = replace(gravity, loads=Loads(gravity.loads.gravity, (1.0, 0.0, 0.5), (0.0, 0.0, 0.01)))
    zeros = replace(bare, loads=Loads(force=(0.0, 0.0, 0.0), force_point=(0.0, 0.0, 0.01), torque=(0.0, 0.0, 0.0)))
    body = gravity.body
    unbalanced = Body(body.mass, (0.001, -0.0007, 0.004), body.inertia + np.diag((1e-6, 0.0, 0.0)))
    general = replace(gravity, body=unbalanced)
    torque = replace(general, loads=replace(general.loads, torque=(0.0, 0.0, 1e-4)))
    exact, exact_general = (replace(s, joint=replace(s.joint, section="exact")) for s in (gravity, general))
    smooth, rough = (replace(gravity, joint=replace(gravity.joint, friction=mu)) for mu in (0.0, 0.05))
    motion, full = {"outputs": MOTION}, {"outputs": None}
    return [
        Feature("geometry only", gravity, {"outputs": GEOMETRY}, "no load"),
        Feature("no load", bare, motion, "no load"),
        Feature("force and torque given as zero", zeros, motion, "no load", unused=True),
        Feature("dimensions without tolerance", bare, motion | {"constant": True}, "no load", unused=True),
        Feature("geometry outputs beside the motion", bare, {"outputs": MOTION + GEOMETRY}, "no load"),
        Feature("choice on contact loss", bare, motion | {"on_contact_loss": "end"}, "no load", unused=True),
        Feature("axial gravity", axial, motion, "no load"),
        Feature("transverse gravity", gravity, motion, "no load"),
        Feature("pose at the end of the motion", gravity, {"outputs": END_OUTPUTS}, "transverse gravity"),
        Feature("force at a point of the axis", force, motion, "transverse gravity"),
        Feature("energy projected", gravity, motion | {"project_energy": True}, "transverse gravity"),
        Feature("all contact-force statistics", gravity, full, "transverse gravity"),
        Feature("two-sided after a loss", gravity, full | {"on_contact_loss": "continue"}, "all contact-force statistics"),
        Feature("every sample checked by step halving", gravity, full | {"halving": True}, "all contact-force statistics"),
        Feature("friction given as zero", smooth, full, "all contact-force statistics", unused=True),
        Feature("friction, statistics", rough, full, "all contact-force statistics"),
        Feature("general body", general, motion, "transverse gravity"),
        Feature("general body, torque", torque, motion, "general body"),
        Feature("general body, statistics", general, full, "all contact-force statistics"),
        Feature("exact section", exact, motion, "transverse gravity"),
        Feature("exact section, statistics", exact, full, "all contact-force statistics"),
        Feature("exact section, general body, statistics", exact_general, full, "general body, statistics"),
        Feature("rk4 instead of rk8", gravity, motion | {"method": "rk4"}, "transverse gravity"),
    ]  # fmt: skip


def run_of(feature: Feature, count: int) -> Callable[[], object]:
    """A call that integrates ``count`` samples of the feature's scene."""
    settings = dict(feature.settings)
    constant = settings.pop("constant", False)
    joint = feature.scene.joint
    spread = 1.0 + 1e-3 * np.random.default_rng(1).uniform(-1, 1, (3, count)) * (not constant)
    dimensions = (joint.bearing_radius, joint.journal_radius, joint.half_length)
    columns = dict(zip(("bearing_radius", "journal_radius", "half_length"), (spread.T * dimensions).T, strict=True))
    step = feature.scene.duration / STEPS
    return lambda: simulate_many(feature.scene, **columns, **{"step": step, "method": "rk8", **settings})


def measure(chosen: list[Feature], count: int, rounds: int) -> dict[str, float]:
    """Least processor time of each feature, s a sample, the features taken in turn."""
    runs = {feature.name: run_of(feature, count) for feature in chosen}
    best = dict.fromkeys(runs, np.inf)
    for run in runs.values():
        run()
    for _ in range(rounds):
        for name, run in runs.items():
            began = time.process_time()
            run()
            best[name] = min(best[name], time.process_time() - began)
    return {name: seconds / count for name, seconds in best.items()}


def draw(table: pd.DataFrame) -> Figure:
    """Bars of the ratio to the leanest scene."""
    with rc_context(STYLE):
        figure = Figure(figsize=(9, 6.5), layout="constrained")
        axes = figure.subplots()
        colours = [ORANGE if unused else BLUE for unused in table["unused"]]
        bars = axes.barh(table["feature"], table["ratio"], color=colours)
        axes.bar_label(bars, [f"{value:.2f}" for value in table["ratio"]], padding=3)
        axes.axvline(1.0, color=GREY, linewidth=1)
        axes.invert_yaxis()
        axes.grid(axis="y", visible=False)
        axes.set_xlabel("time over the leanest scene's (motion only, no load)")
        axes.set_title("What each feature costs at equal steps (orange: given but not used)")
    return figure


def main() -> None:
    """Measure, print the table, draw the figure."""
    options = arguments(__doc__)
    count, rounds = (1024, 2) if options.quick else (8192, 15)
    chosen = features()
    seconds = measure(chosen, count, rounds)
    table = pd.DataFrame(
        {
            "feature": feature.name,
            "µs a sample": 1e6 * seconds[feature.name],
            "ratio": seconds[feature.name] / seconds["no load"],
            "against": feature.base,
            "ratio to that": seconds[feature.name] / seconds[feature.base],
            "unused": feature.unused,
        }
        for feature in chosen
    )
    shown = table.assign(unused=np.where(table["unused"], "not used", ""))
    show(
        f"Cost of features, {STEPS} equal steps, rk8",
        shown,
        {c: ".2f" for c in ("µs a sample", "ratio", "ratio to that")},
    )
    save(draw(table), options.figures / "cost_of_features.png")


if __name__ == "__main__":
    main()
