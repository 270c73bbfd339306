"""Checks of arguments: name, need, value, remedy."""

from __future__ import annotations

import math
import numbers
from collections.abc import Mapping
from typing import Any, TypeVar

Known = TypeVar("Known")


def real_number(name: str, value: Any) -> float:
    """`value` as a finite Python float (numba compiles a second kernel for an int)."""
    if type(value) is float and math.isfinite(value):
        return value
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
    if isinstance(value, bool) or not isinstance(value, numbers.Integral):
        raise TypeError(f"{name} must be a whole number, got {value!r}")
    number = int(value)
    require(number >= low, name, f"be at least {low}", number)
    require(high is None or number <= high, name, f"be at most {high}", number)
    return number


def one_of(name: str, value: str, known: Mapping[str, Known]) -> Known:
    """What is known by that name.

    Raises:
        ValueError: nothing is; the message lists the names.
    """
    require(value in known, name, f"be one of {', '.join(known)}", value)
    return known[value]


def require(holds: bool, name: str, need: str, value: object, remedy: str = "") -> None:
    if not holds:
        raise ValueError(f"{name} must {need}, got {value!r}" + (f"; {remedy}" if remedy else ""))


def plain(value: Any) -> Any:
    """A numpy scalar as the Python number it holds."""
    return value.item() if getattr(value, "ndim", None) == 0 else value
