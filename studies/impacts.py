"""Motions with impacts: run time against error beside SciPy, heyoka and Exudyn, restitution measured, and busy lanes.

    python studies/impacts.py [--quick] [--figures DIR]

The motion is a journal dropped from the middle of the paper's joint with varied bores, followed to between its third and its
fourth impact. All methods are timed in one process, the least processor time counts; the error is that of the pose at the
end, against SciPy at rounding level. heyoka, scalar and in batches, and Exudyn, stopped at the wall or with springs for one,
take part where they are installed; right-hand sides and impact laws are compiled everywhere. Then the restitution measured,
and on longer motions how busy the lanes are and how many rounds an impact takes beside the steps. Prints the tables and
writes figures/impacts.png.
"""

from __future__ import annotations

import importlib.util
import time
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pandas as pd
from impact_peer import scipy_pose
from matplotlib import rc_context
from matplotlib.figure import Figure
from study_tools import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, STYLE, arguments, show

from tolmc.kernels import entries, results
from tolmc.kernels.one_sided import layout
from tolmc.mechanism.scene import Body, Joint, Loads, Motion, Scene
from tolmc.quantities import END_OUTPUTS
from tolmc.simulation import one_sided
from tolmc.simulation.ensemble import simulate_many
from tolmc.simulation.packing import pack
from tolmc.simulation.pilot import plan_integration
from tolmc.simulation.trajectory import simulate

BODY = Body(0.5, (0, 0, 0.004), (4.08e-4, 4.08e-4, 1.2e-4))
START = Motion.free((0.001, 0.002), (0.15, -0.05), (0.05, 0.0), (0.0, 5.0), spin_rate=60.0)
#: Between the third impact of every bore and its fourth.
DROPPED = Scene(Joint(0.02, 0.01, 0.02, restitution=0.6), BODY, Loads((0, -9.81, 0)), START, 0.0945)
CHECKED = 6


def bores(n: int) -> np.ndarray:
    """Bearing radii, m."""
    return np.random.default_rng(1).uniform(0.01999, 0.02001, n)


def flown(radii: np.ndarray, steps: int) -> pd.DataFrame:
    """Pose at the end of every motion."""
    return simulate_many(
        DROPPED, bearing_radius=radii, journal_radius=0.01, half_length=0.02, step=DROPPED.duration / steps,
        outputs=("effective_radius", *END_OUTPUTS),
    )  # fmt: skip


def poses(radii: np.ndarray, steps: int) -> tuple[np.ndarray, np.ndarray]:
    """(X0, Y0, u, v) over r at the end, and r: the numbers that all methods are compared by."""
    found = flown(radii, steps)
    if not found.status.eq("ok").all():
        raise RuntimeError(f"{(found.status != 'ok').sum()} motions failed")
    radius = found.effective_radius.to_numpy()
    offset = (
        DROPPED.joint.half_length * found[["axis_x_end", "axis_y_end"]].to_numpy() / found[["axis_z_end"]].to_numpy()
    )
    origin = found[["origin_x_end", "origin_y_end"]].to_numpy()
    return np.concatenate((origin, offset), axis=1) / radius[:, None], radius


def best_time(call: Callable[[], object], times: int) -> float:
    """Least processor time of a call, s."""
    taken = []
    for _ in range(times):
        began = time.process_time()
        call()
        taken.append(time.process_time() - began)
    return min(taken)


def against_scipy(quick: bool) -> pd.DataFrame:
    """Error and time a motion of both methods, a row a setting."""
    radii = bores(1024 if quick else 32_768)
    _, radius = poses(radii[:CHECKED], 8)
    exact = np.array([scipy_pose(DROPPED, r, 1e-13) for r in radius])
    rows = []
    for steps in (1, 2, 3, 4, 6, 8, 12, 16)[:: 2 if quick else 1]:
        error = np.abs(poses(radii[:CHECKED], steps)[0] - exact).max()
        seconds = best_time(lambda steps=steps: flown(radii, steps), 2 if quick else 5) / len(radii)
        rows.append({"method": "tolmc", "setting": f"{steps} steps", "error": error, "seconds": seconds})
    for tolerance in (1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11)[:: 3 if quick else 1]:
        error = np.abs(np.array([scipy_pose(DROPPED, r, tolerance) for r in radius]) - exact).max()
        seconds = best_time(lambda tolerance=tolerance: scipy_pose(DROPPED, radius[0], tolerance), 3 if quick else 9)
        rows.append({"method": "SciPy DOP853", "setting": f"rtol {tolerance:g}", "error": error, "seconds": seconds})
    return pd.DataFrame([*rows, *_of_heyoka(radii, exact, quick), *_of_exudyn(radius, exact, quick)])


def _of_heyoka(radii: np.ndarray, exact: np.ndarray, quick: bool) -> Iterator[dict[str, object]]:
    """The same of heyoka's terminal events, nothing where it is not installed."""
    if not importlib.util.find_spec("heyoka"):
        return
    from impact_heyoka import prepare

    many = poses(radii[:256], 8)[1]
    for method, batch in (("heyoka", False), ("heyoka, batches", True)):
        for tolerance in (1e-5, 1e-6, 1e-8, 1e-10, 1e-12, 1e-15)[:: 2 if quick else 1]:  # 1e-4 misses an impact
            motions = prepare(DROPPED, tolerance, batch)
            error = np.abs(motions(many)[:CHECKED] - exact).max()
            seconds = best_time(lambda motions=motions: motions(many), 3) / len(many)
            yield {"method": method, "setting": f"tol {tolerance:g}", "error": error, "seconds": seconds}


def _of_exudyn(radius: np.ndarray, exact: np.ndarray, quick: bool) -> Iterator[dict[str, object]]:
    """The same of Exudyn, stopped where a rim meets the wall, and with springs."""
    if not importlib.util.find_spec("exudyn"):
        return
    from impact_exudyn import events, spring

    tolerances = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11)[:: 3 if quick else 1]
    settings = [("Exudyn", f"tol {tolerance:g}", events(DROPPED, tolerance)) for tolerance in tolerances]
    for stiffness in (1e8, 1e9, 1e10, 1e11)[: 1 if quick else 4]:
        name = f"{stiffness:g} N/m^1.5"
        settings.append(("Exudyn, springs", name, spring(DROPPED, 1e-6, stiffness)))
    for method, setting, motions in settings:
        error = np.abs(motions(radius) - exact).max()
        seconds = best_time(lambda motions=motions: motions(radius), 2 if quick else 5) / len(radius)
        yield {"method": method, "setting": setting, "error": error, "seconds": seconds}


def ratios_at(table: pd.DataFrame, error: float) -> dict[str, float]:
    """Times faster than each other method that comes to an error, between its settings log against log.

    A setting counts with the time of a finer one that takes less.
    """
    times = {}
    for method, rows in table.groupby("method", sort=False):
        rows = rows.sort_values("error")
        if rows["error"].iloc[0] > error:
            continue
        least = np.minimum.accumulate(rows["seconds"])
        times[method] = np.exp(np.interp(np.log(error), np.log(rows["error"]), np.log(least)))
    own = times.pop("tolmc")
    return {method: seconds / own for method, seconds in times.items()}


def restitutions() -> pd.DataFrame:
    """Restitution asked for, and measured at the first impact: 1 - e^2 is the energy lost over that lost without rebound."""
    rows = []
    for asked in (0.0, 0.25, 0.5, 0.75, 1.0):
        scene = replace(DROPPED, joint=replace(DROPPED.joint, restitution=asked), duration=0.045)
        motion = simulate(scene, step=1e-3)
        before, after = np.flatnonzero(motion.time == motion.events.time[0])[:2]
        side = "DE".index(motion.events.ends[0])
        rows.append({
            "asked": asked, "impulse (N s)": motion.events.impulse[0][side], "speed (m/s)": motion.events.speed[0][side],
            "energy lost (J)": motion.energy[before] - motion.energy[after],
        })  # fmt: skip
    table = pd.DataFrame(rows)
    lost = table["energy lost (J)"]
    return table.assign(measured=np.sqrt(np.maximum(1.0 - lost / lost[0], 0.0)))


def utilisation(quick: bool) -> pd.DataFrame:
    """Rounds of lanes that have a motion, of all rounds, and rounds beyond the steps for each impact."""
    steps, scene, rows = 100, replace(DROPPED, duration=0.25), []
    nominal = scene.scalars
    plan = plan_integration(scene, {"bearing_radius": (0.01999, 0.02001)}, step=scene.duration / steps)
    for n in (64, 512, 4096)[: 2 if quick else 3]:
        raw, _ = pack({**nominal, "bearing_radius": bores(n)}, n)
        found, counts = np.empty((results.RESULTS, n)), np.zeros(3, np.int64)
        nothing = np.empty((layout.RECORD, 0)), np.empty((layout.EVENT, 0))
        given = one_sided.given(raw, plan)
        call = (raw, given, steps, scene.duration, 10**6, 1e-6, found, counts, *nothing)
        kernel = entries.one_sided(**one_sided.kind(plan.features, plan.method))
        kernel(*call)
        busy, all_rounds = found[layout.R_ROUNDS].sum(), counts[0] * layout.WIDTH
        seconds = best_time(lambda kernel=kernel, call=call: kernel(*call), 3)
        impacts = found[[results.D_IMPACTS, results.E_IMPACTS]].sum()
        rows.append({
            "samples": n, "lanes busy": busy / all_rounds, "impacts a motion": impacts / n,
            "rounds an impact": (busy - n * steps) / impacts, "ns a lane and round": 1e9 * seconds / all_rounds,
        })  # fmt: skip
    return pd.DataFrame(rows)


def draw(table: pd.DataFrame) -> Figure:
    """Time a motion against error."""
    with rc_context(STYLE):
        figure = Figure(figsize=(6.4, 4.4), layout="constrained")
        axis = figure.add_subplot(xscale="log", yscale="log")
        for (method, rows), colour in zip(
            table.groupby("method", sort=False), (BLUE, ORANGE, GREEN, GREY, PURPLE, SKY), strict=False
        ):
            axis.plot(rows["error"], rows["seconds"], marker="o", color=colour, label=method)
        axis.set_title("A motion with three impacts")
        axis.set_xlabel("error of the pose after the third impact, over r")
        axis.set_ylabel("processor time a motion (s)")
        axis.legend()
    return figure


def main() -> None:
    options = arguments(__doc__)
    table = against_scipy(options.quick)
    show("Pose after the third impact", table, {"error": ".1e", "seconds": ".2e"})
    for error in (1e-6, 1e-8):
        found = ", ".join(
            f"{ratio:,.1f} times faster than {method}" for method, ratio in ratios_at(table, error).items()
        )
        print(f"at an error of {error:g}: {found}")
    formats = {"impulse (N s)": ".9f", "speed (m/s)": ".9f", "energy lost (J)": ".9f", "measured": ".12f"}
    show("Restitution asked for and measured", restitutions(), formats)
    formats = {"lanes busy": ".3f", "impacts a motion": ".1f", "rounds an impact": ".2f", "ns a lane and round": ".0f"}
    show("Lanes", utilisation(options.quick), formats)
    draw(table).savefig(options.figures / "impacts.png", dpi=150)


if __name__ == "__main__":
    main()
