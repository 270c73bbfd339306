"""Actuation: the motor's steady torque–speed line (Camp 1997, section 5 and figure 3)."""

from __future__ import annotations

from powered_walker_env.compilation import kernel
from powered_walker_env.phases import Joints, Torque
from powered_walker_env.physics.swing import free_accelerations, locked_accelerations

MOTOR = int(Torque.MOTOR)
LOCKED = int(Joints.ANKLE_LOCKED)


@kernel
def motor_torque(ankle_rate, stall_torque, c):
    """τ = T_stall (1 − ω/ω_noload), N m, with ω = −u2 the speed of extension.

    Extension makes q2 fall, so ω = −u2 and the torque falls with speed. The listing
    (`pow_qddt.m`) takes ω = u2: its motor pushes harder the faster it turns.
    """
    speed = ankle_rate if c.as_published else -ankle_rate
    return stall_torque * (1.0 - speed / c.no_load_speed)


@kernel
def ankle_torque(torque, ankle_rate, stall_torque, c):
    """The torque extending the stance ankle in a phase whose `Torque` is given, N m."""
    return motor_torque(ankle_rate, stall_torque, c) if torque == MOTOR else 0.0


@kernel
def ankle_power(torque, y, stall_torque, c):
    """Power the ankle torque puts into the walker, W: τ(φ' − α')."""
    ankle_rate = y[4] - y[3]
    return -ankle_rate * ankle_torque(torque, ankle_rate, stall_torque, c)


@kernel
def flow(joints, torque, y, stall_torque, c, dy):
    """Write the time derivative of y = (φ, α, β, φ', α', β') in one phase into `dy`."""
    dy[0], dy[1], dy[2] = y[3], y[4], y[5]
    if joints == LOCKED:
        ddalpha, ddbeta = locked_accelerations(y[0], y[1], y[2], y[4], y[5], c)
        dy[3], dy[4], dy[5] = ddalpha, ddalpha, ddbeta
    else:
        tau = ankle_torque(torque, y[4] - y[3], stall_torque, c)
        dy[3], dy[4], dy[5] = free_accelerations(y[0], y[1], y[2], y[3], y[4], y[5], tau, c)
