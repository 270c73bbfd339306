"""Ground force: what the floor and the stop bear along a stride.

From the accelerations of both centres of mass (the foot is massless), with P the vector
from the contact point to the stance ankle,

    F = M (a_A + a_B) + 2 M g,   τ = ⟨iP, F⟩ the torque at the ankle,

and at heel strike the impulse from the jump of their velocities. Vectors are complex as
in `physics`: up (normal to the floor) + i·forward.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from powered_walker_env import record
from powered_walker_env.params import PostStrikeState, WalkerParams, check_state
from powered_walker_env.phases import Cycle, Joints, Outcome
from powered_walker_env.physics.actuation import drive, flow
from powered_walker_env.physics.constants import Constants, constants_of
from powered_walker_env.physics.heel_strike import heel_strike
from powered_walker_env.physics.swing import turned, vectors
from powered_walker_env.poincare.maps import Policy, StrideMap
from powered_walker_env.schemes import AnyControl
from powered_walker_env.stride import Array
from powered_walker_env.trajectory import LoggedStride, log_stride

SAMPLES = 500  # per √(L/g) of time: extremes are right to about the square of 1/500
CONTACT_RTOL = 1e-11  # of the strides examined

ComplexArray = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class GroundForce:
    """The floor's force on the stance foot along one stride, both sides of events included."""

    t: Array  # (n,) s
    normal: Array  # (n,) N
    tangential: Array  # (n,) N, forward positive
    ankle_torque: Array  # (n,) N m, extending: the motor's, or the stop's when the foot is locked
    phase: NDArray[np.int64]  # (n,) index in the walker's cycle
    impulse: tuple[float, float]  # N s, normal and forward, at heel strike; NaN after a fall


def ground_force(
    params: WalkerParams,
    control: AnyControl | Policy | None,
    state: PostStrikeState | Sequence[float],
) -> GroundForce:
    """The ground force along one stride from `state`, finely sampled.

    Raises:
        ValueError: a bad argument.
    """
    logged, cycle, torque = next(logged_strides(params, control, state, 1))
    c = constants_of(params)
    force, ankle = forces(logged.log, cycle, torque, c)
    jump = impulse_of(logged, c)
    return GroundForce(
        t=logged.log[:, 0].copy(),
        normal=force.real.copy(),
        tangential=force.imag.copy(),
        ankle_torque=ankle,
        phase=logged.log[:, 7].astype(np.int64),
        impulse=(jump.real, jump.imag),
    )


def logged_strides(
    params: WalkerParams,
    control: AnyControl | Policy | None,
    state: PostStrikeState | Sequence[float],
    strides: int,
) -> Iterator[tuple[LoggedStride, Cycle, float]]:
    """Logged strides, each with its cycle and stall torque, until a fall."""
    stride_map, here = StrideMap(params, control), check_state(state)
    interval = math.sqrt(params.leg_length / params.gravity) / SAMPLES
    for _ in range(strides):
        chosen = None
        if control is not None:
            chosen = stride_map.scheme.control_of(stride_map.controls(np.array([here]))[0])
        logged = log_stride(here, chosen, params, 0.0, CONTACT_RTOL, interval)
        yield logged, stride_map.cycle, 0.0 if chosen is None else chosen.stall_torque
        if logged.outcome != Outcome.WALKED:
            return
        here = PostStrikeState(*logged.result[record.STATE].tolist())


def forces(
    log: Array, cycle: Cycle, stall_torque: float, c: Constants
) -> tuple[ComplexArray, Array]:
    """Ground force (n,), N, and torque at the ankle (n,), N m, along a logged stride."""
    force, torque = np.empty(len(log), complex), np.empty(len(log))
    for i, row in enumerate(log):
        y, phase = row[1:7], cycle[int(row[7])]
        locked, acting = phase.joints == Joints.ANKLE_LOCKED, drive(phase.torque, stall_torque, c)
        _, _, _, ddphi, ddalpha, ddbeta = flow(locked, y, acting, c)
        foot, A, H, B = vectors(y[0], y[1], y[2], c)
        P, B = c.R + foot, c.reaction * B
        ankle = 1j * P * ddphi - foot * y[3] ** 2
        a_A = ankle + (1j * ddalpha - y[4] ** 2) * A
        a_B = ankle + (1j * ddalpha - y[4] ** 2) * H + (1j * ddbeta - y[5] ** 2) * B
        force[i] = c.M * (a_A + a_B + 2.0 * c.g)
        torque[i] = turned(P, force[i])
    return force, torque


def _momentum(y: Array, c: Constants) -> complex:
    """Linear momentum of the walker, kg m/s."""
    foot, A, H, B = vectors(y[0], y[1], y[2], c)
    ankle = 1j * (c.R + foot) * y[3]
    return complex(c.M * (2.0 * ankle + 1j * ((A + H) * y[4] + c.reaction * B * y[5])))


def impulse_of(logged: LoggedStride, c: Constants) -> complex:
    """The floor's impulse at heel strike, N s: the jump of the momentum."""
    if logged.outcome != Outcome.WALKED:
        return complex(math.nan, math.nan)
    before = logged.log[-1, 1:7]
    return _momentum(np.array(heel_strike(*before, c)), c) - _momentum(before, c)


def trailing_foot(logged: LoggedStride, c: Constants) -> tuple[float, float]:
    """Upward velocities of the old ankle and of the old foot just after heel strike, m/s."""
    if logged.outcome != Outcome.WALKED:
        return math.nan, math.nan
    before = logged.log[-1, 1:7]
    y = np.array(heel_strike(*before, c))
    foot, _, H, _ = vectors(y[0], y[1], y[2], c)
    hip = 1j * ((c.R + foot) * y[3] + H * y[4])
    ankle = hip + 1j * c.L * np.exp(1j * y[2]) * y[5]
    centre = ankle - 1j * c.D * np.exp(1j * before[0]) * y[5]  # turning with the leg
    return float(ankle.real), float(centre.real)
