"""Numbers that count what is done to them: the floating-point operations of a formula.

Additions, multiplications, divisions and roundings count as one each; a fused
multiply-add is therefore two, as in every processor's stated peak. A division takes as
long as several of the others, so a count is a lower bound of the work.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import DOP853

from benchmarks.equations import (
    Constants,
    free_accelerations,
    locked_accelerations,
)

# sin and cos on [-π/4, π/4] to rounding: x + x³P(x²) and 1 − x²/2 + x⁴Q(x²). Coefficients
# of Moshier's Cephes, 1984; highest power first.
SINE = (
    1.58962301576546568060e-10, -2.50507477628578072866e-8, 2.75573136213857245213e-6,
    -1.98412698295895385996e-4, 8.33333333332211858878e-3, -1.66666666666666307295e-1,
)  # fmt: skip
COSINE = (
    -1.13585365213876817300e-11, 2.08757008419747316778e-9, -2.75573141792967388112e-7,
    2.48015872888517045348e-5, -1.38888888888730564116e-3, 4.16666666666665929218e-2,
)  # fmt: skip
QUARTERS = 2.0 / np.pi  # turns of π/2 in a radian
# π/2 in three parts, of which the first two have bits to spare for a small multiple.
PARTS = (1.57079625129699707031, 7.54978941586159635335e-8, 5.39030285815811905290e-15)

LOCKED_DIMENSION, FREE_DIMENSION = 4, 6


class Counted:
    """A number that counts the operations it takes part in, with all others of its kind."""

    done = 0

    def __init__(self, value: float) -> None:
        self.value = value

    def __add__(self, other: Any) -> Counted:
        return _counted(self.value + _plain(other))

    def __sub__(self, other: Any) -> Counted:
        return _counted(self.value - _plain(other))

    def __rsub__(self, other: Any) -> Counted:
        return _counted(_plain(other) - self.value)

    def __mul__(self, other: Any) -> Counted:
        return _counted(self.value * _plain(other))

    def __truediv__(self, other: Any) -> Counted:
        return _counted(self.value / _plain(other))

    def __rtruediv__(self, other: Any) -> Counted:
        return _counted(_plain(other) / self.value)

    def __round__(self) -> Counted:
        return _counted(float(round(self.value)))

    def __neg__(self) -> Counted:
        return Counted(-self.value)  # a sign is no work: the next operation takes it in

    __radd__, __rmul__ = __add__, __mul__


def count(function: Callable[..., Any], *arguments: Any) -> int:
    """Operations that a function does on `Counted` arguments."""
    before = Counted.done
    function(*arguments)
    return Counted.done - before


def sine_and_cosine(x: Any) -> tuple[Any, Any]:
    """Both by polynomials to rounding, up to the exchange and the signs of the quadrant.

    Written for counting: |x| up to some thousand radians.
    """
    turns = round(x * QUARTERS)
    r = ((x - turns * PARTS[0]) - turns * PARTS[1]) - turns * PARTS[2]
    z = r * r
    sine, cosine = SINE[0], COSINE[0]
    for s, c in zip(SINE[1:], COSINE[1:], strict=True):
        sine, cosine = sine * z + s, cosine * z + c
    return r + r * z * sine, (1.0 - 0.5 * z) + z * z * cosine


def evaluation_flops(c: Constants) -> tuple[int, int]:
    """Operations of one right-hand side, foot locked and motor on, its sines included."""
    counted = Constants(*(Counted(value) for value in c))  # type: ignore[arg-type]
    turns = tuple(Counted(value) for value in (0.9, 0.1, 0.8, 0.2, 0.7, 0.3))
    rates = (Counted(0.4), Counted(0.5), Counted(0.6))
    pair = count(sine_and_cosine, Counted(0.3))
    locked = count(locked_accelerations, counted, turns, rates)
    free = count(free_accelerations, counted, turns, rates)
    return locked + 3 * pair + 1, free + 3 * pair  # 1: the foot's angle from the leg's


def step_flops(dimension: int) -> int:
    """Operations of one DOP853 step beside its evaluations: stages, end, error estimate.

    A multiplication and an addition for every coefficient that is not zero, h and y once
    a stage, and for the two error estimates their scale and the sums of squares.
    """
    stages = sum(2 * int(np.count_nonzero(row)) + 1 for row in DOP853.A[1:])
    end = 2 * int(np.count_nonzero(DOP853.B)) + 1
    estimates = 2 * int(np.count_nonzero(DOP853.E3) + np.count_nonzero(DOP853.E5))
    norm = 3 + 2 * 3  # tolerance·max(...) and its quotients; squares and sums
    return (stages + end + estimates + norm) * dimension


def _counted(value: float) -> Counted:
    Counted.done += 1
    return Counted(value)


def _plain(value: Any) -> Any:
    return value.value if isinstance(value, Counted) else value
