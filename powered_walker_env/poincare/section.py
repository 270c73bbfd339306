"""The Poincaré section and the stride map on it, with Jacobians by central differences.

The section of the package is the instant just after heel strike: (α, s, α', β'), four
numbers. The thesis's is the instant the motor starts (section 7): (q1, u1, u3), three
numbers, since there the hip angle is the switch angle and the foot is locked. Both
maps have the same multipliers, but for a zero that the larger section adds.
"""

from __future__ import annotations

import math

import numpy as np

from powered_walker_env.params import Control, PostStrikeState, WalkerParams
from powered_walker_env.phases import Cycle
from powered_walker_env.physics.constants import pack
from powered_walker_env.stride import PASSIVE_CONTROL, Array, cycle_of, run_batch
from powered_walker_env.trajectory import log_stride

SECTION_RTOL = 1e-13  # of the strides behind a gait
DIFFERENCE = 1e-4  # step of the differences, in natural units: their error is ~1e-10 of it
_OFFSETS = np.array([-2.0, -1.0, 1.0, 2.0])
_WEIGHTS = np.array([1.0, -8.0, 8.0, -1.0]) / 12.0  # fourth-order central difference


def natural_units(params: WalkerParams) -> Array:
    """Units of a post-strike state, (4,): radians, and radians per √(L/g)."""
    rate = math.sqrt(params.gravity / params.leg_length)
    return np.array([1.0, 1.0, rate, rate])


def control_row(control: Control | None) -> Array:
    """The control as (2,) for the kernel."""
    if control is None:
        return np.array(PASSIVE_CONTROL)
    return np.array([control.switch_angle, control.stall_torque])


def stride_map(
    states: Array, controls: Array, params: WalkerParams, cycle: Cycle, strides: int = 1
) -> Array:
    """The states (N, 4) after some strides; NaN for a walker that fell."""
    row, flat = pack(params)[np.newaxis], np.zeros(1)
    for _ in range(strides):
        states = run_batch(cycle, states, controls, row, flat, SECTION_RTOL).state
    return states


def map_jacobians(
    state: Array, control: Control | None, params: WalkerParams, period: int = 1
) -> tuple[Array, Array]:
    """Derivatives of the map over `period` strides: by state (4, 4), by control (4, 2).

    Fourth-order central differences of strides at rtol 1e-13, all in one batch. NaN
    where a difference falls.
    """
    point = np.concatenate([state, control_row(control)])
    units = np.concatenate([natural_units(params), [1.0, max(point[5], 1.0)]])
    steps = DIFFERENCE * units
    points = point + (_OFFSETS[:, np.newaxis, np.newaxis] * np.diag(steps)).reshape(-1, 6)
    landed = stride_map(points[:, :4], points[:, 4:], params, cycle_of(control), period)
    columns = np.tensordot(_WEIGHTS, landed.reshape(len(_OFFSETS), 6, 4), axes=1)
    jacobian = (columns / steps[:, np.newaxis]).T
    return jacobian[:, :4], jacobian[:, 4:]


def switch_section(
    state: PostStrikeState, control: Control, params: WalkerParams
) -> tuple[float, float, float] | None:
    """(q1, u1, u3) where the motor starts in the stride from `state`; None if it does not."""
    logged = log_stride(state, control, params, 0.0, SECTION_RTOL, 0.0)
    powered = np.flatnonzero(logged.log[:, 7] > 0)
    if not len(powered):
        return None
    phi, _, _, dphi, dalpha, dbeta = logged.log[powered[0], 1:7].tolist()
    return phi, dphi, dbeta - dalpha
