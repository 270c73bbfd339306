"""The walker's state just after heel strike: the Poincaré section of the package."""

from __future__ import annotations

from typing import Any, NamedTuple

from powered_walker_env.model.checks import plain, real_number, require


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
