"""Tangents: how the mechanics changes to first order along a direction.

A direction moves the state (t_φ, t_α, t_β and the rates' t_φ', …), the stall torque and
the walker itself (`d`, a `Constants` of derivatives) at once. Every function here is
the derivative, by the product rule, of the one of the same name in `swing.py`,
`actuation.py`, `ground.py` or `heel_strike.py`; d e^{iθ} = i e^{iθ} dθ.
"""

from __future__ import annotations

import math

from powered_walker_env.compilation import internal
from powered_walker_env.lanes import where
from powered_walker_env.physics.constants import Constants
from powered_walker_env.physics.heel_strike import trailing_com
from powered_walker_env.physics.swing import direction, inner, turned


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
def ankle_torque_tangent(y, t, acting, torque_change, c, d):
    """Change of T_stall (1 − ω/ω_noload); `torque_change` is that of the stall torque."""
    rate, rate_change = y[4] - y[3], t[4] - t[3]
    slope_change = -acting.slope * d.no_load_speed / c.no_load_speed
    line_change = acting.slope * rate_change + slope_change * rate
    line = 1.0 + acting.slope * rate
    return acting.share * torque_change * line + acting.strength * line_change


@internal
def hip_torque_tangent(y, t, c, d):
    """Change of −k(q3 − π)."""
    return -d.hip_stiffness * (y[2] - y[1] - math.pi) - c.hip_stiffness * (t[2] - t[1])


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
    com = trailing_com(H, y[1], c)
    dcom = dH - d.hip_to_com * direction(y[1]) - times_i(c.hip_to_com * direction(y[1])) * t[1]
    v, dv = P * y[3] + com * y[4], dP * y[3] + P * t[3] + dcom * y[4] + com * t[4]
    leg, dleg = com - H, dcom - dH
    trailing = d.swing_inertia * y[4] + c.swing_inertia * t[4] + d.swing_mass * inner(leg, v)
    return walker, trailing + c.swing_mass * (inner(dleg, v) + inner(leg, dv))
