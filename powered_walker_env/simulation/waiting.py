"""Which stride a lane walks, and when: lanes wait for each other, strides wait for a lane.

Two costs are shared by all lanes. To end and begin phases takes a step's time or more, for one lane
as for all: so lanes whose phases are over stand still until others join them. And a step of two
links takes 0.6 of the time of one of three, which all lanes take if one of them needs it: so a
stride that comes to a phase with another number of links rests, in its own row of the results,
while strides wait for what is walked now.

The order changes nothing but the time: each stride is the same walk, bit for bit, whenever and
beside whomever it walks.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from powered_walker_env.compiled.decorators import internal, once, small
from powered_walker_env.compiled.lanes import LANES, SIZE, bits, blend, count, load, mask_of
from powered_walker_env.compiled.records import Layout
from powered_walker_env.model.mechanics.packing import (
    BENT_CHAIN,
    CHAIN_SIZE,
    CONSTANTS,
    CONSTANTS_SIZE,
    FREE_CHAIN,
    LOCKED_CHAIN,
    OWN,
)
from powered_walker_env.model.phases import BENT, JOINTS, Joints

#: Steps of single lanes, all together, for which those whose phases are over wait for others. What
#: begins together comes to its end together.
PATIENCE = 2 * LANES
LOCKED = int(Joints.ANKLE_LOCKED)
_constants_lane, _LOCK, _KNEED = CONSTANTS.lane, CONSTANTS["lock"], CONSTANTS["kneed"]


class Resting(NamedTuple):
    """What a stride takes from phase to phase; of the lane's other numbers none outlives one."""

    struck: Annotated[float, SIZE]  # the pose, as in `Lockstep`
    struck_thigh: Annotated[float, 2]
    kept: Annotated[float, 9]  # `_kept`, in order
    under: float  # the stride that rests under it, plus 1; 0 for none


RESTING = Layout(Resting)
_STRUCK, _THIGH = RESTING["struck"], RESTING["struck_thigh"]
_KEPT, _UNDER = RESTING["kept"], RESTING["under"]


@once
def waited_enough(s, ended):
    """Whether the lanes (bits) whose phases are over go on now; until then they stand still."""
    blend(s.busy, 0, mask_of(ended), 0.0)
    s.waited[0, 0] += count(ended)
    enough = s.waited[0, 0] > PATIENCE or not bits(load(s.busy, 0) > 0.0)
    if enough:
        s.waited[0, 0] = 0.0
    return enough


@small
def row_of(index, rows):
    """Row of a stride in an array with one row for each or one for all."""
    return index if rows > 1 else 0


@once
def _copy_walker(s, w, lane, rows, row):
    """Write a walker's constants and chains into a lane."""
    for i in range(CONSTANTS_SIZE):
        w.constants[i, lane] = rows[row, OWN + i]
    for i in range(CHAIN_SIZE):
        w.locked_chain[i, lane] = rows[row, LOCKED_CHAIN + i]
        w.free_chain[i, lane] = rows[row, FREE_CHAIN + i]
        w.bent_chain[i, lane] = rows[row, BENT_CHAIN + i]
    c = _constants_lane(w.constants, lane)
    s.unit[0, lane] = math.sqrt(c.L / abs(c.g))
    s.walker[0, lane] = row + 1


@internal
def settle(s, w, lane, index, batch):
    """Give a lane to a stride of the batch: its walker, control and ground. Is the walker new?"""
    row = row_of(index, batch.row_count)
    new = s.walker[0, lane] != row + 1
    if new:
        _copy_walker(s, w, lane, batch.rows, row)
    s.number[0, lane], s.busy[0, lane] = index, 1.0
    s.switch_angle[0, lane] = batch.controls[index, 0]
    s.strength[0, lane] = batch.controls[index, 1]
    s.height[0, lane] = batch.heights[row_of(index, batch.height_count), 0]
    s.first_phi[0, lane] = batch.states[index, 0] - w.constants[_LOCK, lane]
    return new


@once
def start(s, w, lane, batch):
    """Begin the stride of a lane just after heel strike: feet locked, knees straight."""
    index, states = int(s.number[0, lane]), batch.states
    s.struck[0, lane] = s.first_phi[0, lane]
    s.struck[1, lane], s.struck[2, lane] = states[index, 0], states[index, 1] + math.pi
    s.struck[3, lane], s.struck[4, lane] = states[index, 2], states[index, 2]
    s.struck[5, lane] = states[index, 3]
    s.struck_thigh[0, lane], s.struck_thigh[1, lane] = s.struck[2, lane], s.struck[5, lane]
    s.phases[0, lane], s.steps[0, lane], s.t[0, lane] = 0, 0, 0.0
    s.phase[0, lane] = batch.cycle[0, BENT] if w.constants[_KNEED, lane] > 0.0 else 0.0
    s.longer[0, 0] = _longer(batch, int(s.phase[0, lane]))


@small
def _longer(batch, phase):
    """Does the chain of a phase have a second link? 1 or 0."""
    return 0 if batch.cycle[phase, JOINTS] == LOCKED else 1


@small
def _kept(s, sums):
    return (
        s.phase, s.phases, s.steps, s.t,
        sums.energy_in, sums.positive_work, sums.impulse, sums.lost, sums.lowest,
    )  # fmt: skip


@once
def rests(s, sums, lane, phase, batch, d):
    """Lay the stride that comes to a phase aside, if others wait for what is walked now; is it?

    Tangents of states have no room in the results, and a log is of the first lane.
    """
    longer, walked = _longer(batch, phase), int(s.longer[0, 0])
    if longer == walked:
        return False
    others = s.resting[walked, 0] > 0.0 or s.begun[0, 0] < batch.strides
    if not others or d.n > 0 or batch.room > 0:
        s.longer[0, 0] = longer
        return False
    index, results = int(s.number[0, lane]), batch.results
    for i in range(SIZE):
        results[index, _STRUCK + i] = s.struck[i, lane]
    for i in range(2):
        results[index, _THIGH + i] = s.struck_thigh[i, lane]
    column = _KEPT
    for row in _kept(s, sums):
        results[index, column] = row[0, lane]
        column += 1
    results[index, _UNDER] = s.resting[longer, 0]
    s.resting[longer, 0] = index + 1
    return True


@once
def called(s, longer, batch):
    """The last stride laid aside before a phase with a second link, or without; −1 for none."""
    index = int(s.resting[longer, 0]) - 1
    if index >= 0:
        s.resting[longer, 0] = batch.results[index, _UNDER]
        s.longer[0, 0] = longer
    return index


@once
def wake(s, sums, lane, index, batch):
    """Write what a resting stride took with it into its new lane."""
    results = batch.results
    for i in range(SIZE):
        s.struck[i, lane] = results[index, _STRUCK + i]
    for i in range(2):
        s.struck_thigh[i, lane] = results[index, _THIGH + i]
    column = _KEPT
    for row in _kept(s, sums):
        row[0, lane] = results[index, column]
        column += 1
