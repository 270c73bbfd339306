"""Tangents: how the mechanics changes to first order along a direction.

A direction moves the state (t_φ, t_α, t_β and the rates' t_φ', …), the stall torque and
the walker itself (`d`, a `Constants` of derivatives) at once. Every function here is
the derivative, by the product rule, of the one of the same name in `swing.py`,
`actuation.py`, `ground.py` or `heel_strike.py`; d e^{iθ} = i e^{iθ} dθ.
"""

from __future__ import annotations

import math

from powered_walker_env.compilation import kernel
from powered_walker_env.physics.constants import Constants
from powered_walker_env.physics.swing import direction, inner, turned


@kernel
def unpack_direction(row, change, c):
    """The derivative of c = `constants.unpack(row)` along `change`, a row of derivatives."""
    gravity = row[8]
    up = c.g / gravity
    return Constants(
        change[0],
        change[1],
        change[2],
        change[3],
        change[4],
        change[5],
        complex(change[6], change[7]),
        complex(change[0] - change[6], -change[7]),
        (complex(change[8], 0.0) - complex(0.0, gravity * change[9])) * up,
        change[10],
        False,
    )


@kernel
def times_i(a):
    """ia."""
    return complex(-a.imag, a.real)


@kernel
def vectors_tangent(y, t, foot, A, H, B, d):
    """Changes of D e^{iφ}, A, H and B."""
    stance = direction(y[1])
    return (
        d.D * direction(y[0]) + times_i(foot) * t[0],
        d.ankle_to_com * stance + times_i(A) * t[1],
        d.L * stance + times_i(H) * t[1],
        d.hip_to_com * direction(y[2]) + times_i(B) * t[2],
    )


@kernel
def mass_matrix_tangent(vectors, changes, c, d):
    """Changes of (φφ, φα, φβ, αα, αβ, ββ)."""
    foot, A, H, B = vectors
    dfoot, dA, dH, dB = changes
    P, dP = c.R + foot, d.R + dfoot
    leg, dleg = A + H, dA + dH
    return (
        2.0 * d.M * inner(P, P) + 4.0 * c.M * inner(P, dP),
        d.M * inner(P, leg) + c.M * (inner(dP, leg) + inner(P, dleg)),
        d.M * inner(P, B) + c.M * (inner(dP, B) + inner(P, dB)),
        d.I + d.M * (inner(A, A) + inner(H, H)) + 2.0 * c.M * (inner(A, dA) + inner(H, dH)),
        d.M * inner(H, B) + c.M * (inner(dH, B) + inner(H, dB)),
        d.I + d.M * inner(B, B) + 2.0 * c.M * inner(B, dB),
    )


@kernel
def bias_tangent(vectors, changes, rates, rate_changes, c, d):
    """Changes of the centripetal and gravity terms (φ, α, β)."""
    foot, A, H, B = vectors
    dfoot, dA, dH, dB = changes
    u1, u2, u3 = rates
    s1, s2, s3 = u1**2, u2**2, u3**2
    ds1, ds2, ds3 = (
        2.0 * u1 * rate_changes[0],
        2.0 * u2 * rate_changes[1],
        2.0 * u3 * rate_changes[2],
    )
    P, dP = c.R + foot, d.R + dfoot
    ankle = c.g - foot * s1
    dankle = d.g - dfoot * s1 - foot * ds1
    a_A, da_A = ankle - A * s2, dankle - dA * s2 - A * ds2
    a_B = ankle - H * s2 - B * s3
    da_B = dankle - dH * s2 - H * ds2 - dB * s3 - B * ds3
    both, dboth = a_A + a_B, da_A + da_B
    alpha = turned(A, a_A) + turned(H, a_B)
    dalpha = turned(dA, a_A) + turned(A, da_A) + turned(dH, a_B) + turned(H, da_B)
    return (
        d.M * turned(P, both) + c.M * (turned(dP, both) + turned(P, dboth)),
        d.M * alpha + c.M * dalpha,
        d.M * turned(B, a_B) + c.M * (turned(dB, a_B) + turned(B, da_B)),
    )


@kernel
def motor_torque_tangent(ankle_rate, rate_change, stall_torque, torque_change, c, d):
    """Change of T_stall (1 − ω/ω_noload)."""
    sign = 1.0 if c.as_published else -1.0
    share = sign * ankle_rate / c.no_load_speed
    share_change = (sign * rate_change - share * d.no_load_speed) / c.no_load_speed
    return torque_change * (1.0 - share) - stall_torque * share_change


@kernel
def swing_foot_tangent(y, t, c, d):
    """Change of the swing foot's centre from the stance foot's."""
    foot, stance = direction(y[0]), direction(y[1])
    swing, swing_foot = direction(y[2]), direction(y[2] - c.lock)
    turn = foot * t[0] + swing_foot * (t[2] - d.lock)
    legs = stance * t[1] + swing * t[2]
    return d.D * (foot + swing_foot) + d.L * (stance + swing) + times_i(c.D * turn + c.L * legs)


@kernel
def momenta_before_tangent(y, t, vectors, changes, contact, c, d):
    """Changes of the two momenta just before a heel strike (`contact`: the new point)."""
    foot, A, H, B = vectors
    dfoot, dA, dH, dB = changes
    P, dP = c.R + foot, d.R + dfoot
    contact_change = swing_foot_tangent(y, t, c, d)
    if c.as_published:
        reach = d.L * math.sin(y[2]) + c.L * math.cos(y[2]) * t[2]
        contact_change -= complex(0.0, 2.0 * reach)
    v_A = P * y[3] + A * y[4]
    dv_A = dP * y[3] + P * t[3] + dA * y[4] + A * t[4]
    v_B = P * y[3] + H * y[4] + B * y[5]
    dv_B = dP * y[3] + P * t[3] + dH * y[4] + H * t[4] + dB * y[5] + B * t[5]
    arm_A, arm_B = P + A - contact, P + H + B - contact
    darm_A, darm_B = dP + dA - contact_change, dP + dH + dB - contact_change
    orbital = inner(arm_A, v_A) + inner(arm_B, v_B)
    dorbital = inner(darm_A, v_A) + inner(arm_A, dv_A) + inner(darm_B, v_B) + inner(arm_B, dv_B)
    walker = d.I * (y[4] + y[5]) + c.I * (t[4] + t[5]) + d.M * orbital + c.M * dorbital
    leg, dleg = A - H, dA - dH
    trailing = d.I * y[4] + c.I * t[4] + d.M * inner(leg, v_A)
    return walker, trailing + c.M * (inner(dleg, v_A) + inner(leg, dv_A))
