"""Ways to power a walker, one module each: its phases, and the numbers that control it.

- what is a scheme, and which are there? `scheme`, `schemes` (`register_scheme` for one's own);
- the schemes themselves: `motor`, `stopped_motor`, `toe_off`, `hip_torque`, `passive`;
- who decides the numbers, stride by stride? `policy`.
"""

from powered_walker_env.model.powering.hip_torque import HIP, HIP_POWERED_WALKER, HipTorque
from powered_walker_env.model.powering.motor import MOTOR, POWERED_WALKER, Control
from powered_walker_env.model.powering.passive import PASSIVE, PASSIVE_WALKER
from powered_walker_env.model.powering.policy import (
    AnyControl,
    FunctionPolicy,
    Policy,
    as_policy,
    check_walkable,
    decides_on_section,
    numbers_for,
    scheme_of,
)
from powered_walker_env.model.powering.scheme import ANGLE, NO_SWITCH, STRENGTH, Scheme
from powered_walker_env.model.powering.schemes import (
    CONTROL_NUMBERS,
    SCHEMES,
    register_scheme,
    scheme_named,
)
from powered_walker_env.model.powering.stopped_motor import (
    STOPPED_MOTOR,
    STOPPED_WALKER,
    StoppedControl,
)
from powered_walker_env.model.powering.toe_off import (
    LATE_TOE_OFF,
    TOE_OFF,
    TOE_OFF_AT_STRIKE,
    LateToeOff,
    ToeOff,
    ToeOffAtStrike,
)

__all__ = [
    "ANGLE",
    "CONTROL_NUMBERS",
    "HIP",
    "HIP_POWERED_WALKER",
    "LATE_TOE_OFF",
    "MOTOR",
    "NO_SWITCH",
    "PASSIVE",
    "PASSIVE_WALKER",
    "POWERED_WALKER",
    "SCHEMES",
    "STOPPED_MOTOR",
    "STOPPED_WALKER",
    "STRENGTH",
    "TOE_OFF",
    "TOE_OFF_AT_STRIKE",
    "AnyControl",
    "Control",
    "FunctionPolicy",
    "HipTorque",
    "LateToeOff",
    "Policy",
    "Scheme",
    "StoppedControl",
    "ToeOff",
    "ToeOffAtStrike",
    "as_policy",
    "check_walkable",
    "decides_on_section",
    "numbers_for",
    "register_scheme",
    "scheme_named",
    "scheme_of",
]
