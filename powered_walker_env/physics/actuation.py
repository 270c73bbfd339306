"""Actuation: the motor's steady torque–speed line (Camp 1997, section 5 and figure 3)."""

from __future__ import annotations

from typing import NamedTuple

from powered_walker_env.compilation import kernel
from powered_walker_env.phases import Torque
from powered_walker_env.physics.swing import accelerations

MOTOR = int(Torque.MOTOR)


class Drive(NamedTuple):
    """The torque extending the stance ankle in one phase: strength·(1 + slope·u2), N m.

    u2 = α' − φ' is the rate of the ankle angle; extension makes q2 fall.
    """

    strength: float  # N m, at rest
    slope: float  # s/rad
    share: float  # of a change of the stall torque that reaches the strength: 1 or 0


@kernel
def drive(torque, stall_torque, c):
    """What acts in a phase whose `Torque` is given.

    The motor: τ = T_stall (1 − ω/ω_noload) with ω = −u2 the speed of extension, so that
    the torque falls with speed. The listing (`pow_qddt.m`) takes ω = u2: its motor
    pushes harder the faster it turns.
    """
    if torque == MOTOR:
        slope = 1.0 / c.no_load_speed
        return Drive(stall_torque, -slope if c.as_published else slope, 1.0)
    return Drive(0.0, 0.0, 0.0)


@kernel
def ankle_torque(y, acting):
    """The torque of a `Drive` at y = (φ, α, β and rates), N m."""
    return acting.strength * (1.0 + acting.slope * (y[4] - y[3]))


@kernel
def ankle_power(y, acting):
    """Power the ankle torque puts into the walker, W: τ(φ' − α')."""
    return (y[3] - y[4]) * ankle_torque(y, acting)


@kernel
def flow(locked, y, acting, c):
    """The time derivative of y = (φ, α, β, φ', α', β') in one phase.

    Args:
        locked: whether the ankle is; acting: the `Drive`.
    """
    ddphi, ddalpha, ddbeta = accelerations(locked, y, ankle_torque(y, acting), c)
    return y[3], y[4], y[5], ddphi, ddalpha, ddbeta
