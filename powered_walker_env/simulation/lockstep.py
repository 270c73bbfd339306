"""Eight walkers abreast: where each of them is in its stride.

The kernel takes steps with all lanes at once. A lane that ends its stride gets the next
one of the batch; one that comes upon an event takes steps onto it while the others walk
on. Arrays end with the lanes; truths are 1 and 0.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from powered_walker_env.compiled.decorators import internal
from powered_walker_env.compiled.lanes import Table, load, rows_from, store, where
from powered_walker_env.model.mechanics.actuation import drive
from powered_walker_env.model.mechanics.constants import lane_of, write_lane
from powered_walker_env.model.phases import MAX_EXITS, Guard, Joints, Torque

FALL = len(Guard)  # the guard against falls, watched in every phase beside its own
GUARDS = FALL + 1
LOCKED, NONE, MOTOR = int(Joints.ANKLE_LOCKED), int(Torque.NONE), int(Torque.MOTOR)
IDLE = -1
LOCKED_FIRST_STEP = 3.0  # the legs alone swing slowly, foot and motor do not


class Lockstep(NamedTuple):
    """The eight walkers' places in their strides: tables of lanes, of one row if not said."""

    number: Table  # of the stride in the batch, or IDLE
    phase: Table  # number of the phase in the cycle
    phases: Table  # phases so far
    steps: Table  # steps so far
    tries: Table  # steps towards the present event
    ending: Table  # how a phase ends: its guard, or -1 - outcome
    busy: Table  # is there a stride
    elapsed: Table  # has the phase taken time
    fresh: Table  # is this the phase's first step
    t: Table  # s since the stride began
    h: Table  # s, what the step control proposes
    refused: Table  # was the last step too long
    whole: Table  # s, the step in which an event was found
    unit: Table  # s, √(L/g)
    gravity: Table  # m/s²
    switch_angle: Table  # rad
    strength: Table  # of the control: N m of a torque, N s of an impulse
    height: Table  # m, of the ground ahead
    first_phi: Table  # rad, φ as the stride began
    target: Table  # guard of the event that is being stepped onto, or 0
    scuffed: Table  # this step's touch of the floor was no landing
    correction: Table  # s, from the end of the step to the event
    powered: Table  # does a torque act
    motor: Table  # does the ankle's motor draw current
    leads_to: Table  # where the phase's end leads: a phase, or −1 − outcome
    reset: Table  # the reset there
    impulse: Table  # N s, of the push-off at the end of the phase
    pushed: Table  # J, its work
    lost: Table  # J, at the end of the phase
    travelled: Table  # m, of the contact point in the stride
    struck: Table  # 6 rows, state after a heel strike
    active: Table  # GUARDS rows, does the phase watch this guard
    value: Table  # GUARDS rows, of the guards where the step begins
    rate: Table  # GUARDS rows
    value_new: Table  # GUARDS rows, where it ends
    rate_new: Table  # GUARDS rows


_SINGLE = 30
LOCKSTEP_ROWS = _SINGLE + 6 + 5 * GUARDS


@internal
def lockstep(rows):
    """Eight idle lanes, in the first LOCKSTEP_ROWS of a table of lanes."""
    more = _SINGLE + 6
    return Lockstep(
        rows, rows_from(rows, 1), rows_from(rows, 2), rows_from(rows, 3), rows_from(rows, 4),
        rows_from(rows, 5), rows_from(rows, 6), rows_from(rows, 7), rows_from(rows, 8),
        rows_from(rows, 9), rows_from(rows, 10), rows_from(rows, 11), rows_from(rows, 12),
        rows_from(rows, 13), rows_from(rows, 14), rows_from(rows, 15), rows_from(rows, 16),
        rows_from(rows, 17), rows_from(rows, 18), rows_from(rows, 19), rows_from(rows, 20),
        rows_from(rows, 21), rows_from(rows, 22), rows_from(rows, 23), rows_from(rows, 24),
        rows_from(rows, 25), rows_from(rows, 26), rows_from(rows, 27), rows_from(rows, 28),
        rows_from(rows, 29),
        rows_from(rows, _SINGLE), rows_from(rows, more), rows_from(rows, more + GUARDS),
        rows_from(rows, more + 2 * GUARDS), rows_from(rows, more + 3 * GUARDS),
        rows_from(rows, more + 4 * GUARDS),
    )  # fmt: skip


class Batch(NamedTuple):
    """The strides to walk, and where their results go."""

    strides: int  # N
    cycle: Table  # (phases, codes)
    states: Table  # (N, 4)
    controls: Table  # (N, 2)
    rows: Table  # (N or 1, PACKED)
    row_count: int
    heights: Table  # (N or 1, 1) m
    height_count: int
    rtol: float
    first_step: float  # of a phase, in units of √(L/g)
    results: Table  # (N, RESULTS)
    interval: float  # s between samples in the log, 0 for none
    log: Table  # (m, LOG_COLUMNS), of the first lane
    room: int  # m, 0 for no log
    logged: Table  # (1, 1) rows written to it


@internal
def row_of(index, count):
    """Row of a stride in an array with one row for each or one for all."""
    return index if count > 1 else 0


@internal
def blend(array, row, mask, value):
    """Write `value` into the row where the mask holds."""
    store(array, row, where(mask, value, load(array, row)))


@internal
def place(s, w, lane, index, batch, c):
    """Start a stride: the state just after heel strike, both feet locked."""
    write_lane(c, w.constants, lane)
    states, gravity = batch.states, abs(c.g)
    w.y[0, lane], w.y[1, lane] = states[index, 0] - c.lock, states[index, 0]
    w.y[2, lane], w.y[3, lane] = states[index, 1] + math.pi, states[index, 2]
    w.y[4, lane], w.y[5, lane] = states[index, 2], states[index, 3]
    s.number[0, lane], s.phases[0, lane], s.steps[0, lane] = index, 0, 0
    s.busy[0, lane] = 1.0
    s.t[0, lane] = 0.0
    s.unit[0, lane], s.gravity[0, lane] = math.sqrt(c.L / gravity), gravity
    s.switch_angle[0, lane] = batch.controls[index, 0]
    s.strength[0, lane] = batch.controls[index, 1]
    s.height[0, lane] = batch.heights[row_of(index, batch.height_count), 0]
    s.first_phi[0, lane] = w.y[0, lane]


@internal
def rest(s, lane):
    """Nothing is left to do for this lane."""
    s.number[0, lane] = IDLE
    s.busy[0, lane] = 0.0
    s.target[0, lane] = 0.0


@internal
def enter(s, w, lane, phase, batch):
    """Begin a phase of the cycle: joints, drive and guards; y is where it begins."""
    cycle, torque = batch.cycle, int(batch.cycle[phase, 1])
    w.locked[0, lane] = 1.0 if cycle[phase, 0] == LOCKED else 0.0
    acting = drive(torque, s.strength[0, lane], lane_of(w.constants, lane))
    w.drive[0, lane], w.drive[1, lane], w.drive[2, lane] = acting[0], acting[1], acting[2]
    w.drive[3, lane], w.drive[4, lane] = acting[3], acting[4]
    s.powered[0, lane] = 1.0 if torque != NONE else 0.0
    s.motor[0, lane] = 1.0 if torque == MOTOR else 0.0
    for guard in range(GUARDS):
        s.active[guard, lane] = 1.0 if guard == FALL else 0.0
    for exit in range(MAX_EXITS):
        s.active[int(cycle[phase, 2 + 3 * exit]), lane] = 1.0
    s.active[0, lane] = 0.0  # Guard.NEVER, of the padding
    s.phase[0, lane] = phase
    s.phases[0, lane] += 1
    longer = LOCKED_FIRST_STEP if w.locked[0, lane] > 0.0 else 1.0
    s.h[0, lane] = longer * batch.first_step * s.unit[0, lane]
    s.target[0, lane], s.scuffed[0, lane], s.correction[0, lane] = 0.0, 0.0, 0.0
    s.elapsed[0, lane], s.fresh[0, lane], s.refused[0, lane] = 0.0, 1.0, 0.0
