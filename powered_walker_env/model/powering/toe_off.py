"""Impulsive toe-off: a push along the trailing leg around heel strike (McGeer 1990; Kuo 2002).

Before, with or after the heel strike the state that follows is the same, but the work is
not: see `model/mechanics/push_off.py`. A spring between the legs is the walker's `hip_stiffness`.
"""

from __future__ import annotations

from dataclasses import dataclass

from powered_walker_env.model.checks import require
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
from powered_walker_env.model.walker import WalkerParams


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
    """A push at once with the heel strike.

    Both impulses grow together, so each does its work over the mean velocity of its point, and
    what a stride loses is what the floor takes at the new foot, −½⟨floor's impulse, velocity
    before⟩. It is below zero, the floor gives, where the push alone would throw the new foot
    off: the plastic strike then holds it by pulling at it, or drags it along, which no floor
    does (`ContactReport.strike_pushes`). A push before or after the strike never has this.
    """


@dataclass(frozen=True)
class LateToeOff(ToeOff):
    """A push just after heel strike."""


def _needs_a_foot_with_mass(params: WalkerParams) -> None:
    pointed = params.foot_length == 0 and params.foot_radius == 0
    require(
        pointed or not params.massless_foot,
        "leg_inertia",
        "be positive for a push-off from a foot that is not a point",
        params.leg_inertia,
        "the impulse would turn a massless leg infinitely fast",
    )


def _scheme(name: str, reset: Reset, control: type[ToeOff]) -> Scheme:
    return Scheme(name, _pushed(reset), control, (STRENGTH,), _needs_a_foot_with_mass)


#: An impulse along the trailing leg just before heel strike.
TOE_OFF = _scheme("toe-off", Reset.PUSH_BEFORE, ToeOff)
#: The same together with the heel strike.
TOE_OFF_AT_STRIKE = _scheme("toe-off-at-strike", Reset.PUSH_WITH, ToeOffAtStrike)
#: The same just after the heel strike.
LATE_TOE_OFF = _scheme("late-toe-off", Reset.PUSH_AFTER, LateToeOff)
