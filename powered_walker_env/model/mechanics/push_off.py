"""Push-off: an impulse at the old contact along the trailing leg, around the heel strike.

The impulse J = P e^{iα} adds its moments to the two momenta that a heel strike keeps
(McGeer 1990; Kuo 2002). These are the same whether the push comes just before the strike,
with it or just after, so the state after it is the same; what differs is the work. With
v the velocity of the trailing foot's contact point, J does ½⟨J, v⁻ + v⁺⟩:

- before: v⁻ = 0 (it stands), v⁺ that of the walker free in the air;
- with: v⁻ = 0, v⁺ that after both;
- after: v⁻ that after the strike alone, v⁺ that after both.
"""

from __future__ import annotations

from powered_walker_env.compiled.decorators import kernel
from powered_walker_env.model.mechanics.heel_strike import land, momenta_before, new_contact
from powered_walker_env.model.mechanics.swing import direction, inner, turned, vectors


@kernel
def push_moments(phi, alpha, beta, impulse, c):
    """Moments of the impulse about the new contact and about the hip, kg m²/s."""
    foot, _, H, _ = vectors(phi, alpha, beta, c)
    push = impulse * direction(alpha)
    return -turned(new_contact(phi, alpha, beta, c), push), -turned(c.R + foot + H, push)


@kernel
def push_off(phi, alpha, beta, dphi, dalpha, dbeta, impulse, c):
    """The state just after heel strike and push, from the state just before both."""
    walker, trailing_leg = momenta_before(phi, alpha, beta, dphi, dalpha, dbeta, c)
    about_contact, about_hip = push_moments(phi, alpha, beta, impulse, c)
    return land(phi, alpha, beta, walker + about_contact, trailing_leg + about_hip, c)


@kernel
def _along_push(phi, alpha, beta, struck, c):
    """Velocity of the trailing foot's contact point along the trailing leg, m/s, in the state
    after a strike; the angles are those before."""
    foot, _, H, _ = vectors(phi, alpha, beta, c)
    new_foot, _, new_H, _ = vectors(struck[0], struck[1], struck[2], c)
    hip = (c.R + new_foot) * struck[3] + new_H * struck[4]  # divided by i
    return -turned(direction(alpha), hip - (c.R + foot + H) * struck[5])


@kernel
def work_with(phi, alpha, beta, impulse, struck, c):
    """Work of a push that comes with the strike, J; `struck` is the state after both."""
    return 0.5 * impulse * _along_push(phi, alpha, beta, struck, c)


@kernel
def work_after(phi, alpha, beta, impulse, unpushed, struck, c):
    """Work of a push that comes after the strike, J; `unpushed` is the state between."""
    before = _along_push(phi, alpha, beta, unpushed, c)
    return 0.5 * impulse * (before + _along_push(phi, alpha, beta, struck, c))


@kernel
def work_before(phi, alpha, beta, impulse, c):
    """Work of a push that comes before the strike, J: the walker is free in the air.

    With Δv the hip's, n1 and n2 the velocities of the legs' centres of mass about it per
    unit of rate, and a = ⟨iρ, J⟩ the moment about it:
    2MΔv + M n1 Δα' + M n2 Δβ' = J and (I + M|n|²) Δrate + M⟨n, Δv⟩ = a for the trailing
    leg, 0 for the other.
    """
    foot, A, H, B = vectors(phi, alpha, beta, c)
    leg = direction(alpha)
    r1, r2 = A - H, c.reaction * B  # n = i r
    massless = 1.0 - c.reaction  # then both are zero, and so is what is divided
    k1 = 1.0 / (c.I + c.M * inner(r1, r1) + massless)
    k2 = 1.0 / (c.I + c.M * inner(r2, r2) + massless)
    a = -impulse * turned(c.R + foot + H, leg)
    m2 = c.M * c.M
    s11 = 2.0 * c.M - m2 * (k1 * r1.imag * r1.imag + k2 * r2.imag * r2.imag)
    s22 = 2.0 * c.M - m2 * (k1 * r1.real * r1.real + k2 * r2.real * r2.real)
    s12 = m2 * (k1 * r1.imag * r1.real + k2 * r2.imag * r2.real)
    share = c.M * k1 * a
    up, forward = impulse * leg.real + share * r1.imag, impulse * leg.imag - share * r1.real
    determinant = s11 * s22 - s12 * s12
    v_up = (s22 * up - s12 * forward) / determinant
    v_forward = (s11 * forward - s12 * up) / determinant
    turning = k1 * (a - c.M * (r1.real * v_forward - r1.imag * v_up)) * c.reaction
    return 0.5 * (impulse * (leg.real * v_up + leg.imag * v_forward) + a * turning)
