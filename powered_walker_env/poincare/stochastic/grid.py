"""A grid on a section, with axes of its own: where the law of the next step is tabulated.

Stride maps are far from normal: a cloud of pushed walkers is a hundred times longer than thick
and lies aslant to the coordinates. So a grid is a box in any frame: the points p = centre +
frame · y with every y in [−1, 1]. Between its nodes values are interpolated, linear along each of
its axes.

Where a step leads may depend on little but one number, and that not a linear one. So the first
coordinate may be curved: with y₁, y₂, y₃ along the frame, the nodes are equal steps of

    z₁ = y₁ exp(c₀ y₂ + c₁ y₃) + c₂ y₂² + c₃ y₂ y₃ + c₄ y₃²,    z₂ = y₂,    z₃ = y₃,

which rises with y₁ everywhere and has an exact inverse (`alignment.py` fits it).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from powered_walker_env.model.checks import whole_number
from powered_walker_env.poincare.sections import Section
from powered_walker_env.poincare.stochastic.plane import LandingPlane
from powered_walker_env.simulation.strides import Array

STRAIGHT = (0.0,) * 5
STEEPEST = 20.0  # of |c₀| + |c₁|: beyond, nodes are nowhere
DIMENSIONS = 3  # of the tables; a section of fewer numbers has one node along the others
MOST_NODES = 4_000_000


AnySection = Section | LandingPlane


@dataclass(frozen=True, eq=False)
class Grid:
    """Nodes in a box of k numbers.

    Raises:
        ValueError, TypeError: a frame that is no basis, counts below 2, too many nodes.
    """

    centre: Array = field(repr=False)  # (k,)
    frame: Array = field(repr=False)  # (k, k) columns: from the centre to the middle of each side
    shape: tuple[int, ...]  # (k,) nodes along each of its axes
    section: AnySection | None = None  # of a walker; None: of another map
    curve: tuple[float, ...] = STRAIGHT  # (5,) c of the first coordinate

    def __post_init__(self) -> None:
        centre = np.atleast_1d(np.asarray(self.centre, np.float64))
        frame = np.atleast_2d(np.asarray(self.frame, np.float64))
        size = len(centre)
        if not 1 <= size <= DIMENSIONS or frame.shape != (size, size):
            raise ValueError(
                f"centre and frame must be k numbers and (k, k), k from 1 to {DIMENSIONS}, got "
                f"{centre.shape} and {frame.shape}"
            )
        if not (np.isfinite(centre).all() and np.isfinite(frame).all()):
            raise ValueError(
                f"centre and frame must be finite, got {self.centre!r}, {self.frame!r}"
            )
        if np.linalg.cond(frame / np.abs(frame).max()) > 1e12:
            raise ValueError(f"frame must have axes that span the section, got {self.frame!r}")
        shape = tuple(whole_number("shape", int(n), 2) for n in self.shape)
        if len(shape) != size or math.prod(shape) > MOST_NODES:
            raise ValueError(
                f"shape must be {size} counts of at most {MOST_NODES:,} nodes in all, got "
                f"{self.shape!r}"
            )
        curve = tuple(float(c) for c in self.curve)
        if len(curve) != len(STRAIGHT) or not np.isfinite(curve).all():
            raise ValueError(f"curve must be {len(STRAIGHT)} finite numbers, got {self.curve!r}")
        if abs(curve[0]) + abs(curve[1]) > STEEPEST:
            raise ValueError(
                f"curve must have |c0| + |c1| of at most {STEEPEST}, got {self.curve!r}"
            )
        for name, value in (
            ("centre", centre), ("frame", frame), ("shape", shape), ("curve", curve),
        ):  # fmt: skip
            object.__setattr__(self, name, value)

    @classmethod
    def box(
        cls,
        low: ArrayLike,
        high: ArrayLike,
        shape: Sequence[int],
        section: AnySection | None = None,
    ) -> Grid:
        """The grid between two corners, along the coordinates.

        Raises:
            ValueError: corners that do not rise.
        """
        bottom, top = np.atleast_1d(low).astype(float), np.atleast_1d(high).astype(float)
        if bottom.shape != top.shape or not (bottom < top).all():
            raise ValueError(f"low must be below high in all, got {low!r} and {high!r}")
        return cls(0.5 * (bottom + top), np.diag(0.5 * (top - bottom)), tuple(shape), section)

    @property
    def size(self) -> int:
        """How many nodes."""
        return math.prod(self.shape)

    @property
    def table_shape(self) -> tuple[int, int, int]:
        """The shape of a table of values: three counts, 1 where there is no axis."""
        first, second, third = (*self.shape, *(1,) * (DIMENSIONS - len(self.shape)))
        return first, second, third

    @property
    def points(self) -> Array:
        """(N, k) the nodes, the last axis running fastest."""
        axes = [np.linspace(-1.0, 1.0, count) for count in self.shape]
        y = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))
        _, second, third = _three(y)
        c = self.curve
        level = c[2] * second**2 + c[3] * second * third + c[4] * third**2
        y[:, 0] = (y[:, 0] - level) * np.exp(-c[0] * second - c[1] * third)
        points: Array = self.centre + y @ self.frame.T
        return points

    @property
    def states(self) -> Array:
        """(N, 4) the walker's states at the nodes.

        Raises:
            ValueError: a grid of no walker's section.
        """
        if self.section is None:
            raise ValueError("grid must lie on the section of a walker to have states, got none")
        return self.section.states(self.points)

    def places(self, points: Array) -> Array:
        """(N, 3) where points (N, k) lie, counted in nodes along each axis from 0."""
        y = self._along(points - self.centre)
        first, second, third = _three(y)
        c = self.curve
        level = c[2] * second**2 + c[3] * second * third + c[4] * third**2
        y[:, 0] = first * np.exp(c[0] * second + c[1] * third) + level
        return self._counted(0.5 * (y + 1.0))

    def straight_places(self, points: Array) -> Array:
        """(N, 3) the same before the first coordinate is curved: linear in the points."""
        return self._counted(0.5 * (self._along(points - self.centre) + 1.0))

    def steps(self, changes: Array) -> Array:
        """(N, 3) changes (N, k) of points, counted in nodes along each axis, not curved."""
        return self._counted(0.5 * self._along(changes))

    @property
    def aligned(self) -> bool:
        """Whether its first coordinate is curved."""
        return any(self.curve)

    @property
    def counted_curve(self) -> Array:
        """(8,) the curve's c, with straight places counted in nodes, and the middle's place."""
        middle: Array = 0.5 * (np.array(self.table_shape, np.float64) - 1.0)
        half = np.maximum(middle, 0.5)
        c = np.array(self.curve)
        per = [half[1], half[2], half[1] ** 2 / half[0], half[1] * half[2] / half[0],
               half[2] ** 2 / half[0]]  # fmt: skip
        counted: Array = np.concatenate([c / np.array(per), middle])
        return counted

    def _along(self, changes: Array) -> Array:
        along: Array = np.linalg.solve(self.frame, changes.T).T.astype(np.float64)
        return along

    def _counted(self, shares: NDArray[Any]) -> Array:
        counted = np.zeros((len(shares), DIMENSIONS))
        counted[:, : len(self.shape)] = shares * (np.array(self.shape) - 1)
        return counted

    def holds(self, places: Array) -> NDArray[np.bool_]:
        """(N,) whether places (N, 3) are inside."""
        last = np.array(self.table_shape) - 1
        return np.all((places >= 0) & (places <= last), axis=1)

    def resized(self, shape: Sequence[int]) -> Grid:
        """The same box with other counts."""
        return Grid(self.centre, self.frame, tuple(shape), self.section, self.curve)

    def coarser(self, share: float, fewest: int = 4) -> Grid:
        """The same box with a share of the nodes along each axis, no fewer than some."""
        return self.resized([min(n, max(fewest, round(share * n))) for n in self.shape])

    def at(self, table: Array, points: Array) -> Array:
        """(N, ...) values of a table (nodes, ...) at points (N, k); those outside are moved in."""
        last = np.array(self.table_shape) - 1
        places = np.clip(np.nan_to_num(self.places(points)), 0, last)
        floor = np.minimum(places.astype(np.int64), np.maximum(last - 1, 0))
        share = places - floor
        found = np.zeros((len(points), *table.shape[1:]))
        for corner in np.ndindex(2, 2, 2):
            at = np.minimum(floor + corner, last)
            weight = np.prod(np.where(corner, share, 1.0 - share), axis=1)
            rows = np.ravel_multi_index(tuple(at.T), self.table_shape)
            found += table[rows] * weight.reshape(-1, *(1,) * (table.ndim - 1))
        return found


def _three(y: Array) -> tuple[Array | float, Array | float, Array | float]:
    """Columns of (N, k), 0 where there are none."""
    columns = [*y.T, 0.0, 0.0]
    return columns[0], columns[1], columns[2]
