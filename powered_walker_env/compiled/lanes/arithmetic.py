"""Arithmetic of lanes: `+ - * /`, comparisons, `complex`, square root, absolute value, `where`.

One code serves real, complex and dual numbers: the parts that a number has not are left out, and
tangents follow the product rule. Products and sums may be fused (`contract`), in all lanes alike.
"""

from __future__ import annotations

import itertools
import math
import operator

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.imputils import lower_builtin
from numba.extending import type_callable

from powered_walker_env.compiled.lanes.kinds import (
    FLOATS,
    LANES,
    MEMBERS,
    Dual,
    DualPlane,
    Lanes,
    Mask,
    Number,
    Plane,
    Zero,
    constant,
    is_number,
    kind_of,
    number_of,
    product_of,
    value_of,
)

_FLAGS = ("contract",)
_PLAIN = (types.Float, types.Integer, types.Complex)


class Code:
    """LLVM's instructions on vectors of which some are missing (None: zero)."""

    def __init__(self, builder):
        self.builder = builder

    def add(self, a, b):
        if a is None or b is None:
            return b if a is None else a
        return self.builder.fadd(a, b, flags=_FLAGS)

    def sub(self, a, b):
        if b is None:
            return a
        return self.builder.fsub(constant(0.0) if a is None else a, b, flags=_FLAGS)

    def mul(self, a, b):
        return None if a is None or b is None else self.builder.fmul(a, b, flags=_FLAGS)

    def div(self, a, b):
        return None if a is None else self.builder.fdiv(a, b, flags=_FLAGS)

    def neg(self, a):
        return None if a is None else self.builder.fneg(a)

    def each(self, operation, a, b):
        return Number(*(operation(x, y) for x, y in zip(a, b, strict=True)))

    def times(self, a, b):
        """(a + ia')(b + ib') of pairs."""
        (ar, ai), (br, bi) = a, b
        return (
            self.sub(self.mul(ar, br), self.mul(ai, bi)) if ai is not None and bi is not None
            else self.mul(ar, br),
            self.add(self.mul(ar, bi), self.mul(ai, br)),
        )  # fmt: skip


def _sum(code, a, b):
    return code.each(code.add, a, b)


def _difference(code, a, b):
    return code.each(code.sub, a, b)


def _product(code, a, b):
    value = code.times(a[:2], b[:2])
    left, right = code.times(a[:2], b[2:]), code.times(a[2:], b[:2])
    return Number(*value, *map(code.add, left, right))


def _quotient(code, a, b):
    """Of reals: (a/b)' = (a' − (a/b) b')/b."""
    value = code.div(a.real, b.real)
    return Number(value, None, code.div(code.sub(a.dreal, code.mul(value, b.dreal)), b.real))


def _declare(operation, result_of, arity=2):
    @type_callable(operation)
    def _type(context):
        def typer(*arguments):
            ours = len(arguments) == arity and all(is_number(x) for x in arguments)
            if ours and any(x in MEMBERS for x in arguments):
                return result_of(arguments)
            return None

        if arity == 1:
            return lambda x: typer(x)
        return lambda a, b: typer(a, b)


def _define(operation, formula, kinds=tuple(MEMBERS)):
    def lowered(context, builder, signature, args):
        numbers = [
            number_of(context, builder, *each) for each in zip(signature.args, args, strict=True)
        ]
        found = formula(Code(builder), *numbers)
        return value_of(context, builder, signature.return_type, found)

    for pair in itertools.product((*kinds, *_PLAIN), repeat=2):
        if any(kind in kinds for kind in pair):
            lower_builtin(operation, *pair)(lowered)


def _real_only(result_of):
    return lambda pair: None if kind_of(pair) in (Plane, DualPlane) else result_of(pair)


def _quotient_of(pair):
    return None if pair[1] == Zero else product_of(pair)


for _operation, _formula, _kind in (
    (operator.add, _sum, kind_of),
    (operator.sub, _difference, kind_of),
    (operator.mul, _product, product_of),
):
    _declare(_operation, _kind)
    _define(_operation, _formula)
_declare(operator.truediv, _real_only(_quotient_of))
_define(operator.truediv, _quotient, (Lanes, Dual, Zero))
_declare(complex, lambda pair: {Dual: DualPlane, Zero: Zero}.get(kind_of(pair), Plane))
_define(complex, lambda _, a, b: Number(a.real, b.real, a.dreal, b.dreal), (Lanes, Dual, Zero))


def _compared(sign):
    def lowered(context, builder, signature, args):
        a, b = (
            number_of(context, builder, *each).real
            for each in zip(signature.args, args, strict=True)
        )
        return builder.fcmp_ordered(sign, a, b)

    return lowered


for _operation, _sign in (
    (operator.lt, "<"),
    (operator.le, "<="),
    (operator.gt, ">"),
    (operator.ge, ">="),
    (operator.eq, "=="),
):
    _declare(_operation, _real_only(lambda pair: Mask))
    for _pair in itertools.product((Lanes, Dual, *_PLAIN), repeat=2):
        if Lanes in _pair or Dual in _pair:
            lower_builtin(_operation, *_pair)(_compared(_sign))


def _function_of(function, argument, result, lowered):
    """Give a function of one argument a version for lanes."""

    @type_callable(function)
    def _type(context):
        return lambda x: result if x == argument else None

    lower_builtin(function, argument)(lowered)


def _llvm(name, kind=FLOATS):
    def call(builder, *args):
        signature = ir.FunctionType(kind, [kind] * len(args))
        function = cgutils.get_or_insert_function(builder.module, signature, f"{name}.v{LANES}f64")
        return builder.call(function, args)

    return call


_fabs, _sqrt = _llvm("llvm.fabs"), _llvm("llvm.sqrt")


def _unary(function, formula):
    for kind in (Lanes, Dual):

        def lowered(context, builder, signature, args, kind=kind):
            x = number_of(context, builder, kind, args[0])
            return value_of(context, builder, kind, formula(Code(builder), x))

        _function_of(function, kind, kind, lowered)


def _root(code, x):
    """(√x)' = x'/2√x."""
    value = _sqrt(code.builder, x.real)
    return Number(value, None, code.div(code.mul(constant(0.5), x.dreal), value))


def _absolute(code, x):
    """|x|' = x' sign x."""
    down = code.builder.fcmp_ordered("<", x.real, constant(0.0))
    tangent = x.dreal and code.builder.select(down, code.neg(x.dreal), x.dreal)
    return Number(_fabs(code.builder, x.real), None, tangent)


_unary(operator.neg, lambda code, x: Number(*map(code.neg, x)))
_unary(math.sqrt, _root)
_unary(abs, _absolute)
_function_of(operator.invert, Mask, Mask, lambda _c, builder, _s, args: builder.not_(args[0]))


def _mask_operation(operation, instruction):
    @type_callable(operation)
    def _type(context):
        return lambda a, b: Mask if a == Mask and b == Mask else None

    lower_builtin(operation, Mask, Mask)(
        lambda _c, builder, _s, args: getattr(builder, instruction)(*args)
    )


_mask_operation(operator.and_, "and_")
_mask_operation(operator.or_, "or_")
