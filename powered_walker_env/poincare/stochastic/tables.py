"""Tables of controls over a grid of the section, as policies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
import scipy.ndimage
from numpy.typing import NDArray

from powered_walker_env.model.powering import scheme_of
from powered_walker_env.poincare.gaits import Gait
from powered_walker_env.poincare.stochastic.grid import Grid
from powered_walker_env.poincare.tolerances import FATE_RTOL
from powered_walker_env.simulation.strides import Array

NEAR = np.array([-1.0, -0.5, 0.0, 0.5, 1.0])  # of the step, controls tried about one


@dataclass(frozen=True, eq=False)
class TablePolicy:
    """A table of controls over a grid of the section, linear in between: a policy.

    A state is carried to the section first; beyond the grid the nearest control holds.
    """

    grid: Grid = field(repr=False)
    numbers: Array = field(repr=False)  # (N, k) of the controls at the nodes
    scheme: str
    high: Array  # (k,) upper bounds of the numbers
    on_section: ClassVar[bool] = True

    def __repr__(self) -> str:
        return f"TablePolicy({self.scheme}, {self.grid.shape} nodes)"

    def __call__(self, states: Array) -> Array:
        """(N, k) numbers of the controls."""
        assert self.grid.section is not None
        points = self.grid.section.points(states, FATE_RTOL)
        lost = np.isnan(points).any(axis=1)  # they fall whatever is done
        points[lost] = self.grid.centre
        return self.grid.at(self.numbers, points)


def table_policy(grid: Grid, numbers: Array, gait: Gait, high: Array) -> TablePolicy:
    """The policy of controls (N, k) at the nodes."""
    return TablePolicy(grid, numbers, scheme_of(gait.control).name, high)


def filled(grid: Grid, known: NDArray[np.bool_], numbers: Array) -> Array:
    """(N, k) numbers where they are known (N,), and those of the nearest node that has them."""
    unknown = ~known.reshape(grid.table_shape)
    if not unknown.any() or unknown.all():
        return numbers
    nearest = scipy.ndimage.distance_transform_edt(
        unknown, return_distances=False, return_indices=True
    )
    rows = np.arange(grid.size).reshape(grid.table_shape)[tuple(nearest)]
    return numbers[rows.ravel()]


def controls_between(low: Array, high: Array, counts: Sequence[int]) -> Array:
    """(A, k) the controls of a grid between bounds, the last number running fastest."""
    axes = [np.linspace(*ends) for ends in zip(low, high, counts, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))


def controls_about(numbers: Array, step: float, low: Array, high: Array) -> Array:
    """(N, A, k) controls about those of (N, k), which are in the middle, within bounds.

    Args:
        step: how far from them, in half ranges.
    """
    k = numbers.shape[1]
    near = np.stack(np.meshgrid(*[NEAR] * k, indexing="ij"), axis=-1).reshape(-1, k)
    about = numbers[:, np.newaxis] + near * (step * 0.5 * (high - low))
    clipped: Array = np.clip(about, low, high)
    return clipped
