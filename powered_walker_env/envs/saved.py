"""Checks of a state that `get_state` has given, before `set_state` goes back to it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from powered_walker_env.model.phases import Outcome
from powered_walker_env.simulation.strides import Array


class Saved(NamedTuple):
    """What one walker's future depends on; the names of its entries."""

    state: Array  # (4,) post-strike, rad and rad/s
    observation: Array  # (4,)
    level: float  # m, of the ground under the stance foot
    outcome: int  # of the last stride
    walker: Array  # packed
    random: int  # the word that its random numbers come from

    @classmethod
    def of(cls, saved: Any, packed: int) -> Saved:
        """From the entries of a mapping; a walker is packed in so many numbers.

        Raises:
            ValueError: something that `get_state` has not given.
        """
        check_saved(saved, cls._fields)
        return cls(
            numbers(saved, "state", 4),
            numbers(saved, "observation", 4),
            float(numbers(saved, "level", 1)[0]),
            integer(saved, "outcome", len(Outcome)),
            numbers(saved, "walker", packed),
            integer(saved, "random", 2**64),
        )


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
