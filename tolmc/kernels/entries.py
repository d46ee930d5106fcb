"""The entries of all kernels: found on disk, or composed and compiled, for which alone Numba is loaded."""

from __future__ import annotations

from collections.abc import Callable

from tolmc.kernels import names
from tolmc.kernels.code import kept_entry
from tolmc.kernels.once import once


@once
def integrate(formulation: str, method: str, *, load: bool, forces: bool) -> Callable:
    """:func:`tolmc.kernels.engine.build`."""
    if kept := kept_entry(names.integrate(formulation, method, load=load, forces=forces)):
        return kept
    from tolmc.kernels import engine

    return engine.build(formulation, method, load=load, forces=forces)


@once
def trace(formulation: str, method: str, *, load: bool) -> Callable:
    """:func:`tolmc.kernels.engine.build_trace`."""
    if kept := kept_entry(names.trace(formulation, method, load=load)):
        return kept
    from tolmc.kernels import engine

    return engine.build_trace(formulation, method, load=load)


@once
def observe(formulation: str, *, load: bool) -> Callable:
    """:func:`tolmc.kernels.engine.build_observe`."""
    if kept := kept_entry(names.observe(formulation, load=load)):
        return kept
    from tolmc.kernels import engine

    return engine.build_observe(formulation, load=load)


@once
def one_sided(**present: bool) -> Callable:
    """:func:`tolmc.kernels.one_sided.engine.build`."""
    if kept := kept_entry(names.one_sided(**present)):
        return kept
    from tolmc.kernels.one_sided import engine

    return engine.build(**present)


@once
def start_from(formulation: str) -> Callable:
    """:func:`tolmc.kernels.one_sided.hand_over.build`."""
    if kept := kept_entry(names.start_from(formulation)):
        return kept
    from tolmc.kernels.one_sided import hand_over

    return hand_over.build(formulation)


@once
def from_angles() -> Callable:
    """:func:`tolmc.kernels.one_sided.start.build_from_angles`."""
    if kept := kept_entry(names.FROM_ANGLES):
        return kept
    from tolmc.kernels.one_sided import start

    return start.build_from_angles()


@once
def gaps() -> Callable:
    """:func:`tolmc.kernels.one_sided.start.build_gaps`."""
    if kept := kept_entry(names.GAPS):
        return kept
    from tolmc.kernels.one_sided import start

    return start.build_gaps()
