"""Ground force: what the floor and the stop bear along a stride.

The momentum of a chain of links (`mechanics/chain.py`) is p = Σ i u_k θ_k' + i mR θ_1'; with P the
vector from the contact point to the stance ankle (the foot is massless),

    F = p' + m g,   τ = ⟨iP, F⟩ the torque at the ankle.

At an impact the impulse is the momentum's jump. Vectors are complex: up (normal to the floor)
+ i·forward. (The knees: `knee_torques.py`.)
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.model.knees import encoded
from powered_walker_env.model.mechanics.actuation import (
    Accelerations,
    accelerations_at,
    ankle_torque,
    drive,
)
from powered_walker_env.model.mechanics.chain import Pose, bent, cross, pose_of, second_link
from powered_walker_env.model.mechanics.constants import Constants
from powered_walker_env.model.mechanics.heel_strike import heel_strike
from powered_walker_env.model.mechanics.links import Chain, Chains
from powered_walker_env.model.mechanics.packing import chains_of, constants_of
from powered_walker_env.model.mechanics.push_off import push_off
from powered_walker_env.model.phases import Cycle, Joints, Outcome, Reset
from powered_walker_env.model.powering import STRENGTH, AnyControl, Policy
from powered_walker_env.model.state import PostStrikeState, check_state
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.energy.knee_torques import stance_knee, swing_knee
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
    knee_impulse: tuple[float, float]  # N s, the same of knee strike, on the stance foot; NaN where
    # no knee struck

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
    loads = forces(walked, params)
    jump, push, knee = impulse_of(walked, params), push_of(walked), knee_impulse_of(walked, params)
    return GroundForce(
        t=logged.log[:, 0].copy(),
        normal=loads.force.real.copy(),
        tangential=loads.force.imag.copy(),
        ankle_torque=loads.ankle,
        phase=logged.log[:, record.LOG_PHASE].astype(np.int64),
        impulse=(jump.real, jump.imag),
        push=(push.real, push.imag),
        knee_impulse=(knee.real, knee.imag),
    )


class WalkedStride(NamedTuple):
    """A logged stride, and what powered it."""

    logged: LoggedStride
    cycle: Cycle  # all phases, their twins with the knee free included
    strength: float  # of what acts: N m, or N s of a push

    @property
    def push(self) -> float:
        """The impulse along the trailing leg at its end, N s."""
        resets = {way.reset for phase in self.cycle for way in phase.exits}
        return self.strength if resets & PUSHES else 0.0

    def rows(self, joints: Joints) -> NDArray[np.bool_]:
        """(n,) the samples with these joints free."""
        there = np.array([phase.joints == joints for phase in self.cycle])
        return there[self.logged.log[:, record.LOG_PHASE].astype(np.int64)]

    def poses(self) -> Iterator[Pose]:
        """Of the samples."""
        for row in self.logged.log:
            theta, dtheta = row[record.LOG_THIGH]
            yield bent(pose_of(*row[record.LOG_POSE]), theta, dtheta, cmath.rect(1.0, theta))

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
        yield WalkedStride(logged, encoded(stride_map.cycle).phases, float(row[STRENGTH]))
        if logged.outcome != Outcome.WALKED:
            return
        here = PostStrikeState(*logged.result[record.STATE].tolist())


class Loads(NamedTuple):
    """What floor and joints bear along a stride."""

    force: ComplexArray  # (n,) N, of the floor on the stance foot
    ankle: Array  # (n,) N m, torque at the stance ankle, extending
    motor: Array  # (n,) N m, the motor's part of it
    stance_knee: Array  # (n,) N m, on the shank; the stop that keeps it from bending back pushes
    # forward, positive; NaN of a walker without knees
    swing_knee: Array  # (n,) N m, the same of the swing leg; NaN also while it is free


def forces(walked: WalkedStride, params: WalkerParams) -> Loads:
    """The loads along a stride."""
    log, c, chains = walked.logged.log, constants_of(params), chains_of(params)
    loads = Loads(np.empty(len(log), complex), *np.full((4, len(log)), math.nan))
    for i, (pose, row) in enumerate(zip(walked.poses(), log, strict=True)):
        phase = walked.cycle[int(row[record.LOG_PHASE])]
        acting = drive(phase.torque, walked.strength)
        turning = accelerations_at(pose, phase.joints, acting, chains, c)
        force = _floor_force(pose, turning, phase.joints, chains, c)
        loads.force[i] = force
        loads.ankle[i] = cross(c.R + c.D * pose.foot, force)
        loads.motor[i] = ankle_torque(pose.dalpha - pose.dphi, acting, c)
        if params.knee is not None:
            loads.stance_knee[i] = stance_knee(pose, turning, force, params.knee, c)
            if phase.joints != Joints.KNEE_FREE:
                loads.swing_knee[i] = swing_knee(pose, turning, params.knee, c)
    return loads


def _floor_force(
    pose: Pose, turning: Accelerations, joints: Joints, chains: Chains, c: Constants
) -> complex:
    chain = chains.bent if joints == Joints.KNEE_FREE else chains.free
    _, rate, second = second_link(pose, chain)
    u1, u2, u3 = chain.moment1 * pose.foot, chain.moment2 * second, chain.moment3 * pose.swing
    spin = turning.theta if joints == Joints.KNEE_FREE else turning.alpha
    change = 1j * ((chain.roll + u1) * turning.phi + u2 * spin + c.reaction * u3 * turning.beta)
    change -= u1 * pose.dphi**2 + u2 * rate**2 + c.reaction * u3 * pose.dbeta**2
    return complex(change + 2.0 * c.M * c.g)


def _momentum(pose: Pose, chain: Chain, c: Constants) -> complex:
    """Linear momentum of the walker whose ankle, or whose knee, is free, kg m/s."""
    _, rate, second = second_link(pose, chain)
    rolling = (chain.roll + chain.moment1 * pose.foot) * pose.dphi
    swing = c.reaction * chain.moment3 * pose.swing * pose.dbeta
    return complex(1j * (rolling + chain.moment2 * second * rate + swing))


def impulse_of(walked: WalkedStride, params: WalkerParams) -> complex:
    """The floor's impulse on the new foot at heel strike, N s.

    The jump of the momentum, but for what a push along the trailing leg gives of it.
    """
    logged = walked.logged
    if logged.outcome != Outcome.WALKED:
        return complex(math.nan, math.nan)
    c, free = constants_of(params), chains_of(params).free
    jump = _momentum(walked.struck(c, free), free, c) - _momentum(walked.last, free, c)
    return jump - push_of(walked)


def knee_impulse_of(walked: WalkedStride, params: WalkerParams) -> complex:
    """The floor's impulse on the stance foot at knee strike, N s; NaN if no knee struck."""
    phases = walked.logged.log[:, record.LOG_PHASE].astype(np.int64)
    bent_knee = walked.rows(Joints.KNEE_FREE)
    struck = np.flatnonzero(bent_knee[:-1] & ~bent_knee[1:] & (phases[1:] != phases[:-1]))
    if not len(struck):
        return complex(math.nan, math.nan)
    c, chains, poses = constants_of(params), chains_of(params), list(walked.poses())
    before, after = poses[struck[0]], poses[struck[0] + 1]
    return _momentum(after, chains.free, c) - _momentum(before, chains.bent, c)


def push_of(walked: WalkedStride) -> complex:
    """The floor's impulse on the old foot in a push-off, N s, along the trailing leg."""
    if walked.logged.outcome != Outcome.WALKED:
        return complex(math.nan, math.nan)
    return cmath.rect(walked.push, walked.logged.log[-1, 2])


def trailing_foot(walked: WalkedStride, params: WalkerParams) -> tuple[float, float]:
    """Upward velocities of the old ankle and of the old foot just after heel strike, m/s."""
    if walked.logged.outcome != Outcome.WALKED:
        return math.nan, math.nan
    c, free = constants_of(params), chains_of(params).free
    before, pose = walked.last, walked.struck(c, free)
    P = c.R + c.D * pose.foot  # from the contact point to the ankle
    legs = pose.stance * pose.dalpha + pose.swing * pose.dbeta
    ankle = 1j * (P * pose.dphi + c.L * legs)
    centre = ankle - 1j * c.D * before.foot * pose.dbeta  # turning with the leg
    return float(ankle.real), float(centre.real)
