"""Rows of numbers known by where they begin alone, in place of arrays.

To compiled code an array is seven words, a reference count among them, and an index may count from its end: half of what was
written of a kernel, and read again, was about these. What an entry is handed, and hands on to its pieces, are addresses. What
one argument of a piece writes no other may hold (:mod:`tolmc.kernels.linking`). Without compilation such rows are the array, or
a view of it.
"""

from __future__ import annotations

import operator
from typing import TypeAlias

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.types.containers import BaseTuple, UniTuple
from numba.core.types.misc import CPointer, SliceLiteral, SliceType
from numba.core.typing.templates import (
    AbstractTemplate,
    AttributeTemplate,
    infer,
    infer_getattr,
    infer_global,
    signature,
)
from numba.extending import lower_builtin, lower_getattr, models, register_model

#: Numbers, and whole numbers, of a contiguous array. There is ``rows[i]``, 0 <= i, to read and to write, ``rows[first:end]``,
#: whose end nothing looks at, and ``rows[place] = number`` where the place, a slice, is known when the piece is compiled.
Rows: TypeAlias = np.ndarray
Counts: TypeAlias = np.ndarray
#: Those of a contiguous array of two dimensions: ``table[i, j]``, ``table.shape``.
Table: TypeAlias = np.ndarray


class _Rows(types.Type):
    def __init__(self, number: types.Type) -> None:
        super().__init__(f"rows of {number}")
        self.number = number


class _Table(types.Type):
    def __init__(self) -> None:
        super().__init__("table")


ROWS, COUNTS, TABLE = _Rows(types.float64), _Rows(types.int64), _Table()


@register_model(_Rows)
class _RowsModel(models.PrimitiveModel):
    def __init__(self, manager, of_type) -> None:
        number = ir.DoubleType() if of_type is ROWS else ir.IntType(64)
        super().__init__(manager, of_type, number.as_pointer())


@register_model(_Table)
class _TableModel(models.StructModel):
    def __init__(self, manager, of_type) -> None:
        words = [("first", CPointer(types.float64)), ("rows", types.intp), ("columns", types.intp)]
        super().__init__(manager, of_type, words)


_PAIR = UniTuple(types.intp, 2)


def _is_pair(index) -> bool:
    return isinstance(index, BaseTuple) and len(index) == 2 and all(isinstance(one, types.Integer) for one in index)


@infer_getattr
class _Shape(AttributeTemplate):
    key = _Table

    def resolve_shape(self, _table):
        return _PAIR


@infer_global(operator.getitem)
class _Get(AbstractTemplate):
    def generic(self, args, kws):
        of, index = args
        if isinstance(of, _Rows) and isinstance(index, types.Integer):
            return signature(of.number, of, types.intp)
        if isinstance(of, _Rows) and isinstance(index, SliceType):
            return signature(of, of, index)
        if of is TABLE and _is_pair(index):
            return signature(types.float64, of, _PAIR)
        return None


@infer_global(operator.setitem)
class _Set(AbstractTemplate):
    def generic(self, args, kws):
        of, index, _ = args
        if isinstance(of, _Rows) and isinstance(index, types.Integer):
            return signature(types.none, of, types.intp, of.number)
        if of is TABLE and _is_pair(index):
            return signature(types.none, of, _PAIR, types.float64)
        return None


@infer
class _Fill(AbstractTemplate):
    key = "static_setitem"

    def generic(self, args, kws):
        of, place, _ = args
        if isinstance(of, _Rows) and isinstance(place, slice) and place.stop is not None:
            return signature(types.none, of, types.literal(place), of.number)
        return None


@lower_getattr(_Table, "shape")
def _shape(context, builder, of_type, table):
    table = context.make_helper(builder, of_type, table)
    return context.make_tuple(builder, _PAIR, (table.rows, table.columns))


def _at(builder, first, index):
    return builder.gep(first, [index], inbounds=True)


def _in_table(context, builder, table, pair):
    table, (row, column) = context.make_helper(builder, TABLE, table), cgutils.unpack_tuple(builder, pair, 2)
    return _at(builder, table.first, builder.add(builder.mul(row, table.columns), column))


@lower_builtin(operator.getitem, _Rows, types.intp)
def _get(_context, builder, _sig, args):
    return builder.load(_at(builder, *args))


@lower_builtin(operator.getitem, TABLE, _PAIR)
def _get_of_table(context, builder, _sig, args):
    return builder.load(_in_table(context, builder, *args))


@lower_builtin(operator.setitem, _Rows, types.intp, types.Any)
def _set(context, builder, _sig, args):
    builder.store(args[2], _at(builder, *args[:2]))
    return context.get_dummy_value()


@lower_builtin(operator.setitem, TABLE, _PAIR, types.float64)
def _set_of_table(context, builder, _sig, args):
    builder.store(args[2], _in_table(context, builder, *args[:2]))
    return context.get_dummy_value()


@lower_builtin(operator.getitem, _Rows, SliceType)
def _from(context, builder, sig, args):
    return _at(builder, args[0], context.make_helper(builder, sig.args[1], args[1]).start)


@lower_builtin("static_getitem", _Rows, SliceLiteral)
def _from_known(context, builder, _sig, args):
    return _at(builder, args[0], context.get_constant(types.intp, args[1].start or 0))


@lower_builtin("static_setitem", _Rows, SliceLiteral, types.Any)
def _fill(context, builder, _sig, args):
    rows, place, number = args
    first = place.start or 0
    with cgutils.for_range(builder, context.get_constant(types.intp, place.stop - first)) as loop:
        builder.store(number, _at(builder, _at(builder, rows, context.get_constant(types.intp, first)), loop.index))
    return context.get_dummy_value()
