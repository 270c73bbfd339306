"""Poses of eight walkers from the states of their chains, and back; with tangents, too.

A chain has a second link or not: the stance leg with the ankle free, the thigh of the swing leg
with the knee free.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from powered_walker_env.compiled.decorators import internal, small
from powered_walker_env.compiled.lanes import bits, dual, load, load_state, unit, where
from powered_walker_env.model.mechanics.chain import Pose, bent, pose_of
from powered_walker_env.model.mechanics.ground import Held
from powered_walker_env.simulation.runge_kutta import constants_lanes


class Joined(NamedTuple):
    """What the second link of the eight walkers' chains is; if neither, it does not exist."""

    free: Any  # the stance leg: the ankle is free
    bent: Any  # the thigh of the swing leg: the knee is free


@small
def joined(w):
    """Of the phases that the eight walkers are in."""
    return Joined(load(w.free, 0) > 0.0, load(w.bent, 0) > 0.0)


@small
def held(w):
    """Which joints of the eight walkers are locked."""
    return Held(load(w.free, 0) == 0.0, load(w.bent, 0) == 0.0)


@internal
def posed(y, joined, c):
    """The pose of a chain's state; with the ankle locked α = φ + lock."""
    free, bent_knee = joined.free, joined.bent
    alpha, dalpha = where(free, y[1], y[0] + c.lock), where(free, y[4], y[3])
    pose = pose_of(y[0], alpha, y[2], y[3], dalpha, y[5])
    if bits(bent_knee):
        theta, dtheta = where(bent_knee, y[1], y[2]), where(bent_knee, y[4], y[5])
        pose = bent(pose, theta, dtheta, where(bent_knee, unit(theta), pose.swing))
    return pose


@small
def pose_here(w):
    """The pose where the steps begin."""
    c = constants_lanes(w.constants)
    return posed(load_state(w.y, 0), joined(w), c)


@small
def _turned(unit, angle):
    """The change of a unit vector that turns by a small angle: i·unit·angle."""
    return complex(-unit.imag * angle, unit.real * angle)


@internal
def moving(pose, t, joined, lock):
    """The pose with its tangents: t is the change of the chain's state, `lock` that of the lock."""
    alpha, dalpha = where(joined.free, t[1], t[0] + lock), where(joined.free, t[4], t[3])
    theta, dtheta = where(joined.bent, t[1], t[2]), where(joined.bent, t[4], t[5])
    return Pose(
        dual(pose.phi, t[0]),
        dual(pose.alpha, alpha),
        dual(pose.beta, t[2]),
        dual(pose.dphi, t[3]),
        dual(pose.dalpha, dalpha),
        dual(pose.dbeta, t[5]),
        dual(pose.foot, _turned(pose.foot, t[0])),
        dual(pose.stance, _turned(pose.stance, alpha)),
        dual(pose.swing, _turned(pose.swing, t[2])),
        dual(pose.theta, theta),
        dual(pose.dtheta, dtheta),
        dual(pose.thigh, _turned(pose.thigh, theta)),
    )


@small
def which(joined, neither, free, bent_knee):
    """Of three numbers the one for what the chain's second link is."""
    return where(joined.free, free, where(joined.bent, bent_knee, neither))


@small
def chained(pose, thigh, joined):
    """A chain's state from a pose; with the ankle locked foot and leg are one link at φ."""
    return (
        pose[0], which(joined, 0.0, pose[1], load(thigh, 0)), pose[2],
        pose[3], which(joined, 0.0, pose[4], load(thigh, 1)), pose[5],
    )  # fmt: skip
