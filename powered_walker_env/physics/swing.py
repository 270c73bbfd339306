"""Swing: mass matrix, bias and accelerations of both modes; energy.

Camp 1997, Appendix B (Kane's method), in absolute angles. With P the vector from the
contact point to the stance ankle, A from the ankle to the stance leg's centre of mass,
H from the ankle to the hip and B from the hip to the swing leg's centre of mass,

    P = R + D e^{iφ},  A = (X + iY) e^{iα},  H = L e^{iα},  B = (L − X − iY) e^{iβ},

the legs' centres of mass move at i(Pφ' + Aα') and i(Pφ' + Hα' + Bβ'), the foot being
massless and rolling without slip.
"""

from __future__ import annotations

import math

from powered_walker_env.compilation import kernel


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
    """Upper triangle (φφ, φα, φβ, αα, αβ, ββ) of the symmetric mass matrix, kg m²."""
    P = c.R + foot
    return (
        2.0 * c.M * inner(P, P),
        c.M * inner(P, A + H),
        c.M * inner(P, B),
        c.I + c.M * (inner(A, A) + inner(H, H)),
        c.M * inner(H, B),
        c.I + c.M * inner(B, B),
    )


@kernel
def bias(foot, A, H, B, dphi, dalpha, dbeta, c):
    """Centripetal and gravity terms (φ, α, β), N m: mass matrix · accelerations + bias = forces.

    a_A and a_B are the accelerations of the two centres of mass at zero angular
    accelerations, less gravity's.
    """
    P = c.R + foot
    a_ankle = c.g - foot * dphi**2
    a_A = a_ankle - A * dalpha**2
    a_B = a_ankle - H * dalpha**2 - B * dbeta**2
    return (
        c.M * turned(P, a_A + a_B),
        c.M * (turned(A, a_A) + turned(H, a_B)),
        c.M * turned(B, a_B),
    )


@kernel
def solve_free(matrix, f1, f2, f3):
    """(φ'', α'', β'') under forces: Gaussian elimination, β first, then α."""
    m11, m12, m13, m22, m23, m33 = matrix
    k1, k2 = m13 / m33, m23 / m33
    n11, n12, n22 = m11 - k1 * m13, m12 - k1 * m23, m22 - k2 * m23
    h1, h2 = f1 - k1 * f3, f2 - k2 * f3
    k = n12 / n22
    ddphi = (h1 - k * h2) / (n11 - k * n12)
    ddalpha = (h2 - n12 * ddphi) / n22
    ddbeta = (f3 - m13 * ddphi - m23 * ddalpha) / m33
    return ddphi, ddalpha, ddbeta


@kernel
def solve_locked(matrix, f1, f2, f3):
    """(α'', β'') under forces with φ'' = α'': the φ and α rows and columns, added."""
    m11, m12, m13, m22, m23, m33 = matrix
    stance, coupling = m11 + 2.0 * m12 + m22, m13 + m23
    k = coupling / m33
    ddalpha = (f1 + f2 - k * f3) / (stance - k * coupling)
    ddbeta = (f3 - coupling * ddalpha) / m33
    return ddalpha, ddbeta


@kernel
def free_accelerations(phi, alpha, beta, dphi, dalpha, dbeta, torque, c):
    """(φ'', α'', β'') with the ankle free and `torque` extending it, rad/s².

    The motor turns the foot forward and the leg back: generalised forces (+τ, −τ, 0).
    """
    foot, A, H, B = vectors(phi, alpha, beta, c)
    b1, b2, b3 = bias(foot, A, H, B, dphi, dalpha, dbeta, c)
    return solve_free(mass_matrix(foot, A, H, B, c), torque - b1, -torque - b2, -b3)


@kernel
def locked_accelerations(phi, alpha, beta, dalpha, dbeta, c):
    """(α'', β'') with foot and stance leg one body (φ' = α'), rad/s²."""
    foot, A, H, B = vectors(phi, alpha, beta, c)
    b1, b2, b3 = bias(foot, A, H, B, dalpha, dalpha, dbeta, c)
    return solve_locked(mass_matrix(foot, A, H, B, c), -b1, -b2, -b3)


@kernel
def kinetic_energy(phi, alpha, beta, dphi, dalpha, dbeta, c):
    """½ q'ᵀ(mass matrix)q', J."""
    foot, A, H, B = vectors(phi, alpha, beta, c)
    m11, m12, m13, m22, m23, m33 = mass_matrix(foot, A, H, B, c)
    diagonal = m11 * dphi**2 + m22 * dalpha**2 + m33 * dbeta**2
    mixed = m12 * dphi * dalpha + m13 * dphi * dbeta + m23 * dalpha * dbeta
    return 0.5 * diagonal + mixed


@kernel
def potential_energy(phi, alpha, beta, c):
    """M⟨g, r⟩ summed over the legs, J; r from where the contact point is at φ = 0."""
    foot, A, H, B = vectors(phi, alpha, beta, c)
    ankle = complex(c.R, c.R * phi) + foot
    return c.M * inner(c.g, 2.0 * ankle + A + H + B)


@kernel
def energy(phi, alpha, beta, dphi, dalpha, dbeta, c):
    """Mechanical energy of the walker, J."""
    kinetic = kinetic_energy(phi, alpha, beta, dphi, dalpha, dbeta, c)
    return kinetic + potential_energy(phi, alpha, beta, c)
