"""Checks of arguments: name, need, value, remedy."""

from __future__ import annotations

import math
import numbers
from typing import Any


def real_number(name: str, value: Any) -> float:
    """`value` as a finite Python float (numba compiles a second kernel for an int)."""
    if isinstance(value, bool) or not isinstance(value, numbers.Real):
        raise TypeError(f"{name} must be a real number, got {value!r}")
    try:
        number = float(value)
    except OverflowError:  # an integer beyond the floats
        number = math.inf
    if not math.isfinite(number):
        raise ValueError(f"{name} must be finite, got {value!r}")
    return number


def whole_number(name: str, value: Any, low: int, high: int | None = None) -> int:
    """`value` as an int between two.

    Raises:
        TypeError: no integer; ValueError: one out of bounds.
    """
    bounds = f"at least {low}" if high is None else f"between {low} and {high}"
    if isinstance(value, bool) or not isinstance(value, numbers.Integral):
        raise TypeError(f"{name} must be a whole number, {bounds}, got {value!r}")
    number = int(value)
    require(low <= number and (high is None or number <= high), name, f"be {bounds}", number)
    return number


def require(holds: bool, name: str, need: str, value: object, remedy: str = "") -> None:
    if not holds:
        raise ValueError(f"{name} must {need}, got {value!r}" + (f"; {remedy}" if remedy else ""))


def plain(value: Any) -> Any:
    """A numpy scalar as the Python number it holds."""
    return value.item() if getattr(value, "ndim", None) == 0 else value
