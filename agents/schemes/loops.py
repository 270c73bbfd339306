"""What feedback does to the multipliers: none, one number, the regulator."""

from __future__ import annotations

from typing import Any

from agents.schemes.measures import RATES, energies, pairs
from powered_walker_env import PRESETS, Gait, GaitNotFoundError, PoweredWalkerEnv, find_gait
from powered_walker_env.controllers import LQR, Controller, policy_of
from powered_walker_env.controllers.one_number import OneNumber
from powered_walker_env.envs.task import Task
from powered_walker_env.model.powering import AnyControl, Policy
from powered_walker_env.poincare import gait_sensitivity, largest_push, largest_step

#: Presets with a control to decide, powered in every way.
POWERED = tuple(name for name, each in PRESETS.items() if each.control is not None)


def feedback(preset_name: str) -> dict[str, Any]:
    """The closed loops of a preset's environment, by controller."""
    task = PoweredWalkerEnv(preset=preset_name).task
    one = OneNumber(task, "sensitivity")
    found = {
        "open loop": _loop(task.params, task.control, task),
        f"one number: {_plain(one.loop.number)} to {_plain(one.loop.action)}": _closed(task, one),
        "LQR": _closed(task, LQR(task)),
    }
    return {"legs": preset_name, "loops": found}


def _plain(name: str) -> str:
    return name.replace("_", " ")


def _closed(task: Task, controller: Controller) -> dict[str, Any]:
    return _loop(task.params, policy_of(task, controller), task)


def _loop(params: Any, control: AnyControl | Policy, task: Task) -> dict[str, Any]:
    try:
        gait = find_gait(params, control, task.gait[0].tolist())
    except GaitNotFoundError as problem:
        return {"reason": str(problem)}
    spent = energies(gait)
    return {
        "spectral_radius": gait.spectral_radius,
        "multipliers": pairs(gait.multipliers),
        **{name: spent[name] for name in ("mechanical", "electrical", "speed", "step_length")},
        **_survived(gait),
    }


def _survived(gait: Gait) -> dict[str, Any]:
    unit = dict.fromkeys(RATES, 1.0)
    pushed = largest_push(gait.params, gait.control, gait.state)
    stepped = largest_step(gait.params, gait.control, gait.state)
    return {
        "sensitivity_to_pushes": gait_sensitivity(gait, unit, unit).norm if gait.stable else None,
        "push": [pushed.down, pushed.up],
        "step": [stepped.down, stepped.up],
    }
