"""Choosing between lanes, and seeing which: `where`, masks as bits; numbers with their tangents."""

from __future__ import annotations

from llvmlite import ir
from numba.core import types
from numba.core.imputils import lower_builtin
from numba.extending import intrinsic, type_callable

from powered_walker_env.compiled.lanes.kinds import (
    BITS,
    LANES,
    MEMBERS,
    Dual,
    DualPlane,
    Mask,
    Number,
    Plane,
    constant,
    is_number,
    kind_of,
    number_of,
    value_of,
)


def where(condition, yes, no):
    """`yes` where the condition holds, else `no`."""
    return yes if condition else no


@intrinsic
def dual(typing_context, value, tangent):
    """A number with its tangent."""
    kind = kind_of((value, tangent))
    result = DualPlane if kind in (Plane, DualPlane) else Dual

    def lowered(context, builder, signature, args):
        a, b = (number_of(context, builder, *x) for x in zip(signature.args, args, strict=True))
        return value_of(context, builder, result, Number(a.real, a.imag, b.real, b.imag))

    return result(value, tangent), lowered


@intrinsic
def at_lane_0(typing_context, value):
    """The float in the first lane."""

    def lowered(context, builder, signature, args):
        return builder.extract_element(args[0], ir.IntType(32)(0))

    return types.float64(value), lowered


@intrinsic
def bits(typing_context, mask):
    """The mask as an integer, lane 0 in the lowest bit."""

    def lowered(context, builder, signature, args):
        return builder.zext(builder.bitcast(args[0], ir.IntType(LANES)), ir.IntType(64))

    return types.int64(mask), lowered


@intrinsic
def count(typing_context, bits):
    """How many bits are set."""

    def lowered(context, builder, signature, args):
        return builder.ctpop(args[0])

    return types.int64(types.int64), lowered


@intrinsic
def mask_of(typing_context, bits):
    """The inverse of `bits`."""

    def lowered(context, builder, signature, args):
        return builder.bitcast(builder.trunc(args[0], ir.IntType(LANES)), BITS)

    return Mask(types.int64), lowered


@type_callable(where)
def _type_where(context):
    def typer(condition, yes, no):
        if condition == Mask and is_number(yes) and is_number(no):
            return kind_of((yes, no))
        if condition == types.boolean and is_number(yes) and is_number(no):
            ours = yes in MEMBERS or no in MEMBERS
            return kind_of((yes, no)) if ours else context.unify_types(yes, no)
        return None

    return typer


def _lowered_where(context, builder, signature, args):
    kind, (_, yes_kind, no_kind) = signature.return_type, signature.args
    if kind not in MEMBERS:
        values = (
            context.cast(builder, value, given, kind)
            for value, given in zip(args[1:], (yes_kind, no_kind), strict=True)
        )
        return builder.select(args[0], *values)
    yes = number_of(context, builder, yes_kind, args[1])
    no = number_of(context, builder, no_kind, args[2])
    zero = constant(0.0)
    parts = (
        None if a is None and b is None
        else builder.select(args[0], zero if a is None else a, zero if b is None else b)
        for a, b in zip(yes, no, strict=True)
    )  # fmt: skip
    return value_of(context, builder, kind, Number(*parts))


lower_builtin(where, types.Any, types.Any, types.Any)(_lowered_where)
