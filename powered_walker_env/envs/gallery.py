"""What an environment shows: nothing, the pictures of its walkers, or a window on the first."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from powered_walker_env.envs.walkers import Walkers
from powered_walker_env.model.state import PostStrikeState

if TYPE_CHECKING:  # what draws is imported when there is something to draw
    from powered_walker_env.envs.show import StrideShow

RENDER_FPS = 25
EVERY = np.ones(1, np.bool_)


class Gallery:
    """A show for each walker, all drawn by one painter.

    Args:
        walkers: whose.
        mode: as in `show.StrideShow`; "human" shows walker 0. None: nothing is shown.
        maker: what makes the environment, for the message that there is no mode.
    """

    def __init__(self, walkers: Walkers, mode: str | None, maker: str) -> None:
        self.walkers, self.mode, self._maker = walkers, mode, maker
        self._shows: list[StrideShow] = []

    @property
    def fps(self) -> float:
        """Pictures a second with which `render()` after every stride plays in real time."""
        if self.mode != "rgb_array":
            return RENDER_FPS
        from powered_walker_env.envs.show import strides_per_second

        return strides_per_second(self.walkers.task)

    def begin(self, which: NDArray[np.bool_] = EVERY) -> None:
        """Stand at the starts of these walkers."""
        if self.mode is None:
            return
        if not self._shows:
            self._open(self.mode)
        for show in self._shows:
            if which[show.index]:
                show.begin()

    def starts(self) -> list[list[float]] | None:
        """Where the walkers are before their next strides, for `add`; None if none are shown."""
        return None if self.mode is None else self.walkers.states.tolist()

    def add(
        self, starts: Sequence[Sequence[float]] | None, active: NDArray[np.bool_] | None
    ) -> None:
        """Note the strides that led from `starts` to here, of the active walkers only."""
        if starts is None:
            return
        for show in self._shows:
            if active is None or active[show.index]:
                show.add(PostStrikeState(*starts[show.index]))

    def pushes_and_restart(self) -> tuple[int, bool]:
        """What the keys of a window have asked for since the last stride: see `Window`."""
        return self._shows[0].take_wishes() if self._shows else (0, False)

    def pictures(self) -> tuple[Any, ...]:
        """One of each walker; None where a window shows them, or nothing is shown.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset.
        """
        if self.mode is None:
            gym.logger.warn(
                f"render() was called without a render mode; pass one to {self._maker}, for "
                'example render_mode="rgb_array"'
            )
            return (None,)
        if not self._shows:
            raise gym.error.ResetNeeded("call reset() before render()")
        return tuple(show.picture() for show in self._shows)

    def close(self) -> None:
        """Close the window, if there is one."""
        for show in self._shows:
            show.close()
        self._shows = []

    def _open(self, mode: str) -> None:
        from powered_walker_env.envs.show import StrideShow

        first = StrideShow(self.walkers, 0, mode, RENDER_FPS)
        others = range(1, 1 if mode == "human" else self.walkers.count)
        self._shows = [
            first,
            *(StrideShow(self.walkers, i, mode, RENDER_FPS, first.painter) for i in others),
        ]
