"""The types of lanes as numba and LLVM see them."""

from __future__ import annotations

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.typing.templates import AttributeTemplate, infer_getattr
from numba.extending import models, register_model

LANES = 8  # one AVX-512 register; narrower machines take two or four

FLOATS = ir.VectorType(ir.DoubleType(), LANES)
INTS = ir.VectorType(ir.IntType(64), LANES)
BITS = ir.VectorType(ir.IntType(1), LANES)
ALIGNMENT = 8 * LANES  # bytes, of the rows in memory


class _LanesType(types.Type):
    def __init__(self) -> None:
        super().__init__(name="Lanes")


class _PlaneType(types.Type):
    def __init__(self) -> None:
        super().__init__(name="Plane")


class _MaskType(types.Type):
    def __init__(self) -> None:
        super().__init__(name="Mask")


Lanes, Plane, Mask = _LanesType(), _PlaneType(), _MaskType()


@register_model(_LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager, numba_type):
        super().__init__(manager, numba_type, FLOATS)


@register_model(_MaskType)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, manager, numba_type):
        super().__init__(manager, numba_type, BITS)


@register_model(_PlaneType)
class _PlaneModel(models.StructModel):
    def __init__(self, manager, numba_type):
        super().__init__(manager, numba_type, [("real", Lanes), ("imag", Lanes)])


@infer_getattr
class _PlaneAttributes(AttributeTemplate):
    key = _PlaneType

    def resolve_real(self, _):
        return Lanes

    def resolve_imag(self, _):
        return Lanes


def constant(value, vector=FLOATS):
    return ir.Constant(vector, [value] * LANES)


def splat(builder, scalar):
    empty = ir.Constant(FLOATS, ir.Undefined)
    zero = ir.IntType(32)(0)
    first = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
    return builder.shuffle_vector(builder.insert_element(empty, scalar, zero), empty, first)


def parts_of(context, builder, numba_type, value):
    """Real and imaginary vectors of a value; None for the imaginary part of a real one."""
    if numba_type == Plane:
        pair = cgutils.create_struct_proxy(Plane)(context, builder, value=value)
        return pair.real, pair.imag
    if numba_type == Lanes:
        return value, None
    return splat(builder, context.cast(builder, value, numba_type, types.float64)), None


def plane_of(context, builder, real, imag):
    pair = cgutils.create_struct_proxy(Plane)(context, builder)
    pair.real, pair.imag = real, imag
    return pair._getvalue()


def is_number(numba_type):
    return numba_type in (Lanes, Plane) or isinstance(numba_type, types.Float | types.Integer)
