"""The zero that is known before a kernel is compiled."""

from __future__ import annotations

from numba.extending import intrinsic, overload

from powered_walker_env.compiled.lanes.kinds import Number, Zero, value_of


def zero():
    """0, whose sums and products take no time in a kernel."""
    return 0.0


@intrinsic
def _zero(typing_context):
    def code(context, builder, signature, args):
        return value_of(context, builder, Zero, Number())

    return Zero(), code


@overload(zero)
def _known():
    return lambda: _zero()
