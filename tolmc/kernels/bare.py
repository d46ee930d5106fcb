"""Rows of numbers known by where they begin alone, in place of arrays.

To compiled code an array is seven words, a reference count among them, and an index may count from its end: half of what was
written of a kernel, and read again, was about these. What a piece is handed by its own kernel it needs the address of. What one
argument of a piece writes no other may hold (:mod:`tolmc.kernels.linking`). Without compilation such rows are the array, or a
view of it.
"""

from __future__ import annotations

import operator

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.types.containers import BaseTuple, UniTuple
from numba.core.types.misc import CPointer, SliceLiteral, SliceType
from numba.core.typing.templates import AbstractTemplate, infer, infer_global, signature
from numba.extending import lower_builtin, models, register_model, type_callable
from numba.np.arrayobj import make_array

_NUMBER = ir.DoubleType().as_pointer()


def bare(array: np.ndarray) -> np.ndarray:
    """The numbers of a contiguous array of floats, which must live as long as they are used.

    Of one of one dimension there is ``rows[i]``, 0 <= i, to read and to write, ``rows[first:end]``, whose end nothing looks at,
    and ``rows[place] = number`` where the place, a slice, is known when the piece is compiled; of one of two ``table[i, j]``.
    """
    return array


class _Rows(types.Type):
    def __init__(self) -> None:
        super().__init__("rows")


class _Table(types.Type):
    def __init__(self) -> None:
        super().__init__("table")


_ROWS, _TABLE = _Rows(), _Table()
_OF_ARRAY = {1: _ROWS, 2: _TABLE}


@register_model(_Rows)
class _RowsModel(models.PrimitiveModel):
    def __init__(self, manager, of_type) -> None:
        super().__init__(manager, of_type, _NUMBER)


@register_model(_Table)
class _TableModel(models.StructModel):
    def __init__(self, manager, of_type) -> None:
        super().__init__(manager, of_type, [("first", CPointer(types.float64)), ("columns", types.intp)])


@type_callable(bare)
def _type_of_bare(_context):
    def type_of(array):
        is_plain = isinstance(array, types.Array) and array.dtype == types.float64 and array.layout == "C"
        return _OF_ARRAY.get(array.ndim) if is_plain else None

    return type_of


@lower_builtin(bare, types.Array)
def _bare(context, builder, sig, args):
    array = make_array(sig.args[0])(context, builder, args[0])
    if sig.return_type is _ROWS:
        return array.data
    table = context.make_helper(builder, _TABLE)
    table.first, table.columns = array.data, cgutils.unpack_tuple(builder, array.shape, 2)[1]
    return table._getvalue()


def _is_pair(index) -> bool:
    return isinstance(index, BaseTuple) and len(index) == 2 and all(isinstance(one, types.Integer) for one in index)


_PAIR = UniTuple(types.intp, 2)


@infer_global(operator.getitem)
class _Get(AbstractTemplate):
    def generic(self, args, kws):
        of, index = args
        if of is _ROWS and isinstance(index, types.Integer):
            return signature(types.float64, of, types.intp)
        if of is _ROWS and isinstance(index, SliceType):
            return signature(of, of, index)
        if of is _TABLE and _is_pair(index):
            return signature(types.float64, of, _PAIR)
        return None


@infer_global(operator.setitem)
class _Set(AbstractTemplate):
    def generic(self, args, kws):
        of, index, _ = args
        if of is _ROWS and isinstance(index, types.Integer):
            return signature(types.none, of, types.intp, types.float64)
        if of is _TABLE and _is_pair(index):
            return signature(types.none, of, _PAIR, types.float64)
        return None


@infer
class _Fill(AbstractTemplate):
    key = "static_setitem"

    def generic(self, args, kws):
        of, place, _ = args
        if of is _ROWS and isinstance(place, slice) and place.stop is not None:
            return signature(types.none, of, types.literal(place), types.float64)
        return None


def _at(builder, first, index):
    return builder.gep(first, [index], inbounds=True)


def _in_table(context, builder, table, pair):
    table, (row, column) = context.make_helper(builder, _TABLE, table), cgutils.unpack_tuple(builder, pair, 2)
    return _at(builder, table.first, builder.add(builder.mul(row, table.columns), column))


@lower_builtin(operator.getitem, _ROWS, types.intp)
def _get(_context, builder, _sig, args):
    return builder.load(_at(builder, *args))


@lower_builtin(operator.getitem, _TABLE, _PAIR)
def _get_of_table(context, builder, _sig, args):
    return builder.load(_in_table(context, builder, *args))


@lower_builtin(operator.setitem, _ROWS, types.intp, types.float64)
def _set(context, builder, _sig, args):
    builder.store(args[2], _at(builder, *args[:2]))
    return context.get_dummy_value()


@lower_builtin(operator.setitem, _TABLE, _PAIR, types.float64)
def _set_of_table(context, builder, _sig, args):
    builder.store(args[2], _in_table(context, builder, *args[:2]))
    return context.get_dummy_value()


@lower_builtin(operator.getitem, _ROWS, SliceType)
def _from(context, builder, sig, args):
    return _at(builder, args[0], context.make_helper(builder, sig.args[1], args[1]).start)


@lower_builtin("static_getitem", _ROWS, SliceLiteral)
def _from_known(context, builder, _sig, args):
    return _at(builder, args[0], context.get_constant(types.intp, args[1].start or 0))


@lower_builtin("static_setitem", _ROWS, SliceLiteral, types.float64)
def _fill(context, builder, _sig, args):
    rows, place, number = args
    first = place.start or 0
    with cgutils.for_range(builder, context.get_constant(types.intp, place.stop - first)) as loop:
        builder.store(number, _at(builder, _at(builder, rows, context.get_constant(types.intp, first)), loop.index))
    return context.get_dummy_value()
