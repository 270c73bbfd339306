"""What is noted down along a stride: its results, its log, clearance and work."""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from powered_walker_env.compiled.decorators import internal, once, rare, small
from powered_walker_env.compiled.lanes import (
    SIZE,
    Table,
    at_lane_0,
    bits,
    blend,
    load,
    where,
)
from powered_walker_env.compiled.records import Layout
from powered_walker_env.model.mechanics.actuation import ankle_torque, power
from powered_walker_env.model.mechanics.chain import energy
from powered_walker_env.model.mechanics.constants import CONSTANTS
from powered_walker_env.model.mechanics.ground import apart, clearance
from powered_walker_env.model.phases import Outcome
from powered_walker_env.simulation.interpolant import interpolate, look_inside
from powered_walker_env.simulation.lockstep import acting, flow_at, moving, posed, torques_act
from powered_walker_env.simulation.runge_kutta import (
    chain_lanes,
    constants_duals,
    constants_lanes,
)


class Result(NamedTuple):
    """A row of results."""

    state: Annotated[float, 4]  # post-strike (α, s, α', β'); NaN unless the walker walked
    final: Annotated[float, SIZE]  # pose at the end, before any heel strike
    duration: float  # s
    step_length: float  # m
    energy_in: float  # J
    positive_work: float  # J
    energy_lost: float  # J
    min_clearance: float  # m
    electrical_energy: float  # J
    outcome: float


class Sample(NamedTuple):
    """A row of the log."""

    t: float  # s
    pose: Annotated[float, SIZE]
    phase: float  # its number in the cycle


RESULT, SAMPLE = Layout(Result), Layout(Sample)
RESULTS, LOG_COLUMNS = RESULT.size, SAMPLE.size
STATE, FINAL = RESULT.slice("state"), RESULT.slice("final")
DURATION, STEP_LENGTH = RESULT["duration"], RESULT["step_length"]
ENERGY_IN, POSITIVE_WORK = RESULT["energy_in"], RESULT["positive_work"]
ENERGY_LOST, MIN_CLEARANCE = RESULT["energy_lost"], RESULT["min_clearance"]
ELECTRICAL_ENERGY, OUTCOME = RESULT["electrical_energy"], RESULT["outcome"]
LOG_POSE, LOG_PHASE = SAMPLE.slice("pose"), SAMPLE["phase"]
_STATE, _FINAL, _POSE = STATE.start, FINAL.start, LOG_POSE.start
_NO_LOAD_SPEED = CONSTANTS["no_load_speed"]

WALKED, NOT_FINITE = int(Outcome.WALKED), int(Outcome.NOT_FINITE)
ALREADY_LANDED = int(Outcome.ALREADY_LANDED)
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


TOTALS = Layout(Totals)
totals = TOTALS.view


@once
def clear(sums, lane):
    """Nothing has been added up for this lane's stride."""
    sums.energy_in[0, lane], sums.positive_work[0, lane] = 0.0, 0.0
    sums.impulse[0, lane], sums.lost[0, lane] = 0.0, 0.0
    sums.lowest[0, lane] = math.inf


@internal
def begin_sums(s, w, sums, mask, pose):
    """Look at the poses where phases begin; where strides begin nothing has been added up."""
    starting = mask & (load(s.phases, 0) == 1.0)
    for row in (sums.energy_in, sums.positive_work, sums.impulse, sums.lost):
        blend(row, 0, starting, 0.0)
    blend(sums.lowest, 0, starting, math.inf)
    look(
        sums, mask, torques_act(s), pose, acting(s),
        chain_lanes(w.free_chain), constants_lanes(w.constants),
    )  # fmt: skip


@internal
def look(sums, mask, powered, pose, drive, free_chain, c):
    """Take clearance, and where torques act energy and power, as those where the step begins."""
    height, descent = clearance(pose, c)
    blend(sums.height, 0, mask, height)
    blend(sums.descent, 0, mask, descent)
    if bits(powered & mask):
        blend(sums.energy, 0, mask, energy(pose, free_chain, c))
        blend(sums.power, 0, mask, power(pose, drive, c))
        blend(sums.torque, 0, mask, ankle_torque(pose.dalpha - pose.dphi, drive, c))


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
    gain = where(value_end > value, value_end - value, 0.0)
    dips, peaks = (slope < 0.0) & (slope_end > 0.0), (slope > 0.0) & (slope_end < 0.0)
    if bits(dips | peaks):
        _, bottom = cubic_minimum(value, slope, value_end, slope_end)
        _, top = cubic_minimum(-value, -slope, -value_end, -slope_end)
        bottom = where(bottom < value_end, bottom, value_end)
        top = where(top < -value, -top, value)
        gain = where(dips, value_end - bottom, where(peaks, top - value, gain))
    return gain


@once
def add_step(sums, s, w, mask, taken, pose, pose_new, free_chain, c):
    """Add the work of the step just taken, and where the swing foot was lowest in it.

    Args:
        taken: s, the length of the step, its correction included.
        pose, pose_new: where it begins and ends.
    """
    height, descent = load(sums.height, 0), load(sums.descent, 0)
    before, rising, torque = load(sums.energy, 0), load(sums.power, 0), load(sums.torque, 0)
    drive, powered = acting(s), mask & torques_act(s)
    look(sums, mask, powered, pose_new, drive, free_chain, c)
    if bits(powered):
        after = load(sums.energy, 0)
        gain = _gain(before, rising * taken, after, load(sums.power, 0) * taken)
        given = _torque_impulse(pose, pose_new, drive, torque, load(sums.torque, 0), taken, c)
        blend(sums.energy_in, 0, powered, load(sums.energy_in, 0) + (after - before))
        blend(sums.positive_work, 0, powered, load(sums.positive_work, 0) + gain)
        blend(sums.impulse, 0, powered, load(sums.impulse, 0) + given)
    ahead = mask & (apart(pose_new) > 0.0)
    if bits(ahead & (descent < 0.0) & (load(sums.descent, 0) > 0.0)):
        _dip(sums, s, w, ahead, taken, pose, pose_new, height, descent)


@rare
def _dip(sums, s, w, ahead, taken, pose, pose_new, height, descent):
    """The lowest clearance where it turns inside the step, after the legs have passed."""
    end, descent_end = load(sums.height, 0), load(sums.descent, 0)
    x, _ = cubic_minimum(height, descent * taken, end, descent_end * taken)
    between, between_end = apart(pose), apart(pose_new)
    passed = where(between > 0.0, 0.0, between / (between - between_end))
    dips = ahead & (x > passed) & (x < 1.0)
    if bits(dips):
        _lower(sums, s, dips, _lowest_inside(s, w, x, passed))


@internal
def _lower(sums, s, mask, height):
    """Take a height of the swing foot as the lowest, over its own ground, if it is lower."""
    low, lowest = height - load(s.height, 0), load(sums.lowest, 0)
    blend(sums.lowest, 0, mask & (low < lowest), low)


@once
def end_clearance(sums, s, mask, pose, c):
    """Where a phase ends with the legs passed, the swing foot may be lowest, too."""
    height, _ = clearance(pose, c)
    _lower(sums, s, mask & (apart(pose) > 0.0), height)


@once
def _torque_impulse(pose, pose_new, drive, torque, torque_end, taken, c):
    """∫τ dt of the motor over the step, N m s: its line exactly, its limit as the mean."""
    bent = (pose_new.alpha - pose_new.phi) - (pose.alpha - pose.phi)
    line = drive.stall * (taken + c.droop * bent)
    bounded = (abs(torque) >= c.torque_limit) | (abs(torque_end) >= c.torque_limit)
    return where(bounded, 0.5 * (torque + torque_end) * taken, line)


@small
def pose_inside(w, fraction):
    """The pose at fractions of the steps (0 to 1); needs `interpolate`."""
    y, c = look_inside(w, fraction), constants_lanes(w.constants)
    return posed(y, load(w.free, 0) > 0.0, c)


@rare
def _lowest_inside(s, w, x, earliest):
    """The lowest clearance near fraction x of the step: Newton on the interpolant."""
    c, free = constants_lanes(w.constants), load(w.free, 0) > 0.0
    interpolate(s, w)
    h = load(w.length, 0)
    for _ in range(NEWTON_STEPS):
        y = look_inside(w, x)
        moved, still = flow_at(s, w, y), constants_duals(c, w.zeros)
        _, descent = clearance(moving(posed(y, free, c), moved, free, 0.0 * x), still)
        bend = h * descent.tangent
        x = where(bend > 0.0, x - descent.value / bend, x)
        x = where(x > earliest, x, earliest)
        x = where(x < 1.0, x, 1.0)
    height, _ = clearance(pose_inside(w, x), c)
    return height


@once
def write_row(results, row, s, w, sums, lane, outcome):
    """The results of the stride that one lane has ended; did it walk, and is all finite?"""
    walked = outcome == WALKED
    if walked and not s.t[0, lane] > 0.0:  # a stride takes time
        outcome, walked = ALREADY_LANDED, False
    pushed = s.pushed[0, lane] if walked else 0.0
    lost = s.lost[0, lane] if walked else 0.0
    low = sums.lowest[0, lane]
    results[row, DURATION] = s.t[0, lane]
    results[row, STEP_LENGTH] = s.travelled[0, lane] if walked else 0.0
    results[row, ENERGY_IN] = sums.energy_in[0, lane] + pushed
    results[row, POSITIVE_WORK] = sums.positive_work[0, lane] + max(0.0, pushed)
    results[row, ENERGY_LOST] = sums.lost[0, lane] + lost
    results[row, ELECTRICAL_ENERGY] = sums.impulse[0, lane] * w.constants[_NO_LOAD_SPEED, lane]
    results[row, MIN_CLEARANCE] = low if low < math.inf else math.nan
    total = s.struck[1, lane] + s.struck[2, lane] + s.struck[4, lane] + s.struck[5, lane]
    for column in range(DURATION, MIN_CLEARANCE):
        total += results[row, column]
    if walked and not math.isfinite(total + results[row, ELECTRICAL_ENERGY]):
        outcome, walked = NOT_FINITE, False
    for i in range(SIZE):
        results[row, _FINAL + i] = s.final[i, lane]
    results[row, _STATE] = s.struck[1, lane] if walked else math.nan
    results[row, _STATE + 1] = s.struck[2, lane] - math.pi if walked else math.nan
    results[row, _STATE + 2] = s.struck[4, lane] if walked else math.nan
    results[row, _STATE + 3] = s.struck[5, lane] if walked else math.nan
    results[row, OUTCOME] = outcome
    return walked


@internal
def write_log(batch, t, pose, phase):
    """Append a row to the log, of the first lane, if there is room."""
    row, log = int(batch.logged[0, 0]), batch.log
    if row < batch.room:
        log[row, 0], log[row, LOG_PHASE] = t, phase
        log[row, _POSE] = at_lane_0(pose.phi)
        log[row, _POSE + 1] = at_lane_0(pose.alpha)
        log[row, _POSE + 2] = at_lane_0(pose.beta)
        log[row, _POSE + 3] = at_lane_0(pose.dphi)
        log[row, _POSE + 4] = at_lane_0(pose.dalpha)
        log[row, _POSE + 5] = at_lane_0(pose.dbeta)
        batch.logged[0, 0] = row + 1


@rare
def log_step(batch, s, w):
    """Log the multiples of the interval inside the step that lane 0 has just made."""
    t, h, interval = s.t[0, 0], w.length[0, 0], batch.interval
    k = math.floor(t / interval) + 1.0
    if k * interval >= t + h:
        return
    interpolate(s, w)
    while k * interval < t + h and batch.logged[0, 0] < batch.room:
        pose = pose_inside(w, (k * interval - t) / h + 0.0 * load(w.length, 0))
        write_log(batch, k * interval, pose, s.phase[0, 0])
        k += 1.0
