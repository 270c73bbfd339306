"""Where phases and strides begin and end: each lane goes on by itself.

A lane whose phase has ended enters the next one of its cycle, or ends its stride, writes
its results and begins the next stride of the batch.
"""

from __future__ import annotations

import math

import numpy as np

from powered_walker_env.compiled.decorators import internal
from powered_walker_env.compiled.lanes import LANES, load, mask_of
from powered_walker_env.model.mechanics.actuation import flow
from powered_walker_env.model.mechanics.constants import lane_of, lanes_of, unpack
from powered_walker_env.model.mechanics.ground import name_fall
from powered_walker_env.model.phases import MAX_EXITS, Outcome
from powered_walker_env.simulation.events import over_at_once, watch
from powered_walker_env.simulation.lockstep import FALL, blend, enter, place, rest, row_of
from powered_walker_env.simulation.record import clear, look, write_log, write_row
from powered_walker_env.simulation.resets import (
    CONTINUE,
    PUSH_AFTER,
    PUSH_BEFORE,
    STOP_RESET,
    impact,
)
from powered_walker_env.simulation.runge_kutta import DIMENSION, acting, load_state, state_of
from powered_walker_env.simulation.sensitivity import (
    begin,
    enter_phases,
    leave_phases,
    stop_phases,
    strike,
    write_derivatives,
)

WALKED, NOT_FINITE = int(Outcome.WALKED), int(Outcome.NOT_FINITE)
STEP_LIMIT = int(Outcome.STEP_LIMIT)
MAX_PHASES = 16  # of one stride


@internal
def next_stride(s, w, sums, lane, queue, batch, d):
    """Place the next stride that can begin in a free lane; the strides begun so far."""
    states = batch.states
    for index in range(queue, batch.strides):
        c = unpack(batch.rows, row_of(index, batch.row_count))
        place(s, w, lane, index, batch, c)
        clear(sums, lane)
        enter(s, w, lane, np.int64(0), batch)  # a literal would be another type
        if d is not None:
            begin(d, lane)
        if math.isfinite(states[index, 0] + states[index, 1] + states[index, 2] + states[index, 3]):
            return index + 1
        _finish(s, w, sums, lane, np.int64(NOT_FINITE), batch, d)
    rest(s, lane)
    return batch.strides


@internal
def begin_phases(s, w, sums, begun):
    """Slopes, guards and sums where phases begin (bits); those that are over at once."""
    mask, y, c, drive = mask_of(begun), load_state(w.y, 0), lanes_of(w.constants), acting(w)
    locked = load(w.locked, 0) > 0.0
    slope = flow(locked, y, drive, c)
    for i in range(DIMENSION):
        blend(w.slopes, i, mask, slope[i])
    watch(s, locked, y, drive, c, mask, s.value, s.rate)
    look(sums, mask, y, drive, c)
    return over_at_once(s) & begun


@internal
def _way_out(s, w, lane, batch):
    """Where a phase that has ended leads: a phase, or −1 − outcome; notes the reset."""
    ending, phase, cycle = int(s.ending[0, lane]), int(s.phase[0, lane]), batch.cycle
    s.reset[0, lane], s.impulse[0, lane] = 0.0, 0.0
    if ending < 0:
        return ending
    if ending == FALL:
        c = lane_of(w.constants, lane)
        return -1 - name_fall(w.locked[0, lane] > 0.0, state_of(w.y, lane), c)
    for exit in range(MAX_EXITS):
        if cycle[phase, 2 + 3 * exit] == ending:
            to, reset = int(cycle[phase, 4 + 3 * exit]), int(cycle[phase, 3 + 3 * exit])
            s.reset[0, lane] = reset
            if PUSH_BEFORE <= reset <= PUSH_AFTER:
                s.impulse[0, lane] = s.strength[0, lane]
            return to if s.phases[0, lane] < MAX_PHASES or to < 0 else -1 - STEP_LIMIT
    return -1 - STEP_LIMIT  # not reached: only guards of the phase end it


@internal
def _finish(s, w, sums, lane, outcome, batch, d):
    """Write the results of a stride that is over."""
    index = int(s.number[0, lane])
    if outcome == WALKED and not math.isfinite(s.struck[4, lane] + s.struck[5, lane]):
        outcome = NOT_FINITE
    write_row(batch.results, index, s, w, sums, lane, outcome)
    if d is not None:
        write_derivatives(d, index, lane, outcome == WALKED)


@internal
def end_phases(s, w, sums, ended, queue, batch, d):
    """Pass lanes (bits) on to the next phase or stride.

    Returns those that begin one, and how many strides have been begun.
    """
    stopped, impacts = 0, False
    for lane in range(LANES):
        if ended >> lane & 1:
            s.leads_to[0, lane] = _way_out(s, w, lane, batch)
            impacts |= s.reset[0, lane] != CONTINUE
            stopped |= (1 << lane) if s.reset[0, lane] == STOP_RESET else 0
    if ended & 1:
        write_log(batch, s.t[0, 0], state_of(w.y, 0), s.phase[0, 0])
    if d is not None:
        leave_phases(d, s, w, mask_of(ended))
    if impacts:
        impact(s, w)
    if d is not None:
        if impacts:
            strike(d, s, w, mask_of(ended))
        if stopped:
            stop_phases(d, s, w, mask_of(stopped))
    begun, continued = 0, 0
    for lane in range(LANES):
        if not ended >> lane & 1:
            continue
        to = int(s.leads_to[0, lane])
        if to < 0:
            _finish(s, w, sums, lane, -1 - to, batch, d)
            queue = next_stride(s, w, sums, lane, queue, batch, d)
            begun |= (1 << lane) if s.number[0, lane] >= 0 else 0
            continue
        if stopped >> lane & 1:
            sums.lost[0, lane] += s.lost[0, lane]
            for i in range(DIMENSION):
                w.y[i, lane] = s.struck[i, lane]
        enter(s, w, lane, to, batch)
        continued |= 1 << lane
    if continued & 1:
        write_log(batch, s.t[0, 0], state_of(w.y, 0), s.phase[0, 0])
    if d is not None and continued:
        enter_phases(d, s, w, mask_of(continued))
    return begun | continued, queue
