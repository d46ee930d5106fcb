"""Many samples: one motion each, in blocks over threads, a row of outputs a sample."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from tolmc.mechanism.checks import choice, plain_array
from tolmc.mechanism.scene import Scene
from tolmc.quantities import ON_CONTACT_LOSS, SCALARS
from tolmc.simulation.block import block_columns
from tolmc.simulation.integration import WIDTH
from tolmc.simulation.judge import STATUSES
from tolmc.simulation.outputs import checked_outputs, integrates, scene_outputs
from tolmc.simulation.pilot import plan_integration
from tolmc.simulation.plan import Plan

_WORDS = pd.Series(STATUSES).array

# Rows of so many samples, or of a multiple, share sets of the cache: motions with statistics or impacts take 5 % longer.
_PAGE = 512
_CHUNK = 8192  # most samples a call of a kernel: half as many take 3 % longer, twice as many gain 1 %


def simulate_many(
    scene: Scene,
    *,
    bearing_radius: ArrayLike,
    journal_radius: ArrayLike,
    half_length: ArrayLike,
    parameters: Mapping[str, object] | None = None,
    step: float | None = None,
    method: str = "rk8",
    formulation: str = "slope",
    outputs: Sequence[str] | None = None,
    workers: int = 1,
    accuracy: float | None = None,
    on_contact_loss: str = "stop",
    project_energy: bool = False,
    halving: bool = False,
    plan: Plan | None = None,
) -> pd.DataFrame:
    """Integrate one motion a sample and return its statistics, a row a sample in the order given.

    The start angles of the scene are kept when the dimensions vary, so every sample starts on its own circles.

    Parameters
    ----------
    bearing_radius, journal_radius, half_length : (n,) array_like, m
    parameters : mapping from further names in quantities.SCALARS to (n,) array_like, SI units
    step : float, s
        Fixed step; None: chosen by a pilot on the nominal and the corner dimensions (:func:`plan_integration`).
    method : {"rk8", "rk4", "auto"}
        A symmetric body whose contact forces nobody asks for has a formula of order 8 that takes fewer steps.
    formulation : {"slope", "published", "published-regular"}
    outputs : names in :data:`tolmc.quantities.OUTPUTS` or :data:`tolmc.quantities.END_OUTPUTS`
        None: all that the scene has (:func:`scene_outputs`). What is not asked for is not computed; geometry alone
        integrates nothing.
    workers : int
        Threads; the results do not depend on it.
    accuracy : float
        A sample whose invariants (energy, constraints; angular momentum about Z and Omega where they are conserved) are
        missed by more, or whose statistics contradict each other by more, has status "inaccurate".
    on_contact_loss : {"stop", "continue", "end", "follow"}
        At the first instant at which a contact force turns negative the sample ends, all its outputs with it ("stop", "end":
        tables count what the first leaves open both ways, what the second leaves as it is), or it goes on two-sided, as the
        paper's model. With restitution there is "follow" alone (the default too): the motion goes on through flight and
        impacts.
    project_energy : bool
        Also project every step on the energy; ``energy_correction`` is what that took out in all, and is judged as an error.
    halving : bool
        Integrate every sample once more with twice the steps, at three times the cost; one whose end of motion, tilt or
        force statistics differ by more than ``accuracy`` is "inaccurate". Finds chaotic motions, whose invariants look well.
    plan : Plan
        Overrides step, method, formulation and accuracy (used by the Monte Carlo driver, which plans once).

    Returns
    -------
    pandas.DataFrame
        The inputs, the outputs (m, rad, N, s), ``status_time`` (s; NaN when ok) and ``status``: "ok", "contact lost",
        "diverged", "inaccurate", "geometry invalid", "body invalid", "singular: ..." (published formulations only).

    Raises
    ------
    ValueError, TypeError
        Before any work starts: unknown names, columns of different lengths, values out of range. A sample that cannot be
        integrated raises nothing: it has a status.
    """
    dimensions = {"bearing_radius": bearing_radius, "journal_radius": journal_radius, "half_length": half_length}
    inputs, n = _sample_columns({**dimensions, **(parameters or {})})
    names = checked_outputs(outputs)
    if isinstance(workers, bool) or not isinstance(workers, (int, np.integer)) or workers < 1:
        raise ValueError(f"workers = {workers!r} is out of range; allowed: a whole number >= 1.")
    after: dict[str, Any] = {"on_contact_loss": on_contact_loss, "project_energy": project_energy}
    plan = plan or plan_integration(
        scene, _bounds(inputs), step=step if integrates(names) else scene.duration, method=method, formulation=formulation,
        accuracy=accuracy, outputs=names, halving=halving, samples=n, **after,
    )  # fmt: skip
    asked = names or scene_outputs(plan, project_energy)
    numbers = np.empty((len(inputs) + len(asked) + 1, n))
    numbers[: len(inputs)] = list(inputs.values())
    part = numbers[len(inputs) :]
    columns = integrate_columns(scene, inputs, n, plan=plan, outputs=asked, workers=int(workers), into=part, **after)
    return _frame([*inputs, *asked, "status_time"], numbers, columns["status"])


def _frame(names: Sequence[str], numbers: np.ndarray, status: np.ndarray) -> pd.DataFrame:
    """The numbers (name, sample), and the status in words."""
    # pandas takes one array as it is; it would look at each of forty columns, and at every word of one that holds objects.
    frame = pd.DataFrame(numbers.T, columns=list(names), copy=False)
    frame["status"] = _WORDS.take(status)
    return frame


def _bounds(inputs: Mapping[str, np.ndarray]) -> dict[str, tuple[float, float]]:
    """Least and largest finite value of each column."""
    finite = {name: column[np.isfinite(column)] for name, column in inputs.items()}
    return {name: (float(c.min()), float(c.max())) for name, c in finite.items() if len(c)}


def integrate_columns(
    scene: Scene,
    inputs: Mapping[str, np.ndarray],
    n: int,
    *,
    plan: Plan,
    outputs: Sequence[str],
    workers: int = 1,
    on_contact_loss: str = "stop",
    project_energy: bool = False,
    into: np.ndarray | None = None,
) -> dict[str, np.ndarray]:
    """What :func:`simulate_many` does once everything is decided: ``n`` samples as bare columns.

    Parameters
    ----------
    inputs : mapping from names in quantities.SCALARS to (n,) float arrays, SI units
    into : (len(outputs) + 1, n) float array that gets the outputs and ``status_time``; None: a fresh one

    Returns
    -------
    dict
        The outputs, ``status_time``, and ``status`` as places in :data:`STATUSES`, (n,) each.
    """
    choice("on_contact_loss", on_contact_loss, ON_CONTACT_LOSS)
    size = min(_CHUNK, -(-n // (workers * WIDTH)) * WIDTH)
    if size % _PAGE == 0:
        size += WIDTH  # not less: powers of two would leave a rest
    into = np.empty((len(outputs) + 1, n)) if into is None else into
    columns = dict(zip((*outputs, "status_time"), into, strict=True))
    columns["status"] = np.empty(n, np.int64)

    def chunk(first: int) -> None:
        part = {name: column[first : first + size] for name, column in inputs.items()}
        count = min(size, n - first)
        found = block_columns(scene, part, count, outputs, plan, on_contact_loss, project_energy)
        for name, column in columns.items():
            column[first : first + count] = found[name]

    starts = range(0, n, max(size, 1))
    if workers == 1 or len(starts) <= 1:
        for first in starts:
            chunk(first)
    else:
        with ThreadPoolExecutor(workers) as threads:
            list(threads.map(chunk, starts))
    return columns


def _sample_columns(columns: Mapping[str, object]) -> tuple[dict[str, np.ndarray], int]:
    """``columns`` as float arrays of one length, and that length."""
    arrays = {}
    for name, column in columns.items():
        choice("parameters", name, SCALARS)
        arrays[name] = plain_array(f"simulate_many: {name}", column)
    try:
        shape = np.broadcast_shapes(*(a.shape for a in arrays.values()))
    except ValueError:
        shapes = ", ".join(f"{name} {a.shape}" for name, a in arrays.items())
        raise ValueError(f"simulate_many: columns have different lengths: {shapes}; give one value a sample.") from None
    if len(shape) > 1:
        raise ValueError(f"simulate_many: columns must be one-dimensional, got shape {shape}.")
    n = shape[0] if shape else 1
    return {name: np.array(np.broadcast_to(a, (n,))) for name, a in arrays.items()}, n
