"""Derivatives of a stride, carried along with it.

The variational equations S' = (∂f/∂y) S + ∂f/∂p are stepped through the stages of every
accepted step, so that S is the derivative of the very walk that is taken. At an event
the saltation matrix corrects for the event's time moving: with the guard g and the flow
f⁻ before and f⁺ after, dt = −(∇g·S + ∂g/∂p)/ġ and S⁺ = S + (f⁻ − f⁺) dt (Leine and
Nijmeijer, Dynamics and Bifurcations of Non-Smooth Mechanical Systems, 2004, chapter 7);
a reset R gives ∂R/∂y (S + f⁻ dt) + ∂R/∂p.

Guards and resets are not differentiated by hand: their formulas are called with numbers that
carry tangents (`compiled/lanes`). The flow is (`mechanics/tangents.py`), for speed.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from powered_walker_env.compiled.decorators import internal, once, rare, small
from powered_walker_env.compiled.lanes import (
    SIZE,
    Table,
    bits,
    blend,
    blend_state,
    dual,
    load,
    load_state,
    plus,
    rows_from,
    store_state,
    tangents_of,
    unit,
    where,
)
from powered_walker_env.compiled.records import Layout
from powered_walker_env.model.mechanics.actuation import ankle_torque
from powered_walker_env.model.mechanics.chain import couplings, hip_bend, mass_matrix
from powered_walker_env.model.mechanics.constants import (
    BENT_CHAIN,
    CHAIN_SIZE,
    CONSTANTS,
    CONSTANTS_SIZE,
    FREE_CHAIN,
    LOCKED_CHAIN,
    OWN,
)
from powered_walker_env.model.mechanics.ground import travel
from powered_walker_env.model.mechanics.guards import FIRST_FALL, value_of
from powered_walker_env.model.mechanics.tangents import acceleration_tangents, couplings_tangent
from powered_walker_env.simulation.lockstep import flow_at, moving_aims, moving_drive
from powered_walker_env.simulation.poses import chained, held, joined, moving, pose_here, which
from powered_walker_env.simulation.resets import after_reset, pushes, strikes
from powered_walker_env.simulation.runge_kutta import (
    ADVANCES,
    STAGES,
    chain_duals,
    chain_lanes,
    constants_duals,
    constants_lanes,
    weighted,
)
from powered_walker_env.simulation.watching import along, guard_along

OUTPUTS = 6  # what a stride is differentiated of: α, s, α', β' after it, duration, step length
CHANGES = 6  # of what besides the walker: post-strike state (4), switch angle, strength
_SWITCH, _STRENGTH = 4, 5
_FIRST, _STAGE, _WEIGHT = ADVANCES
_LOCK = CONSTANTS["lock"]


class Direction(NamedTuple):
    """One direction to differentiate along: the derivatives of eight strides under way."""

    S: Annotated[Table, SIZE]  # of the chain's state, now
    flows: Annotated[Table, (STAGES + 1) * SIZE]  # of S at the stages
    shift: Table  # s, how far the last event moves
    start: Table  # rad, of φ as the stride began
    struck: Annotated[Table, SIZE]  # of the pose after the reset
    struck_thigh: Annotated[Table, 2]
    length: Table  # m, of the way travelled
    constants: Annotated[Table, CONSTANTS_SIZE]  # of the walkers
    locked_chain: Annotated[Table, CHAIN_SIZE]
    free_chain: Annotated[Table, CHAIN_SIZE]
    bent_chain: Annotated[Table, CHAIN_SIZE]
    chain: Annotated[Table, CHAIN_SIZE]


DIRECTION = Layout(Direction)
DIRECTION_SIZE = DIRECTION.size
direction_in = DIRECTION.view


class Directions(NamedTuple):
    """What to differentiate by, and where the derivatives go."""

    n: int  # directions, 0 for none
    rows: Table  # of lanes: n times DIRECTION.size
    changes: Table  # (n, CHANGES)
    walkers: Table  # (rows·n, ROW) of the walkers' rows, n for each walker
    derivatives: Table  # (N·n, OUTPUTS)


@small
def direction_of(d, k):
    """The k-th direction."""
    return direction_in(rows_from(d.rows, k * DIRECTION_SIZE))


@once
def begin(d, s, lane, row, new):
    """The change of the pose at the start of a stride: both feet locked, φ = α − lock.

    Args:
        row: of the walker in the batch; new: whether the lane had another before.
    """
    for k in range(d.n):
        e, changes = direction_of(d, k), d.changes
        if new:
            _copy_walker(d, e, lane, row * d.n + k)
        phi = changes[k, 0] - e.constants[_LOCK, lane]
        e.start[0, lane], e.shift[0, lane] = phi, 0.0
        e.struck[0, lane], e.struck[1, lane], e.struck[2, lane] = phi, changes[k, 0], changes[k, 1]
        e.struck[3, lane], e.struck[4, lane] = changes[k, 2], changes[k, 2]
        e.struck[5, lane] = changes[k, 3]
        e.struck_thigh[0, lane], e.struck_thigh[1, lane] = changes[k, 1], changes[k, 3]


@once
def _copy_walker(d, e, lane, row):
    """Write the changes of a walker's constants and chains into a lane."""
    for i in range(CONSTANTS_SIZE):
        e.constants[i, lane] = d.walkers[row, OWN + i]
    for i in range(CHAIN_SIZE):
        e.locked_chain[i, lane] = d.walkers[row, LOCKED_CHAIN + i]
        e.free_chain[i, lane] = d.walkers[row, FREE_CHAIN + i]
        e.bent_chain[i, lane] = d.walkers[row, BENT_CHAIN + i]


@once
def write_derivatives(d, index, lane, walked):
    """The derivatives of the stride that one lane has ended; NaN after a fall."""
    for k in range(d.n):
        e, row = direction_of(d, k), index * d.n + k
        for j in range(OUTPUTS):
            d.derivatives[row, j] = math.nan
        if walked:
            d.derivatives[row, 0], d.derivatives[row, 1] = e.struck[1, lane], e.struck[2, lane]
            d.derivatives[row, 2], d.derivatives[row, 3] = e.struck[4, lane], e.struck[5, lane]
            d.derivatives[row, 4], d.derivatives[row, 5] = e.shift[0, lane], e.length[0, lane]


@small
def _change(d, k, s, column):
    """A change of the control, in all lanes."""
    return d.changes[k, column] + 0.0 * load(s.t, 0)


@once
def _torque_changes(y, t, drive, chain, c, dchain, moving):
    """Changes of the torques at the ankle and the hip; `moving`: the constants with theirs."""
    u2 = dual(chain.ankle * (y[4] - y[3]), chain.ankle * (t[4] - t[3]))
    bend = hip_bend(y[0], y[1], y[2], chain)
    turned = chain.hip1 * t[0] + chain.hip2 * t[1] + chain.hip3 * t[2] + dchain.hip0
    hip = drive.pull - moving.hip_stiffness * dual(bend, turned)
    return ankle_torque(u2, drive, moving).tangent, hip.tangent


@rare
def propagate(d, s, w, mask):
    """Carry S over the steps just taken, where the mask holds, and on to the events."""
    h, correction, fresh = load(w.length, 0), load(s.correction, 0), load(s.fresh, 0) > 0.0
    chain, c = chain_lanes(w.chain), constants_lanes(w.constants)
    for stage in range(STAGES + 1):
        y, moved = load_state(w.stages, SIZE * stage), load_state(w.flows, SIZE * stage)
        z1, z2, z3 = unit(y[0]), unit(y[1]), unit(y[2])
        at = couplings(z1, z2, z3, chain, c)
        m = mass_matrix(at, chain, c)
        for k in range(d.n):
            e = direction_of(d, k)
            t = load_state(e.S, 0)
            if stage > 0:
                t = plus(t, h, weighted(_FIRST, _STAGE, _WEIGHT, stage - 1, e.flows))
            dchain, dc = chain_lanes(e.chain), constants_lanes(e.constants)
            drive = moving_drive(s, _change(d, k, s, _STRENGTH))
            moving = constants_duals(c, e.constants)
            tau, hip = _torque_changes(y, t, drive, chain, c, dchain, moving)
            dat = couplings_tangent(z1, z2, z3, at, t, chain, c, dchain, dc)
            t1, t2, t3 = acceleration_tangents(
                at, dat, m, y, moved, t, tau, hip, chain, c, dchain, dc
            )
            out = (t[3], t[4], t[5], t1, t2, t3)
            if stage == 0:
                blend_state(e.flows, 0, mask & fresh, out)
            else:
                store_state(e.flows, SIZE * stage, out)
            if stage == STAGES:
                blend_state(e.S, 0, mask, plus(t, correction, out))
                blend_state(e.flows, 0, mask, out)


@internal
def _moving_chains(w, e):
    """The walkers' chains with their changes."""
    return (
        chain_duals(chain_lanes(w.locked_chain), e.locked_chain),
        chain_duals(chain_lanes(w.free_chain), e.free_chain),
        chain_duals(chain_lanes(w.bent_chain), e.bent_chain),
    )


@internal
def _event_shift(d, k, s, w, target, rates, pose, c):
    """How far the event moves, s: −(∇g·S + ∂g/∂p)/ġ, from the moving pose of one direction.

    An event that is there as its phase begins moves with the event before it, and at the
    start of a stride not at all.
    """
    e = direction_of(d, k)
    dt = where(load(s.elapsed, 0) > 0.0, 0.0, load(e.shift, 0))
    aimed = moving_aims(s, _change(d, k, s, _SWITCH))
    drive = moving_drive(s, _change(d, k, s, _STRENGTH))
    chains = _moving_chains(w, e)
    for guard in range(1, FIRST_FALL):
        if bits(target == guard):
            change = value_of(guard, held(w), pose, drive, aimed, chains, c).tangent
            dt = where(target == guard, -change / rates, dt)
    return dt


@once
def _rates(s, w, pose, target):
    """Rates of the guards that have ended the phases, ġ."""
    rates = 0.0 * target + 1.0
    for guard in range(1, FIRST_FALL):
        if bits(target == guard):
            rates = where(target == guard, guard_along(s, w, guard, pose).tangent, rates)
    return rates


@rare
def leave_phases(d, s, w, mask):
    """Move S to the events and through the resets: the pose after them."""
    here, y, links = pose_here(w), load_state(w.y, 0), joined(w)
    plain, reset = constants_lanes(w.constants), load(s.reset, 0)
    before = flow_at(s, w, y)
    target = where(mask & (load(s.elapsed, 0) > 0.0), load(s.target, 0), 0.0)
    rates = _rates(s, w, along(w, here, before), target)
    for k in range(d.n):
        e = direction_of(d, k)
        c, S, lock = (
            constants_duals(plain, e.constants),
            load_state(e.S, 0),
            load(e.constants, _LOCK),
        )
        dt = _event_shift(d, k, s, w, target, rates, moving(here, S, links, lock), c)
        blend(e.shift, 0, mask, dt)
        pose = moving(here, plus(S, dt, before), links, lock)
        strength = dual(load(s.strength, 0), _change(d, k, s, _STRENGTH))
        impulse = where(pushes(reset), strength, 0.0 * strength)
        struck = after_reset(reset, pose, impulse, _moving_chains(w, e), c)
        numbers = (
            struck.phi, struck.alpha, struck.beta, struck.dphi, struck.dalpha, struck.dbeta
        )  # fmt: skip
        blend_state(e.struck, 0, mask, tangents_of(numbers))
        blend(e.struck_thigh, 0, mask, struck.theta.tangent)
        blend(e.struck_thigh, 1, mask, struck.dtheta.tangent)
        if bits(strikes(reset)):
            began = dual(load(s.first_phi, 0), load(e.start, 0))
            blend(e.length, 0, mask & strikes(reset), travel(pose, began, c).tangent)


@rare
def enter_phases(d, s, w, mask, after):
    """S where phases begin: of the chain's state, less the other half of the saltation, f⁺ dt."""
    links = joined(w)
    for k in range(d.n):
        e = direction_of(d, k)
        for i in range(CHAIN_SIZE):
            locked, free = load(e.locked_chain, i), load(e.free_chain, i)
            blend(e.chain, i, mask, which(links, locked, free, load(e.bent_chain, i)))
        state = chained(load_state(e.struck, 0), e.struck_thigh, links)
        blend_state(e.S, 0, mask, plus(state, -load(e.shift, 0), after))
