"""A controller's episode as a trajectory, and several of them as one animation."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from powered_walker_env import PostStrikeState, Trajectory, walk
from powered_walker_env.controllers import Controller
from powered_walker_env.controllers.evaluation import walkers_of
from powered_walker_env.envs.task import Task
from powered_walker_env.model.mechanics.packing import params_of
from powered_walker_env.simulation.trajectory import TrajectoryBuilder, log_stride

SAMPLE_INTERVAL = 0.01  # s


def record(
    controller: Controller, env_id: str, seed: int, strides: int, **env_kwargs: Any
) -> Trajectory:
    """Walk the episode of that seed again, with all its disturbances, and sample it in time.

    Args:
        controller: gives deterministic actions, as in `evaluate`.
        strides: how many at most; it ends earlier if the walker falls.
    """
    envs, _ = walkers_of(env_id, 1, **env_kwargs)
    observation, _ = envs.reset(seed=seed)
    walkers, scheme = envs.walkers, envs.task.scheme
    builder = TrajectoryBuilder(params_of(walkers.row(0)), _state(walkers.states[0]))
    memory, fresh = None, np.ones(1, np.bool_)
    for _ in range(strides):
        start, params = _state(walkers.states[0]), params_of(walkers.row(0))
        actions, memory = controller.predict(observation, memory, fresh, deterministic=True)
        result = walkers.step(np.asarray(actions, np.float64))
        height = float(walkers.heights[0])
        control = scheme.of_numbers(walkers.controls[0])
        logged = log_stride(start, control, params, height, walkers.rtol, SAMPLE_INTERVAL)
        builder.add(logged, scheme.cycle, height)
        observation, fresh = result.observation, np.zeros(1, np.bool_)
        if result.terminated[0]:
            break
    return builder.build()


def nominal_stride(task: Task) -> Trajectory:
    """One stride of the undisturbed gait."""
    return walk(task.gait[0].tolist(), task.control, task.params, 1, sample_interval=0.005)


def _state(row: NDArray[np.float64]) -> PostStrikeState:
    return PostStrikeState(*row.tolist())
