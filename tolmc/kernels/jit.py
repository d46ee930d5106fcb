"""The one place where compilation is configured."""

from __future__ import annotations

import gc
import platform
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from types import FunctionType

import numba as nb
import numpy as np
from llvmlite.binding import get_host_cpu_features
from numba.core import event
from numba.core.compiler_lock import global_compiler_lock
from numba.extending import intrinsic

from tolmc.kernels import bare, code, kept, notices
from tolmc.kernels.code import Head
from tolmc.kernels.compiling import EntryCompiler, KernelCompiler, PieceCompiler

# Never nnan or ninf: a diverged lane must stay recognisable as NaN.
_STRICT = {"nogil": True, "error_model": "numpy"}
_OPTIONS = {**_STRICT, "fastmath": {"contract", "nsz", "arcp"}}

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


@device
def yes():
    """True, but no literal: for each literal a function is compiled anew."""
    return np.bool_(True)


@device
def no():
    """False, but no literal."""
    return np.bool_(False)


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
def _alone(function: FunctionType) -> Iterator[None]:
    """A context in which this function is compiled in no other process, nor anything else in this one."""
    # Numba's own lock first: its threads would otherwise wait for each other's.
    with (
        global_compiler_lock,
        kept.no_other_process(
            f"{function.__module__}.{function.__qualname__}", partial(notices.compiling, function.__module__)
        ),
        _collecting_rarely(),
    ):
        yield


class _Told(event.Listener):
    """Passes on what Numba says of its compilations of tolmc's functions."""

    def on_start(self, event: event.Event) -> None:
        if self._is_ours(event):
            notices.begin(event.data["dispatcher"].py_func.__module__)

    def on_end(self, event: event.Event) -> None:
        if self._is_ours(event):
            notices.end()

    @staticmethod
    def _is_ours(event: event.Event) -> bool:
        return (event.data["dispatcher"].py_func.__module__ or "").startswith("tolmc.")


event.register("numba:compile", _Told())


def _compiled_by_one(dispatcher):
    """The dispatcher of a kernel; processes that need it at the same time wait for the first, and read what it has compiled."""
    compile_or_read = dispatcher.compile

    def compile_alone(signature):
        with _alone(dispatcher.py_func):
            return compile_or_read(signature)

    dispatcher.compile = compile_alone
    return dispatcher


def kernel(function):
    """A function for Python and for other kernels, compiled once; it runs without the interpreter lock.

    Numba keeps it on disk where there is a place.
    """
    if kept.CACHE is None:
        return nb.njit(pipeline_class=KernelCompiler, **_OPTIONS)(function)
    # The directory is read when the function is decorated; restoring it leaves the user's own Numba functions alone.
    with _DECORATING:
        previous, nb.config.CACHE_DIR = nb.config.CACHE_DIR, str(kept.CACHE)
        try:
            compiled = nb.njit(cache=True, pipeline_class=KernelCompiler, **_OPTIONS)(function)
        finally:
            nb.config.CACHE_DIR = previous
    return compiled if nb.config.DISABLE_JIT else _compiled_by_one(compiled)


_TYPES = {
    "int": nb.int64, "float": nb.float64, "bool": nb.boolean, "Rows": bare.ROWS, "Counts": bare.COUNTS, "Table": bare.TABLE,
}  # fmt: skip


class LazyEntry:
    """A function of numbers and arrays for Python alone: compiled when it is called, or found on disk.

    ``template``: its arguments are of the kinds that its annotations say, as text (``from __future__ import annotations``), the
    last of them the ``buffers`` that it works in, which its callers leave out.
    """

    def __init__(
        self, name: str, template: Callable, function: FunctionType, buffers: Sequence[int], sizes: Mapping[str, int]
    ) -> None:
        self.__name__, self._function = name, function
        kinds = [kind for argument, kind in template.__annotations__.items() if argument != "return"]
        if not set(kinds) <= set(code.KINDS):
            allowed = ", ".join(code.KINDS)
            raise TypeError(f"{name}: its template's arguments are annotated {kinds}; allowed, as text: {allowed}")
        self.head = Head("", kinds, buffers, sizes, ())
        self._called: Callable | None = None

    def __call__(self, *arguments) -> None:
        if nb.config.DISABLE_JIT:
            self._function(*arguments, *code.buffers(self.head))
            return
        if self._called is None:
            with _alone(self._function):
                self._called = self._called or code.Called(*(code.read(self.__name__) or self._compiled()))
        self._called(*arguments)

    def _compiled(self) -> tuple[Head, bytes]:
        types = tuple(_TYPES[kind] for kind in self.head.arguments)
        compiled = nb.njit(pipeline_class=EntryCompiler, **_OF_PIECES, **_OPTIONS)(self._function)
        compiled.compile(types)
        made = compiled.overloads[types]
        machine_code, needs = made.library.machine_code()
        head = replace(self.head, symbol=made.fndesc.llvm_func_name, needs=needs)
        code.keep(self.__name__, head, machine_code)
        return head, machine_code


def entry(
    template: Callable, name: str, *, buffers: Sequence[int] = (), sizes: Mapping[str, int] | None = None, **parts
):
    """A :class:`LazyEntry` named ``name``: the function ``template``, ``parts`` in place of its module's names.

    On disk it is known by its name alone, for what stands behind it is sources, whose hash the cache's place carries.
    """
    return LazyEntry(name, template, _filled(template, name, parts), buffers, sizes or {})


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
