"""Swing: mass matrix, bias and accelerations of both modes; energy.

Camp 1997, Appendix B (Kane's method), in absolute angles. With P the vector from the
contact point to the stance ankle, A from the ankle to the stance leg's centre of mass,
H from the ankle to the hip and B from the hip to the swing leg's centre of mass,

    P = R + D e^{iφ},  A = (X + iY) e^{iα},  H = L e^{iα},  B = (L − X − iY) e^{iβ},

the legs' centres of mass move at i(Pφ' + Aα') and i(Pφ' + Hα' + Bβ'), the foot being
massless and rolling without slip.

Every function takes floats and complex numbers, or eight walkers at once (`lanes.py`).

A leg whose whole mass sits at the hip is the limit of a vanishing mass m at the ankle
(Garcia et al. 1998): the swing leg's equation is divided by m, and its reaction on the
rest of the walker (`c.reaction`, otherwise 1) is 0.
"""

from __future__ import annotations

import math

from powered_walker_env.compiled.decorators import kernel
from powered_walker_env.compiled.lanes import where


@kernel
def inner(a, b):
    """⟨a, b⟩ = Re(ā b)."""
    return a.real * b.real + a.imag * b.imag


@kernel
def turned(a, b):
    """⟨ia, b⟩: the component of b along a turned by a right angle forward."""
    return a.real * b.imag - a.imag * b.real


@kernel
def direction(angle):
    """e^{i·angle}: a unit vector at `angle` from the floor's normal."""
    return complex(math.cos(angle), math.sin(angle))


@kernel
def vectors(phi, alpha, beta, c):
    """D e^{iφ}, A, H and B of the module's docstring, m."""
    stance = direction(alpha)
    return (
        c.D * direction(phi),
        c.ankle_to_com * stance,
        c.L * stance,
        c.hip_to_com * direction(beta),
    )


@kernel
def mass_matrix(foot, A, H, B, c):
    """Upper triangle (φφ, φα, φβ, αα, αβ, ββ) of the symmetric mass matrix, kg m².

    The entries with β are those of the swing leg's own equation.
    """
    P = c.R + foot
    return (
        2.0 * c.M * inner(P, P),
        c.M * inner(P, A + H),
        c.swing_mass * inner(P, B),
        c.I + c.M * (inner(A, A) + inner(H, H)),
        c.swing_mass * inner(H, B),
        c.swing_inertia + c.swing_mass * inner(B, B),
    )


@kernel
def bias(foot, A, H, B, dphi, dalpha, dbeta, c):
    """Centripetal and gravity terms (φ, α, β), N m: mass matrix · accelerations + bias = forces.

    a_A and a_B are the accelerations of the two centres of mass at zero angular
    accelerations, less gravity's.
    """
    P = c.R + foot
    stance = dalpha * dalpha
    a_ankle = c.g - foot * (dphi * dphi)
    a_A = a_ankle - A * stance
    a_B = a_ankle - H * stance - B * (c.reaction * (dbeta * dbeta))
    return (
        c.M * turned(P, a_A + a_B),
        c.M * (turned(A, a_A) + turned(H, a_B)),
        c.swing_mass * turned(B, a_B),
    )


@kernel
def solve(locked, matrix, f1, f2, f3, c):
    """(φ'', α'', β'') under forces; with the ankle locked φ'' = α''.

    Gaussian elimination of β; then the two equations left, or, the ankle's torque being
    internal, their sum.
    """
    m11, m12, m13, m22, m23, m33 = matrix
    swing = 1.0 / m33
    k1, k2 = m13 * swing, m23 * swing
    r1, r2 = c.reaction * k1, c.reaction * k2
    n11, n12, n22 = m11 - r1 * m13, m12 - r1 * m23, m22 - r2 * m23
    h1, h2 = f1 - r1 * f3, f2 - r2 * f3
    both = h1 + h2
    determinant = where(locked, n11 + 2.0 * n12 + n22, n11 * n22 - n12 * n12)
    share = 1.0 / determinant
    ddphi = share * where(locked, both, n22 * h1 - n12 * h2)
    ddalpha = share * where(locked, both, n11 * h2 - n12 * h1)
    ddbeta = swing * f3 - k1 * ddphi - k2 * ddalpha
    return ddphi, ddalpha, ddbeta


@kernel
def spring_torque(y, c):
    """Of the spring between the legs, on the swing leg: −k(q3 − π), N m (Kuo 2002)."""
    return -c.hip_stiffness * (y[2] - y[1] - math.pi)


@kernel
def accelerations(locked, y, ankle_torque, hip_torque, c):
    """(φ'', α'', β'') at y = (φ, α, β, φ', α', β'), rad/s².

    The ankle's torque turns the foot forward and the leg back: generalised forces
    (+τ, −τ, 0); the hip's, to which the spring's is added, turns the swing leg forward
    and the stance leg back: (0, −τ, +τ).
    """
    foot, A, H, B = vectors(y[0], y[1], y[2], c)
    b1, b2, b3 = bias(foot, A, H, B, y[3], y[4], y[5], c)
    hip = hip_torque + spring_torque(y, c)
    return solve(
        locked,
        mass_matrix(foot, A, H, B, c),
        ankle_torque - b1,
        -ankle_torque - c.reaction * hip - b2,
        hip - b3,
        c,
    )


@kernel
def kinetic_energy(phi, alpha, beta, dphi, dalpha, dbeta, c):
    """½ q'ᵀ(mass matrix)q', J."""
    foot, A, H, B = vectors(phi, alpha, beta, c)
    m11, m12, m13, m22, m23, m33 = mass_matrix(foot, A, H, B, c)
    stance = 0.5 * (m11 * dphi * dphi + m22 * dalpha * dalpha) + m12 * dphi * dalpha
    swing = (0.5 * m33 * dbeta + m13 * dphi + m23 * dalpha) * dbeta
    return stance + c.reaction * swing


@kernel
def potential_energy(phi, alpha, beta, c):
    """M⟨g, r⟩ summed over the legs, and the hip spring's, J; r from where the contact
    point is at φ = 0."""
    foot, A, H, B = vectors(phi, alpha, beta, c)
    ankle = complex(c.R, c.R * phi) + foot
    apart = beta - alpha - math.pi
    spring = 0.5 * c.hip_stiffness * apart * apart
    return c.M * inner(c.g, 2.0 * ankle + A + H + c.reaction * B) + c.reaction * spring


@kernel
def energy(phi, alpha, beta, dphi, dalpha, dbeta, c):
    """Mechanical energy of the walker, J."""
    kinetic = kinetic_energy(phi, alpha, beta, dphi, dalpha, dbeta, c)
    return kinetic + potential_energy(phi, alpha, beta, c)
