"""Heel strike: legs swap, two angular momenta kept (Camp 1997, section 3).

A plastic collision without slip: the old foot leaves the floor and is retracted at
once (it is massless). Kept are the angular momentum of the whole walker about the new
contact point, and of the trailing leg about the hip.

The listing (`as_published`) departs from this text twice:
1. `mom.m` puts the new contact point at −L sin β instead of +L sin β (AutoLev input
   `p_sank_h> = L*b1>`): for a symmetric step near the old contact (on it if D = 0);
2. `pow_jump.m` solves with the mass matrix of the configuration *before* the strike.
"""

from __future__ import annotations

import math

from powered_walker_env.compiled.decorators import kernel
from powered_walker_env.compiled.lanes import where
from powered_walker_env.model.mechanics.ground import swing_foot
from powered_walker_env.model.mechanics.swing import direction, inner, mass_matrix, vectors


@kernel
def new_contact(phi, alpha, beta, c):
    """The new contact point from the old one, m (up + i·forward)."""
    point = swing_foot(phi, alpha, beta, c)
    departure = where(c.as_published, 2.0 * c.L * math.sin(beta), 0.0)  # the first
    return point - complex(0.0, departure)


@kernel
def momenta_before(phi, alpha, beta, dphi, dalpha, dbeta, c):
    """Angular momenta just before: the walker's about the new contact, the trailing leg's
    about the hip, kg m²/s."""
    foot, A, H, B = vectors(phi, alpha, beta, c)
    P = c.R + foot
    contact = new_contact(phi, alpha, beta, c)
    velocity_A = P * dphi + A * dalpha  # divided by i, as in swing.py
    velocity_B = P * dphi + H * dalpha + B * (c.reaction * dbeta)
    spin = c.I * (dalpha + dbeta)
    arm_B = P + H + c.reaction * B - contact
    walker = inner(P + A - contact, velocity_A) + inner(arm_B, velocity_B)
    arm = from_hip(alpha, c)
    trailing = inner(arm, P * dphi + (H + arm) * dalpha)
    return spin + c.M * walker, c.swing_inertia * dalpha + c.swing_mass * trailing


@kernel
def from_hip(alpha, c):
    """From the hip to the mass that swings in the next stride: A − H, without the cancellation,
    and the vanishing mass at the ankle in the limit of a massless foot."""
    return -1.0 * (c.hip_to_com * direction(alpha))


@kernel
def momentum_matrix(phi, alpha, beta, c):
    """The same momenta in a locked configuration as a 2×2 matrix times (α', β').

    The walker's row is the sum of all rows of the mass matrix, the swing leg's its β
    row, with φ' = α'.
    """
    foot, A, H, B = vectors(phi, alpha, beta, c)
    m11, m12, m13, m22, m23, m33 = mass_matrix(foot, A, H, B, c)
    coupling = m13 + m23
    stance = m11 + 2.0 * m12 + m22
    return stance + c.reaction * coupling, c.reaction * (coupling + m33), coupling, m33


@kernel
def swapped(beta, alpha, c):
    """(φ, α, β) after the strike: the swing leg stands, the stance leg swings."""
    return beta - math.pi - c.lock, beta - math.pi, alpha + math.pi


@kernel
def heel_strike(phi, alpha, beta, dphi, dalpha, dbeta, c):
    """The state (φ, α, β, φ', α', β') just after the strike, from the state just before."""
    walker, trailing_leg = momenta_before(phi, alpha, beta, dphi, dalpha, dbeta, c)
    return land(phi, alpha, beta, walker, trailing_leg, c)


@kernel
def land(phi, alpha, beta, walker, trailing_leg, c):
    """The state just after a strike that leaves the two momenta."""
    new_phi, new_alpha, new_beta = swapped(beta, alpha, c)
    # Departure 2: the listing's matrix is that of the configuration before the strike.
    a11, a12, a21, a22 = momentum_matrix(
        where(c.as_published, phi, new_phi),
        where(c.as_published, alpha, new_alpha),
        where(c.as_published, beta, new_beta),
        c,
    )
    determinant = a11 * a22 - a12 * a21
    new_dalpha = (walker * a22 - a12 * trailing_leg) / determinant
    new_dbeta = (a11 * trailing_leg - a21 * walker) / determinant
    return new_phi, new_alpha, new_beta, new_dalpha, new_dalpha, new_dbeta
