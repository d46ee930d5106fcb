"""How studies, results and trajectories look in a notebook: HTML of their tables, and their pictures."""

from __future__ import annotations

from collections.abc import Callable
from functools import singledispatch
from typing import Any

from matplotlib.figure import Figure

from tolmc import quantities
from tolmc.errors import InputError
from tolmc.pictures import DISTRIBUTIONS, plots
from tolmc.runs.nominal import study_motion
from tolmc.runs.run import StudyResult
from tolmc.simulation.trajectory import Trajectory
from tolmc.statistics.drivers import drivers_of
from tolmc.study.study import Study
from tolmc.tables.motion import extremes_table
from tolmc.tables.page import page
from tolmc.tables.run import run_blocks
from tolmc.tables.understood import understood_blocks

_RANKED = 10_000  # samples, for pictures of what drives what


@singledispatch
def html(shown: Any) -> str:
    """HTML of what there is to show."""
    raise TypeError(f"{type(shown).__name__} has no page")


@html.register
def _(study: Study) -> str:
    study.introduce()
    return page(understood_blocks(study))


@html.register
def _(result: StudyResult) -> str:
    result.study.introduce()
    return page(run_blocks(result))


@html.register
def _(trajectory: Trajectory) -> str:
    return page([extremes_table(trajectory)])


def picture(shown: Any, kind: str | None = None) -> Figure:
    """The picture of that kind; the first there is when none is named.

    Raises
    ------
    InputError
        Where there is no such picture; the message names those there are.
    """
    kinds = pictures(shown)
    if kind is None:
        return next(iter(kinds.values()))()
    if kind not in kinds:
        raise InputError(f"plot: kind = {kind!r} is unknown; allowed: {', '.join(kinds)}.")
    return kinds[kind]()


@singledispatch
def pictures(shown: Any) -> dict[str, Callable[[], Figure]]:
    """The pictures there are, by their kind."""
    raise TypeError(f"{type(shown).__name__} has no pictures")


@pictures.register
def _(study: Study) -> dict[str, Callable[[], Figure]]:
    def motion() -> Figure:
        return plots.draw_trajectory(study_motion(study), study.scene, title=f"{study.title}: nominal motion")

    return {"motion": motion}


@pictures.register
def _(result: StudyResult) -> dict[str, Callable[[], Figure]]:
    study, samples = result.study, result.samples
    study.introduce()
    outputs = quantities.outputs_among(samples)

    def distributions() -> Figure:
        nominal = {name: value for name, value in result.nominal.items() if not isinstance(value, str)}
        shown = [name for name in (*study.specification, *DISTRIBUTIONS) if name in samples] or outputs[:1]
        return plots.draw_distributions(
            samples,
            list(dict.fromkeys(shown)),
            nominal=nominal,
            specification=study.specification,
            title=study.title,
        )

    def drivers() -> Figure:
        names = study.tolerances.shown_names
        varied = [dimension.name for dimension in study.tolerances.varied]
        first = samples[[*varied, *outputs]].iloc[:_RANKED].rename(columns=names)
        return plots.draw_drivers(drivers_of(first, [names[name] for name in varied]), title=study.title)

    return {"distributions": distributions, "drivers": drivers, **pictures(study)}


@pictures.register
def _(trajectory: Trajectory) -> dict[str, Callable[[], Figure]]:
    def motion() -> Figure:
        if trajectory.scene is None:
            raise InputError("plot: this trajectory does not know its scene; simulate it anew.")
        return plots.draw_trajectory(trajectory, trajectory.scene, title="Motion")

    return {"motion": motion}
