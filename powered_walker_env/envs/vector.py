"""Many walkers in one vector environment: `stride_batch` inside, all cores, one task.

Walker i behaves bit for bit as a single environment seeded with `seed + i`, so the
results are those of `SyncVectorEnv` over N single environments.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from powered_walker_env.envs.disturbances import Disturbance
from powered_walker_env.envs.setup import make_task
from powered_walker_env.envs.walker import (
    STRIDE_RTOL,
    action_space,
    check_action,
    check_options,
    observation_space,
)
from powered_walker_env.envs.walkers import Walkers
from powered_walker_env.model.powering import AnyControl
from powered_walker_env.model.state import PostStrikeState
from powered_walker_env.model.walker import WalkerParams

Observations = NDArray[np.float32]
Info = dict[str, Any]


class PoweredWalkerVectorEnv(gym.vector.VectorEnv[Observations, NDArray[Any], NDArray[Any]]):
    """N walkers at once; the task, spaces and arguments are those of `PoweredWalkerEnv`.

    Args:
        num_envs: how many walkers.
        max_episode_steps: strides until truncation; None for no limit. (`gym.make_vec`
            passes the registered limit.)
        autoreset_mode: `AutoresetMode.NEXT_STEP` (Gymnasium's default), `SAME_STEP` or
            `DISABLED`, or the mode's value as a string.
        **task: `preset`, `params`, `scheme`, `control`, `gait`, `action_range`, `reward`,
            `effort_weight`, `disturbance`, as in `PoweredWalkerEnv`.

    Raises:
        ValueError: a bad argument, or a render mode: this environment draws nothing.
    """

    def __init__(
        self,
        num_envs: int = 1,
        max_episode_steps: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        preset: str | None = None,
        params: WalkerParams | Mapping[str, Any] | None = None,
        control: AnyControl | Sequence[float] | None = None,
        gait: Sequence[Any] | None = None,
        action_range: Sequence[float] | None = None,
        reward: str = "deviation",
        effort_weight: float = 0.0,
        disturbance: str | Mapping[str, float] | Disturbance = "light",
        scheme: str | None = None,
    ) -> None:
        if num_envs < 1:
            raise ValueError(f"num_envs must be at least 1, got {num_envs!r}")
        if max_episode_steps is not None and max_episode_steps < 1:
            raise ValueError(f"max_episode_steps must be at least 1, got {max_episode_steps!r}")
        if render_mode is not None:
            raise ValueError(
                f"render_mode must be None here, got {render_mode!r}; use "
                'gym.make, or make_vec(vectorization_mode="sync"), for pictures'
            )
        self.task = make_task(
            preset, params, scheme, control, gait, action_range, reward, effort_weight, disturbance
        )
        self.num_envs = num_envs
        self.max_episode_steps = max_episode_steps
        self.autoreset_mode = AutoresetMode(autoreset_mode)
        self.metadata = {"autoreset_mode": self.autoreset_mode}
        self.render_mode = None
        self.single_observation_space = observation_space()
        self.single_action_space = action_space(self.task.scheme)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.walkers = Walkers(self.task, num_envs, STRIDE_RTOL)
        self._elapsed = np.zeros(num_envs, np.int64)
        self._over = np.zeros(num_envs, np.bool_)  # finished, waiting for their reset
        self._started = np.zeros(num_envs, np.bool_)

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Observations, Info]:
        """Start all walkers, or those of `options["reset_mask"]`, anew.

        Args:
            seed: of walker 0, the others following; or one for each. Without one, a
                walker's random numbers go on.
            options: `state`, as in `PoweredWalkerEnv`, and `reset_mask`, (N,) bool.

        Raises:
            ValueError: as many seeds as walkers are needed; a bad option.
        """
        seeds = self._seeds(seed)
        chosen = dict(options or {})
        mask = self._mask(chosen.pop("reset_mask", None))
        state = check_options(chosen)
        for i in np.flatnonzero(mask).tolist():
            if seeds[i] is not None or not self._started[i]:
                self.walkers.seed(i, seeding.np_random(seeds[i])[0])
        self._started |= mask
        self._restart(mask, state)
        return self.walkers.observations.copy(), _masked(self.walkers.start_info(), mask)

    def step(
        self, actions: NDArray[Any]
    ) -> tuple[Observations, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], Info]:
        """One stride of each walker; what happens to those that are over, the mode says.

        Raises:
            ValueError: actions of a wrong shape or not finite.
            gymnasium.error.ResetNeeded: before the first reset, or, with autoreset
                disabled, while a walker that is over has not been reset.
        """
        wanted = check_action(actions, self.action_space.shape, self.task.scheme)
        if not self._started.all():
            raise gym.error.ResetNeeded("call reset() before step()")
        active = None
        if self._over.any():
            if self.autoreset_mode == AutoresetMode.DISABLED:
                raise gym.error.ResetNeeded(
                    f"walkers {np.flatnonzero(self._over).tolist()} are over; reset them with "
                    'options={"reset_mask": ...}'
                )
            active = ~self._over
            self._restart(self._over)
        result = self.walkers.step(wanted, active)
        self._elapsed += 1 if active is None else active
        truncated = np.zeros(self.num_envs, np.bool_)
        if self.max_episode_steps is not None:
            truncated = self._elapsed >= self.max_episode_steps
        self._over = result.terminated | truncated
        if self.autoreset_mode == AutoresetMode.SAME_STEP and self._over.any():
            observation, info = self._finish(result.observation, result.info)
        else:
            observation, info = result.observation, _masked(result.info)
        return observation, result.reward, result.terminated, truncated, info

    def _restart(self, which: NDArray[np.bool_], state: PostStrikeState | None = None) -> None:
        """Start the given walkers anew with their own random numbers."""
        self.walkers.reset(slice(None) if which.all() else np.flatnonzero(which), state)
        self._elapsed[which] = 0
        self._over = self._over & ~which

    def _finish(
        self, observation: Observations, info: dict[str, NDArray[Any]]
    ) -> tuple[Observations, Info]:
        """Restart what is over; its last observation and info go into `final_…`."""
        over = self._over
        final = np.full(self.num_envs, None, dtype=object)
        for i in np.flatnonzero(over):
            final[i] = observation[i]
        last = _masked(info, over)
        self._restart(over)
        fresh = self.walkers.start_info()
        for name, values in info.items():
            values[over] = fresh[name][over]
        ends: Info = {"final_obs": final, "_final_obs": over.copy()}
        ends |= {"final_info": last, "_final_info": over.copy()}
        return self.walkers.observations.copy(), ends | _masked(info)

    def _seeds(self, seed: int | Sequence[int | None] | None) -> list[int | None]:
        if seed is None:
            return [None] * self.num_envs
        if isinstance(seed, (int, np.integer)):
            return [int(seed) + i for i in range(self.num_envs)]
        if len(seed) != self.num_envs:
            raise ValueError(f"seed must be one or {self.num_envs} seeds, got {len(seed)}")
        return list(seed)

    def _mask(self, mask: Any) -> NDArray[np.bool_]:
        if mask is None:
            return np.ones(self.num_envs, np.bool_)
        good = isinstance(mask, np.ndarray) and mask.dtype == np.bool_
        if not (good and mask.shape == (self.num_envs,) and mask.any()):
            raise ValueError(
                f"options['reset_mask'] must be ({self.num_envs},) bool with a True, got {mask!r}"
            )
        chosen: NDArray[np.bool_] = mask
        return chosen


def _masked(info: dict[str, NDArray[Any]], mask: NDArray[np.bool_] | None = None) -> Info:
    """Gymnasium's form: every key with a `_key` that says whose values count, others zero.

    Args:
        mask: (N,); every walker if left out.
    """
    masked: Info = {}
    every = None
    for name, values in info.items():
        if mask is None:
            every = np.ones(len(values), np.bool_) if every is None else every
            masked[name], masked[f"_{name}"] = values, every
        else:
            masked[name], masked[f"_{name}"] = np.zeros_like(values), mask.copy()
            masked[name][mask] = values[mask]
    return masked
