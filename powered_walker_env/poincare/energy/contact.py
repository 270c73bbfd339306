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
from dataclasses import dataclass

import numpy as np

from powered_walker_env.model.checks import whole_number
from powered_walker_env.model.mechanics.constants import constants_of
from powered_walker_env.model.mechanics.ground import swing_foot
from powered_walker_env.model.phases import Joints, Outcome
from powered_walker_env.model.powering import AnyControl, Policy
from powered_walker_env.model.state import PostStrikeState
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.energy.ground_force import (
    ComplexArray,
    WalkedStride,
    forces,
    impulse_of,
    logged_strides,
    trailing_foot,
)
from powered_walker_env.poincare.gaits import Gait
from powered_walker_env.simulation import record
from powered_walker_env.simulation.strides import Array

_THIGH = record.LOG_THIGH.start
STILL = 1e-9  # rad, m/L and rad/s·√(L/g): less than this is rounding


@dataclass(frozen=True)
class ContactReport:
    """Contact over one or more strides; the worst stride counts. NaN where nothing struck.

    Friction coefficients are infinite where the floor would have to pull.
    """

    outcome: Outcome  # of the last stride examined
    strides: int
    weight: float  # N, of the walker
    min_normal_force: float  # N, least normal force on the stance foot; below 0 it lifts off
    max_normal_force: float  # N
    friction: float  # least coefficient that keeps the stance foot from slipping
    min_stop_torque: float  # N m, the stop's on the locked foot beside a motor's; below 0 it would
    # need a latch
    min_clearance: float  # m, of the swing foot after the legs have passed; below 0 it scuffs
    max_clearance: float  # m, likewise; at most 0: it never comes up through the floor
    deepest: float  # m, lowest height of the swing foot in the whole swing
    min_ankle_height: float  # m, of either ankle above the floor
    trailing_ankle_velocity: float  # m/s, upward, just after heel strike
    trailing_foot_velocity: float  # m/s, upward, of the old foot's lowest point just after heel
    # strike, its ankle held as it was; below 0 it would press into the floor
    normal_impulse: float  # N s, of the floor on the new foot at heel strike, least
    strike_friction: float  # least coefficient that keeps the new foot from slipping there
    stop_overrun: float  # rad, how far the powered foot falls back past its stop, q2 − q2_lock
    ankle_reversals: int  # times the ankle turns round while the motor runs
    min_stance_knee_torque: float  # N m, of the locked stance knee on its shank; below 0 it would
    # need a latch, as a stop only keeps it from bending back; NaN without knees, as those below
    max_stance_knee_torque: float  # N m
    min_swing_knee_torque: float  # N m, the same of the swing knee once it has struck

    def __repr__(self) -> str:
        found = "; ".join(self.violations()) or "nothing that the model assumes is broken"
        strides = f"{self.strides} stride{'s' * (self.strides != 1)}"
        return f"ContactReport({strides}, {self.outcome.label}: {found})"

    @property
    def min_normal_fraction(self) -> float:
        """Least normal force as a fraction of the weight."""
        return self.min_normal_force / self.weight

    @property
    def keeps_contact(self) -> bool:
        """Whether the floor only ever pushes the stance foot."""
        return self.min_normal_force > 0.0

    @property
    def stop_suffices(self) -> bool:
        """Whether a stop that can only push holds the foot in the passive swing."""
        return self.min_stop_torque >= -STILL * self.weight  # at its release it is zero

    @property
    def scuffs(self) -> bool:
        """Whether the swing foot goes under the floor after the legs have passed."""
        return self.min_clearance < -STILL

    @property
    def ankles_stay_above(self) -> bool:
        """Whether no ankle dips under the floor."""
        return self.min_ankle_height >= 0.0

    @property
    def trailing_foot_lifts(self) -> bool:
        """Whether the old foot leaves the floor at heel strike by itself."""
        return self.trailing_foot_velocity >= 0.0

    @property
    def strike_pushes(self) -> bool:
        """Whether the floor pushes the new foot at heel strike."""
        return self.normal_impulse > 0.0

    @property
    def falls_back(self) -> bool:
        """Whether the powered foot falls back past its stop."""
        return self.stop_overrun > STILL

    @property
    def extends_monotonely(self) -> bool:
        """Whether the powered foot only ever extends."""
        return not self.falls_back and self.ankle_reversals == 0

    def violations(self, friction: float = 1.0) -> tuple[str, ...]:
        """What the model assumes and this walk would not do on a floor of that friction."""
        found = [
            (not self.keeps_contact, f"the stance foot lifts off: least normal force "
             f"{self.min_normal_fraction:.3g} of the weight"),
            (self.friction > friction, f"the stance foot slips: it needs a friction coefficient "
             f"of {self.friction:.3g}"),
            (not self.stop_suffices, "the stop must hold the foot back, as a latch: "
             f"{self.min_stop_torque:.4g} N m"),
            (self.min_stance_knee_torque < -STILL * self.weight, "the stance knee must be held "
             f"straight, as by a latch: {self.min_stance_knee_torque:.4g} N m"),
            (self.min_swing_knee_torque < -STILL * self.weight, "the swing knee must be held "
             f"straight once it has struck, as by a latch: {self.min_swing_knee_torque:.4g} N m"),
            (self.scuffs, f"the swing foot scuffs after mid-swing: {self.min_clearance:.3g} m"),
            (not self.ankles_stay_above, f"an ankle is under the floor: "
             f"{self.min_ankle_height:.3g} m"),
            (self.trailing_foot_velocity < 0, "the trailing foot does not lift at heel strike: "
             f"{self.trailing_foot_velocity:.3g} m/s"),
            (self.normal_impulse <= 0, "the floor would have to pull at heel strike: "
             f"{self.normal_impulse:.4g} N s"),
            (self.strike_friction > friction, "the new foot slips at heel strike: it needs a "
             f"friction coefficient of {self.strike_friction:.3g}"),
            (self.falls_back, f"the foot falls back past its stop: {self.stop_overrun:.3g} rad"),
        ]  # fmt: skip
        return tuple(text for broken, text in found if broken)


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


def _examine(walked: WalkedStride, params: WalkerParams) -> ContactReport:
    c, logged = constants_of(params), walked.logged
    log, loads = logged.log, forces(walked, params)
    force = loads.force
    locked = ~walked.rows(Joints.ANKLE_FREE)
    height = np.array([swing_foot(pose, c).real for pose in walked.poses()])
    passed = height[log[:, 2] > log[:, _THIGH] - math.pi]
    jump = impulse_of(walked, params)
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
        min_stance_knee_torque=float(loads.stance_knee.min()),
        max_stance_knee_torque=float(loads.stance_knee.max()),
        min_swing_knee_torque=float(np.nanmin(loads.swing_knee))
        if np.isfinite(loads.swing_knee).any()
        else math.nan,
    )


_SMALLEST_IS_WORST = (
    "min_normal_force", "min_stop_torque", "min_clearance", "max_clearance", "deepest",
    "min_ankle_height", "trailing_ankle_velocity", "trailing_foot_velocity", "normal_impulse",
    "min_stance_knee_torque", "min_swing_knee_torque",
)  # fmt: skip
_LARGEST_IS_WORST = (
    "max_normal_force", "friction", "strike_friction", "stop_overrun", "ankle_reversals",
    "max_stance_knee_torque",
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
