"""Pieces of kernels, which compiled code alone calls, as functions that a test calls.

They run without compilation, which takes a second for a long one: compiled they are looked at in the kernels, which are made
of them.
"""

from types import FunctionType

from numba.core.registry import CPUDispatcher


def called(piece):
    """The piece, and the pieces that it calls, as Python's functions."""
    if not isinstance(piece, CPUDispatcher):
        return piece
    function = piece.py_func
    pieces = {
        name: called(function.__globals__[name]) for name in function.__code__.co_names if name in function.__globals__
    }
    return FunctionType(function.__code__, function.__globals__ | pieces, function.__name__, None, function.__closure__)
