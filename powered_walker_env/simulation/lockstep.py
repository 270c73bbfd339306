"""Eight walkers abreast: where each of them is in its stride.

The kernel takes steps with all lanes at once. A lane that ends its stride gets the next
one of the batch; one that comes upon an event takes steps onto it while the others walk
on. Tables end with the lanes; truths are 1 and 0.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from powered_walker_env.compiled.decorators import once, rare, small
from powered_walker_env.compiled.lanes import (
    SIZE,
    Table,
    bits,
    blend,
    blend_state,
    dual,
    load,
    load_state,
)
from powered_walker_env.compiled.records import Layout
from powered_walker_env.model.mechanics.actuation import Drive, flow
from powered_walker_env.model.mechanics.guards import FIRST_FALL, Aims
from powered_walker_env.model.mechanics.packing import (
    CHAIN,
    CHAIN_SIZE,
    CONSTANTS,
)
from powered_walker_env.model.phases import (
    EXITS,
    JOINTS,
    MAX_EXITS,
    TORQUE,
    Guard,
    Joints,
    Torque,
)
from powered_walker_env.simulation.poses import chained, joined, which

GUARDS = len(Guard)  # Guard.NEVER included
ANKLE_FREE, KNEE_FREE = int(Joints.ANKLE_FREE), int(Joints.KNEE_FREE)
MOTOR, HIP = int(Torque.MOTOR), int(Torque.HIP)
IDLE = -1
LOCKED_FIRST_STEP = 3.0  # the legs alone swing slowly, foot and motor do not

_Pose = Annotated[Table, SIZE]
_Thigh = Annotated[Table, 2]
_Guards = Annotated[Table, GUARDS]


class Lockstep(NamedTuple):
    """The eight walkers' places in their strides: tables of lanes, of one row if not said."""

    begun: Table  # in the first column: strides of the batch begun so far
    longer: Table  # there: have the chains that are walked now a second link
    resting: Annotated[Table, 2]  # there: at rest, before a phase without one and with one
    waited: Table  # there: steps for which lanes have waited for others to end their phases
    number: Table  # of the stride in the batch, or IDLE
    phase: Table  # number of the phase in the cycle
    phases: Table  # phases so far
    steps: Table  # steps so far
    tries: Table  # steps towards the present event
    ending: Table  # how a phase ends: its guard, or -1 - outcome
    busy: Table  # is there a stride, and its phase not over
    elapsed: Table  # has the phase taken time
    fresh: Table  # is this the phase's first step
    t: Table  # s since the stride began
    h: Table  # s, what the step control proposes
    refused: Table  # was the last step too long
    expected: Table  # 1/s⁸, the last step's error over its tolerance and its length's eighth power
    whole: Table  # s, the step in which an event was found
    fraction: Table  # of a step, at which a guard falls
    unit: Table  # s, √(L/g)
    walker: Table  # its row in the batch, plus 1; 0 for none
    switch_angle: Table  # rad
    strength: Table  # of the control: N m of a torque, N s of an impulse
    motor: Table  # share of the strength at the ankle: 1 or 0
    hip: Table  # at the hip, on the swing leg: −1 or 0
    height: Table  # m, of the ground ahead
    first_phi: Table  # rad, φ as the stride began
    target: Table  # guard of the event that is being stepped onto, or 0
    scuffed: Table  # this step's touch of the floor was no landing
    correction: Table  # s, from the end of the step to the event
    leads_to: Table  # where the phase's end leads: a phase, or −1 − outcome
    reset: Table  # the reset there
    impulse: Table  # N s, of the push-off at the end of the phase
    pushed: Table  # J, its work
    lost: Table  # J, at the end of the phase
    travelled: Table  # m, of the contact point in the stride
    final: _Pose  # pose where the phase ended: φ, α, β and their rates
    final_thigh: _Thigh  # θ and its rate
    struck: _Pose  # pose after the reset
    struck_thigh: _Thigh
    active: _Guards  # does the phase watch this guard
    watched: Table  # in the first column: guards (bits) that some lane's phase watches
    value: _Guards  # of the guards where the step begins
    rate: _Guards
    value_new: _Guards  # where it ends
    rate_new: _Guards
    suspected: _Guards  # in the first column: lanes (bits) where it may have fallen


LOCKSTEP = Layout(Lockstep)
lockstep = LOCKSTEP.view
_constants_lane, constants_lanes, chain_lanes = CONSTANTS.lane, CONSTANTS.lanes, CHAIN.lanes
_LOCK, _KNEED = CONSTANTS["lock"], CONSTANTS["kneed"]


class Batch(NamedTuple):
    """The strides to walk, and where their results go."""

    strides: int  # N
    phases: int  # of the cycle
    cycle: Table  # (phases, codes)
    states: Table  # (N, 4)
    controls: Table  # (N, 2)
    rows: Table  # (N or 1, ROW)
    row_count: int
    heights: Table  # (N or 1, 1) m
    height_count: int
    rtol: float
    together: float  # foot to foot, over L, up to which the feet stand together
    first_step: float  # of a phase, in units of √(L/g)
    results: Table  # (N, RESULTS)
    interval: float  # s between samples in the log, 0 for none
    log: Table  # (m, LOG_COLUMNS), of the first lane
    room: int  # m, 0 for no log
    logged: Table  # (1, 1) rows written to it


@small
def acting(s):
    """What drives the eight walkers."""
    strength = load(s.strength, 0)
    return Drive(load(s.motor, 0) * strength, load(s.hip, 0) * strength)


@small
def torques_act(s):
    """Whether a torque acts on the walkers."""
    return (load(s.motor, 0) > 0.0) | (load(s.hip, 0) < 0.0)


@small
def moving_drive(s, change):
    """What drives the eight walkers, where the strength of their controls changes."""
    strength = dual(load(s.strength, 0), change)
    return Drive(load(s.motor, 0) * strength, load(s.hip, 0) * strength)


@small
def moving_aims(s, change):
    """What the eight walkers' guards are set to, where the switch angles change."""
    return Aims(dual(load(s.switch_angle, 0), change), load(s.height, 0))


@rare
def flow_at(s, w, y):
    """The flow of the chains' states, where it is seldom asked for."""
    return flow(y, acting(s), chain_lanes(w.chain), constants_lanes(w.constants))


@once
def enter(s, w, mask, batch):
    """Begin phases of the cycle from the poses in s.struck: their chains, drives and guards.

    All lanes at once: numbers written one by one are slow to be read as lanes.
    """
    cycle, number = batch.cycle, load(s.phase, 0)
    for phase in range(batch.phases):
        here = mask & (number == 1.0 * phase)
        if bits(here):
            free = cycle[phase, JOINTS] == ANKLE_FREE
            blend(w.free, 0, here, 1.0 if free else 0.0)
            blend(w.bent, 0, here, 1.0 if cycle[phase, JOINTS] == KNEE_FREE else 0.0)
            blend(s.motor, 0, here, 1.0 if cycle[phase, TORQUE] == MOTOR else 0.0)
            blend(s.hip, 0, here, -1.0 if cycle[phase, TORQUE] == HIP else 0.0)
            for guard in range(GUARDS):
                blend(s.active, guard, here, 1.0 if guard >= FIRST_FALL else 0.0)
            for exit in range(MAX_EXITS):  # Guard.NEVER, of the padding, is never looked at
                blend(s.active, int(cycle[phase, EXITS + 3 * exit]), here, 1.0)
            longer = 1.0 if free else LOCKED_FIRST_STEP
            blend(s.h, 0, here, longer * batch.first_step * load(s.unit, 0))
    watched = 0
    for guard in range(1, GUARDS):
        if bits(load(s.active, guard) > 0.0):
            watched |= 1 << guard
    s.watched[0, 0] = watched
    blend(s.busy, 0, mask, 1.0)
    blend(s.phases, 0, mask, load(s.phases, 0) + 1.0)
    for row in (s.target, s.scuffed, s.correction, s.elapsed, s.refused, s.expected):
        blend(row, 0, mask, 0.0)
    blend(s.fresh, 0, mask, 1.0)
    of_phase = joined(w)
    for i in range(CHAIN_SIZE):
        locked, free, bent = load(w.locked_chain, i), load(w.free_chain, i), load(w.bent_chain, i)
        blend(w.chain, i, mask, which(of_phase, locked, free, bent))
    blend_state(w.y, 0, mask, chained(load_state(s.struck, 0), s.struck_thigh, of_phase))
