"""The Gymnasium environment: one step is one stride."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from powered_walker_env.envs.arguments import TaskArguments
from powered_walker_env.envs.contract import (
    STRIDE_RTOL,
    action_space,
    check_action,
    check_options,
    check_render_mode,
    observation_space,
)
from powered_walker_env.envs.description import describe
from powered_walker_env.envs.gallery import RENDER_FPS, Gallery
from powered_walker_env.envs.levels import key_push
from powered_walker_env.envs.saved import check_saved
from powered_walker_env.envs.setup import make_task
from powered_walker_env.envs.task import Task
from powered_walker_env.envs.walkers import WALKED, Walkers
from powered_walker_env.model.phases import Outcome
from powered_walker_env.model.powering import AnyControl

Observation = NDArray[np.float32]
Action = NDArray[np.float32]
NOBODY = np.zeros(1, np.bool_)


class PoweredWalkerEnv(gym.Env[Observation, Action]):  # its docstring is in `description.py`
    __doc__ = describe()

    metadata: dict[str, Any] = {  # noqa: RUF012 (Gymnasium declares it so)
        "render_modes": ["human", "rgb_array", "rgb_array_list"],
        "render_fps": RENDER_FPS,
    }

    def __init__(
        self, preset: str | None = None, *, render_mode: str | None = None, **arguments: Any
    ) -> None:
        """See the class.

        Raises:
            ValueError: an argument out of its domain, or two that contradict.
            TypeError: an argument that does not exist.
            GaitNotFoundError: parameters without a gait, and none found.
        """
        self.render_mode = check_render_mode(render_mode, self.metadata["render_modes"])
        self.task: Task = make_task(TaskArguments.of({"preset": preset, **arguments}))
        self.observation_space = observation_space()
        self.action_space = action_space(self.task.scheme)
        self._scheme = self.task.scheme
        self.walkers = Walkers(self.task, 1, STRIDE_RTOL)
        self._reward, self._table = np.zeros(1), self.walkers.nothing()  # every step's
        self._seeded = False
        self._begun = False  # by a reset
        self._warned = False  # that the walker lies where it fell
        self._gallery = Gallery(self.walkers, render_mode, "gym.make")
        self.metadata = {**self.metadata, "render_fps": self._gallery.fps}

    @property
    def np_random(self) -> np.random.Generator:
        """The generator that the walker's random numbers begin from; set, they begin anew."""
        return super().np_random

    @np_random.setter
    def np_random(self, value: np.random.Generator) -> None:
        gym.Env.np_random.__set__(self, value)  # type: ignore[attr-defined] # a property
        self.walkers.seed(0, value)
        self._seeded = True

    @property
    def outcome(self) -> Outcome:
        """How the last stride ended: `info["outcome"]` as a name."""
        return Outcome(int(self.walkers.outcomes[0]))

    def control(self, action: Sequence[float] | Action) -> AnyControl:
        """The control that an action means: the public action mapping (without noise).

        Raises:
            ValueError: an action that is not k finite numbers.
        """
        wanted = check_action(action, self.action_space.shape, self.task.scheme)
        return self.task.control_of(wanted)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start an episode; `options={"state": ...}` starts at a post-strike state.

        The seed decides where the walker's random numbers begin; without one they go on.

        Raises:
            ValueError: an unknown option, or a state that is not four finite numbers.
        """
        state = check_options(options)
        super().reset(seed=seed)
        if seed is not None or not self._seeded:
            self.walkers.seed(0, self.np_random)
            self._seeded = True
        self.walkers.reset(state=state)
        self._begun, self._warned = True, False
        self._table[:] = 0.0  # nothing walked yet, nothing earned
        self._gallery.begin()
        return self.walkers.observations[0].copy(), self.walkers.info_of_first(self._table[:, 0])

    def step(self, action: Action) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Walk one stride.

        After a fall it warns, once, and goes on: the walker lies where it fell, earns nothing,
        and every step says so again until the next reset.

        Raises:
            ValueError: an action that is not k finite numbers.
            gymnasium.error.ResetNeeded: before the first reset.
        """
        if not self._begun:
            raise gym.error.ResetNeeded("call reset() before step(): no walk has begun yet")
        wanted = check_action(action, self.action_space.shape, self._scheme)
        walkers, reward, table = self.walkers, self._reward, self._table
        active, starts = None, self._gallery.starts()
        if walkers.outcomes.item(0) != WALKED:
            active = self._lying()
        walkers.walk(wanted.reshape(1, -1), active, reward, table)
        self._gallery.add(starts, active)
        fell, restart = walkers.outcomes.item(0) != WALKED, False
        if self.render_mode == "human":
            pushes, restart = self._gallery.pushes_and_restart()
            if pushes and not fell:
                walkers.push(0, pushes * key_push(self.task))
        observation, info = walkers.observations[0].copy(), walkers.info_of_first(table[:, 0])
        return observation, reward.item(0), fell, restart, info

    def _lying(self) -> NDArray[np.bool_]:
        """Nobody walks, and nothing is earned."""
        if not self._warned:
            gym.logger.warn("step() was called after a fall: nothing happens until reset()")
            self._warned = True
        self._reward[:] = self._table[:] = 0.0
        return NOBODY

    def get_state(self) -> dict[str, Any]:
        """Everything the future depends on, random numbers included; for planners.

        JSON-able. The wrappers of `gym.make` keep their own: `TimeLimit` its count.
        """
        return {**self.walkers.get_state(0), "begun": self._begun, "seeded": self._seeded}

    def set_state(self, saved: Mapping[str, Any]) -> None:
        """Go back to a state of `get_state` (of an environment with the same arguments).

        Raises:
            ValueError: something that `get_state` has not given.
        """
        check_saved(saved, ("begun", "seeded"))
        self.walkers.set_state(0, saved)
        self._begun, self._seeded = bool(saved["begun"]), bool(saved["seeded"])
        self._warned = False
        if self._begun:
            self._gallery.begin()

    def render(self) -> Any:
        """The last picture; with `"rgb_array_list"` all since the last call.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset.
        """
        return self._gallery.pictures()[0]

    def close(self) -> None:
        """Close the window, if any."""
        self._gallery.close()
