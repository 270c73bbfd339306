"""The walker's state just after heel strike: the Poincaré section of the package."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.model.checks import plain, real_number, require
from powered_walker_env.model.walker import WalkerParams


class PostStrikeState(NamedTuple):
    """The walker just after heel strike, feet locked: the Poincaré section of the package.

    Both legs are measured ankle to hip from the floor's normal, forward positive. After
    a fall there is no such state and all four are NaN.
    """

    stance_angle: float  # α, rad
    swing_angle: float  # s = β − π, rad
    stance_rate: float  # α', rad/s
    swing_rate: float  # β', rad/s


def check_state(state: Any) -> PostStrikeState:
    """The state as four finite floats.

    Raises:
        ValueError: not four numbers, or one that is not finite.
    """
    if type(state) is PostStrikeState and _finite(*state):
        return state
    try:
        values = tuple(state)
    except TypeError:
        values = ()
    require(
        len(values) == 4,
        "state",
        "be four numbers (stance_angle, swing_angle, stance_rate, swing_rate)",
        state,
    )
    named = zip(PostStrikeState._fields, values, strict=True)
    checked = (real_number(f"state.{n}", plain(v)) for n, v in named)
    return PostStrikeState(*checked)


def _finite(a: float, b: float, c: float, d: float) -> bool:
    """Whether four numbers are finite floats; four whose sum overflows are looked at closely."""
    floats = type(a) is type(b) is type(c) is type(d) is float
    return floats and math.isfinite(a + b + c + d)


def natural_units(params: WalkerParams) -> NDArray[np.float64]:
    """Units of a post-strike state, (4,): radians, and radians per √(L/g)."""
    rate = math.sqrt(params.gravity / params.leg_length)
    return np.array([1.0, 1.0, rate, rate])
