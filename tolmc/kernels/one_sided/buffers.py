"""Arrays of lanes in one buffer, borrowed: compiled code counts no references to them.

A routine that is handed eight arrays would else count up and down for each of them, atomically, in every call: more than the
arithmetic of an event takes.
"""

from __future__ import annotations

import numba as nb
import numpy as np
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic, overload

from tolmc.kernels.one_sided.layout import WIDTH


@intrinsic
def _pointer(typing_context, address):
    """An address as a pointer."""

    def generate(context, builder, signature, arguments):
        return builder.inttoptr(arguments[0], cgutils.voidptr_t)

    return types.voidptr(address), generate


def borrowed(buffer, first, rows):
    """``rows`` rows of lanes of ``buffer`` from row ``first``; the caller keeps the buffer alive."""
    return buffer[first * WIDTH : (first + rows) * WIDTH]


@overload(borrowed, inline="never")
def _borrowed(buffer, first, rows):
    def compiled(buffer, first, rows):
        return nb.carray(_pointer(buffer.ctypes.data + 8 * first * WIDTH), (rows * WIDTH,), np.float64)

    return compiled
