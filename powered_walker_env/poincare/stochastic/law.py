"""The law of the next step on a grid, and the sums over it: expectations and best choices.

From node i under choice a a step leads, with the weight of each of its branches, to a place
m + G ξ + B(ξ), ξ standard normal and B quadratic, and brings a reward; what is missing of the
weights has fallen, and counts nothing. Places are counted in nodes. An expectation is a sum over
points of ξ, each interpolated between its eight nodes: linear along each axis, and
corrected for the bend of the table, −½ x (1 − x) δ², with the second differences of the nearest
node, within the least and the greatest of the eight. (Linear interpolation alone works like
another disturbance, of variance h² x (1 − x).)
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import scipy.sparse
from numpy.typing import NDArray

from powered_walker_env.poincare.stochastic.grid import Grid
from powered_walker_env.poincare.stochastic.sums import best_choices, spread
from powered_walker_env.simulation.strides import Array
from powered_walker_env.simulation.threads import run_in_slices

Singles = NDArray[np.float32]
REACH = 4.5  # standard deviations, of equal spaces at most
MANY = 11  # points of equal spaces, at least: fewer are too far apart to be exact
#: Of a push, across a cliff and along it; and where nothing says which way a cliff lies.
ACROSS, ANYWHERE = (31, 3), (15, 15)


@dataclass(frozen=True, eq=False)
class Law:
    """Where steps lead; the rows of a node follow one another, those of a choice, too."""

    grid: Grid
    begin: NDArray[np.int64] = field(repr=False)  # (N + 1,) the first row of each node
    choice: NDArray[np.int32] = field(repr=False)  # (M,) number of the choice
    weight: Array = field(repr=False)  # (M,) of the branch
    mean: Singles = field(repr=False)  # (M, 3) in nodes, before the grid's curve
    gain: Singles = field(repr=False)  # (M, 3, 2) in nodes by a standard deviation
    reward: Singles = field(repr=False)  # (M,) expected, if it walks
    points: Array = field(repr=False)  # (Q, 2) of ξ
    weights: Array = field(repr=False)  # (Q,) of the points, of sum 1
    #: (M, 3, 3) in nodes, by ξ₁², ξ₁ξ₂ and ξ₂²; left out, none
    bend: Singles = field(repr=False, default_factory=lambda: np.zeros((0, 3, 3), np.float32))

    def __post_init__(self) -> None:
        if len(self.bend) != self.rows:
            object.__setattr__(self, "bend", np.zeros((self.rows, 3, 3), np.float32))

    @property
    def rows(self) -> int:
        """M."""
        return len(self.choice)

    def best(
        self,
        values: Array,
        discount: float = 1.0,
        outside: float = 0.0,
        gain: float = 1.0,
        *,
        curved: bool = True,
    ) -> tuple[Array, NDArray[np.int32]]:
        """(N,) greatest over the choices of reward + discount · value after, and (N,) the choice.

        Args:
            values: (N,) at the nodes.
            discount: of what comes after.
            outside: what counts as the value off the grid.
            gain: what the rewards are multiplied by.
            curved: whether the interpolation follows the bends.

        Returns:
            Where no choice walks the value is 0, and the choice −1.
        """
        best, chosen = np.zeros(self.grid.size), np.full(self.grid.size, -1, np.int32)
        table = np.ascontiguousarray(values, np.float64)
        counts = np.array(self.grid.table_shape)
        bends = second_differences(table, self.grid.table_shape)
        if not curved:
            bends[:] = 0.0

        def work(part: slice) -> None:
            first, beyond, _ = part.indices(self.grid.size)
            best_choices(
                first, beyond, table, bends, counts, self.grid.counted_curve, self.begin,
                self.choice, self.weight, self.mean, self.gain, self.bend, self.reward,
                self.points, self.weights, discount, outside, gain, best, chosen,
            )  # fmt: skip

        run_in_slices(work, self.grid.size)
        return best, chosen

    def under(self, chosen: NDArray[np.int32]) -> Law:
        """The law where the choice (N,) at every node is made; −1: none, it falls."""
        nodes = np.repeat(np.arange(self.grid.size), np.diff(self.begin))
        return self._with(self.choice == chosen[nodes], np.zeros_like(self.choice))

    def among(self, kept: NDArray[np.bool_]) -> Law:
        """The law with some of the choices left, numbered anew in their order."""
        renamed = (np.cumsum(kept) - 1).astype(self.choice.dtype)
        return self._with(kept[self.choice], renamed[self.choice])

    def _with(self, keep: NDArray[np.bool_], choice: NDArray[np.int32]) -> Law:
        """The law with some of its rows, whose choices are renamed."""
        nodes = np.repeat(np.arange(self.grid.size), np.diff(self.begin))
        begin = np.concatenate([[0], np.cumsum(np.bincount(nodes[keep], minlength=self.grid.size))])
        return Law(
            self.grid, begin, choice[keep], self.weight[keep], self.mean[keep], self.gain[keep],
            self.reward[keep], self.points, self.weights, self.bend[keep],
        )  # fmt: skip

    def matrix(self) -> scipy.sparse.csr_array:
        """(N, N) probabilities between nodes of a law with one choice; rows short of 1 fall.

        Interpolated linearly: with the correction for bends they would be no probabilities.

        Raises:
            ValueError: a law with choices left.
        """
        if self.rows and self.choice.any():
            raise ValueError("law must have one choice at every node, got several; take `under`")
        size = self.rows * len(self.weights)
        if size > 40_000_000:
            raise ValueError(
                f"grid must be smaller for a matrix, got {self.grid.shape}, {size:,} places to "
                "write down; survival and first passage need none"
            )
        nodes = np.repeat(np.arange(self.grid.size), np.diff(self.begin))
        index = np.empty(8 * size, np.int64)
        share = np.empty(8 * size)
        spread(
            np.array(self.grid.table_shape), self.grid.counted_curve, self.weight, self.mean,
            self.gain, self.bend, self.points, self.weights, index, share,
        )  # fmt: skip
        rows = np.repeat(nodes, 8 * len(self.weights))
        there = share > 0.0
        shape = (self.grid.size, self.grid.size)
        matrix = scipy.sparse.coo_array((share[there], (rows[there], index[there])), shape)
        return matrix.tocsr()


def normal_points(counts: int | tuple[int, int]) -> tuple[Array, Array]:
    """(Q, 2) points and (Q,) weights of two standard normal numbers, Q the counts' product.

    Gauss and Hermite's, exact for polynomials of a degree below 2·count in each; of two counts
    each, from `MANY` on, is of equal spaces. Values may fall off at a cliff there, and a best
    choice made among Gauss and Hermite's points, far apart in the tails, puts it between two.
    """
    one = isinstance(counts, int | np.integer)
    (x, v), (y, w) = (
        np.polynomial.hermite_e.hermegauss(count) if one or count < MANY else _equal_spaces(count)
        for count in ((counts, counts) if isinstance(counts, int | np.integer) else counts)
    )
    points = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    return points, np.outer(v / v.sum(), w / w.sum()).ravel()


def push_counts(grid: Grid) -> tuple[int, int]:
    """Counts of points of pushes: many across a cliff, whose way an aligned grid knows."""
    return ACROSS if grid.aligned else ANYWHERE


def _equal_spaces(count: int) -> tuple[Array, Array]:
    """Points and weights of the trapezoidal rule, its error at the ends as large as in between.

    Cut off at R, with spaces of h, it misses about e^(−R²/2) and e^(−2π²/h²).
    """
    reach = min(REACH, math.sqrt(math.pi * (count - 1)))
    x = np.linspace(-reach, reach, count)
    return x, np.exp(-0.5 * x**2)


def turned(gain: Array, bend: Array) -> tuple[Array, Array]:
    """(M, 3, 2), (M, 3, 3) the same noise, its second number of no effect along the first axis.

    Two independent normal numbers may be turned: points may be many along the axis where values
    change fast, and few across it. To first order: a bend stays.
    """
    along, across = gain[:, 0, 0], gain[:, 0, 1]
    size = np.hypot(along, across)
    still = size == 0.0
    c = (np.where(still, 1.0, along) / np.where(still, 1.0, size))[:, np.newaxis]
    s = (np.where(still, 0.0, across) / np.where(still, 1.0, size))[:, np.newaxis]
    one, two = gain[:, :, 0], gain[:, :, 1]
    p, q, r = bend[:, :, 0], bend[:, :, 1], bend[:, :, 2]
    return (
        np.stack([c * one + s * two, c * two - s * one], axis=2),
        np.stack([
            c * c * p + c * s * q + s * s * r,
            2.0 * c * s * (r - p) + (c * c - s * s) * q,
            s * s * p - c * s * q + c * c * r,
        ], axis=2),
    )  # fmt: skip


def second_differences(values: Array, shape: tuple[int, int, int]) -> Array:
    """(N, 3) second differences of a table along each axis; 0 at its ends."""
    table = values.reshape(shape)
    bends = np.zeros((*shape, 3))
    for axis in range(3):
        if shape[axis] > 2:
            along = np.moveaxis(bends[..., axis], axis, 0)
            along[1:-1] = np.diff(np.moveaxis(table, axis, 0), 2, axis=0)
    return bends.reshape(-1, 3)
