"""The one place where compilation is configured."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

import numba as nb

# Never nnan or ninf: a diverged lane must stay recognisable as NaN.
_OPTIONS = {"nogil": True, "error_model": "numpy", "fastmath": {"contract", "nsz", "arcp"}}

_HERE = Path(__file__).parent
_INSTALLED = {"site-packages", "dist-packages"}


def source_hash(folder: Path = _HERE) -> str:
    """Hash of every kernel source in ``folder`` and the folders below it, and of the compiler's version."""
    digest = hashlib.sha256(nb.__version__.encode())
    for path in sorted(folder.rglob("*.py")):
        digest.update(path.relative_to(folder).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def cache_directory() -> Path:
    """Where compiled kernels are kept: beside the sources of a checkout, else in the user's cache.

    Not beside installed sources: what stands there that the installer does not know outlives an uninstall, and a folder
    without sources would then hide the package from a later editable install.

    Numba's own key is the file of the function alone, so a changed helper in another file would leave a stale caller: the
    directory's name carries the hash of all kernel sources instead. ``TOLMC_CACHE_DIR`` overrides the place.
    """
    if override := os.environ.get("TOLMC_CACHE_DIR"):
        root = Path(override)
    elif os.access(_HERE, os.W_OK) and not _INSTALLED & set(_HERE.parts):
        root = _HERE / "__pycache__"
    else:
        root = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "tolmc"
    return root / f"numba-{source_hash()}"


_CACHE = str(cache_directory())


#: A scalar function that is inlined into the lane loops that call it.
device = nb.njit(forceinline=True, **_OPTIONS)

#: A scalar function or loop that its callers take over before they are compiled: not compiled itself, which many small ones
#: would be for nothing.
inlined = nb.njit(inline="always", **_OPTIONS)

#: A function of its own within a kernel: compiled once however often it is called.
routine = nb.njit(**_OPTIONS)


def kernel(function):
    """An entry point: compiled once, cached on disk, runs without the interpreter lock."""
    # The directory is read when the function is decorated; restoring it leaves the user's own Numba functions alone.
    previous, nb.config.CACHE_DIR = nb.config.CACHE_DIR, _CACHE
    try:
        return nb.njit(cache=True, **_OPTIONS)(function)
    finally:
        nb.config.CACHE_DIR = previous
