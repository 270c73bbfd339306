"""Where inside a step a guard falls through zero: by its ends, or by the step's interpolant."""

from __future__ import annotations

from powered_walker_env.compiled.decorators import internal, once, rare
from powered_walker_env.compiled.lanes import (
    bits,
    load,
    where,
)
from powered_walker_env.model.mechanics.guards import (
    LANDING,
    RELEASE,
)
from powered_walker_env.simulation.interpolant import interpolate, look_inside
from powered_walker_env.simulation.lockstep import flow_at
from powered_walker_env.simulation.poses import joined, posed
from powered_walker_env.simulation.runge_kutta import constants_lanes
from powered_walker_env.simulation.watching import along, factor_rate, guard_along, landing_lanes

BISECTIONS = 60  # enough to close any bracket in double precision
NEWTON_STEPS = 4  # on a cubic, from inside its bracket
NOWHERE = 2.0  # a fraction of the step past its end


@once
def cubic_fall(value, slope, value_end, slope_end):
    """Where in (0, 1) the cubic with these ends (slopes per step) falls through zero."""
    low, high = 0.0 * value, 0.0 * value + 1.0
    x = value / (value - value_end)
    a = 2.0 * (value - value_end) + slope + slope_end
    b = 3.0 * (value_end - value) - 2.0 * slope - slope_end
    for _ in range(NEWTON_STEPS):
        here = value + x * (slope + x * (b + x * a))
        low, high = where(here > 0.0, x, low), where(here > 0.0, high, x)
        steep = slope + x * (2.0 * b + 3.0 * x * a)
        x = where(steep < 0.0, x - here / steep, low)
        x = where((low < x) & (x < high), x, 0.5 * (low + high))
    return x


@internal
def _guard_inside(s, w, batch, lane, guard, fraction):
    """Is one lane's guard up, and rising, at a fraction of the step; would it land there?"""
    y = look_inside(w, fraction + 0.0 * load(w.length, 0))
    none = 0.0 * y[0]
    moved = y[3], y[4], y[5], none, none, none
    if guard == RELEASE:  # the only one that looks at accelerations
        moved = flow_at(s, w, y)
    pose = along(w, posed(y, joined(w), constants_lanes(w.constants)), moved)
    found = guard_along(s, w, guard, pose)
    up, rising = bits(found.value > 0.0) >> lane & 1, bits(found.tangent > 0.0) >> lane & 1
    return up, rising, landing_lanes(w, batch, pose, factor_rate(w, pose)) >> lane & 1


@rare
def hidden_fall(s, w, batch, lane, guard):
    """Fraction at which a guard falls whose ends only hint at it; NOWHERE if it does not.

    Bisection on the interpolant: for the turn first, then for the fall.
    """
    interpolate(s, w)
    first_rising = 1 if s.rate[guard, lane] > 0.0 else 0
    low, high, positive, lands_there = 0.0, 1.0, 0, 0
    for turn in range(2 * BISECTIONS):
        if turn == BISECTIONS:
            positive, _, _ = _guard_inside(s, w, batch, lane, guard, high)
            if (positive == 1) == (s.value[guard, lane] > 0.0):
                return NOWHERE
            low, high = (0.0, high) if positive == 0 else (high, 1.0)
        middle = 0.5 * (low + high)
        up, rising, _ = _guard_inside(s, w, batch, lane, guard, middle)
        before = rising == first_rising if turn < BISECTIONS else up == 1
        low, high = (middle, high) if before else (low, middle)
    _, _, lands_there = _guard_inside(s, w, batch, lane, guard, high)
    return NOWHERE if guard == LANDING and lands_there == 0 else high  # scuffing is allowed
