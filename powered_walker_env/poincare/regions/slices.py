"""Where to look in the state space: rectangles in two of its four coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from powered_walker_env.model.state import PostStrikeState, check_state
from powered_walker_env.simulation.strides import Array

COORDINATES = PostStrikeState._fields


@dataclass(frozen=True)
class Slice:
    """A rectangle in two coordinates of the post-strike state, the other two fixed."""

    base: PostStrikeState | Sequence[float]  # the point whose other coordinates are kept
    axes: tuple[str, str]  # across, up: names out of PostStrikeState's fields
    ranges: tuple[tuple[float, float], tuple[float, float]]  # rad or rad/s, ends included
    shape: tuple[int, int] = (200, 200)  # points across, up

    def __post_init__(self) -> None:
        object.__setattr__(self, "base", check_state(self.base))
        if len(set(self.axes)) != 2 or not set(self.axes) <= set(COORDINATES):
            raise ValueError(f"axes must be two of {', '.join(COORDINATES)}, got {self.axes!r}")
        if min(self.shape) < 1:
            raise ValueError(f"shape must be two positive numbers, got {self.shape!r}")

    @property
    def ticks(self) -> tuple[Array, Array]:
        """The values across and up."""
        across, up = (
            np.linspace(low, high, number)
            for (low, high), number in zip(self.ranges, self.shape, strict=True)
        )
        return across, up

    @property
    def states(self) -> Array:
        """(across·up, 4); `values.reshape(up, across)` makes a picture of one number a state."""
        across, up = np.meshgrid(*self.ticks)
        states = np.tile(np.array(self.base), (across.size, 1))
        states[:, COORDINATES.index(self.axes[0])] = across.ravel()
        states[:, COORDINATES.index(self.axes[1])] = up.ravel()
        return states


def starts_of(grid: Slice | ArrayLike) -> Array:
    states = grid.states if isinstance(grid, Slice) else np.asarray(grid, np.float64)
    if states.ndim != 2 or states.shape[1] != 4 or not len(states):
        raise ValueError(f"grid must be a Slice or states (N, 4), got shape {states.shape}")
    if not np.isfinite(states).all():
        raise ValueError("grid must hold finite states, got one that is not")
    return np.ascontiguousarray(states)
