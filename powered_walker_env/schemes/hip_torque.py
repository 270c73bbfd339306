"""A constant torque between the legs from heel strike until the hip closes to a switch angle.

It swings the free leg forward against the stance leg (McGeer 1989 drives level walking at
the hip; Kuo 2002 tunes the swing there).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from powered_walker_env.params import real_number, require
from powered_walker_env.phases import Cycle, Exit, Guard, Joints, Outcome, Phase, Reset, Torque
from powered_walker_env.schemes.scheme import ANGLE, STRENGTH, Scheme

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


@dataclass(frozen=True)
class HipTorque:
    """When the torque ends, and how strong it is.

    Raises:
        ValueError: a switch angle outside (0, 2π), or a torque that is not finite.
    """

    switch_angle: float  # q3 at which the torque ends, rad, in (0, 2 pi)
    hip_torque: float  # N m, forward on the swing leg

    def __post_init__(self) -> None:
        object.__setattr__(self, "switch_angle", real_number("switch_angle", self.switch_angle))
        object.__setattr__(self, "hip_torque", real_number("hip_torque", self.hip_torque))
        require(
            0 < self.switch_angle < 2 * math.pi,
            "switch_angle",
            "lie in (0, 2*pi)",
            self.switch_angle,
            "angles are radians",
        )


HIP = Scheme("hip-torque", HIP_POWERED_WALKER, HipTorque, (ANGLE, STRENGTH), positive=False)
