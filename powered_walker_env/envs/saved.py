"""Checks of a state that `get_state` has given, before `set_state` goes back to it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from powered_walker_env.simulation.strides import Array


def check_saved(saved: Any, names: tuple[str, ...]) -> None:
    """Reject a saved state without these entries.

    Raises:
        ValueError: naming the entries that are missing.
    """
    missing = [name for name in names if not (isinstance(saved, Mapping) and name in saved)]
    if missing:
        raise ValueError(
            f"saved must be a state of get_state(), got {saved!r} without {', '.join(missing)}"
        )


def numbers(saved: Mapping[str, Any], name: str, count: int) -> Array:
    """The entry `name`: (count,) finite numbers.

    Raises:
        ValueError: it is something else.
    """
    try:
        values = np.atleast_1d(np.asarray(saved[name], np.float64))
    except (TypeError, ValueError):
        values = np.empty(0)
    if values.shape != (count,) or not np.isfinite(values).all():
        raise ValueError(f"saved {name} must be {count} finite numbers, got {saved[name]!r}")
    return values


def integer(saved: Mapping[str, Any], name: str, end: int) -> int:
    """The entry `name`: an integer in [0, end).

    Raises:
        ValueError: it is something else.
    """
    value = saved[name]
    good = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
    if not (good and 0 <= value < end):
        raise ValueError(f"saved {name} must be an integer in [0, {end}), got {value!r}")
    return int(value)
