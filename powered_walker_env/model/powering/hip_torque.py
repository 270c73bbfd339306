"""A constant torque between the legs from heel strike until the hip closes to a switch angle.

It swings the free leg forward against the stance leg (McGeer 1989 drives level walking at
the hip; Kuo 2002 tunes the swing there).
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
from powered_walker_env.model.powering.scheme import ANGLE, STRENGTH, Scheme
from powered_walker_env.model.quantities import ANY, HIP_ANGLE, check_numbers, documented, quantity

#: The phases of a stride that a hip torque powers until the switch angle.
HIP_POWERED_WALKER: Cycle = (
    Phase(
        "pulled",
        Joints.ANKLE_LOCKED,
        Torque.HIP,
        (
            Exit(Guard.SWITCH_ANGLE, Reset.CONTINUE, "coasting"),
            Exit(Guard.LANDING, Reset.HEEL_STRIKE, Outcome.WALKED),
        ),
    ),
    Phase(
        "coasting",
        Joints.ANKLE_LOCKED,
        Torque.NONE,
        (Exit(Guard.LANDING, Reset.HEEL_STRIKE, Outcome.WALKED),),
    ),
)


@documented
@dataclass(frozen=True)
class HipTorque:
    """When the torque ends, and how strong it is.

    Raises:
        ValueError: a switch angle outside (0, 2π), or a torque that is not finite.
    """

    switch_angle: float = quantity("q3", "rad", "hip angle at which the torque ends", HIP_ANGLE)
    hip_torque: float = quantity("T", "N m", "hip torque, forward on the swing leg", ANY)

    def __post_init__(self) -> None:
        check_numbers(self)


#: A constant torque between the legs until a switch angle.
HIP = Scheme("hip-torque", HIP_POWERED_WALKER, HipTorque, (ANGLE, STRENGTH))
