"""Records: one declaration says which numbers there are, and where they lie.

A record is a `NamedTuple` whose fields are floats, complex numbers or truths. From it follow the
columns of a row that packs it, the rows of a table of lanes that holds eight of it, and the
functions that load them. A record of `Table`s (`Annotated[Table, n]` for n rows) is a map of a
block of memory. To add a number is to add a field.
"""

from __future__ import annotations

import typing
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic

from powered_walker_env.compiled.lanes.kinds import (
    ALIGNMENT,
    Dual,
    DualPlane,
    Lanes,
    Mask,
    Number,
    Plane,
    constant,
    number_of,
    value_of,
)
from powered_walker_env.compiled.lanes.tables import TABLE, Table, row_pointer

R = TypeVar("R")
_I64 = ir.IntType(64)


class Place(NamedTuple):
    """Where a field lies."""

    name: str
    kind: type  # float, complex, bool or Table
    first: int  # column of a row, or row of a table of lanes
    size: int


class Layout(Generic[R]):
    """The places of a record's fields, one after another, and what loads them.

    Attributes:
        size: numbers in all.
        places: of the fields, by name.
        view: in kernels, `view(table)`: the record of tables in the first rows of a table.
        lanes: in kernels, `lanes(table)`: the record of eight, as lanes.
        lane: in kernels, `lane(table, i)`: that of one lane, as plain numbers.
        duals: in kernels, `duals(lanes, table)`: a record of lanes with its tangents from a table.
    """

    def __init__(self, record: type[R]) -> None:
        self.record = record
        self.places: dict[str, Place] = {}
        self.size = 0
        for name, hint in typing.get_type_hints(record, include_extras=True).items():
            kind, *more = typing.get_args(hint) or (hint,)
            size = more[0] if more else {complex: 2}.get(kind, 1)
            self.places[name] = Place(name, kind, self.size, size)
            self.size += size
        self.view, self.lanes = _view(self), _lanes(self)
        self.lane, self.duals = _lane(self), _duals(self)

    def __getitem__(self, name: str) -> int:
        """The first column, or row, of a field."""
        return self.places[name].first

    def slice(self, name: str) -> slice:
        """All columns of a field."""
        place = self.places[name]
        return slice(place.first, place.first + place.size)

    def columns(self, record: R) -> list[Any]:
        """The numbers of a record in order, complex ones as two; each may be an array."""
        numbers: list[Any] = []
        for place, value in zip(self.places.values(), record, strict=True):  # type: ignore[call-overload]
            numbers += [np.real(value), np.imag(value)] if place.kind is complex else [value]
        return numbers

    def of(self, row: Any) -> R:
        """The record that a row of plain numbers packs."""
        values = []
        for place in self.places.values():
            number = float(row[place.first])
            if place.kind is complex:
                values.append(complex(number, float(row[place.first + 1])))
            else:
                values.append(place.kind(number) if place.kind is bool else number)
        return self.record(*values)


def _typed(layout: Layout[Any], kinds: dict[type, Any]) -> types.NamedTuple:
    return types.NamedTuple([kinds[p.kind] for p in layout.places.values()], layout.record)


def _vector(context, builder, table, row):
    pointer = row_pointer(context, builder, table, _I64(row))
    return builder.load(pointer, align=ALIGNMENT)


def _truth(builder, vector):
    return builder.fcmp_ordered(">", vector, constant(0.0))


def _view(layout):
    @intrinsic
    def view(typing_context, table):
        result = types.NamedTuple([TABLE] * len(layout.places), layout.record)

        def code(context, builder, signature, args):
            whole = cgutils.create_struct_proxy(TABLE)(context, builder, value=args[0])
            tables = []
            for place in layout.places.values():
                start = builder.mul(whole.columns, _I64(place.first))
                part = cgutils.create_struct_proxy(TABLE)(context, builder)
                part.data = builder.gep(whole.data, [start])
                part.columns = whole.columns
                tables.append(part._getvalue())
            return context.make_tuple(builder, result, tables)

        return result(TABLE), code

    return view


def _lanes(layout):
    @intrinsic
    def lanes(typing_context, table):
        kinds = {float: Lanes, complex: Plane, bool: Mask}
        result = _typed(layout, kinds)

        def code(context, builder, signature, args):
            values = []
            for place in layout.places.values():
                parts = [
                    _vector(context, builder, args[0], place.first + i) for i in range(place.size)
                ]
                if place.kind is bool:
                    values.append(_truth(builder, parts[0]))
                else:
                    values.append(value_of(context, builder, kinds[place.kind], Number(*parts)))
            return context.make_tuple(builder, result, values)

        return result(TABLE), code

    return lanes


def _duals(layout):
    @intrinsic
    def duals(typing_context, record, tangents):
        result = _typed(layout, {float: Dual, complex: DualPlane, bool: Mask})

        def code(context, builder, signature, args):
            values = []
            for i, place in enumerate(layout.places.values()):
                held = builder.extract_value(args[0], i)
                if place.kind is bool:
                    values.append(held)
                    continue
                number = number_of(context, builder, signature.args[0].types[i], held)
                rows = range(place.first, place.first + place.size)
                moved = [_vector(context, builder, args[1], row) for row in rows]
                number = number._replace(**dict(zip(("dreal", "dimag"), moved, strict=False)))
                values.append(value_of(context, builder, result.types[i], number))
            return context.make_tuple(builder, result, values)

        return result(record, TABLE), code

    return duals


def _lane(layout):
    @intrinsic
    def lane(typing_context, table, i):
        kinds = {float: types.float64, complex: types.complex128, bool: types.boolean}
        result = _typed(layout, kinds)

        def code(context, builder, signature, args):
            whole = cgutils.create_struct_proxy(TABLE)(context, builder, value=args[0])

            def number(row):
                start = builder.add(builder.mul(whole.columns, _I64(row)), args[1])
                return builder.load(builder.gep(whole.data, [start]))

            values = []
            for place in layout.places.values():
                value = number(place.first)
                if place.kind is complex:
                    pair = context.make_complex(builder, types.complex128)
                    pair.real, pair.imag = value, number(place.first + 1)
                    value = pair._getvalue()
                elif place.kind is bool:
                    value = builder.fcmp_ordered(">", value, ir.Constant(ir.DoubleType(), 0.0))
                values.append(value)
            return context.make_tuple(builder, result, values)

        return result(TABLE, types.intp), code

    return lane


__all__ = ["Layout", "Place", "Table"]
