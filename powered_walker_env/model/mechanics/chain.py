"""A planar chain of links: mass matrix, bias, accelerations, momenta, energy.

Camp 1997, Appendix B (Kane's method), as a chain. Link k points along z_k = e^{iθ_k}; with the
levers l_k to the next joint and the moments S_k of `Chain`, let

    P_1 = R + l_1 z_1,  P_2 = l_2 z_2,  u_k = S_k z_k,  q_jk = conj(P_j) u_k  (j < k).

Since the contact point rolls, a point at r on the first link moves at i(R + r z_1)θ_1', and one on
a later link at i r z_k θ_k' on top of its joint. So the coefficient of θ_j'' in the equation of
link k is Re q_jk, and that of the centripetal θ_j'² is its imaginary part, up to what R adds:

    mass matrix   J_1 + 2R Re u_1,  J_2,  J_3;  Re q_jk
    bias of 1     −R Im u_1 θ_1'² − Im q_12 θ_2'² − Im q_13 θ_3'² + ⟨i(mR + u_1), g⟩
    bias of k     Σ_{j<k} Im(q_jk − R u_k [j = 1]) θ_j'² − Σ_{j>k} Im q_kj θ_j'² + ⟨iu_k, g⟩

A leg whose whole mass sits at the hip is the limit of a vanishing mass m at the ankle
(Garcia et al. 1998): the swing leg's equation is divided by m, and its reaction on the
rest of the walker (`c.reaction`, otherwise 1) is 0.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from powered_walker_env.compiled.decorators import formula, small
from powered_walker_env.compiled.lanes import unit, where


@small
def inner(a, b):
    """⟨a, b⟩ = Re(ā b)."""
    return a.real * b.real + a.imag * b.imag


@small
def cross(a, b):
    """⟨ia, b⟩ = Im(ā b): the component of b along a turned by a right angle forward."""
    return a.real * b.imag - a.imag * b.real


class Couplings(NamedTuple):
    """u_1, u_2, u_3 and q_12, q_13, q_23 of the module's docstring."""

    u1: Any  # kg m
    u2: Any
    u3: Any
    q12: Any  # kg m²
    q13: Any
    q23: Any


class Mass(NamedTuple):
    """The upper triangle of the mass matrix, kg m²; 13 and 23 as in the third equation."""

    m11: Any
    m12: Any
    m13: Any
    m22: Any
    m23: Any
    m33: Any
    share3: Any  # 1/m33


@small
def coupled(a, b):
    """conj(a) b."""
    return complex(inner(a, b), cross(a, b))


class Pose(NamedTuple):
    """The walker at an instant: angles, rates, and the unit vectors along its links.

    With the swing knee straight the thigh is the leg: θ = β.
    """

    phi: Any  # rad, foot
    alpha: Any  # stance leg
    beta: Any  # swing leg; with the knee bent its shank
    dphi: Any  # rad/s
    dalpha: Any
    dbeta: Any
    foot: Any  # e^{iφ}
    stance: Any  # e^{iα}
    swing: Any  # e^{iβ}
    theta: Any  # rad, thigh of the swing leg
    dtheta: Any
    thigh: Any  # e^{iθ}


@small
def straight(phi, alpha, beta, dphi, dalpha, dbeta, foot, stance, swing):
    """A pose with a straight swing leg."""
    return Pose(
        phi, alpha, beta, dphi, dalpha, dbeta, foot, stance, swing, beta, dbeta, swing
    )  # fmt: skip


@small
def bent(pose, theta, dtheta, thigh):
    """A pose with another thigh."""
    return Pose(
        pose.phi, pose.alpha, pose.beta, pose.dphi, pose.dalpha, pose.dbeta,
        pose.foot, pose.stance, pose.swing, theta, dtheta, thigh,
    )  # fmt: skip


@formula
def pose_of(phi, alpha, beta, dphi, dalpha, dbeta):
    """The pose with these angles and rates, and a straight swing leg."""
    return straight(phi, alpha, beta, dphi, dalpha, dbeta, unit(phi), unit(alpha), unit(beta))


@formula
def couplings(z1, z2, z3, chain, c):
    """How links along these unit vectors pull at each other."""
    P1, P2 = chain.lever1 * z1 + c.R, chain.lever2 * z2
    u1, u2, u3 = chain.moment1 * z1, chain.moment2 * z2, chain.moment3 * z3
    return Couplings(u1, u2, u3, coupled(P1, u2), coupled(P1, u3), coupled(P2, u3))


@small
def mass_matrix(at, chain, c):
    """The mass matrix from the couplings."""
    return Mass(
        chain.inertia1 + 2.0 * c.R * at.u1.real,
        at.q12.real,
        at.q13.real,
        chain.inertia2,
        at.q23.real,
        chain.inertia3,
        chain.share3,
    )


@formula
def bias(at, dy1, dy2, dy3, chain, c):
    """Centripetal and gravity terms, N m: mass matrix · accelerations + bias = forces."""
    s1, s2, s3 = dy1 * dy1, dy2 * dy2, dy3 * dy3
    pull = c.reaction * s3
    b1 = cross(at.u1 + chain.roll, c.g) - c.R * at.u1.imag * s1
    b2 = cross(at.u2, c.g) + (at.q12.imag - c.R * at.u2.imag) * s1
    b3 = cross(at.u3, c.g) + (at.q13.imag - c.R * at.u3.imag) * s1 + at.q23.imag * s2
    return b1 - at.q12.imag * s2 - at.q13.imag * pull, b2 - at.q23.imag * pull, b3


@formula
def solve(m, f1, f2, f3, c):
    """The x with mass matrix · x = f, by Gaussian elimination of the third."""
    k1, k2 = m.m13 * m.share3, m.m23 * m.share3
    r1, r2 = c.reaction * k1, c.reaction * k2
    n11, n12, n22 = m.m11 - r1 * m.m13, m.m12 - r1 * m.m23, m.m22 - r2 * m.m23
    h1, h2 = f1 - r1 * f3, f2 - r2 * f3
    scale = 1.0 / (n11 * n22 - n12 * n12)
    x1, x2 = scale * (n22 * h1 - n12 * h2), scale * (n11 * h2 - n12 * h1)
    return x1, x2, m.share3 * f3 - k1 * x1 - k2 * x2


@small
def hip_bend(y1, y2, y3, chain):
    """How far the swing leg is from the stance leg's line, q3 − π, rad."""
    return chain.hip1 * y1 + chain.hip2 * y2 + chain.hip3 * y3 + (chain.hip0 - math.pi)


@formula
def accelerations(y, ankle, pull, chain, c):
    """The angular accelerations at y, rad/s².

    The ankle's torque turns the foot forward and the leg back: generalised forces
    (+τ, −τ, 0); the hip's turns the swing leg forward and the stance leg back.
    """
    at = couplings(unit(y[0]), unit(y[1]), unit(y[2]), chain, c)
    b1, b2, b3 = bias(at, y[3], y[4], y[5], chain, c)
    hip = pull - c.hip_stiffness * hip_bend(y[0], y[1], y[2], chain)  # with the spring (Kuo 2002)
    back, tau = c.reaction * hip, chain.ankle * ankle
    return solve(
        mass_matrix(at, chain, c),
        tau + chain.hip1 * back - b1,
        chain.hip2 * back - tau - b2,
        chain.hip3 * hip - b3,
        c,
    )


@formula
def momenta(m, dy1, dy2, dy3, c):
    """Generalised momenta, kg m²/s: mass matrix · rates."""
    pull = c.reaction * dy3
    return (
        m.m11 * dy1 + m.m12 * dy2 + m.m13 * pull,
        m.m12 * dy1 + m.m22 * dy2 + m.m23 * pull,
        m.m13 * dy1 + m.m23 * dy2 + m.m33 * dy3,
    )


@small
def second_link(pose, chain):
    """Angle, rate and unit vector of the link between the first and the last; a link that does
    not exist stands still."""
    knee = chain.knee > 0.0
    return (
        where(knee, pose.theta, pose.alpha),
        chain.ankle * pose.dalpha + chain.knee * pose.dtheta,
        where(knee, pose.thigh, pose.stance),
    )


@formula
def mass_matrix_at(pose, chain, c):
    """The mass matrix at a pose, of any of the walker's chains."""
    _, _, second = second_link(pose, chain)
    return mass_matrix(couplings(pose.foot, second, pose.swing, chain, c), chain, c)


@formula
def kinetic_energy(pose, chain, c):
    """½ rates · momenta, J."""
    m, (_, rate, _) = mass_matrix_at(pose, chain, c), second_link(pose, chain)
    p1, p2, p3 = momenta(m, pose.dphi, rate, pose.dbeta, c)
    return 0.5 * (p1 * pose.dphi + p2 * rate + c.reaction * p3 * pose.dbeta)


@small
def potential_energy(pose, chain, c):
    """Σ m⟨g, r⟩ and the hip spring's, J; r from where the contact point is at φ = 0."""
    angle, _, second = second_link(pose, chain)
    moment = chain.moment1 * pose.foot + chain.moment2 * second
    moment = moment + c.reaction * (chain.moment3 * pose.swing)
    rolled = chain.roll * complex(0.0 * pose.phi + 1.0, pose.phi)
    bend = hip_bend(pose.phi, angle, pose.beta, chain)
    spring = 0.5 * c.hip_stiffness * bend * bend
    return inner(c.g, rolled + moment) + c.reaction * spring


@small
def energy(pose, chain, c):
    """Mechanical energy of the walker, J."""
    return kinetic_energy(pose, chain, c) + potential_energy(pose, chain, c)
