"""Where compiled kernels are kept, and one process at a time that compiles one."""

from __future__ import annotations

import hashlib
import os
import stat
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

_HERE = Path(__file__).parent
_INSTALLED = {"site-packages", "dist-packages"}


def source_hash(folder: Path = _HERE) -> str:
    """Hash of every kernel source in ``folder`` and the folders below it, and of the compiler's version."""
    digest = hashlib.sha256(_compiler().encode())
    for path in sorted(folder.rglob("*.py")):
        digest.update(path.relative_to(folder).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def _compiler() -> str:
    try:
        return version("numba")
    except PackageNotFoundError:  # packed into one program, without what pip writes of it
        import numba

        return numba.__version__


def cache_directory() -> Path | None:
    """Where compiled kernels are kept: the first of these places that can be written, None where none can.

    What ``TOLMC_CACHE_DIR`` or else ``NUMBA_CACHE_DIR`` names; beside the sources of a checkout; in the user's cache; in the
    temporary folder. Not beside installed sources: what stands there that the installer does not know outlives an
    uninstall, and a folder without sources would then hide the package from a later editable install.

    A kernel is made of many files, and a changed helper must leave no stale caller: the directory's name carries the hash of
    all kernel sources.
    """
    name = f"numba-{source_hash()}"
    return next((root / name for root in _roots() if _takes_files(root / name)), None)


def _roots() -> Iterator[Path]:
    for variable in ("TOLMC_CACHE_DIR", "NUMBA_CACHE_DIR"):
        if chosen := os.environ.get(variable):
            yield Path(chosen).absolute()
    if not _INSTALLED & set(_HERE.parts):
        yield _HERE / "__pycache__"
    if user := os.environ.get("XDG_CACHE_HOME"):
        yield Path(user).absolute() / "tolmc"
    elif (home := os.path.expanduser("~")) != "~":  # which it stays where there is no home
        yield Path(home) / ".cache" / "tolmc"
    # Compiled code is loaded from there and run: the folder must be nobody else's.
    with suppress(OSError):  # no temporary folder at all
        shared = Path(tempfile.gettempdir()) / (f"tolmc-{os.getuid()}" if hasattr(os, "getuid") else "tolmc")
        with suppress(FileExistsError):
            shared.mkdir(mode=0o700)
        if _is_ours(shared):
            yield shared


def _is_ours(folder: Path) -> bool:
    """Whether nobody else can have put files into the folder."""
    if not hasattr(os, "getuid"):
        return True
    state = folder.lstat()
    return stat.S_ISDIR(state.st_mode) and state.st_uid == os.getuid() and not state.st_mode & 0o022


def _takes_files(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


#: The place, found once; None where nothing can be kept.
CACHE = cache_directory()


@contextmanager
def no_other_process(name: str, waiting: Callable[[], AbstractContextManager]) -> Iterator[None]:
    """A context that one process at a time is in; where the system has no locks of files, as many as come.

    ``waiting``: a context for the time that another one takes.
    """
    if sys.platform == "win32" or CACHE is None:
        yield
        return
    import fcntl

    try:
        file = (CACHE / f"{name}.lock").open("ab")
    except OSError:  # the folder is gone, or may no longer be written
        yield
        return
    with file:
        with suppress(OSError):  # a filesystem without locks
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                with waiting():
                    fcntl.flock(file, fcntl.LOCK_EX)
        try:
            yield
        finally:
            with suppress(OSError):
                fcntl.flock(file, fcntl.LOCK_UN)  # a forked child has the file open as well
