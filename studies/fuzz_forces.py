"""Statistics of contact forces in random motions, at given steps and at chosen ones, against 16 times finer steps.

    python studies/fuzz_forces.py [--quick] [--motions 100000] [--seed 1] [--section circle|exact]

Ensembles of 64 motions of every kind, a few of their own periods long, in 8 to 400 steps, most of which begin with the journal
on the wall. A sample with status "ok" or "contact lost" must have its statistics and loss time right: to 1e-3 of the largest
force and of the duration at given steps, to ten times the accuracy at chosen ones. Motions that 11 and 16 times finer steps do
not agree on (chaotic ones) are counted apart. Prints how many were right, flagged, flagged for nothing (right to a tenth) and
missed, and the worst of those.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pandas as pd
from fuzz_scenes import KINDS, SYMMETRIC, samples
from rich.progress import track
from study_tools import arguments, show

from tolmc.mechanism.scene import Joint, Scene
from tolmc.simulation.ensemble import simulate_many
from tolmc.simulation.pilot import plan_integration

DIMENSIONS = ("bearing_radius", "journal_radius", "half_length")
FORCES = [f"contact_force_{end}_{kind}" for end in "DE" for kind in ("max", "min", "mean", "rms")]
GROUP = 64
GIVEN, FINE = 1e-3, 16


def simulated(scene: Scene, columns: dict[str, np.ndarray], steps: int | None, **options) -> pd.DataFrame:
    """Statistics of every motion in so many steps; None: as many as the pilot chooses."""
    rest = {name: column for name, column in columns.items() if name not in DIMENSIONS}
    dimensions = {name: columns[name] for name in DIMENSIONS}
    step = None if steps is None else scene.duration / steps
    return simulate_many(scene, **dimensions, parameters=rest, step=step, **options)


def ensembles(rng: np.random.Generator, count: int, section: str) -> Iterator[tuple[str, Scene, dict, int]]:
    """Kind, scene, columns and a number of steps of ensembles that together have ``count`` motions or a few more."""
    made = 0
    while made < count:
        kind, level = str(rng.choice(list(KINDS))), str(rng.choice(("sane", "far"), p=(0.7, 0.3)))
        joint = Joint(*(getattr(SYMMETRIC.joint, name) for name in DIMENSIONS), section)
        scene = replace(SYMMETRIC, joint=joint, loads=replace(SYMMETRIC.loads, gravity=(0.0, 0.0, 0.0)))
        columns = _on_the_wall(rng, scene, samples(rng, 16 * GROUP, kind, level, poisoned=0.0))
        everything = scene.scalars | columns
        pull = np.sqrt(
            sum((everything[f"gravity_{a}"] + everything[f"force_{a}"] / everything["mass"]) ** 2 for a in "xyz")
        )
        radius = columns["bearing_radius"] - columns["journal_radius"]
        rate = np.maximum.reduce(
            [np.sqrt(pull / radius), *(np.abs(columns[n]) for n in ("alpha_rate", "beta_rate", "spin_rate"))]
        )
        order = np.argsort(rate)
        for first in range(0, len(order), GROUP):
            rows = order[first : first + GROUP]
            steps = int(np.exp(rng.uniform(np.log(8), np.log(400))))
            duration = float(rng.uniform(0.3, 10) / np.median(rate[rows]))
            made += len(rows)
            yield (
                kind,
                replace(scene, duration=duration),
                {name: column[rows] for name, column in columns.items()},
                steps,
            )


def _on_the_wall(rng, scene: Scene, columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The samples turned about until their contacts push, and one in twenty of those that never do."""
    for turn in (np.pi, 0.5 * np.pi, np.pi, 0.0):
        start = simulated(replace(scene, duration=1e-9), columns, 1, accuracy=1.0, on_contact_loss="continue")
        least = start[["contact_force_D_min", "contact_force_E_min"]].min(axis=1).to_numpy()
        for name in ("alpha", "beta"):
            columns[name] = columns[name] + np.where(least < 0, turn, 0.0)
    keep = (least > 0) | (rng.random(len(least)) < 0.05)
    return {name: column[keep] for name, column in columns.items()}


def error(found: pd.DataFrame, true: pd.DataFrame, duration: float) -> np.ndarray:
    """Largest difference of forces over the largest force, of tilt, and of loss times over the duration."""
    scale = true[FORCES].abs().max(axis=1).to_numpy()
    forces = (found[FORCES] - true[FORCES]).abs().max(axis=1).to_numpy()
    worst = np.divide(forces, scale, out=np.zeros_like(forces), where=scale > 0)
    lost, truly = found.contact_loss_time, true.contact_loss_time
    times = np.where(lost.isna() & truly.isna(), 0.0, ((lost - truly).abs() / duration).fillna(np.inf))
    worst = np.maximum.reduce([worst, (found.tilt_max - true.tilt_max).abs().to_numpy(), times])
    return np.where(np.isfinite(worst), worst, np.inf)


def compared(scene: Scene, columns: dict[str, np.ndarray], steps: int, allowed: float, given: bool) -> pd.DataFrame:
    """A row a motion: its error, whether it has a good status, whether the finer steps agree, and what would be wrong.

    ``given``: whether the steps are given; else they are the pilot's.
    """
    found = simulated(scene, columns, steps if given else None)
    true, check = (simulated(scene, columns, times * steps, accuracy=1.0) for times in (FINE, 11))
    frame = pd.DataFrame({"error": error(found, true, scene.duration), "status": found.status, "steps": steps})
    frame["good"] = found.status.isin(["ok", "contact lost"])
    frame["known"] = error(check, true, scene.duration) < 0.1 * allowed
    frame["missed"] = frame.known & frame.good & (frame.error > allowed)
    frame["for nothing"] = frame.known & ~frame.good & (frame.error < 0.1 * allowed)
    return frame


def run(motions: int, seed: int, section: str) -> pd.DataFrame:
    """Every motion of the fuzz, a row each, as :func:`compared` has it, with how its steps were chosen."""
    rng, frames = np.random.default_rng(seed), []
    found = ensembles(rng, motions, section)
    for number, (kind, scene, columns, steps) in enumerate(track(found, disable=not sys.stdout.isatty())):
        frames.append(compared(scene, columns, steps, GIVEN, given=True).assign(kind=kind, chosen="given"))
        if number % 10 == 0:
            bounds = {name: (float(column.min()), float(column.max())) for name, column in columns.items()}
            plan = plan_integration(scene, bounds)
            if plan.unresolved == 0 and plan.steps < 2000:
                frame = compared(scene, columns, plan.steps, 10 * plan.accuracy, given=False)
                frames.append(frame.assign(kind=kind, chosen="by the pilot"))
    return pd.concat(frames, ignore_index=True)


def main() -> None:
    options = arguments(
        __doc__,
        motions={"type": int, "default": 100_000, "metavar": "N", "help": "motions (default 100,000)"},
        seed={"type": int, "default": 1, "metavar": "N"},
        section={"choices": ["circle", "exact"], "default": "circle"},
    )
    frame = run(options.motions // (100 if options.quick else 1), options.seed, options.section)
    for chosen, part in frame.groupby("chosen"):
        known = part[part.known]
        counts = {"known": len(known), "good status": int(known.good.sum()), "flagged": int((~known.good).sum()),
                  "for nothing": int(known["for nothing"].sum()), "missed": int(known.missed.sum()),
                  "finer steps disagree": int((~part.known).sum())}  # fmt: skip
        show(f"Steps {chosen}", pd.DataFrame([counts]))
        print(dict(Counter(part.status)))
    missed = frame[frame.missed].sort_values("error", ascending=False)
    if len(missed):
        show("The worst that were missed", missed.head(20)[["kind", "chosen", "steps", "status", "error"]])
        sys.exit(1)


if __name__ == "__main__":
    main()
