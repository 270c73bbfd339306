"""Events inside one integration step: has a guard fallen through zero, and exactly where?

A guard (`physics/ground.py`) is looked at through its values and rates at both ends of
the step. Where those allow a fall through zero, also one that is over again before the
step ends, the interpolant is searched; the step is then taken again so that it ends on
the event, which is found to rounding on the integrator's own accuracy.
"""

from __future__ import annotations

from powered_walker_env.compilation import kernel
from powered_walker_env.integrator import DIMENSION, STAGES, dense_state, prepare_dense, step
from powered_walker_env.phases import Guard
from powered_walker_env.physics.ground import (
    LANDING,
    comes_down,
    guard_value,
    legs_have_passed,
    upright,
)

FALL = len(Guard)  # the guard against falls, watched in every phase beside its own
BISECTIONS = 60  # enough to close any bracket in double precision
LANDING_STEPS = 8  # tries at a step that ends on the event
FIRST_ORDER = 1e-9  # s: below this the rest is linear to rounding (its square is 1e-18)


@kernel
def guard_at(guard, joints, y, switch_angle, step_height, c):
    """Value and rate of a phase's guard or of the guard against falls."""
    if guard == FALL:
        return upright(joints, y, c)
    return guard_value(guard, joints, y, switch_angle, step_height, c)


@kernel
def may_fall_through(value, rate, value_end, rate_end):
    """Whether the guard, smooth between the ends, can go from positive to not positive."""
    if value > 0.0:
        return value_end <= 0.0 or (rate < 0.0 and rate_end > 0.0)
    return value_end <= 0.0 and rate > 0.0 and rate_end < 0.0


@kernel
def _extremum(guard, joints, w, rising_first, switch_angle, step_height, c):
    """Fraction of the step at which the guard's rate changes sign, by bisection."""
    low, high = 0.0, 1.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        dense_state(w, middle)
        _, rate = guard_at(guard, joints, w.work, switch_angle, step_height, c)
        if (rate > 0.0) == rising_first:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@kernel
def _fall_between(guard, joints, w, low, high, switch_angle, step_height, c):
    """Fraction in (low, high] at which the guard reaches zero (Illinois, bounded)."""
    dense_state(w, low)
    above, _ = guard_at(guard, joints, w.work, switch_angle, step_height, c)
    dense_state(w, high)
    below, _ = guard_at(guard, joints, w.work, switch_angle, step_height, c)
    for _ in range(BISECTIONS):
        if below == 0.0 or high - low < 1e-15:
            break
        guess = high - below * (high - low) / (below - above)
        if not low < guess < high:
            guess = 0.5 * (low + high)
        dense_state(w, guess)
        value, _ = guard_at(guard, joints, w.work, switch_angle, step_height, c)
        if value > 0.0:
            low, above = guess, value
            below *= 0.5
        else:
            high, below = guess, value
            above *= 0.5
    return high


@kernel
def crossing(guard, joints, w, ends, switch_angle, step_height, c):
    """Fraction of the step at which a suspected event happens, or 2.0 if it does not.

    `ends` is (value, rate, value at the end, rate at the end); w.dense must be ready.
    """
    value, rate, value_end, _ = ends
    low, high = 0.0, 1.0
    if not (value > 0.0 and value_end <= 0.0):
        turn = _extremum(guard, joints, w, rate > 0.0, switch_angle, step_height, c)
        dense_state(w, turn)
        value_turn, _ = guard_at(guard, joints, w.work, switch_angle, step_height, c)
        if value > 0.0:
            high = turn
            if value_turn > 0.0:
                return 2.0
        else:
            low = turn
            if value_turn <= 0.0:
                return 2.0
    fraction = _fall_between(guard, joints, w, low, high, switch_angle, step_height, c)
    dense_state(w, fraction)
    if guard == LANDING and not comes_down(joints, w.work, c):
        return 2.0  # scuffing: allowed, as in the thesis
    return fraction


@kernel
def step_onto(guard, joints, torque, w, h, guess, control, step_height, c):
    """Take the step again so that w.y_new lies on the event.

    Newton on the length of the step, each time a full step of the method; the last
    correction is first order. Returns the length of the step and that correction, s.
    """
    switch_angle, stall_torque = control
    length = guess
    for attempt in range(LANDING_STEPS):
        step(joints, torque, w, length, stall_torque, c)
        value, rate = guard_at(guard, joints, w.y_new, switch_angle, step_height, c)
        change = -value / rate if rate != 0.0 else 0.0
        if abs(change) < FIRST_ORDER:
            for i in range(DIMENSION):
                w.y_new[i] += change * w.slopes[STAGES, i]
            return length, change
        if attempt < LANDING_STEPS - 1:
            length = min(h, max(0.0, length + change))
    return length, 0.0


@kernel
def find_event(joints, torque, w, h, guards, ends, control, step_height, c):
    """The first event in the step just taken: index into `guards` (or −1) and fraction."""
    switch_angle, stall_torque = control
    first, fraction = -1, 2.0
    ready = False
    for k in range(len(guards)):
        value, rate, value_end, rate_end = ends[k, 0], ends[k, 1], ends[k, 2], ends[k, 3]
        if not may_fall_through(value, rate, value_end, rate_end):
            continue
        if guards[k] == LANDING and not (legs_have_passed(w.y) or legs_have_passed(w.y_new)):
            continue
        if not ready:
            prepare_dense(joints, torque, w, h, stall_torque, c)
            ready = True
        where = crossing(
            guards[k],
            joints,
            w,
            (value, rate, value_end, rate_end),
            switch_angle,
            step_height,
            c,
        )
        if where < fraction:
            first, fraction = k, where
    return first, fraction
