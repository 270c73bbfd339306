"""States: the six numbers of three links, angles and rates, for eight walkers at once.

A state is a tuple of six `Lanes`, or of six `Dual`s; those of a link that does not exist may be
`Zero`. Each function here is one operation on all six, so that a method of integration reads as its
formula does.
"""

from __future__ import annotations

from llvmlite import ir
from numba.core import types
from numba.extending import intrinsic

from powered_walker_env.compiled.lanes.arithmetic import Code
from powered_walker_env.compiled.lanes.kinds import (
    ALIGNMENT,
    Dual,
    Lanes,
    Mask,
    Number,
    Zero,
    constant,
    kind_of,
    number_of,
    value_of,
)
from powered_walker_env.compiled.lanes.tables import TABLE, row_pointer

SIZE = 6
State = types.UniTuple(Lanes, SIZE)
DualState = types.UniTuple(Dual, SIZE)


def _numbers(context, builder, kind, value):
    parts = (builder.extract_value(value, i) for i in range(SIZE))
    return [number_of(context, builder, *each) for each in zip(kind, parts, strict=True)]


def _made(context, builder, kind, numbers):
    values = [value_of(context, builder, *each) for each in zip(kind, numbers, strict=True)]
    return context.make_tuple(builder, kind, values)


def _row(builder, row, i):
    return builder.add(row, ir.IntType(64)(i))


def _is_state(kind):
    return (
        isinstance(kind, types.BaseTuple)
        and len(kind) == SIZE
        and all(each in (Lanes, Dual, Zero) for each in kind)
    )


@intrinsic
def load_state(typing_context, rows, row):
    """Six rows of a table of lanes as a state."""

    def code(context, builder, signature, args):
        pointers = (
            row_pointer(context, builder, args[0], _row(builder, args[1], i)) for i in range(SIZE)
        )
        loaded = [builder.load(pointer, align=ALIGNMENT) for pointer in pointers]
        return context.make_tuple(builder, State, loaded)

    return State(TABLE, types.intp), code


@intrinsic
def load_like(typing_context, state, rows, row):
    """Six rows as a state of another's kind: what is `Zero` there is not looked at."""

    def code(context, builder, signature, args):
        loaded = []
        for i, kind in enumerate(state):
            pointer = row_pointer(context, builder, args[1], _row(builder, args[2], i))
            known = kind == Zero
            loaded.append(Number() if known else Number(builder.load(pointer, align=ALIGNMENT)))
        return _made(context, builder, state, loaded)

    return state(state, TABLE, types.intp), code


def _store(context, builder, args, mask, vectors):
    for i, new in enumerate(vectors):
        pointer = row_pointer(context, builder, args[0], _row(builder, args[1], i))
        new = constant(0.0) if new is None else new
        if mask is not None:
            new = builder.select(mask, new, builder.load(pointer, align=ALIGNMENT))
        builder.store(new, pointer, align=ALIGNMENT)
    return context.get_dummy_value()


@intrinsic
def store_state(typing_context, rows, row, state):
    """The inverse of `load_state`; of a dual state the values."""

    def code(context, builder, signature, args):
        numbers = _numbers(context, builder, signature.args[2], args[2])
        return _store(context, builder, args, None, [each.real for each in numbers])

    return types.void(TABLE, types.intp, state), code


@intrinsic
def blend_state(typing_context, rows, row, mask, state):
    """Write six rows where the mask holds."""

    def code(context, builder, signature, args):
        numbers = _numbers(context, builder, signature.args[3], args[3])
        return _store(context, builder, args, args[2], [each.real for each in numbers])

    return types.void(TABLE, types.intp, Mask, state), code


@intrinsic
def plus(typing_context, a, factor, b):
    """a + factor·b, number by number; the factor does not change."""
    if not _is_state(a) or not _is_state(b) or factor == Dual:
        return None
    factor = factor if factor == Lanes else types.float64

    def code(context, builder, signature, args):
        left = _numbers(context, builder, signature.args[0], args[0])
        by = number_of(context, builder, signature.args[1], args[1])
        right = _numbers(context, builder, signature.args[2], args[2])
        do = Code(builder)
        moved = [
            do.each(do.add, x, Number(do.mul(by.real, y.real), None, do.mul(by.real, y.dreal)))
            for x, y in zip(left, right, strict=True)
        ]
        return _made(context, builder, signature.return_type, moved)

    result = types.BaseTuple.from_types([kind_of(pair) for pair in zip(a, b, strict=True)])
    return result(a, factor, b), code


@intrinsic
def scaled(typing_context, factor, a):
    """factor·a, number by number."""
    factor = factor if factor == Lanes else types.float64

    def code(context, builder, signature, args):
        by = number_of(context, builder, signature.args[0], args[0]).real
        numbers = _numbers(context, builder, signature.args[1], args[1])
        return _made(context, builder, a, [Number(Code(builder).mul(by, x.real)) for x in numbers])

    return a(factor, a), code


@intrinsic
def dual_state(typing_context, values, tangents):
    """A state with its tangents."""

    def code(context, builder, signature, args):
        pairs = zip(
            _numbers(context, builder, State, args[0]),
            _numbers(context, builder, State, args[1]),
            strict=True,
        )
        return _made(context, builder, DualState, [Number(a.real, None, b.real) for a, b in pairs])

    return DualState(State, State), code


@intrinsic
def tangents_of(typing_context, state):
    """The tangents of a dual state, as a state."""

    def code(context, builder, signature, args):
        numbers = _numbers(context, builder, DualState, args[0])
        return _made(context, builder, State, [Number(each.dreal) for each in numbers])

    return State(DualState), code


@intrinsic
def selected(typing_context, mask, yes, no):
    """A state from one of two, lane by lane."""

    def code(context, builder, signature, args):
        pairs = zip(*(_numbers(context, builder, yes, value) for value in args[1:]), strict=True)
        chosen = [
            Number(*(x and builder.select(args[0], x, y) for x, y in zip(a, b, strict=True)))
            for a, b in pairs
        ]
        return _made(context, builder, yes, chosen)

    return yes(Mask, yes, yes), code
