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

from powered_walker_env.compiled.decorators import formula, small
from powered_walker_env.model.mechanics.chain import cross, inner
from powered_walker_env.model.mechanics.heel_strike import land, momenta_before, new_contact


@small
def _arms(pose, c):
    """From the contact point to the stance ankle and the hip, m."""
    P = c.D * pose.foot + c.R
    return P, P + c.L * pose.stance


@small
def push_moments(pose, impulse, c):
    """Moments of the impulse about the new contact and about the hip, kg m²/s."""
    _, hip = _arms(pose, c)
    push = impulse * pose.stance
    return -cross(new_contact(pose, c), push), -cross(hip, push)


@formula
def push_off(pose, impulse, free, c):
    """The pose just after heel strike and push, from the one just before both."""
    walker, trailing_leg = momenta_before(pose, c)
    about_contact, about_hip = push_moments(pose, impulse, c)
    return land(pose, walker + about_contact, trailing_leg + about_hip, free, c)


@small
def _along_push(pose, struck, c):
    """Velocity of the trailing foot's contact point along the trailing leg, m/s, in the pose
    after a strike; `pose` is the one before."""
    _, hip = _arms(pose, c)
    ankle, new_hip = _arms(struck, c)
    turning = ankle * struck.dphi + (new_hip - ankle) * struck.dalpha  # divided by i
    return -cross(pose.stance, turning - hip * struck.dbeta)


@small
def work_with(pose, impulse, struck, c):
    """Work of a push that comes with the strike, J; `struck` is the pose after both."""
    return 0.5 * impulse * _along_push(pose, struck, c)


@small
def work_after(pose, impulse, unpushed, struck, c):
    """Work of a push that comes after the strike, J; `unpushed` is the pose between."""
    return 0.5 * impulse * (_along_push(pose, unpushed, c) + _along_push(pose, struck, c))


@small
def work_before(pose, impulse, c):
    """Work of a push that comes before the strike, J: the walker is free in the air.

    With Δv the hip's, n1 and n2 the velocities of the legs' centres of mass about it per
    unit of rate, and a = ⟨iρ, J⟩ the moment about it:
    2MΔv + M n1 Δα' + M n2 Δβ' = J and (I + M|n|²) Δrate + M⟨n, Δv⟩ = a for the trailing
    leg, 0 for the other.
    """
    leg, (_, hip) = pose.stance, _arms(pose, c)
    r1 = c.ankle_to_com * leg - c.L * leg  # n = i r
    r2 = c.reaction * (c.hip_to_com * pose.swing)
    massless = 1.0 - c.reaction  # then both are zero, and so is what is divided
    k1 = 1.0 / (c.I + c.M * inner(r1, r1) + massless)
    k2 = 1.0 / (c.I + c.M * inner(r2, r2) + massless)
    a = -impulse * cross(hip, leg)
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
