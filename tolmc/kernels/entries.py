"""The entries of all kernels: found on disk, or composed and compiled, for which alone Numba is loaded."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module

from tolmc.kernels import names
from tolmc.kernels.code import kept_entry
from tolmc.kernels.once import once

_ENGINE, _ONE_SIDED = "tolmc.kernels.engine", "tolmc.kernels.one_sided"


def _entry(name: str, module: str, build: str, *choice, **choices) -> Callable:
    """The entry of this name on disk, or what ``build`` of this module makes."""
    return kept_entry(name) or getattr(import_module(module), build)(*choice, **choices)


@once
def integrate(formulation: str, method: str, *, load: bool, forces: bool) -> Callable:
    """:func:`tolmc.kernels.engine.build`."""
    name = names.integrate(formulation, method, load=load, forces=forces)
    return _entry(name, _ENGINE, "build", formulation, method, load=load, forces=forces)


@once
def trace(formulation: str, method: str, *, load: bool) -> Callable:
    """:func:`tolmc.kernels.engine.build_trace`."""
    return _entry(names.trace(formulation, method, load=load), _ENGINE, "build_trace", formulation, method, load=load)


@once
def observe(formulation: str, *, load: bool) -> Callable:
    """:func:`tolmc.kernels.engine.build_observe`."""
    return _entry(names.observe(formulation, load=load), _ENGINE, "build_observe", formulation, load=load)


@once
def one_sided(**present: bool) -> Callable:
    """:func:`tolmc.kernels.one_sided.engine.build`."""
    return _entry(names.one_sided(**present), f"{_ONE_SIDED}.engine", "build", **present)


@once
def start_from(formulation: str) -> Callable:
    """:func:`tolmc.kernels.one_sided.hand_over.build`."""
    return _entry(names.start_from(formulation), f"{_ONE_SIDED}.hand_over", "build", formulation)


@once
def from_angles() -> Callable:
    """:func:`tolmc.kernels.one_sided.start.build_from_angles`."""
    return _entry(names.FROM_ANGLES, f"{_ONE_SIDED}.start", "build_from_angles")


@once
def gaps() -> Callable:
    """:func:`tolmc.kernels.one_sided.start.build_gaps`."""
    return _entry(names.GAPS, f"{_ONE_SIDED}.start", "build_gaps")
