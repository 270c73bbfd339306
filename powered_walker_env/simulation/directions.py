"""Directions to differentiate strides along, and the derivatives of eight strides under way."""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from powered_walker_env.compiled.decorators import once, small
from powered_walker_env.compiled.lanes import SIZE, Table, load, rows_from
from powered_walker_env.compiled.records import Layout
from powered_walker_env.model.mechanics.packing import (
    BENT_CHAIN,
    CHAIN_SIZE,
    CONSTANTS,
    CONSTANTS_SIZE,
    FREE_CHAIN,
    LOCKED_CHAIN,
    OWN,
)
from powered_walker_env.simulation.runge_kutta import STAGES

OUTPUTS = 6  # what a stride is differentiated of: α, s, α', β' after it, duration, step length
CHANGES = 6  # of what besides the walker: post-strike state (4), switch angle, strength
SWITCH, STRENGTH = 4, 5  # columns of the latter
LOCK = CONSTANTS["lock"]


class Direction(NamedTuple):
    """One direction to differentiate along: the derivatives of eight strides under way."""

    S: Annotated[Table, SIZE]  # of the chain's state, now
    flows: Annotated[Table, (STAGES + 1) * SIZE]  # of S at the stages
    shift: Table  # s, how far the last event moves
    start: Table  # rad, of φ as the stride began
    struck: Annotated[Table, SIZE]  # of the pose after the reset
    struck_thigh: Annotated[Table, 2]
    length: Table  # m, of the way travelled
    constants: Annotated[Table, CONSTANTS_SIZE]  # of the walkers
    locked_chain: Annotated[Table, CHAIN_SIZE]
    free_chain: Annotated[Table, CHAIN_SIZE]
    bent_chain: Annotated[Table, CHAIN_SIZE]
    chain: Annotated[Table, CHAIN_SIZE]


DIRECTION = Layout(Direction)
DIRECTION_SIZE = DIRECTION.size
direction_in = DIRECTION.view


class Directions(NamedTuple):
    """What to differentiate by, and where the derivatives go."""

    n: int  # directions, 0 for none
    rows: Table  # of lanes: n times DIRECTION.size
    changes: Table  # (n, CHANGES)
    walkers: Table  # (rows·n, ROW) of the walkers' rows, n for each walker
    derivatives: Table  # (N·n, OUTPUTS)


@small
def direction_of(d, k):
    """The k-th direction."""
    return direction_in(rows_from(d.rows, k * DIRECTION_SIZE))


@once
def begin(d, s, lane, row, new):
    """The change of the pose at the start of a stride: both feet locked, φ = α − lock.

    Args:
        row: of the walker in the batch; new: whether the lane had another before.
    """
    for k in range(d.n):
        e, changes = direction_of(d, k), d.changes
        if new:
            _copy_walker(d, e, lane, row * d.n + k)
        phi = changes[k, 0] - e.constants[LOCK, lane]
        e.start[0, lane], e.shift[0, lane] = phi, 0.0
        e.struck[0, lane], e.struck[1, lane], e.struck[2, lane] = phi, changes[k, 0], changes[k, 1]
        e.struck[3, lane], e.struck[4, lane] = changes[k, 2], changes[k, 2]
        e.struck[5, lane] = changes[k, 3]
        e.struck_thigh[0, lane], e.struck_thigh[1, lane] = changes[k, 1], changes[k, 3]


@once
def _copy_walker(d, e, lane, row):
    """Write the changes of a walker's constants and chains into a lane."""
    for i in range(CONSTANTS_SIZE):
        e.constants[i, lane] = d.walkers[row, OWN + i]
    for i in range(CHAIN_SIZE):
        e.locked_chain[i, lane] = d.walkers[row, LOCKED_CHAIN + i]
        e.free_chain[i, lane] = d.walkers[row, FREE_CHAIN + i]
        e.bent_chain[i, lane] = d.walkers[row, BENT_CHAIN + i]


@once
def write_derivatives(d, index, lane, walked):
    """The derivatives of the stride that one lane has ended; NaN after a fall."""
    for k in range(d.n):
        e, row = direction_of(d, k), index * d.n + k
        for j in range(OUTPUTS):
            d.derivatives[row, j] = math.nan
        if walked:
            d.derivatives[row, 0], d.derivatives[row, 1] = e.struck[1, lane], e.struck[2, lane]
            d.derivatives[row, 2], d.derivatives[row, 3] = e.struck[4, lane], e.struck[5, lane]
            d.derivatives[row, 4], d.derivatives[row, 5] = e.shift[0, lane], e.length[0, lane]


@small
def change_of(d, k, s, column):
    """A change of the control, in all lanes."""
    return d.changes[k, column] + 0.0 * load(s.t, 0)
