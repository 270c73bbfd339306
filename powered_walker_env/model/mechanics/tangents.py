"""How a chain's accelerations change to first order along a direction.

From mass matrix · q'' + bias = force follows, with δ for what changes,
mass matrix · δq'' = δforce − δbias − δ(mass matrix) q'', with δz = i z δθ and the product rule
on the complex products of `chain.py`. This alone is written by hand: carried through the stages
of every step, it would cost more if the numbers themselves were calculated anew with each
direction, as formulas with tangents do.
"""

from __future__ import annotations

from powered_walker_env.compiled.decorators import formula, small
from powered_walker_env.model.mechanics.chain import Couplings, coupled, cross, solve


@small
def times_i(a):
    """ia."""
    return complex(-a.imag, a.real)


@formula
def couplings_tangent(z1, z2, z3, at, t, chain, c, dchain, dc):
    """Changes of the couplings; t: of the angles, dchain and dc: of the walker."""
    arm1, P2 = chain.lever1 * z1, chain.lever2 * z2
    P1 = arm1 + c.R
    dP1 = dchain.lever1 * z1 + times_i(arm1) * t[0] + dc.R
    dP2 = dchain.lever2 * z2 + times_i(P2) * t[1]
    du1 = dchain.moment1 * z1 + times_i(at.u1) * t[0]
    du2 = dchain.moment2 * z2 + times_i(at.u2) * t[1]
    du3 = dchain.moment3 * z3 + times_i(at.u3) * t[2]
    return Couplings(
        du1,
        du2,
        du3,
        coupled(dP1, at.u2) + coupled(P1, du2),
        coupled(dP1, at.u3) + coupled(P1, du3),
        coupled(dP2, at.u3) + coupled(P2, du3),
    )


@formula
def bias_tangent(at, dat, y, t, chain, c, dchain, dc):
    """Changes of the centripetal and gravity terms."""
    s1, s2, s3 = y[3] * y[3], y[4] * y[4], c.reaction * (y[5] * y[5])
    ds1, ds2 = 2.0 * y[3] * t[3], 2.0 * y[4] * t[4]
    ds3 = c.reaction * (2.0 * y[5] * t[5])
    b1 = cross(dat.u1 + dchain.roll, c.g) + cross(at.u1 + chain.roll, dc.g)
    b2 = cross(dat.u2, c.g) + cross(at.u2, dc.g)
    b3 = cross(dat.u3, c.g) + cross(at.u3, dc.g)
    b1 = b1 - (dc.R * at.u1.imag + c.R * dat.u1.imag) * s1 - c.R * at.u1.imag * ds1
    b1 = b1 - dat.q12.imag * s2 - at.q12.imag * ds2 - dat.q13.imag * s3 - at.q13.imag * ds3
    b2 = b2 + (dat.q12.imag - dc.R * at.u2.imag - c.R * dat.u2.imag) * s1
    b2 = b2 + (at.q12.imag - c.R * at.u2.imag) * ds1 - dat.q23.imag * s3 - at.q23.imag * ds3
    b3 = b3 + (dat.q13.imag - dc.R * at.u3.imag - c.R * dat.u3.imag) * s1
    b3 = b3 + (at.q13.imag - c.R * at.u3.imag) * ds1 + dat.q23.imag * s2 + at.q23.imag * ds2
    return b1, b2, b3


@formula
def acceleration_tangents(at, dat, m, y, moved, t, tau, hip, chain, c, dchain, dc):
    """Changes of the angular accelerations.

    Args:
        at, m: couplings and mass matrix at y; dat: changes of the couplings.
        moved: the time derivative of y; t: the change of y.
        tau, hip: changes of the torques at the ankle and the hip.
    """
    b1, b2, b3 = bias_tangent(at, dat, y, t, chain, c, dchain, dc)
    a1, a2, a3, back = moved[3], moved[4], c.reaction * moved[5], c.reaction * hip
    d11 = dchain.inertia1 + 2.0 * (dc.R * at.u1.real + c.R * dat.u1.real)
    d12, d13, d23 = dat.q12.real, dat.q13.real, dat.q23.real
    f1 = chain.ankle * tau + chain.hip1 * back - b1 - d11 * a1 - d12 * a2 - d13 * a3
    f2 = chain.hip2 * back - chain.ankle * tau - b2
    f2 = f2 - d12 * a1 - dchain.inertia2 * a2 - d23 * a3
    f3 = chain.hip3 * hip - b3 - d13 * a1 - d23 * a2 - dchain.inertia3 * moved[5]
    return solve(m, f1, f2, f3, c)
