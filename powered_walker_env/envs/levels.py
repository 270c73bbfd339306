"""Disturbances by name: "none", "light", "medium" or "rough", each kind's sizes for each walker.

A level of one kind is named "light" (pushes), "light-ground", "rough-torque" and so on. The
pushes are given; the other kinds are as hard *for the open loop* as the pushes of the same
level: the geometric mean of 1 + the strides survived is the same, within a third ("medium",
between the two, is the geometric mean of light and rough). Of slope and parameters, which are
drawn once per episode, some draws lie so near the nominal walker that it walks all 100 strides,
so the plain mean is larger there. Sensor noise does not touch the open loop: it is as large as
the push in units of the observation (root mean square over the two rates).

For a controller the kinds differ widely: one that feels a disturbance may bear it far better
than the pushes, or worse. Strides of 100 survived, in the mean of 1000 episodes, by the open
loop, and under sensor noise by a linear regulator (LQR; under the pushes its typical walk has
30 / 9 / 3, 70 / 12 / 4, 24 / 7 / 3 and, with knees, 27 / 9 / 4 strides), as `python -m
agents.severity` measures them, under light / medium / rough:

                 camp1997            round feet          as published        with knees
    push         11.7 / 5.7 / 3.5    9.2 / 4.3 / 2.5     18.8 / 8.1 / 4.1    10.8 / 5.4 / 3.1
    ground       9.7 / 4.3 / 2.7     8.4 / 3.6 / 2.3     17.0 / 6.4 / 3.5    9.6 / 4.6 / 2.8
    slope        38.6 / 25.1 / 16.9  38.6 / 28.6 / 20.5  37.5 / 25.6 / 16.5  30.7 / 21.8 / 13.4
    torque       10.9 / 4.3 / 2.8    8.9 / 3.6 / 2.3     20.4 / 9.1 / 5.3    9.9 / 4.1 / 2.7
    sensor, LQR  33.3 / 10.3 / 4.7   9.2 / 5.4 / 4.2     100 / 100 / 100     38.4 / 13.9 / 7.4
    parameters   32.1 / 18.2 / 8.4   30.8 / 18.3 / 12.2  39.3 / 29.0 / 22.7  30.7 / 20.4 / 13.1

Of the presets with other schemes, "motor-with-stop" takes the levels of camp1997, which are as
hard for it. "hip-torque" bears any torque noise and parameters: the pushes are harder.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

from powered_walker_env.envs.disturbances import KINDS, Disturbance
from powered_walker_env.model.walker import WalkerParams

if TYPE_CHECKING:
    from powered_walker_env.envs.task import Task

LEVELS = ("none", "light", "medium", "rough")

#: (light, medium, rough) of every kind for each preset; all other places read them here.
SIZES: dict[str, dict[str, tuple[float, float, float]]] = {
    "camp1997": {
        "push": (0.005, 0.007, 0.01),
        "ground": (0.00019, 0.00034, 0.00061),
        "slope": (0.0039, 0.0062, 0.01),
        "torque": (0.005, 0.01, 0.02),
        "sensor": (0.026, 0.037, 0.053),
        "parameters": (0.015, 0.031, 0.064),
    },
    "camp1997-as-published": {
        "push": (0.02, 0.028, 0.04),
        "ground": (0.0022, 0.0037, 0.0061),
        "slope": (0.0089, 0.015, 0.025),
        "torque": (0.11, 0.14, 0.17),
        "sensor": (0.11, 0.15, 0.21),
        "parameters": (0.12, 0.155, 0.2),
    },
    "round-foot": {
        "push": (0.02, 0.032, 0.05),
        "ground": (0.0031, 0.0081, 0.021),
        "slope": (0.039, 0.056, 0.081),
        "torque": (0.046, 0.096, 0.2),
        "sensor": (0.11, 0.17, 0.26),
        "parameters": (0.13, 0.19, 0.27),
    },
    "kneed": {
        "push": (0.025, 0.035, 0.05),
        "ground": (0.0024, 0.004, 0.0067),
        "slope": (0.027, 0.041, 0.063),
        "torque": (0.31, 0.55, 0.98),
        "sensor": (0.13, 0.19, 0.27),
        "parameters": (0.27, 0.36, 0.49),
    },
    "toe-off": {
        "push": (0.008, 0.0106, 0.014),
        "ground": (0.0014, 0.0022, 0.0036),
        "slope": (0.021, 0.026, 0.033),
        "torque": (0.37, 0.58, 0.92),
        "sensor": (0.13, 0.17, 0.23),
        "parameters": (0.43, 0.64, 0.95),
    },
    "hip-torque": {
        "push": (0.02, 0.0245, 0.03),
        "ground": (0.002, 0.003, 0.0045),
        "slope": (0.052, 0.072, 0.099),
        "torque": (0.5, 0.71, 1.0),
        "sensor": (0.33, 0.41, 0.5),
        "parameters": (0.5, 0.71, 1.0),
    },
}
KEY_PUSHES = 3  # standard deviations of a push by a key
_REFERENCE = "camp1997"  # whose levels other walkers take
_REFERENCE_RATE = math.sqrt(10.0)  # rad/s, its √(g/L)


def disturbance_of(
    choice: str | Mapping[str, float] | Disturbance, preset: str | None, params: WalkerParams
) -> Disturbance:
    """The disturbance that a constructor argument means for a walker.

    Args:
        choice: "none", "light", "medium", "rough", a level with a kind ("light-ground"), or
            standard deviations by kind.
        preset: the walker's preset, whose levels apply. A walker without levels of its
            own takes those of camp1997, the push in proportion to √(g/L); the other
            kinds have no unit of time.
        params: the walker.

    Raises:
        ValueError: an unknown level or kind, or a bad deviation.
    """
    if isinstance(choice, Disturbance):
        return choice
    if isinstance(choice, str):
        return _named(choice, preset, params)
    if isinstance(choice, Mapping):
        unknown = [kind for kind in choice if kind not in KINDS]
        if unknown:
            raise ValueError(f"disturbance kinds are {', '.join(KINDS)}, got {unknown[0]!r}")
        return Disturbance(**choice)
    raise ValueError(
        f"disturbance must be a level ({', '.join(LEVELS)}) or a mapping of kinds to standard "
        f"deviations, got {choice!r}"
    )


def _named(choice: str, preset: str | None, params: WalkerParams) -> Disturbance:
    level, _, kind = choice.partition("-")
    kind = kind or "push"
    if level not in LEVELS or kind not in KINDS:
        raise ValueError(
            f"disturbance must be one of {', '.join(LEVELS)}, or such a level with a kind of "
            f"{', '.join(KINDS)} as in 'light-ground', got {choice!r}"
        )
    if level == "none":
        return Disturbance()
    size = SIZES.get(preset or "", SIZES[_REFERENCE])[kind][LEVELS.index(level) - 1]
    if preset not in SIZES and kind == "push":
        size *= math.sqrt(params.gravity / params.leg_length) / _REFERENCE_RATE
    return Disturbance(**{kind: size})


def key_push(task: Task) -> float:
    """rad/s: what a key of the window pushes, KEY_PUSHES standard deviations of the task's pushes.

    Where it has none, those of "light".
    """
    usual = task.disturbance.push or disturbance_of("light", None, task.params).push
    return KEY_PUSHES * usual
