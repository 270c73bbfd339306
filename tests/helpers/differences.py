"""Derivatives by differences, of plain strides and of functions."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from powered_walker_env.model.mechanics.packing import OWN, own_numbers, rows_from_own
from powered_walker_env.model.phases import Cycle
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.simulation import record
from powered_walker_env.simulation.derivatives import run_derivatives
from powered_walker_env.simulation.strides import run_batch
from powered_walker_env.simulation.walked import StrideBatch
from tests.helpers.derivation import Array

INPUTS = 6 + OWN  # post-strike state 4, control 2, and a walker's own numbers
#: Sixth-order central difference: Richardson's, twice.
OFFSETS = np.array([-3, -2, -1, 1, 2, 3])
WEIGHTS = np.array([-1, 9, -45, 45, -9, 1]) / 60


def central(function: Callable[[float], Array], h: float) -> Array:
    """The derivative at 0 of a function of one number."""
    values = np.array([function(offset * h) for offset in OFFSETS])
    return np.asarray(np.tensordot(WEIGHTS, values, 1) / h)


def point_of(state: Array, row: Array, params: WalkerParams) -> Array:
    """(INPUTS,) all that a stride depends on."""
    return np.concatenate([state, row, own_numbers(params)])


def outputs(cycle: Cycle, points: Array) -> Array:
    """(N, 6) state after, duration and step length of plain strides, NaN for falls; each row of
    points is its own walker."""
    parts = (np.ascontiguousarray(points[:, cut]) for cut in (slice(4), slice(4, 6)))
    walkers = rows_from_own(np.ascontiguousarray(points[:, 6:]))
    results = run_batch(cycle, *parts, walkers, np.zeros(1), 1e-13).results
    wanted = (record.DURATION, record.STEP_LENGTH)
    return np.column_stack([results[:, record.STATE], *(results[:, k] for k in wanted)])


def difference(cycle: Cycle, point: Array, direction: Array, h: float) -> Array:
    """(6,) the change of a stride's outputs along a direction."""
    return np.asarray(WEIGHTS @ outputs(cycle, point + h * np.outer(OFFSETS, direction)) / h)


def variational(
    cycle: Cycle, point: Array, directions: Array, rtol: float = 1e-13
) -> tuple[StrideBatch, Array]:
    """The stride at a point, and (6, directions) its derivatives carried along with it."""
    start, row = point[np.newaxis, :4], point[np.newaxis, 4:6]
    walkers = rows_from_own(point[np.newaxis, 6:])
    strides, derivatives = run_derivatives(cycle, start, row, walkers, rtol, directions)
    return strides, derivatives[0]
