"""What is noted down along a stride: its results, its log, clearance and work."""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from powered_walker_env.compiled.decorators import internal, once, rare
from powered_walker_env.compiled.lanes import (
    SIZE,
    at_lane_0,
    load,
)
from powered_walker_env.compiled.records import Layout
from powered_walker_env.model.mechanics.packing import CONSTANTS
from powered_walker_env.model.phases import Outcome
from powered_walker_env.simulation.interpolant import interpolate, pose_inside


class Result(NamedTuple):
    """A row of results."""

    state: Annotated[float, 4]  # post-strike (α, s, α', β'); NaN unless the walker walked
    final: Annotated[float, SIZE]  # pose at the end, before any heel strike: φ, α, β and rates
    final_thigh: Annotated[float, 2]  # θ and its rate there
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
    pose: Annotated[float, SIZE]  # φ, α, β and their rates
    thigh: Annotated[float, 2]  # θ and its rate
    phase: float  # its number in the cycle


RESULT, SAMPLE = Layout(Result), Layout(Sample)
RESULTS, LOG_COLUMNS = RESULT.size, SAMPLE.size
STATE, FINAL = RESULT.slice("state"), RESULT.slice("final")
FINAL_THIGH = RESULT.slice("final_thigh")
DURATION, STEP_LENGTH = RESULT["duration"], RESULT["step_length"]
ENERGY_IN, POSITIVE_WORK = RESULT["energy_in"], RESULT["positive_work"]
ENERGY_LOST, MIN_CLEARANCE = RESULT["energy_lost"], RESULT["min_clearance"]
ELECTRICAL_ENERGY, OUTCOME = RESULT["electrical_energy"], RESULT["outcome"]
LOG_POSE, LOG_PHASE = SAMPLE.slice("pose"), SAMPLE["phase"]
LOG_THIGH = SAMPLE.slice("thigh")
_STATE, _FINAL, _POSE = STATE.start, FINAL.start, LOG_POSE.start
_FINAL_THIGH, _THIGH = FINAL_THIGH.start, LOG_THIGH.start
_NO_LOAD_SPEED = CONSTANTS["no_load_speed"]

WALKED, NOT_FINITE = int(Outcome.WALKED), int(Outcome.NOT_FINITE)
ALREADY_LANDED = int(Outcome.ALREADY_LANDED)


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
    for i in range(2):
        results[row, _FINAL_THIGH + i] = s.final_thigh[i, lane]
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
        log[row, _THIGH] = at_lane_0(pose.theta)
        log[row, _THIGH + 1] = at_lane_0(pose.dtheta)
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
