"""The law of the next step on a grid, and the sums over it: expectations and best choices.

From node i under choice a a step leads, with the weight of each of its branches, to a place
m + G ξ, ξ standard normal, and brings a reward; what is missing of the weights has fallen, and
counts nothing. Places are counted in nodes. An expectation is a sum over points of ξ
(Gauss and Hermite's), each interpolated between its eight nodes: linear along each axis, and
corrected for the bend of the table, −½ x (1 − x) δ², with the second differences of the nearest
node, within the least and the greatest of the eight. (Linear interpolation alone works like
another disturbance, of variance h² x (1 − x).)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import scipy.sparse
from numpy.typing import NDArray

from powered_walker_env.compiled.decorators import internal, kernel
from powered_walker_env.poincare.stochastic.grid import Grid
from powered_walker_env.simulation.strides import Array
from powered_walker_env.simulation.threads import run_in_slices


SMOOTH = 0.1  # of the value: the most that the drops to both neighbours may add up to
Singles = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Law:
    """Where steps lead; the rows of a node follow one another, those of a choice, too."""

    grid: Grid
    begin: NDArray[np.int64] = field(repr=False)  # (N + 1,) the first row of each node
    choice: NDArray[np.int32] = field(repr=False)  # (M,) number of the choice
    weight: Array = field(repr=False)  # (M,) of the branch
    mean: Singles = field(repr=False)  # (M, 3) in nodes
    gain: Singles = field(repr=False)  # (M, 3, 2) in nodes by a standard deviation
    reward: Singles = field(repr=False)  # (M,) expected, if it walks
    points: Array = field(repr=False)  # (Q, 2) of ξ
    weights: Array = field(repr=False)  # (Q,) of the points, of sum 1

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
        between: Sequence[int] = (),
    ) -> tuple[Array, Array]:
        """(N,) greatest over the choices of reward + discount · value after, and (N, 2) which.

        Args:
            values: (N,) at the nodes.
            discount: of what comes after.
            outside: what counts as the value off the grid.
            gain: what the rewards are multiplied by.
            curved: whether the interpolation follows the bends.
            between: counts, if the choices are numbered along a grid of one or two axes: then
                the greatest of the parabolas through the best and its two neighbours counts.

        Returns:
            The choice as places on that grid (else its number, and 0), in between where the
            parabola is; where no choice walks the value 0, and the place −1.
        """
        best, chosen = np.zeros(self.grid.size), np.full((self.grid.size, 2), -1.0)
        table = np.ascontiguousarray(values, np.float64)
        counts = np.array(self.grid.table_shape)
        bends = second_differences(table, self.grid.table_shape)
        if not curved:
            bends[:] = 0.0
        most = 1 + (int(self.choice.max()) if self.rows else 0)
        first, second = (*between, 1, 1)[:2] if between else (most, 1)

        def work(part: slice) -> None:
            best_choices(
                part.start, part.stop, table, bends, counts, self.begin, self.choice, self.weight,
                self.mean, self.gain, self.reward, self.points, self.weights, discount, outside,
                gain, first, second, len(between) > 0, best, chosen,
            )  # fmt: skip

        run_in_slices(work, self.grid.size)
        return best, chosen

    def under(self, chosen: NDArray[np.int64]) -> Law:
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
        taken = (choice, self.weight, self.mean, self.gain, self.reward)
        return Law(self.grid, begin, *(each[keep] for each in taken), self.points, self.weights)

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
            np.array(self.grid.table_shape), self.weight, self.mean, self.gain, self.points,
            self.weights, index, share,
        )  # fmt: skip
        rows = np.repeat(nodes, 8 * len(self.weights))
        there = share > 0.0
        shape = (self.grid.size, self.grid.size)
        matrix = scipy.sparse.coo_array((share[there], (rows[there], index[there])), shape)
        return matrix.tocsr()


def normal_points(count: int) -> tuple[Array, Array]:
    """(Q, 2) points and (Q,) weights of two standard normal numbers, Q = count².

    Gauss and Hermite's: exact for polynomials of a degree below 2·count in each.
    """
    x, w = np.polynomial.hermite_e.hermegauss(count)
    w = w / w.sum()
    points = np.stack(np.meshgrid(x, x, indexing="ij"), axis=-1).reshape(-1, 2)
    return points, np.outer(w, w).ravel()


def second_differences(values: Array, shape: tuple[int, int, int]) -> Array:
    """(N, 3) second differences of a table along each axis; 0 at its ends."""
    table = values.reshape(shape)
    bends = np.zeros((*shape, 3))
    for axis in range(3):
        if shape[axis] > 2:
            inner = [slice(None)] * 3
            inner[axis] = slice(1, -1)
            bends[(*inner, axis)] = np.diff(table, 2, axis=axis)
    return bends.reshape(-1, 3)


@internal
def _value_at(values, bends, counts, a, b, c, outside):  # type: ignore[no-untyped-def]
    """The table interpolated at a place; `outside` off the grid."""
    n, m, o = counts[0], counts[1], counts[2]
    if not (a >= 0.0 and b >= 0.0 and c >= 0.0 and a <= n - 1 and b <= m - 1 and c <= o - 1):
        return outside
    i, j, k = min(int(a), max(n - 2, 0)), min(int(b), max(m - 2, 0)), min(int(c), max(o - 2, 0))
    x, y, z = a - i, b - j, c - k
    right = m * o if n > 1 else 0
    up = o if m > 1 else 0
    ahead = 1 if o > 1 else 0
    base = (i * m + j) * o + k
    at = base + (right if x > 0.5 else 0) + (up if y > 0.5 else 0) + (ahead if z > 0.5 else 0)
    bend = x * (1.0 - x) * bends[at, 0] + y * (1.0 - y) * bends[at, 1] + z * (1.0 - z) * bends[at, 2]
    p, q = values[base], values[base + ahead]
    r, s = values[base + up], values[base + up + ahead]
    base += right
    t, u = values[base], values[base + ahead]
    v, w = values[base + up], values[base + up + ahead]
    front = (1.0 - y) * ((1.0 - z) * p + z * q) + y * ((1.0 - z) * r + z * s)
    back = (1.0 - y) * ((1.0 - z) * t + z * u) + y * ((1.0 - z) * v + z * w)
    found = (1.0 - x) * front + x * back - 0.5 * bend
    low = min(min(min(p, q), min(r, s)), min(min(t, u), min(v, w)))
    high = max(max(max(p, q), max(r, s)), max(max(t, u), max(v, w)))
    return min(max(found, low), high)


@internal
def _peak(below, here, above):  # type: ignore[no-untyped-def]
    """How far the parabola through three values at −1, 0, 1 rises above the middle, and where."""
    bend, slope = below - 2.0 * here + above, 0.5 * (above - below)
    if not -SMOOTH * abs(here) < bend < 0.0:  # no peak, or an edge that no parabola follows
        return 0.0, 0.0
    at = min(max(-slope / bend, -0.5), 0.5)
    return at * slope + 0.5 * at * at * bend, at


@kernel
def best_choices(
    first, beyond, values, bends, counts, begin, choice, weight, mean, gain, reward, points,
    weights, discount, outside, factor, across, along, between, best, chosen,
):  # type: ignore[no-untyped-def]  # fmt: skip
    """`Law.best` of the nodes from `first` to before `beyond`; choices are across · along."""
    worth = np.empty(across * along)
    for node in range(first, beyond):
        worth[:] = -np.inf
        for row in range(begin[node], begin[node + 1]):
            expected = 0.0
            for q in range(weights.shape[0]):
                u, v = points[q, 0], points[q, 1]
                a = mean[row, 0] + gain[row, 0, 0] * u + gain[row, 0, 1] * v
                b = mean[row, 1] + gain[row, 1, 0] * u + gain[row, 1, 1] * v
                c = mean[row, 2] + gain[row, 2, 0] * u + gain[row, 2, 1] * v
                expected += weights[q] * _value_at(values, bends, counts, a, b, c, outside)
            if worth[choice[row]] == -np.inf:
                worth[choice[row]] = 0.0
            worth[choice[row]] += weight[row] * (factor * reward[row] + discount * expected)
        winner = np.argmax(worth)
        if worth[winner] == -np.inf:
            best[node], chosen[node, 0], chosen[node, 1] = 0.0, -1.0, -1.0
            continue
        i, j = winner // along, winner % along
        total, x, y = worth[winner], 0.0, 0.0
        if between and 0 < i < across - 1:
            rise, x = _peak(worth[winner - along], worth[winner], worth[winner + along])
            total += rise
        if between and 0 < j < along - 1:
            rise, y = _peak(worth[winner - 1], worth[winner], worth[winner + 1])
            total += rise
        best[node], chosen[node, 0], chosen[node, 1] = total, i + x, j + y


@kernel
def spread(counts, weight, mean, gain, points, weights, index, share):  # type: ignore[no-untyped-def]
    """The nodes and shares that each row and point of ξ leads to; share 0 off the grid."""
    n, m, o = counts[0], counts[1], counts[2]
    number = 0
    for row in range(weight.shape[0]):
        for q in range(weights.shape[0]):
            u, v = points[q, 0], points[q, 1]
            a = mean[row, 0] + gain[row, 0, 0] * u + gain[row, 0, 1] * v
            b = mean[row, 1] + gain[row, 1, 0] * u + gain[row, 1, 1] * v
            c = mean[row, 2] + gain[row, 2, 0] * u + gain[row, 2, 1] * v
            inside = a >= 0.0 and b >= 0.0 and c >= 0.0
            inside = inside and a <= n - 1 and b <= m - 1 and c <= o - 1
            i, j, k = 0, 0, 0
            if inside:
                i = min(int(a), max(n - 2, 0))
                j = min(int(b), max(m - 2, 0))
                k = min(int(c), max(o - 2, 0))
            for corner in range(8):
                di, dj, dk = corner >> 2, corner >> 1 & 1, corner & 1
                x = a - i if di else 1.0 - (a - i)
                y = b - j if dj else 1.0 - (b - j)
                z = c - k if dk else 1.0 - (c - k)
                part = weight[row] * weights[q] * x * y * z if inside else 0.0
                if part > 0.0:
                    index[number] = ((i + di) * m + j + dj) * o + k + dk
                else:
                    index[number], part = 0, 0.0
                share[number] = part
                number += 1
