"""How long controllers walk, on equal disturbances, with confidence intervals.

Episode i of every controller has the same seed, so all meet the same pushes; they differ
by what they make of them. Strides survived are the measure: a return depends on how much
an environment pays for merely walking.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import gymnasium as gym
import numpy as np
from gymnasium.wrappers import OrderEnforcing, PassiveEnvChecker, TimeLimit
from numpy.typing import NDArray

from powered_walker_env.controllers.controller import Controller, as_controller
from powered_walker_env.controllers.estimates import Estimate, mean_estimate
from powered_walker_env.envs.registration import make_walkers
from powered_walker_env.envs.task import Task
from powered_walker_env.envs.vector import PoweredWalkerVectorEnv
from powered_walker_env.envs.walker import PoweredWalkerEnv
from powered_walker_env.model.phases import Outcome

#: The first seed of evaluations: the small ones are those of trainings.
EPISODE_SEED = 10_000
WALKED = int(Outcome.WALKED)
_HARMLESS = (OrderEnforcing, PassiveEnvChecker, TimeLimit)  # wrappers of `gym.make`


@dataclass(frozen=True, eq=False)
class Evaluation:
    """What became of a controller's episodes, seeded `seed`, `seed + 1`, ..."""

    env_id: str
    env_kwargs: Mapping[str, Any]
    disturbance: Mapping[str, float]  # standard deviations by kind, those that are not 0
    seed: int
    limit: int  # strides after which an episode is over
    strides: NDArray[np.int64]  # (episodes,) strides completed
    returns: NDArray[np.float64]  # (episodes,)
    outcomes: NDArray[np.int64]  # (episodes,) `Outcome` of the last stride

    @property
    def mean_strides(self) -> Estimate:
        """Strides survived, with the interval over episodes."""
        return mean_estimate(self.strides)

    @property
    def mean_return(self) -> Estimate:
        """The return, with the interval over episodes."""
        return mean_estimate(self.returns)

    @property
    def survived(self) -> int:
        """Episodes that lasted to the limit."""
        return int((self.outcomes == WALKED).sum())

    def ends(self) -> dict[str, int]:
        """How the episodes ended, by the outcome's label, the most frequent first."""
        kinds, counts = np.unique(self.outcomes, return_counts=True)
        order = np.argsort(-counts, kind="stable")
        return {Outcome(int(kinds[i])).label: int(counts[i]) for i in order}


def evaluate(
    controller: Any,
    env: str | gym.Env[Any, Any],
    episodes: int = 100,
    seed: int = EPISODE_SEED,
    **env_kwargs: Any,
) -> Evaluation:
    """Let a controller walk episodes, all at once; episode i has the seed `seed + i`.

    Args:
        controller: anything with SB3's `predict`, asked for deterministic actions, or a
            function from (N, 4) observations to (N, k) actions.
        env: an id of this package, one of your own, or an environment; with the
            disturbance it is registered with.
        **env_kwargs: arguments of the environment, with an id.

    Raises:
        TypeError: no controller.
        ValueError: an environment that does not exist or is not of this package; actions
            of a wrong shape or not finite.
    """
    asked = as_controller(controller)
    if not isinstance(episodes, int | np.integer) or episodes < 1:
        raise ValueError(f"episodes must be a positive integer, got {episodes!r}")
    envs, name = walkers_of(env, int(episodes), **env_kwargs)
    limit = _limit_of(envs, f"environment {name!r}")
    walked = walk_episodes(asked, envs, seed)
    met = {kind: size for kind, size in dataclasses.asdict(envs.task.disturbance).items() if size}
    return Evaluation(name, dict(env_kwargs), met, seed, limit, *walked)


class Episodes(NamedTuple):
    """What N episodes came to, (N,) each."""

    strides: NDArray[np.int64]  # walked
    returns: NDArray[np.float64]
    outcomes: NDArray[np.int64]  # of the last stride


def walk_episodes(
    controller: Controller, envs: PoweredWalkerVectorEnv, seed: int | Sequence[int | None]
) -> Episodes:
    """One episode of every walker, to its fall or its limit.

    Args:
        envs: with a limit of steps; walkers that fell neither draw nor move.
        seed: of walker 0, the others following; or one for each.

    Raises:
        ValueError: no limit; actions of a wrong shape or not finite.
    """
    limit = _limit_of(envs, "envs")
    observation, _ = envs.reset(seed=seed)
    count = envs.num_envs
    memory, fresh = None, np.ones(count, np.bool_)
    strides, returns = np.zeros(count, np.int64), np.zeros(count)
    outcomes = np.full(count, WALKED)
    going = np.ones(count, np.bool_)
    for _ in range(limit):
        actions, memory = controller.predict(observation, memory, fresh, deterministic=True)
        wanted = _checked(actions, envs.action_space.shape)
        result = envs.walkers.step(wanted, None if going.all() else going)
        observation = result.observation
        strides += going & ~result.terminated
        returns[going] += result.reward[going]
        outcomes[going] = result.info["outcome"][going]
        going &= ~result.terminated
        fresh = np.zeros(count, np.bool_)
        if not going.any():
            break
    return Episodes(strides, returns, outcomes)


def _limit_of(envs: PoweredWalkerVectorEnv, name: str) -> int:
    if envs.max_episode_steps is None:
        raise ValueError(f"{name} must have max_episode_steps, or episodes never end")
    return envs.max_episode_steps


def _checked(actions: Any, shape: tuple[int, ...] | None) -> NDArray[np.float64]:
    checked = np.asarray(actions, np.float64)
    if checked.shape != shape or not np.isfinite(checked).all():
        raise ValueError(
            f"a controller must give {shape} finite actions, got shape {checked.shape}"
        )
    return checked


def walkers_of(
    env: str | gym.Env[Any, Any], count: int, **env_kwargs: Any
) -> tuple[PoweredWalkerVectorEnv, str]:
    """N walkers of an environment of this package, and its name.

    Args:
        env: an id, registered with a vector entry point or without, or an environment.
        count: N.
        **env_kwargs: arguments of the environment, with an id.

    Raises:
        ValueError: an unknown id, arguments that it does not take, another package's
            environment, or one whose class or wrappers change what a step does.
    """
    if isinstance(env, str):
        try:
            return make_walkers(env, count, **env_kwargs), env
        except (TypeError, ValueError, ImportError, gym.error.Error) as error:
            given = env_kwargs or "no arguments"
            raise ValueError(f"environment {env!r} with {given}: {error}") from error
    walker, wrapped = env.unwrapped, env
    name = env.spec.id if env.spec else type(walker).__name__
    if env_kwargs:
        raise ValueError(f"arguments go with an id, got an environment and {env_kwargs}")
    while isinstance(wrapped, gym.Wrapper):
        if type(wrapped) not in _HARMLESS:
            raise ValueError(
                f"env must have no wrapper, got {type(wrapped).__name__} around {name}"
            )
        wrapped = wrapped.env
    if type(walker) is not PoweredWalkerEnv:
        raise ValueError(f"env must be a PoweredWalkerEnv itself, or the id of one, got {env!r}")
    # The fields of a task are arguments of an environment with exactly this task.
    task = {field.name: getattr(walker.task, field.name) for field in dataclasses.fields(Task)}
    limit = env.spec.max_episode_steps if env.spec else None
    return PoweredWalkerVectorEnv(count, max_episode_steps=limit, **task), name


def task_of(env: str | gym.Env[Any, Any], **env_kwargs: Any) -> Task:
    """What an environment asks of its walker.

    Raises:
        ValueError: as `walkers_of`.
    """
    return walkers_of(env, 1, **env_kwargs)[0].task
