"""The schemes by name: those of this package, and those registered from outside.

A scheme of one's own is a frozen dataclass of numbers, a list of phases, and one call:

    @dataclass(frozen=True)
    class Pull:
        pull: float = quantity("T", "N m", "torque between the legs", ANY)

    register_scheme(Scheme("pull", PHASES, Pull, columns=(STRENGTH,)))

Strides, gaits, policies and environments then take it by that name or by its control. In a
process of its own (a worker, a script) the module that registers it must be imported first.
"""

from __future__ import annotations

import dataclasses

from powered_walker_env.model.checks import one_of
from powered_walker_env.model.knees import encode
from powered_walker_env.model.powering.hip_torque import HIP
from powered_walker_env.model.powering.motor import MOTOR
from powered_walker_env.model.powering.passive import PASSIVE
from powered_walker_env.model.powering.scheme import ANGLE, STRENGTH, Scheme
from powered_walker_env.model.powering.stopped_motor import STOPPED_MOTOR
from powered_walker_env.model.powering.toe_off import LATE_TOE_OFF, TOE_OFF, TOE_OFF_AT_STRIKE

#: By name.
SCHEMES: dict[str, Scheme] = {}
#: By the type of the control; None is the passive walker's.
BY_CONTROL: dict[type | None, Scheme] = {}
#: Every control number's column in the kernel's row.
CONTROL_NUMBERS: dict[str, int] = {}


def register_scheme(scheme: Scheme) -> Scheme:
    """Make a way to power a walker known by its name and by its control.

    The same definition may be registered again (a module reloaded, a cell run twice).

    Returns:
        The scheme.

    Raises:
        ValueError: a name, control or number that is taken; columns that do not fit the
            control's numbers; phases that cannot be encoded.
        TypeError: a control that is no frozen dataclass.
    """
    _check_control(scheme)
    if not scheme.cycle:
        raise ValueError(f"cycle must have at least one phase, got {scheme.cycle!r}")
    encode(scheme.cycle)
    for taken in (SCHEMES.get(scheme.name), BY_CONTROL.get(scheme.control)):
        if taken is not None and not _same_definition(taken, scheme):
            raise ValueError(
                f"scheme must have a name and a control of its own, got {scheme.name!r} with "
                f"{_name_of(scheme.control)}; scheme {taken.name!r} has {_name_of(taken.control)}"
            )
    columns = dict(zip(scheme.numbers, scheme.columns, strict=True))
    for name, column in columns.items():
        if CONTROL_NUMBERS.get(name, column) != column:
            raise ValueError(
                f"scheme {scheme.name!r} must not call its {('angle', 'strength')[column]} "
                f"{name!r}, which is another scheme's {('angle', 'strength')[1 - column]}"
            )
    CONTROL_NUMBERS.update(columns)
    SCHEMES[scheme.name] = BY_CONTROL[scheme.control] = scheme
    return scheme


def _check_control(scheme: Scheme) -> None:
    kind = scheme.control
    frozen = getattr(getattr(kind, "__dataclass_params__", None), "frozen", False)
    if kind is not None and not frozen:
        raise TypeError(f"control must be a frozen dataclass of numbers, or None, got {kind!r}")
    fields = () if kind is None else dataclasses.fields(kind)
    columns = scheme.columns
    if len(columns) != len(fields) or not set(columns) <= {ANGLE, STRENGTH}:
        raise ValueError(
            f"columns must say ANGLE or STRENGTH for each of the control's {len(fields)} numbers, "
            f"got {columns!r}"
        )
    if len(set(columns)) != len(columns):
        raise ValueError(f"columns must differ, got {columns!r}; a stride has one of each")


def _same_definition(one: Scheme, other: Scheme) -> bool:
    return one.name == other.name and _name_of(one.control) == _name_of(other.control)


def _name_of(kind: type | None) -> str:
    return "no control" if kind is None else f"{kind.__module__}.{kind.__qualname__}"


def scheme_named(name: str) -> Scheme:
    """The scheme of that name.

    Raises:
        ValueError: no such scheme; the message lists them.
    """
    return one_of("scheme", name, SCHEMES)


for _scheme in (MOTOR, STOPPED_MOTOR, TOE_OFF, TOE_OFF_AT_STRIKE, LATE_TOE_OFF, HIP, PASSIVE):
    register_scheme(_scheme)
