"""The one place where compilation is configured."""

from __future__ import annotations

import gc
import hashlib
import os
import platform
import stat
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import cache, wraps
from pathlib import Path
from types import FunctionType

import numba as nb
from llvmlite.binding import get_host_cpu_features
from numba.core import event
from numba.core.compiler_lock import global_compiler_lock
from numba.extending import intrinsic

from tolmc.kernels.compiling import EntryCompiler, KernelCompiler, PieceCompiler

# Never nnan or ninf: a diverged lane must stay recognisable as NaN.
_STRICT = {"nogil": True, "error_model": "numpy"}
_OPTIONS = {**_STRICT, "fastmath": {"contract", "nsz", "arcp"}}

_HERE = Path(__file__).parent
_INSTALLED = {"site-packages", "dist-packages"}


def source_hash(folder: Path = _HERE) -> str:
    """Hash of every kernel source in ``folder`` and the folders below it, and of the compiler's version."""
    digest = hashlib.sha256(nb.__version__.encode())
    for path in sorted(folder.rglob("*.py")):
        digest.update(path.relative_to(folder).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def cache_directory() -> Path | None:
    """Where compiled kernels are kept: the first of these places that can be written, None where none can.

    What ``TOLMC_CACHE_DIR`` or else ``NUMBA_CACHE_DIR`` names; beside the sources of a checkout; in the user's cache; in the
    temporary folder. Not beside installed sources: what stands there that the installer does not know outlives an
    uninstall, and a folder without sources would then hide the package from a later editable install.

    Numba's own key is the file of the function alone, so a changed helper in another file would leave a stale caller: the
    directory's name carries the hash of all kernel sources instead.
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


_CACHE = cache_directory()

#: Kernels are made in several threads, and Numba's setting is one for all.
_DECORATING = threading.Lock()


# Without _nrt=False a function that is handed arrays counts references to them, atomically, in every call; a piece so makes
# no arrays of its own, but views.
_OF_PIECES = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, "_nrt": False}


def _piece(**options) -> Callable:
    """Decorator of functions that compiled code alone calls."""
    return nb.njit(pipeline_class=PieceCompiler, **_OF_PIECES, **options)


#: A scalar function that is inlined into the lane loops that call it.
device = _piece(forceinline=True, **_OPTIONS)

#: The same, to the same bits in whichever loop: products and sums are not contracted, as each loop may do in its own way.
#: Said here too, or Numba would hand down the caller's leave to contract.
strict = _piece(forceinline=True, fastmath=False, **_STRICT)


def _product_and_sum(a, b, c):
    return a * b + c


def _fused(context, a, b, c):
    def generate(_, builder, signature, numbers):
        return builder.fma(*numbers)

    return nb.float64(nb.float64, nb.float64, nb.float64), generate


def _fma():
    fuses = get_host_cpu_features().get("fma") or platform.machine().lower() in ("arm64", "aarch64")
    return intrinsic(_fused) if fuses and not nb.config.DISABLE_JIT else strict(_product_and_sum)


#: a b + c, rounded once where the processor does it so: what strict pieces are contracted by, in every loop alike.
fma = _fma()


@strict
def dot(ax, ay, bx, by):
    """a.b in the plane."""
    return fma(ax, bx, ay * by)


#: A function of its own within a kernel: compiled once however often it is called.
#: Said, not left to the default: Numba hands the option of a function down to those that it compiles on the way.
routine = _piece(forceinline=False, **_OPTIONS)

#: A scalar function or loop that its callers take over before they are compiled: not compiled itself, which many small ones
#: would be for nothing.
inlined = nb.njit(inline="always", **_OPTIONS)


@contextmanager
def _collecting_rarely() -> Iterator[None]:
    """Garbage is sought less often within: looking through what a compilation keeps takes a tenth of its time, or a fifth."""
    thresholds = gc.get_threshold()
    gc.set_threshold(100_000, 50, 50)
    try:
        yield
    finally:
        gc.set_threshold(*thresholds)


@contextmanager
def _no_other_process(path: Path, dispatcher) -> Iterator[None]:
    """A context that one process at a time is in; where the system has no locks of files, as many as come."""
    if sys.platform == "win32":
        yield
        return
    import fcntl

    try:
        file = path.open("ab")
    except OSError:  # the folder is gone, or may no longer be written
        yield
        return
    with file:
        with suppress(OSError):  # a filesystem without locks
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                # For whoever watches it is a compilation, of another process.
                with event.trigger_event("numba:compile", data={"dispatcher": dispatcher}):
                    fcntl.flock(file, fcntl.LOCK_EX)
        try:
            yield
        finally:
            with suppress(OSError):
                fcntl.flock(file, fcntl.LOCK_UN)  # a forked child has the file open as well


def _compiled_by_one(dispatcher, folder: Path):
    """The dispatcher of a kernel; processes that need it at the same time wait for the first, and read what it has compiled."""
    function, compile_or_read = dispatcher.py_func, dispatcher.compile

    def compile_alone(signature):
        # Numba's own lock first: its threads would otherwise wait for each other's.
        with (
            global_compiler_lock,
            _no_other_process(folder / f"{function.__module__}.{function.__qualname__}.lock", dispatcher),
            _collecting_rarely(),
        ):
            return compile_or_read(signature)

    dispatcher.compile = compile_alone
    return dispatcher


def kernel(function, compiler: type = KernelCompiler):
    """An entry point: compiled once, cached on disk where there is a place, runs without the interpreter lock.

    Other kernels may call it, unless its ``compiler`` is the one of entries.
    """
    if _CACHE is None:
        return nb.njit(pipeline_class=compiler, **_OPTIONS)(function)
    # The directory is read when the function is decorated; restoring it leaves the user's own Numba functions alone.
    with _DECORATING:
        previous, nb.config.CACHE_DIR = nb.config.CACHE_DIR, str(_CACHE)
        try:
            compiled = nb.njit(cache=True, pipeline_class=compiler, **_OPTIONS)(function)
        finally:
            nb.config.CACHE_DIR = previous
    return compiled if nb.config.DISABLE_JIT else _compiled_by_one(compiled, _CACHE)


def is_kept(name: str) -> bool:
    """Whether a kernel of this name is found on disk; also True where nothing can be kept there."""
    return _CACHE is None or any(_CACHE.glob(f"*/*.{name}-*.nbi"))


def once(build: Callable) -> Callable:
    """A function that makes its result once for each choice of arguments, also when threads ask at the same time."""
    made, lock = cache(build), threading.RLock()

    @wraps(build)
    def build_once(*choice, **choices):
        with lock:
            return made(*choice, **choices)

    return build_once


def entry(template: Callable, name: str, **parts):
    """A :func:`kernel` named ``name`` for Python alone: the function ``template``, ``parts`` in place of its module's names.

    Numba's cache knows an entry by its name, its bytecode and the contents of its closure. Compiled functions in a closure
    would look different in every process; global names it does not look at, and what stands behind them is sources alone,
    whose hash the cache's place carries.
    """
    return kernel(_filled(template, name, parts), EntryCompiler)


def piece(template: Callable, name: str, **parts):
    """The same as a :data:`routine`."""
    return routine(_filled(template, name, parts))


def chain(functions: Sequence[Callable], pair: Callable[[Callable, Callable], Callable]) -> Callable | None:
    """One function that calls all of these in their order, ``pair(first, second)`` one that calls two; None without any.

    By halves: what is inlined is copied at every level, of which there would else be as many as functions.
    """
    if len(functions) < 2:
        return functions[0] if functions else None
    half = len(functions) // 2
    return pair(chain(functions[:half], pair), chain(functions[half:], pair))


def _filled(template: Callable, name: str, parts: dict) -> FunctionType:
    function = FunctionType(template.__code__, {**template.__globals__, **parts}, name)
    function.__qualname__, function.__module__ = name, template.__module__
    return function
