"""Actuation: the motor's steady torque–speed line (Camp 1997, section 5 and figure 3), the hip's
constant torque, and the stop of the ankle."""

from __future__ import annotations

from typing import NamedTuple

from powered_walker_env.compiled.decorators import kernel
from powered_walker_env.compiled.lanes import where
from powered_walker_env.model.mechanics.swing import (
    accelerations,
    bias,
    mass_matrix,
    vectors,
)
from powered_walker_env.model.phases import Torque

MOTOR, HIP = int(Torque.MOTOR), int(Torque.HIP)


class Drive(NamedTuple):
    """What acts in one phase: strength·(1 + slope·u2) at the stance ankle, and a hip torque.

    u2 = α' − φ' is the rate of the ankle angle; extension makes q2 fall.
    """

    strength: float  # N m, extending the ankle at rest
    slope: float  # s/rad
    share: float  # of a change of the control's strength that reaches the ankle: 1 or 0
    hip: float  # N m, on the swing leg, forward negative as angles of its direction are
    hip_share: float  # of such a change that reaches the hip: −1 or 0


@kernel
def drive(torque, strength, c):
    """What acts in a phase whose `Torque` is given; `strength` is the control's, N m.

    The motor: τ = T_stall (1 − ω/ω_noload) with ω = −u2 the speed of extension, so that
    the torque falls with speed. The listing (`pow_qddt.m`) takes ω = u2: its motor
    pushes harder the faster it turns. The hip's torque pulls the swing leg forward.
    """
    slope = 1.0 / c.no_load_speed
    if torque == MOTOR:
        return Drive(strength, -slope if c.as_published else slope, 1.0, 0.0, 0.0)
    if torque == HIP:
        return Drive(0.0, 0.0, 0.0, -strength, -1.0)
    return Drive(0.0, 0.0, 0.0, 0.0, 0.0)


@kernel
def motor_line(y, acting):
    """The motor's torque before its limit, N m."""
    return acting.strength * (1.0 + acting.slope * (y[4] - y[3]))


@kernel
def ankle_torque(y, acting, c):
    """The torque of a `Drive` at y = (φ, α, β and rates), N m, within the motor's limit."""
    line, limit = motor_line(y, acting), c.torque_limit
    line = where(line < limit, line, limit)
    return where(line > -limit, line, -limit)


@kernel
def power(y, acting, c):
    """Power that the torques put into the walker, W: τ(φ' − α') and, at the hip, τ(β' − α')."""
    hip = c.reaction * acting.hip * (y[5] - y[4])
    return (y[3] - y[4]) * ankle_torque(y, acting, c) + hip


@kernel
def flow(locked, y, acting, c):
    """The time derivative of y = (φ, α, β, φ', α', β') in one phase.

    Args:
        locked: whether the ankle is; acting: the `Drive`.
    """
    torque = ankle_torque(y, acting, c)
    ddphi, ddalpha, ddbeta = accelerations(locked, y, torque, acting.hip, c)
    return y[3], y[4], y[5], ddphi, ddalpha, ddbeta


@kernel
def holding_torque(y, slope, acting, c):
    """What the stop must give beside the motor to keep the ankle locked, over MgL.

    From the foot's own equation, the row φ of mass matrix · accelerations + bias = τ.
    Args:
        slope: the time derivative of y in the locked phase.
    """
    foot, A, H, B = vectors(y[0], y[1], y[2], c)
    m11, m12, m13, _, _, _ = mass_matrix(foot, A, H, B, c)
    b1, _, _ = bias(foot, A, H, B, y[3], y[4], y[5], c)
    needed = m11 * slope[3] + m12 * slope[4] + c.reaction * m13 * slope[5] + b1
    return (needed - ankle_torque(y, acting, c)) / stop_unit(c)


@kernel
def stop_unit(c):
    """MgL, N m; for gravity its component along the floor's normal."""
    return c.M * c.L * c.g.real
