"""Impulsive toe-off: a push along the trailing leg around heel strike (McGeer 1990; Kuo 2002).

Before, with or after the heel strike the state that follows is the same, but the work is
not: see `model/mechanics/push_off.py`. A spring between the legs is the walker's `hip_stiffness`.
"""

from __future__ import annotations

from dataclasses import dataclass

from powered_walker_env.model.phases import (
    Cycle,
    Exit,
    Guard,
    Joints,
    Outcome,
    Phase,
    Reset,
    Torque,
)
from powered_walker_env.model.powering.scheme import STRENGTH, Scheme
from powered_walker_env.model.quantities import NOT_NEGATIVE, check_numbers, documented, quantity


def _pushed(reset: Reset) -> Cycle:
    return (
        Phase(
            "swing",
            Joints.ANKLE_LOCKED,
            Torque.NONE,
            (Exit(Guard.LANDING, reset, Outcome.WALKED),),
        ),
    )


@documented
@dataclass(frozen=True)
class ToeOff:
    """A push just before heel strike.

    Under a round foot the impulse acts at the contact point, along the trailing leg, as ankle
    to hip has it (not through the foot's centre, nor along the floor's normal).

    Raises:
        ValueError: an impulse that is negative or not finite.
    """

    impulse: float = quantity("P", "N s", "impulse along the trailing leg", NOT_NEGATIVE)

    def __post_init__(self) -> None:
        check_numbers(self)


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
