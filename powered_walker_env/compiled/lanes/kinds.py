"""The types of lanes as numba and LLVM see them.

A number has a real part, and may have an imaginary part and tangents (first derivatives along
one direction): `Lanes` is real, `Plane` complex, `Dual` real with its tangent, `DualPlane`
complex with its tangent. `Zero` is the number that is known to be zero in all lanes: what is added
to it or multiplied by it takes no time. `Mask` holds truths.
"""

from __future__ import annotations

from typing import NamedTuple

from llvmlite import ir
from numba.core import types
from numba.extending import models, register_model

from powered_walker_env.compiled.lanes.width import doubles_in_a_register

LANES = doubles_in_a_register()  # eight with AVX-512

FLOATS = ir.VectorType(ir.DoubleType(), LANES)
INTS = ir.VectorType(ir.IntType(64), LANES)
BITS = ir.VectorType(ir.IntType(1), LANES)
ALIGNMENT = 8 * LANES  # bytes, of the rows in memory


class _Kind(types.Type):
    """A type of its own for each name; numba wants a class each."""

    def __init__(self) -> None:
        super().__init__(name=type(self).__name__.strip("_"))


class _Lanes(_Kind): ...


class _Mask(_Kind): ...


class _Plane(_Kind): ...


class _Dual(_Kind): ...


class _DualPlane(_Kind): ...


class _Zero(_Kind): ...


Lanes, Mask, Plane, Dual, DualPlane = _Lanes(), _Mask(), _Plane(), _Dual(), _DualPlane()
Zero = _Zero()

#: The vectors that each kind of number is made of, out of `Number`'s.
MEMBERS = {
    Lanes: ("real",),
    Plane: ("real", "imag"),
    Dual: ("real", "dreal"),
    DualPlane: ("real", "imag", "dreal", "dimag"),
    Zero: (),
}


def _primitive(kind: type[_Kind], vector: ir.Type) -> None:
    @register_model(kind)
    class _Model(models.PrimitiveModel):
        def __init__(self, manager, numba_type):
            super().__init__(manager, numba_type, vector)


def _structure(kind: type[_Kind], members: tuple[str, ...]) -> None:
    @register_model(kind)
    class _Model(models.StructModel):
        def __init__(self, manager, numba_type):
            super().__init__(manager, numba_type, [(name, Lanes) for name in members])


_primitive(_Lanes, FLOATS)
_primitive(_Mask, BITS)
_primitive(_Zero, ir.IntType(8))
_structure(_Plane, MEMBERS[Plane])
_structure(_Dual, MEMBERS[Dual])
_structure(_DualPlane, MEMBERS[DualPlane])


class Number(NamedTuple):
    """The vectors of a number; None where it has no such part."""

    real: ir.Value | None = None
    imag: ir.Value | None = None
    dreal: ir.Value | None = None
    dimag: ir.Value | None = None


def constant(value, vector=FLOATS):
    return ir.Constant(vector, [value] * LANES)


def splat(builder, scalar):
    empty = ir.Constant(FLOATS, ir.Undefined)
    zero = ir.IntType(32)(0)
    first = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
    return builder.shuffle_vector(builder.insert_element(empty, scalar, zero), empty, first)


def number_of(context, builder, numba_type, value):
    """The vectors of a value; a plain float or integer stands in all lanes."""
    if numba_type == Lanes:
        return Number(value)
    if numba_type in MEMBERS:
        parts = (builder.extract_value(value, i) for i in range(len(MEMBERS[numba_type])))
        return Number(**dict(zip(MEMBERS[numba_type], parts, strict=True)))
    if isinstance(numba_type, types.Complex):
        pair = context.make_complex(builder, numba_type, value=value)
        return Number(splat(builder, pair.real), splat(builder, pair.imag))
    return Number(splat(builder, context.cast(builder, value, numba_type, types.float64)))


def value_of(context, builder, numba_type, number):
    """The value of a type with these vectors; parts that it lacks are zero."""
    if numba_type == Lanes:
        return constant(0.0) if number.real is None else number.real
    if numba_type == Zero:
        return ir.Constant(ir.IntType(8), 0)
    made = ir.Constant(context.get_value_type(numba_type), ir.Undefined)
    for i, name in enumerate(MEMBERS[numba_type]):
        part = getattr(number, name)
        made = builder.insert_value(made, constant(0.0) if part is None else part, i)
    return made


def is_number(numba_type):
    plain = isinstance(numba_type, types.Float | types.Integer | types.Complex)
    return numba_type in MEMBERS or plain


def kind_of(numba_types):
    """The kind of number that a sum of these is."""
    if all(each == Zero for each in numba_types):
        return Zero
    dual = Dual in numba_types or DualPlane in numba_types
    flat = any(
        each in (Plane, DualPlane) or isinstance(each, types.Complex) for each in numba_types
    )
    if dual:
        return DualPlane if flat else Dual
    return Plane if flat else Lanes


def product_of(numba_types):
    """The kind of number that a product of these is."""
    return Zero if Zero in numba_types else kind_of(numba_types)
