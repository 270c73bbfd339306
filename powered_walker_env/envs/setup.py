"""From constructor arguments, all of them JSON-able, to a checked `Task`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from powered_walker_env.envs.arguments import TaskArguments
from powered_walker_env.envs.levels import disturbance_of
from powered_walker_env.envs.task import Task
from powered_walker_env.model.powering import (
    ANGLE,
    MOTOR,
    PASSIVE,
    SCHEMES,
    AnyControl,
    Scheme,
    check_walkable,
    scheme_named,
    scheme_of,
)
from powered_walker_env.model.presets import PRESETS, preset
from powered_walker_env.model.state import check_state
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.gaits import GaitNotFoundError, find_gait
from powered_walker_env.simulation.strides import Array

#: Action ranges of the motor: rad of switch angle, and fraction of the stall torque.
ACTION_RANGES = {
    "camp1997": (0.15, 0.03),
    "camp1997-as-published": (0.45, 0.09),
    "round-foot": (0.2, 0.3),
    "kneed": (0.1, 0.3),
}
#: Of the other schemes: rad of an angle, and fraction of the strength's absolute value.
ANGLE_RANGE, STRENGTH_RANGE = 0.15, 0.3
DEFAULT_PRESET = "camp1997"


class _Walker(NamedTuple):
    """What the arguments of an environment say of its walker."""

    preset: str | None
    params: WalkerParams
    control: AnyControl
    gait: Array


def make_task(arguments: TaskArguments) -> Task:
    """The task that the arguments of an environment describe.

    Raises:
        ValueError: contradicting arguments, or one out of its domain.
        TypeError: params with a field that does not exist, a control that is none.
        GaitNotFoundError: no gait given, and none found.
    """
    params, control, gait = arguments.params, arguments.control, arguments.gait
    if params is not None and arguments.preset is not None:
        raise ValueError(
            f"preset and params exclude each other, got preset {arguments.preset!r} and params; "
            "pass preset=None with params (the registered ids set a preset)"
        )
    named = None if arguments.scheme is None else _powered(scheme_named(arguments.scheme))
    if params is None:
        walker = _from_preset(arguments.preset or _first_preset(named), named, control, gait)
    else:
        given = params if isinstance(params, WalkerParams) else WalkerParams.from_dict({**params})
        walker = _from_params(given, named, control, gait)
    powered, reach = scheme_of(walker.control), arguments.action_range
    if reach is None:
        reach = default_range(powered, walker.preset)
    return Task(
        params=walker.params,
        control=walker.control,
        gait=walker.gait,
        action_range=_numbers("action_range", reach, powered),
        disturbance=disturbance_of(arguments.disturbance, walker.preset, walker.params),
        reward=arguments.reward,  # checked by the task
        effort_weight=_number("effort_weight", arguments.effort_weight),
    )


def default_range(powered: Scheme, preset_name: str | None) -> tuple[float, ...]:
    """What action 1 adds where nothing is said: rad of an angle, fraction of a strength."""
    if powered is MOTOR:
        return ACTION_RANGES.get(preset_name or "", ACTION_RANGES[DEFAULT_PRESET])
    return tuple(ANGLE_RANGE if c == ANGLE else STRENGTH_RANGE for c in powered.columns)


def _powered(named: Scheme) -> Scheme:
    if named is PASSIVE:
        powered = ", ".join(name for name in SCHEMES if name != PASSIVE.name)
        raise ValueError(
            f"scheme must power the walker, got {named.name!r}, which leaves nothing to decide; "
            f"choose one of {powered}"
        )
    return named


def _presets_of(powered: Scheme) -> list[str]:
    return [name for name, known in PRESETS.items() if scheme_of(known.control) is powered]


def _first_preset(named: Scheme | None) -> str:
    """The walker where neither preset nor params are given."""
    if named is None or named is MOTOR:
        return DEFAULT_PRESET
    names = _presets_of(named)
    if not names:
        raise ValueError(f"params and control must be given: no preset has scheme {named.name!r}")
    return names[0]


def _from_preset(
    name: str,
    named: Scheme | None,
    control: AnyControl | Sequence[float] | None,
    gait: Sequence[Any] | None,
) -> _Walker:
    chosen = preset(name)
    if chosen.control is None:
        powered = ", ".join(n for n, known in PRESETS.items() if known.control is not None)
        raise ValueError(
            f"preset must be a powered walker, got {name!r}, which has no motor and so nothing "
            f"to decide; choose one of {powered}"
        )
    own = scheme_of(chosen.control)
    if named is not None and named is not own:
        others = ", ".join(_presets_of(named)) or "none"
        raise ValueError(
            f"scheme must be {own.name!r} or left out for preset {name!r}, got {named.name!r}; "
            f"give params and control instead of the preset, or one with this scheme: {others}"
        )
    given = _control(control, own, f"preset {name!r}")
    if given is None and gait is None:
        return _Walker(name, chosen.params, chosen.control, np.array([chosen.state]))
    nominal = given or chosen.control
    return _Walker(name, chosen.params, nominal, _gait(chosen.params, nominal, gait))


def _from_params(
    params: WalkerParams,
    named: Scheme | None,
    control: AnyControl | Sequence[float] | None,
    gait: Sequence[Any] | None,
) -> _Walker:
    powered = named
    if named is None:
        plain = control is None or isinstance(control, (Sequence, np.ndarray))
        powered = MOTOR if plain else _powered(scheme_of(control))
    assert powered is not None
    given = _control(control, powered, f"scheme {powered.name!r}")
    if given is not None:
        return _Walker(None, params, given, _gait(params, given, gait))
    if gait is not None:
        raise ValueError("control must be given with params and gait: a gait belongs to a control")
    return _with_known_control(params, powered)


def _with_known_control(params: WalkerParams, powered: Scheme) -> _Walker:
    """The walker under the first control of a preset that it has a gait with."""
    reasons = []
    for name in _presets_of(powered):
        known = PRESETS[name].control
        assert known is not None
        try:
            return _Walker(None, params, known, _gait(params, known, None))
        except GaitNotFoundError as error:
            reasons.append(str(error))
    raise GaitNotFoundError(
        f"no gait found under the control of any preset with scheme {powered.name!r}; give "
        f"control (and gait): {reasons[0] if reasons else 'there is no such preset'}"
    )


def _gait(params: WalkerParams, control: AnyControl, gait: Sequence[Any] | None) -> Array:
    """The cycle's post-strike states, given (one state or several) or found."""
    check_walkable(params, control)
    if gait is None:
        return find_gait(params, control).states
    try:
        points = np.atleast_2d(np.asarray(gait, dtype=np.float64))
    except (TypeError, ValueError):
        points = np.empty(0)
    if points.ndim != 2 or not points.size:
        raise ValueError(f"gait must be one post-strike state or a list of them, got {gait!r}")
    return np.array([check_state(point) for point in points])


def _control(
    control: AnyControl | Sequence[float] | None, powered: Scheme, whose: str
) -> AnyControl | None:
    """The control given, as an object of the scheme; None if none is given."""
    if control is None:
        return None
    if isinstance(control, (Sequence, np.ndarray)) or not hasattr(control, "__dataclass_fields__"):
        chosen: AnyControl = powered.of_numbers(_numbers("control", control, powered))
        return chosen
    if scheme_of(control) is not powered:
        kind = getattr(powered.control, "__name__", None)
        raise ValueError(
            f"control must be a {kind} or its numbers for {whose}, got {control!r}; "
            "for another scheme give params, the control and no preset"
        )
    return control


def _numbers(name: str, values: Any, powered: Scheme) -> tuple[float, ...]:
    count = len(powered.numbers)
    given = tuple(values) if isinstance(values, (Sequence, np.ndarray)) else ()
    if isinstance(values, str) or len(given) != count:
        need = {1: "one number", 2: "two numbers"}.get(count, f"{count} numbers")
        raise ValueError(
            f"{name} must be {need}, got {values!r}; the control is {', '.join(powered.numbers)}"
        )
    return tuple(_number(name, value) for value in given)


def _number(name: str, value: Any) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        raise ValueError(f"{name} must be a number, got {value!r}") from None
