"""The linear-quadratic regulator of an environment's gait: the baseline of every learner."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from powered_walker_env.controllers.linear import LinearFeedback, nominal_gait
from powered_walker_env.envs.task import Task
from powered_walker_env.model.presets import PRESETS
from powered_walker_env.model.state import natural_units
from powered_walker_env.poincare.regulator import Weights, regulate
from powered_walker_env.simulation.strides import Array


class Costs(NamedTuple):
    """Weights of the squared observation (4) and of the squared action (k, or one for all)."""

    state: Sequence[float]
    action: float | Sequence[float]


#: Of the presets, found by `python -m agents.tune_lqr`. The stance leg counts: it carries the
#: walker, the swing leg comes out of each stride anew. With knees it is the swing rate.
TUNED = {
    "round-foot": Costs((0.4, 0.001, 1.0, 0.013), (0.0013, 0.013)),
    "camp1997": Costs((0.25, 0.032, 1.0, 0.0025), (0.001, 0.4)),
    "camp1997-as-published": Costs((0.36, 0.0011, 1.0, 0.49), (570.0, 7.6)),
    "kneed": Costs((0.0012, 0.0012, 0.025, 1.0), (0.001, 0.0018)),
}
UNTUNED = Costs((1.0, 0.0, 1.0, 0.0), 0.03)


class LQR(LinearFeedback):
    """Actions −K x that minimise Σ x'Qx + a'Ra over the strides to come, clipped to ±1.

    x is the observation (the deviation from the gait over its scale) and a the action (1 is
    the full range); the stride map is linearised at the gait (`poincare.regulate`).

    Args:
        task: of the environment (`env.unwrapped.task`).
        state_cost: Q: a number, the diagonal (4), or a matrix (4, 4); left out, as tuned
            for the walker.
        action_cost: R: a number, the diagonal (k), or a matrix (k, k), positive definite.

    Raises:
        ValueError: a gait of more than one stride, or weights that will not do.
    """

    def __init__(
        self, task: Task, state_cost: Weights | None = None, action_cost: Weights | None = None
    ) -> None:
        gait = nominal_gait(task, "LQR")
        tuned = tuned_costs(task)
        self.state_cost = tuned.state if state_cost is None else state_cost
        self.action_cost = tuned.action if action_cost is None else action_cost
        cost = np.asarray(self.state_cost, np.float64)
        units = natural_units(task.params) / task.scale
        if cost.shape in ((), (1,), (4,), (4, 4)):  # of others the regulator says what is wrong
            cost = cost * (np.outer(units, units) if cost.ndim == 2 else units**2)
        found = regulate(gait, task.half_range.tolist(), self.action_cost, cost)
        super().__init__(-found.gain * task.scale / task.half_range[:, np.newaxis])
        #: (4, 4): the cost of all strides to come is about x'Px.
        self.P: Array = found.cost * np.outer(task.scale, task.scale)
        self.Q: Array = _matrix(self.state_cost, 4)  # (4, 4)
        self.R: Array = _matrix(self.action_cost, len(task.nominal))  # (k, k)


def _matrix(weights: Weights, size: int) -> Array:
    """Weights that are known to be good, as a matrix."""
    given = np.asarray(weights, np.float64)
    return given if given.ndim == 2 else np.diag(np.broadcast_to(given, (size,)))


def tuned_costs(task: Task) -> Costs:
    """The weights for a task's walker; `UNTUNED` for one that is no preset's."""
    for name, costs in TUNED.items():
        if PRESETS[name].params == task.params and np.size(costs.action) == len(task.nominal):
            return costs
    return UNTUNED
