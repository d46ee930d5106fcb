"""Random scenes from sane to absurd through ``simulate_many``; damaged files and odd surroundings through the command line.

    python studies/fuzz.py [--quick] [--samples 100000] [--flights 100000] [--scenes 2000] [--files 1000] [--seed 2026]

Samples vary every scalar in large ensembles, some with values that are no numbers; flights start within the clearance and hit
the wall, on both sections; scenes are single motions with options of every kind; study files are the studies of this folder
with random damage. Nothing may raise or warn; a sample with status "ok" has finite and consistent statistics, errors within
the stated accuracy, and, where every sample is checked by step halving, the values of a much finer step. Prints how often
each status came, and fails on the first fault of each kind.
"""

from __future__ import annotations

import sys
import tempfile
import warnings
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
from fuzz_files import cases
from fuzz_scenes import KINDS, LEVELS, SYMMETRIC, flights, samples, scene
from rich.progress import track
from study_tools import ROOT, arguments, show

from tolmc.mechanism.scene import Motion
from tolmc.quantities import ALWAYS, GEOMETRY
from tolmc.simulation.ensemble import simulate_many
from tolmc.simulation.judge import STATUSES
from tolmc.simulation.plan import FORMULATIONS

DIMENSIONS = ("bearing_radius", "journal_radius", "half_length")
NUMBERS = [name for name in ALWAYS if name != "contact_loss_time"]
DYNAMIC = [name for name in NUMBERS if name not in GEOMETRY]
STATISTICS = [name for name in NUMBERS if name.startswith(("contact_force", "tilt_max"))]
#: Of a wall that holds the journal; "follow" is one's that only pushes.
ON_CONTACT_LOSS = ("stop", "continue", "end")
#: What an impact leaves.
BLOWS = (
    ("impacts", ""),
    ("impulse", "_max"),
    ("impulse", "_total"),
    ("impact_speed", "_max"),
    ("impact_force", "_max"),
)
ACCURACY = 1e-4
STEPS = 200


def faults(result: pd.DataFrame, duration: float, accuracy: float = ACCURACY) -> dict[str, np.ndarray]:
    """Which rows break what every result must keep, by the name of the rule."""
    ok, lost = result.status == "ok", result.status == "contact lost"
    invalid = result.status.isin(["geometry invalid", "body invalid"])
    finite = np.isfinite(result[NUMBERS].astype(float)).all(axis=1)
    found = {
        "unknown status": ~result.status.isin(STATUSES),
        "not finite with status ok": ok & ~finite,
        "not finite with status contact lost": lost & ~finite,
        "error above the accuracy with status ok": ok
        & ~(result[["energy_error", "constraint_error"]].max(axis=1) <= accuracy),
        "a loss of contact with status ok": ok & result.contact_loss_time.notna(),
        "a loss of contact outside the motion": lost & ~result.contact_loss_time.between(0, duration),
        "numbers without a motion": invalid & result[DYNAMIC].notna().any(axis=1),
    }
    slack = 2 * accuracy * np.maximum(result.contact_force_D_max, result.contact_force_E_max).abs() + 1e-300
    for side in "DE":
        low, mean, rms, high = (result[f"contact_force_{side}_{kind}"] for kind in ("min", "mean", "rms", "max"))
        ordered = (low <= mean + slack) & (mean <= high + slack) & (mean.abs() <= rms + slack) & (low >= -slack)
        found[f"forces at {side} out of order with status ok"] = ok & ~ordered
    found["tilt beyond the largest with status ok"] = ok & ~(result.tilt_max <= result.tilt_angle * (1 + accuracy))
    return {rule: np.asarray(rows) for rule, rows in found.items()}


def disagreement(result: pd.DataFrame, fine: pd.DataFrame) -> np.ndarray:
    """Largest relative difference of the statistics of each sample, NaN where either has none."""
    scale = np.maximum(fine.contact_force_D_max, fine.contact_force_E_max)
    forces = (result[STATISTICS[:-1]] - fine[STATISTICS[:-1]]).abs().div(scale.where(scale > 0), axis=0)
    return np.maximum(forces.max(axis=1), (result.tilt_max - fine.tilt_max).abs()).to_numpy()


class Report:
    """Counts of statuses by group, and the first example of every fault."""

    def __init__(self) -> None:
        self.statuses: dict[str, Counter] = {}
        self.faults: Counter = Counter()
        self.examples: dict[str, str] = {}

    def add(self, group: str, statuses) -> None:
        self.statuses.setdefault(group, Counter()).update(statuses)

    def check(self, found: dict[str, np.ndarray], describe) -> None:
        """Note the faults of a result; ``describe(row)`` says how to see one again."""
        for rule, rows in found.items():
            if rows.any():
                self.faults[rule] += int(rows.sum())
                self.examples.setdefault(rule, describe(int(np.argmax(rows))))

    def show(self) -> None:
        counts = pd.DataFrame(self.statuses).T.fillna(0).astype(int)
        ordered = [status for status in (*STATUSES, *counts) if status in counts]
        counts = counts[list(dict.fromkeys(ordered))]
        counts.insert(0, "", counts.index)
        show("How often each status came", counts)
        for rule, count in self.faults.items():
            print(f"\nFAULT: {rule}: {count} times; first: {self.examples[rule]}")


def fuzz_samples(report: Report, rng: np.random.Generator, count: int) -> None:
    """Ensembles of every kind and level, every scalar varied; the sound ones once more against a much finer step."""
    groups = [(kind, level) for kind in KINDS for level in LEVELS]
    for kind, level in track(groups, description="samples", disable=not sys.stdout.isatty()):
        columns = samples(rng, max(1, count // len(groups)), kind, level)
        dimensions = {name: columns.pop(name) for name in DIMENSIONS}
        for choice in ON_CONTACT_LOSS:
            step = SYMMETRIC.duration / STEPS
            result = simulate_many(SYMMETRIC, **dimensions, parameters=columns, step=step, on_contact_loss=choice)
            report.add(f"{kind}, {level}", result.status)

            def describe(row, kind=kind, result=result, choice=choice):
                return f"{kind}, {choice}, step = {SYMMETRIC.duration / STEPS}\n{result.iloc[row].to_dict()}"

            report.check(faults(result, SYMMETRIC.duration), describe)
        if level == "sane":
            options = {"on_contact_loss": "continue", "accuracy": ACCURACY}
            checked = simulate_many(SYMMETRIC, **dimensions, parameters=columns, step=4 * step, halving=True, **options)
            fine = simulate_many(SYMMETRIC, **dimensions, parameters=columns, step=step / 2, **options)
            wrong = (checked.status == "ok") & (disagreement(checked, fine) > 10 * ACCURACY)
            report.check(
                {"wrong though step halving found nothing": wrong.to_numpy()},
                lambda row, checked=checked: f"step = {4 * SYMMETRIC.duration / STEPS}\n{checked.iloc[row].to_dict()}",
            )


def impact_faults(result: pd.DataFrame, section: str, accuracy: float) -> dict[str, np.ndarray]:
    """The same of motions that leave the wall."""
    ok = (result.status == "ok").to_numpy()
    radius = result.effective_radius if section == "circle" else result.bearing_radius - result.journal_radius
    shares = result.closed_share_D + result.closed_share_E + result.free_share
    found = {
        "unknown status": ~result.status.isin(STATUSES),
        "energy not kept": ok & ~(result.energy_error <= accuracy),
        "penetration": ok & ~(result.constraint_error <= 1e-10),
        "tilt beyond the largest": ok & ~(result.tilt_max <= np.arctan2(radius, result.half_length) * (1 + 1e-9)),
        "impacts that give energy": ok & ~(result.impact_energy_loss >= -1e-12 * np.maximum(result.mass, 1.0)),
        "shares of time that are none": ok & ~shares.between(1 - 1e-9, 2 + 1e-9),
    }
    for side in "DE":
        blows = result[[f"{name}_{side}{end}" for name, end in BLOWS]]
        lowest, untouched = result[f"contact_force_{side}_min"], result[f"closed_share_{side}"] == 0
        found[f"negative impulse or force at {side}"] = ok & ((blows < 0).any(axis=1) | (lowest < 0))
        found[f"forces at {side} without contact"] = ok & (lowest.isna() != untouched)
        found[f"impacts at {side} without impulse"] = ok & (result[f"impacts_{side}"] > 0) & (blows.iloc[:, 1] <= 0)
    return {rule: np.asarray(rows) for rule, rows in found.items()}


def fuzz_flights(report: Report, rng: np.random.Generator, count: int) -> None:
    """Motions with impacts of every kind of body and load on both sections."""
    groups = [(kind, section) for kind in KINDS for section in ("circle", "exact")]
    start = Motion.free((0, 0), (0, 0), spin_rate=80.0)
    for kind, section in track(groups, description="flights", disable=not sys.stdout.isatty()):
        columns = flights(rng, max(1, count // len(groups)), kind)
        joint = replace(SYMMETRIC.joint, restitution=0.5, contact_stiffness=1e9, section=section)
        scene = replace(SYMMETRIC, joint=joint, motion=start)
        dimensions = {name: columns.pop(name) for name in DIMENSIONS}
        varied = dimensions | columns
        result = simulate_many(
            scene, **dimensions, parameters=columns, step=scene.duration / (4 * STEPS), accuracy=1e-6
        )
        result = result.assign(mass=varied.get("mass", scene.body.mass))
        report.add(f"flights, {kind}, {section}", result.status)
        report.check(
            impact_faults(result, section, 1e-6),
            lambda row, result=result, kind=kind, section=section: f"{kind}, {section}\n{result.iloc[row].to_dict()}",
        )


def fuzz_scenes(report: Report, rng: np.random.Generator, count: int) -> None:
    """Single scenes with random options, in the paper's formulations too."""
    for _ in track(range(count), description="scenes ", disable=not sys.stdout.isatty()):
        case = scene(rng)
        exact = case.joint.section == "exact"
        formulation = "slope" if exact else str(rng.choice(FORMULATIONS, p=(0.8, 0.1, 0.1)))
        options = {
            "step": case.duration / int(rng.integers(1, 300)),
            "method": str(rng.choice(["rk8", "rk4"])),
            "formulation": formulation,
            "on_contact_loss": str(rng.choice(list(ON_CONTACT_LOSS))),
            "project_energy": formulation == "slope" and bool(rng.random() < 0.3),
        }
        R = case.joint.bearing_radius * (1 + np.array([0.0, 1e-3]))
        try:
            result = simulate_many(
                case, **{name: case.scalars[name] for name in DIMENSIONS} | {"bearing_radius": R}, **options
            )
        except Exception as error:
            error.add_note(f"{case!r}\n{options}")
            raise
        report.add(f"scenes, {formulation}{', exact section' if exact else ''}", result.status)
        report.check(
            faults(result, case.duration), lambda row, case=case, options=options: f"row {row}\n{case!r}\n{options}"
        )


def fuzz_files(report: Report, rng: np.random.Generator, count: int) -> None:
    """Damaged study and CSV files and odd surroundings: an error in words and exit status 2, or the right result."""
    texts = [path.read_text("utf-8") for path in sorted((ROOT / "studies").glob("*.toml"))]
    with tempfile.TemporaryDirectory() as folder:
        found = cases(rng, Path(folder), count, texts)
        for case in track(found, total=count, description="files  ", disable=not sys.stdout.isatty()):
            report.add(case.group, [case.outcome])
            report.check(
                {f"{case.group}: {rule}": np.array([True]) for rule in case.broken}, lambda _, case=case: case.shown
            )


def main() -> None:
    whole = {"type": int, "metavar": "N"}
    options = arguments(
        __doc__,
        samples=whole | {"default": 100_000, "help": "samples in ensembles (default 100,000)"},
        flights=whole | {"default": 100_000, "help": "motions with impacts (default 100,000)"},
        scenes=whole | {"default": 2000, "help": "single scenes (default 2,000)"},
        files=whole | {"default": 1000, "help": "damaged study files, CSV files and surroundings (default 1,000)"},
        seed=whole | {"default": 2026},
    )
    share = 100 if options.quick else 1
    rng, report = np.random.default_rng(options.seed), Report()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fuzz_samples(report, rng, options.samples // share)
        fuzz_flights(report, rng, options.flights // share)
        fuzz_scenes(report, rng, options.scenes // share)
        fuzz_files(report, rng, options.files // share)
    report.show()
    if report.faults:
        sys.exit(1)
    print("\nNo fault found.")


if __name__ == "__main__":
    main()
