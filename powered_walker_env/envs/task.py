"""The task, apart from the walker: what one environment asks, as checked numbers.

Deviations are measured in units of `state_scale`: 0.05 rad on both angles, 0.15 and
0.3 rad/s on the rates of stance and swing leg, for a walker with √(g/L) = √10 /s.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from powered_walker_env.envs.disturbances import Disturbance
from powered_walker_env.envs.rewards import Reward, reward_of
from powered_walker_env.model.powering import ANGLE, AnyControl, Scheme, scheme_of
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.simulation.strides import Array

OBSERVATION_LIMIT = 20.0  # deviations beyond are clipped: 1 rad, far outside any basin

#: The numbers of a stride in `info`, and what they are; columns of the table that
#: `stepping.end_strides` fills.
STRIDE_INFO = {
    "duration": "s",
    "step_length": "m, 0 after a fall",
    "step_height": "m, of the ground ahead over the ground under the stance foot",
    "energy_in": "J, net work of motor, hip or push",
    "positive_work": "J, its positive part",
    "energy_lost": "J, at the heel strike",
    "distance": "from the gait after the stride, scaled",
    "reward_stability": "the term that `reward` says",
    "reward_effort": "−`effort_weight` · cost of transport",
    "reward_fall": "what a fall costs",
}
STABILITY = list(STRIDE_INFO).index("reward_stability")
EFFORT = STABILITY + 1


@dataclass(frozen=True, eq=False)
class Task:
    """What one environment asks of its walker."""

    params: WalkerParams
    control: AnyControl  # the nominal one: zero action, the open-loop baseline
    gait: Array  # (period, 4) post-strike states of the nominal cycle
    action_range: tuple[float, ...]  # (k,) at action 1: rad of an angle, fraction of a strength
    disturbance: Disturbance
    reward: str | Reward = "deviation"
    effort_weight: float = 0.0  # reward lost per unit of mechanical cost of transport

    def __post_init__(self) -> None:
        object.__setattr__(self, "reward", reward_of(self.reward))
        if not 0 <= self.effort_weight < math.inf:
            raise ValueError(
                f"effort_weight must be finite and not negative, got {self.effort_weight!r}"
            )
        for i, (column, reach) in enumerate(
            zip(self.scheme.columns, self.action_range, strict=True)
        ):
            self._check_reach(f"action_range[{i}]", column, reach)
        if not self.half_range.any():
            raise ValueError(
                f"control must not be zero, or there is nothing to decide, got {self.control!r}"
            )

    def _check_reach(self, name: str, column: int, reach: float) -> None:
        """Reject an action range that leaves the control's domain."""
        if column != ANGLE:
            if not 0 < reach <= 1:
                raise ValueError(f"{name} must lie in (0, 1], got {reach!r}")
            return
        angle = self.scheme.row(self.control)[ANGLE]
        most = min(angle, 2 * math.pi - angle)
        if not 0 < reach < most:
            raise ValueError(
                f"{name} must lie in (0, {most:.4g}) so that the switch angle stays in "
                f"(0, 2*pi), got {reach!r}"
            )

    @property
    def scheme(self) -> Scheme:
        """What powers the walker; k is how many numbers its control has."""
        return scheme_of(self.control)

    @property
    def nominal(self) -> Array:
        """(k,) the numbers of the nominal control; of the motor: switch angle, stall torque."""
        return np.array([getattr(self.control, name) for name in self.scheme.numbers])

    @property
    def half_range(self) -> Array:
        """(k,) what action 1 adds to them: rad, or a share of the strength's absolute value."""
        units = np.where(np.array(self.scheme.columns) == ANGLE, 1.0, np.abs(self.nominal))
        return np.array(self.action_range) * units

    def control_of(self, action: Array) -> AnyControl:
        """The control that (k,) finite numbers mean: the action mapping, without noise."""
        wanted = self.nominal + np.clip(action, -1.0, 1.0) * self.half_range
        meant: AnyControl = self.scheme.of_numbers(wanted)
        return meant

    @property
    def scale(self) -> Array:
        """(4,) units of a deviation from the gait."""
        return state_scale(self.params)


def state_scale(params: WalkerParams) -> Array:
    """(4,) units of a deviation, rad and rad/s; rates go with √(g/L)."""
    rate = math.sqrt(params.gravity / params.leg_length / 10.0)
    return np.array([0.05, 0.05, 0.15 * rate, 0.3 * rate])
