"""Contact: what the floor and the stop would have to bear for a walk to be possible.

The model (Camp 1997, section 3) assumes a foot that never slips nor leaves the floor, a
trailing foot that leaves it freely at heel strike, a swing foot and ankles that may pass
through it, and no stop once the motor runs. Here each assumption is confronted with the
forces and motions that the equations give (`ground_force.py`).
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from powered_walker_env.model.checks import whole_number
from powered_walker_env.model.mechanics.ground import swing_foot
from powered_walker_env.model.mechanics.packing import constants_of
from powered_walker_env.model.phases import Joints
from powered_walker_env.model.powering import AnyControl, Policy
from powered_walker_env.model.state import PostStrikeState
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.energy.assumptions import STILL, ContactReport
from powered_walker_env.poincare.energy.ground_force import (
    ComplexArray,
    WalkedStride,
    forces,
    impulse_of,
    knee_impulse_of,
    logged_strides,
    trailing_foot,
)
from powered_walker_env.poincare.gaits import Gait
from powered_walker_env.simulation import record
from powered_walker_env.simulation.strides import Array

_THIGH = record.LOG_THIGH.start


def contact_report(
    params: WalkerParams,
    control: AnyControl | Policy | None,
    state: PostStrikeState | Sequence[float],
    *,
    strides: int = 1,
) -> ContactReport:
    """Examine the contact of some strides from `state` (flat ground).

    Args:
        params: the walker.
        control: a constant control, None for a passive walker, or a policy.
        state: post-strike state, rad and rad/s.
        strides: how many; a fall ends the examination.

    Raises:
        ValueError: a bad argument.
    """
    strides = whole_number("strides", strides, 1)
    reports = [
        _examine(stride, params) for stride in logged_strides(params, control, state, strides)
    ]
    return _worst(reports)


def contact_of(gait: Gait) -> ContactReport:
    """The report of a gait, over its period."""
    return contact_report(gait.params, gait.control, gait.state, strides=gait.period)


def foot_motion(gait: Gait) -> tuple[float, int]:
    """How far the powered foot falls back past its stop, rad, and how often it turns round.

    The same numbers as in the report, at a small part of its cost.
    """
    walked = logged_strides(gait.params, gait.control, gait.state, gait.period)
    motions = [_foot_motion(stride, gait.params) for stride in walked]
    return max(overrun for overrun, _ in motions), max(turns for _, turns in motions)


def _foot_motion(walked: WalkedStride, params: WalkerParams) -> tuple[float, int]:
    pose = walked.logged.log[walked.rows(Joints.ANKLE_FREE), record.LOG_POSE]
    ankle, ankle_rate = pose[:, 1] - pose[:, 0], pose[:, 4] - pose[:, 3]
    overrun = float(np.max(ankle - params.locked_ankle_angle, initial=0.0))
    return overrun, _reversals(ankle_rate, math.sqrt(params.gravity / params.leg_length))


def _reversals(ankle_rate: Array, scale: float) -> int:
    """How often the ankle turns round; rates within rounding of zero have no sign."""
    signs = np.sign(ankle_rate[np.abs(ankle_rate) > STILL * scale])
    return int(np.count_nonzero(np.diff(signs)))


def _ankle_heights(log: Array, params: WalkerParams) -> Array:
    """(2, n) heights of the stance and the swing ankle above the floor, m."""
    stance = params.foot_radius + params.foot_length * np.cos(log[:, 1])
    shank = 0.0 if params.knee is None else params.knee.shank_length
    swing = shank * np.cos(log[:, 3]) + (params.leg_length - shank) * np.cos(log[:, _THIGH])
    return np.array([stance, stance + params.leg_length * np.cos(log[:, 2]) + swing])


def _needed_friction(force: ComplexArray) -> float:
    """Largest tangential over normal component; infinite if the normal one is not positive."""
    if not (force.real > 0.0).all():
        return math.inf if np.isfinite(force.real).all() else math.nan
    return float(np.max(np.abs(force.imag) / force.real))


def _least(values: Array) -> float:
    """The least that is a number; `math.nan` if none is, so that reports can be compared."""
    known = values[np.isfinite(values)]
    return float(known.min()) if len(known) else math.nan


def _most(values: Array) -> float:
    """The largest, likewise."""
    return math.nan if math.isnan(least := _least(-values)) else -least


def _examine(walked: WalkedStride, params: WalkerParams) -> ContactReport:
    c, logged = constants_of(params), walked.logged
    log, loads = logged.log, forces(walked, params)
    force = loads.force
    locked = ~walked.rows(Joints.ANKLE_FREE)
    height = np.array([swing_foot(pose, c).real for pose in walked.poses()])
    passed = height[log[:, 2] > log[:, _THIGH] - math.pi]
    jump, knee = impulse_of(walked, params), knee_impulse_of(walked, params)
    ankle_velocity, foot_velocity = trailing_foot(walked, params)
    overrun, reversals = _foot_motion(walked, params)
    return ContactReport(
        outcome=logged.outcome,
        strides=1,
        weight=2.0 * params.leg_mass * params.gravity,
        min_normal_force=float(force.real.min()),
        max_normal_force=float(force.real.max()),
        friction=_needed_friction(force),
        min_stop_torque=float((loads.ankle - loads.motor)[locked].min()),
        min_clearance=float(logged.result[record.MIN_CLEARANCE]),
        max_clearance=float(passed.max()) if len(passed) else math.nan,
        deepest=float(height.min()),
        min_ankle_height=float(_ankle_heights(log, params).min()),
        trailing_ankle_velocity=ankle_velocity,
        trailing_foot_velocity=foot_velocity,
        normal_impulse=jump.real,
        strike_friction=_needed_friction(np.array([jump])),
        stop_overrun=overrun,
        ankle_reversals=reversals,
        min_stance_knee_torque=_least(loads.stance_knee),
        max_stance_knee_torque=_most(loads.stance_knee),
        min_swing_knee_torque=_least(loads.swing_knee),
        knee_impulse=knee.real if math.isfinite(knee.real) else math.nan,
        knee_friction=_needed_friction(np.array([knee])),
    )


_SMALLEST_IS_WORST = (
    "min_normal_force", "min_stop_torque", "min_clearance", "max_clearance", "deepest",
    "min_ankle_height", "trailing_ankle_velocity", "trailing_foot_velocity", "normal_impulse",
    "min_stance_knee_torque", "min_swing_knee_torque", "knee_impulse",
)  # fmt: skip
_LARGEST_IS_WORST = (
    "max_normal_force", "friction", "strike_friction", "stop_overrun", "ankle_reversals",
    "max_stance_knee_torque", "knee_friction",
)  # fmt: skip


def _worst(reports: list[ContactReport]) -> ContactReport:
    """One report of several strides (a NaN, where nothing struck, passes on)."""
    changes = {
        **{n: min((getattr(r, n) for r in reports), key=_nan_first) for n in _SMALLEST_IS_WORST},
        **{n: max((getattr(r, n) for r in reports), key=_nan_last) for n in _LARGEST_IS_WORST},
    }
    last = reports[-1]
    return dataclasses.replace(last, strides=len(reports), **changes)


def _nan_first(value: float) -> float:
    return -math.inf if math.isnan(value) else value


def _nan_last(value: float) -> float:
    return math.inf if math.isnan(value) else value
