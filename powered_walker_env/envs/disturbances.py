"""Disturbances: what the walker meets besides its own dynamics, by kind and by level.

Every kind is a standard deviation of independent normal draws. A level of one kind is
named "light" or "rough" (pushes), or "light-ground", "rough-torque" and so on. The
levels of the other kinds are as hard for the open loop as the pushes of the same level:
the geometric mean of 1 + the strides survived is the same. Of slope and parameters,
which are drawn once per episode, some draws (29 to 38 %, light; 6 to 20 %, rough) lie so
near the nominal walker that it walks all 100 strides, so the plain mean is larger there.
Sensor noise does not touch the open loop: it is as large as the push in units of the
observation (root mean square over the two rates). A linear regulator, which does feel it,
bears it far better than the pushes with point feet and worse with round feet.

`python -m agents.severity` measures this table (strides of 100 that the open loop
survives, in the mean of 1000 episodes), `--find` finds the levels anew:

    light        camp1997        as published    round feet
    push         0.005   11.7    0.02    18.8    0.02     9.2
    ground       0.00019  9.7    0.0022  17.1    0.0031   8.4
    slope        0.0039  38.7    0.0089  37.4    0.039   38.6
    torque       0.005   10.9    0.11    20.4    0.046    8.9
    sensor       0.026           0.11            0.11
    parameters   0.015   32.3    0.12    39.5    0.13    30.8

    rough        camp1997        as published    round feet
    push         0.01     3.5    0.04     4.1    0.05     2.5
    ground       0.00061  2.7    0.0061   3.5    0.021    2.3
    slope        0.01    16.9    0.025   16.5    0.081   20.5
    torque       0.02     2.8    0.17     5.3    0.2      2.3
    sensor       0.053           0.21            0.26
    parameters   0.064    8.4    0.2     22.7    0.27    12.2

Of the presets with other schemes (400 episodes each), "motor-with-stop" takes the levels
of camp1997, which are as hard for it. Under light and rough pushes "toe-off" survives 6.5
and 3.2 strides, "hip-torque" 11.2 and 4.3; the other kinds go with those, but for the
torque noise and the parameters of "hip-torque", which bears any.
"""

from __future__ import annotations

import dataclasses
import math
import numbers
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.simulation.strides import Array

# Columns of the normal draws of a stride.
PUSH, GROUND, TORQUE, SENSOR = slice(0, 2), 2, 3, slice(4, 8)
STEP_DRAWS = 8
EPISODE_DRAWS = 6  # normal draws of an episode: slope 1, parameters 4, one to spare
SPREAD_FIELDS = ("foot_length", "leg_mass", "leg_inertia", "no_load_speed")
STEEPEST = 1.5  # rad, of a slope drawn: short of a wall


@dataclass(frozen=True, kw_only=True)
class Disturbance:
    """Standard deviations of each kind; 0 is none.

    Raises:
        ValueError: a deviation that is negative or not finite.
    """

    push: float = 0.0  # rad/s, on both leg rates after every heel strike
    ground: float = 0.0  # leg lengths, height of the ground at every landing about its mean
    slope: float = 0.0  # rad, of the floor, drawn once per episode
    torque: float = 0.0  # fraction of the control's strength, as stall torque, at every stride
    sensor: float = 0.0  # observation units, on all four numbers at every observation
    parameters: float = 0.0  # fraction of foot length, mass, inertia and motor speed, per episode

    def __post_init__(self) -> None:
        for kind in KINDS:
            value = getattr(self, kind)
            number = isinstance(value, numbers.Real) and not isinstance(value, bool)
            if not (number and 0 <= value < math.inf):
                raise ValueError(
                    f"disturbance {kind} must be a standard deviation, finite and >= 0, "
                    f"got {value!r}"
                )
            object.__setattr__(self, kind, float(value))

    def sizes(self, params: WalkerParams) -> Array:
        """(STEP_DRAWS,) standard deviations of the draws of a stride, SI units."""
        push, sensor = [self.push] * 2, [self.sensor] * 4
        return np.array([*push, self.ground * params.leg_length, self.torque, *sensor])


KINDS = tuple(field.name for field in dataclasses.fields(Disturbance))
LEVELS = ("none", "light", "rough")

# (light, rough) for each preset.
_LEVELS: dict[str, dict[str, tuple[float, float]]] = {
    "camp1997": {
        "push": (0.005, 0.01),
        "ground": (0.00019, 0.00061),
        "slope": (0.0039, 0.01),
        "torque": (0.005, 0.02),
        "sensor": (0.026, 0.053),
        "parameters": (0.015, 0.064),
    },
    "camp1997-as-published": {
        "push": (0.02, 0.04),
        "ground": (0.0022, 0.0061),
        "slope": (0.0089, 0.025),
        "torque": (0.11, 0.17),
        "sensor": (0.11, 0.21),
        "parameters": (0.12, 0.2),
    },
    "round-foot": {
        "push": (0.02, 0.05),
        "ground": (0.0031, 0.021),
        "slope": (0.039, 0.081),
        "torque": (0.046, 0.2),
        "sensor": (0.11, 0.26),
        "parameters": (0.13, 0.27),
    },
    "toe-off": {
        "push": (0.008, 0.014),
        "ground": (0.0014, 0.0036),
        "slope": (0.021, 0.033),
        "torque": (0.37, 0.92),
        "sensor": (0.13, 0.23),
        "parameters": (0.43, 0.95),
    },
    "hip-torque": {
        "push": (0.02, 0.03),
        "ground": (0.002, 0.0045),
        "slope": (0.052, 0.099),
        "torque": (0.5, 1.0),
        "sensor": (0.33, 0.5),
        "parameters": (0.5, 1.0),
    },
}
_REFERENCE = "camp1997"  # whose levels other walkers take
_REFERENCE_RATE = math.sqrt(10.0)  # rad/s, its √(g/L)


def disturbance_of(
    choice: str | Mapping[str, float] | Disturbance, preset: str | None, params: WalkerParams
) -> Disturbance:
    """The disturbance that a constructor argument means for a walker.

    Args:
        choice: "none", "light", "rough", a level with a kind ("light-ground"), or
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
    size = _LEVELS.get(preset or "", _LEVELS[_REFERENCE])[kind][LEVELS.index(level) - 1]
    if preset not in _LEVELS and kind == "push":
        size *= math.sqrt(params.gravity / params.leg_length) / _REFERENCE_RATE
    return Disturbance(**{kind: size})


def episode_params(params: WalkerParams, disturbance: Disturbance, draws: Array) -> WalkerParams:
    """The walker of one episode: slope and parameter spread applied.

    Args:
        draws: (EPISODE_DRAWS,) standard normal numbers.
    """
    changes: dict[str, Any] = {}
    if disturbance.slope > 0:
        slope = params.slope + disturbance.slope * draws[0]
        changes["slope"] = float(np.clip(slope, -STEEPEST, STEEPEST))
    if disturbance.parameters > 0:
        factors = np.exp(disturbance.parameters * draws[1:5])  # stays positive
        for field, factor in zip(SPREAD_FIELDS, factors.tolist(), strict=True):
            changes[field] = getattr(params, field) * factor
    return params.replace(**changes) if changes else params
