"""The walker as reinforcement-learning environments.

walker, vector: the environments; `sb3.py` beside this room adapts them to Stable-Baselines3.
registration: ids. arguments, setup, task: from constructor arguments to a checked task.
rewards, disturbances, levels: what a stride is worth, and what disturbs it; paths: a function
of one's own, written as text.
stepping, noise: compiled. show, gallery, recording: pictures.
"""

from typing import Any

from powered_walker_env.envs.arguments import TaskArguments
from powered_walker_env.envs.disturbances import Disturbance
from powered_walker_env.envs.registration import ENVIRONMENTS, make_walkers, register_walker
from powered_walker_env.envs.rewards import REWARDS
from powered_walker_env.envs.task import Task
from powered_walker_env.envs.vector import PoweredWalkerVectorEnv
from powered_walker_env.envs.walker import PoweredWalkerEnv

__all__ = [
    "ENVIRONMENTS",
    "REWARDS",
    "Disturbance",
    "PoweredWalkerEnv",
    "PoweredWalkerVectorEnv",
    "RecordWalk",
    "Task",
    "TaskArguments",
    "make_walkers",
    "register_walker",
]


def __getattr__(name: str) -> Any:
    """`RecordWalk` on demand: it draws, and what drawing needs takes its time."""
    if name == "RecordWalk":
        from powered_walker_env.envs.recording import RecordWalk

        return RecordWalk
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
