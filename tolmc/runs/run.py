"""The Monte Carlo driver: blocks of samples over workers, their statistics, runs that survive.

A block draws its own samples, integrates them and comes back as columns, so everything but writing runs in parallel. One
plan of integration, made from the study alone, holds for all samples: no sample depends on the block it is in.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, nullcontext
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from tolmc import quantities
from tolmc.errors import ClusterError, InputError
from tolmc.mechanism.scene import Scene
from tolmc.quantities import SCALARS
from tolmc.runs import directory as run_directory
from tolmc.runs.ahead import kernel_ahead
from tolmc.runs.crew import Crew, crew
from tolmc.runs.directory import NextFree, RunDirectory
from tolmc.runs.impacts import step_errors
from tolmc.runs.integrate import integrate_study, status_words, study_plan
from tolmc.runs.model_terms import ModelTerms, model_terms, with_model_terms
from tolmc.runs.nominal import study_motion
from tolmc.runs.pictures import RunPictures, run_pictures
from tolmc.runs.progress import progress
from tolmc.runs.record import RunDirectoryError
from tolmc.runs.until import Sequential, looks_of, outcome, sample_study
from tolmc.shown import Shown
from tolmc.simulation.judge import STATUSES
from tolmc.simulation.plan import Plan, step_seconds
from tolmc.simulation.trajectory import Trajectory
from tolmc.statistics.columns import Columns
from tolmc.statistics.outcomes import ANY_REQUIREMENT, computed_share, out_of_specification
from tolmc.statistics.summary import count_statuses, summarise, summarise_requirements
from tolmc.study.file import load_study
from tolmc.study.study import Study
from tolmc.tolerances.draw import sample

#: Samples in a block, at most: about a tenth of a second of work and a few megabytes of results.
LARGEST_BLOCK = 16_384
# A multiple of the lanes that run together, so that few of them idle.
_BLOCK_STEP = 256
# Seconds of work in a block, at least: what handing it to a worker and writing it to the disk take.
_LEAST_WORK = 0.02


@dataclass(frozen=True, repr=False)
class StudyResult(Shown):
    """What a run found.

    Attributes
    ----------
    study : Study
        With the number of samples and the seed of this run.
    plan : Plan
        How the motions were integrated.
    nominal : dict
        Outputs at the nominal dimensions, SI units.
    sequential : Sequential or None
        How sampling ended, for a study with ``until``: at which number, and whether the interval was narrow enough.
    summary : DataFrame
        A row an output, SI units: :func:`tolmc.statistics.summary.summarise`. Its intervals, and those of the next two, are
        95 % intervals; those of a sequential run are wider, to hold at 95 % whichever look the run stops at.
    requirements, statuses : DataFrame
        :func:`tolmc.statistics.summary.summarise_requirements` and :func:`tolmc.statistics.summary.count_statuses`.
    samples : DataFrame
        A row a sample; read from the run directory on first use.
    directory : Path or None
        Where the run was written.
    elapsed : float
        Seconds from the call to the summary.
    notes : tuple of str
        What went wrong beside the statistics: pictures that could not be drawn.
    """

    study: Study
    plan: Plan
    nominal: dict[str, float | str]
    sequential: Sequential | None
    summary: pd.DataFrame
    requirements: pd.DataFrame
    statuses: pd.DataFrame
    directory: Path | None
    elapsed: float
    read: Callable[..., pa.Table] = field(repr=False)
    notes: tuple[str, ...] = ()

    @cached_property
    def samples(self) -> pd.DataFrame:
        return self.read().to_pandas()

    @property
    def computed_share(self) -> float:
        """Share of the samples that could be computed: ok, or contact lost at a known instant."""
        return computed_share(self.statuses)

    def __repr__(self) -> str:
        found = self.requirements.loc[ANY_REQUIREMENT] if self.study.specification else None
        kept = "" if found is None else f"; {100 * (1 - found['share_most']):.5g} % keep every limit"
        where = "" if self.directory is None else f"; in {self.directory}"
        return f"<StudyResult {self.study.title!r}: {self.study.samples:,} samples{kept}{where}>"


def run(
    study: Study | Mapping[str, Any] | str | Path,
    *,
    samples: int | None = None,
    seed: int | None = None,
    workers: int | None = None,
    out: str | Path | NextFree | None = None,
    cluster: str | None = None,
    on_summary: Callable[[StudyResult], None] | None = None,
) -> StudyResult:
    """Sample the dimensions of a study, integrate every sample, and summarise the outputs.

    Sample i depends on the seed and i alone (Latin hypercube: on the number of samples too): the results are bitwise
    equal for any number of workers, any block size, and on a cluster of like machines.

    Parameters
    ----------
    study : Study, path, or mapping as :meth:`tolmc.study.study.Study.from_dict` takes it
        With ``until``, samples are drawn until its interval is narrow enough, at most ``study.samples``.
    samples, seed, workers : int, optional
        In place of those of the study; ``samples`` in place of its ``until`` too.
    out : path, optional
        Run directory to write (:mod:`tolmc.runs.directory`); without it nothing is written.
    cluster : str, optional
        Address of a Dask scheduler on whose workers the blocks run, such as "tcp://host:8786".
    on_summary : function of a StudyResult, optional
        Called as soon as the statistics are known, while pictures are still being drawn: the result without their notes.

    Raises
    ------
    StudyError, RunDirectoryError, ClusterError
        When the study, the directory or the cluster cannot be used; nothing is written then.
    """
    began = time.perf_counter()
    if isinstance(study, Mapping):
        study = Study.from_dict(study)
    study = study if isinstance(study, Study) else load_study(study)
    study = study.replaced(samples=samples, seed=seed, workers=workers)
    with nullcontext() if cluster else kernel_ahead(study):
        with progress(f"{study.title}: choosing the step"):
            plan = study_plan(study)
        with crew(study.workers, cluster) as workforce:
            block = _block_size(study.samples, workforce.size, plan)
            if out is None:
                return _run_in_memory(study, plan, workforce, block, began, on_summary)
            most = None
            if study.until is not None:
                most, study = study.samples, study.replaced(samples=looks_of(study).start)
            with run_directory.create(out, study, block=block, plan=_record_of(plan), most_samples=most) as directory:
                return _run_into(directory, study, plan, workforce, began, on_summary)


def resume(
    directory: str | Path,
    *,
    study: Study | str | Path | None = None,
    extend: int = 0,
    workers: int | None = None,
    cluster: str | None = None,
    on_summary: Callable[[StudyResult], None] | None = None,
) -> StudyResult:
    """Go on with a stopped run, or add ``extend`` samples to a finished one.

    The outcome is bitwise equal to that of a run that was never stopped. ``study``, where given, must be the run's own.
    A sequential run goes on until its interval is narrow enough; once finished it gets just the samples asked for.
    ``on_summary``: as that of :func:`run`.

    Raises
    ------
    RunDirectoryError
        When the directory holds no run, is damaged or in use, belongs to another study, or cannot be extended.
    """
    began = time.perf_counter()
    if study is not None and not isinstance(study, Study):
        study = load_study(study)
    with run_directory.reopen(directory, study=study, extend=extend) as opened:
        study, plan = opened.study().replaced(workers=workers), _recorded_plan(opened)
        with crew(study.workers, cluster) as workforce:
            return _run_into(opened, study, plan, workforce, began, on_summary)


def default_directory(study: str | Path) -> NextFree:
    """``runs/<study name>``, with a number behind it where that is taken."""
    return NextFree(Path("runs") / Path(study).stem)


def replay(directory: str | Path, index: int) -> tuple[Study, Scene, Trajectory, dict]:
    """Sample ``index`` of a run once more: its study, scene, full trajectory, and its row in the run.

    Raises
    ------
    RunDirectoryError
        When the directory holds no run, or no such sample.
    InputError
        When the sample's geometry is invalid, so that it has no motion.
    """
    opened = run_directory.read(directory)
    study, row = opened.study(), opened.row(index)
    try:
        scalars = study.with_inertia({name: np.asarray(row[name], float) for name in SCALARS if name in row})
        scene = study.scene.replaced(**{name: float(value) for name, value in scalars.items()})
    except ValueError as error:
        raise InputError(f"sample {index} of {directory} has no motion: {error}") from None
    return study, scene, study_motion(study, scene), row


def _record_of(plan: Plan) -> dict:
    # JSON has neither NaN nor infinity: what is left out takes its default again, infinity is a word.
    return {name: "Infinity" if value == math.inf else value for name, value in asdict(plan).items() if value == value}


def _recorded_plan(directory: RunDirectory) -> Plan:
    plan = directory.record["plan"]
    try:
        return Plan(**{**plan, "pilot_error": float(plan.get("pilot_error", math.nan))})
    except TypeError as error:
        raise RunDirectoryError(
            f"{directory.path} was begun by tolmc {directory.record['versions'].get('tolmc')}, whose plan of integration this "
            f"one does not know ({error}). Go on with that version, or run the study into a new directory."
        ) from None


def _block(study: Study, plan: Plan, start: int, count: int) -> pa.Table:
    """Samples ``start`` ... ``start + count - 1``: drawn, integrated, as columns."""
    dimensions = sample(
        study.tolerances, count, sampling=study.sampling, seed=study.seed, start=start, total=study.samples
    )
    columns = integrate_study(study, plan, dimensions)
    columns["status"] = status_words(columns["status"])
    # Declared to have no nulls (a missing number is NaN), columns are written and read without a mask.
    fields = [pa.field(name, getattr(column, "type", pa.float64()), nullable=False) for name, column in columns.items()]
    return pa.table(columns, schema=pa.schema(fields))


def _block_size(samples: int, workers: int, plan: Plan) -> int:
    """Small enough for several blocks a worker, large enough to be worth its overhead."""
    share = max(-(-samples // (4 * workers)), int(_LEAST_WORK / (step_seconds(plan.features) * plan.steps)))
    return min(-(-share // _BLOCK_STEP) * _BLOCK_STEP, LARGEST_BLOCK)


class _InMemory:
    """The samples of a run that is written nowhere; a class, so that a result can be pickled."""

    def __init__(self) -> None:
        self.table: pa.Table | None = None

    def add(self, tables: Iterator[pa.Table]) -> None:
        before = [] if self.table is None else [self.table]
        self.table = pa.concat_tables([*before, *tables]).unify_dictionaries()

    def __call__(self, columns: list[str] | None = None, rows: int | None = None) -> pa.Table:
        assert self.table is not None
        chosen = self.table if columns is None else self.table.select(columns)
        return chosen if rows is None else chosen.slice(0, rows)


def _run_in_memory(
    study: Study, plan: Plan, workforce: Crew, block: int, began: float, on_summary: Callable | None
) -> StudyResult:
    kept = _InMemory()

    def draw(count: int) -> Columns:
        done = kept.table.num_rows if kept.table is not None else 0
        calls = ((study, plan, start, min(block, count - start)) for start in range(done, count, block))
        with progress(study.title, count, done) as counted, closing(workforce.map(_block, calls)) as computed:
            kept.add(counted(computed))
        return Columns(partial(kept, rows=count))

    sequential = None
    if study.until is None:
        draw(study.samples)
    else:
        sequential = sample_study(study, draw)
        study = study.replaced(samples=sequential.found.count)
    terms = model_terms(study, plan, workforce, _block, kept)
    with progress(f"{study.title}: statistics"):
        result = _result(study, plan, _nominal_outputs(study, plan), sequential, kept, None, began, terms)
    if on_summary is not None:
        on_summary(result)
    return result


def _run_into(
    directory: RunDirectory, study: Study, plan: Plan, workforce: Crew, began: float, on_summary: Callable | None
) -> StudyResult:
    try:
        with run_pictures(directory) as pictures:
            if study.integrates:
                pictures.draw_motion(study)
            sequential = _compute(directory, study, plan, workforce, pictures)
            study = study.replaced(samples=directory.record["samples"])
            nominal = _nominal_outputs(study, plan)
            pictures.draw_samples(study, nominal)
            terms = model_terms(study, plan, workforce, _block, directory.read)
            with progress(f"{study.title}: statistics"):
                result = _result(study, plan, nominal, sequential, directory.read, directory.path, began, terms)
            if on_summary is not None:
                on_summary(result)
            with progress(f"{study.title}: pictures"):
                result = replace(result, notes=pictures.finish())
        for name, table in terms.files.items():
            directory.write_file(name, partial(pq.write_table, table))
        directory.write_text("summary.csv", result.summary.to_csv())
        directory.write_text("requirements.csv", result.requirements.to_csv())
        stop: dict[str, Any] = {} if sequential is None else {"stopped_at": sequential.found.count}
        said = {"pilot": words} if (words := plan.unresolved_words()) else {}
        directory.finish(seconds=round(time.perf_counter() - began, 3), **stop, **said)
    except (OSError, KeyboardInterrupt, ClusterError) as error:
        error.add_note(f"Finished blocks are kept; go on with: tolmc run --resume {directory.path}")
        raise
    return result


def _compute(
    directory: RunDirectory, study: Study, plan: Plan, workforce: Crew, pictures: RunPictures
) -> Sequential | None:
    """All samples of a run in samples.parquet; of a sequential one, as many as it takes."""

    def draw(count: int) -> Columns:
        directory.grow(count)
        _compute_blocks(directory, study.replaced(samples=directory.record["samples"]), plan, workforce, pictures)
        return Columns(partial(directory.read, rows=count))

    asked, stopped_at = directory.sequential_study(), directory.record.get("stopped_at")
    if asked is not None and stopped_at is None:
        return sample_study(asked, draw)
    draw(directory.record["samples"])
    return None if asked is None else outcome(asked, Columns(partial(directory.read, rows=stopped_at)))


def _compute_blocks(directory: RunDirectory, study: Study, plan: Plan, workforce: Crew, pictures: RunPictures) -> None:
    """samples.parquet with all samples; blocks that are on the disk already are not computed again."""
    blocks = directory.blocks()
    missing = {start: count for start, count in blocks if not directory.has_block(start)}
    calls = ((study, plan, start, count) for start, count in missing.items())

    def in_order(computed: Iterator[pa.Table]) -> Iterator[pa.Table]:
        for start, count in blocks:
            if start in missing:
                table = next(computed)
                if len(blocks) > 1:  # else samples.parquet has it at once
                    directory.write_block(start, table)
                yield table
            else:
                yield directory.read_block(start, count)

    if blocks:
        done = study.samples - sum(missing.values())
        with progress(study.title, study.samples, done) as counted, closing(workforce.map(_block, calls)) as computed:
            tables = in_order(counted(computed))
            directory.write_samples(pictures.watch(tables, study) if blocks[0][0] == 0 else tables)


def _result(
    study: Study,
    plan: Plan,
    nominal: dict[str, float | str],
    sequential: Sequential | None,
    read: Callable[..., pa.Table],
    directory: Path | None,
    began: float,
    terms: ModelTerms,
) -> StudyResult:
    samples, specification = Columns(read), study.specification
    outputs = quantities.outputs_among(samples)
    drawn: dict[str, Any] = {"sampling": study.sampling, "lot_size": study.tolerances.lot_size or 1}
    if sequential is not None:
        drawn["confidence"] = sequential.looks.look_confidence
    judged = out_of_specification(samples, specification, on_contact_loss=study.on_contact_loss)
    judging: dict[str, Any] = {
        "specification": specification,
        "on_contact_loss": study.on_contact_loss,
        "judged": judged,
    }
    impacts = plan.features.one_sided and not math.isnan(plan.pilot_error)
    accuracies = step_errors(study, plan, read) if impacts else _integration_errors(plan, nominal)
    summary = summarise(samples, outputs=outputs, accuracies=accuracies, workers=study.workers, **judging, **drawn)
    summary.insert(0, "unit", [quantities.unit(name) for name in summary.index])
    requirements = summarise_requirements(samples, **judging, **drawn)
    summary, requirements = with_model_terms(summary, requirements, terms, study, read, **drawn)
    return StudyResult(
        study=study,
        plan=plan,
        nominal=nominal,
        sequential=sequential,
        summary=summary,
        requirements=requirements,
        statuses=count_statuses(samples, **drawn),
        directory=directory,
        elapsed=time.perf_counter() - began,
        read=read,
    )


def _nominal_outputs(study: Study, plan: Plan) -> dict[str, float | str]:
    row = pd.DataFrame([{dimension.name: dimension.nominal for dimension in study.tolerances.dimensions}])
    columns = {name: column[0] for name, column in integrate_study(study, plan, row).items()}
    return {**columns, "status": STATUSES[columns["status"]]}


def _integration_errors(plan: Plan, nominal: dict) -> dict[str, float]:
    """The pilot's error, relative to the larger contact-force maximum and to 1 rad, in the outputs' units."""
    statistics = [row for row in quantities.OUTPUT_ROWS if row.group == "statistics" and row.name in nominal]
    peaks = [abs(nominal[row.name]) for row in statistics if row.kind == "force" and row.settled == "grows"]
    known = [peak for peak in peaks if math.isfinite(peak)]  # an end that never touches has none
    scales = {"force": max(known, default=0.0), "angle": 1.0}
    return {row.name: plan.pilot_error * scales[row.kind] for row in statistics if row.kind in scales}
