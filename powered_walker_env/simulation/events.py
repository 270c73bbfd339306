"""Events: has a guard fallen through zero inside a step, and exactly where?

A guard (`physics/ground.py`) is looked at through its values and rates at both ends of
the step. Where those allow a fall through zero, also one that is over again before the
step ends, its place is guessed; the step is then taken again so that it ends on the
event, Newton's way, each try being a full step of the method, until what is left is
linear to the accuracy asked for.
"""

from __future__ import annotations

from powered_walker_env.compiled.decorators import internal, rare
from powered_walker_env.compiled.lanes import LANES, bits, load, store, where
from powered_walker_env.model.mechanics.actuation import flow, holding_torque
from powered_walker_env.model.mechanics.constants import lanes_of
from powered_walker_env.model.mechanics.ground import (
    comes_down,
    landing,
    legs_have_passed,
    switch,
    upright,
)
from powered_walker_env.model.mechanics.stop import stop
from powered_walker_env.model.mechanics.tangents import holding_torque_rate
from powered_walker_env.model.phases import Guard
from powered_walker_env.simulation.interpolant import interpolate, look_inside
from powered_walker_env.simulation.lockstep import FALL, GUARDS, blend
from powered_walker_env.simulation.runge_kutta import acting

SWITCH_ANGLE, LANDING = int(Guard.SWITCH_ANGLE), int(Guard.LANDING)
STOP, RELEASE = int(Guard.STOP), int(Guard.RELEASE)
BISECTIONS = 60  # enough to close any bracket in double precision
NEWTON_STEPS = 4  # on a cubic, from inside its bracket
TRIES = 8  # steps towards one event
NOWHERE = 2.0  # a fraction of the step past its end


@rare
def _release(locked, y, drive, c):
    """Whether the stop still holds the ankle: the torque it has to give, and its rate."""
    slope = flow(locked, y, drive, c)
    return holding_torque(y, slope, drive, c), holding_torque_rate(y, slope, drive, c)


@internal
def guard_at(guard, locked, y, drive, switch_angle, step_height, c):
    """Value and rate of one guard, of eight walkers."""
    if guard == SWITCH_ANGLE:
        return switch(y, switch_angle)
    if guard == LANDING:
        return landing(locked, y, step_height, c)
    if guard == STOP:
        return stop(y, c)
    if guard == RELEASE:
        return _release(locked, y, drive, c)
    return upright(locked, y, c)


@internal
def watch(s, locked, y, drive, c, mask, values, rates):
    """Write all guards' values and rates at y where the mask holds."""
    for guard in (SWITCH_ANGLE, LANDING, FALL):
        _watch(s, guard, locked, y, drive, c, mask, values, rates)
    for guard in (STOP, RELEASE):
        if bits(load(s.active, guard) > 0.0):
            _watch(s, guard, locked, y, drive, c, mask, values, rates)


@internal
def _watch(s, guard, locked, y, drive, c, mask, values, rates):
    switch_angle, height = load(s.switch_angle, 0), load(s.height, 0)
    value, rate = guard_at(guard, locked, y, drive, switch_angle, height, c)
    blend(values, guard, mask, value)
    blend(rates, guard, mask, rate)


@internal
def may_fall_through(value, rate, value_end, rate_end, h):
    """Whether a guard, smooth between the ends, can go from positive to not positive.

    Where it turns inside the step, it lies within its tangents at the ends; twice their
    slope is allowed for.
    """
    reach, reach_end = 2.0 * h * rate, 2.0 * h * rate_end
    down = (value > 0.0) & (value_end <= 0.0)
    dip = (value > 0.0) & (value + reach <= 0.0) & (value_end > 0.0) & (value_end <= reach_end)
    hump = (value <= 0.0) & (value + reach > 0.0) & (value_end <= 0.0) & (value_end > reach_end)
    return down | dip | hump


@internal
def suspicions(s, h, y, y_new):
    """For each guard, NEVER left out, the lanes (bits) in which it may have fallen through zero.

    Args:
        h: s, lengths of the steps; y, y_new: their ends.
    """
    ahead = (legs_have_passed(y) | legs_have_passed(y_new)) & (load(s.scuffed, 0) == 0.0)
    stopped, released = 0, 0
    if bits(load(s.active, STOP) + load(s.active, RELEASE) > 0.0):
        stopped = bits(_suspicion(s, STOP, h))
        released = bits(_suspicion(s, RELEASE, h))
    return (
        bits(_suspicion(s, SWITCH_ANGLE, h)),
        bits(_suspicion(s, LANDING, h) & ahead),
        stopped,
        released,
        bits(_suspicion(s, FALL, h)),
    )


@internal
def _suspicion(s, guard, h):
    value, value_end = load(s.value, guard), load(s.value_new, guard)
    doubt = may_fall_through(value, load(s.rate, guard), value_end, load(s.rate_new, guard), h)
    watched = (load(s.active, guard) > 0.0) & (load(s.busy, 0) > 0.0)
    return watched & doubt & ~(load(s.target, 0) == guard)


@internal
def over_at_once(s):
    """Lanes, as bits, whose phase is over as it begins; notes why in s.ending.

    A hip already past the switch and closing starts the motor at once, a stop with
    nothing to hold lets go at once, and a walker that is already down has fallen. A
    landing must be a fall through the floor, and a stop be met.
    """
    switching = (load(s.active, SWITCH_ANGLE) > 0.0) & (load(s.rate, SWITCH_ANGLE) < 0.0)
    switched = bits(switching & (load(s.value, SWITCH_ANGLE) <= 0.0))
    loose = bits((load(s.active, RELEASE) > 0.0) & (load(s.value, RELEASE) <= 0.0))
    down = bits(load(s.value, FALL) <= 0.0)
    for lane in range(LANES):
        if (switched | loose | down) >> lane & 1:
            s.ending[0, lane] = RELEASE if loose >> lane & 1 else SWITCH_ANGLE
            if down >> lane & 1:
                s.ending[0, lane] = FALL
    return switched | loose | down


@internal
def cubic_fall(value, slope, value_end, slope_end):
    """Where in (0, 1) the cubic with these ends (slopes per step) falls through zero."""
    low, high = 0.0, 1.0
    x = value / (value - value_end)
    for _ in range(NEWTON_STEPS):
        a = 2.0 * (value - value_end) + slope + slope_end
        b = 3.0 * (value_end - value) - 2.0 * slope - slope_end
        here = value + x * (slope + x * (b + x * a))
        if here > 0.0:
            low = x
        else:
            high = x
        steep = slope + x * (2.0 * b + 3.0 * x * a)
        x = x - here / steep if steep < 0.0 else 0.5 * (low + high)
        if not low < x < high:
            x = 0.5 * (low + high)
    return x


@internal
def _guard_inside(s, w, lane, guard, fraction):
    """Value and rate of one lane's guard at a fraction of the step; is touching the floor
    there a landing?"""
    c, locked = lanes_of(w.constants), load(w.locked, 0) > 0.0
    y = look_inside(w, fraction + 0.0 * load(w.length, 0))
    switch_angle, height = load(s.switch_angle, 0), load(s.height, 0)
    value, rate = guard_at(guard, locked, y, acting(w), switch_angle, height, c)
    lands = bits(comes_down(locked, y, c)) >> lane & 1
    return bits(value > 0.0) >> lane & 1, bits(rate > 0.0) >> lane & 1, lands


@rare
def hidden_fall(s, w, lane, guard):
    """Fraction at which a guard falls whose ends only hint at it; NOWHERE if it does not.

    Bisection on the interpolant: for the turn first, then for the fall.
    """
    interpolate(w)
    rising = 1 if s.rate[guard, lane] > 0.0 else 0
    low, high = 0.0, 1.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        _, up, _ = _guard_inside(s, w, lane, guard, middle)
        if up == rising:
            low = middle
        else:
            high = middle
    positive, _, _ = _guard_inside(s, w, lane, guard, high)
    if (positive == 1) == (s.value[guard, lane] > 0.0):
        return NOWHERE
    low, high = (0.0, high) if positive == 0 else (high, 1.0)
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        positive, _, _ = _guard_inside(s, w, lane, guard, middle)
        if positive == 1:
            low = middle
        else:
            high = middle
    _, _, lands = _guard_inside(s, w, lane, guard, high)
    return NOWHERE if guard == LANDING and lands == 0 else high  # scuffing is allowed


@internal
def first_fall(s, w, lane, suspected):
    """The first of the suspected guards (bits) to fall: guard and fraction of the step."""
    first, earliest, h = 0, NOWHERE, w.length[0, lane]
    for guard in range(1, GUARDS):
        if not suspected >> guard & 1:
            continue
        value, value_end = s.value[guard, lane], s.value_new[guard, lane]
        if value > 0.0 and value_end <= 0.0:
            slope, slope_end = s.rate[guard, lane] * h, s.rate_new[guard, lane] * h
            fraction = cubic_fall(value, slope, value_end, slope_end)
        else:
            fraction = hidden_fall(s, w, lane, guard)
        if fraction < earliest:
            first, earliest = guard, fraction
    return first, earliest


@internal
def aim(s, w, lane, guard, fraction):
    """Step onto the event from now on."""
    if s.target[0, lane] == 0.0:
        s.whole[0, lane] = w.length[0, lane]
        s.tries[0, lane] = 0
    s.target[0, lane] = guard
    w.length[0, lane] *= fraction


@internal
def arrive(s, w, lane, landed, linear):
    """The step towards an event has been made: is it there?

    Args:
        landed: at its end, would a touch of the floor be a landing?
        linear: s, below which the rest of the way is linear.

    Returns:
        Whether it is; if not, the next try is prepared.
    """
    guard = int(s.target[0, lane])
    value, rate = s.value_new[guard, lane], s.rate_new[guard, lane]
    change = -value / rate if rate != 0.0 else 0.0
    s.tries[0, lane] += 1
    near = abs(change) < linear
    if near or s.tries[0, lane] >= TRIES:
        if guard == LANDING and not landed:
            s.scuffed[0, lane], s.target[0, lane] = 1.0, 0.0  # take the whole step after all
            s.h[0, lane] = s.whole[0, lane]
            return False
        s.correction[0, lane] = change if near else 0.0
        s.ending[0, lane] = guard
        return True
    w.length[0, lane] = min(s.whole[0, lane], max(0.0, w.length[0, lane] + change))
    return False


@internal
def landing_lanes(w, y, c):
    """Lanes, as bits, in which a touch of the floor at y is a landing."""
    return bits(comes_down(load(w.locked, 0) > 0.0, y, c))


@internal
def planned(s, w, longest, latest):
    """Set the lengths of the steps: towards an event as aimed, else as the control proposes.

    Args:
        longest: s; latest: s, when the stride is given up.
    """
    h = load(s.h, 0)
    h = where(h < longest, h, longest)
    left = latest - load(s.t, 0)
    h = where(h < left, h, left)
    store(w.length, 0, where(load(s.target, 0) > 0.0, load(w.length, 0), h))
