"""Trained policies that come with the package: of each learner at each registered environment one.

They are the control study's (`python -m agents.study`): of the seeds of a learner the one with the
median return, in single precision, without code (`load_network`). `policies.json` beside them says
of each where and how it was trained, and what it scores.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from powered_walker_env.controllers.network import Network, load_network
from powered_walker_env.envs.arguments import TaskArguments
from powered_walker_env.envs.registration import ENVIRONMENTS, family
from powered_walker_env.envs.setup import make_task
from powered_walker_env.envs.task import Task

FOLDER = Path(__file__).parent / "trained"
DECLARED = "policies.json"
#: Learners by name: their labels in tables.
LEARNERS = {
    "ppo": "PPO",
    "apg": "analytic policy gradient",
    "ppo-default": "PPO, SB3's defaults",
    "sac": "SAC",
    "tqc": "TQC",
    "crossq": "CrossQ",
    "cmaes": "CMA-ES",
}


def policy_name(env_id: str, learner: str) -> str:
    """The name of a policy's file."""
    return f"{family(env_id)}-{learner}.npz"


def shipped_policies(folder: Path = FOLDER) -> dict[str, dict[str, Any]]:
    """What is declared to be there: of each file its training, and what it scores.

    Of each: `env_id`, `learner`, `seed` and `trained_strides`; of `episodes`, seeded from
    `episode_seed` on, `strides` and `return`, mean and 95 % interval; of the `first` each.
    """
    found: dict[str, dict[str, Any]] = json.loads((folder / DECLARED).read_text(encoding="utf-8"))
    return found


def shipped_learners(env_id: str | None = None) -> list[str]:
    """The learners of which a policy is shipped: for an environment, or for any."""
    there = shipped_policies().values()
    wanted = {each["learner"] for each in there if env_id in (None, each["env_id"])}
    return [name for name in LEARNERS if name in wanted]


def shipped_policy(learner: str, task: Task, env_id: str | None = None) -> Network:
    """The trained policy of a learner that comes with the package.

    Args:
        learner: of `LEARNERS`.
        task: of the environment that it will meet; it need not be disturbed as in training.
        env_id: its id; left out, or one without policies of its own, the environment is found by
            the task: that of the same walker, control and range of actions.

    Raises:
        ValueError: no such learner, none shipped for this task, or an environment whose actions
            are made another task by its arguments.
    """
    if learner not in LEARNERS:
        raise ValueError(f"learner must be one of {', '.join(LEARNERS)}, got {learner!r}")
    there = {each["env_id"]: name for name, each in shipped_policies().items()
             if each["learner"] == learner}  # fmt: skip
    asked = _short(env_id) if env_id else None
    home = asked if asked in ENVIRONMENTS else environment_of(task)
    if home not in there:
        raise ValueError(
            f"no trained {learner!r} comes with the package for {asked or 'this task'}, "
            f"{_known(learner, there)}; train one with agents.train and give its folder"
        )
    if reason := _differs(task, _task_of(home)):
        raise ValueError(
            f"the trained {learner!r} of {home} is for the environment as it is registered, but "
            f"for its disturbance and reward; got another {reason}: train one with agents.train, "
            f"or give the file {str(FOLDER / there[home])!r} to try it all the same"
        )
    return load_network(FOLDER / there[home])


def environment_of(task: Task) -> str | None:
    """The registered environment of the same walker, control and range of actions."""
    return next((each for each in ENVIRONMENTS if not _differs(task, _task_of(each))), None)


@cache
def _task_of(env_id: str) -> Task:
    return make_task(TaskArguments(preset=ENVIRONMENTS[env_id][0]))


def _differs(task: Task, known: Task) -> str:
    """What of a task is another's; "" if what a policy sees and does is the same."""
    if task.params != known.params:
        return "walker"
    if task.control != known.control:
        return "control"
    same = task.half_range.shape == known.half_range.shape
    if not same or not np.allclose(task.half_range, known.half_range):
        return f"range of actions, {task.half_range.tolist()}"
    return "" if np.allclose(task.gait[0], known.gait[0], atol=1e-6) else "gait"


def _known(learner: str, there: Mapping[str, str]) -> str:
    return f"only for {', '.join(there)}" if there else "nor for any other environment"


def _short(env_id: str) -> str:
    return env_id.rpartition(":")[2]
