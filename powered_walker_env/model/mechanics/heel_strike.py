"""Heel strike: legs swap, two angular momenta kept (Camp 1997, section 3).

A plastic collision without slip, of a walker with straight legs: the old foot leaves the floor and
is retracted at once (it is massless). Kept are the angular momentum of the whole walker about the
new contact point, and of the trailing leg about the hip.

The listing (`as_published`) departs from this text twice:
1. `mom.m` puts the new contact point at −L sin β instead of +L sin β (AutoLev input
   `p_sank_h> = L*b1>`): for a symmetric step near the old contact (on it if D = 0);
2. `pow_jump.m` solves with the mass matrix of the configuration *before* the strike.
"""

from __future__ import annotations

import math

from powered_walker_env.compiled.decorators import formula, small
from powered_walker_env.compiled.lanes import where
from powered_walker_env.model.mechanics.chain import (
    couplings,
    inner,
    mass_matrix,
    pose_of,
    straight,
)
from powered_walker_env.model.mechanics.ground import swing_foot
from powered_walker_env.model.mechanics.locking import rates_of


@small
def new_contact(pose, c):
    """The new contact point from the old one, m (up + i·forward)."""
    departure = where(c.as_published, 2.0 * c.L * pose.swing.imag, 0.0)  # the first
    return swing_foot(pose, c) - complex(0.0 * departure, departure)


@small
def from_hip(stance, c):
    """From the hip to the mass that swings in the next stride: A − H, without the cancellation,
    and the vanishing mass at the ankle in the limit of a massless foot."""
    return -1.0 * (c.hip_to_com * stance)


@formula
def momenta_before(pose, c):
    """Angular momenta just before: the walker's about the new contact, the trailing leg's
    about the hip, kg m²/s."""
    P = c.D * pose.foot + c.R
    A, H = c.ankle_to_com * pose.stance, c.L * pose.stance
    B = c.reaction * (c.hip_to_com * pose.swing)
    contact = new_contact(pose, c)
    velocity_A = P * pose.dphi + A * pose.dalpha  # divided by i, as in chain.py
    velocity_B = P * pose.dphi + H * pose.dalpha + B * pose.dbeta
    orbital = inner(P + A - contact, velocity_A) + inner(P + H + B - contact, velocity_B)
    arm = from_hip(pose.stance, c)
    trailing = inner(arm, P * pose.dphi + (H + arm) * pose.dalpha)
    walker = c.I * (pose.dalpha + pose.dbeta) + c.M * orbital
    return walker, c.swing_inertia * pose.dalpha + c.swing_mass * trailing


@formula
def land(pose, walker, trailing_leg, free, c):
    """The pose just after a strike that leaves the two momenta: the swing leg stands, the stance
    leg swings. The walker's momentum about the contact is the sum of its two links'."""
    alpha = pose.beta - math.pi
    still = 0.0 * alpha
    after = pose_of(alpha - c.lock, alpha, pose.alpha + math.pi, still, still, still)
    # Departure 2: the listing's matrix is that of the configuration before the strike.
    m = mass_matrix(
        couplings(
            where(c.as_published, pose.foot, after.foot),
            where(c.as_published, pose.stance, after.stance),
            where(c.as_published, pose.swing, after.swing),
            free,
            c,
        ),
        free,
        c,
    )
    dalpha, dbeta = rates_of(m, walker - c.reaction * trailing_leg, trailing_leg, c)
    return straight(
        after.phi, after.alpha, after.beta, dalpha, dalpha, dbeta,
        after.foot, after.stance, after.swing,
    )  # fmt: skip


@small
def heel_strike(pose, free, c):
    """The pose just after the strike, from the one just before."""
    walker, trailing_leg = momenta_before(pose, c)
    return land(pose, walker, trailing_leg, free, c)
