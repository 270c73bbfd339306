"""Ground force: what the floor and the stop bear along a stride.

From the accelerations of both centres of mass (the foot is massless), with P the vector
from the contact point to the stance ankle,

    F = M (a_A + a_B) + 2 M g,   τ = ⟨iP, F⟩ the torque at the ankle,

and at heel strike the impulse from the jump of their velocities. Vectors are complex as
in `physics`: up (normal to the floor) + i·forward.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.model.mechanics.actuation import accelerations_at, ankle_torque, drive
from powered_walker_env.model.mechanics.chain import Pose, cross, pose_of
from powered_walker_env.model.mechanics.constants import Chain, Constants, chains_of, constants_of
from powered_walker_env.model.mechanics.heel_strike import heel_strike
from powered_walker_env.model.mechanics.push_off import push_off
from powered_walker_env.model.phases import Cycle, Joints, Outcome, Reset
from powered_walker_env.model.powering import STRENGTH, AnyControl, Policy
from powered_walker_env.model.state import PostStrikeState, check_state
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.maps import StrideMap
from powered_walker_env.poincare.tolerances import CONTACT_RTOL
from powered_walker_env.simulation import record
from powered_walker_env.simulation.strides import Array
from powered_walker_env.simulation.trajectory import LoggedStride, log_stride

SAMPLES = 500  # per √(L/g) of time: extremes are right to about the square of 1/500

PUSHES = {Reset.PUSH_BEFORE, Reset.PUSH_WITH, Reset.PUSH_AFTER}

ComplexArray = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class GroundForce:
    """The floor's force on the stance foot along one stride, both sides of events included."""

    t: Array  # (n,) s
    normal: Array  # (n,) N
    tangential: Array  # (n,) N, forward positive
    ankle_torque: Array  # (n,) N m, extending: the motor's, and the stop's when the foot is locked
    phase: NDArray[np.int64]  # (n,) index in the walker's cycle
    impulse: tuple[float, float]  # N s, normal and forward, on the new foot at heel strike; NaN
    # after a fall
    push: tuple[float, float]  # N s, the same of a push-off, on the old foot

    def __repr__(self) -> str:
        least, most = self.normal.min(), self.normal.max()
        return f"GroundForce({self.t[-1]:.4g} s, normal {least:.4g} to {most:.4g} N)"


def ground_force(
    params: WalkerParams,
    control: AnyControl | Policy | None,
    state: PostStrikeState | Sequence[float],
) -> GroundForce:
    """The ground force along one stride from `state`, finely sampled.

    Raises:
        ValueError: a bad argument.
    """
    walked = next(logged_strides(params, control, state, 1))
    logged = walked.logged
    force, ankle, _ = forces(walked, params)
    jump, push = impulse_of(walked, params), push_of(walked)
    return GroundForce(
        t=logged.log[:, 0].copy(),
        normal=force.real.copy(),
        tangential=force.imag.copy(),
        ankle_torque=ankle,
        phase=logged.log[:, 7].astype(np.int64),
        impulse=(jump.real, jump.imag),
        push=(push.real, push.imag),
    )


class WalkedStride(NamedTuple):
    """A logged stride, and what powered it."""

    logged: LoggedStride
    cycle: Cycle
    strength: float  # of what acts: N m, or N s of a push

    @property
    def push(self) -> float:
        """The impulse along the trailing leg at its end, N s."""
        resets = {way.reset for way in self.cycle[-1].exits}
        return self.strength if resets & PUSHES else 0.0

    def rows(self, joints: Joints) -> NDArray[np.bool_]:
        """(n,) the samples with the ankle locked, or free."""
        there = np.array([phase.joints == joints for phase in self.cycle])
        return there[self.logged.log[:, 7].astype(np.int64)]

    @property
    def last(self) -> Pose:
        """The pose just before its end."""
        return pose_of(*self.logged.log[-1, record.LOG_POSE])

    def struck(self, c: Constants, free: Chain) -> Pose:
        """The pose after heel strike and push."""
        if self.push == 0.0:
            return heel_strike(self.last, free, c)
        return push_off(self.last, self.push, free, c)


def logged_strides(
    params: WalkerParams,
    control: AnyControl | Policy | None,
    state: PostStrikeState | Sequence[float],
    strides: int,
) -> Iterator[WalkedStride]:
    """Logged strides until a fall."""
    stride_map, here = StrideMap(params, control), check_state(state)
    interval = math.sqrt(params.leg_length / params.gravity) / SAMPLES
    for _ in range(strides):
        row = stride_map.controls(np.array([here]))[0]
        chosen = stride_map.scheme.control_of(row)
        logged = log_stride(here, chosen, params, 0.0, CONTACT_RTOL, interval)
        yield WalkedStride(logged, stride_map.cycle, float(row[STRENGTH]))
        if logged.outcome != Outcome.WALKED:
            return
        here = PostStrikeState(*logged.result[record.STATE].tolist())


def forces(walked: WalkedStride, params: WalkerParams) -> tuple[ComplexArray, Array, Array]:
    """Along a stride: ground force, N, torque at the ankle and the motor's part, N m; (n,)."""
    log, c, chains = walked.logged.log, constants_of(params), chains_of(params)
    force, torque, motor = np.empty(len(log), complex), np.empty(len(log)), np.empty(len(log))
    for i, row in enumerate(log):
        pose, phase = pose_of(*row[record.LOG_POSE]), walked.cycle[int(row[record.LOG_PHASE])]
        acting = drive(phase.torque, walked.strength)
        free = phase.joints == Joints.ANKLE_FREE
        ddphi, ddalpha, ddbeta = accelerations_at(pose, free, acting, chains, c)
        foot, (P, A, H, B) = c.D * pose.foot, _arms(pose, c)
        ankle = 1j * P * ddphi - foot * pose.dphi**2
        a_A = ankle + (1j * ddalpha - pose.dalpha**2) * A
        a_B = ankle + (1j * ddalpha - pose.dalpha**2) * H + (1j * ddbeta - pose.dbeta**2) * B
        force[i] = c.M * (a_A + a_B + 2.0 * c.g)
        torque[i] = cross(P, force[i])
        motor[i] = ankle_torque(pose.dalpha - pose.dphi, acting, c)
    return force, torque, motor


def _arms(pose: Pose, c: Constants) -> tuple[complex, complex, complex, complex]:
    """From contact to ankle, ankle to the stance leg's mass and to the hip, hip to the other's."""
    stance = pose.stance
    return (
        c.R + c.D * pose.foot,
        c.ankle_to_com * stance,
        c.L * stance,
        c.reaction * c.hip_to_com * pose.swing,
    )


def _momentum(pose: Pose, c: Constants) -> complex:
    """Linear momentum of the walker, kg m/s."""
    P, A, H, B = _arms(pose, c)
    return complex(1j * c.M * (2.0 * P * pose.dphi + (A + H) * pose.dalpha + B * pose.dbeta))


def impulse_of(walked: WalkedStride, params: WalkerParams) -> complex:
    """The floor's impulse on the new foot at heel strike, N s.

    The jump of the momentum, but for what a push along the trailing leg gives of it.
    """
    logged = walked.logged
    if logged.outcome != Outcome.WALKED:
        return complex(math.nan, math.nan)
    c, (_, free) = constants_of(params), chains_of(params)
    jump = _momentum(walked.struck(c, free), c) - _momentum(walked.last, c)
    return jump - push_of(walked)


def push_of(walked: WalkedStride) -> complex:
    """The floor's impulse on the old foot in a push-off, N s, along the trailing leg."""
    if walked.logged.outcome != Outcome.WALKED:
        return complex(math.nan, math.nan)
    return cmath.rect(walked.push, walked.logged.log[-1, 2])


def trailing_foot(walked: WalkedStride, params: WalkerParams) -> tuple[float, float]:
    """Upward velocities of the old ankle and of the old foot just after heel strike, m/s."""
    if walked.logged.outcome != Outcome.WALKED:
        return math.nan, math.nan
    c, (_, free) = constants_of(params), chains_of(params)
    before, pose = walked.last, walked.struck(c, free)
    P, _, H, _ = _arms(pose, c)
    ankle = 1j * (P * pose.dphi + H * pose.dalpha + c.L * pose.swing * pose.dbeta)
    centre = ankle - 1j * c.D * before.foot * pose.dbeta  # turning with the leg
    return float(ankle.real), float(centre.real)
