"""Impulsive toe-off: a push along the trailing leg around heel strike (McGeer 1990; Kuo 2002).

Before, with or after the heel strike the state that follows is the same, but the work is
not: see `physics/push_off.py`. A spring between the legs is the walker's `hip_stiffness`.
"""

from __future__ import annotations

from dataclasses import dataclass

from powered_walker_env.params import real_number, require
from powered_walker_env.phases import Cycle, Exit, Guard, Joints, Outcome, Phase, Reset, Torque
from powered_walker_env.schemes.scheme import STRENGTH, Scheme


def _pushed(reset: Reset) -> Cycle:
    return (
        Phase(
            "swing",
            Joints.ANKLE_LOCKED,
            Torque.NONE,
            (Exit(Guard.LANDING, reset, Outcome.WALKED),),
        ),
    )


@dataclass(frozen=True)
class ToeOff:
    """A push just before heel strike.

    Raises:
        ValueError: an impulse that is negative or not finite.
    """

    impulse: float  # N s, >= 0, along the trailing leg

    def __post_init__(self) -> None:
        object.__setattr__(self, "impulse", real_number("impulse", self.impulse))
        require(self.impulse >= 0, "impulse", "not be negative", self.impulse)


@dataclass(frozen=True)
class ToeOffAtStrike(ToeOff):
    """A push at once with the heel strike."""


@dataclass(frozen=True)
class LateToeOff(ToeOff):
    """A push just after heel strike."""


TOE_OFF = Scheme("toe-off", _pushed(Reset.PUSH_BEFORE), ToeOff, (STRENGTH,))
TOE_OFF_AT_STRIKE = Scheme(
    "toe-off-at-strike", _pushed(Reset.PUSH_WITH), ToeOffAtStrike, (STRENGTH,)
)
LATE_TOE_OFF = Scheme("late-toe-off", _pushed(Reset.PUSH_AFTER), LateToeOff, (STRENGTH,))
