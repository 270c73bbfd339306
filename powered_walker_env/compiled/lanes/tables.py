"""Rows of lanes in memory, and tables of plain numbers, without counting who holds them."""

from __future__ import annotations

import operator

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.errors import TypingError
from numba.core.imputils import lower_builtin
from numba.extending import intrinsic, models, register_model, type_callable

from powered_walker_env.compiled.lanes.kinds import (
    ALIGNMENT,
    FLOATS,
    LANES,
    Lanes,
    Mask,
    number_of,
)

_POINTER = types.CPointer(types.float64)


class _TableType(types.Type):
    def __init__(self) -> None:
        super().__init__(name="Table")


class Table:
    """In annotations: rows of numbers in memory, `rows[i, j]` in kernels."""


TABLE = _TableType()


@register_model(_TableType)
class _TableModel(models.StructModel):
    def __init__(self, manager, numba_type):
        super().__init__(manager, numba_type, [("data", _POINTER), ("columns", types.intp)])


def table_at(context, builder, data, columns):
    """The table that begins at a pointer."""
    made = ir.Constant(context.get_value_type(TABLE), ir.Undefined)
    return builder.insert_value(builder.insert_value(made, data, 0), columns, 1)


def _check_layout(array):
    """A table has no strides: reject, as kernels are compiled, what would need them."""
    if array.layout != "C" or array.dtype != types.float64:
        raise TypingError(f"a table needs a C-contiguous array of float64, got {array}")


@intrinsic
def table(typing_context, array):
    """An array of floats, (n, m) or (n,) for m = 1, as a `Table`: a pointer, no owner.

    Arrays count who holds them, at each call of a function; tables do not, and whoever
    makes one must keep the array.
    """

    _check_layout(array)

    def code(context, builder, signature, args):
        (kind,) = signature.args
        made = context.make_array(kind)(context, builder, args[0])
        columns = ir.IntType(64)(1)
        if kind.ndim == 2:
            columns = builder.extract_value(made.shape, 1)
        return table_at(context, builder, made.data, columns)

    return TABLE(array), code


@intrinsic
def eights(typing_context, array):
    """A flat array as a `Table` of rows of lanes, from its first multiple of 64 bytes on."""

    _check_layout(array)

    def code(context, builder, signature, args):
        data = context.make_array(signature.args[0])(context, builder, args[0]).data
        address = builder.ptrtoint(data, ir.IntType(64))
        room = ir.IntType(64)(ALIGNMENT - 1)
        start = builder.and_(builder.add(address, room), builder.not_(room))
        return table_at(context, builder, builder.inttoptr(start, data.type), ir.IntType(64)(LANES))

    return TABLE(array), code


def _entry(context, builder, kind, value, row, column):
    place = builder.add(builder.mul(row, builder.extract_value(value, 1)), column)
    return builder.gep(builder.extract_value(value, 0), [place])


@intrinsic
def rows_from(typing_context, rows, first):
    """The same table from a later row on."""

    def code(context, builder, signature, args):
        place = _entry(context, builder, TABLE, args[0], args[1], ir.IntType(64)(0))
        return table_at(context, builder, place, builder.extract_value(args[0], 1))

    return TABLE(TABLE, types.intp), code


@type_callable(operator.getitem)
def _type_getitem(context):
    def typer(rows, place):
        return types.float64 if rows == TABLE and isinstance(place, types.BaseTuple) else None

    return typer


@type_callable(operator.setitem)
def _type_setitem(context):
    def typer(rows, place, value):
        return types.none if rows == TABLE and isinstance(place, types.BaseTuple) else None

    return typer


def _place(context, builder, kind, value):
    pair = cgutils.unpack_tuple(builder, value)
    return [context.cast(builder, v, t, types.intp) for v, t in zip(pair, kind.types, strict=True)]


@lower_builtin(operator.getitem, TABLE, types.BaseTuple)
def _getitem(context, builder, signature, args):
    place = _place(context, builder, signature.args[1], args[1])
    return builder.load(_entry(context, builder, TABLE, args[0], *place))


@lower_builtin(operator.setitem, TABLE, types.BaseTuple, types.Any)
def _setitem(context, builder, signature, args):
    place = _place(context, builder, signature.args[1], args[1])
    value = context.cast(builder, args[2], signature.args[2], types.float64)
    builder.store(value, _entry(context, builder, TABLE, args[0], *place))
    return context.get_dummy_value()


def row_pointer(context, builder, rows, row):
    """Where a row of lanes begins."""
    start = builder.mul(row, ir.IntType(64)(LANES))
    place = builder.gep(builder.extract_value(rows, 0), [start])
    return builder.bitcast(place, FLOATS.as_pointer())


@intrinsic
def load(typing_context, rows, row):
    """A row of a table of lanes."""

    def code(context, builder, signature, args):
        return builder.load(row_pointer(context, builder, *args), align=ALIGNMENT)

    return Lanes(TABLE, types.intp), code


@intrinsic
def store(typing_context, rows, row, value):
    """Write a row, as `load` reads it."""

    def code(context, builder, signature, args):
        builder.store(args[2], row_pointer(context, builder, *args[:2]), align=ALIGNMENT)
        return context.get_dummy_value()

    return types.void(TABLE, types.intp, Lanes), code


@intrinsic
def blend(typing_context, rows, row, mask, value):
    """Write a row where the mask holds."""
    if value != Lanes:
        value = types.float64

    def code(context, builder, signature, args):
        pointer = row_pointer(context, builder, *args[:2])
        new = number_of(context, builder, signature.args[3], args[3]).real
        old = builder.load(pointer, align=ALIGNMENT)
        builder.store(builder.select(args[2], new, old), pointer, align=ALIGNMENT)
        return context.get_dummy_value()

    return types.void(TABLE, types.intp, Mask, value), code
