"""Files that are whole or absent: written beside their place, flushed, renamed; the lock of a run; row groups."""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from tolmc.runs.record import RunDirectoryError

# Rows of a row group: a column of a million samples is read in half the time that it takes from groups of 16,384.
ROW_GROUP = 65_536
# Random doubles do not compress, and every sample's row is read as a whole column or not at all.
PARQUET = {
    "compression": "NONE", "use_dictionary": ["status"], "write_statistics": False, "write_page_checksum": True,
}  # fmt: skip


def damaged(path: Path, what: str) -> RunDirectoryError:
    remedy = (
        "Delete it and resume: the block is computed again"
        if path.parent.name == "blocks"
        else "Restore it, or run the study into a new directory"
    )
    return RunDirectoryError(f"{path} is truncated or foreign: {what}. {remedy}.")


def read_table(path: Path, read: Callable[[], pa.Table]) -> pa.Table:
    try:
        return read()
    except (pa.ArrowInvalid, OSError) as error:
        raise damaged(path, f"it cannot be read ({str(error).splitlines()[0]})") from None


def row_groups(tables: Iterator[pa.Table]) -> Iterator[pa.Table]:
    """The rows of ``tables`` in tables of ROW_GROUP rows, the last one with the rest."""
    waiting, rows = [], 0
    for table in tables:
        waiting.append(table)
        rows += table.num_rows
        while rows >= ROW_GROUP:
            together = pa.concat_tables(waiting)
            yield together.slice(0, ROW_GROUP).unify_dictionaries()
            waiting, rows = [together.slice(ROW_GROUP)], rows - ROW_GROUP
    if rows:
        yield pa.concat_tables(waiting).unify_dictionaries()


def group_starts(file: pq.ParquetFile) -> np.ndarray:
    """First row of every row group."""
    counts = [file.metadata.row_group(group).num_rows for group in range(file.num_row_groups)]
    return np.cumsum([0, *counts[:-1]])


# What says that another process has the lock; any other error that there are no locks (ENOLCK, ENOTSUP, ENOSYS, ...).
_HELD = {errno.EWOULDBLOCK, errno.EAGAIN, errno.EACCES, errno.EDEADLK}

# What a filesystem answers that cannot flush directories (CIFS, vboxsf, 9p, FUSE), or flushes nothing.
_UNFLUSHED = {
    errno.EINVAL, errno.ENOTSUP, errno.EOPNOTSUPP, errno.ENOSYS, errno.EBADF, errno.EPERM, errno.EACCES, errno.EISDIR,
    errno.ENOTTY,
}  # fmt: skip


@contextmanager
def locked(path: Path) -> Iterator[None]:
    # The operating system drops the lock with the process, so a killed run leaves none behind.
    with (path / ".lock").open("ab") as file:
        try:
            _lock(file.fileno())
        except OSError as error:
            if error.errno not in _HELD:
                yield  # a filesystem without locks: runs must keep apart by themselves
                return
            raise RunDirectoryError(
                f"{path} is in use by another run. Wait for it to end, or choose another directory with --out."
            ) from None
        yield


def _lock(descriptor: int) -> None:
    if sys.platform == "win32":
        import msvcrt

        msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
    else:
        import fcntl

        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)


def write_whole(path: Path, write: Callable[[Path], object]) -> None:
    """A file that is whole wherever it has its name; that the name is on the disk, too, :func:`flush_names` sees to."""
    temporary = path.with_name(f".partial-{path.name}")
    try:
        write(temporary)
        _flush(temporary)
        temporary.replace(path)
    except OSError as error:
        if error.filename is None:  # of a write or a flush
            error.filename = str(path)
        raise
    finally:
        temporary.unlink(missing_ok=True)


def flush_names(folder: Path) -> None:
    """Names of the files in a folder, on the disk."""
    if os.name != "nt":  # Windows cannot flush a directory
        _flush(folder)


def _flush(path: Path) -> None:
    try:
        descriptor = os.open(path, os.O_RDONLY if path.is_dir() else os.O_RDWR)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
    except OSError as error:
        if error.errno not in _UNFLUSHED:
            raise
