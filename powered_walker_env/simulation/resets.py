"""Resets: what happens to the pose where a phase ends, for eight walkers at once.

One table, of poses with or without tangents. To add a reset: its formula in `mechanics/`, a line
in `after_reset`, a member of `Reset`.
"""

from __future__ import annotations

from powered_walker_env.compiled.decorators import internal, once, rare, small
from powered_walker_env.compiled.lanes import bits, load, store, where
from powered_walker_env.model.mechanics.chain import Pose, kinetic_energy
from powered_walker_env.model.mechanics.ground import travel
from powered_walker_env.model.mechanics.heel_strike import heel_strike
from powered_walker_env.model.mechanics.locking import ankle_caught, knee_caught
from powered_walker_env.model.mechanics.push_off import (
    push_off,
    work_after,
    work_before,
    work_with,
)
from powered_walker_env.model.phases import Reset
from powered_walker_env.simulation.runge_kutta import chain_lanes, constants_lanes

CONTINUE, HEEL_STRIKE, STOP = int(Reset.CONTINUE), int(Reset.HEEL_STRIKE), int(Reset.STOP)
KNEE_STRIKE = int(Reset.KNEE_STRIKE)
BEFORE, WITH, AFTER = int(Reset.PUSH_BEFORE), int(Reset.PUSH_WITH), int(Reset.PUSH_AFTER)


@small
def pushes(reset):
    """Whether a push-off comes with the reset."""
    return (reset == BEFORE) | (reset == WITH) | (reset == AFTER)


@small
def strikes(reset):
    """Whether the reset is a heel strike, with or without a push."""
    return (reset == HEEL_STRIKE) | pushes(reset)


@internal
def either(mask, yes, no):
    """One pose where the mask holds, else the other."""
    return Pose(
        where(mask, yes.phi, no.phi),
        where(mask, yes.alpha, no.alpha),
        where(mask, yes.beta, no.beta),
        where(mask, yes.dphi, no.dphi),
        where(mask, yes.dalpha, no.dalpha),
        where(mask, yes.dbeta, no.dbeta),
        where(mask, yes.foot, no.foot),
        where(mask, yes.stance, no.stance),
        where(mask, yes.swing, no.swing),
        where(mask, yes.theta, no.theta),
        where(mask, yes.dtheta, no.dtheta),
        where(mask, yes.thigh, no.thigh),
    )


@internal
def after_reset(reset, pose, impulse, chains, c):
    """The poses after the resets; the impulse, N s, of those that push, otherwise 0.

    Args:
        chains: the walkers', as in `guards.value_of`.
    """
    after = pose
    if bits(strikes(reset)):
        after = either(strikes(reset), push_off(pose, impulse, chains[1], c), after)
    if bits(reset == STOP):
        after = either(reset == STOP, ankle_caught(pose, chains[1], c), after)
    if bits(reset == KNEE_STRIKE):
        caught = knee_caught(pose, chains[0], chains[2], c)
        after = either(reset == KNEE_STRIKE, caught, after)
    return after


@once
def apply_resets(s, w, pose):
    """Write the poses after the resets to s.struck; energy lost, the push's work, way travelled."""
    c, free, reset = constants_lanes(w.constants), chain_lanes(w.free_chain), load(s.reset, 0)
    impulse, chains = (
        load(s.impulse, 0),
        (chain_lanes(w.locked_chain), free, chain_lanes(w.bent_chain)),
    )
    struck = after_reset(reset, pose, impulse, chains, c)
    store_pose(s, struck)
    if bits(~(reset == CONTINUE)):
        work = 0.0 * impulse
        if bits(pushes(reset)):
            work = _push_work(pose, reset, impulse, struck, free, c)
        before = kinetic_energy(pose, chain_lanes(w.chain), c)
        after = kinetic_energy(struck, free, c)
        store(s.pushed, 0, work)
        store(s.lost, 0, before + work - after)
        store(s.travelled, 0, travel(pose, load(s.first_phi, 0), c))


@small
def store_pose(s, pose):
    """Write the angles and rates of the pose after the reset."""
    store(s.struck, 0, pose.phi)
    store(s.struck, 1, pose.alpha)
    store(s.struck, 2, pose.beta)
    store(s.struck, 3, pose.dphi)
    store(s.struck, 4, pose.dalpha)
    store(s.struck, 5, pose.dbeta)
    store(s.struck_thigh, 0, pose.theta)
    store(s.struck_thigh, 1, pose.dtheta)


@rare
def _push_work(pose, reset, impulse, struck, free, c):
    """Work of the push-off by when it comes, J; 0 for other resets."""
    unpushed = heel_strike(pose, free, c)
    work = where(reset == BEFORE, work_before(pose, impulse, c), 0.0)
    work = where(reset == WITH, work_with(pose, impulse, struck, c), work)
    return where(reset == AFTER, work_after(pose, impulse, unpushed, struck, c), work)
