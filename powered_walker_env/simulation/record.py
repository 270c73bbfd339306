"""What is noted down along a stride: its results, its log, clearance and work."""

from __future__ import annotations

import math
from typing import NamedTuple

from powered_walker_env.compiled.decorators import internal, rare
from powered_walker_env.compiled.lanes import Table, bits, load, rows_from, where
from powered_walker_env.model.mechanics.actuation import ankle_torque, flow, power
from powered_walker_env.model.mechanics.constants import NO_LOAD_SPEED, lanes_of
from powered_walker_env.model.mechanics.ground import clearance, clearance_acceleration, swing_foot
from powered_walker_env.model.mechanics.swing import energy
from powered_walker_env.model.phases import Outcome
from powered_walker_env.simulation.interpolant import interpolate, look_inside
from powered_walker_env.simulation.lockstep import blend
from powered_walker_env.simulation.runge_kutta import (
    DIMENSION,
    acting,
    first_lane,
    load_state,
)

# Columns of a row of results.
STATE = slice(0, 4)  # post-strike state (α, s, α', β'); NaN unless the walker walked
FINAL = slice(4, 10)  # φ, α, β and rates at the end, before any heel strike
DURATION, STEP_LENGTH, ENERGY_IN, POSITIVE_WORK, ENERGY_LOST, MIN_CLEARANCE = range(10, 16)
ELECTRICAL_ENERGY, OUTCOME = 16, 17
RESULTS = 18
WALKED = int(Outcome.WALKED)

# Columns of a row of the log: time, φ, α, β and rates, phase.
LOG_COLUMNS = 8

NEWTON_STEPS = 2  # towards a minimum, from the cubic's: what is left counts squared


class Totals(NamedTuple):
    """Sums over the strides of eight walkers, and what the next step adds to them; a row each."""

    energy: Table  # J, where the step begins
    power: Table  # W, of the torques
    torque: Table  # N m, of the ankle's motor
    height: Table  # m, of the swing foot above flat ground
    descent: Table  # m/s, its rate
    energy_in: Table  # J
    positive_work: Table  # J
    impulse: Table  # N m s, of the motor's torque
    lost: Table  # J, in the impacts before the last
    lowest: Table  # m, of the swing foot since the legs passed


TOTALS_ROWS = 10


@internal
def totals(rows):
    """Those in the first TOTALS_ROWS of a table of lanes."""
    return Totals(
        rows, rows_from(rows, 1), rows_from(rows, 2), rows_from(rows, 3), rows_from(rows, 4),
        rows_from(rows, 5), rows_from(rows, 6), rows_from(rows, 7), rows_from(rows, 8),
        rows_from(rows, 9),
    )  # fmt: skip


@internal
def clear(sums, lane):
    """Nothing has been added up for this lane's stride."""
    sums.energy_in[0, lane], sums.positive_work[0, lane] = 0.0, 0.0
    sums.impulse[0, lane], sums.lost[0, lane] = 0.0, 0.0
    sums.lowest[0, lane] = math.inf


@internal
def look(sums, mask, y, drive, c):
    """Take energy, power and clearance at y as those where the step begins."""
    height, descent = clearance(y, c)
    blend(sums.energy, 0, mask, energy(y[0], y[1], y[2], y[3], y[4], y[5], c))
    blend(sums.power, 0, mask, power(y, drive, c))
    blend(sums.torque, 0, mask, ankle_torque(y, drive, c))
    blend(sums.height, 0, mask, height)
    blend(sums.descent, 0, mask, descent)


@internal
def cubic_minimum(value, slope, value_end, slope_end):
    """Where in (0, 1) the cubic with these ends (slopes per step) has its minimum, and how low.

    The place is 2 if it has none inside.
    """
    a = 2.0 * (value - value_end) + slope + slope_end
    b = 3.0 * (value_end - value) - 2.0 * slope - slope_end
    root = b * b - 3.0 * a * slope
    width = math.sqrt(where(root > 0.0, root, 0.0))
    # Of the two forms of the root of the slope, the one that does not cancel.
    x = where(b > 0.0, -slope / (b + width), (width - b) / (3.0 * a))
    inside = (root >= 0.0) & (x > 0.0) & (x < 1.0)
    low = value + x * (slope + x * (b + x * a))
    return where(inside, x, 2.0), where(inside, low, math.inf)


@internal
def _gain(value, slope, value_end, slope_end):
    """How much a quantity rises over a step, its falls left out (at most one turn inside)."""
    _, bottom = cubic_minimum(value, slope, value_end, slope_end)
    _, top = cubic_minimum(-value, -slope, -value_end, -slope_end)
    bottom = where(bottom < value_end, bottom, value_end)
    top = where(top < -value, -top, value)
    up = where(value_end > value, value_end - value, 0.0)
    after_dip = where((slope < 0.0) & (slope_end > 0.0), value_end - bottom, up)
    return where((slope > 0.0) & (slope_end < 0.0), top - value, after_dip)


@internal
def add_step(sums, s, w, mask, taken):
    """Add the work of the step just taken, and where the swing foot was lowest in it.

    Args:
        taken: s, the length of the step, its correction included.
    """
    y_new, drive, c = load_state(w.y_new, 0), acting(w), lanes_of(w.constants)
    before, rising, torque = load(sums.energy, 0), load(sums.power, 0), load(sums.torque, 0)
    height, descent = load(sums.height, 0), load(sums.descent, 0)
    look(sums, mask, y_new, drive, c)
    after = load(sums.energy, 0)
    powered = mask & (load(s.powered, 0) > 0.0)
    gain = _gain(before, rising * taken, after, load(sums.power, 0) * taken)
    blend(sums.energy_in, 0, powered, load(sums.energy_in, 0) + (after - before))
    blend(sums.positive_work, 0, powered, load(sums.positive_work, 0) + gain)
    if bits(load(s.motor, 0) > 0.0):
        given = _torque_impulse(w, drive, y_new, torque, load(sums.torque, 0), taken, c)
        motor = mask & (load(s.motor, 0) > 0.0)
        blend(sums.impulse, 0, motor, load(sums.impulse, 0) + given)
    ahead = mask & (y_new[1] > y_new[2] - math.pi)
    low = load(sums.height, 0)
    where_low, _ = cubic_minimum(height, descent * taken, low, load(sums.descent, 0) * taken)
    apart, apart_end = _apart(load_state(w.y, 0)), _apart(y_new)
    passed = where(apart > 0.0, 0.0, apart / (apart - apart_end))
    dips = ahead & (where_low > passed) & (where_low < 1.0)
    if bits(dips):
        deep = _lowest_inside(w, where_low, passed, c)
        low = where(dips & (deep < low), deep, low)
    low = low - load(s.height, 0)
    lowest = load(sums.lowest, 0)
    blend(sums.lowest, 0, ahead & (low < lowest), low)


@internal
def _torque_impulse(w, drive, y_new, torque, torque_end, taken, c):
    """∫τ dt of the motor over the step, N m s: its line exactly, its limit as the mean."""
    turned = (y_new[1] - y_new[0]) - (load(w.y, 1) - load(w.y, 0))
    line = drive.strength * (taken + drive.slope * turned)
    bounded = (abs(torque) >= c.torque_limit) | (abs(torque_end) >= c.torque_limit)
    return where(bounded, 0.5 * (torque + torque_end) * taken, line)


@internal
def _apart(y):
    """α − s, which rises through zero as the legs pass."""
    return y[1] - y[2] + math.pi


@rare
def _lowest_inside(w, x, earliest, c):
    """The lowest clearance near fraction x of the step: Newton on the interpolant."""
    interpolate(w)
    h = load(w.length, 0)
    for _ in range(NEWTON_STEPS):
        y = look_inside(w, x)
        _, rate = clearance(y, c)
        slope = flow(load(w.locked, 0) > 0.0, y, acting(w), c)
        bend = h * clearance_acceleration(y, slope, c)
        x = where(bend > 0.0, x - rate / bend, x)
        x = where(x > earliest, x, earliest)
        x = where(x < 1.0, x, 1.0)
    height, _ = clearance(look_inside(w, x), c)
    return height


@internal
def write_row(results, row, s, w, sums, lane, outcome):
    """The results of the stride that one lane has ended."""
    walked = outcome == WALKED
    for i in range(DIMENSION):
        results[row, 4 + i] = w.y[i, lane]
    results[row, 0] = s.struck[1, lane] if walked else math.nan
    results[row, 1] = s.struck[2, lane] - math.pi if walked else math.nan
    results[row, 2] = s.struck[4, lane] if walked else math.nan
    results[row, 3] = s.struck[5, lane] if walked else math.nan
    results[row, DURATION] = s.t[0, lane]
    results[row, STEP_LENGTH] = s.travelled[0, lane] if walked else 0.0
    pushed = s.pushed[0, lane] if walked else 0.0
    results[row, ENERGY_IN] = sums.energy_in[0, lane] + pushed
    results[row, POSITIVE_WORK] = sums.positive_work[0, lane] + max(0.0, pushed)
    results[row, ENERGY_LOST] = sums.lost[0, lane] + (s.lost[0, lane] if walked else 0.0)
    results[row, ELECTRICAL_ENERGY] = sums.impulse[0, lane] * w.constants[NO_LOAD_SPEED, lane]
    low = sums.lowest[0, lane]
    results[row, MIN_CLEARANCE] = low if low < math.inf else math.nan
    results[row, OUTCOME] = outcome


@internal
def travel(s, y, c):
    """How far the contact point moves in the stride, m: foot to foot, and the rolling."""
    return swing_foot(y[0], y[1], y[2], c).imag + c.R * (y[0] - load(s.first_phi, 0))


@internal
def write_log(batch, t, y, phase):
    """Append a row to the log if there is room."""
    row, log = int(batch.logged[0, 0]), batch.log
    if row < batch.room:
        log[row, 0], log[row, 7] = t, phase
        for i in range(DIMENSION):
            log[row, 1 + i] = y[i]
        batch.logged[0, 0] = row + 1


@rare
def log_step(batch, s, w):
    """Log the multiples of the interval inside the step that lane 0 has just made."""
    t, h, interval = s.t[0, 0], w.length[0, 0], batch.interval
    k = math.floor(t / interval) + 1.0
    if k * interval >= t + h:
        return
    interpolate(w)
    while k * interval < t + h and batch.logged[0, 0] < batch.room:
        y = look_inside(w, (k * interval - t) / h + 0.0 * load(w.length, 0))
        write_log(batch, k * interval, first_lane(y), s.phase[0, 0])
        k += 1.0
