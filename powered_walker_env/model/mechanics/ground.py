"""Ground: swing-foot clearance, landing, the switch, and falls.

Every guard is a function of the configuration that is positive while the phase goes
on; the event is its fall through zero. Each returns its value and its rate. All but
`name_fall` take floats, or eight walkers at once (`lanes.py`).
"""

from __future__ import annotations

import math

from powered_walker_env.compiled.decorators import kernel
from powered_walker_env.compiled.lanes import where
from powered_walker_env.model.mechanics.swing import direction
from powered_walker_env.model.phases import Outcome

FLAT = 1e-12  # a ground step below this fraction of the leg is rounding: the floor is flat


@kernel
def swing_foot(phi, alpha, beta, c):
    """Centre of the swing foot from the centre of the stance foot, m (up + i·forward).

    The real part is the clearance on flat ground (the radius cancels), the imaginary
    part the distance from foot to foot.
    """
    swing = direction(beta)
    return c.D * direction(phi) + c.L * (direction(alpha) + swing) + c.retracted * swing


@kernel
def clearance(y, c):
    """Height of the swing foot above flat ground, m, and its rate, m/s."""
    foot, stance, swing = direction(y[0]), direction(y[1]), direction(y[2])
    swing_leg = c.L * swing + c.retracted * swing
    height = c.D * foot.real + c.L * stance.real + swing_leg.real
    rate = c.D * foot.imag * y[3] + c.L * stance.imag * y[4] + swing_leg.imag * y[5]
    return height, -rate


@kernel
def clearance_acceleration(y, slope, c):
    """Second time derivative of the clearance, m/s²; `slope` is that of y."""
    foot, stance, swing = direction(y[0]), direction(y[1]), direction(y[2])
    swing_leg = c.L * swing + c.retracted * swing
    centripetal = c.D * foot.real * y[3] * y[3] + c.L * stance.real * y[4] * y[4]
    tangential = c.D * foot.imag * slope[3] + c.L * stance.imag * slope[4]
    swing_part = swing_leg.real * y[5] * y[5] + swing_leg.imag * slope[5]
    return -centripetal - tangential - swing_part


@kernel
def locked_landing(y, c):
    """The factor of the clearance that vanishes at landing when both feet are locked.

    With K = L + D e^{−i·lock} and s = β − π the clearance is
    −2|K| sin((α − s)/2) sin((α + s)/2 + arg K). Its first factor vanishes as the legs
    pass, with foot and foot together; the landing is the second one rising through
    zero with α > s. Returned with its sign turned, so that it falls.
    """
    angle = direction(0.5 * (y[1] + y[2] - math.pi) + c.landing_angle)
    return -angle.imag, -angle.real * 0.5 * (y[4] + y[5])


@kernel
def landing(locked, y, step_height, c):
    """The swing foot's height above the ground ahead, scaled, and its rate."""
    factor, factor_rate = locked_landing(y, c)
    height, rate = clearance(y, c)
    on_the_level = locked & (abs(step_height) < FLAT * c.L)
    return (
        where(on_the_level, factor, (height - step_height) / c.L),
        where(on_the_level, factor_rate, rate / c.L),
    )


@kernel
def switch(y, switch_angle):
    """How far the hip angle q3 is from the switch angle, rad, and its rate."""
    return y[2] - y[1] - switch_angle, y[5] - y[4]


@kernel
def legs_have_passed(y):
    """Whether the swing foot is ahead: α > s = β − π. Only then is the floor a landing."""
    return y[1] > y[2] - math.pi


@kernel
def comes_down(locked, y, c):
    """Whether the swing foot, reaching the floor at `y`, lands there instead of scuffing.

    It must be ahead. With both feet locked it must also come down by the factor of
    `locked_landing`: a foot that scuffs as the legs pass does so on the floor that the
    other one stands on, and not on a step down, however small.
    """
    _, rate = locked_landing(y, c)
    return legs_have_passed(y) & (where(locked, rate, -1.0) < 0.0)


@kernel
def upright(locked, y, c):
    """How far the walker is from a fall (dimensionless), and its rate; a fall is zero.

    The least of: the cosine of the stance leg, of the swing leg, the height of the hip
    over L, and, with the ankle free, a foot that has not turned over. The foot may
    point its ankle anywhere but into the quarter under and ahead of its centre,
    π/2 < φ < π: cos(φ + π/4) + √½ > 0.
    """
    foot, stance, swing = direction(y[0]), direction(y[1]), direction(y[2])
    value, rate = stance.real, -stance.imag * y[4]
    lower = -swing.real < value
    value, rate = where(lower, -swing.real, value), where(lower, swing.imag * y[5], rate)
    hip = (c.R + c.D * foot.real) / c.L + stance.real
    lower = hip < value
    hip_rate = -c.D / c.L * foot.imag * y[3] - stance.imag * y[4]
    value, rate = where(lower, hip, value), where(lower, hip_rate, rate)
    turned, turned_rate = foot_upright(foot, y[3])
    turned = where(locked, 2.0, turned)
    lower = turned < value
    return where(lower, turned, value), where(lower, turned_rate, rate)


@kernel
def foot_upright(foot, rate):
    """cos(φ + π/4) + √½ and its rate, from e^{iφ}."""
    half = math.sqrt(0.5)
    return half * (foot.real - foot.imag) + half, -half * (foot.real + foot.imag) * rate


@kernel
def name_fall(locked, y, c):
    """The outcome of a state at which `upright` has come down to zero: its least term."""
    stance, swing = math.cos(y[1]), -math.cos(y[2])
    least = (c.R + c.D * math.cos(y[0])) / c.L + math.cos(y[1])
    outcome = Outcome.HIP_BELOW_FLOOR
    if stance <= least:
        least = stance
        outcome = Outcome.FELL_FORWARD if math.sin(y[1]) > 0.0 else Outcome.FELL_BACKWARD
    if swing < least:
        least, outcome = swing, Outcome.SWING_LEG_HORIZONTAL
    if not locked and foot_upright(direction(y[0]), y[3])[0] < least:
        over = math.sin(y[0]) > 0.5  # at φ = π/2, not at φ = −π
        outcome = Outcome.FOOT_ROLLED_OVER if over else Outcome.FOOT_FELL_BACK
    return outcome
