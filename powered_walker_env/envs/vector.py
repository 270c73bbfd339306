"""Many walkers in one vector environment: `stride_batch` inside, all cores, one task.

Walker i behaves bit for bit as a single environment seeded with `seed + i`, so the
results are those of `SyncVectorEnv` over N single environments.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from powered_walker_env.envs.arguments import TaskArguments
from powered_walker_env.envs.contract import (
    STRIDE_RTOL,
    action_space,
    check_action,
    check_count,
    check_mask,
    check_options,
    check_render_mode,
    check_seeds,
    endings,
    masked,
    observation_space,
)
from powered_walker_env.envs.gallery import Gallery
from powered_walker_env.envs.saved import Saved, numbers
from powered_walker_env.envs.setup import make_task
from powered_walker_env.envs.walkers import WALKED, Walkers
from powered_walker_env.model.mechanics.packing import OWN
from powered_walker_env.model.powering import AnyControl
from powered_walker_env.model.state import PostStrikeState

Observations = NDArray[np.float32]
Info = dict[str, Any]
RENDER_MODES = ["human", "rgb_array"]


class PoweredWalkerVectorEnv(gym.vector.VectorEnv[Observations, NDArray[Any], NDArray[Any]]):
    """N walkers at once; the task, spaces and arguments are those of `PoweredWalkerEnv`.

    Args:
        num_envs: how many walkers.
        max_episode_steps: strides until truncation; None for no limit. (`gym.make_vec`
            passes the registered limit.)
        autoreset_mode: `AutoresetMode.NEXT_STEP` (Gymnasium's default), `SAME_STEP` or
            `DISABLED`, or the mode's value as a string. If it is disabled, a walker that fell
            lies there and earns nothing until it is reset, with a warning.
        render_mode: "rgb_array", a picture of each walker at the end of its last stride; or
            "human", a window that shows walker 0.
        **arguments: those of `TaskArguments`, as in `PoweredWalkerEnv`.

    Raises:
        ValueError: a bad argument; TypeError: one that does not exist.
    """

    def __init__(
        self,
        num_envs: int = 1,
        max_episode_steps: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        **arguments: Any,
    ) -> None:
        check_count("num_envs", num_envs)
        if max_episode_steps is not None:
            check_count("max_episode_steps", max_episode_steps)
        self.render_mode = check_render_mode(render_mode, RENDER_MODES)
        self.autoreset_mode = AutoresetMode(autoreset_mode)
        self.task = make_task(TaskArguments.of(arguments))
        self.num_envs = num_envs
        self.max_episode_steps = max_episode_steps
        self.single_observation_space = observation_space()
        self.single_action_space = action_space(self.task.scheme)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.walkers = Walkers(self.task, num_envs, STRIDE_RTOL)
        self.elapsed = np.zeros(num_envs, np.int64)  # strides of each walker's episode
        self._over = np.zeros(num_envs, np.bool_)  # finished, waiting for their reset
        self._started = np.zeros(num_envs, np.bool_)
        self._seeded = np.zeros(num_envs, np.bool_)
        self._gallery = Gallery(self.walkers, render_mode, "gym.make_vec")
        self.metadata = {
            "autoreset_mode": self.autoreset_mode,
            "render_modes": RENDER_MODES,
            "render_fps": self._gallery.fps,
        }

    @property
    def np_random(self) -> np.random.Generator:
        """Seeded by `reset`; set, every walker's random numbers begin anew from it."""
        return super().np_random

    @np_random.setter
    def np_random(self, value: np.random.Generator) -> None:
        gym.vector.VectorEnv.np_random.__set__(self, value)  # type: ignore[attr-defined] # a property
        for i in range(self.num_envs):
            self.walkers.seed(i, value)
        self._seeded[:] = True

    def control(self, actions: Any) -> tuple[AnyControl, ...]:
        """The controls that (N, k) actions mean, as `PoweredWalkerEnv.control` for each.

        Raises:
            ValueError: actions of a wrong shape or not finite.
        """
        wanted = check_action(actions, self.action_space.shape, self.task.scheme)
        return tuple(map(self.task.control_of, wanted))

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
        seeds = check_seeds(seed, self.num_envs)
        chosen = dict(options or {})
        mask = check_mask(chosen.pop("reset_mask", None), self.num_envs)
        state = check_options(chosen)
        if isinstance(seed, (int, np.integer)):
            super().reset(seed=int(seed))
        for i in np.flatnonzero(mask).tolist():
            if seeds[i] is not None or not self._seeded[i]:
                own = (self.np_random_seed or 0) + i if seeds[i] is None else seeds[i]
                self.walkers.seed(i, seeding.np_random(own)[0])
        self._started |= mask
        self._seeded |= mask
        self._restart(mask, state)
        return self.walkers.observations.copy(), masked(self._start_info(), mask)

    def step(
        self, actions: NDArray[Any]
    ) -> tuple[Observations, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], Info]:
        """One stride of each walker; what happens to those that are over, the mode says.

        Raises:
            ValueError: actions of a wrong shape or not finite.
            gymnasium.error.ResetNeeded: before the first reset of each.
        """
        wanted = check_action(actions, self.action_space.shape, self.task.scheme)
        if not self._started.all():
            raise gym.error.ResetNeeded("call reset() before step()")
        active = self._active() if self._over.any() else None
        starts = self._gallery.starts()
        result = self.walkers.step(wanted, active)
        self._gallery.add(starts, active)
        self.elapsed += 1 if active is None else active
        limit = math.inf if self.max_episode_steps is None else self.max_episode_steps
        truncated = self.elapsed >= limit
        self._over = result.terminated | truncated
        observation, info = result.observation, result.info
        if self.autoreset_mode == AutoresetMode.SAME_STEP and self._over.any():
            observation, info = self._finish(observation, info)
        else:
            info = masked(info)
        return observation, result.reward, result.terminated, truncated, info

    def render(self) -> Any:
        """A tuple of N pictures, (height, width, 3) RGB each; None for a window.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset.
        """
        pictures = self._gallery.pictures()
        return pictures if self.render_mode == "rgb_array" else None

    def close_extras(self, **kwargs: Any) -> None:
        """Close the window, if any."""
        self._gallery.close()

    def set_states(self, saved: Sequence[Mapping[str, Any]], elapsed: Any) -> None:
        """Put every walker into a state of `walkers.get_state`, so many strides into its episode.

        Raises:
            ValueError: something that `get_state` has not given.
        """
        packed = OWN
        checked = [Saved.of(each, packed) for each in saved]
        self.elapsed[:] = numbers({"elapsed": elapsed}, "elapsed", self.num_envs)
        for i, each in enumerate(checked):
            self.walkers.put(i, each)
        self._over = self.walkers.outcomes != WALKED
        self._started[:] = self._seeded[:] = True
        self._gallery.begin(self._started)

    def _active(self) -> NDArray[np.bool_]:
        """Who walks where some are over: they are restarted, or lie where they fell."""
        if self.autoreset_mode != AutoresetMode.DISABLED:
            active = ~self._over
            self._restart(self._over)
            return active
        active = self.walkers.outcomes == WALKED
        if not active.all():
            gym.logger.warn(
                f"step() was called after walkers {np.flatnonzero(~active).tolist()} fell: "
                'nothing happens to them until reset(options={"reset_mask": ...})'
            )
        return active

    def _restart(self, which: NDArray[np.bool_], state: PostStrikeState | None = None) -> None:
        """Start the given walkers anew with their own random numbers."""
        self.walkers.reset(slice(None) if which.all() else np.flatnonzero(which), state)
        self.elapsed[which] = 0
        self._over = self._over & ~which
        self._gallery.begin(which)

    def _start_info(self) -> dict[str, NDArray[Any]]:
        """What `Step.info` holds, at a start: nothing walked yet, nothing earned."""
        return self.walkers.info(self.walkers.nothing())

    def _finish(
        self, observation: Observations, info: dict[str, NDArray[Any]]
    ) -> tuple[Observations, Info]:
        """Restart what is over; its last observation and info go into `final_…`."""
        over = self._over
        ends = endings(observation, info, over)
        self._restart(over)
        fresh = self._start_info()
        for name, values in info.items():
            values[over] = fresh[name][over]
        return self.walkers.observations.copy(), ends | masked(info)
