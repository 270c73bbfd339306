"""Viability: which states can be saved at all, by any control within bounds.

The ceiling for every controller, learnt or not. From each start a tree of control
sequences is searched, stride by stride, with the exact stride map:

- *saved*: a sequence was found that leads into the trapping region (`trapping.py`) of
  the regulated gait. Up to that region's own check by samples this is certain: a lower
  bound of the viable set.
- *lost*: every sequence of the grid of controls ends in a fall within so many strides.
  Certain for the grid, but for walkers that came so near to one another (`CELL`) that one
  stood for both; sampled for the controls between its points: an estimate of an upper
  bound, better the finer the grid.
- *open*: neither. The search keeps the most promising walkers (least cost to go of the
  regulator) and as many that are unlike them; where more were left, it may have missed a
  rescue: more `width` and `depth` decide more.

A finer grid alone does not leave more open: its walkers fill the same cells. (Round feet,
200 starts: 57 lost at once; after a stride or more 20 on 5 by 5 controls, 14 on 9 by 9; of
these none is saved by a search sixteen times as wide on 13 by 13.)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from powered_walker_env.model.checks import whole_number
from powered_walker_env.model.mechanics.packing import pack
from powered_walker_env.model.state import natural_units
from powered_walker_env.poincare.gaits import Gait, find_gait
from powered_walker_env.poincare.maps import StrideMap
from powered_walker_env.poincare.regions.slices import Slice, starts_of
from powered_walker_env.poincare.regulator import Regulator, regulate
from powered_walker_env.poincare.stability.trapping import Trap, trap_around
from powered_walker_env.poincare.tolerances import FATE_RTOL
from powered_walker_env.poincare.work.pieces import RunOptions, blocks, run_pieces
from powered_walker_env.simulation.strides import Array, run_batch

ROWS = 32  # starts of a piece: thousands of strides each
CELL = 0.05  # natural units: walkers of one start within such a cube count as one


@dataclass(frozen=True, eq=False)
class Viability:
    """What the best control can do from each start."""

    gait: Gait  # under its constant control, the middle of the bounds
    low: Array  # (k,) bounds of the control; of the motor: switch angle, stall torque
    high: Array
    grid: tuple[int, ...]  # (k,) values of each tried, besides the regulator's own
    depth: int  # strides searched
    width: int  # walkers kept of each start from stride to stride: so many, twice
    states: Array = field(repr=False)  # (N, 4) the starts
    saved: NDArray[np.int64] = field(repr=False)  # (N,) strides to the safe region; −1: not found
    lost: NDArray[np.int64] = field(repr=False)  # (N,) strides that any sequence walks before it
    # falls, if all do; −1: not known to be lost
    walked: NDArray[np.int64] = field(repr=False)  # (N,) strides of the longest sequence found
    first_control: Array = field(repr=False)  # (N, k) of the best sequence found

    @property
    def bounds(self) -> tuple[float, float]:
        """Shares of the starts: surely viable, and not known to be lost."""
        return float(np.mean(self.saved >= 0)), float(np.mean(self.lost < 0))


def viable_states(
    gait: Gait,
    half_range: Sequence[float],
    states: Slice | ArrayLike,
    *,
    grid: int | Sequence[int] = 5,
    depth: int = 8,
    width: int = 8,
    **run: Unpack[RunOptions],
) -> Viability:
    """Search for rescues from every start, by the best controls within bounds.

    Args:
        gait: of one stride under a constant control.
        half_range: (k,) how far the numbers of the control (of the motor: switch angle,
            rad, and stall torque, N m) may go from the gait's own.
        states: a `Slice`, or (N, 4).
        grid: values of each number tried at every stride, the bounds included; one count
            for all, or one for each.
        depth: strides within which a walker must be safe.
        width: walkers kept of each start from one stride to the next: the so many most
            promising, and as many unlike them.
        run: where it runs, see `run_pieces`.

    Raises:
        ValueError: bad bounds or counts; a regulated gait that is not stable.
        TypeError: counts that are no whole numbers.
    """
    counts = _counts(grid, len(half_range))
    depth, width = whole_number("depth", depth, 1), whole_number("width", width, 1)
    starts, regulator = starts_of(states), regulate(gait, half_range)
    trap = trap_around(find_gait(gait.params, regulator, gait.state))
    corners = [
        np.linspace(low, high, number)
        for low, high, number in zip(regulator.low, regulator.high, counts, strict=True)
    ]
    controls = np.stack(np.meshgrid(*corners, indexing="ij"), axis=-1).reshape(-1, len(counts))
    stride_map = StrideMap(gait.params, gait.control, FATE_RTOL)
    work = [
        _Work(stride_map, regulator, trap, controls, starts[part], depth, width)
        for part in blocks(len(starts), ROWS)
    ]
    found = [np.concatenate(parts) for parts in zip(*run_pieces(search, work, **run), strict=True)]
    return Viability(gait, regulator.low, regulator.high, counts, depth, width, starts, *found)


def _counts(grid: int | Sequence[int], numbers: int) -> tuple[int, ...]:
    """How many values of each number of the control are tried."""
    given = tuple(grid) if isinstance(grid, Sequence | np.ndarray) else (grid,) * numbers
    if len(given) != numbers:
        raise ValueError(f"grid must be one count or {numbers}, got {grid!r}")
    return tuple(whole_number("grid", count, 2) for count in given)


class _Work(NamedTuple):
    stride_map: StrideMap
    regulator: Regulator
    trap: Trap
    controls: Array  # (G, k)
    states: Array
    depth: int
    width: int


class _Walkers(NamedTuple):
    """Walkers of the search: the start each came from, its state, its first control."""

    start: NDArray[np.int64]
    state: Array
    first: Array

    def take(self, rows: NDArray[np.int64] | NDArray[np.bool_]) -> _Walkers:
        return _Walkers(self.start[rows], self.state[rows], self.first[rows])


def search(work: _Work) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64], Array]:
    """(saved, lost, walked, control) of the starts of a piece."""
    count = len(work.states)
    saved, lost, walked = (np.full(count, value) for value in (-1, -1, 0))
    control, complete = work.regulator(work.states), np.ones(count, np.bool_)
    now = _Walkers(np.arange(count), work.states, control.copy())
    for k in range(work.depth + 1):
        safe = work.trap.holds(now.state)
        saved[now.start[safe]] = walked[now.start[safe]] = k
        control[now.start[safe][::-1]] = now.first[safe][::-1]  # the least costly one's stays
        now = now.take(~np.isin(now.start, now.start[safe]))
        if k == work.depth or not len(now.start):
            break
        alive = np.unique(now.start)
        now = _children(work, now, first=k == 0)
        walked[now.start], fallen = k + 1, np.setdiff1d(alive, now.start)
        lost[fallen[complete[fallen]]] = k
        now, cut = _kept(work, now)
        complete[cut] = False
        control[now.start[::-1]] = now.first[::-1]
    return saved, lost, walked, control


def _children(work: _Work, now: _Walkers, first: bool) -> _Walkers:
    """The walkers that are still up after a stride with each control of the grid."""
    each = len(work.controls) + 1
    own = work.regulator(now.state)[:, np.newaxis]
    grid = np.broadcast_to(work.controls, (len(now.state), *work.controls.shape))
    controls = np.concatenate([own, grid], axis=1).reshape(len(now.state) * each, -1)
    states, row = np.repeat(now.state, each, axis=0), pack(work.stride_map.params)[np.newaxis]
    powered, rtol = work.stride_map.scheme, work.stride_map.rtol
    batch = run_batch(powered.cycle, states, powered.rows(controls), row, np.zeros(1), rtol)
    firsts = controls if first else np.repeat(now.first, each, axis=0)
    return _Walkers(np.repeat(now.start, each), batch.state, firsts).take(batch.walked)


def _kept(work: _Work, now: _Walkers) -> tuple[_Walkers, NDArray[np.int64]]:
    """Of each start the `width` least costly walkers and as many of other cells, in order.

    And the starts of which more cells had walkers.
    """
    ordered = now.take(np.lexsort((work.regulator.costs(now.state), now.start)))
    near = _places(ordered.start) < work.width
    cubes = np.floor(ordered.state / (CELL * natural_units(work.stride_map.params)))
    rows = np.column_stack([ordered.start, cubes.astype(np.int64)])
    _, first, cell = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    others = np.sort(np.delete(first, np.unique(cell.ravel()[near])))  # the best of each cell
    fits = _places(ordered.start[others]) < work.width
    keep = np.union1d(np.flatnonzero(near), others[fits])
    return ordered.take(keep), np.unique(ordered.start[others[~fits]])


def _places(starts: NDArray[np.int64]) -> NDArray[np.int64]:
    """The place of each row among those of the same start; the starts ascend."""
    known, begin = np.unique(starts, return_index=True)
    places: NDArray[np.int64] = np.arange(len(starts)) - begin[np.searchsorted(known, starts)]
    return places
