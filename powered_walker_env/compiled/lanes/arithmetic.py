"""Arithmetic of lanes: `+ - * /`, comparisons, `complex`, square root, absolute value, `where`.

Products and sums may be fused (`contract`), in all lanes alike.
"""

from __future__ import annotations

import math
import operator

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.imputils import lower_builtin, lower_getattr
from numba.extending import intrinsic, overload, type_callable

from powered_walker_env.compiled.lanes.kinds import (
    BITS,
    FLOATS,
    LANES,
    Lanes,
    Mask,
    Plane,
    constant,
    is_number,
    parts_of,
    plane_of,
)

_FLAGS = ("contract",)

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
            if all(is_number(x) for x in pair) and (Lanes in pair or Plane in pair):
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
            parts_of(context, builder, a, args[0]), parts_of(context, builder, b, args[1])
        )  # fmt: skip
        emit = getattr(builder, instruction)
        real = emit(ar, br, flags=_FLAGS)
        if signature.return_type == Lanes:
            return real
        if bi is None:
            return plane_of(context, builder, real, ai)
        imag = emit(constant(0.0) if ai is None else ai, bi, flags=_FLAGS)
        return plane_of(context, builder, real, imag)

    return code


def _product_code(context, builder, signature, args):
    a, b = signature.args
    (ar, ai), (br, bi) = (
        parts_of(context, builder, a, args[0]), parts_of(context, builder, b, args[1])
    )  # fmt: skip

    def times(x, y):
        return builder.fmul(x, y, flags=_FLAGS)

    if ai is None and bi is None:
        return times(ar, br)
    if ai is None:
        return plane_of(context, builder, times(ar, br), times(ar, bi))
    if bi is None:
        return plane_of(context, builder, times(ar, br), times(ai, br))
    real = builder.fsub(times(ar, br), times(ai, bi), flags=_FLAGS)
    imag = builder.fadd(times(ar, bi), times(ai, br), flags=_FLAGS)
    return plane_of(context, builder, real, imag)


def _quotient_code(context, builder, signature, args):
    a, b = signature.args
    ar, _ = parts_of(context, builder, a, args[0])
    br, _ = parts_of(context, builder, b, args[1])
    return builder.fdiv(ar, br, flags=_FLAGS)


def _real_only(result):
    return lambda pair: None if Plane in pair else result


def _comparison_code(sign):
    def code(context, builder, signature, args):
        a, b = signature.args
        ar, _ = parts_of(context, builder, a, args[0])
        br, _ = parts_of(context, builder, b, args[1])
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


@lower_getattr(type(Plane), "real")
def _real(context, builder, numba_type, value):
    return parts_of(context, builder, numba_type, value)[0]


@lower_getattr(type(Plane), "imag")
def _imag(context, builder, numba_type, value):
    return parts_of(context, builder, numba_type, value)[1]


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
        kind = ir.FunctionType(FLOATS, [FLOATS])
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
        return Plane if Lanes in pair and all(is_number(x) for x in pair) else None

    return typer


def _complex_code(context, builder, signature, args):
    parts = [parts_of(context, builder, t, v)[0] for t, v in zip(signature.args, args, strict=True)]
    return plane_of(context, builder, *parts)


_define(complex, _REAL_PAIRS, _complex_code)


def where(condition, yes, no):
    """`yes` where the condition holds, else `no`."""
    return yes if condition else no


@intrinsic
def _select(typing_context, mask, yes, no):
    def code(context, builder, signature, args):
        _, a, b = signature.args
        first, _ = parts_of(context, builder, a, args[1])
        second, _ = parts_of(context, builder, b, args[2])
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
        return builder.bitcast(builder.trunc(args[0], ir.IntType(LANES)), BITS)

    return Mask(types.int64), code
