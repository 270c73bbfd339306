"""The ankle's stop: a plastic impact of foot and leg, which then move as one.

The impulse between them is internal: kept are the momenta of foot and stance leg
together and of the swing leg, the sum of the φ and α rows of the mass matrix times the
rates, and its β row.
"""

from __future__ import annotations

from powered_walker_env.compiled.decorators import kernel
from powered_walker_env.model.mechanics.heel_strike import momentum_matrix
from powered_walker_env.model.mechanics.swing import mass_matrix, vectors


@kernel
def stop(y, c):
    """How far the ankle is from its stop, rad, positive when extended, and the rate."""
    return c.lock - (y[1] - y[0]), y[3] - y[4]


@kernel
def stance_matrix(phi, alpha, beta, c):
    """The two momenta with φ' = α' as a 2×2 matrix times (α', β')."""
    a11, a12, a21, a22 = momentum_matrix(phi, alpha, beta, c)
    return a11 - c.reaction * a21, a12 - c.reaction * a22, a21, a22


@kernel
def stance_momenta(y, c):
    """Momenta of foot and stance leg together, and of the swing leg, kg m²/s."""
    foot, A, H, B = vectors(y[0], y[1], y[2], c)
    m11, m12, m13, m22, m23, m33 = mass_matrix(foot, A, H, B, c)
    swing = c.reaction * (m13 + m23) * y[5]
    stance = (m11 + m12) * y[3] + (m12 + m22) * y[4] + swing
    return stance, m13 * y[3] + m23 * y[4] + m33 * y[5]


@kernel
def caught(y, c):
    """The state just after the ankle has met its stop, from the state just before."""
    stance, swing = stance_momenta(y, c)
    a11, a12, a21, a22 = stance_matrix(y[0], y[1], y[2], c)
    determinant = a11 * a22 - a12 * a21
    dalpha = (stance * a22 - a12 * swing) / determinant
    dbeta = (a11 * swing - a21 * stance) / determinant
    return y[0], y[1], y[2], dalpha, dalpha, dbeta
