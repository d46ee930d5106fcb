"""The pictures of a run, drawn beside the workers: Matplotlib takes as long as the statistics do."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager
from types import SimpleNamespace
from typing import Any

import pyarrow as pa

from tolmc import quantities
from tolmc.pictures import DISTRIBUTIONS
from tolmc.pictures.painters import PAINTERS, paint
from tolmc.runs.directory import RunDirectory
from tolmc.runs.nominal import study_motion
from tolmc.statistics.columns import Columns
from tolmc.statistics.drivers import RANKED, drivers_of
from tolmc.study.study import Study

# What is drawn of a motion.
_OF_MOTION = ("time", "origin", "axis", "contact_force", "closed", "events")


class RunPictures:
    """nominal.png, drivers.png and distributions.png of a run, each begun as soon as what it shows is known."""

    def __init__(self, directory: RunDirectory, threads: Executor) -> None:
        self._directory, self._threads = directory, threads
        self._pictures: dict[str, Future] = {}
        self._has_drivers = False

    def draw_motion(self, study: Study) -> None:
        """nominal.png."""
        self._begin("nominal.png", draw_motion, study)

    def watch(self, tables: Iterable[pa.Table], study: Study) -> Iterator[pa.Table]:
        """Passes on the samples of a run, from the first one on; begins drivers.png with the first of them."""
        seen, rows = [], 0
        for table in tables:
            if rows < RANKED:
                seen.append(table)
                rows += table.num_rows
                if rows >= RANKED:
                    self._draw_drivers(study, pa.concat_tables(seen).slice(0, RANKED))
                    seen.clear()
            yield table

    def draw_samples(self, study: Study, nominal: dict[str, float | str]) -> None:
        """distributions.png, and drivers.png where :meth:`watch` has not seen enough samples for it."""
        if not self._has_drivers:  # the longest to draw
            self._draw_drivers(study, self._directory.read(rows=RANKED))
        self._begin("distributions.png", draw_distributions, study, nominal)

    def finish(self) -> tuple[str, ...]:
        """Wait for the pictures; a sentence on each that could not be drawn, which must cost a run no statistics."""
        errors = {name: picture.exception() for name, picture in self._pictures.items()}
        return tuple(
            f"{name} could not be drawn ({type(error).__name__}: {' '.join(str(error).split())[:200]}); all else is there."
            for name, error in errors.items()
            if error is not None
        )

    def _draw_drivers(self, study: Study, first: pa.Table) -> None:
        self._has_drivers = True
        self._begin("drivers.png", draw_drivers, study, first)

    def _begin(self, name: str, draw: Callable, *shown) -> None:
        self._pictures[name] = self._threads.submit(draw, self._directory, *shown)


@contextmanager
def run_pictures(directory: RunDirectory) -> Iterator[RunPictures]:
    """The pictures of a run, all of them drawn when the context ends."""
    with ThreadPoolExecutor(PAINTERS) as thread:
        yield RunPictures(directory, thread)


def draw_motion(directory: RunDirectory, study: Study) -> None:
    """nominal.png: the motion at the nominal dimensions."""
    motion = study_motion(study)
    # Not as a Trajectory, with which a process that only draws would have to load the kernels.
    seen = SimpleNamespace(**{name: getattr(motion, name) for name in _OF_MOTION})
    _write(directory, "nominal.png", "draw_trajectory", seen, study.scene, title=f"{study.title}: nominal motion")


def draw_drivers(directory: RunDirectory, study: Study, first: pa.Table) -> None:
    """drivers.png: what drives which output, from the first samples."""
    varied = [dimension.name for dimension in study.tolerances.varied]
    shown = [*varied, *quantities.outputs_among(first.column_names)]
    names = study.tolerances.shown_names
    samples = first.select(shown).to_pandas().rename(columns=names)
    found = drivers_of(samples, [names[name] for name in varied])
    _write(directory, "drivers.png", "draw_drivers", found, title=study.title)


def draw_distributions(directory: RunDirectory, study: Study, nominal: Mapping[str, Any]) -> None:
    """distributions.png: histograms of all samples."""
    samples = Columns(directory.read)
    shown = [name for name in DISTRIBUTIONS if name in samples] or quantities.outputs_among(samples)[:1]
    _write(
        directory, "distributions.png", "draw_distributions", {name: samples[name].to_numpy() for name in shown}, shown,
        nominal=nominal, specification=study.specification, title=study.title,
    )  # fmt: skip


def _write(directory: RunDirectory, name: str, draw: str, *shown, **words) -> None:
    directory.write_file(name, lambda path: paint(path, draw, *shown, **words))
