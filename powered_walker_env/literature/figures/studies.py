"""What the thesis's figures 4, 5 and 6 show, computed (Camp 1997, sections 7 and 8).

The published setting is that of figure 6: hip 1000 kg, ankle 1 kg, L = 1 m, D = 0.05 m,
R = 0, locked ankle 3π/4, no-load speed 100 rad/s, switch angle 2.8625; figure 4 is its
gait at 692 N m. In the conserving physics that walker has no such gait; its counterpart
walks at switch angle 2.9068 and 729.8 N m.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from powered_walker_env.model.mechanics.actuation import accelerations_at, drive
from powered_walker_env.model.mechanics.chain import pose_of
from powered_walker_env.model.mechanics.packing import chains_of, constants_of
from powered_walker_env.model.phases import Joints, Torque
from powered_walker_env.model.powering.motor import Control
from powered_walker_env.model.presets import PRESETS
from powered_walker_env.model.walker import AS_PUBLISHED, CONSERVING
from powered_walker_env.poincare import Gait, find_gait
from powered_walker_env.poincare.branches.branch import Branch
from powered_walker_env.poincare.branches.continuation import continue_gait, switch_branch
from powered_walker_env.poincare.branches.special_points import SpecialKind, SpecialPoint
from powered_walker_env.poincare.energy.contact import foot_motion
from powered_walker_env.simulation.strides import Array

POINTS = 24  # gaits of figure 6
RADIUS_4 = 0.65  # largest multiplier, as printed
SLOPE_STEP = 0.5  # N m, to either side of an onset
TORQUE = "stall_torque"


class Setting(NamedTuple):
    """Where a figure looks, in one physics."""

    physics: str
    preset: str
    window: tuple[float, float]  # N m, of the 24 gaits
    bounds: tuple[float, float]  # N m, of the branch
    lattice: tuple[float, float]  # steps of the search for figure 5: rad, N m


SETTINGS = (
    Setting(AS_PUBLISHED, "camp1997-as-published", (692.0, 760.0), (685.0, 760.0), (0.01, 5.0)),
    Setting(CONSERVING, "camp1997", (727.0, 736.0), (720.0, 740.0), (0.002, 0.8)),
)


@dataclass(frozen=True, eq=False)
class Onset:
    """Where the foot begins to move otherwise as the stall torque changes."""

    stall_torque: float  # N m
    radius: float  # largest multiplier there
    slope_below: float  # of it, per N m
    slope_above: float


@dataclass(frozen=True, eq=False)
class Figure6:
    """The largest multiplier against the stall torque, and what happens on the way."""

    setting: Setting
    gait: Gait  # of figure 4
    branch: Branch
    doubled: Branch
    doubling: SpecialPoint  # where it ends stability
    stall_torques: Array  # (24,)
    gaits: tuple[Gait, ...]  # at them
    falling_back: Onset | None  # below it the foot falls back as the motor starts
    turning_late: Onset | None  # above it the foot rises once more on its way

    @property
    def radii(self) -> Array:
        """(24,) the largest multipliers."""
        return np.array([gait.spectral_radius for gait in self.gaits])

    @property
    def stable_range(self) -> tuple[float, float]:
        """The stall torques, N m, between which the gait of figure 4 is stable."""
        torque = torque_of(self.gait)
        return next(r for r in self.branch.stable_ranges() if r[0] <= torque <= r[1])


def control_of(gait: Gait) -> Control:
    """Its constant control."""
    assert isinstance(gait.control, Control)
    return gait.control


def torque_of(gait: Gait) -> float:
    """Its stall torque, N m."""
    return control_of(gait).stall_torque


def figure_4(setting: Setting) -> Gait:
    """The stable gait of the setting."""
    params, control, state, _ = PRESETS[setting.preset]
    return find_gait(params, control, state)


def figure_6(setting: Setting, gait: Gait) -> Figure6:
    """Follow the gait of figure 4 in its stall torque."""
    branch = continue_gait(gait, TORQUE, setting.bounds, step=0.01)
    doubling = next(p for p in branch.of_kind(SpecialKind.PERIOD_DOUBLING) if p.limits_stability)
    at = upper_part(gait, branch)
    torques = np.linspace(*setting.window, POINTS)
    return Figure6(
        setting=setting,
        gait=gait,
        branch=branch,
        doubled=switch_branch(doubling, setting.bounds, step=0.01),
        doubling=doubling,
        stall_torques=torques,
        gaits=tuple(at(torque) for torque in torques.tolist()),
        falling_back=_onset(at, motor_start_acceleration, setting.window, 1e-6),
        turning_late=_onset(at, turns_twice, setting.window, 1e-4),
    )


def upper_part(gait: Gait, branch: Branch) -> Callable[[float], Gait]:
    """The gaits by stall torque on the part of the branch without folds that holds `gait`."""
    torque = torque_of(gait)
    here = int(np.argmin(np.abs(branch.values - torque) + abs(branch.states[:, 0] - gait.state[0])))
    turns = np.flatnonzero(np.diff(np.sign(np.diff(branch.values)))) + 1
    low = max([int(t) for t in turns if t <= here], default=0)
    high = min([int(t) for t in turns if t > here], default=len(branch) - 1)
    values, states = branch.values[low : high + 1], branch.states[low : high + 1]
    order = np.argsort(values)

    def at(value: float) -> Gait:
        guess = [float(np.interp(value, values[order], x[order])) for x in states.T]
        return find_gait(gait.params, _with_torque(gait, value), guess)

    return at


def _with_torque(gait: Gait, stall_torque: float) -> Control:
    return dataclasses.replace(control_of(gait), stall_torque=stall_torque)


def motor_start_acceleration(gait: Gait) -> float:
    """q2'' as the motor starts, rad/s²: positive if the foot falls back past its stop first."""
    control = control_of(gait)
    assert gait.section_state is not None
    phi, dphi, hip_rate = gait.section_state
    alpha = phi + gait.params.locked_ankle_angle
    beta = alpha + control.switch_angle
    pose = pose_of(phi, alpha, beta, dphi, dphi, dphi + hip_rate)
    motor = drive(Torque.MOTOR, control.stall_torque)
    chains, c = chains_of(gait.params), constants_of(gait.params)
    ddphi, ddalpha, *_ = accelerations_at(pose, Joints.ANKLE_FREE, motor, chains, c)
    return float(ddalpha - ddphi)


def turns_twice(gait: Gait) -> float:
    """Above zero where the ankle turns round more than once, below where it does not."""
    return 0.5 if foot_motion(gait)[1] >= 2 else -0.5


def _onset(
    at: Callable[[float], Gait],
    test: Callable[[Gait], float],
    window: tuple[float, float],
    exact: float,
) -> Onset | None:
    """The stall torque at which the test changes its sign, to `exact` N m; None if it keeps it."""
    low, high = window
    if test(at(low)) * test(at(high)) > 0:
        return None
    torque = float(brentq(lambda value: test(at(value)), low, high, xtol=exact))
    below, here, above = (at(torque + k * SLOPE_STEP).spectral_radius for k in (-1.0, 0.0, 1.0))
    return Onset(torque, here, (here - below) / SLOPE_STEP, (above - here) / SLOPE_STEP)
