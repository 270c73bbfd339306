"""The pictures of many walkers, or a window on the first of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.envs.show import StrideShow
from powered_walker_env.envs.walkers import Walkers
from powered_walker_env.model.state import PostStrikeState


class Gallery:
    """A show for each walker of a batch, all drawn by one painter.

    Args:
        mode: "rgb_array", or "human" for walker 0 only.
    """

    def __init__(self, walkers: Walkers, mode: str, fps: int) -> None:
        first = StrideShow(walkers, 0, mode, fps)
        others = range(1, walkers.count if mode == "rgb_array" else 1)
        self.shows = [first, *(StrideShow(walkers, i, mode, fps, first.painter) for i in others)]

    def begin(self, which: NDArray[np.bool_]) -> None:
        """Stand at the starts of these walkers."""
        for show in self.shows:
            if which[show.index]:
                show.begin()

    def add(self, starts: Sequence[Sequence[float]], active: NDArray[np.bool_] | None) -> None:
        """Note the strides that led from `starts` to here, of the active walkers only."""
        for show in self.shows:
            if active is None or active[show.index]:
                show.add(PostStrikeState(*starts[show.index]))

    def pictures(self) -> tuple[Any, ...] | None:
        """One of each walker; None where a window shows them."""
        if self.shows[0].mode == "human":
            return None
        return tuple(show.picture() for show in self.shows)

    def close(self) -> None:
        """Close the window, if there is one."""
        for show in self.shows:
            show.close()
