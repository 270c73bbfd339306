"""The simplest feedback: one observed number to one action.

Which number, which action, which gain? Each of the 4k pairs is judged by three criteria:

- "radius": the closed loop's spectral radius. It says nothing of how far a push carries the walker
  before it dies out, and picks gains under which round feet fall sooner than without feedback;
- "sensitivity": the gait sensitivity norm under the pushes. It does, as long as the map is linear
  and actions stay in bounds: on round feet it finds the pair that walks best;
- "strides": trial walks of the true map with clipped actions. Where pushes leave the linear range
  (with knees) only these tell, so the controller is chosen by them.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import scipy.optimize

from powered_walker_env.controllers.linear import LinearFeedback, LinearMap, linearise
from powered_walker_env.controllers.trials import FEW, MANY, trial_strides
from powered_walker_env.envs.task import Task
from powered_walker_env.model.state import PostStrikeState
from powered_walker_env.simulation.strides import Array

CRITERIA = ("radius", "sensitivity", "strides")
LEAST, MOST = 0.01, 100.0  # gains looked at: actions per observation
FINE, COARSE = 121, 17  # of each sign, for criteria that cost nothing, and for walks
FINALISTS = 4  # gains of a pair that are walked again, more often


class OneNumberLoop(NamedTuple):
    """One pair at its best gain."""

    number: str  # observed, by the name of the state
    action: str  # by the name of the control's number
    gain: float  # action = −gain · observation; 0 where no feedback is best
    spectral_radius: float
    sensitivity: float  # gait sensitivity norm by the task's pushes, observation units
    strides: float  # mean of trial walks of 100 strides


class OneNumber(LinearFeedback):
    """One observed number to one action, the pair and the gain that walk longest in trials.

    Args:
        task: of the environment.
        criterion: one of `CRITERIA`.

    Raises:
        ValueError: an unknown criterion, a gait of several strides, no pair that is stable.
    """

    def __init__(self, task: Task, criterion: str = "strides") -> None:
        table = one_number_table(task, criterion)
        stable = [row for row in table if math.isfinite(row.sensitivity)]
        if not stable:
            raise ValueError("no feedback of one number to one action makes this gait stable")
        #: The pair chosen.
        self.loop: OneNumberLoop = min(stable, key=_keys(criterion))
        super().__init__(_gain(task, self.loop.number, self.loop.action, self.loop.gain))


def one_number_table(task: Task, criterion: str = "sensitivity") -> list[OneNumberLoop]:
    """All 4k pairs, each at the gain that is best by one criterion.

    Raises:
        ValueError: an unknown criterion, a gait of several strides.
    """
    if criterion not in CRITERIA:
        raise ValueError(f"criterion must be one of {', '.join(CRITERIA)}, got {criterion!r}")
    linear = linearise(task)
    return [
        _best(task, linear, criterion, number, action)
        for action in task.scheme.numbers
        for number in PostStrikeState._fields
    ]


def _keys(criterion: str) -> Callable[[OneNumberLoop], float]:
    return {
        "radius": lambda row: row.spectral_radius,
        "sensitivity": lambda row: row.sensitivity,
        "strides": lambda row: -row.strides,
    }[criterion]


def _gain(task: Task, number: str, action: str, value: float) -> Array:
    gain = np.zeros((len(task.nominal), 4))
    gain[task.scheme.numbers.index(action), PostStrikeState._fields.index(number)] = value
    return gain


def _best(
    task: Task, linear: LinearMap, criterion: str, number: str, action: str
) -> OneNumberLoop:  # fmt: skip
    def gain(value: float) -> Array:
        return _gain(task, number, action, value)

    def strides(value: float, walks: int = MANY) -> float:
        return trial_strides(task, LinearFeedback(gain(value)), walks)

    if criterion == "strides":
        stable = [value for value in _gains(COARSE) if linear.spectral_radius(gain(value)) < 1.0]
        order = sorted(stable, key=lambda value: -strides(value, FEW))[:FINALISTS]
        value = max(order, key=strides, default=0.0)
    elif criterion == "radius":
        value = _least(lambda value: linear.spectral_radius(gain(value)))
    else:
        value = _least(lambda value: linear.sensitivity(gain(value)))
    return OneNumberLoop(
        number, action, value, linear.spectral_radius(gain(value)),
        linear.sensitivity(gain(value)), strides(value),
    )  # fmt: skip


def _gains(each: int) -> list[float]:
    sizes = np.geomspace(LEAST, MOST, each)
    return [*(-sizes[::-1]).tolist(), 0.0, *sizes.tolist()]


def _least(judge: Callable[[float], float]) -> float:
    """The gain of least judgement: the best of a fine scan, polished between its neighbours."""
    gains = _gains(FINE)
    found = [judge(value) for value in gains]
    i = int(np.argmin(found))
    if not math.isfinite(found[i]):
        return 0.0
    low, high = gains[max(i - 1, 0)], gains[min(i + 1, len(gains) - 1)]
    polished = scipy.optimize.minimize_scalar(
        judge, bounds=(low, high), method="bounded", options={"xatol": 1e-9 * (high - low)}
    )
    return float(polished.x) if polished.fun < found[i] else gains[i]
