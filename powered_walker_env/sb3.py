"""Stable-Baselines3's `VecEnv` over the native batch (import it on demand: needs torch).

SB3 takes no Gymnasium vector environment; this is one for it, with the same walkers.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv
from stable_baselines3.common.vec_env.base_vec_env import VecEnvObs, VecEnvStepReturn

from powered_walker_env.envs.vector import PoweredWalkerVectorEnv

_OWN_INFO = ("final_obs", "final_info")


class PoweredWalkerVecEnv(VecEnv):
    """N walkers for Stable-Baselines3, on all cores.

    Args:
        env_id: a registered environment, as `"powered_walker_env:PoweredWalker-v0"`.
        num_envs: how many walkers.
        seed: of walker 0, the others following.
        **kwargs: of the environment.

    Raises:
        ValueError: an environment of another package, or arguments it does not take.
    """

    def __init__(self, env_id: str, num_envs: int, seed: int | None = None, **kwargs: Any) -> None:
        mode = AutoresetMode.SAME_STEP.value
        try:
            envs = gym.make_vec(
                env_id,
                num_envs,
                vectorization_mode="vector_entry_point",
                autoreset_mode=mode,
                **kwargs,
            ).unwrapped
        except TypeError as error:
            raise ValueError(
                f"env_id must name an environment of this package that takes {kwargs}, "
                f"got {env_id!r}: {error}"
            ) from error
        if not isinstance(envs, PoweredWalkerVectorEnv):
            raise ValueError(f"env_id must name an environment of this package, got {env_id!r}")
        self.envs = envs
        self._wanted = np.zeros(envs.action_space.shape or (0,))
        self._next_seed = seed
        self.render_mode = None
        super().__init__(num_envs, envs.single_observation_space, envs.single_action_space)

    def reset(self) -> VecEnvObs:
        """Start all walkers anew; seeds and options, if any, count once."""
        seed: Any = self._next_seed if self._seeds[0] is None else self._seeds
        plain = np.array([not options for options in self._options])
        starts: list[tuple[NDArray[np.bool_], dict[str, Any]]] = (
            [(plain, {})] if plain.any() else []
        )
        for i in np.flatnonzero(~plain):
            starts.append((np.arange(self.num_envs) == i, self._options[i]))
        for mask, options in starts:
            observation, info = self.envs.reset(seed=seed, options={**options, "reset_mask": mask})
            self._keep_reset_infos(_rows(info), mask)
        self._next_seed = None
        self._reset_seeds()
        self._reset_options()
        return observation

    def step_async(self, actions: np.ndarray) -> None:
        """Note the actions."""
        self._wanted = actions

    def step_wait(self) -> VecEnvStepReturn:
        """Walk one stride each; walkers that are over start anew at once."""
        observation, reward, terminated, truncated, info = self.envs.step(self._wanted)
        infos, done = _rows(info), terminated | truncated
        self._keep_reset_infos(infos, done)
        if done.any():
            endings = _rows(info["final_info"])
        for i in np.flatnonzero(done):
            infos[i] = {**endings[i], "terminal_observation": info["final_obs"][i]}
        for row, cut in zip(infos, (truncated & ~terminated).tolist(), strict=True):
            row["TimeLimit.truncated"] = cut
        return observation, reward, done, infos

    def _keep_reset_infos(self, infos: list[dict[str, Any]], which: NDArray[np.bool_]) -> None:
        for i in np.flatnonzero(which):
            self.reset_infos[i] = dict(infos[i])

    def get_state(self) -> dict[str, Any]:
        """Everything the walkers' future depends on, random numbers included."""
        walkers = self.envs.walkers
        return {
            "walkers": [walkers.get_state(i) for i in range(self.num_envs)],
            "elapsed": self.envs._elapsed.copy(),
        }

    def set_state(self, saved: dict[str, Any]) -> None:
        """Go back to a state of `get_state` (of as many walkers at the same task)."""
        if len(saved["walkers"]) != self.num_envs:
            raise ValueError(
                f"the state must be one of {self.num_envs} walkers, got {len(saved['walkers'])}"
            )
        for i, walker in enumerate(saved["walkers"]):
            self.envs.walkers.set_state(i, walker)
        self.envs._elapsed[:] = saved["elapsed"]
        self.envs._started[:] = True
        self._next_seed = None

    def close(self) -> None:
        """Release the walkers."""
        self.envs.close()

    def get_attr(self, attr_name: str, indices: int | Iterable[int] | None = None) -> list[Any]:
        """An attribute of the vector environment, once for each walker asked for."""
        value = getattr(self.envs, attr_name)
        return [value for _ in self._get_indices(indices)]

    def set_attr(
        self, attr_name: str, value: Any, indices: int | Iterable[int] | None = None
    ) -> None:
        """Refused: the walkers of a batch share one task."""
        raise AttributeError(f"{attr_name!r} cannot be set: the walkers of a batch share one task")

    def env_method(
        self,
        method_name: str,
        *args: Any,
        indices: int | Iterable[int] | None = None,
        **kwargs: Any,
    ) -> list[Any]:
        """Call a method of the vector environment; one result for each walker asked for."""
        result = getattr(self.envs, method_name)(*args, **kwargs)
        return [result for _ in self._get_indices(indices)]

    def env_is_wrapped(
        self, wrapper_class: type[gym.Wrapper[Any, Any, Any, Any]], indices: Any = None
    ) -> list[bool]:
        """Never: there are no wrappers inside."""
        return [False for _ in self._get_indices(indices)]


def _rows(info: dict[str, Any]) -> list[dict[str, Any]]:
    """The info of every walker, the endings left out; numbers as plain Python."""
    names = [name for name in info if name[0] != "_" and name not in _OWN_INFO]
    columns = [info[name] for name in names]
    plain = [list(values) if values.ndim > 1 else values.tolist() for values in columns]
    return [dict(zip(names, row, strict=True)) for row in zip(*plain, strict=True)]
