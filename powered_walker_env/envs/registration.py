"""The environments' ids. Any change that affects learning is a new version."""

from __future__ import annotations

import copy
import importlib
import re
from typing import TYPE_CHECKING, Any

import gymnasium as gym
from gymnasium.envs.registration import load_env_creator

if TYPE_CHECKING:
    from powered_walker_env.envs.vector import PoweredWalkerVectorEnv

MAX_EPISODE_STEPS = 100  # strides
SINGLE = "powered_walker_env.envs.walker:PoweredWalkerEnv"
VECTOR = "powered_walker_env.envs.vector:PoweredWalkerVectorEnv"
#: Environment id to (preset, mean return of 100 episodes that counts as solved). It is 0.9 of the
#: optimum's return (`controllers/optima/`).
ENVIRONMENTS: dict[str, tuple[str, float]] = {
    "PoweredWalker-v0": ("camp1997", 53.4),
    "PoweredWalkerRoundFoot-v0": ("round-foot", 88.0),
    "PoweredWalkerAsPublished-v1": ("camp1997-as-published", 20.8),
    "PoweredWalkerKneed-v0": ("kneed", 82.0),
}
#: Older versions, registered so that results can be repeated: id to what it registers, threshold
#: and the arguments that keep it what it was.
PREVIOUS: dict[str, tuple[float, dict[str, Any]]] = {
    "PoweredWalkerAsPublished-v0": (
        11.4, {"preset": "camp1997-as-published", "action_range": [0.15, 0.03]}
    ),
}  # fmt: skip


def register_environments() -> None:
    """Register the environments with Gymnasium; again does nothing."""
    current = {name: (threshold, {"preset": preset})
               for name, (preset, threshold) in ENVIRONMENTS.items()}  # fmt: skip
    for name, (threshold, arguments) in {**PREVIOUS, **current}.items():
        if name not in gym.registry:
            _register(name, MAX_EPISODE_STEPS, threshold, arguments)


def family(env_id: str) -> str:
    """The name of an id without its module and version."""
    return re.sub(r"-v\d+$", "", env_id.rpartition(":")[2])


def register_walker(
    env_id: str,
    *,
    max_episode_steps: int | None = MAX_EPISODE_STEPS,
    reward_threshold: float | None = None,
    **arguments: Any,
) -> None:
    """Register a walker under an id of one's own, single and in batches.

    `gym.make`, `gym.make_vec` and `PoweredWalkerVecEnv` take it then. The arguments are tried
    at once: where the gait is not given, it is searched here.

    Args:
        env_id: as in "MyWalker-v0".
        max_episode_steps: strides until truncation; None for no limit.
        reward_threshold: mean return that counts as solved.
        **arguments: of `PoweredWalkerEnv` (its docstring has the table); objects become JSON.

    Raises:
        ValueError: an id that is taken, an argument out of its domain, or one that JSON
            cannot hold; TypeError: an argument that does not exist.
        GaitNotFoundError: parameters without a gait, and none found.
    """
    from powered_walker_env.envs.arguments import TaskArguments
    from powered_walker_env.envs.setup import make_task

    if env_id in gym.registry:
        raise ValueError(f"env_id must be new, got {env_id!r}, which is registered already")
    given = TaskArguments.of(arguments)
    plain = given.to_dict()
    make_task(given)
    _register(env_id, max_episode_steps, reward_threshold, plain)


def make_walkers(env_id: str, num_envs: int, **arguments: Any) -> PoweredWalkerVectorEnv:
    """N walkers of a registered environment of this package, in one native batch.

    An id registered without a vector entry point, by a plain `gym.register`, will do.

    Args:
        env_id: as in "PoweredWalker-v0" or "my_package:MyWalker-v0".
        num_envs: how many.
        **arguments: of `PoweredWalkerVectorEnv`, over those registered.

    Raises:
        ValueError: an environment of another class, or arguments that it does not take.
        gymnasium.error.Error: an id that is not registered; ImportError: its module.
    """
    from powered_walker_env.envs.vector import PoweredWalkerVectorEnv
    from powered_walker_env.envs.walker import PoweredWalkerEnv

    module, _, name = env_id.rpartition(":")
    if module:
        importlib.import_module(module)
    spec = copy.deepcopy(gym.spec(name))
    entry = spec.entry_point
    if spec.vector_entry_point is None and entry is not None:
        maker = load_env_creator(entry) if isinstance(entry, str) else entry
        if maker is PoweredWalkerEnv:
            spec.vector_entry_point = VECTOR
    try:
        envs = gym.make_vec(spec, num_envs, vectorization_mode="vector_entry_point", **arguments)
    except (TypeError, gym.error.Error) as error:
        raise ValueError(
            f"env_id must name an environment of this package that takes {arguments}, "
            f"got {env_id!r}: {error}"
        ) from error
    if not isinstance(envs.unwrapped, PoweredWalkerVectorEnv):
        raise ValueError(f"env_id must name an environment of this package, got {env_id!r}")
    return envs.unwrapped


def _register(
    env_id: str, steps: int | None, threshold: float | None, kwargs: dict[str, Any]
) -> None:
    gym.register(
        id=env_id,
        entry_point=SINGLE,
        vector_entry_point=VECTOR,
        max_episode_steps=steps,
        reward_threshold=threshold,
        kwargs=kwargs,
    )
