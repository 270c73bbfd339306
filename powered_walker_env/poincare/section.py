"""The Poincaré section, the stride map on it, and the map's exact derivatives.

The section of the package is the instant just after heel strike: (α, s, α', β'), four
numbers. The thesis's is the instant the motor starts (section 7): (q1, u1, u3), three
numbers, since there the hip angle is the switch angle and the foot is locked. Both
maps have the same multipliers, but for a zero that the larger section adds.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from powered_walker_env import kernel
from powered_walker_env.params import Control, PostStrikeState, WalkerParams
from powered_walker_env.phases import Cycle, Outcome, encode
from powered_walker_env.physics.constants import pack
from powered_walker_env.sensitivity import OUTPUTS
from powered_walker_env.stride import PASSIVE_CONTROL, Array, cycle_of, run_batch
from powered_walker_env.trajectory import log_stride

SECTION_RTOL = 1e-13  # of the strides behind a gait


class MapPoint(NamedTuple):
    """Where the map takes a state, with its derivatives; NaN after a fall."""

    state: Array  # (4,) after the strides
    by_state: Array  # (4, 4)
    by_control: Array  # (4, 2), by switch angle (rad) and stall torque (N m)
    outcome: Outcome  # of the last stride walked


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


def differentiate_map(
    state: Array, control: Control | None, params: WalkerParams, period: int = 1
) -> MapPoint:
    """The map over `period` strides and its derivatives, exact to the integrator's accuracy.

    The variational equations are carried along with each stride (`sensitivity.py`); over
    several strides the chain rule joins them.
    """
    changes = np.eye(4 + 2, 4 + 2 + pack(params).size)
    by_state, by_control = np.eye(4), np.zeros((4, 2))
    outcome = Outcome.WALKED
    for _ in range(period):
        results = np.empty((1, kernel.RESULTS))
        outcomes = np.empty(1, np.int64)
        derivatives = np.empty((1, len(changes), OUTPUTS))
        kernel.differentiate_strides(
            encode(cycle_of(control)),
            np.ascontiguousarray(state)[np.newaxis],
            control_row(control)[np.newaxis],
            pack(params)[np.newaxis],
            SECTION_RTOL,
            changes,
            results,
            outcomes,
            derivatives,
        )
        state, step = results[0, kernel.STATE], derivatives[0, :, :4].T
        by_state, by_control = step[:, :4] @ by_state, step[:, :4] @ by_control + step[:, 4:]
        outcome = Outcome(int(outcomes[0]))
        if outcome != Outcome.WALKED:
            break
    return MapPoint(state, by_state, by_control, outcome)


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
