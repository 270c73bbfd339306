"""Camp's motor against a mechanical stop, which the foot cannot pass backwards.

The thesis's foot is held by a latch while it is locked, and by nothing afterwards: a weak
motor lets it fall back. Here the latch opens at the switch onto a stop. The stop holds
the ankle as long as the motor is too weak for the load, lets go when the torque that it
has to give falls to zero, and catches the foot, plastically, when it comes back.
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
from powered_walker_env.model.powering.motor import Control, needs_a_lever
from powered_walker_env.model.powering.scheme import ANGLE, STRENGTH, Scheme

#: The phases of a stride with a stop that the foot cannot pass backwards.
STOPPED_WALKER: Cycle = (
    Phase(
        "swing",
        Joints.ANKLE_LOCKED,
        Torque.NONE,
        (
            Exit(Guard.SWITCH_ANGLE, Reset.CONTINUE, "held"),
            Exit(Guard.LANDING, Reset.CONTINUE, Outcome.NO_SWITCH),
        ),
    ),
    Phase(
        "held",
        Joints.ANKLE_LOCKED,
        Torque.MOTOR,
        (
            Exit(Guard.RELEASE, Reset.CONTINUE, "powered"),
            Exit(Guard.LANDING, Reset.HEEL_STRIKE, Outcome.WALKED),
        ),
    ),
    Phase(
        "powered",
        Joints.ANKLE_FREE,
        Torque.MOTOR,
        (
            Exit(Guard.LANDING, Reset.HEEL_STRIKE, Outcome.WALKED),
            Exit(Guard.STOP, Reset.STOP, "held"),
        ),
    ),
)


@dataclass(frozen=True)
class StoppedControl(Control):
    """Switch angle, rad, and stall torque, N m, as `Control`, of a motor with a stop."""


#: Camp's motor with a mechanical stop.
STOPPED_MOTOR = Scheme(
    "motor-with-stop", STOPPED_WALKER, StoppedControl, (ANGLE, STRENGTH), needs_a_lever
)
