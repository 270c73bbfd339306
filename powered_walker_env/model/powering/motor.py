"""Camp's walker: a passive swing, then a constant voltage extends the stance foot (1997)."""

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
from powered_walker_env.model.powering.scheme import ANGLE, STRENGTH, Scheme
from powered_walker_env.model.quantities import (
    HIP_ANGLE,
    NOT_NEGATIVE,
    check_numbers,
    documented,
    quantity,
)
from powered_walker_env.model.walker import WalkerParams

#: The phases of Camp's stride: passive swing, then the motor on.
POWERED_WALKER: Cycle = (
    Phase(
        "swing",
        Joints.ANKLE_LOCKED,
        Torque.NONE,
        (
            Exit(Guard.SWITCH_ANGLE, Reset.CONTINUE, "powered"),
            Exit(Guard.LANDING, Reset.CONTINUE, Outcome.NO_SWITCH),
        ),
    ),
    Phase(
        "powered",
        Joints.ANKLE_FREE,
        Torque.MOTOR,
        (Exit(Guard.LANDING, Reset.HEEL_STRIKE, Outcome.WALKED),),
    ),
)


@documented
@dataclass(frozen=True)
class Control:
    """The open-loop control of one stride: when the motor starts and how strong it is.

    Raises:
        ValueError: `switch_angle` outside (0, 2π) or a `stall_torque` that is negative
            or not finite.
    """

    switch_angle: float = quantity("q3", "rad", "hip angle at which the motor starts", HIP_ANGLE)
    stall_torque: float = quantity("T", "N m", "stall torque of the ankle motor", NOT_NEGATIVE)

    def __post_init__(self) -> None:
        check_numbers(self)


def needs_a_lever(params: WalkerParams) -> None:
    """Refuse D = R = 0: an ankle motor has no lever on the floor.

    Raises:
        ValueError: such a foot.
    """
    require(
        params.foot_length > 0 or params.foot_radius > 0,
        "foot_length",
        "be positive for a powered walker with foot_radius = 0",
        params.foot_length,
        "pass control=None for a passive walker",
    )


#: Camp's ankle motor at constant voltage from a switch angle on.
MOTOR = Scheme("motor", POWERED_WALKER, Control, (ANGLE, STRENGTH), needs_a_lever)
