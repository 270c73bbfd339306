"""Sine and cosine on lanes: reduction to an eighth of a turn, then polynomials.

Libraries' functions take one number at a time. These are the minimax polynomials of
Sun's fdlibm (k_sin.c, k_cos.c, 1993) on |x| <= pi/4, after the subtraction of quarter
turns in three parts (Cody and Waite 1980): within two units in the last place for
|x| < 1e5 rad, which no walker reaches.
"""

from __future__ import annotations

import math

from numba.core import types
from numba.extending import intrinsic, overload

from powered_walker_env.compiled.decorators import internal
from powered_walker_env.compiled.lanes.kinds import (
    FLOATS,
    INTS,
    Dual,
    Lanes,
    Mask,
    Zero,
    constant,
)
from powered_walker_env.compiled.lanes.selection import dual, where

# π/2 in three parts; the first two have 33 bits, so that a hundred thousand times they are exact.
_QUARTER, _QUARTER_2, _QUARTER_3 = (
    1.5707963267341256,
    6.077100506303966e-11,
    2.0222662487959506e-21,
)
_S1, _S2, _S3, _S4, _S5, _S6 = (
    -1.66666666666666324348e-01,
    8.33333333332248946124e-03,
    -1.98412698298579493134e-04,
    2.75573137070700676789e-06,
    -2.50507602534068634195e-08,
    1.58969099521155010221e-10,
)
_C1, _C2, _C3, _C4, _C5, _C6 = (
    4.16666666666666019037e-02,
    -1.38888888888741095749e-03,
    2.48015872894767294178e-05,
    -2.75573143513906633035e-07,
    2.08757232129817482790e-09,
    -1.13596475577881948265e-11,
)
# Added to a small number, it leaves the nearest integer in the lowest bits.
_ROUNDER = 1.5 * 2.0**52


@intrinsic
def _quarters(typing_context, x):
    """Nearest number of quarter turns; is it odd; signs of the sine and the cosine there."""
    result = types.Tuple((Lanes, Mask, Lanes, Lanes))

    def code(context, builder, signature, args):
        shifted = builder.fadd(builder.fmul(args[0], constant(2.0 / math.pi)), constant(_ROUNDER))
        count = builder.bitcast(shifted, INTS)
        one, two, up = (constant(n, INTS) for n in (1, 2, 62))
        odd = builder.icmp_signed("!=", builder.and_(count, one), constant(0, INTS))
        sine = builder.shl(builder.and_(count, two), up)
        cosine = builder.shl(builder.and_(builder.add(count, one), two), up)
        number = builder.fsub(shifted, constant(_ROUNDER))
        signs = (builder.bitcast(sine, FLOATS), builder.bitcast(cosine, FLOATS))
        return context.make_tuple(builder, result, (number, odd, *signs))

    return result(x), code


@intrinsic
def _signed(typing_context, x, sign):
    """x, its sign turned where the sign bit of `sign` is set."""

    def code(context, builder, signature, args):
        turned = builder.xor(*(builder.bitcast(a, INTS) for a in args))
        return builder.bitcast(turned, FLOATS)

    return Lanes(x, sign), code


@internal
def _sine_cosine(x):
    quarters, odd, sine_sign, cosine_sign = _quarters(x)
    near = (x - quarters * _QUARTER) - quarters * _QUARTER_2
    r = near - quarters * _QUARTER_3  # counts where r is nearly 0 alone: its square need not wait
    z = near * near
    # In pairs (Estrin): a chain of multiply-adds half as long as Horner's.
    zz = z * z
    odds = (_S1 + z * _S2) + zz * ((_S3 + z * _S4) + zz * (_S5 + z * _S6))
    evens = (_C1 + z * _C2) + zz * ((_C3 + z * _C4) + zz * (_C5 + z * _C6))
    sine = r + (r * z) * odds
    cosine = (1.0 - 0.5 * z) + zz * evens
    return (
        _signed(where(odd, cosine, sine), sine_sign),
        _signed(where(odd, sine, cosine), cosine_sign),
    )


def unit(angle):
    """e^{i·angle}."""
    return complex(math.cos(angle), math.sin(angle))


@overload(unit)
def _unit(angle):
    if angle == Lanes:
        return lambda angle: _plain_unit(angle)
    if angle == Dual:
        return lambda angle: _dual_unit(angle)
    if angle == Zero:
        return lambda angle: complex(1.0, 0.0)
    return None


@internal
def _plain_unit(angle):
    sine, cosine = _sine_cosine(angle)
    return complex(cosine, sine)


@internal
def _dual_unit(angle):
    """(e^{iθ})' = i e^{iθ} θ'."""
    sine, cosine = _sine_cosine(angle.value)
    along = angle.tangent
    return dual(complex(cosine, sine), complex(-sine * along, cosine * along))
