"""The stride kernel: run a cycle of phases from heel strike to heel strike.

Closed: no exception, no print, every loop bounded. It takes the encoded list of
`phases.py` and numbers, and leaves one row of results and an outcome.
"""

from __future__ import annotations

import math

import numpy as np

from powered_walker_env.compilation import kernel, threaded_kernel
from powered_walker_env.events import FALL, find_event, guard_at, step_onto
from powered_walker_env.integrator import (
    DIMENSION,
    STAGES,
    error_norm,
    start,
    step,
    step_factor,
    workspace,
)
from powered_walker_env.phases import MAX_EXITS, Guard, Joints, Outcome, Reset, Torque
from powered_walker_env.physics.constants import unpack
from powered_walker_env.physics.ground import name_fall, swing_foot
from powered_walker_env.physics.heel_strike import heel_strike
from powered_walker_env.physics.swing import kinetic_energy
from powered_walker_env.record import (
    DURATION,
    ENERGY_IN,
    ENERGY_LOST,
    FINAL,
    LOG_COLUMNS,
    MIN_CLEARANCE,
    STATE,
    STEP_LENGTH,
    energy_at,
    log_step,
    track_clearance,
    track_work,
    write_log,
)
from powered_walker_env.sensitivity import (
    Directions,
    begin,
    pass_event,
    pass_heel_strike,
    propagate,
)

LOCKED, NONE = int(Joints.ANKLE_LOCKED), int(Torque.NONE)
SWITCH_ANGLE, HEEL_STRIKE = int(Guard.SWITCH_ANGLE), int(Reset.HEEL_STRIKE)
WALKED, NO_LANDING = int(Outcome.WALKED), int(Outcome.NO_LANDING)
NOT_FINITE, STEP_LIMIT = int(Outcome.NOT_FINITE), int(Outcome.STEP_LIMIT)

# All times in units of √(L/g).
TIME_LIMIT = 20.0  # no landing by then is a fall; the nearly simplest walker takes 3.9
LONGEST_STEP = 0.5  # so that no guard can turn twice inside a step
SHORTEST_STEP = 1e-12
MAX_STEPS = 20_000
MAX_PHASES = 16
TOLERANCE_SHARE = 0.1  # of rtol for one step: the stride map multiplies errors by about 10


@kernel
def _already_over(guards, joints, w, switch_angle, step_height, c, ends):
    """Set the guards at the start of a phase; index of one that has already happened, or −1.

    A hip already past the switch and closing starts the motor at once; a walker that is
    already down has fallen. A landing must be a fall through the floor.
    """
    over = -1
    for k in range(len(guards)):
        value, rate = guard_at(guards[k], joints, w.y, switch_angle, step_height, c)
        ends[k, 2], ends[k, 3] = value, rate
        closing = guards[k] == FALL or (guards[k] == SWITCH_ANGLE and rate < 0.0)
        if closing and not value > 0.0:
            over = k
    return over


@kernel
def _run_phase(
    code, phase, t, w, control, row, c, step_height, rtol, interval, log, result, directions
):
    """Integrate one phase from w.y to its end, w.y ending on the event.

    Returns where it leads (encoded), the reset and the guard of its exit, and the time.
    """
    joints, torque = code[0], code[1]
    guards = (code[2], code[5], FALL)
    ends = np.empty((MAX_EXITS + 1, 4))
    unit = math.sqrt(c.L / abs(c.g))
    over = _already_over(guards, joints, w, control[0], step_height, c, ends)
    tolerance = TOLERANCE_SHARE * rtol
    h = tolerance**0.125 * unit  # about a step's length for this tolerance
    start(joints, torque, w, control[1], c)
    fresh = True
    for _ in range(MAX_STEPS):
        if over >= 0:
            break
        if t >= TIME_LIMIT * unit:
            return -1 - NO_LANDING, 0, 0, t
        h = min(h, LONGEST_STEP * unit, TIME_LIMIT * unit - t + SHORTEST_STEP * unit)
        step(joints, torque, w, h, control[1], c)
        error = error_norm(w, h, tolerance, 1.0 / unit)
        if not error <= 1.0:
            h *= step_factor(error) if error < math.inf else 0.1
            if h < SHORTEST_STEP * unit:
                return -1 - (STEP_LIMIT if error < math.inf else NOT_FINITE), 0, 0, t
            continue
        for k in range(len(guards)):
            ends[k, 0], ends[k, 1] = ends[k, 2], ends[k, 3]
            ends[k, 2], ends[k, 3] = guard_at(
                guards[k], joints, w.y_new, control[0], step_height, c
            )
        over, fraction = find_event(joints, torque, w, h, guards, ends, control, step_height, c)
        length, correction = h, 0.0
        if over >= 0:
            length, correction = step_onto(
                guards[over], joints, torque, w, h, fraction * h, control, step_height, c
            )
        if interval > 0.0:
            log_step(joints, torque, t, length, interval, phase, w, control[1], c, log, result)
        if directions is not None:
            propagate(joints, torque, w, length, correction, fresh, control, row, c, directions)
        taken, fresh = length + correction, False
        track_clearance(joints, torque, w, length, step_height, control[1], c, result)
        if torque != NONE:
            track_work(torque, w, taken, control[1], c, result)
        t += taken
        h *= step_factor(error)
        for i in range(DIMENSION):
            w.y[i] = w.y_new[i]
            w.slopes[0, i] = w.slopes[STAGES, i]
    if over < 0:
        return -1 - STEP_LIMIT, 0, 0, t
    if guards[over] == FALL:
        return -1 - name_fall(joints, w.y, c), 0, 0, t
    return code[4 + 3 * over], code[3 + 3 * over], guards[over], t


@kernel
def _begin(state, c, w, result):
    """Set the post-strike state, feet locked, and an empty row of results."""
    w.y[0], w.y[1], w.y[2] = state[0] - c.lock, state[0], state[1] + math.pi
    w.y[3], w.y[4], w.y[5] = state[2], state[2], state[3]
    result[:] = 0.0
    result[STATE] = math.nan
    result[MIN_CLEARANCE] = math.inf
    for value in state:
        if not math.isfinite(value):
            return False
    return True


@kernel
def _strike(w, c, result):
    """Apply the heel strike to w.y; write the post-strike state and the energy lost."""
    y = w.y
    before = kinetic_energy(y[0], y[1], y[2], y[3], y[4], y[5], c)
    y[0], y[1], y[2], y[3], y[4], y[5] = heel_strike(y[0], y[1], y[2], y[3], y[4], y[5], c)
    result[ENERGY_LOST] = before - kinetic_energy(y[0], y[1], y[2], y[3], y[4], y[5], c)
    result[0], result[1], result[2], result[3] = y[1], y[2] - math.pi, y[4], y[5]


@kernel
def run_stride(cycle, state, control, row, step_height, rtol, interval, log, result, directions):
    """One stride of the walker packed in `row`; fills `result`, returns the outcome.

    Args:
        cycle: the encoded phases.
        state: (4,) post-strike state; control: (switch angle, stall torque).
        step_height: m, of the ground ahead over the ground under the stance foot.
        rtol: tolerance of the post-strike state.
        interval: s between samples in `log`, 0 for none; events are logged in any case.
        log: (m, LOG_COLUMNS), m may be 0; result: (RESULTS,).
        directions: to differentiate the stride by, or None; numba leaves the derivatives
            out of the machine code of strides without them.
    """
    c = unpack(row)
    w = workspace()
    if not _begin(state, c, w, result):
        return NOT_FINITE
    if directions is not None:
        begin(directions)
    first_phi, before_strike = w.y[0], np.empty(DIMENSION)
    t, phase, outcome = 0.0, 0, STEP_LIMIT
    write_log(t, w.y, phase, log, result)
    for _ in range(MAX_PHASES):
        powered = cycle[phase][1] != NONE
        acting = (cycle[phase][0], cycle[phase][1])
        before, began = energy_at(w.y, c) if powered else 0.0, t
        to, reset, guard, t = _run_phase(
            cycle[phase], phase, t, w, control, row, c, step_height, rtol, interval, log, result,
            directions,
        )  # fmt: skip
        if powered:
            result[ENERGY_IN] += energy_at(w.y, c) - before
        write_log(t, w.y, phase, log, result)
        if reset == HEEL_STRIKE:
            result[FINAL] = w.y
            result[STEP_LENGTH] = swing_foot(w.y[0], w.y[1], w.y[2], c).imag + c.R * (
                w.y[0] - first_phi
            )
            before_strike[:] = w.y
            _strike(w, c, result)
            if directions is not None:
                pass_heel_strike(
                    guard, acting, first_phi, before_strike, w.y, control, row, c, directions
                )
        elif to >= 0 and directions is not None:
            following = (cycle[to][0], cycle[to][1])
            pass_event(guard, t > began, (acting, following), w.y, control, row, c, directions)
        if to < 0:
            outcome = -1 - to
            break
        phase = to
        write_log(t, w.y, phase, log, result)
    result[DURATION] = t
    if outcome != WALKED:
        result[STATE] = math.nan
        result[FINAL] = w.y
    elif not math.isfinite(result[0] + result[1] + result[2] + result[3]):
        outcome = NOT_FINITE
    if result[MIN_CLEARANCE] == math.inf:
        result[MIN_CLEARANCE] = math.nan
    return outcome


@threaded_kernel
def run_strides(cycle, states, controls, rows, heights, rtol, results, outcomes):
    """N strides one after another; `rows` and `heights` have N rows or one for all."""
    no_log = np.empty((0, LOG_COLUMNS))
    for i in range(states.shape[0]):
        row = rows[i if rows.shape[0] > 1 else 0]
        height = heights[i if heights.shape[0] > 1 else 0]
        control = (controls[i, 0], controls[i, 1])
        outcomes[i] = run_stride(
            cycle, states[i], control, row, height, rtol, 0.0, no_log, results[i], None
        )


@threaded_kernel
def differentiate_strides(
    cycle, states, controls, rows, rtol, changes, results, outcomes, derivatives
):
    """N strides on flat ground with their derivatives along the same n directions.

    Args:
        changes: (n, 18) of the state (4), the control (2) and the packed walker (12).
        derivatives: (N, n, OUTPUTS) of the post-strike state, duration, step length.
    """
    n = changes.shape[0]
    no_log = np.empty((0, LOG_COLUMNS))
    S, slopes = np.empty((n, DIMENSION)), np.empty((n, STAGES + 1, DIMENSION))
    by_state, by_control, by_params = changes[:, :4], changes[:, 4:6], changes[:, 6:]
    for i in range(states.shape[0]):
        row = rows[i if rows.shape[0] > 1 else 0]
        control = (controls[i, 0], controls[i, 1])
        derivatives[i] = math.nan
        directions = Directions(by_state, by_control, by_params, S, slopes, derivatives[i])
        outcomes[i] = run_stride(
            cycle, states[i], control, row, 0.0, rtol, 0.0, no_log, results[i], directions
        )
