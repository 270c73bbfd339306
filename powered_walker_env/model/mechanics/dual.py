"""Numbers with their derivatives, in plain Python: for what is calculated once per walker.

A `Dual` is a value and its derivative along one direction, each a float, a complex number or an
array of them; the product and quotient rules do the rest. (Inside kernels `compiled/lanes` has
the same.)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Dual:
    """A value and its derivative."""

    value: Any
    tangent: Any

    __array_ufunc__ = None  # numpy's arrays leave what they have to do with it to it

    def __add__(self, other: Any) -> Dual:
        value, tangent = _parts(other)
        return Dual(self.value + value, self.tangent + tangent)

    __radd__ = __add__

    def __neg__(self) -> Dual:
        return Dual(-self.value, -self.tangent)

    def __sub__(self, other: Any) -> Dual:
        value, tangent = _parts(other)
        return Dual(self.value - value, self.tangent - tangent)

    def __rsub__(self, other: Any) -> Dual:
        return -self + other

    def __mul__(self, other: Any) -> Dual:
        value, tangent = _parts(other)
        return Dual(self.value * value, self.tangent * value + self.value * tangent)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Dual:
        value, tangent = _parts(other)
        quotient = self.value / value
        return Dual(quotient, (self.tangent - quotient * tangent) / value)

    def __rtruediv__(self, other: Any) -> Dual:
        return Dual(*_parts(other)) / self


def _parts(number: Any) -> tuple[Any, Any]:
    return (number.value, number.tangent) if isinstance(number, Dual) else (number, 0.0)


def value_of(number: Any) -> Any:
    """The value, of plain numbers themselves."""
    return _parts(number)[0]


def tangent_of(number: Any) -> Any:
    """The derivative, of plain numbers 0."""
    return _parts(number)[1]


def unit(angle: Any) -> Any:
    """e^{i·angle}."""
    turn = np.exp(1j * value_of(angle))
    return Dual(turn, 1j * turn * angle.tangent) if isinstance(angle, Dual) else turn


def conjugate(number: Any) -> Any:
    """The complex conjugate."""
    if isinstance(number, Dual):
        return Dual(np.conj(number.value), np.conj(number.tangent))
    return np.conj(number)


def real(number: Any) -> Any:
    """The real part."""
    if isinstance(number, Dual):
        return Dual(np.real(number.value), np.real(number.tangent))
    return np.real(number)


def square(number: Any) -> Any:
    """|number|², real."""
    if isinstance(number, Dual):
        moved = 2.0 * (np.conj(number.value) * number.tangent).real
        return Dual(abs(number.value) ** 2, moved)
    return abs(number) ** 2


def length(number: Any) -> Any:
    """|number|, real."""
    if isinstance(number, Dual):
        size = abs(number.value)
        return Dual(size, (np.conj(number.value) * number.tangent).real / size)
    return abs(number)


def choose(condition: Any, yes: Any, no: Any) -> Any:
    """`yes` where the condition, of plain arrays, holds, else `no`."""
    value = np.where(condition, value_of(yes), value_of(no))
    if isinstance(yes, Dual) or isinstance(no, Dual):
        return Dual(value, np.where(condition, tangent_of(yes), tangent_of(no)))
    return value
