"""Where phases and strides begin and end: each lane goes on by itself.

A lane whose phase has ended enters the next one of its cycle, or ends its stride, writes
its results and begins the next stride of the batch.
"""

from __future__ import annotations

import math

import numpy as np

from powered_walker_env.compiled.decorators import once, rare
from powered_walker_env.compiled.lanes import LANES, SIZE, blend, blend_state, load_state, mask_of
from powered_walker_env.model.mechanics.guards import FIRST_FALL, KNEE_STRIKE, fall_outcome
from powered_walker_env.model.phases import EXITS, MAX_EXITS, Outcome
from powered_walker_env.simulation.directions import begin, write_derivatives
from powered_walker_env.simulation.events import over_at_once
from powered_walker_env.simulation.lockstep import IDLE, enter, flow_at, place, row_of
from powered_walker_env.simulation.poses import pose_here
from powered_walker_env.simulation.record import write_log, write_row
from powered_walker_env.simulation.resets import AFTER, BEFORE, CONTINUE, WITH, apply_resets
from powered_walker_env.simulation.runge_kutta import constants_lanes
from powered_walker_env.simulation.sensitivity import enter_phases, leave_phases
from powered_walker_env.simulation.totals import begin_sums, clear, end_clearance
from powered_walker_env.simulation.watching import along, watch_here

WALKED, NOT_FINITE = int(Outcome.WALKED), int(Outcome.NOT_FINITE)
STEP_LIMIT, KNEE_FOLDED = int(Outcome.STEP_LIMIT), int(Outcome.KNEE_FOLDED)
MAX_PHASES = 16  # of one stride


@once
def _rest(s, lane):
    """Nothing is left to do for this lane."""
    s.number[0, lane] = IDLE
    s.busy[0, lane] = 0.0
    s.target[0, lane] = 0.0


@once
def next_stride(s, w, sums, lane, queue, batch, d):
    """Place the next stride that can begin in a free lane; the strides begun so far."""
    states = batch.states
    for index in range(queue, batch.strides):
        new = place(s, w, lane, index, batch)
        begin(d, s, lane, row_of(index, batch.row_count), new)
        if math.isfinite(states[index, 0] + states[index, 1] + states[index, 2] + states[index, 3]):
            return index + 1
        clear(sums, lane)
        for i in range(SIZE):
            s.final[i, lane] = s.struck[i, lane]
        s.final_thigh[0, lane], s.final_thigh[1, lane] = s.final[2, lane], s.final[5, lane]
        _finish(s, w, sums, lane, np.int64(NOT_FINITE), batch, d)
    _rest(s, lane)
    return batch.strides


@rare
def fill(s, w, sums, lanes, queue, batch, d):
    """Give the free lanes (bits) a stride each; those that got one, and the strides begun."""
    begun = np.int64(0)
    for lane in range(LANES):
        if lanes >> lane & 1:
            queue = next_stride(s, w, sums, lane, queue, batch, d)
            begun |= (1 << lane) if s.number[0, lane] >= 0 else 0
    return begun, queue


@rare
def begin_phases(s, w, sums, begun, batch, d):
    """Enter phases (bits): flow, guards and sums where they begin; those that are over at once."""
    mask = mask_of(begun)
    enter(s, w, mask, batch)
    moved = flow_at(s, w, load_state(w.y, 0))
    blend_state(w.flows, 0, mask, moved)
    pose = pose_here(w)
    going = along(w, pose, moved)
    watch_here(s, w, 1, FIRST_FALL, going, mask, s.value, s.rate)
    begin_sums(s, w, sums, mask, pose)
    if d.n > 0:
        enter_phases(d, s, w, mask, moved)
    if begun & 1:
        write_log(batch, s.t[0, 0], pose, s.phase[0, 0])
    return over_at_once(s, w, batch, going) & begun


@once
def _way_out(s, lane, batch):
    """Where a phase that has ended leads: a phase, or −1 − outcome; notes the reset."""
    ending, phase, cycle = int(s.ending[0, lane]), int(s.phase[0, lane]), batch.cycle
    s.reset[0, lane], s.impulse[0, lane] = 0.0, 0.0
    if ending < 0:
        return ending
    if ending >= FIRST_FALL:
        stance = math.sin(s.final[1, lane])
        return -1 - fall_outcome(ending, stance, math.sin(s.final[0, lane]))
    if ending == KNEE_STRIKE and math.cos(s.final[2, lane] - s.final_thigh[0, lane]) < 0.0:
        return -1 - KNEE_FOLDED
    for exit in range(MAX_EXITS):
        column = EXITS + 3 * exit
        if cycle[phase, column] == ending:
            to, reset = int(cycle[phase, column + 2]), int(cycle[phase, column + 1])
            s.reset[0, lane] = reset
            if reset in (BEFORE, WITH, AFTER):
                s.impulse[0, lane] = s.strength[0, lane]
            return to if s.phases[0, lane] < MAX_PHASES or to < 0 else -1 - STEP_LIMIT
    return -1 - STEP_LIMIT  # not reached: only guards of the phase end it


@rare
def _finish(s, w, sums, lane, outcome, batch, d):
    """Write the results of a stride that is over."""
    index = int(s.number[0, lane])
    walked = write_row(batch.results, index, s, w, sums, lane, outcome)
    write_derivatives(d, index, lane, walked)


@rare
def end_phases(s, w, sums, ended, queue, batch, d):
    """Pass lanes (bits) on to the next phase or stride.

    Returns those that begin one, and how many strides have been begun.
    """
    mask, pose = mask_of(ended), pose_here(w)
    _note_ends(s, pose, mask)
    end_clearance(sums, s, mask, pose, constants_lanes(w.constants))
    for lane in range(LANES):
        if ended >> lane & 1:
            s.leads_to[0, lane] = _way_out(s, lane, batch)
    if ended & 1:
        write_log(batch, s.t[0, 0], pose, s.phase[0, 0])
    apply_resets(s, w, pose)
    if d.n > 0:
        leave_phases(d, s, w, mask)
    free, continued = np.int64(0), np.int64(0)
    for lane in range(LANES):
        if not ended >> lane & 1:
            continue
        to = int(s.leads_to[0, lane])
        if to < 0:
            _finish(s, w, sums, lane, -1 - to, batch, d)
            free |= 1 << lane
            continue
        if s.reset[0, lane] != CONTINUE:
            sums.lost[0, lane] += s.lost[0, lane]
        s.phase[0, lane] = to
        continued |= 1 << lane
    begun, queue = fill(s, w, sums, free, queue, batch, d)
    return begun | continued, queue


@once
def _note_ends(s, pose, mask):
    """Write the poses where phases end."""
    numbers = (pose.phi, pose.alpha, pose.beta, pose.dphi, pose.dalpha, pose.dbeta)
    blend_state(s.final, 0, mask, numbers)
    blend(s.final_thigh, 0, mask, pose.theta)
    blend(s.final_thigh, 1, mask, pose.dtheta)
