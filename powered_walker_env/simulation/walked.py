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
        stance, swing, stance_rate, swing_rate, phi, alpha, beta, dphi, dalpha, dbeta, duration,
        step_length, energy_in, positive_work, energy_lost, min_clearance, electrical_energy,
        outcome,
    ) = row.tolist()  # fmt: skip
    found = object.__new__(Stride)  # whose own way, field by field, takes as long as all of this
    found.__dict__.update(
        state=PostStrikeState(stance, swing, stance_rate, swing_rate),
        final=Final((phi, alpha - phi, beta - alpha), (dphi, dalpha - dphi, dbeta - dalpha)),
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
        """(N, 6) (φ, α, β) and their rates at the ends, before any heel strike."""
        return self.results[:, record.FINAL]

    @property
    def final_q(self) -> Array:
        """(N, 3) rad, relative angles at the ends, before any heel strike."""
        return relative(self.final[:, :3])

    @property
    def final_u(self) -> Array:
        """(N, 3) rad/s, their rates."""
        return relative(self.final[:, 3:])

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


def relative(absolute: Array) -> Array:
    """Relative angles (or rates) from absolute ones: (φ, α, β) to (q1, q2, q3), (..., 3)."""
    return np.concatenate([absolute[..., :1], np.diff(absolute, axis=-1)], axis=-1)
