"""Controllers of an environment as policies of its stride map: closed loops to analyse.

A controller speaks in observations and actions (`predict`, as Stable-Baselines3 has
it), the laboratory in post-strike states and controls. The adapter is the task's own
mapping: observation = clip((state − gait)/scale), control = nominal + clip(action)·range.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from powered_walker_env.controllers.controller import Controller, as_controller
from powered_walker_env.envs.task import OBSERVATION_LIMIT, Task
from powered_walker_env.simulation.differences import differences
from powered_walker_env.simulation.strides import Array

# Steps of fourth-order differences in observations, by the precision of the actions: about
# the fifth root of the rounding, where the rounding costs as much as the truncation.
SINGLE_STEP, DOUBLE_STEP = 0.03, 1e-3


@dataclass(frozen=True, eq=False)
class TaskPolicy:
    """A controller at a task, as the stride map takes it (see `poincare.Policy`)."""

    task: Task
    controller: Controller

    def __repr__(self) -> str:
        return f"TaskPolicy({self.scheme}, {type(self.controller).__name__})"

    @property
    def scheme(self) -> str:
        """What its numbers control, by name."""
        return self.task.scheme.name

    @property
    def on_section(self) -> bool:
        """Whether it sees a section's three numbers alone: as its controller says, if it does."""
        return bool(getattr(self.controller, "on_section", False))

    def __call__(self, states: Array) -> Array:
        """(N, k) numbers of the controls; of the motor: switch angles and stall torques."""
        actions = np.clip(self._actions(self._observations(states)), -1.0, 1.0)
        return np.asarray(self.task.nominal + actions * self.task.half_range, np.float64)

    def derivative(self, states: Array) -> Array:
        """(N, k, 4) of the controls by the states; zero where one of either is clipped."""
        observations = self._observations(states)
        seen = np.abs(observations) < OBSERVATION_LIMIT
        known = getattr(self.controller, "derivative", None)
        inner = self._differences(observations) if known is None else known(observations)
        free = np.abs(self._actions(observations)) < 1.0
        outer = self.task.half_range[:, np.newaxis] / self.task.scale
        found = inner * outer * free[:, :, np.newaxis] * seen[:, np.newaxis]
        return np.asarray(found, np.float64)

    def _observations(self, states: Array) -> Array:
        deviation = (states - self.task.gait[0]) / self.task.scale
        return np.clip(deviation, -OBSERVATION_LIMIT, OBSERVATION_LIMIT)

    def _actions(self, observations: Array) -> Array:
        actions, memory = self.controller.predict(observations, deterministic=True)
        if memory is not None:
            raise ValueError(
                "controller must have no memory: the stride map's state is the walker's alone, "
                f"got a controller with state {type(memory).__name__}"
            )
        found = np.asarray(actions)
        wanted = (len(observations), len(self.task.nominal))
        if found.shape != wanted:
            raise ValueError(
                f"controller must return actions of shape {wanted} for "
                f"observations {observations.shape}, got {found.shape}"
            )
        return found

    def _differences(self, observations: Array) -> Array:
        single = self._actions(observations[:1]).dtype != np.float64
        step = SINGLE_STEP if single else DOUBLE_STEP
        return differences(self._actions, observations, step)


def policy_of(env: Any, controller: Any) -> TaskPolicy:
    """The policy that a controller is at an environment's walker, without disturbances.

    Args:
        env: an environment of this package, wrapped or not, a vector environment, or
            a `Task`. A wrapper that changes observations or actions is not seen: the
            controller must take what the environment itself gives.
        controller: with `predict(observations, deterministic=True)`, or a function from
            observations to actions; for networks of single precision see
            `controllers.stable_baselines.double_precision`.

    Raises:
        TypeError: an environment without a task, no controller.
    """
    task = env if isinstance(env, Task) else getattr(getattr(env, "unwrapped", env), "task", None)
    if not isinstance(task, Task):
        raise TypeError(f"env must be an environment of this package or its Task, got {env!r}")
    return TaskPolicy(task, as_controller(controller))
