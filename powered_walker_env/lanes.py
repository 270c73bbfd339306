"""Eight walkers in one number: SIMD lanes as numba types, so that formulas need no loop.

A compiled function that is given `Lanes` (eight floats), `Plane` (eight complex numbers)
or `Mask` (eight truths) in place of a float, a complex or a bool does the same thing to
all of them with single machine instructions. The mechanics in `physics/` is written once,
with `+ - * /`, comparisons, `complex`, `math.cos`, `math.sin`, `math.sqrt`, `abs` and
`where`; plain Python runs it on floats, the kernel on lanes.

Each lane's result depends on that lane alone, whatever its neighbours hold: a walker
walks the same walk, bit for bit, in any lane of any batch. Products and sums may be
fused (`contract`), in all lanes alike.
"""

from __future__ import annotations

import math
import operator

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.errors import TypingError
from numba.core.imputils import lower_builtin, lower_getattr
from numba.core.typing.templates import AttributeTemplate, infer_getattr
from numba.extending import intrinsic, models, overload, register_model, type_callable

LANES = 8  # one AVX-512 register; narrower machines take two or four

_FLOATS = ir.VectorType(ir.DoubleType(), LANES)
_INTS = ir.VectorType(ir.IntType(64), LANES)
_BITS = ir.VectorType(ir.IntType(1), LANES)
_FLAGS = ("contract",)
_ALIGNMENT = 8 * LANES  # bytes, of the rows in memory
_POINTER = types.CPointer(types.float64)


class _LanesType(types.Type):
    def __init__(self) -> None:
        super().__init__(name="Lanes")


class _PlaneType(types.Type):
    def __init__(self) -> None:
        super().__init__(name="Plane")


class _MaskType(types.Type):
    def __init__(self) -> None:
        super().__init__(name="Mask")


class _TableType(types.Type):
    def __init__(self) -> None:
        super().__init__(name="Table")


class Table:
    """In annotations: rows of numbers in memory, `rows[i, j]` in kernels."""


Lanes, Plane, Mask, TABLE = _LanesType(), _PlaneType(), _MaskType(), _TableType()


@register_model(_LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager, numba_type):
        super().__init__(manager, numba_type, _FLOATS)


@register_model(_MaskType)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, manager, numba_type):
        super().__init__(manager, numba_type, _BITS)


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


def _constant(value, vector=_FLOATS):
    return ir.Constant(vector, [value] * LANES)


def _splat(builder, scalar):
    empty = ir.Constant(_FLOATS, ir.Undefined)
    zero = ir.IntType(32)(0)
    first = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
    return builder.shuffle_vector(builder.insert_element(empty, scalar, zero), empty, first)


def _parts(context, builder, numba_type, value):
    """Real and imaginary vectors of a value; None for the imaginary part of a real one."""
    if numba_type == Plane:
        pair = cgutils.create_struct_proxy(Plane)(context, builder, value=value)
        return pair.real, pair.imag
    if numba_type == Lanes:
        return value, None
    return _splat(builder, context.cast(builder, value, numba_type, types.float64)), None


def _plane(context, builder, real, imag):
    pair = cgutils.create_struct_proxy(Plane)(context, builder)
    pair.real, pair.imag = real, imag
    return pair._getvalue()


def _is_number(numba_type):
    return numba_type in (Lanes, Plane) or isinstance(numba_type, types.Float | types.Integer)


_NUMBERS = (types.Float, types.Integer)
_REAL_PAIRS = [(Lanes, Lanes), *((Lanes, n) for n in _NUMBERS), *((n, Lanes) for n in _NUMBERS)]
_PLANE_PAIRS = [(Plane, Plane)]
for _other in (Lanes, *_NUMBERS):
    _PLANE_PAIRS += [(Plane, _other), (_other, Plane)]


def _declare(operation, result_of):
    @type_callable(operation)
    def _type(context):
        def typer(a, b):
            pair = (a, b)
            if all(_is_number(x) for x in pair) and (Lanes in pair or Plane in pair):
                return result_of(pair)
            return None

        return typer


def _define(operation, pairs, code):
    for pair in pairs:
        lower_builtin(operation, *pair)(code)


def _number_of(pair):
    return Plane if Plane in pair else Lanes


def _sum_code(instruction):
    def code(context, builder, signature, args):
        a, b = signature.args
        (ar, ai), (br, bi) = (
            _parts(context, builder, a, args[0]), _parts(context, builder, b, args[1])
        )  # fmt: skip
        emit = getattr(builder, instruction)
        real = emit(ar, br, flags=_FLAGS)
        if signature.return_type == Lanes:
            return real
        if bi is None:
            return _plane(context, builder, real, ai)
        imag = emit(_constant(0.0) if ai is None else ai, bi, flags=_FLAGS)
        return _plane(context, builder, real, imag)

    return code


def _product_code(context, builder, signature, args):
    a, b = signature.args
    (ar, ai), (br, bi) = (
        _parts(context, builder, a, args[0]), _parts(context, builder, b, args[1])
    )  # fmt: skip

    def times(x, y):
        return builder.fmul(x, y, flags=_FLAGS)

    if ai is None and bi is None:
        return times(ar, br)
    if ai is None:
        return _plane(context, builder, times(ar, br), times(ar, bi))
    if bi is None:
        return _plane(context, builder, times(ar, br), times(ai, br))
    real = builder.fsub(times(ar, br), times(ai, bi), flags=_FLAGS)
    imag = builder.fadd(times(ar, bi), times(ai, br), flags=_FLAGS)
    return _plane(context, builder, real, imag)


def _quotient_code(context, builder, signature, args):
    a, b = signature.args
    ar, _ = _parts(context, builder, a, args[0])
    br, _ = _parts(context, builder, b, args[1])
    return builder.fdiv(ar, br, flags=_FLAGS)


def _real_only(result):
    return lambda pair: None if Plane in pair else result


def _comparison_code(sign):
    def code(context, builder, signature, args):
        a, b = signature.args
        ar, _ = _parts(context, builder, a, args[0])
        br, _ = _parts(context, builder, b, args[1])
        return builder.fcmp_ordered(sign, ar, br)

    return code


for _operation, _instruction in ((operator.add, "fadd"), (operator.sub, "fsub")):
    _declare(_operation, _number_of)
    _define(_operation, _REAL_PAIRS + _PLANE_PAIRS, _sum_code(_instruction))
_declare(operator.mul, _number_of)
_define(operator.mul, _REAL_PAIRS + _PLANE_PAIRS, _product_code)
_declare(operator.truediv, _real_only(Lanes))
_define(operator.truediv, _REAL_PAIRS, _quotient_code)
for _operation, _sign in (
    (operator.lt, "<"),
    (operator.le, "<="),
    (operator.gt, ">"),
    (operator.ge, ">="),
    (operator.eq, "=="),
):
    _declare(_operation, _real_only(Mask))
    _define(_operation, _REAL_PAIRS, _comparison_code(_sign))


@lower_getattr(_PlaneType, "real")
def _real(context, builder, numba_type, value):
    return _parts(context, builder, numba_type, value)[0]


@lower_getattr(_PlaneType, "imag")
def _imag(context, builder, numba_type, value):
    return _parts(context, builder, numba_type, value)[1]


def _function_of(function, argument, result, code):
    """Give a function of one argument a version for lanes."""

    @type_callable(function)
    def _type(context):
        def typer(x):
            return result if x == argument else None

        return typer

    lower_builtin(function, argument)(code)


def _llvm(name):
    def code(context, builder, signature, args):
        kind = ir.FunctionType(_FLOATS, [_FLOATS])
        function = cgutils.get_or_insert_function(builder.module, kind, f"{name}.v{LANES}f64")
        return builder.call(function, args)

    return code


_function_of(operator.neg, Lanes, Lanes, lambda _c, builder, _s, args: builder.fneg(args[0]))
_function_of(operator.invert, Mask, Mask, lambda _c, builder, _s, args: builder.not_(args[0]))
_function_of(abs, Lanes, Lanes, _llvm("llvm.fabs"))
_function_of(math.sqrt, Lanes, Lanes, _llvm("llvm.sqrt"))


def _mask_operation(operation, instruction):
    @type_callable(operation)
    def _type(context):
        def typer(a, b):
            return Mask if a == Mask and b == Mask else None

        return typer

    lower_builtin(operation, Mask, Mask)(
        lambda _c, builder, _s, args: getattr(builder, instruction)(*args)
    )


_mask_operation(operator.and_, "and_")
_mask_operation(operator.or_, "or_")


@type_callable(complex)
def _type_complex(context):
    def typer(real, imag):
        pair = (real, imag)
        return Plane if Lanes in pair and all(_is_number(x) for x in pair) else None

    return typer


def _complex_code(context, builder, signature, args):
    parts = [_parts(context, builder, t, v)[0] for t, v in zip(signature.args, args, strict=True)]
    return _plane(context, builder, *parts)


_define(complex, _REAL_PAIRS, _complex_code)


def where(condition, yes, no):
    """`yes` where the condition holds, else `no`."""
    return yes if condition else no


@intrinsic
def _select(typing_context, mask, yes, no):
    def code(context, builder, signature, args):
        _, a, b = signature.args
        first, _ = _parts(context, builder, a, args[1])
        second, _ = _parts(context, builder, b, args[2])
        return builder.select(args[0], first, second)

    return Lanes(mask, yes, no), code


@overload(where, inline="never")
def _where(condition, yes, no):
    if condition == Mask:
        return lambda condition, yes, no: _select(condition, yes, no)
    return lambda condition, yes, no: yes if condition else no


@intrinsic
def at_lane_0(typing_context, value):
    """The float in the first lane."""

    def code(context, builder, signature, args):
        return builder.extract_element(args[0], ir.IntType(32)(0))

    return types.float64(value), code


@intrinsic
def bits(typing_context, mask):
    """The mask as an integer, lane 0 in the lowest bit."""

    def code(context, builder, signature, args):
        return builder.zext(builder.bitcast(args[0], ir.IntType(LANES)), ir.IntType(64))

    return types.int64(mask), code


@intrinsic
def mask_of(typing_context, bits):
    """The inverse of `bits`."""

    def code(context, builder, signature, args):
        return builder.bitcast(builder.trunc(args[0], ir.IntType(LANES)), _BITS)

    return Mask(types.int64), code


@register_model(_TableType)
class _TableModel(models.StructModel):
    def __init__(self, manager, numba_type):
        super().__init__(manager, numba_type, [("data", _POINTER), ("columns", types.intp)])


def _table(context, builder, data, columns):
    made = cgutils.create_struct_proxy(TABLE)(context, builder)
    made.data, made.columns = data, columns
    return made._getvalue()


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
        return _table(context, builder, made.data, columns)

    return TABLE(array), code


@intrinsic
def eights(typing_context, array):
    """A flat array as a `Table` of rows of lanes, from its first multiple of 64 bytes on."""

    _check_layout(array)

    def code(context, builder, signature, args):
        data = context.make_array(signature.args[0])(context, builder, args[0]).data
        address = builder.ptrtoint(data, ir.IntType(64))
        room = ir.IntType(64)(_ALIGNMENT - 1)
        start = builder.and_(builder.add(address, room), builder.not_(room))
        return _table(context, builder, builder.inttoptr(start, data.type), ir.IntType(64)(LANES))

    return TABLE(array), code


def _entry(context, builder, kind, value, row, column):
    made = cgutils.create_struct_proxy(TABLE)(context, builder, value=value)
    place = builder.add(builder.mul(row, made.columns), column)
    return builder.gep(made.data, [place])


@intrinsic
def unseen(typing_context, row):
    """The same number, of which the compiler knows nothing.

    What is loaded by it is not recognised as loaded before: no product is shared with
    other code, which the compiler would then fuse otherwise, to other bits.
    """

    def code(context, builder, signature, args):
        kind = ir.FunctionType(ir.IntType(64), [ir.IntType(64)])
        return builder.asm(kind, "", "=r,0", [args[0]], True)

    return types.int64(types.int64), code


@intrinsic
def rows_from(typing_context, rows, first):
    """The same table from a later row on."""

    def code(context, builder, signature, args):
        made = cgutils.create_struct_proxy(TABLE)(context, builder, value=args[0])
        place = _entry(context, builder, TABLE, args[0], args[1], ir.IntType(64)(0))
        return _table(context, builder, place, made.columns)

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


def _eight(builder, context, rows, row):
    data = cgutils.create_struct_proxy(TABLE)(context, builder, value=rows).data
    start = builder.mul(row, ir.IntType(64)(LANES))
    return builder.bitcast(builder.gep(data, [start]), _FLOATS.as_pointer())


@intrinsic
def load(typing_context, rows, row):
    """A row of a table of lanes."""

    def code(context, builder, signature, args):
        return builder.load(_eight(builder, context, *args), align=_ALIGNMENT)

    return Lanes(TABLE, types.intp), code


@intrinsic
def store(typing_context, rows, row, value):
    """Write a row, as `load` reads it."""

    def code(context, builder, signature, args):
        builder.store(args[2], _eight(builder, context, *args[:2]), align=_ALIGNMENT)
        return context.get_dummy_value()

    return types.void(TABLE, types.intp, Lanes), code
