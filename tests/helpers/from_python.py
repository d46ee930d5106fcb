"""Pieces of kernels, which compiled code alone calls, as functions that a test calls."""

import numba as nb


def called(piece):
    """The piece as a function that Python can call."""
    return nb.njit(lambda *arguments: piece(*arguments), error_model="numpy")
