"""The open loop at its best: the constant control that feels pushes least.

What mechanics alone can do. Judged by the gait sensitivity norm (Hobbelen and Wisse 2007) of the
gait that belongs to each control: the observations, in their units, by the pushes on both leg
rates. The gait is followed from the environment's own through the action bounds.

The norm is that of the linear map. How far the true one may be left before it falls it does not
know, so that it need not rank controls as their walks do: `criterion="strides"` asks trial walks,
which begin where the environment's episodes do.

The observations go on counting from the environment's gait, not from the new one: the reward
"deviation" may fall where the strides survived rise.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from powered_walker_env.controllers.controller import FunctionController
from powered_walker_env.controllers.following import (
    POINTS,
    Search,
    gait_near,
    gaits_within,
    norm_of,
)
from powered_walker_env.controllers.linear import linearise, nominal_gait
from powered_walker_env.controllers.trials import FEW, MANY, trial_strides
from powered_walker_env.envs.task import Task
from powered_walker_env.poincare.gaits import Gait
from powered_walker_env.simulation.strides import Array

CRITERIA = ("sensitivity", "strides")
FINALISTS = 5  # nodes of the grid that are looked at again: searched from, or walked more often
EVALUATIONS = 200  # of the search from each, at most
AGAIN = 0.01  # of its simplex, of a second search from the best


class TunedControl(NamedTuple):
    """The best constant control."""

    action: Array  # (k,) in [-1, 1]
    gait: Gait  # under it
    sensitivity: float  # gait sensitivity norm
    nominal_sensitivity: float  # of the environment's own control


class TunedOpenLoop:
    """The best constant action, whatever happens.

    Args:
        task: of the environment.
        criterion: "sensitivity", the least gait sensitivity norm, or "strides", the most in
            trial walks.

    Raises:
        ValueError: an unknown criterion, a gait of several strides.
    """

    on_section = True  # whatever is seen

    def __init__(self, task: Task, criterion: str = "sensitivity") -> None:
        #: What was found: action, gait, norm.
        self.tuned: TunedControl = tune_control(task, criterion)

    def predict(self, observation: Any, *_: Any, deterministic: bool = True) -> tuple[Array, None]:
        """The same actions."""
        return _constant(self.tuned.action, np.shape(observation)[:-1]), None

    def derivative(self, observations: Array) -> Array:
        """(N, k, 4) zeros."""
        return np.zeros((len(observations), len(self.tuned.action), 4))


def tune_control(task: Task, criterion: str = "sensitivity") -> TunedControl:
    """The best constant control within the action bounds, of those with a stable gait.

    Args:
        task: of the environment.
        criterion: as `TunedOpenLoop` has it.

    Raises:
        ValueError: an unknown criterion, a gait of several strides.
    """
    if criterion not in CRITERIA:
        raise ValueError(f"criterion must be one of {', '.join(CRITERIA)}, got {criterion!r}")
    start, linear = nominal_gait(task, "the tuned open loop"), linearise(task)

    def follow(action: Array, near: Gait) -> Gait | None:
        return gait_near(task.params, task.control_of(action), near)

    def judge(gait: Gait) -> float:
        return norm_of(task, linear, gait)

    nodes = gaits_within(len(task.nominal), start, follow)
    if criterion == "strides":
        stable = [node for node in nodes if node[1].stable]
        order = sorted(stable, key=lambda node: -_strides(task, node[0], FEW))[:FINALISTS]
        action, gait = max(order, key=lambda node: _strides(task, node[0], MANY))
        return TunedControl(action, gait, judge(gait), judge(start))
    size = np.full(len(task.nominal), 2.0 / (POINTS - 1))
    order = sorted(nodes, key=lambda node: judge(node[1]))[:FINALISTS]
    searches = [Search(follow, judge, node) for node in order]
    for search in searches:
        search.run(size, EVALUATIONS)
    best = min(searches, key=lambda search: search.least)
    best.run(-AGAIN * size, EVALUATIONS)  # one laid flat on a bound saw nothing beside it
    return TunedControl(best.x, best.gait, best.least, judge(start))


def _constant(action: Array, shape: tuple[int, ...]) -> Array:
    return np.broadcast_to(action, (*shape, len(action))).copy()


def _strides(task: Task, action: Array, walks: int) -> float:
    controller = FunctionController(lambda seen: _constant(action, (len(seen),)))
    return trial_strides(task, controller, walks)
