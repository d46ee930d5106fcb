"""How wrong the simpler descriptions of the contact are, against the exact section of rim and tilted journal.

    python studies/section_error.py [--quick]

Three descriptions: the usual radius R* - r* in place of r, the paper's constant r, and the linear theory of small clearance
(radius R* - r*, tilt so small that the bearing seems infinitely long). For each, against clearance ratio and slenderness:

- position and tilt at given polar angles of D and E, the largest relative error over all of them (geometry alone);
- largest tilt and peaks of the contact forces over a family of motions: median, and what nine out of ten stay below.

The motions are free swings of about five periods under gravity across the bearing, from random polar angles within 1.5 rad
of the bottom with random rates and spins, in units of sqrt((R* - r*)/g) and of L: every joint sees the same family. Motions
that lose contact are left out. Prints the tables and draws figures/section_error.png.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd
from matplotlib import rc_context
from matplotlib.figure import Figure
from study_tools import BLUE, GREEN, GREY, ORANGE, PURPLE, RED, STYLE, arguments, paper_joint, save, show

from tolmc.mechanism.circle_error import CONTACT_FORCE_SHARE, section_error_estimate
from tolmc.mechanism.scene import Body, Joint, Loads, Motion, Scene
from tolmc.simulation.ensemble import simulate_many
from tolmc.simulation.trajectory import simulate

JOURNAL, MASS, GRAVITY = 0.01, 0.5, 9.81
#: z_C/L, A/(m L^2), C/(m L^2). The first is the paper joint's body.
BODIES = {
    "paper": (0.2, 2.04, 0.6),
    "slender": (0.0, 8.0, 0.1),
    "flat": (0.2, 0.6, 1.0),
    "overhung": (1.5, 4.0, 1.0),
}
MODELS = {"approximate": "R* − r*", "constant": "constant r", "linear": "linear theory"}
COLOURS = {"approximate": ORANGE, "constant": BLUE, "linear": GREEN}
PEAKS = ("contact_force_D_max", "contact_force_E_max")
RATIOS = (1e-4, 1e-3, 1e-2, 0.03, 0.1, 0.2, 0.5, 1.0, 2.0)
SLENDERNESS = (0.5, 1.0, 2.0, 5.0, 20.0)
PAPER_SLENDERNESS = 2.0
GOALS = (1e-2, 1e-3, 1e-4)
#: Makes the bearing of the linear theory so long that its tilt has no second-order effect left.
_STRETCH = 1e6


@dataclass(frozen=True)
class Family:
    """Starts of the motions: polar angles (rad), rates and spins in units of sqrt(g/(R* - r*)), arrays (n,)."""

    alpha: np.ndarray
    beta: np.ndarray
    alpha_rate: np.ndarray
    beta_rate: np.ndarray
    spin_rate: np.ndarray

    @classmethod
    def draw(cls, count: int) -> Family:
        rng = np.random.default_rng(2026)
        alpha, beta = -np.pi / 2 + rng.uniform(-1.5, 1.5, (2, count))
        return cls(alpha, beta, *rng.uniform(-0.5, 0.5, (2, count)), rng.uniform(-3, 3, count))


def joint_of(model: str, ratio: float, slenderness: float) -> Joint:
    """A joint whose circle or exact section is that of the model."""
    clearance, length = ratio * JOURNAL, slenderness * JOURNAL
    if model in ("exact", "constant"):
        return Joint(JOURNAL + clearance, JOURNAL, length, "exact" if model == "exact" else "circle")
    length *= _STRETCH if model == "linear" else 1
    # Equation (3) gives this bore the effective radius R* - r* of the true one.
    return Joint(JOURNAL * np.hypot(1, clearance / length) + clearance, JOURNAL, length)


def motions(model: str, ratio: float, slenderness: float, body: str, family: Family) -> pd.DataFrame:
    """Largest tilt and force peaks of the family, a row a motion; NaN where contact is lost."""
    joint = joint_of(model, ratio, slenderness)
    L, unit = joint.half_length, np.sqrt(ratio * JOURNAL / GRAVITY)
    z, transverse, axial = BODIES[body]
    inertia = MASS * L**2 * np.array([transverse, transverse, axial])
    scene = Scene(joint, Body(MASS, (0, 0, z * L), inertia), Loads((0, -GRAVITY, 0)), Motion(0, 0), 10 * unit)
    parameters = {name: getattr(family, name) / (unit if name.endswith("rate") else 1) for name in vars(family)}
    results = simulate_many(
        scene, bearing_radius=joint.bearing_radius, journal_radius=JOURNAL, half_length=L, parameters=parameters,
        outputs=[*PEAKS, "tilt_max"], accuracy=1e-7, on_contact_loss="continue",
    )  # fmt: skip
    found = results[[*PEAKS, "tilt_max"]].where(results.status == "ok")
    if model == "linear":
        found["tilt_max"] = np.tan(found.tilt_max) * _STRETCH
    return found


def motion_errors(model: str, ratio: float, slenderness: float, body: str, family: Family) -> pd.DataFrame:
    """Relative errors of ``peak`` (both forces) and ``tilt_max``, a row a motion that keeps contact in both."""
    exact, found = (motions(m, ratio, slenderness, body, family) for m in ("exact", model))
    error = (found / exact - 1).abs().dropna()
    return pd.DataFrame({"peak": error[list(PEAKS)].max(axis=1), "tilt_max": error.tilt_max})


def pose_errors(model: str, ratio: float, slenderness: float, count: int) -> tuple[float, float]:
    """Largest relative errors of the distance of D from Z and of the tilt over polar angles of D and E."""
    half = np.linspace(0, np.pi / 2, count + 1)[1:]

    def poses(name):
        scene = Scene(
            joint_of(name, ratio, slenderness), Body(MASS, inertia=(1.0, 1.0, 1.0)), Loads(), Motion(0, 0), 1.0
        )  # fmt: skip
        found = [simulate(scene.replaced(alpha=h, beta=-h), step=1.0) for h in half]
        origin = np.array([t.origin[0] for t in found])
        slope = np.array([t.axis[0, :2] / t.axis[0, 2] for t in found])
        distance = np.hypot(*(origin + scene.joint.half_length * slope).T)
        slope = np.hypot(*slope.T)
        return distance, slope * _STRETCH if name == "linear" else np.arctan(slope)

    exact, found = poses("exact"), poses(model)
    position, tilt = (float(np.abs(a / b - 1).max()) for a, b in zip(found, exact, strict=True))
    return position, tilt


def survey(ratios, slenderness, family: Family, poses: int) -> pd.DataFrame:
    """A row for each model, slenderness and clearance ratio, with the paper's body."""
    rows = []
    for L in slenderness:
        for ratio in ratios:
            estimate = section_error_estimate(joint_of("constant", ratio, L))["position"]
            for model in MODELS:
                position, tilt = pose_errors(model, ratio, L, poses)
                errors = motion_errors(model, ratio, L, "paper", family)
                rows.append(
                    {"L/r*": L, "clearance ratio": ratio, "estimate": estimate, "model": model, "position": position,
                     "tilt": tilt, "motions": len(errors), **spread(errors)}
                )  # fmt: skip
    return pd.DataFrame(rows)


def spread(errors: pd.DataFrame) -> dict[str, float]:
    """Median of each column, and what nine out of ten motions stay below."""
    shares = {"median": 0.5, "90 %": 0.9}
    return {f"{name} {word}": errors[name].quantile(q) for name in errors for word, q in shares.items()}


def good_below(errors: pd.DataFrame, quantity: str, goal: float) -> float:
    """Clearance ratio below which the error is less than the goal, from the rows of one model and slenderness."""
    x, y = np.log(errors["clearance ratio"].to_numpy()), np.log(errors[quantity].to_numpy())
    rising = np.maximum.accumulate(y)
    if not rising[0] <= np.log(goal) <= rising[-1]:
        return np.nan
    return float(np.exp(np.interp(np.log(goal), rising, x)))


def rule_of_thumb(errors: pd.DataFrame) -> pd.DataFrame:
    """Largest clearance ratio for which the constant r is good to 1, 0.1, 0.01 %: rule and measurement."""
    rows = []
    for L, part in errors[errors.model == "constant"].groupby("L/r*"):
        for goal in GOALS:
            measured = {q: good_below(part, q, goal) for q in ("position", "tilt", "peak 90 %", "peak median")}
            rows.append({"L/r*": L, "good to": goal, "rule": 2 * goal * L**2, **measured})
    return pd.DataFrame(rows)


def bodies_table(family: Family, ratio: float) -> pd.DataFrame:
    """Errors of the motions of different bodies, as multiples of the estimate of the position's error."""
    estimate = section_error_estimate(joint_of("constant", ratio, PAPER_SLENDERNESS))["position"]
    rows = []
    for body in BODIES:
        for model in MODELS:
            errors = motion_errors(model, ratio, PAPER_SLENDERNESS, body, family)
            rows.append({"body": body, "model": MODELS[model], "motions": len(errors), **spread(errors / estimate)})
    return pd.DataFrame(rows)


def paper_motion() -> pd.DataFrame:
    """Force peaks of the paper joint's own motion for smaller and smaller bores: errors of the constant r."""
    rows = []
    for ratio in (1.0, 0.2, 0.05, 0.005):
        peaks = []
        for section in ("circle", "exact"):
            scene = paper_joint(section).replaced(bearing_radius=JOURNAL * (1 + ratio))
            joint = scene.joint
            peaks.append(
                simulate_many(
                    scene, bearing_radius=joint.bearing_radius, journal_radius=JOURNAL, half_length=joint.half_length,
                    outputs=PEAKS, accuracy=1e-8, on_contact_loss="continue",
                )[list(PEAKS)].iloc[0]
            )  # fmt: skip
        rows.append({"clearance ratio": ratio, **dict(zip(("N_D", "N_E"), peaks[0] / peaks[1] - 1, strict=True))})
    return pd.DataFrame(rows)


def draw(errors: pd.DataFrame, rule: pd.DataFrame) -> Figure:
    """How far the constant r goes, and the errors of the three descriptions in motion."""
    with rc_context(STYLE):
        figure = Figure(figsize=(12.5, 9.6), layout="constrained")
        figure.suptitle("What the simpler descriptions of the contact cost, against the exact section")
        axes = figure.subplots(2, 2)
        own = errors[errors["L/r*"] == PAPER_SLENDERNESS]
        _draw_rule(axes[0, 0], rule)
        _draw_collapse(axes[0, 1], errors[errors.model == "constant"])
        _draw_motions(axes[1, 0], own, "peak", "Peak contact force of a motion, L = 2 r*")
        _draw_motions(axes[1, 1], own, "tilt_max", "Largest tilt of a motion, L = 2 r*")
    return figure


def _draw_rule(axis, rule: pd.DataFrame) -> None:
    axis.set(
        title="Up to which clearance the constant r is good", xscale="log", yscale="log",
        xlabel="slenderness L/r*", ylabel="clearance ratio (R* − r*)/r*",
    )  # fmt: skip
    for (goal, part), colour in zip(rule.groupby("good to", sort=False), (BLUE, ORANGE, GREEN), strict=True):
        x = part["L/r*"]
        axis.plot(x, part["rule"], color=colour, label=f"(R* − r*)/r* = 2 × {100 * goal:g} % × (L/r*)²")
        axis.plot(x, part.position, "o", color=colour)
        axis.plot(x, part["peak 90 %"], "s", color=colour, fillstyle="none", markersize=9)
    axis.plot([], [], "o", color=GREY, label="measured, position")
    axis.plot([], [], "s", color=GREY, fillstyle="none", markersize=9, label="measured, nine out of ten force peaks")
    axis.legend(fontsize=8)


def _draw_collapse(axis, constant: pd.DataFrame) -> None:
    markers = zip("osD^v", (BLUE, ORANGE, GREEN, RED, PURPLE), strict=True)
    for (L, part), (marker, colour) in zip(constant.groupby("L/r*"), markers, strict=False):
        axis.plot(part.estimate, part["peak 90 %"], marker, color=colour, label=f"L = {L:g} r*, nine out of ten below")
        axis.plot(part.estimate, part["peak median"], marker, color=colour, fillstyle="none")
    x = np.array([constant.estimate.min(), constant.estimate.max()])
    axis.plot(x, CONTACT_FORCE_SHARE * x, color="black", linewidth=1, label="estimate (open symbols: median)")
    axis.set(
        title="Peak contact force, constant r, every joint", xscale="log", yscale="log",
        xlabel="estimate r* (1/cos ψ − 1)/(R* − r*)", ylabel="relative error",
    )  # fmt: skip
    axis.legend(fontsize=8)


def _draw_motions(axis, own: pd.DataFrame, quantity: str, title: str) -> None:
    for model, part in own.groupby("model", sort=False):
        x, colour = part["clearance ratio"], COLOURS[model]
        axis.plot(
            x, part[f"{quantity} 90 %"], "s--", color=colour, markersize=4, label=f"{MODELS[model]}, nine in ten below"
        )
        axis.plot(x, part[f"{quantity} median"], "o-", color=colour, label=f"{MODELS[model]}, median")
    axis.set(title=title, xlabel="clearance ratio (R* − r*)/r*", ylabel="relative error", xscale="log", yscale="log")
    for goal in GOALS:
        axis.axhline(goal, color=GREY, linewidth=0.8, linestyle=":")
        axis.text(own["clearance ratio"].min(), goal * 1.12, f"{100 * goal:g} %", color=GREY, fontsize=8)
    axis.legend(fontsize=8, loc="lower right")


def compact(errors: pd.DataFrame) -> pd.DataFrame:
    """A row a joint: position and tilt at given polar angles, and what nine motions out of ten stay below."""
    wide = errors.pivot(
        index=["L/r*", "clearance ratio"], columns="model", values=["position", "tilt", "peak 90 %", "tilt_max 90 %"]
    )
    columns = [(q, m) for q in ("position", "tilt", "peak 90 %", "tilt_max 90 %") for m in MODELS]
    columns.remove(("position", "linear"))  # that of R* - r*
    wide = wide[columns]
    wide.columns = [f"{quantity}\n{MODELS[model]}" for quantity, model in columns]
    return wide.reset_index()


def main() -> None:
    """Survey, tables, figure."""
    options = arguments(__doc__)
    ratios, slenderness = ((1e-3, 0.1, 1.0), (PAPER_SLENDERNESS,)) if options.quick else (RATIOS, SLENDERNESS)
    family = Family.draw(32 if options.quick else 256)
    errors = survey(ratios, slenderness, family, 16 if options.quick else 64)
    table = compact(errors)
    show("Relative errors against the exact section, the paper's body", table, dict.fromkeys(table.columns, ".3g"))
    rule = rule_of_thumb(errors)
    show(
        "Clearance ratio below which the constant r is good to q; rule: 2 q (L/r*)²",
        rule,
        dict.fromkeys(rule.columns, ".3g"),
    )
    bodies = bodies_table(family, 0.1)
    show(
        "Errors of the motions as multiples of the estimate, L = 2 r*, clearance ratio 0.1",
        bodies, dict.fromkeys(bodies.columns[3:], ".2f"),
    )  # fmt: skip
    show(
        "Force peaks of the paper joint's own motion for smaller bores: errors of the constant r",
        paper_motion(), {"clearance ratio": "g", "N_D": "+.3%", "N_E": "+.3%"},
    )  # fmt: skip
    save(draw(errors, rule), options.figures / "section_error.png")


if __name__ == "__main__":
    main()
