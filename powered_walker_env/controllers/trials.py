"""Trial walks: what is chosen by the strides it survives is chosen on walks no evaluation uses."""

from __future__ import annotations

from powered_walker_env.controllers.controller import Controller
from powered_walker_env.controllers.linear import push_of
from powered_walker_env.controllers.policies import TaskPolicy
from powered_walker_env.envs.task import Task
from powered_walker_env.poincare import StepNoise, disturbed_walks

STRIDES = 100  # of a walk at most, as of an episode
FEW, MANY = 200, 1000  # walks, of a first look and of a decision
FIRST_SEED, SECOND_SEED = 60_000, 60_001  # apart from those of episodes


def trial_strides(task: Task, controller: Controller, walks: int = MANY) -> float:
    """Mean strides of walks under the task's pushes (where it has none, those of "light")."""
    walked = disturbed_walks(
        task.params, TaskPolicy(task, controller), StepNoise(push=push_of(task)),
        task.gait[0].tolist(), strides=STRIDES, walks=walks,
        seed=FIRST_SEED if walks == FEW else SECOND_SEED,
    )  # fmt: skip
    return walked.mean[0]
