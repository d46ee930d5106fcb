"""The sample of a run that lies furthest out of its limits, and its motion once more."""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np
import pandas as pd

from tolmc import quantities
from tolmc.runs.directory import RunDirectory
from tolmc.runs.run import replay
from tolmc.statistics.outcomes import Specification, out_of_specification

WORST = "worst.png"
# In place of a standard deviation of zero: an output that does not vary is worst of all where it is out.
_LEAST = 1e-290


class Worst(NamedTuple):
    """Its place in the run, the output that makes it the worst, and that output's value."""

    sample: int
    output: str
    value: float


def worst_sample(samples: pd.DataFrame, specification: Specification, *, on_contact_loss: str = "stop") -> Worst | None:
    """The sample with the largest excess y - U or L - y over a limit, in standard deviations of the output.

    Where no sample is out it is the one nearest to a limit. None where nothing is known of any sample.

    Parameters
    ----------
    samples : of a run, the outputs with limits and ``status``
    specification, on_contact_loss
        As for :func:`tolmc.statistics.outcomes.out_of_specification`, with its errors.
    """
    _, known = out_of_specification(samples, specification, on_contact_loss=on_contact_loss)
    found, most = None, -np.inf
    for name, limits in specification.items():
        values = samples[name].to_numpy(float)
        ends = [limit for limit in (limits.get("min"), limits.get("max")) if limit is not None]
        signs = [sign for sign, end in ((-1.0, "min"), (1.0, "max")) if limits.get(end) is not None]
        usable = known[name] & np.isfinite(values)
        if not usable.any():
            continue
        excess = np.max([sign * (values - end) for sign, end in zip(signs, ends, strict=True)], axis=0)
        excess = np.where(usable, excess / max(values[usable].std(), _LEAST), -np.inf)
        place = int(np.argmax(excess))
        if excess[place] > most:
            found, most = Worst(place, name, float(values[place])), excess[place]
    return found


def draw_worst(directory: RunDirectory) -> None:
    """worst.png in a finished run with limits: the motion of its worst sample, integrated again; an old one goes.

    Raises
    ------
    InputError
        When that motion cannot be integrated.
    """
    (directory.path / WORST).unlink(missing_ok=True)
    study = directory.study()
    if not study.specification or not study.integrates:
        return
    columns = [*study.specification, "contact_loss_time", "status"]
    present = directory.read(rows=0).column_names
    samples = directory.read(columns=[name for name in columns if name in present]).to_pandas()
    worst = worst_sample(samples, study.specification, on_contact_loss=study.on_contact_loss)
    if worst is None:
        return
    from tolmc.pictures import plots

    _, scene, trajectory, _ = replay(directory.path, worst.sample)
    unit, factor = quantities.shown(worst.output)
    label = quantities.label(worst.output)
    title = f"{study.title}: sample {worst.sample:,}, {label} = {factor * worst.value:.6g} {unit}"
    directory.write_file(WORST, partial(plots.save, plots.draw_trajectory(trajectory, scene, title=title)))
