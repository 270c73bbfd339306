"""Ground: swing-foot clearance, landing, the switch, and falls.

Every guard is a function of the configuration that is positive while the phase goes
on; the event is its fall through zero. Each returns its value and its rate.
"""

from __future__ import annotations

import cmath
import math

from powered_walker_env.compilation import kernel
from powered_walker_env.phases import Guard, Joints, Outcome
from powered_walker_env.physics.swing import direction

FREE = int(Joints.ANKLE_FREE)
LOCKED = int(Joints.ANKLE_LOCKED)
SWITCH_ANGLE = int(Guard.SWITCH_ANGLE)
LANDING = int(Guard.LANDING)
FLAT = 1e-12  # a ground step below this fraction of the leg is rounding: the floor is flat


@kernel
def swing_foot(phi, alpha, beta, c):
    """Centre of the swing foot from the centre of the stance foot, m (up + i·forward).

    The real part is the clearance on flat ground (the radius cancels), the imaginary
    part the distance from foot to foot.
    """
    legs = c.L * (direction(alpha) + direction(beta))
    return c.D * (direction(phi) + direction(beta - c.lock)) + legs


@kernel
def clearance(y, c):
    """Height of the swing foot above flat ground, m, and its rate, m/s."""
    foot = swing_foot(y[0], y[1], y[2], c)
    stance_foot = -c.D * math.sin(y[0]) * y[3]
    stance_leg = -c.L * math.sin(y[1]) * y[4]
    swing_leg = -(c.L * math.sin(y[2]) + c.D * math.sin(y[2] - c.lock)) * y[5]
    return foot.real, stance_foot + stance_leg + swing_leg


@kernel
def locked_landing(y, c):
    """The factor of the clearance that vanishes at landing when both feet are locked.

    With K = L + D e^{−i·lock} and s = β − π the clearance is
    −2|K| sin((α − s)/2) sin((α + s)/2 + arg K). Its first factor vanishes as the legs
    pass, with foot and foot together; the landing is the second one rising through
    zero with α > s. Returned with its sign turned, so that it falls.
    """
    angle = 0.5 * (y[1] + y[2] - math.pi) + cmath.phase(c.L + c.D * direction(-c.lock))
    return -math.sin(angle), -math.cos(angle) * 0.5 * (y[4] + y[5])


@kernel
def landing(joints, y, step_height, c):
    """The swing foot's height above the ground ahead, scaled, and its rate."""
    if joints == LOCKED and abs(step_height) < FLAT * c.L:
        return locked_landing(y, c)
    height, rate = clearance(y, c)
    return (height - step_height) / c.L, rate / c.L


@kernel
def guard_value(guard, joints, y, switch_angle, step_height, c):
    """Value and rate of a phase's guard."""
    if guard == SWITCH_ANGLE:
        return y[2] - y[1] - switch_angle, y[5] - y[4]
    if guard == LANDING:
        return landing(joints, y, step_height, c)
    return 1.0, 0.0


@kernel
def legs_have_passed(y):
    """Whether the swing foot is ahead: α > s = β − π. Only then is the floor a landing."""
    return y[1] > y[2] - math.pi


@kernel
def comes_down(joints, y, c):
    """Whether the swing foot, reaching the floor at `y`, lands there instead of scuffing.

    It must be ahead. With both feet locked it must also come down by the factor of
    `locked_landing`: a foot that scuffs as the legs pass does so on the floor that the
    other one stands on, and not on a step down, however small.
    """
    if not legs_have_passed(y):
        return False
    _, rate = locked_landing(y, c)
    return joints != LOCKED or rate < 0.0


@kernel
def upright(joints, y, c):
    """How far the walker is from a fall (dimensionless), and its rate; a fall is zero.

    The least of: the cosine of the stance leg, of the swing leg, the height of the hip
    over L, and, with the ankle free, a foot that has not turned over. The foot may
    point its ankle anywhere but into the quarter under and ahead of its centre,
    π/2 < φ < π: cos(φ + π/4) + √½ > 0.
    """
    value, rate = math.cos(y[1]), -math.sin(y[1]) * y[4]
    swing = -math.cos(y[2])
    if swing < value:
        value, rate = swing, math.sin(y[2]) * y[5]
    hip = (c.R + c.D * math.cos(y[0])) / c.L + math.cos(y[1])
    if hip < value:
        value = hip
        rate = -c.D / c.L * math.sin(y[0]) * y[3] - math.sin(y[1]) * y[4]
    if joints == FREE:
        foot = math.cos(y[0] + 0.25 * math.pi) + math.sqrt(0.5)
        if foot < value:
            value, rate = foot, -math.sin(y[0] + 0.25 * math.pi) * y[3]
    return value, rate


@kernel
def name_fall(joints, y, c):
    """The outcome of a state at which `upright` has come down to zero: its least term."""
    stance, swing = math.cos(y[1]), -math.cos(y[2])
    least = (c.R + c.D * math.cos(y[0])) / c.L + math.cos(y[1])
    outcome = Outcome.HIP_BELOW_FLOOR
    if stance <= least:
        least = stance
        outcome = Outcome.FELL_FORWARD if math.sin(y[1]) > 0.0 else Outcome.FELL_BACKWARD
    if swing < least:
        least, outcome = swing, Outcome.SWING_LEG_HORIZONTAL
    if joints == FREE and math.cos(y[0] + 0.25 * math.pi) + math.sqrt(0.5) < least:
        over = math.sin(y[0]) > 0.5  # at φ = π/2, not at φ = −π
        outcome = Outcome.FOOT_ROLLED_OVER if over else Outcome.FOOT_FELL_BACK
    return outcome
