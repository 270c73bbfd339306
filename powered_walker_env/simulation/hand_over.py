"""Where phases and strides begin and end: each lane goes on by itself.

A lane whose phase has ended enters the next one of its cycle, or ends its stride, writes
its results and begins the next stride of the batch.
"""

from __future__ import annotations

import math

import numpy as np

from powered_walker_env.compiled.decorators import internal, once, rare
from powered_walker_env.compiled.lanes import LANES, SIZE, blend, blend_state, load_state, mask_of
from powered_walker_env.model.mechanics.guards import FIRST_FALL, KNEE_STRIKE, fall_outcome
from powered_walker_env.model.phases import EXITS, MAX_EXITS, Outcome
from powered_walker_env.simulation.directions import begin, write_derivatives
from powered_walker_env.simulation.events import over_at_once
from powered_walker_env.simulation.lockstep import IDLE, enter, flow_at
from powered_walker_env.simulation.poses import pose_here
from powered_walker_env.simulation.record import write_log, write_row
from powered_walker_env.simulation.resets import AFTER, BEFORE, CONTINUE, WITH, apply_resets
from powered_walker_env.simulation.runge_kutta import constants_lanes
from powered_walker_env.simulation.sensitivity import enter_phases, leave_phases
from powered_walker_env.simulation.totals import begin_sums, clear, end_clearance
from powered_walker_env.simulation.waiting import called, rests, row_of, settle, start, wake
from powered_walker_env.simulation.watching import along, watch_here

WALKED, NOT_FINITE = int(Outcome.WALKED), int(Outcome.NOT_FINITE)
STEP_LIMIT, KNEE_FOLDED = int(Outcome.STEP_LIMIT), int(Outcome.KNEE_FOLDED)
MAX_PHASES = 16  # of one stride


@once
def _idle(s, lane):
    """Nothing is left to do for this lane."""
    s.number[0, lane] = IDLE
    s.busy[0, lane] = 0.0
    s.target[0, lane] = 0.0


@internal
def _goes_on(s, w, sums, lane, long, batch):
    """Take up the last of the strides that rest before phases of a kind; was there one?"""
    index = called(s, long, batch)
    if index >= 0:
        settle(s, w, lane, index, batch)
        wake(s, sums, lane, index, batch)
    return index >= 0


@once
def _begins(s, w, sums, lane, batch, d):
    """Begin the next stride that can; is there one?"""
    states = batch.states
    for index in range(int(s.begun[0, 0]), batch.strides):
        s.begun[0, 0] = index + 1
        new = settle(s, w, lane, index, batch)
        start(s, w, lane, batch)
        begin(d, s, lane, row_of(index, batch.row_count), new)
        if math.isfinite(states[index, 0] + states[index, 1] + states[index, 2] + states[index, 3]):
            return True
        clear(sums, lane)
        for i in range(SIZE):
            s.final[i, lane] = s.struck[i, lane]
        s.final_thigh[0, lane], s.final_thigh[1, lane] = s.final[2, lane], s.final[5, lane]
        _finish(s, w, sums, lane, np.int64(NOT_FINITE), batch, d)
    return False


@once
def _next_stride(s, w, sums, lane, batch, d):
    """Give a free lane a stride, the first choice one that suits the others; did it get one?"""
    walked = int(s.longer[0, 0])
    if _goes_on(s, w, sums, lane, walked, batch) or _begins(s, w, sums, lane, batch, d):
        return True
    if _goes_on(s, w, sums, lane, 1 - walked, batch):
        return True
    _idle(s, lane)
    return False


@rare
def fill(s, w, sums, lanes, batch, d):
    """Give the free lanes (bits) a stride each; those that got one."""
    begun = np.int64(0)
    for lane in range(LANES):
        if lanes >> lane & 1 and _next_stride(s, w, sums, lane, batch, d):
            begun |= 1 << lane
    return begun


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
def end_phases(s, w, sums, ended, batch, d):
    """Pass lanes (bits) on to the next phase or stride; those that begin one."""
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
        if rests(s, sums, lane, to, batch, d):
            free |= 1 << lane
        else:
            continued |= 1 << lane
    return fill(s, w, sums, free, batch, d) | continued


@once
def _note_ends(s, pose, mask):
    """Write the poses where phases end."""
    numbers = (pose.phi, pose.alpha, pose.beta, pose.dphi, pose.dalpha, pose.dbeta)
    blend_state(s.final, 0, mask, numbers)
    blend(s.final_thigh, 0, mask, pose.theta)
    blend(s.final_thigh, 1, mask, pose.dtheta)
