"""The best that any controller can do at an environment, as a controller: a table of controls.

Found by dynamic programming on the walker's section (`poincare.optimum`), for an environment
whose walker is pushed, or driven with noise, at every step and seen as it is. Sensor noise, a
slope or a walker that differs from episode to episode, and ground whose height is drawn at every
landing leave more to know than three numbers: for these it is no optimum, and is refused.

Tables of the registered environments come with the package (`SHIPPED`), each with its error and
what its policy walks; `python -m agents.optimum` makes them, and others.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from powered_walker_env.envs.task import Task
from powered_walker_env.poincare import Optimum, StepNoise, find_gait, optimum
from powered_walker_env.poincare.stochastic.rollout import LookAhead
from powered_walker_env.poincare.stochastic.steps import Progress, Reward
from powered_walker_env.poincare.stochastic.tables import TablePolicy
from powered_walker_env.results import load_result
from powered_walker_env.simulation.strides import Array

FOLDER = Path(__file__).parent / "optima"
#: The tables that come with the package.
SHIPPED = tuple(sorted(path.name for path in FOLDER.glob("*.npz")))
STRIDES = 100  # of an episode
OPTIMUM_NAME, BEST_KNOWN_NAME = "optimum", "best known"  # in tables
HINT = "make a table with python -m agents.optimum --env ID --out FILE.npz and give the file"


class Optimal:
    """Controls out of an optimum's table, linear between its nodes.

    Where the values fall off steeply between the nodes (`looks_ahead` of the optimum) they are
    the best of some by one exact stride and the table's values after it: two milliseconds a
    decision, or 0.4 in a large batch.

    Args:
        task: of the environment (`env.unwrapped.task`).
        found: the optimum of this task; left out, the one that is shipped for it.

    Raises:
        ValueError: a task without a shipped table, or the optimum of another task.
    """

    def __init__(self, task: Task, found: Optimum | None = None) -> None:
        self.found = _shipped(task) if found is None else found
        if reason := _differs(self.found, task):
            raise ValueError(
                f"found must be the optimum of this task, got one with {reason}; {HINT}"
            )
        #: Of states, whole: observations are clipped.
        self.policy: TablePolicy | LookAhead = self.found.policy(
            deviation_of(task) if self.found.rewarded else None
        )
        self._gait, self._scale = task.gait[0], task.scale
        self._nominal, self._half_range = task.nominal, task.half_range

    @property
    def name(self) -> str:
        """In tables: whether it is the optimum, or the best that is known."""
        return OPTIMUM_NAME if self.found.resolved else BEST_KNOWN_NAME

    def predict(self, observation: Any, *_: Any, deterministic: bool = True) -> tuple[Array, None]:
        """The best actions, as far as the observations are not clipped."""
        seen = np.atleast_2d(np.asarray(observation, np.float64))
        controls = self.policy(self._gait + seen * self._scale)
        actions = (controls - self._nominal) / self._half_range
        return actions.reshape(*np.shape(observation)[:-1], -1), None


def find_optimum(
    task: Task, *, objective: str = "return", progress: Progress | None = None, **settings: Any
) -> Optimum:
    """The optimum of an environment's task.

    Args:
        task: of the environment.
        objective: "return" (of the reward "deviation", without effort), or "strides".
        **settings: of `poincare.optimum`.

    Raises:
        ValueError: a disturbance or a reward whose optimum is not on the section; a gait of
            several strides.
    """
    noise = noise_of(task)
    if objective not in ("return", "strides"):
        raise ValueError(f"objective must be 'return' or 'strides', got {objective!r}")
    known = task.reward == "deviation" and task.effort_weight == 0.0
    if objective == "return" and not known:
        raise ValueError(
            "task must have the reward 'deviation' and no effort_weight for the greatest return, "
            f"got {task.reward!r} and {task.effort_weight!r}; ask for objective='strides'"
        )
    if len(task.gait) != 1:
        raise ValueError(f"task must have a gait of one stride, got one of {len(task.gait)}")
    gait = find_gait(task.params, task.control, task.gait[0].tolist())
    return optimum(
        gait, task.half_range.tolist(), noise, progress=progress,
        reward=deviation_of(task) if objective == "return" else None,
        **{"horizon": STRIDES, **settings},
    )  # fmt: skip


def deviation_of(task: Task) -> Reward:
    """The reward "deviation" of a task, of post-strike states (N, 4)."""

    def deviation(states: Array) -> Array:
        away = (states - task.gait[0]) / task.scale
        worth: Array = np.exp(-0.5 * np.einsum("ij,ij->i", away, away))
        return worth

    return deviation


def noise_of(task: Task) -> StepNoise:
    """The disturbance of a task as the noise of a step.

    Raises:
        ValueError: kinds that leave more to know than the section's three numbers, or none.
    """
    kinds = vars(task.disturbance)
    beyond = [kind for kind in ("ground", "slope", "sensor", "parameters") if kinds[kind] > 0]
    if beyond:
        raise ValueError(
            f"disturbance must be pushes or torque noise for an optimum on the section, got "
            f"{', '.join(beyond)}: there a decision depends on more than the state that is known"
        )
    noise = StepNoise(push=task.disturbance.push, strength=task.disturbance.torque)
    if noise == StepNoise():
        raise ValueError("disturbance must not be none: without one the open loop walks for ever")
    return noise


def _differs(found: Optimum, task: Task) -> str:
    """What an optimum was found for, if it is another task than this; "" if it is not."""
    gait, half = found.gait, 0.5 * (found.high - found.low)
    if gait.params != task.params or gait.control != task.control:
        return f"another walker or control: {gait.control!r}"
    if half.shape != task.half_range.shape or not np.allclose(half, task.half_range):
        return f"the action ranges {half.tolist()}"
    try:
        noise = noise_of(task)
    except ValueError as error:
        return f"{found.noise}, and {error}"
    return "" if found.noise == noise else f"the disturbance {found.noise}, not {noise}"


@cache
def _table(name: str) -> Optimum:
    found: Optimum = load_result(FOLDER / name)
    return found


def _shipped(task: Task) -> Optimum:
    for name in SHIPPED:
        if not _differs(_table(name), task):
            return _table(name)
    noise_of(task)
    raise ValueError(f"the optimum of this task does not come with the package: {HINT}")
