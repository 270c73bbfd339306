"""From constructor arguments, all of them JSON-able, to a checked `Task`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from powered_walker_env.envs.disturbances import Disturbance, disturbance_of
from powered_walker_env.envs.task import Task
from powered_walker_env.params import Control, WalkerParams, check_state
from powered_walker_env.poincare.gaits import GaitNotFoundError, find_gait
from powered_walker_env.presets import PRESETS, preset
from powered_walker_env.schemes import check_walkable
from powered_walker_env.stride import Array

#: Action ranges: rad of switch angle, and fraction of the stall torque.
ACTION_RANGES = {
    "camp1997": (0.15, 0.03),
    "camp1997-as-published": (0.15, 0.03),
    "round-foot": (0.2, 0.3),
}
DEFAULT_PRESET = "camp1997"


def make_task(
    preset_name: str | None,
    params: WalkerParams | Mapping[str, Any] | None,
    control: Control | Sequence[float] | None,
    gait: Sequence[Any] | None,
    action_range: Sequence[float] | None,
    reward: str,
    effort_weight: float,
    disturbance: str | Mapping[str, float] | Disturbance,
) -> Task:
    """The task that the arguments of an environment describe.

    Raises:
        ValueError: contradicting arguments, or one out of its domain.
        TypeError: params with a field that does not exist.
        GaitNotFoundError: no gait given, and none found.
    """
    if params is not None and preset_name is not None:
        raise ValueError(
            f"preset and params exclude each other, got preset {preset_name!r} and params; "
            "pass preset=None with params (the registered ids set a preset)"
        )
    given = _control(control)
    if params is None:
        name = DEFAULT_PRESET if preset_name is None else preset_name
        walker, nominal, cycle = _from_preset(name, given, gait)
    else:
        name = None
        walker = params if isinstance(params, WalkerParams) else WalkerParams.from_dict({**params})
        nominal, cycle = _from_params(walker, given, gait)
    if action_range is None:
        action_range = ACTION_RANGES.get(name or "", ACTION_RANGES[DEFAULT_PRESET])
    return Task(
        params=walker,
        control=nominal,
        gait=cycle,
        action_range=_pair("action_range", action_range),
        disturbance=disturbance_of(disturbance, name, walker),
        reward=reward,
        effort_weight=_number("effort_weight", effort_weight),
    )


def _from_preset(
    name: str, control: Control | None, gait: Sequence[Any] | None
) -> tuple[WalkerParams, Control, Array]:
    chosen = preset(name)
    if chosen.control is None:
        powered = ", ".join(n for n, known in PRESETS.items() if known.control is not None)
        raise ValueError(
            f"preset must be a powered walker, got {name!r}, which has no motor and so nothing "
            f"to decide; choose one of {powered}"
        )
    if control is None and gait is None:
        return chosen.params, chosen.control, np.array([chosen.state])
    nominal = control or chosen.control
    return chosen.params, nominal, _gait(chosen.params, nominal, gait)


def _from_params(
    params: WalkerParams, control: Control | None, gait: Sequence[Any] | None
) -> tuple[Control, Array]:
    if control is not None:
        return control, _gait(params, control, gait)
    if gait is not None:
        raise ValueError("control must be given with params and gait: a gait belongs to a control")
    reasons = []
    for known in PRESETS.values():
        if known.control is None:
            continue
        try:
            return known.control, _gait(params, known.control, None)
        except GaitNotFoundError as error:
            reasons.append(str(error))
    raise GaitNotFoundError(
        f"no gait found under the control of any preset; give control (and gait): {reasons[0]}"
    )


def _gait(params: WalkerParams, control: Control, gait: Sequence[Any] | None) -> Array:
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


def _control(control: Control | Sequence[float] | None) -> Control | None:
    if control is None or isinstance(control, Control):
        return control
    return Control(*_pair("control", control))


def _pair(name: str, values: Any) -> tuple[float, float]:
    numbers = tuple(values) if isinstance(values, (Sequence, np.ndarray)) else ()
    if isinstance(values, str) or len(numbers) != 2:
        raise ValueError(f"{name} must be two numbers, got {values!r}")
    return _number(name, numbers[0]), _number(name, numbers[1])


def _number(name: str, value: Any) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        raise ValueError(f"{name} must be a number, got {value!r}") from None
