"""Stable-Baselines3's `VecEnv` over the native batch (import it on demand: needs torch).

SB3 takes no Gymnasium vector environment; this is one for it, with the same walkers.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import VecEnv
from stable_baselines3.common.vec_env.base_vec_env import VecEnvObs, VecEnvStepReturn

from powered_walker_env.envs.on_demand import Columns, WalkerInfo, infos_of, row_of
from powered_walker_env.envs.registration import make_walkers
from powered_walker_env.envs.saved import check_saved, numbers

_OWN_INFO = ("final_obs", "final_info")
_CUT = "TimeLimit.truncated"


class PoweredWalkerVecEnv(VecEnv):
    """N walkers for Stable-Baselines3, on all cores; monitored, as those of `make_vec_env`.

    Infos are dictionaries that are put together when somebody looks at them.

    Args:
        env_id: a registered environment, as `"powered_walker_env:PoweredWalker-v0"`, or one of
            your own of the same class.
        num_envs: how many walkers.
        seed: of walker 0, the others following.
        monitor: put return, length and time of every episode into the last info, as `Monitor`
            does: `ep_rew_mean` is logged, and `evaluate_policy` reports raw returns. False
            where a `VecMonitor` does it.
        **kwargs: of the environment, `render_mode` among them ("rgb_array" for
            `VecVideoRecorder`: one picture a stride, in real time).

    Raises:
        ValueError: an environment of another package, or arguments it does not take.
    """

    def __init__(
        self,
        env_id: str,
        num_envs: int,
        seed: int | None = None,
        *,
        monitor: bool = True,
        **kwargs: Any,
    ) -> None:
        mode = AutoresetMode.SAME_STEP
        self.envs = make_walkers(env_id, num_envs, **{"autoreset_mode": mode.value, **kwargs})
        if self.envs.autoreset_mode != mode:
            raise ValueError(f"autoreset_mode is {mode.value!r} here, got {kwargs!r}")
        self._monitor = monitor
        self._returns = np.zeros(num_envs)
        self._began = time.time()
        self._wanted = np.zeros(self.envs.action_space.shape or (0,))
        self._next_seed = seed
        super().__init__(
            num_envs, self.envs.single_observation_space, self.envs.single_action_space
        )
        self.metadata = {**self.envs.metadata}

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
            self._keep_reset_infos(_columns(info), mask)
        self._next_seed = None
        self._returns[:] = 0.0
        self._reset_seeds()
        self._reset_options()
        return observation

    def step_async(self, actions: np.ndarray) -> None:
        """Note the actions."""
        self._wanted = actions

    def step_wait(self) -> VecEnvStepReturn:
        """Walk one stride each; walkers that are over start anew at once."""
        lengths = self.envs.elapsed + 1
        observation, reward, terminated, truncated, info = self.envs.step(self._wanted)
        self._returns += reward
        columns, done = _columns(info), terminated | truncated
        infos = infos_of(columns)
        for row in infos:
            row[_CUT] = False
        if done.any():
            self._keep_reset_infos(columns, done)
            endings, cut = _columns(info["final_info"]), truncated & ~terminated
            for i in np.flatnonzero(done).tolist():
                row = infos[i] = WalkerInfo(endings, i)
                row["terminal_observation"], row[_CUT] = info["final_obs"][i], bool(cut[i])
                if self._monitor:
                    row["episode"] = self._episode(i, int(lengths[i]))
        self._returns[done] = 0.0
        return observation, reward, done, infos

    def _episode(self, i: int, length: int) -> dict[str, float]:
        """What `Monitor` says of an episode that is over."""
        seconds = round(time.time() - self._began, 6)
        return {"r": round(float(self._returns[i]), 6), "l": length, "t": seconds}

    def get_images(self) -> Sequence[NDArray[np.uint8] | None]:
        """A picture of each walker, with `render_mode="rgb_array"`."""
        return list(self.envs.render())

    def _keep_reset_infos(self, columns: Columns, which: NDArray[np.bool_]) -> None:
        for i in np.flatnonzero(which).tolist():
            self.reset_infos[i] = row_of(columns, i)

    def get_state(self) -> dict[str, Any]:
        """Everything the walkers' future depends on, random numbers included."""
        walkers = self.envs.walkers
        return {
            "walkers": [walkers.get_state(i) for i in range(self.num_envs)],
            "elapsed": self.envs.elapsed.copy(),
            "returns": self._returns.copy(),
        }

    def set_state(self, saved: dict[str, Any]) -> None:
        """Go back to a state of `get_state` (of as many walkers at the same task).

        Raises:
            ValueError: something else, or the state of another number of walkers.
        """
        check_saved(saved, ("walkers", "elapsed", "returns"))
        if len(saved["walkers"]) != self.num_envs:
            raise ValueError(
                f"the state must be one of {self.num_envs} walkers, got {len(saved['walkers'])}"
            )
        returns = numbers(saved, "returns", self.num_envs)
        self.envs.set_states(saved["walkers"], saved["elapsed"])
        self._returns[:] = returns
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
        """Whether there is a `Monitor` inside; no other wrapper is."""
        monitored = self._monitor and issubclass(wrapper_class, Monitor)
        return [monitored for _ in self._get_indices(indices)]


def _columns(info: dict[str, Any]) -> Columns:
    """The numbers of all walkers, the endings left out."""
    return {
        name: values for name, values in info.items() if name[0] != "_" and name not in _OWN_INFO
    }
