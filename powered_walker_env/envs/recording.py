"""Films of walks: every picture of every stride, where `RecordVideo` has one for each."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium as gym

from powered_walker_env.envs.contract import check_count
from powered_walker_env.envs.gallery import RENDER_FPS
from powered_walker_env.envs.show import Walked
from powered_walker_env.envs.walker import Action, Observation, PoweredWalkerEnv
from powered_walker_env.envs.walkers import WALKED
from powered_walker_env.model.mechanics.packing import params_of
from powered_walker_env.model.state import PostStrikeState
from powered_walker_env.pictures.film import check_film, save_animation
from powered_walker_env.simulation.trajectory import TrajectoryBuilder

LONGEST = 1000  # strides of one film; a longer episode goes on unfilmed


def often_at_first(episode: int) -> bool:
    """The schedule of `RecordVideo`: 0, 1, 8, 27, 64, ..., 1000, 2000, 3000, ..."""
    if episode >= 1000:
        return episode % 1000 == 0
    return round(episode ** (1 / 3)) ** 3 == episode


class RecordWalk(
    gym.Wrapper[Observation, Action, Observation, Action], gym.utils.RecordConstructorArgs
):
    """Writes episodes as films, in real time; used as Gymnasium's `RecordVideo`.

    It needs no render mode: strides are noted as numbers, and drawn when their episode is over,
    at the next reset or at `close()`. A film appears complete or not at all; after a fall it
    rests a second on its last picture.

    ```python
    env = RecordWalk(gym.make("powered_walker_env:PoweredWalker-v0"), "films")
    ```

    Args:
        env: an environment of this package, wrapped or not.
        folder: where the films go; it is made. Films are `walk-episode-0.mp4` and so on.
        episode_trigger: which episodes, by number; `often_at_first` if left out.
        name_prefix: "walk" in the name of the films.
        suffix: ".mp4", or ".gif".
        fps: pictures for each second of the walk.
        longest: strides of a film at most.

    Raises:
        TypeError: an environment of another class.
        FileExistsError: films of that name are there already.
        ValueError: a suffix, rate or number that will not do.
        ImportError: pygame, or what the format needs, is not installed.
    """

    def __init__(
        self,
        env: gym.Env[Observation, Action],
        folder: str | os.PathLike[str],
        episode_trigger: Callable[[int], bool] | None = None,
        *,
        name_prefix: str = "walk",
        suffix: str = ".mp4",
        fps: float = RENDER_FPS,
        longest: int = LONGEST,
    ) -> None:
        gym.utils.RecordConstructorArgs.__init__(
            self,
            folder=str(folder),
            episode_trigger=episode_trigger,
            name_prefix=name_prefix,
            suffix=suffix,
            fps=fps,
            longest=longest,
        )
        gym.Wrapper.__init__(self, env)
        if not isinstance(env.unwrapped, PoweredWalkerEnv):
            raise TypeError(f"env must be an environment of this package, got {env!r}")
        check_count("longest", longest)
        self.folder, self.name_prefix, self.suffix = Path(folder), name_prefix, suffix
        self.fps, self.longest = fps, longest
        self._trigger = episode_trigger or often_at_first
        self._walker: PoweredWalkerEnv = env.unwrapped
        self._episode = -1
        self._film: TrajectoryBuilder | None = None  # of the episode under way
        self._strides = 0  # in it
        there = sorted(self.folder.glob(f"{name_prefix}-episode-*{suffix}"))
        if there:
            raise FileExistsError(
                f"{str(there[0])!r} is there already; choose another folder or name_prefix"
            )
        self.folder.mkdir(parents=True, exist_ok=True)
        check_film(self._path(), fps=fps)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start an episode, and perhaps a film; one under way is written."""
        self._finish()
        given = self.env.reset(seed=seed, options=options)
        self._episode += 1
        if self._trigger(self._episode):
            params = params_of(self._walker.walkers.row(0))
            self._film, self._strides = TrajectoryBuilder(params, self._state()), 0
        return given

    def step(self, action: Action) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Walk one stride, and note it; the film of an episode that is over is written."""
        walkers, start = self._walker.walkers, self._state()
        lay = walkers.outcomes[0] != WALKED  # fallen before: there is nothing to see
        given = self.env.step(action)
        if self._film is not None and not lay and self._strides < self.longest:
            walked = Walked.of(walkers, 0, start)
            walked.add_to(self._film, walkers.task, walkers.rtol, 1.0 / self.fps)
            self._strides += 1
        if given[2] or given[3]:
            self._finish()
        return given  # type: ignore[return-value] # our reward is a float

    def close(self) -> None:
        """Write the film under way, and close the environment."""
        self._finish()
        super().close()

    def _state(self) -> PostStrikeState:
        return PostStrikeState(*self._walker.walkers.states[0].tolist())

    def _path(self) -> Path:
        return self.folder / f"{self.name_prefix}-episode-{self._episode}{self.suffix}"

    def _finish(self) -> None:
        film, self._film = self._film, None
        if film is not None and self._strides:
            save_animation(film.build(), self._path(), fps=self.fps)
