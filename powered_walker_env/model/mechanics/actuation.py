"""Actuation: the motor's steady torque–speed line (Camp 1997, section 5 and figure 3), the hip's
constant torque, and how the state of a chain flows under them."""

from __future__ import annotations

from typing import Any, NamedTuple

from powered_walker_env.compiled.decorators import formula, small
from powered_walker_env.compiled.lanes import where
from powered_walker_env.model.mechanics.chain import Pose, accelerations
from powered_walker_env.model.mechanics.constants import Constants
from powered_walker_env.model.mechanics.links import Chains
from powered_walker_env.model.phases import Joints, Torque


class Drive(NamedTuple):
    """What acts in a phase."""

    stall: Any  # N m, of the ankle's motor at rest, extending
    pull: Any  # N m, at the hip, on the swing leg, forward negative as angles of its direction are


def drive(torque: Torque, strength: float) -> Drive:
    """What acts in a phase with a control of this strength."""
    return Drive(
        strength if torque == Torque.MOTOR else 0.0, -strength if torque == Torque.HIP else 0.0
    )


@small
def motor_line(u2, acting, c):
    """The motor's torque before its limit, N m, at the rate u2 = α' − φ' of the ankle.

    τ = T_stall (1 − ω/ω_noload) with ω = −u2 the speed of extension, so that the torque falls
    with speed. (The listing's has the other sign: `constants.droop`.)
    """
    return acting.stall * (1.0 + c.droop * u2)


@formula
def ankle_torque(u2, acting, c):
    """The motor's torque within its limit, N m."""
    line, limit = motor_line(u2, acting, c), c.torque_limit
    line = where(line < limit, line, limit)
    return where(line > -limit, line, -limit)


@small
def power(pose, acting, c):
    """Power that the torques put into the walker, W: −τ u2 and, at the hip, τ(θ' − α')."""
    u2 = pose.dalpha - pose.dphi
    return c.reaction * acting.pull * (pose.dtheta - pose.dalpha) - u2 * ankle_torque(u2, acting, c)


@formula
def flow(y, acting, chain, c):
    """The time derivative of a chain's state: three angles and their rates."""
    u2 = chain.ankle * (y[4] - y[3])
    d1, d2, d3 = accelerations(y, ankle_torque(u2, acting, c), acting.pull, chain, c)
    return y[3], y[4], y[5], d1, d2, d3


class Accelerations(NamedTuple):
    """Of one walker at a pose, rad/s²."""

    phi: float  # foot
    alpha: float  # stance leg
    theta: float  # thigh of the swing leg
    beta: float  # swing leg, or its shank


def accelerations_at(
    pose: Pose, joints: Joints, acting: Drive, chains: Chains, c: Constants
) -> Accelerations:
    """Angular accelerations of one walker at a pose, in Python."""
    second = {
        Joints.ANKLE_LOCKED: (0.0, 0.0),
        Joints.ANKLE_FREE: (pose.alpha, pose.dalpha),
        Joints.KNEE_FREE: (pose.theta, pose.dtheta),
    }[joints]
    y = (pose.phi, second[0], pose.beta, pose.dphi, second[1], pose.dbeta)
    first, middle, last = flow(y, acting, chains[joints], c)[3:]
    return Accelerations(
        first,
        middle if joints == Joints.ANKLE_FREE else first,
        middle if joints == Joints.KNEE_FREE else last,
        last,
    )
