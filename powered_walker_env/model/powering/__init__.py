"""Ways to power a walker, one module each: its phases, and the numbers that control it.

A new scheme is a new module here and its name in `SCHEMES`; strides, gaits and
environments take it by that name or by its control's type.
"""

from __future__ import annotations

from typing import Any

from powered_walker_env.model.checks import require
from powered_walker_env.model.powering.hip_torque import HIP, HIP_POWERED_WALKER, HipTorque
from powered_walker_env.model.powering.motor import MOTOR, POWERED_WALKER, Control
from powered_walker_env.model.powering.passive import PASSIVE, PASSIVE_WALKER
from powered_walker_env.model.powering.scheme import ANGLE, NO_SWITCH, STRENGTH, Scheme
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
from powered_walker_env.model.walker import WalkerParams

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
    "HipTorque",
    "LateToeOff",
    "Scheme",
    "StoppedControl",
    "ToeOff",
    "ToeOffAtStrike",
    "check_walkable",
    "scheme",
    "scheme_of",
]

AnyControl = Control | ToeOff | HipTorque  # and their subclasses

#: By name.
SCHEMES: dict[str, Scheme] = {
    each.name: each
    for each in (MOTOR, STOPPED_MOTOR, TOE_OFF, TOE_OFF_AT_STRIKE, LATE_TOE_OFF, HIP, PASSIVE)
}
_BY_CONTROL = {each.control: each for each in SCHEMES.values()}

#: Every control number's column in the kernel's row.
CONTROL_NUMBERS: dict[str, int] = {
    name: column
    for each in SCHEMES.values()
    for name, column in zip(each.numbers, each.columns, strict=True)
}


def scheme(name: str) -> Scheme:
    """The scheme of that name.

    Raises:
        ValueError: no such scheme; the message lists them.
    """
    if name not in SCHEMES:
        raise ValueError(f"scheme must be one of {', '.join(SCHEMES)}, got {name!r}")
    return SCHEMES[name]


def scheme_of(control: Any) -> Scheme:
    """The scheme that a control belongs to; None is a passive walker.

    Raises:
        TypeError: something that is no control.
    """
    kind = None if control is None else type(control)
    if kind not in _BY_CONTROL:
        known = ", ".join(each.__name__ for each in _BY_CONTROL if each is not None)
        raise TypeError(
            f"control must be one of {known}, or None for a passive walker, got {control!r}"
        )
    return _BY_CONTROL[kind]


def check_walkable(params: WalkerParams, control: AnyControl | None) -> None:
    """Reject a walker that the control cannot power.

    Raises:
        ValueError: an ankle motor on D = R = 0, whose foot has no lever on the floor; a
            push-off from a massless foot that is not a point.
        TypeError: an argument of the wrong type.
    """
    if not isinstance(params, WalkerParams):
        raise TypeError(f"params must be a WalkerParams, got {params!r}")
    scheme_of(control)
    pointed = params.foot_length == 0 and params.foot_radius == 0
    require(
        not (isinstance(control, Control) and pointed),
        "foot_length",
        "be positive for a powered walker with foot_radius = 0",
        params.foot_length,
        "pass control=None for a passive walker",
    )
    require(
        not isinstance(control, ToeOff) or pointed or not params.massless_foot,
        "leg_inertia",
        "be positive for a push-off from a foot that is not a point",
        params.leg_inertia,
        "the impulse would turn a massless leg infinitely fast",
    )
