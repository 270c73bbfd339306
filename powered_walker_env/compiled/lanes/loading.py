"""What loads a record from tables of lanes, made from its layout (`compiled/records.py`)."""

from __future__ import annotations

from llvmlite import ir
from numba.core import types
from numba.core.imputils import lower_getattr_generic
from numba.core.typing.templates import AttributeTemplate, infer_getattr
from numba.extending import intrinsic, models, register_model

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
from powered_walker_env.compiled.lanes.tables import TABLE, row_pointer, table_at

_I64 = ir.IntType(64)


def _typed(layout, kinds):
    return types.NamedTuple([kinds[p.kind] for p in layout.places.values()], layout.record)


def _vector(context, builder, table, row):
    pointer = row_pointer(context, builder, table, _I64(row))
    return builder.load(pointer, align=ALIGNMENT)


def _truth(builder, vector):
    return builder.fcmp_ordered(">", vector, constant(0.0))


class _View(types.Type):
    """A record of tables: where it begins, and nothing else, however many tables it has.

    Handed from function to function as so many tables, a record of forty would be eighty
    arguments.
    """

    def __init__(self, layout):
        self.layout = layout
        super().__init__(name=f"View({layout.record.__module__}.{layout.record.__qualname__})")


@register_model(_View)
class _ViewModel(models.StructModel):
    def __init__(self, manager, numba_type):
        super().__init__(manager, numba_type, [("whole", TABLE)])


@infer_getattr
class _ViewAttributes(AttributeTemplate):
    key = _View

    def generic_resolve(self, view, name):
        return TABLE if name in view.layout.places else None


@lower_getattr_generic(_View)
def _field(context, builder, view, value, name):
    whole = builder.extract_value(value, 0)
    data, columns = (builder.extract_value(whole, i) for i in range(2))
    start = builder.mul(columns, _I64(view.layout.places[name].first))
    return table_at(context, builder, builder.gep(data, [start]), columns)


def view_of(layout):
    result = _View(layout)

    @intrinsic
    def view(typing_context, table):
        def code(context, builder, signature, args):
            empty = ir.Constant(context.get_value_type(result), ir.Undefined)
            return builder.insert_value(empty, args[0], 0)

        return result(TABLE), code

    return view


def lanes_of(layout):
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


def duals_of(layout):
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


def lane_of(layout):
    @intrinsic
    def lane(typing_context, table, i):
        kinds = {float: types.float64, complex: types.complex128, bool: types.boolean}
        result = _typed(layout, kinds)

        def code(context, builder, signature, args):
            data, columns = (builder.extract_value(args[0], i) for i in range(2))

            def number(row):
                start = builder.add(builder.mul(columns, _I64(row)), args[1])
                return builder.load(builder.gep(data, [start]))

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
