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

from powered_walker_env.compiled.decorators import internal, once, rare
from powered_walker_env.compiled.lanes import (
    SIZE,
    bits,
    blend,
    blend_state,
    dual,
    load,
    load_state,
    plus,
    store_state,
    tangents_of,
    unit,
    where,
)
from powered_walker_env.model.mechanics.actuation import ankle_torque
from powered_walker_env.model.mechanics.chain import couplings, hip_bend, mass_matrix
from powered_walker_env.model.mechanics.ground import travel
from powered_walker_env.model.mechanics.guards import FIRST_FALL, value_of
from powered_walker_env.model.mechanics.packing import (
    CHAIN_SIZE,
)
from powered_walker_env.model.mechanics.tangents import acceleration_tangents, couplings_tangent
from powered_walker_env.simulation.directions import LOCK, STRENGTH, SWITCH, change_of, direction_of
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

_FIRST, _STAGE, _WEIGHT = ADVANCES


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
                t = plus(t, h, weighted(_FIRST, _STAGE, _WEIGHT, stage - 1, e.flows, t))
            dchain, dc = chain_lanes(e.chain), constants_lanes(e.constants)
            drive = moving_drive(s, change_of(d, k, s, STRENGTH))
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
    aimed = moving_aims(s, change_of(d, k, s, SWITCH))
    drive = moving_drive(s, change_of(d, k, s, STRENGTH))
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
            load(e.constants, LOCK),
        )
        dt = _event_shift(d, k, s, w, target, rates, moving(here, S, links, lock), c)
        blend(e.shift, 0, mask, dt)
        pose = moving(here, plus(S, dt, before), links, lock)
        strength = dual(load(s.strength, 0), change_of(d, k, s, STRENGTH))
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
