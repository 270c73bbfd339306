"""Guards: one formula each, positive while a phase goes on; its fall through zero ends the phase.

The rate of a guard, and its derivative by anything, follow from the formula: it is called with
poses that carry tangents (`compiled/lanes`). To add a guard: its formula, a line in `value_of`, a
member of `Guard`, and an `Outcome` if it ends the stride.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from powered_walker_env.compiled.decorators import formula, rare, small
from powered_walker_env.compiled.lanes import where
from powered_walker_env.model.mechanics.actuation import ankle_torque
from powered_walker_env.model.mechanics.chain import (
    accelerations,
    bias,
    couplings,
    cross,
    mass_matrix,
)
from powered_walker_env.model.mechanics.ground import height_over_ground
from powered_walker_env.model.phases import Guard, Outcome

SWITCH_ANGLE, LANDING = int(Guard.SWITCH_ANGLE), int(Guard.LANDING)
STOP, RELEASE = int(Guard.STOP), int(Guard.RELEASE)
KNEE_STRIKE = int(Guard.KNEE_STRIKE)
STANCE_LEG_DOWN, SWING_LEG_DOWN = int(Guard.STANCE_LEG_DOWN), int(Guard.SWING_LEG_DOWN)
HIP_DOWN, FOOT_TURNED = int(Guard.HIP_DOWN), int(Guard.FOOT_TURNED)
FIRST_FALL = STANCE_LEG_DOWN  # those from here on are falls, watched in every phase


class Aims(NamedTuple):
    """What the guards of a stride are set to."""

    switch_angle: Any  # rad
    step_height: Any  # m, of the ground ahead


@small
def switch(pose, switch_angle):
    """How far the hip angle q3 is from the switch angle, rad."""
    return pose.theta - pose.alpha - switch_angle


@small
def stop(pose, c):
    """How far the ankle is from its stop, rad, positive when extended."""
    return c.lock - (pose.alpha - pose.phi)


@rare
def holding_torque(pose, acting, locked, free, c):
    """What the stop must give beside the motor to keep the ankle locked, over MgL.

    From the foot's own equation, row φ of mass matrix · accelerations + bias = τ, of the walker
    that moves as its locked chain does.
    """
    zero = 0.0 * pose.alpha
    y = (pose.phi, zero, pose.beta, pose.dphi, zero, pose.dbeta)
    d1, _, d3 = accelerations(y, acting.stall, acting.pull, locked, c)
    at = couplings(pose.foot, pose.stance, pose.swing, free, c)
    m = mass_matrix(at, free, c)
    b1, _, _ = bias(at, pose.dphi, pose.dalpha, pose.dbeta, free, c)
    needed = (m.m11 + m.m12) * d1 + c.reaction * m.m13 * d3 + b1
    return (needed - ankle_torque(pose.dalpha - pose.dphi, acting, c)) / holding_unit(c)


@small
def holding_unit(c):
    """MgL, N m; for gravity its component along the floor's normal."""
    return c.M * c.L * c.g.real


@small
def knee(pose):
    """sin(β − θ): positive while the shank hangs back behind the thigh.

    It falls through zero as the shank catches up, and as it folds up against the thigh.
    """
    return cross(pose.thigh, pose.swing)


@small
def stance_leg_up(pose):
    """cos α: zero with the stance leg horizontal."""
    return pose.stance.real


@small
def swing_leg_up(pose):
    """−cos θ: zero with the swing leg, of a bent one its thigh, horizontal."""
    return -pose.thigh.real


@formula
def hip_up(pose, c):
    """The height of the hip above the floor, over L; without a foot the stance leg says it all."""
    height = (c.R + c.D * pose.foot.real) / c.L + pose.stance.real
    return where(c.R + c.D > 0.0, height, 1.0 + 0.0 * height)


@small
def foot_up(pose):
    """How far a free foot is from having turned over.

    It may point its ankle anywhere but into the quarter under and ahead of its centre,
    π/2 < φ < π: cos(φ + π/4) + √½ > 0.
    """
    half = math.sqrt(0.5)
    return half * (pose.foot.real - pose.foot.imag) + half


@formula
def fall_value(guard, held, pose, c):
    """The value of a guard against a fall."""
    if guard == STANCE_LEG_DOWN:
        return stance_leg_up(pose)
    if guard == SWING_LEG_DOWN:
        return swing_leg_up(pose)
    if guard == HIP_DOWN:
        return hip_up(pose, c)
    return where(held.ankle, 1.0 + 0.0 * pose.phi, foot_up(pose))


@formula
def nearest_fall(held, pose, h, c):
    """The least that a guard against falls can have come to within h before this moving pose.

    A guard that has dipped below zero and is up again now lies within twice its slope. While
    this is positive no fall need be looked for.
    """
    least = _least_before(stance_leg_up(pose), h, 1.0 + 0.0 * h)
    least = _least_before(swing_leg_up(pose), h, least)
    least = _least_before(hip_up(pose, c), h, least)
    return where(held.ankle, least, _least_before(foot_up(pose), h, least))


@formula
def _least_before(guard, h, least):
    reach = 2.0 * h * guard.tangent
    value = where(reach > 0.0, guard.value - reach, guard.value)
    return where(value < least, value, least)


@formula
def value_of(guard, held, pose, acting, aims, chains, c):
    """The value of a guard; `chains` are the walker's: locked, ankle free, knee free."""
    if guard == SWITCH_ANGLE:
        return switch(pose, aims.switch_angle)
    if guard == LANDING:
        return height_over_ground(held, pose, aims.step_height, c)
    if guard == STOP:
        return stop(pose, c)
    if guard == RELEASE:
        return holding_torque(pose, acting, chains[0], chains[1], c)
    if guard == KNEE_STRIKE:
        return knee(pose)
    return fall_value(guard, held, pose, c)


@small
def fall_outcome(guard, stance, foot):
    """How a stride has ended that a fall's guard ended, from the sines of α and φ."""
    if guard == STANCE_LEG_DOWN:
        return Outcome.FELL_FORWARD if stance > 0.0 else Outcome.FELL_BACKWARD
    if guard == SWING_LEG_DOWN:
        return Outcome.SWING_LEG_HORIZONTAL
    if guard == HIP_DOWN:
        return Outcome.HIP_BELOW_FLOOR
    # At φ = π/2, not at φ = −π.
    return Outcome.FOOT_ROLLED_OVER if foot > 0.5 else Outcome.FOOT_FELL_BACK
