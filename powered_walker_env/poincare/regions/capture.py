"""How many strides a walker can be kept from falling, from both sides, on a grid of its section.

Backward induction: a state is n-step capturable (Koolen, de Boer, Rebula, Goswami and Pratt 2012)
if some control walks it into the (n − 1)-step capturable ones; those that are for every n are the
viability kernel (Aubin 1991). On a grid the sets are known at nodes only, so there are two answers:

- *at least*: every node about where a control of the grid leads is of the set;
- *at most*: some node is, of all within a cell of where that control or those between it and its
  neighbours lead. What leaves the grid is open.

A node that cannot be kept even at most is lost, one kept at least is saved, the rest is what the
resolution leaves open: finer grids and more controls decide more of it. At nodes the strides are
exact; between them it is an estimate of the bounds that sharpens, not a proof.

With a bound on the pushes the kernel is the robust one: saved is who is saved whatever push within
the bound comes after each heel strike.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.model.checks import real_number, require, whole_number
from powered_walker_env.poincare.gaits import Gait
from powered_walker_env.poincare.regulator import regulate
from powered_walker_env.poincare.stochastic.grid import Grid
from powered_walker_env.poincare.stochastic.law import Law
from powered_walker_env.poincare.stochastic.noise import StepNoise
from powered_walker_env.poincare.stochastic.programming import decided_section
from powered_walker_env.poincare.stochastic.steps import Progress, step_law
from powered_walker_env.poincare.stochastic.sums import led_into
from powered_walker_env.poincare.stochastic.tables import controls_between
from powered_walker_env.simulation.strides import Array

CELL = 1.0  # nodes about an image within which its set is looked for, at most
REACH = 0.1  # natural units, of rates √(g/L), around the gait: the grid if none is given


@dataclass(frozen=True, eq=False)
class Capture:
    """Strides that each node can be kept from falling."""

    gait: Gait
    low: Array  # (k,) bounds of the control; of the motor: switch angle, stall torque
    high: Array
    counts: tuple[int, ...]  # (k,) values of each number tried
    push: float  # rad/s, that each rate may be pushed after every heel strike, either way
    strides: int  # looked ahead
    grid: Grid = field(repr=False)
    at_least: NDArray[np.int64] = field(repr=False)  # (N,) strides, up to those looked ahead
    at_most: NDArray[np.int64] = field(repr=False)  # (N,)
    control_share: Array = field(repr=False)  # (N,) of the controls after which it is still saved

    def __repr__(self) -> str:
        saved, possible = self.bounds
        return (
            f"Capture({saved:.3f} saved, {1.0 - possible:.3f} lost, {possible - saved:.3f} open "
            f"of {self.grid.size} nodes, {self.strides} strides)"
        )

    @property
    def bounds(self) -> tuple[float, float]:
        """Shares of the nodes kept for all the strides: at least, and at most."""
        ahead = self.strides
        return float(np.mean(self.at_least >= ahead)), float(np.mean(self.at_most >= ahead))

    @property
    def fate(self) -> NDArray[np.int64]:
        """(N,) 1 saved, 0 open, −1 lost."""
        saved, possible = self.at_least >= self.strides, self.at_most >= self.strides
        return np.where(saved, 1, np.where(possible, 0, -1))

    @property
    def viability_measure(self) -> float:
        """Share of all pairs of node and control that keep a walker saved.

        S. Heim and A. Spröwitz, Beyond basins of attraction: quantifying robustness of natural
        dynamics, IEEE Transactions on Robotics 35 (2019) 939-952: the measure of the viable
        state-action pairs. A node's own share is `control_share`.
        """
        return float(np.mean(self.control_share))


def capture(
    gait: Gait,
    half_range: Sequence[float],
    *,
    grid: Grid | None = None,
    strides: int = 20,
    counts: int | Sequence[int] = 9,
    shape: int = 30,
    push: float = 0.0,
    progress: Progress | None = None,
) -> Capture:
    """Which states of the section any controls within bounds can keep from falling.

    Args:
        gait: of one stride under a constant control.
        half_range: (k,) how far the numbers of the control may go from the gait's own.
        grid: on a section ahead of every switch; left out, 0.1 (0.1 √(g/L) of a rate) around
            the gait with `shape` nodes along each axis.
        strides: looked ahead.
        counts: values of each number of the control tried, the bounds included.
        push: rad/s, bound of the pushes on each rate after every heel strike.
        progress: called with the strides done and those in all.

    Raises:
        ValueError, TypeError: bad bounds or counts, a gait of several strides.
    """
    strides, push = whole_number("strides", strides, 1), real_number("push", push)
    require(push >= 0.0, "push", "not be negative", push)
    law = regulate(gait, half_range)
    given = tuple(counts) if isinstance(counts, Sequence) else (counts,) * len(law.nominal)
    if len(given) != len(law.nominal):
        raise ValueError(f"counts must be one or {len(law.nominal)}, got {counts!r}")
    numbers = tuple(whole_number("counts", count, 2) for count in given)
    noise = StepNoise(push=push)
    box = _around(gait, law.high, noise, whole_number("shape", shape, 3)) if grid is None else grid
    if box.aligned:
        raise ValueError("grid must not be curved where boxes of it are counted, got one that is")
    choices = controls_between(law.low, law.high, numbers)
    table = step_law(
        gait.params, gait.control, box, noise, choices=choices, push_points=1, progress=progress
    )
    pushed = np.abs(table.gain).sum(axis=2)
    between = pushed + CELL + _apart(table, numbers)
    at_least, _ = _kept(table, pushed, strides, every=True)
    at_most, _ = _kept(table, between, strides, every=False)
    safe = _led(table, pushed, at_least >= strides, every=True)
    nodes = np.repeat(np.arange(box.size), np.diff(table.begin))
    share = np.bincount(nodes[safe], minlength=box.size) / len(choices)
    return Capture(gait, law.low, law.high, numbers, push, strides, box, at_least, at_most, share)


def _around(gait: Gait, high: Array, noise: StepNoise, shape: int) -> Grid:
    on = decided_section(gait, high, noise)
    point = on.points([gait.state])[0]
    unit = np.sqrt(gait.params.gravity / gait.params.leg_length)
    reach = REACH * np.array([1.0, *(unit,) * (len(point) - 1)])
    return Grid.box(point - reach, point + reach, (shape,) * len(point), on)


def _apart(table: Law, counts: Sequence[int]) -> NDArray[np.float32]:
    """(M, 3) half of how far the images of neighbouring controls are apart, in nodes."""
    nodes = np.repeat(np.arange(table.grid.size), np.diff(table.begin))
    dense = np.full((table.grid.size, int(np.prod(counts)), 3), np.nan, np.float32)
    dense[nodes, table.choice] = table.mean
    dense = dense.reshape(table.grid.size, *counts, 3)
    half = np.zeros(dense.shape, np.float32)
    for axis in range(1, dense.ndim - 1):
        steps = np.abs(np.diff(dense, axis=axis))
        room = [(0, 0)] * dense.ndim
        room[axis] = (1, 1)
        both = np.pad(np.nan_to_num(steps), room)
        along = np.moveaxis(both, axis, 0)
        half += 0.5 * np.moveaxis(np.maximum(along[1:], along[:-1]), 0, axis)
    return half.reshape(table.grid.size, -1, 3)[nodes, table.choice]


def _led(
    table: Law, half: NDArray[Any], inside: NDArray[np.bool_], *, every: bool
) -> NDArray[np.bool_]:
    """(M,) which rows lead into a set of nodes."""
    held = np.zeros(table.rows, np.bool_)
    counts, boxes = np.array(table.grid.table_shape), np.asarray(half, np.float32)
    led_into(counts, table.mean, boxes, inside, every, not every, held)
    return held


def _kept(
    table: Law, half: NDArray[Any], strides: int, *, every: bool
) -> tuple[NDArray[np.int64], int]:
    """(N,) strides that each node is kept, and after how many the sets no longer change."""
    kept, inside = np.zeros(table.grid.size, np.int64), np.ones(table.grid.size, np.bool_)
    nodes = np.repeat(np.arange(table.grid.size), np.diff(table.begin))
    for number in range(1, strides + 1):
        held = _led(table, half, inside, every=every) if number > 1 else np.ones(table.rows, bool)
        now = np.bincount(nodes[held], minlength=table.grid.size) > 0
        kept[now] = number
        if number > 1 and (now == inside).all():
            kept[now] = strides
            return kept, number
        inside = now
    return kept, strides
