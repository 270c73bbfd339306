"""The swing foot and the floor: clearance, and when a touch is a landing.

All is said of a pose; heights are above the floor under the stance foot.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from powered_walker_env.compiled.decorators import formula, small
from powered_walker_env.compiled.lanes import unit, where

FLAT = 1e-12  # a ground step below this fraction of the leg is rounding: the floor is flat


class Held(NamedTuple):
    """Which joints are held by their locks."""

    ankle: Any  # of the stance leg
    knee: Any  # of the swing leg


@small
def swing_foot(pose, c):
    """Centre of the swing foot from the centre of the stance foot, m (up + i·forward).

    The real part is the clearance on flat ground (the radius cancels), the imaginary
    part the distance from foot to foot.
    """
    return c.D * pose.foot + c.L * pose.stance + c.thigh * pose.thigh + c.shank * pose.swing


@formula
def clearance(pose, c):
    """Height of the swing foot above flat ground, m, and its rate, m/s."""
    foot, stance = c.D * pose.foot, c.L * pose.stance
    thigh, shank = c.thigh * pose.thigh, c.shank * pose.swing
    rate = foot.imag * pose.dphi + stance.imag * pose.dalpha
    rate = rate + thigh.imag * pose.dtheta + shank.imag * pose.dbeta
    return foot.real + stance.real + thigh.real + shank.real, -rate


@small
def travel(pose, first_phi, c):
    """How far the contact point moves in a stride, m: foot to foot, and the rolling."""
    return swing_foot(pose, c).imag + c.R * (pose.phi - first_phi)


@small
def apart(pose):
    """α − s, the angle between the legs, of a bent one its thigh; it rises through zero as they
    pass."""
    return pose.alpha - pose.theta + math.pi


@formula
def last_factor(pose, c):
    """The factor of the clearance that vanishes at landing, and not as the legs pass.

    With all joints but the hip locked, and for a foot without length (D = 0) on straight legs,
    the clearance is
    −2|K| sin((α − s)/2) sin((α + s)/2 + arg K), K = L + D e^{−i·lock}, s = β − π. This is the
    second sine with its sign turned, so that it falls through zero as the foot lands.
    """
    mean = unit(0.5 * (pose.alpha + pose.beta - math.pi))
    return -(mean * c.lean).imag


@small
def factorises(held, c):
    """Whether the clearance has that factor."""
    return held.knee & (held.ankle | (c.D == 0.0))


@formula
def height_over_ground(held, pose, step_height, c):
    """What falls through zero as the swing foot meets the ground ahead, scaled.

    On the level its clearance may be said by the last factor alone: the legs' passing is no
    root of it.
    """
    level = factorises(held, c) & (abs(step_height) < FLAT * c.L)
    height, _ = clearance(pose, c)
    return where(level, last_factor(pose, c), (height - step_height) / c.L)


@formula
def lands(held, pose, factor_rate, together, c):
    """Whether the swing foot, reaching the ground at `pose`, lands there instead of scuffing.

    It must be ahead, and not beside the stance foot. Where the clearance factorises it must
    also come down by the last factor: a foot that scuffs as the legs pass does so on the floor
    that the other one stands on, and not on a step down, however small.

    Args:
        factor_rate: of `last_factor`, 1/s.
        together: distance from foot to foot, over L, up to which the feet stand together.
    """
    ahead = (apart(pose) > 0.0) & (swing_foot(pose, c).imag > together * c.L)
    return ahead & (where(factorises(held, c), factor_rate, -1.0) < 0.0)
