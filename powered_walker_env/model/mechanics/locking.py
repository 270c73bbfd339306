"""Locking a joint: two links are caught by a stop and move as one from then on.

A plastic impact. The impulse between the two is internal: kept are the momentum of the pair, the
sum of theirs, and that of every other link. With the pair's rows and columns of the mass matrix
added up, the momenta give the rates that follow.
"""

from __future__ import annotations

from powered_walker_env.compiled.decorators import formula, small
from powered_walker_env.model.mechanics.chain import (
    Mass,
    couplings,
    mass_matrix,
    mass_matrix_at,
    momenta,
    solve,
    straight,
)


@small
def ankle_locked(m):
    """The mass matrix of foot and stance leg as one, then of the swing leg."""
    one = 0.0 * m.m33 + 1.0
    zero = 0.0 * one
    return Mass(m.m11 + 2.0 * m.m12 + m.m22, zero, m.m13 + m.m23, one, zero, m.m33, m.share3)


@formula
def rates_of(m, stance, swing, c):
    """(α', β') of a walker with its ankle locked from its momenta; `m` is the free chain's."""
    dalpha, _, dbeta = solve(ankle_locked(m), stance, 0.0 * stance, swing, c)
    return dalpha, dbeta


@formula
def ankle_caught(pose, free, c):
    """The pose just after the ankle has met its stop, from the one just before."""
    m = mass_matrix_at(pose, free, c)
    foot, stance, swing = momenta(m, pose.dphi, pose.dalpha, pose.dbeta, c)
    dalpha, dbeta = rates_of(m, foot + stance, swing, c)
    return straight(
        pose.phi, pose.alpha, pose.beta, dalpha, dalpha, dbeta, pose.foot, pose.stance, pose.swing
    )


@formula
def knee_caught(pose, locked, bent, c):
    """The pose just after knee strike, from the one just before.

    Args:
        locked, bent: the walker's chains with all joints but the hip locked, and with its knee
            free. Of thigh and shank as one the first has the row already.
    """
    stance, thigh, shank = momenta(
        mass_matrix_at(pose, bent, c), pose.dphi, pose.dtheta, pose.dbeta, c
    )
    m = mass_matrix(couplings(pose.foot, pose.stance, pose.swing, locked, c), locked, c)
    dphi, _, dbeta = solve(m, stance, 0.0 * stance, thigh + shank, c)
    return straight(
        pose.phi, pose.alpha, pose.beta, dphi, dphi, dbeta, pose.foot, pose.stance, pose.swing
    )
