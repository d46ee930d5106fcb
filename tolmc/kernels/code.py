"""Machine code of an entry: written to a file and read again, loaded and called; without Numba.

Numba takes half a second to load, as long as a small run computes: it is needed where a kernel is compiled, not where one is
found on disk. Both run as this module loads them.
"""

from __future__ import annotations

import ctypes
import hashlib
import json
import os
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import cache
from itertools import chain
from pathlib import Path
from typing import NamedTuple

import llvmlite.binding as llvm
import numpy as np

from tolmc.kernels import kept

_LINE = 64  # bytes of a cache line: a vector that straddles two costs two loads


class _Kind(NamedTuple):
    """What an argument is in a call, and of which array."""

    words: tuple
    dtype: type | None = None
    dimensions: int = 0


_ADDRESS, _WHOLE, _SIZE = ctypes.c_void_p, ctypes.c_int64, ctypes.c_ssize_t
#: Kinds of arguments, as the templates' annotations have them.
KINDS: Mapping[str, _Kind] = {
    "int": _Kind((_WHOLE,)),
    "float": _Kind((ctypes.c_double,)),
    "bool": _Kind((ctypes.c_bool,)),
    "Rows": _Kind((_ADDRESS,), np.float64, 1),
    "Counts": _Kind((_ADDRESS,), np.int64, 1),
    "Table": _Kind((_ADDRESS, _SIZE, _SIZE), np.float64, 2),
}


@dataclass(frozen=True)
class Head:
    """What an entry's file says before the machine code.

    Attributes
    ----------
    symbol : name of the function
    arguments : the kind of each of its arguments, in order; a key of :data:`KINDS`
    buffers : numbers in the buffers that it works in, its last arguments
    sizes : of what a caller must make room for, by name
    needs : functions that it calls, of the system's libraries
    """

    symbol: str
    arguments: Sequence[str]
    buffers: Sequence[int]
    sizes: Mapping[str, int]
    needs: Sequence[str]


# Files


@cache
def _processor() -> str:
    """What code is for: the processor, and what Numba is told of it."""
    told = [os.environ.get(f"NUMBA_{what}") for what in ("CPU_NAME", "CPU_FEATURES", "ENABLE_AVX", "OPT")]
    processor = llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten(), llvm.llvm_version_info, told
    return hashlib.sha256(repr(processor).encode()).hexdigest()[:8]


def _file(name: str) -> Path | None:
    return None if kept.CACHE is None else kept.CACHE / f"{name}-{_processor()}.code"


def is_kept(name: str) -> bool:
    """Whether an entry of this name is found on disk; also True where nothing can be kept there."""
    file = _file(name)
    return file is None or os.access(file, os.R_OK)


def keep(name: str, head: Head, machine_code: bytes) -> None:
    """Write an entry to the disk, whole or not at all."""
    file = _file(name)
    if file is None:
        return
    content = json.dumps(asdict(head)).encode() + b"\n" + machine_code
    new = file.with_suffix(f".{os.getpid()}.{threading.get_ident()}.new")
    try:
        new.write_bytes(_digest(content) + b"\n" + content)
        os.replace(new, file)
    except OSError:  # a disk that is full, or a folder that is gone, costs a compilation
        with suppress(OSError):
            new.unlink(missing_ok=True)


def _digest(content: bytes) -> bytes:
    return hashlib.sha256(content).hexdigest().encode()


def read(name: str) -> tuple[Head, bytes] | None:
    """An entry from the disk; None where there is none, or not what has been written there, or not what it calls."""
    file = _file(name)
    with suppress(OSError, ValueError, TypeError):
        if file is not None:
            digest, content = file.read_bytes().split(b"\n", 1)
            if digest == _digest(content):
                said, machine_code = content.split(b"\n", 1)
                head = Head(**json.loads(said))
                return (head, machine_code) if all(map(_is_there, head.needs)) else None
    return None


def _is_there(function: str) -> bool:
    """Whether this process has such a function; libraries that Numba brings it has with Numba."""
    _looks_around()
    return llvm.address_of_symbol(function) is not None


@cache
def _looks_around() -> None:
    """The first engine has LLVM look at all that the process has loaded."""
    _engine()


# Calls


def _of_array(array: np.ndarray, kind: _Kind) -> tuple[int, ...]:
    is_plain = isinstance(array, np.ndarray) and array.flags.c_contiguous
    if not (is_plain and array.dtype == kind.dtype and array.ndim == kind.dimensions):
        raise TypeError(
            f"an entry takes a contiguous array of {kind.dimensions} dimension(s) of {np.dtype(kind.dtype)}, "
            f"not {getattr(array, 'dtype', type(array))} in the shape {np.shape(array)}"
        )
    return (array.ctypes.data, *array.shape) if array.ndim == 2 else (array.ctypes.data,)


def _buffer(numbers: int, dtype: type | None) -> np.ndarray:
    """An array that begins on a cache line."""
    whole: np.ndarray = np.empty(numbers + _LINE // 8, dtype)
    skip = -(whole.ctypes.data // 8) % (_LINE // 8)
    return whole[skip : skip + numbers]


def buffers(head: Head) -> list[np.ndarray]:
    """What an entry works in, anew for each call."""
    kinds = [KINDS[kind] for kind in head.arguments[len(head.arguments) - len(head.buffers) :]]
    return [_buffer(numbers, kind.dtype) for kind, numbers in zip(kinds, head.buffers, strict=True)]


class Called:
    """An entry as a function of numbers and arrays, which runs without the interpreter lock.

    It takes what its head's arguments say, but for the buffers: numbers, and contiguous arrays of float64 or int64, of one or
    two dimensions. TypeError for any other array, which would be read as what it is not.
    """

    def __init__(self, head: Head, machine_code: bytes) -> None:
        self.head, self._keeps_code = head, _loaded(machine_code)
        self._kinds = [KINDS[kind] for kind in head.arguments]
        types = chain.from_iterable(kind.words for kind in self._kinds)
        # Numba's convention: places for the result and for an error, and 0 where all went well.
        prototype = ctypes.CFUNCTYPE(ctypes.c_int32, _ADDRESS, _ADDRESS, *types)
        address = self._keeps_code.get_function_address(head.symbol)
        if not address:
            raise RuntimeError(f"there is no {head.symbol} in its machine code")
        self._function: Callable = prototype(address)

    def __call__(self, *arguments) -> None:
        arguments = (*arguments, *buffers(self.head))
        words: list = []
        for kind, argument in zip(self._kinds, arguments, strict=True):
            words += _of_array(argument, kind) if kind.dtype else (argument,)
        nothing = (ctypes.c_void_p * 2)()
        if self._function(ctypes.addressof(nothing), ctypes.addressof(nothing) + 8, *words):
            raise RuntimeError(f"{self.head.symbol} has failed")  # no entry raises


def _loaded(machine_code: bytes):
    """The engine that holds the code, for as long as it lives."""
    engine = _engine()
    engine.add_object_file(llvm.ObjectFileRef.from_data(machine_code))
    engine.finalize_object()
    return engine


def _engine():
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    triple = llvm.get_process_triple()
    machine = llvm.Target.from_triple(triple).create_target_machine(jit=True)
    return llvm.create_mcjit_compiler(llvm.parse_assembly(f'target triple = "{triple}"'), machine)


def kept_entry(name: str) -> Called | None:
    """An entry that is found on disk and can be loaded as it is; None else, or where nothing is to be compiled."""
    if os.environ.get("NUMBA_DISABLE_JIT", "0") != "0":
        return None
    found = read(name)
    return None if found is None else Called(*found)
