"""What strides give: one as numbers, N as arrays."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.model.phases import Outcome
from powered_walker_env.model.state import PostStrikeState
from powered_walker_env.simulation import record
from powered_walker_env.simulation.arguments import Array

_OUTCOMES = tuple(Outcome)


class Final(NamedTuple):
    """The walker where a stride ended, before any heel strike; relative angles."""

    q: tuple[float, float, float]  # rad: foot to vertical, ankle, hip
    u: tuple[float, float, float]  # rad/s
    knee: tuple[float, float]  # rad, rad/s: flexion of the swing knee; 0 if it is straight


@dataclass(frozen=True)
class Stride:
    """One stride and how it ended."""

    state: PostStrikeState  # after the heel strike; NaN after a fall
    final: Final  # at the end, whatever happened
    outcome: Outcome
    duration: float  # s
    step_length: float  # m, travel of the contact point (rolling included); 0 after a fall
    energy_in: float  # J, net work of motor, hip or push
    positive_work: float  # J, its positive part
    energy_lost: float  # J, at the heel strike and at the ankle's stop; below 0 only for a push
    # at once with the strike, see `ToeOffAtStrike`
    min_clearance: float  # m, lowest of the swing foot once the legs have passed, its ground
    # at 0: 0 is a clean step, less is scuffing; NaN if they did not pass
    electrical_energy: float  # J, voltage times current of the ankle motor: ω_noload ∫τ dt


def stride_of(row: Array) -> Stride:
    """The stride in a row of the kernel's results."""
    # The fields of `record.Result` in order.
    (
        stance, swing, stance_rate, swing_rate, phi, alpha, beta, dphi, dalpha, dbeta,
        theta, dtheta, duration, step_length, energy_in, positive_work, energy_lost,
        min_clearance, electrical_energy, outcome,
    ) = row.tolist()  # fmt: skip
    found = object.__new__(Stride)  # whose own way, field by field, takes as long as all of this
    found.__dict__.update(
        state=PostStrikeState(stance, swing, stance_rate, swing_rate),
        final=Final(
            (phi, alpha - phi, theta - alpha),
            (dphi, dalpha - dphi, dtheta - dalpha),
            (beta - theta, dbeta - dtheta),
        ),
        outcome=_OUTCOMES[int(outcome)],
        duration=duration,
        step_length=step_length,
        energy_in=energy_in,
        positive_work=positive_work,
        energy_lost=energy_lost,
        min_clearance=min_clearance,
        electrical_energy=electrical_energy,
    )
    return found


@dataclass(frozen=True, eq=False)
class StrideBatch:
    """N strides as arrays; the fields are those of `Stride`."""

    outcome: NDArray[np.int64]  # (N,), values of `Outcome`
    results: Array = field(repr=False)  # (N, record.RESULTS): the kernel's rows

    def __repr__(self) -> str:
        return f"StrideBatch({len(self.outcome)} strides, {int(self.walked.sum())} walked)"

    @property
    def state(self) -> Array:
        """(N, 4) after the heel strikes; NaN after a fall."""
        return self.results[:, record.STATE]

    @property
    def final(self) -> Array:
        """(N, 6) (φ, α, β) and their rates at the ends, before any heel strike; β is the shank's
        where the knee is bent."""
        return self.results[:, record.FINAL]

    @property
    def final_q(self) -> Array:
        """(N, 3) rad, relative angles at the ends, before any heel strike."""
        return self._motion[0]

    @property
    def final_u(self) -> Array:
        """(N, 3) rad/s, their rates."""
        return self._motion[1]

    @property
    def final_knee(self) -> Array:
        """(N, 2) rad and rad/s, flexion of the swing knee at the ends; 0 if it is straight."""
        return self._motion[2]

    @property
    def _motion(self) -> tuple[Array, Array, Array]:
        return joint_motion(self.final, self.results[:, record.FINAL_THIGH])

    @property
    def walked(self) -> NDArray[np.bool_]:
        """(N,) which strides ended in a heel strike."""
        return self.outcome == int(Outcome.WALKED)

    @property
    def duration(self) -> Array:
        """(N,) s."""
        return self.results[:, record.DURATION]

    @property
    def step_length(self) -> Array:
        """(N,) m."""
        return self.results[:, record.STEP_LENGTH]

    @property
    def energy_in(self) -> Array:
        """(N,) J."""
        return self.results[:, record.ENERGY_IN]

    @property
    def positive_work(self) -> Array:
        """(N,) J."""
        return self.results[:, record.POSITIVE_WORK]

    @property
    def energy_lost(self) -> Array:
        """(N,) J."""
        return self.results[:, record.ENERGY_LOST]

    @property
    def min_clearance(self) -> Array:
        """(N,) m."""
        return self.results[:, record.MIN_CLEARANCE]

    @property
    def electrical_energy(self) -> Array:
        """(N,) J."""
        return self.results[:, record.ELECTRICAL_ENERGY]


def joint_motion(pose: Array, thigh: Array) -> tuple[Array, Array, Array]:
    """Relative angles (q1, q2, q3), their rates, and the swing knee's flexion with its rate.

    Args:
        pose: (..., 6) φ, α, β and their rates; thigh: (..., 2) θ and its rate.
    """
    leg = np.stack([pose[..., 2], pose[..., 5]], axis=-1) - thigh
    absolute = pose.copy()
    absolute[..., 2], absolute[..., 5] = thigh[..., 0], thigh[..., 1]
    absolute[..., 1:3] -= pose[..., :2]
    absolute[..., 4:6] -= pose[..., 3:5]
    return absolute[..., :3], absolute[..., 3:], leg
