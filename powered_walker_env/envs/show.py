"""What the environment shows of its strides: keeps the pictures that `render` hands out."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from powered_walker_env.envs.walkers import Walkers
from powered_walker_env.model.mechanics.constants import params_of
from powered_walker_env.model.state import PostStrikeState
from powered_walker_env.pictures.canvas import Frame
from powered_walker_env.pictures.renderer import Renderer
from powered_walker_env.pictures.window import Window
from powered_walker_env.simulation.trajectory import TrajectoryBuilder, log_stride


class StrideShow:
    """Draws the stride that the environment has just walked, at `fps` frames per second.

    Args:
        walkers: whose first walker is shown.
        mode: "rgb_array", "rgb_array_list" or "human", which shows each stride at once.
    """

    def __init__(self, walkers: Walkers, mode: str, fps: int) -> None:
        self.walkers, self.mode, self.fps = walkers, mode, fps
        self._renderer = Renderer(walkers.task.params)
        self._window = Window(fps) if mode == "human" else None
        self._frames: list[Frame] = []

    def begin(self) -> None:
        """Stand at the start of an episode, or where the environment has been put."""
        params = params_of(self.walkers.rows[0])
        self._renderer.reset(self.walkers.states[0].tolist(), params=params)
        self._frames = []
        if self.mode != "rgb_array":
            self._keep([self._renderer.frame()])

    def add(self, start: PostStrikeState) -> None:
        """Show the stride that led from `start` to here."""
        walkers = self.walkers
        params = params_of(walkers.rows[0])
        height = float(walkers.heights[0])
        scheme = walkers.task.scheme
        control = scheme.of_numbers(walkers.controls[0])
        logged = log_stride(start, control, params, height, walkers.rtol, 1.0 / self.fps)
        builder = TrajectoryBuilder(params, start)
        builder.add(logged, scheme.cycle, height)
        if self.mode == "rgb_array":
            self._renderer.follow(builder.build())
        else:
            self._keep(self._renderer.frames(builder.build(), self.fps))

    def picture(self) -> Any:
        """The last frame; all frames since the last call for "rgb_array_list"."""
        if self.mode == "human":
            return None
        if self.mode == "rgb_array":
            return self._renderer.frame()
        frames, self._frames = self._frames, []
        return frames

    def close(self) -> None:
        """Close the window, if there is one."""
        if self._window is not None:
            self._window.close()

    def _keep(self, frames: Iterable[Frame]) -> None:
        if self._window is not None:
            self._window.show(frames)
        else:
            self._frames += frames
