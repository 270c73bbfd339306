"""What is noted down along a stride: its results, its log, clearance and work."""

from __future__ import annotations

import math

from powered_walker_env.compilation import kernel
from powered_walker_env.integrator import dense_state, prepare_dense
from powered_walker_env.physics.actuation import ankle_power
from powered_walker_env.physics.ground import clearance, legs_have_passed
from powered_walker_env.physics.swing import energy

# Columns of a row of results.
STATE = slice(0, 4)  # post-strike state (α, s, α', β'); NaN unless the walker walked
FINAL = slice(4, 10)  # φ, α, β and rates at the end, before any heel strike
DURATION, STEP_LENGTH, ENERGY_IN, POSITIVE_WORK, ENERGY_LOST, MIN_CLEARANCE, LOGGED = range(10, 17)
RESULTS = 17

BISECTIONS = 40  # in search of a minimum: to 1e-12 of a step

# Columns of a row of the log: time, φ, α, β and rates, phase.
LOG_COLUMNS = 8


@kernel
def _cubic_minimum(value, slope, value_end, slope_end):
    """Where in (0, 1) the cubic with these ends (slopes per step) has its minimum, and how low.

    The place is 2 if it has none inside.
    """
    a = 2.0 * (value - value_end) + slope + slope_end
    b = 3.0 * (value_end - value) - 2.0 * slope - slope_end
    root = b * b - 3.0 * a * slope
    if root < 0.0 or (b <= 0.0 and a == 0.0):
        return 2.0, math.inf
    # Of the two forms of the root of the slope, the one that does not cancel.
    x = -slope / (b + math.sqrt(root)) if b > 0.0 else (math.sqrt(root) - b) / (3.0 * a)
    if not 0.0 < x < 1.0:
        return 2.0, math.inf
    return x, value + x * (slope + x * (b + x * a))


@kernel
def _positive_gain(value, slope, value_end, slope_end):
    """How much a quantity rises over a step, its falls left out (at most one turn inside)."""
    if slope < 0.0 < slope_end:
        _, low = _cubic_minimum(value, slope, value_end, slope_end)
        return max(0.0, value_end - min(low, value_end))
    if slope_end < 0.0 < slope:
        _, low = _cubic_minimum(-value, -slope, -value_end, -slope_end)
        return max(0.0, -min(low, -value) - value)
    return max(0.0, value_end - value)


@kernel
def energy_at(y, c):
    return energy(y[0], y[1], y[2], y[3], y[4], y[5], c)


@kernel
def _lowest_clearance(w, low, c):
    """The swing foot's lowest point on the interpolant after fraction `low`, by bisection."""
    high = 1.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        dense_state(w, middle)
        _, rate = clearance(w.work, c)
        if rate < 0.0:
            low = middle
        else:
            high = middle
    dense_state(w, high)
    return clearance(w.work, c)[0]


@kernel
def track_clearance(joints, torque, w, h, step_height, stall_torque, c, result):
    """Lower MIN_CLEARANCE to the swing foot's lowest point over a step with the legs passed."""
    if not legs_have_passed(w.y_new):
        return
    height, rate = clearance(w.y, c)
    lowest, rate_end = clearance(w.y_new, c)
    where, _ = _cubic_minimum(height, rate * h, lowest, rate_end * h)
    apart = w.y[1] - w.y[2] + math.pi  # α − s, which rises through zero as the legs pass
    apart_end = w.y_new[1] - w.y_new[2] + math.pi
    passed = 0.0 if apart > 0.0 else apart / (apart - apart_end)
    if passed < where < 1.0:
        prepare_dense(joints, torque, w, h, stall_torque, c)
        lowest = min(lowest, _lowest_clearance(w, passed, c))
    result[MIN_CLEARANCE] = min(result[MIN_CLEARANCE], lowest - step_height)


@kernel
def write_log(t, y, phase, log, result):
    """Append a row to the log if there is room."""
    row = int(result[LOGGED])
    if row < log.shape[0]:
        log[row, 0] = t
        log[row, 1:7] = y
        log[row, 7] = phase
        result[LOGGED] = row + 1


@kernel
def log_step(joints, torque, t, h, interval, phase, w, stall_torque, c, log, result):
    """Log the multiples of `interval` inside a step that begins at t."""
    k = math.floor(t / interval) + 1.0
    if k * interval >= t + h:
        return
    prepare_dense(joints, torque, w, h, stall_torque, c)
    while k * interval < t + h and result[LOGGED] < log.shape[0]:
        dense_state(w, (k * interval - t) / h)
        write_log(k * interval, w.work, phase, log, result)
        k += 1.0


@kernel
def track_work(torque, w, h, stall_torque, c, result):
    """Add the positive work of the ankle torque over a step to POSITIVE_WORK."""
    result[POSITIVE_WORK] += _positive_gain(
        energy_at(w.y, c),
        ankle_power(torque, w.y, stall_torque, c) * h,
        energy_at(w.y_new, c),
        ankle_power(torque, w.y_new, stall_torque, c) * h,
    )
