"""Strides that wait for a lane: those not begun, and those that rest between two phases.

A step of two links takes 0.6 of the time of one of three, which all lanes take if one of them needs
it. So a stride whose next phase has another number of links rests while strides wait for what is
walked now. It rests in its own row of the results, on top of others. The order changes nothing but
the time: each stride is the same walk, bit for bit, whenever and beside whomever it walks.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from powered_walker_env.compiled.decorators import once, small
from powered_walker_env.compiled.lanes import SIZE
from powered_walker_env.compiled.records import Layout
from powered_walker_env.model.phases import JOINTS, Joints

LOCKED = int(Joints.ANKLE_LOCKED)


class Resting(NamedTuple):
    """What a stride takes from phase to phase; of the lane's other numbers none outlives one."""

    struck: Annotated[float, SIZE]  # the pose, as in `Lockstep`
    struck_thigh: Annotated[float, 2]
    kept: Annotated[float, 9]  # `_kept`, in order
    under: float  # the stride that rests under it, plus 1; 0 for none


RESTING = Layout(Resting)
_STRUCK, _THIGH = RESTING["struck"], RESTING["struck_thigh"]
_KEPT, _UNDER = RESTING["kept"], RESTING["under"]


@small
def _kept(s, sums):
    return (
        s.phase, s.phases, s.steps, s.t,
        sums.energy_in, sums.positive_work, sums.impulse, sums.lost, sums.lowest,
    )  # fmt: skip


@small
def longer(batch, phase):
    """Does the chain of a phase have a second link? 1 or 0."""
    return 0 if batch.cycle[phase, JOINTS] == LOCKED else 1


@once
def rests(s, sums, lane, phase, batch, d):
    """Lay the stride that comes to a phase aside, if others wait for what is walked now; is it?"""
    long, walked = longer(batch, phase), int(s.longer[0, 0])
    if long == walked:
        return False
    waiting = s.resting[walked, 0] > 0.0 or s.begun[0, 0] < batch.strides
    if not waiting or d.n > 0 or batch.room > 0:
        s.longer[0, 0] = long
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
    results[index, _UNDER] = s.resting[long, 0]
    s.resting[long, 0] = index + 1
    return True


@once
def called(s, long, batch):
    """The stride on top of those that rest before phases with or without a second link, or −1."""
    index = int(s.resting[long, 0]) - 1
    if index >= 0:
        s.resting[long, 0] = batch.results[index, _UNDER]
        s.longer[0, 0] = long
    return index


@once
def wake(s, sums, lane, index, batch):
    """Write what a resting stride had with it into its new lane."""
    results = batch.results
    for i in range(SIZE):
        s.struck[i, lane] = results[index, _STRUCK + i]
    for i in range(2):
        s.struck_thigh[i, lane] = results[index, _THIGH + i]
    column = _KEPT
    for row in _kept(s, sums):
        row[0, lane] = results[index, column]
        column += 1
