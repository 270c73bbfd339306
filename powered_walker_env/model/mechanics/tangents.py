"""Tangents: how the mechanics changes to first order along a direction.

A direction moves the state (t_φ, t_α, t_β and the rates' t_φ', …), the stall torque and
the walker itself (`d`, a `Constants` of derivatives) at once. Every function here is
the derivative, by the product rule, of the one of the same name in `swing.py`,
`actuation.py`, `ground.py` or `heel_strike.py`; d e^{iθ} = i e^{iθ} dθ.
"""

from __future__ import annotations

import math

from powered_walker_env.compiled.decorators import internal
from powered_walker_env.compiled.lanes import where
from powered_walker_env.model.mechanics.actuation import stop_unit
from powered_walker_env.model.mechanics.constants import Constants
from powered_walker_env.model.mechanics.heel_strike import from_hip
from powered_walker_env.model.mechanics.swing import (
    direction,
    inner,
    mass_matrix,
    solve,
    turned,
    vectors,
)


@internal
def unpack_direction(gravity, unfold, change, c):
    """The derivative of c = `constants.unpack(row)` along `change`, a row of derivatives.

    Args:
        gravity: row[8], m/s²; unfold: e^{−i·lock}.
    """
    moving = c.reaction  # in the limit of a massless foot its mass and place are fixed
    one = 0.0 * moving + 1.0
    up = (1.0 / gravity) * c.g
    turn, lean = change[1] * unfold, change[3] * c.retracted
    retracted = complex(turn.real + lean.imag, turn.imag - lean.real)  # − i·lock'·D e^{−i·lock}
    arm = c.L + c.retracted  # arg' = ⟨i arm, arm'⟩/|arm|²
    tilt = gravity * change[9]
    return Constants(
        change[0],
        change[1],
        change[2],
        change[3],
        change[4],
        change[5],
        complex(one * change[6], one * change[7]),
        complex(change[0] - moving * change[6], -moving * change[7]),
        moving * change[4],
        moving * change[5],
        0.0,
        complex(change[8] * up.real + tilt * up.imag, change[8] * up.imag - tilt * up.real),
        retracted,
        turned(arm, change[0] + retracted) / inner(arm, arm),
        change[11],
        change[10],
        change[12],
        False,
    )


@internal
def times_i(a):
    """ia."""
    return complex(-a.imag, a.real)


@internal
def vectors_tangent(y, t, foot, A, H, B, d):
    """Changes of D e^{iφ}, A, H and B."""
    stance = direction(y[1])
    return (
        d.D * direction(y[0]) + times_i(foot) * t[0],
        d.ankle_to_com * stance + times_i(A) * t[1],
        d.L * stance + times_i(H) * t[1],
        d.hip_to_com * direction(y[2]) + times_i(B) * t[2],
    )


@internal
def mass_matrix_tangent(vectors, changes, c, d):
    """Changes of (φφ, φα, φβ, αα, αβ, ββ)."""
    foot, A, H, B = vectors
    dfoot, dA, dH, dB = changes
    P, dP = c.R + foot, d.R + dfoot
    leg, dleg = A + H, dA + dH
    m, dm = c.swing_mass, d.swing_mass
    return (
        2.0 * d.M * inner(P, P) + 4.0 * c.M * inner(P, dP),
        d.M * inner(P, leg) + c.M * (inner(dP, leg) + inner(P, dleg)),
        dm * inner(P, B) + m * (inner(dP, B) + inner(P, dB)),
        d.I + d.M * (inner(A, A) + inner(H, H)) + 2.0 * c.M * (inner(A, dA) + inner(H, dH)),
        dm * inner(H, B) + m * (inner(dH, B) + inner(H, dB)),
        d.swing_inertia + dm * inner(B, B) + 2.0 * m * inner(B, dB),
    )


@internal
def bias_tangent(vectors, changes, y, t, c, d):
    """Changes of the centripetal and gravity terms (φ, α, β)."""
    foot, A, H, B = vectors
    dfoot, dA, dH, dB = changes
    s1, s2, s3 = y[3] * y[3], y[4] * y[4], c.reaction * (y[5] * y[5])
    ds1, ds2 = 2.0 * y[3] * t[3], 2.0 * y[4] * t[4]
    ds3 = c.reaction * (2.0 * y[5] * t[5])
    P, dP = c.R + foot, d.R + dfoot
    ankle = c.g - foot * s1
    dankle = d.g - dfoot * s1 - foot * ds1
    a_A, da_A = ankle - A * s2, dankle - dA * s2 - A * ds2
    a_B = ankle - H * s2 - B * s3
    da_B = dankle - dH * s2 - H * ds2 - dB * s3 - B * ds3
    both, dboth = a_A + a_B, da_A + da_B
    alpha = turned(A, a_A) + turned(H, a_B)
    dalpha = turned(dA, a_A) + turned(A, da_A) + turned(dH, a_B) + turned(H, da_B)
    swing = turned(dB, a_B) + turned(B, da_B)
    return (
        d.M * turned(P, both) + c.M * (turned(dP, both) + turned(P, dboth)),
        d.M * alpha + c.M * dalpha,
        d.swing_mass * turned(B, a_B) + c.swing_mass * swing,
    )


@internal
def ankle_torque_tangent(y, t, acting, strength_change, c, d):
    """Change of the motor's torque within its limit; `strength_change` is the control's."""
    rate, rate_change = y[4] - y[3], t[4] - t[3]
    slope_change = -acting.slope * d.no_load_speed / c.no_load_speed
    line = 1.0 + acting.slope * rate
    free = acting.share * strength_change * line + acting.strength * (
        acting.slope * rate_change + slope_change * rate
    )
    torque = acting.strength * line
    free = where(torque > c.torque_limit, d.torque_limit, free)
    return where(torque < -c.torque_limit, -d.torque_limit, free)


@internal
def spring_torque_tangent(y, t, c, d):
    """Change of −k(q3 − π)."""
    return -d.hip_stiffness * (y[2] - y[1] - math.pi) - c.hip_stiffness * (t[2] - t[1])


@internal
def flow_tangent(locked, y, slope, at, matrix, t, acting, strength_change, c, d):
    """(∂f/∂y) t + ∂f/∂p: from M q'' + bias = force, M δq'' = δforce − δbias − δM q''.

    Args:
        y, slope: a state and its derivative; at, matrix: its vectors and mass matrix.
        t: the direction's state; d: its walker.
    """
    moved = vectors_tangent(y, t, at[0], at[1], at[2], at[3], d)
    d11, d12, d13, d22, d23, d33 = mass_matrix_tangent(at, moved, c, d)
    b1, b2, b3 = bias_tangent(at, moved, y, t, c, d)
    tau = ankle_torque_tangent(y, t, acting, strength_change, c, d)
    hip = spring_torque_tangent(y, t, c, d) + acting.hip_share * strength_change
    q1, q2, q3 = slope[3], slope[4], slope[5]
    f1 = tau - b1 - d11 * q1 - d12 * q2 - c.reaction * d13 * q3
    f2 = -tau - c.reaction * hip - b2 - d12 * q1 - d22 * q2 - c.reaction * d23 * q3
    f3 = hip - b3 - d13 * q1 - d23 * q2 - d33 * q3
    ddphi, ddalpha, ddbeta = solve(locked, matrix, f1, f2, f3, c)
    return t[3], t[4], t[5], ddphi, ddalpha, ddbeta


@internal
def holding_torque_tangent(y, slope, t, acting, strength_change, c, d):
    """Change of `actuation.holding_torque`, its scale taken for constant (it is zero there)."""
    at = vectors(y[0], y[1], y[2], c)
    matrix = mass_matrix(at[0], at[1], at[2], at[3], c)
    locked = c.L > 0.0
    turn = flow_tangent(locked, y, slope, at, matrix, t, acting, strength_change, c, d)
    moved = vectors_tangent(y, t, at[0], at[1], at[2], at[3], d)
    d11, d12, d13, _, _, _ = mass_matrix_tangent(at, moved, c, d)
    b1, _, _ = bias_tangent(at, moved, y, t, c, d)
    tau = ankle_torque_tangent(y, t, acting, strength_change, c, d)
    m11, m12, m13 = matrix[0], matrix[1], matrix[2]
    changed = d11 * slope[3] + d12 * slope[4] + c.reaction * d13 * slope[5]
    turned_faster = m11 * turn[3] + m12 * turn[4] + c.reaction * m13 * turn[5]
    return (changed + turned_faster + b1 - tau) / stop_unit(c)


@internal
def still(c):
    """No change of the walker."""
    zero = 0.0 * c.L
    none = complex(zero, zero)
    return Constants(
        zero, zero, zero, zero, zero, zero, none, none, zero, zero, zero, none, none, zero, zero,
        zero, zero, False,
    )  # fmt: skip


@internal
def holding_torque_rate(y, slope, acting, c):
    """Time derivative of `actuation.holding_torque` in the locked phase."""
    return holding_torque_tangent(y, slope, slope, acting, 0.0 * c.L, c, still(c))


@internal
def swing_foot_tangent(y, t, c, d):
    """Change of the swing foot's centre from the stance foot's."""
    foot, stance, swing = direction(y[0]), direction(y[1]), direction(y[2])
    turn = c.D * (foot * t[0]) + c.L * (stance * t[1]) + (c.L * swing + c.retracted * swing) * t[2]
    return d.D * foot + d.L * (stance + swing) + d.retracted * swing + times_i(turn)


@internal
def momenta_before_tangent(y, t, vectors, changes, contact, c, d):
    """Changes of the two momenta just before a heel strike (`contact`: the new point)."""
    foot, A, H, B = vectors
    dfoot, dA, dH, dB = changes
    P, dP = c.R + foot, d.R + dfoot
    reach = d.L * math.sin(y[2]) + c.L * math.cos(y[2]) * t[2]
    departure = where(c.as_published, 2.0 * reach, 0.0)
    contact_change = swing_foot_tangent(y, t, c, d) - complex(0.0 * departure, departure)
    swing, dswing = c.reaction * y[5], c.reaction * t[5]
    v_A = P * y[3] + A * y[4]
    dv_A = dP * y[3] + P * t[3] + dA * y[4] + A * t[4]
    v_B = P * y[3] + H * y[4] + B * swing
    dv_B = dP * y[3] + P * t[3] + dH * y[4] + H * t[4] + dB * swing + B * dswing
    arm_A, arm_B = P + A - contact, P + H + c.reaction * B - contact
    darm_A, darm_B = dP + dA - contact_change, dP + dH + c.reaction * dB - contact_change
    orbital = inner(arm_A, v_A) + inner(arm_B, v_B)
    dorbital = inner(darm_A, v_A) + inner(arm_A, dv_A) + inner(darm_B, v_B) + inner(arm_B, dv_B)
    walker = d.I * (y[4] + y[5]) + c.I * (t[4] + t[5]) + d.M * orbital + c.M * dorbital
    leg = from_hip(y[1], c)
    dleg = times_i(leg) * t[1] - d.hip_to_com * direction(y[1])
    com, dcom = H + leg, dH + dleg
    v, dv = P * y[3] + com * y[4], dP * y[3] + P * t[3] + dcom * y[4] + com * t[4]
    trailing = d.swing_inertia * y[4] + c.swing_inertia * t[4] + d.swing_mass * inner(leg, v)
    return walker, trailing + c.swing_mass * (inner(dleg, v) + inner(leg, dv))


@internal
def push_moments_tangent(y, t, vectors, changes, contact, impulse, impulse_change, c, d):
    """Changes of `push_off.push_moments`."""
    foot, _, H, _ = vectors
    dfoot, _, dH, _ = changes
    contact_change = swing_foot_tangent(y, t, c, d)
    leg = direction(y[1])
    push = impulse * leg
    dpush = impulse_change * leg + times_i(push) * t[1]
    arm, darm = c.R + foot + H, d.R + dfoot + dH
    about_contact = -turned(contact_change, push) - turned(contact, dpush)
    return about_contact, -turned(darm, push) - turned(arm, dpush)


@internal
def stance_momenta_tangent(y, t, vectors, changes, matrix, c, d):
    """Changes of `stop.stance_momenta`."""
    m11, m12, m13, m22, m23, m33 = matrix
    d11, d12, d13, d22, d23, d33 = mass_matrix_tangent(vectors, changes, c, d)
    stance = (d11 + d12) * y[3] + (d12 + d22) * y[4] + c.reaction * (d13 + d23) * y[5]
    stance = stance + (m11 + m12) * t[3] + (m12 + m22) * t[4] + c.reaction * (m13 + m23) * t[5]
    swing = d13 * y[3] + d23 * y[4] + d33 * y[5] + m13 * t[3] + m23 * t[4] + m33 * t[5]
    return stance, swing
