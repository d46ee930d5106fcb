"""Long runs: drift of energy, momentum about Z and constraints over up to ten million steps of one motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
from study_tools import BLUE, GREEN, GREY, ORANGE, PURPLE, RED, SKY, paper_joint

from tolmc.mechanism.scene import Loads, Scene
from tolmc.simulation.ensemble import simulate_many
from tolmc.simulation.trajectory import Trajectory, simulate

#: Steps a second: what the default accuracy asks for, five times as many, and so many that only rounding is left.
COARSE, FINE, FINEST = 80, 400, 1600
#: Weights of the tenth-order central difference, (f(k) - f(-k)) for k = 1 ... 5.
_DIFFERENCE = np.array([5 / 6, -5 / 21, 5 / 84, -5 / 504, 1 / 1260])


def vertical(scene: Scene) -> Scene:
    """The scene with gravity along the bearing: its momentum about Z is constant."""
    return replace(scene, loads=Loads((0, 0, -9.81)))


def counts(last: float) -> np.ndarray:
    """Numbers of steps from a thousand on: two a decade, beyond a million one."""
    exponents = np.arange(3, np.log10(last) + 0.01, 0.5)
    return np.rint(10 ** exponents[(exponents <= 6) | (exponents % 1 == 0)]).astype(int)


def ensemble_drift(scene: Scene, rate: int, project: bool, last: float) -> pd.DataFrame:
    """Largest energy and constraint errors of a motion over n steps, slope coordinates, a row an n."""
    rows = []
    for n in counts(last):
        joint, long = scene.joint, replace(scene, duration=n / rate)
        found = simulate_many(
            long, bearing_radius=joint.bearing_radius, journal_radius=joint.journal_radius,
            half_length=joint.half_length, step=1 / rate, project_energy=project,
            outputs=["energy_error", "constraint_error"],
        ).iloc[0]  # fmt: skip
        rows.append({"steps": n, "energy": found.energy_error, "constraint": found.constraint_error})
    return pd.DataFrame(rows)


def momentum(scene: Scene, motion: Trajectory, rows: np.ndarray, step: float) -> np.ndarray:
    """Angular momentum of a symmetric body about Z at some rows, N m s; velocities by differences of the motion itself."""
    m, z = scene.body.mass, scene.body.center_of_mass[2]
    axial, spin = scene.body.inertia[2, 2], scene.motion.spin_rate
    transverse = scene.body.inertia[0, 0] - m * z * z

    def with_rate(values):
        ahead = sum(w * values[rows + k] for k, w in enumerate(_DIFFERENCE, 1))
        behind = sum(w * values[rows - k] for k, w in enumerate(_DIFFERENCE, 1))
        return values[rows], (ahead - behind) / step

    (x, y), (x_rate, y_rate) = (part.T for part in with_rate(motion.origin))
    e, e_rate = (part.T for part in with_rate(motion.axis))
    x, y, x_rate, y_rate = x + z * e[0], y + z * e[1], x_rate + z * e_rate[0], y_rate + z * e_rate[1]
    orbital = m * (x * y_rate - y * x_rate)
    return orbital + transverse * (e[0] * e_rate[1] - e[1] * e_rate[0]) + axial * spin * e[2]


def momentum_drift(scene: Scene, rate: int, project: bool, last: float) -> pd.DataFrame:
    """Change of the momentum about Z over n steps, over the largest momentum without the spin's part, a row an n."""
    scene, step = vertical(scene), 1 / rate
    motion = simulate(replace(scene, duration=last * step), step=step, project_energy=project)
    first, window = 5, np.arange(50)
    found = [momentum(scene, motion, n - 60 + window, step) for n in counts(last)]
    start = momentum(scene, motion, first + window, step)
    scale = np.abs(start - scene.body.inertia[2, 2] * scene.motion.spin_rate).max()
    change = [np.abs(values - start.mean()).max() / scale for values in found]
    return pd.DataFrame({"steps": counts(last), "momentum": change})


def published_drift(scene: Scene, rate: int, formulation: str, last: float) -> tuple[pd.DataFrame, str]:
    """Largest energy and constraint errors over n steps in the paper's coordinates, and how the motion ended."""
    motion = simulate(replace(scene, duration=last / rate), step=1 / rate, formulation=formulation)
    r, L = scene.joint.effective_radius, scene.joint.half_length
    offset = L * motion.axis[:, :2] / motion.axis[:, 2:]
    ends = np.stack([np.hypot(*(motion.origin + offset).T), np.hypot(*(motion.origin - offset).T)])
    # The kinetic energy of the swing: the spin's own part is constant.
    scale = np.ptp(motion.energy - motion.energy[0] + motion.origin[:, 1] * scene.body.mass * scene.loads.gravity[1])
    energy = np.maximum.accumulate(np.abs(motion.energy - motion.energy[0])) / scale
    constraint = np.maximum.accumulate(np.abs(ends / r - 1).max(axis=0))
    rows = [n for n in counts(last) if n < len(motion.time)]
    return pd.DataFrame({"steps": rows, "energy": energy[rows], "constraint": constraint[rows]}), motion.status


def long_runs(quick: bool) -> dict[str, pd.DataFrame]:
    """Drift of each run, by its name."""
    scene = paper_joint()
    million, ten_million, published_last = (1e4, 1e4, 1e3) if quick else (1e6, 1e7, 1e4)
    runs = {
        f"slope, {COARSE} steps a second": ensemble_drift(scene, COARSE, False, million),
        f"slope, {FINE} steps a second": ensemble_drift(scene, FINE, False, million),
        f"slope, {FINEST} steps a second": ensemble_drift(scene, FINEST, False, ten_million),
        f"slope, {COARSE}, project_energy": ensemble_drift(scene, COARSE, True, ten_million),
        f"slope, {FINE} steps a second, axial gravity": momentum_drift(scene, FINE, False, million),
        f"slope, {FINE}, project_energy, axial gravity": momentum_drift(scene, FINE, True, million),
    }
    for formulation in ("published-regular", "published"):
        drift, status = published_drift(scene, FINE, formulation, published_last)
        runs[f"{formulation}, {FINE} steps a second: {status}"] = drift
    return runs


def drift_table(runs: dict[str, pd.DataFrame]) -> pd.DataFrame:
    """Drift at the end of each run, how it grows (exponent of a power of the number of steps), and its rate a step."""
    rows = []
    for name, run in runs.items():
        for quantity in run.columns[1:]:
            late = run[run.steps >= 1e4] if (run.steps >= 1e4).sum() > 2 else run
            positive = late[late[quantity] > 0]
            grows = np.polyfit(np.log(positive.steps), np.log(positive[quantity]), 1)[0] if len(positive) > 1 else 0.0
            end = run.iloc[-1] if len(run) else {"steps": 0, quantity: np.nan}
            rows.append(
                {"run": name, "quantity": quantity, "steps": int(end["steps"]), "drift": end[quantity],
                 "exponent": grows, "a step": end[quantity] / max(end["steps"], 1)}
            )  # fmt: skip
    return pd.DataFrame(rows)


def draw_drift(energy, others, runs: dict[str, pd.DataFrame]) -> None:
    """Energy error on one axis, momentum and constraint errors on another."""
    colours = dict(zip(runs, (ORANGE, BLUE, SKY, GREEN, BLUE, GREEN, PURPLE, RED), strict=True))
    for name, run in runs.items():
        label, colour = name.split(":")[0], colours[name]
        if "energy" in run:
            energy.plot(run.steps, run.energy, "o-", markersize=4, color=colour, label=label)
            others.plot(run.steps, run.constraint, "s:", markersize=3, color=colour)
        else:
            others.plot(run.steps, run.momentum, "o-", markersize=4, color=colour, label=label)
    others.plot([], [], "s:", markersize=3, color=GREY, label="constraints, the runs of the left panel")
    energy.axhline(1e-10, color=GREY, linewidth=1, linestyle=":")
    energy.set(title="Energy over a long run of the paper's joint", ylabel="error over the largest kinetic energy")
    others.set(title="Momentum about Z, and constraints", ylabel="relative error")
    for axis in (energy, others):
        axis.set(xlabel="steps of one motion", xscale="log", yscale="log", ylim=(1e-17, 1e-2))
        axis.legend(fontsize=8, ncols=2, loc="upper left")
