"""The run directory: what a Monte Carlo run leaves on disk, whole after a stop at any instant.

    DIR/study.toml, DIR/data/   the study as it was read, with its data files
    DIR/run.json                what the run is and how far it is: study hash, samples, sampling, seed, versions, state
    DIR/blocks/START.parquet    finished blocks of samples, named by their first sample, while the run goes on
    DIR/samples.parquet         a row a sample
    DIR/summary.csv, DIR/*.png  what people read

Every file is written beside its place, flushed to the disk and renamed, so a name always stands for a whole file. The
rows of samples.parquet come first, blocks hold the rows after them: that is all the state there is.
"""

from __future__ import annotations

import hashlib
import json
import os
import platform
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import partial
from itertools import chain
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from tolmc.runs.files import (
    PARQUET,
    ROW_GROUP,
    _flush,
    damaged,
    flush_names,
    group_starts,
    locked,
    read_table,
    row_groups,
    write_whole,
)
from tolmc.runs.record import FORMAT, RunDirectoryError, read_record, versions
from tolmc.study.file import load_study
from tolmc.study.sections import MAX_SAMPLES
from tolmc.study.study import Study, StudyError

_OUTPUTS = ("samples.parquet", "summary.csv", "blocks")


@dataclass(frozen=True)
class NextFree:
    """The directory ``first``, or where that is taken the same with a number behind it."""

    first: Path

    def claim(self) -> Path:
        """Make the directory and return its path; of two runs that claim at once each gets its own."""
        self.first.parent.mkdir(parents=True, exist_ok=True)
        path, number = self.first, 1
        while True:
            try:
                path.mkdir()
            except FileExistsError:
                number += 1
                path = self.first.with_name(f"{self.first.name}-{number}")
            else:
                return path


@contextmanager
def create(
    path: str | Path | NextFree, study: Study, *, block: int, plan: dict, most_samples: int | None = None
) -> Iterator[RunDirectory]:
    """A new run directory for ``study`` in blocks of ``block`` samples, locked until the context ends.

    ``plan`` (how the motions are integrated) is kept in run.json, so that a resumed run goes on as it began. So is
    ``most_samples``, which makes the run a sequential one: it grows until the study's ``until`` is met.

    Raises
    ------
    RunDirectoryError
        When the directory already holds a run or a file that the run would overwrite, or another run is in it.
    """
    path = path.claim() if isinstance(path, NextFree) else Path(path)
    copies = {
        "study.toml": study.source.encode(),
        **{f"data/{name}": text for name, text in study.data_files.items()},
    }
    _refuse_occupied(path, copies)
    path.mkdir(parents=True, exist_ok=True)
    with locked(path):
        _refuse_occupied(path, copies)
        for name, content in copies.items():
            (path / name).parent.mkdir(parents=True, exist_ok=True)
            write_whole(path / name, partial(Path.write_bytes, data=content))
        record = {
            "format": FORMAT,
            "title": study.title,
            "study_sha256": study.sha256,
            "samples": study.samples,
            **({} if most_samples is None else {"most_samples": most_samples}),
            "sampling": study.sampling,
            "seed": study.seed,
            "block": block,
            "plan": plan,
            "state": "running",
            "started": _now(),
            "versions": versions(),
            "machine": {"platform": platform.platform(), "cores": os.cpu_count()},
        }
        directory = RunDirectory(path, record)
        directory._save_record()
        yield directory


@contextmanager
def reopen(path: str | Path, *, study: Study | None = None, extend: int = 0) -> Iterator[RunDirectory]:
    """An existing run directory, locked until the context ends; ``extend`` raises its number of samples.

    Raises
    ------
    RunDirectoryError
        When it is no run directory, is damaged, belongs to another study (than ``study``, where given), is in use,
        or cannot be extended.
    """
    path = Path(path)
    read_record(path)
    with locked(path):
        directory = RunDirectory(path, read_record(path))
        if study is not None and study.sha256 != directory.record["study_sha256"]:
            raise RunDirectoryError(
                f"{path} belongs to another study or the study has changed since (its title there: "
                f"{directory.record['title']!r}). Run the changed study into a new directory."
            )
        if extend:
            directory._extend(extend)
        yield directory


def read(path: str | Path) -> RunDirectory:
    """An existing run directory, to read from it; RunDirectoryError when it is none or damaged."""
    return RunDirectory(Path(path), read_record(Path(path)))


@dataclass(frozen=True)
class RunDirectory:
    """An open run directory: its ``path`` and the ``record`` kept in run.json."""

    path: Path
    record: dict

    @property
    def samples_path(self) -> Path:
        return self.path / "samples.parquet"

    @property
    def is_complete(self) -> bool:
        return self.record["state"] == "complete"

    def study(self) -> Study:
        """The study of this run, with the number of samples and the seed that the run has."""
        return self._own_study().replaced(samples=self.record["samples"], seed=self.record["seed"])

    def sequential_study(self) -> Study | None:
        """The study as a sequential run was begun with it, ``until`` and the largest number of samples; else None."""
        most = self.record.get("most_samples")
        if most is None:
            return None
        study = self._own_study()
        if study.until is None:
            raise RunDirectoryError(
                f"{self.path / 'run.json'} is damaged: most_samples = {most}, but the study has no [monte_carlo] until. "
                "Restore it, or run anew."
            )
        return replace(study, samples=most, seed=self.record["seed"])

    def _own_study(self) -> Study:
        try:
            study = load_study(self.path / "study.toml", data_folder=self.path / "data")
        except StudyError as error:
            raise RunDirectoryError(f"{self.path}: its copy of the study is damaged: {error}") from None
        if study.sha256 != self.record["study_sha256"]:
            raise RunDirectoryError(
                f"{self.path}: study.toml has changed since the run began. Put it back as it was, or run the changed "
                "study into a new directory."
            )
        return study

    def rows(self) -> int:
        """Number of samples in samples.parquet."""
        if not self.samples_path.exists():
            return 0
        with self._open(self.samples_path, None) as file:
            return file.metadata.num_rows

    def read(self, columns: list[str] | None = None, rows: int | None = None) -> pa.Table:
        """Columns of samples.parquet (None: all), of its first ``rows`` samples (None: all)."""
        with self._open(self.samples_path, None) as file:
            groups = list(range(file.num_row_groups))
            if rows is not None:
                groups = groups[: int(np.searchsorted(group_starts(file), rows))]
            table = read_table(
                self.samples_path, partial(file.read_row_groups, groups, columns=columns, use_threads=False)
            )
        return table if rows is None else table.slice(0, rows)

    def row(self, index: int) -> dict[str, float | str]:
        """Sample ``index`` as {column: value}; RunDirectoryError where it is not there."""
        if index < self.rows():
            with self._open(self.samples_path, None) as file:
                starts = group_starts(file)
                group = int(np.searchsorted(starts, index, side="right")) - 1
                table = read_table(self.samples_path, partial(file.read_row_group, group))
            return table.slice(index - starts[group], 1).to_pylist()[0]
        for start, count in self.blocks():
            if start <= index < start + count and self.has_block(start):
                return self.read_block(start, count).slice(index - start, 1).to_pylist()[0]
        computed = "" if self.is_complete else " as far as they are computed"
        raise RunDirectoryError(
            f"{self.path} has no sample {index}; allowed: 0 to {self.record['samples'] - 1}{computed}."
        )

    def blocks(self) -> list[tuple[int, int]]:
        """First sample and number of samples of every block that follows samples.parquet."""
        first, last, block = self.rows(), self.record["samples"], self.record["block"]
        return [(start, min(block, last - start)) for start in range(first, last, block)]

    def has_block(self, start: int) -> bool:
        return self._block_path(start).exists()

    def read_block(self, start: int, count: int) -> pa.Table:
        """A finished block; RunDirectoryError where it is truncated or not of this run."""
        path = self._block_path(start)
        with self._open(path, start) as file:
            if file.metadata.num_rows != count:
                raise damaged(path, f"it holds {file.metadata.num_rows} samples, {count} are expected")
            return read_table(path, file.read)

    def write_block(self, start: int, table: pa.Table) -> None:
        self._block_path(start).parent.mkdir(exist_ok=True)
        table = table.replace_schema_metadata({**self._stamp(), b"tolmc.start": str(start).encode()})

        def write(temporary: Path) -> None:
            with pq.ParquetWriter(temporary, table.schema, **PARQUET) as writer:
                writer.write_table(table)

        write_whole(self._block_path(start), write)

    def write_samples(self, tables: Iterator[pa.Table]) -> None:
        """samples.parquet anew: its rows so far, then those of ``tables``, in row groups of one size."""

        def write(temporary: Path) -> None:
            everything = self._with_present(tables)
            first = next(everything)
            schema = first.schema.with_metadata(self._stamp())
            fitted = (self._fitted(table, schema) for table in chain([first], everything))
            with pq.ParquetWriter(temporary, schema, **PARQUET) as writer:
                for group in row_groups(fitted):
                    writer.write_table(group)
                    if group.num_rows == ROW_GROUP:
                        _flush(temporary)  # so that little is left to wait for once the last sample is there

        write_whole(self.samples_path, write)

    def write_text(self, name: str, text: str) -> None:
        write_whole(self.path / name, lambda temporary: temporary.write_text(text, encoding="utf-8"))

    def write_file(self, name: str, write: Callable[[Path], object]) -> None:
        """A file that ``write`` writes to the path it is given (with the same ending as ``name``)."""
        write_whole(self.path / name, write)

    def grow(self, samples: int) -> None:
        """Make ``samples`` the number of samples of this run, where it has fewer."""
        if samples > self.record["samples"]:
            self.record["samples"] = samples
            self._save_record()

    def finish(self, **facts) -> None:
        """Mark the run complete, keep ``facts`` about it in run.json, and remove the blocks."""
        self.record.update(state="complete", finished=_now(), **facts)
        if versions() != self.record["versions"]:
            self.record["versions_at_finish"] = versions()
        self._save_record()
        for leftover in (self.path / "blocks").glob("*"):
            leftover.unlink()
        with suppress(FileNotFoundError):
            (self.path / "blocks").rmdir()

    def _with_present(self, tables: Iterator[pa.Table]) -> Iterator[pa.Table]:
        if self.samples_path.exists():
            with self._open(self.samples_path, None) as file:
                for group in range(file.num_row_groups):
                    yield read_table(self.samples_path, partial(file.read_row_group, group))
        yield from tables

    def _fitted(self, table: pa.Table, schema: pa.Schema) -> pa.Table:
        if table.schema.names != schema.names:
            different = sorted(set(table.schema.names) ^ set(schema.names))
            raise RunDirectoryError(
                f"{self.path} was begun by tolmc {self.record['versions'].get('tolmc')}, this one computes other columns "
                f"({', '.join(different)}). Go on with that version, or run the study into a new directory."
            )
        return table.cast(schema)

    def _extend(self, count: int) -> None:
        if not self.is_complete:
            raise RunDirectoryError(f"{self.path}: the run is not finished; finish it first with --resume.")
        if self.record["sampling"] == "latin_hypercube":
            raise RunDirectoryError(
                f"{self.path}: a Latin hypercube is made for its number of samples and cannot be extended. Use "
                'sampling = "sobol" or "random", or run anew with more samples.'
            )
        self.rows()
        samples = self.record["samples"] + count
        if samples > MAX_SAMPLES:
            raise RunDirectoryError(
                f"{self.path}: {count} more would make {samples} samples; allowed: at most {MAX_SAMPLES}. Add fewer."
            )
        self.record.update(samples=samples, state="running")
        self._save_record()

    def _block_path(self, start: int) -> Path:
        return self.path / "blocks" / f"{start:012d}.parquet"

    def _stamp(self) -> dict[bytes, bytes]:
        # What fixes the rows: the same stamp means the same numbers, so a block of another run is recognised.
        parts = [self.record["study_sha256"], self.record["sampling"], str(self.record["seed"])]
        if self.record["sampling"] == "latin_hypercube":
            parts.append(str(self.record["samples"]))
        return {b"tolmc.run": hashlib.sha256("\n".join(parts).encode()).hexdigest().encode()}

    def _open(self, path: Path, start: int | None) -> pq.ParquetFile:
        try:
            file = pq.ParquetFile(path, page_checksum_verification=True, memory_map=True)
        except (pa.ArrowInvalid, OSError) as error:
            raise damaged(path, f"it cannot be read ({str(error).splitlines()[0]})") from None
        metadata = file.schema_arrow.metadata or {}
        expected = self._stamp() | ({} if start is None else {b"tolmc.start": str(start).encode()})
        if any(metadata.get(key) != value for key, value in expected.items()):
            raise damaged(path, "it comes from another run")
        return file

    def _save_record(self) -> None:
        self.write_text("run.json", json.dumps(self.record, indent=2, allow_nan=False) + "\n")
        flush_names(self.path)  # of all files up to here


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")


def _refuse_occupied(path: Path, copies: dict[str, bytes]) -> None:
    if path.exists() and not path.is_dir():
        raise RunDirectoryError(f"{path} is a file; choose a directory.")
    if (path / "run.json").exists():
        raise RunDirectoryError(
            f"{path} already holds a run. Go on with it by --resume, add samples by --extend, or choose another "
            "directory with --out."
        )
    # A run killed before run.json was there leaves copies of the study; they do not stop its next start.
    taken = [name for name in _OUTPUTS if (path / name).exists()]
    taken += [name for name, content in copies.items() if not _is_copy(path / name, content)]
    if taken:
        raise RunDirectoryError(
            f"{path} holds {taken[0]}, which the run would overwrite. Choose another directory with --out."
        )


def _is_copy(path: Path, content: bytes) -> bool:
    return not path.exists() or (path.is_file() and path.read_bytes() == content)
