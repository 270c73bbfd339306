"""The task, apart from the walker: observation, action, reward, start. Pure functions.

Deviations are measured in units of `state_scale`: 0.05 rad on both angles, 0.15 and
0.3 rad/s on the rates of stance and swing leg, for a walker with √(g/L) = √10 /s.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.compiled.decorators import kernel

threaded_kernel = kernel
from powered_walker_env.envs.disturbances import GROUND, SENSOR, TORQUE, Disturbance
from powered_walker_env.envs.noise import Words, draw_normals
from powered_walker_env.model.mechanics.constants import GRAVITY, LEG_LENGTH, LEG_MASS
from powered_walker_env.model.phases import Outcome
from powered_walker_env.model.powering import ANGLE, AnyControl, Scheme, scheme_of
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.simulation.record import (
    DURATION,
    ENERGY_IN,
    ENERGY_LOST,
    OUTCOME,
    POSITIVE_WORK,
    STATE,
    STEP_LENGTH,
)
from powered_walker_env.simulation.strides import Array

REWARDS = ("deviation", "contraction", "periodicity")
OBSERVATION_LIMIT = 20.0  # deviations beyond are clipped: 1 rad, far outside any basin
CONTRACTION_FLOOR = 0.01  # ε: a distance of less than a hundredth of the scale is "on the gait"
CONTRACTION_FALL = -10.0  # log(40/0.01) is 8.3: more than a walk loses inside the observed box
SHORTEST_STEP = 0.01  # leg lengths; a shorter step costs as much as this one, not infinity
WALKED = int(Outcome.WALKED)
DEVIATION, CONTRACTION, PERIODICITY = range(3)

#: The numbers of a stride in `info`; rows of the table that `end_stride` fills.
STRIDE_INFO = (
    "duration",  # s
    "step_length",  # m, 0 after a fall
    "step_height",  # m, of the ground ahead over the ground under the stance foot
    "energy_in",  # J, net work of motor, hip or push
    "positive_work",  # J, its positive part
    "energy_lost",  # J, at the heel strike
    "distance",  # from the gait, scaled
    "reward_stability",
    "reward_effort",
    "reward_fall",
)


@dataclass(frozen=True, eq=False)
class Task:
    """What one environment asks of its walker."""

    params: WalkerParams
    control: AnyControl  # the nominal one: zero action, the open-loop baseline
    gait: Array  # (period, 4) post-strike states of the nominal cycle
    action_range: tuple[float, ...]  # (k,) at action 1: rad of an angle, fraction of a strength
    disturbance: Disturbance
    reward: str = "deviation"
    effort_weight: float = 0.0  # reward lost per unit of mechanical cost of transport

    def __post_init__(self) -> None:
        if self.reward not in REWARDS:
            raise ValueError(f"reward must be one of {', '.join(REWARDS)}, got {self.reward!r}")
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

    @property
    def scale(self) -> Array:
        """(4,) units of a deviation from the gait."""
        return state_scale(self.params)


def state_scale(params: WalkerParams) -> Array:
    """(4,) units of a deviation, rad and rad/s; rates go with √(g/L)."""
    rate = math.sqrt(params.gravity / params.leg_length / 10.0)
    return np.array([0.05, 0.05, 0.15 * rate, 0.3 * rate])


@kernel
def distance(state: Array, other: Array, scale: Array) -> float:
    """Distance of two post-strike states in units of the scale."""
    total = 0.0
    for j in range(4):
        total += ((state[j] - other[j]) / scale[j]) ** 2
    return math.sqrt(total)


@kernel
def distance_to_gait(state: Array, gait: Array, scale: Array) -> float:
    """Distance to the nearest point of the gait's cycle."""
    nearest = math.inf
    for k in range(gait.shape[0]):
        nearest = min(nearest, distance(state, gait[k], scale))
    return nearest


@kernel
def stability_reward(kind: int, state: Array, landed: Array, gait: Array, scale: Array) -> float:
    """Reward of a stride that walked from `state` to `landed`.

    deviation: exp(−d²/2), d the distance to the gait after the stride;
    contraction: log((d + ε)/(d' + ε)), d before and d' after: it telescopes;
    periodicity: exp(−d²/2), d the distance between the two states.
    """
    if kind == PERIODICITY:
        return math.exp(-0.5 * distance(state, landed, scale) ** 2)
    after = distance_to_gait(landed, gait, scale)
    if kind == CONTRACTION:
        before = distance_to_gait(state, gait, scale)
        return math.log((before + CONTRACTION_FLOOR) / (after + CONTRACTION_FLOOR))
    return math.exp(-0.5 * after**2)


@kernel
def cost_of_transport(result: Array, walker: Array) -> float:
    """Positive work of a stride over weight times step length; `walker` packed."""
    length, mass, gravity = walker[LEG_LENGTH], walker[LEG_MASS], walker[GRAVITY]
    step = max(result[STEP_LENGTH], SHORTEST_STEP * length)
    return result[POSITIVE_WORK] / (2.0 * mass * gravity * step)


@kernel
def observe(
    state: Array, gait: Array, scale: Array, noise: Array, observation: NDArray[np.float32]
) -> None:
    """Write the deviation from the gait's first point, with sensor noise, clipped."""
    for j in range(4):
        value = (state[j] - gait[0, j]) / scale[j] + noise[j]
        observation[j] = min(OBSERVATION_LIMIT, max(-OBSERVATION_LIMIT, value))


@kernel
def begin_episodes(
    words: Words, sizes: Array, gait: Array, scale: Array, pushed: bool,
    states: Array, observations: NDArray[np.float32],
) -> None:  # fmt: skip
    """Start N walkers: push their `states` if they are to be pushed, and observe them."""
    draws = np.empty((states.shape[0], sizes.shape[0]))
    draw_normals(words, sizes, draws)
    for i in range(states.shape[0]):
        if pushed:
            states[i, 2] += draws[i, 0]
            states[i, 3] += draws[i, 1]
        observe(states[i], gait, scale, draws[i, SENSOR], observations[i])


@threaded_kernel
def begin_strides(
    walkers: NDArray[np.int64], actions: Array, nominal: Array, half_range: Array, strength: int,
    least: float, sizes: Array, levels: Array, words: Words, states: Array,
    draws: Array, controls: Array, heights: Array, starts: Array,
) -> None:  # fmt: skip
    """Draw the disturbances of n strides; set their controls and steps of the ground.

    Args:
        walkers: (n,) which of the N walkers.
        actions: (N, k), clipped to [−1, 1] here.
        nominal, half_range: (k,) control at action 0, and what action 1 adds.
        strength: which of the k numbers the torque noise multiplies.
        least: of the strength: 0, or −∞ where it may be negative.
        sizes: (8,) standard deviations of the draws.
        levels: (N,) m, height of the ground under each stance foot.
        words: (N,) states of the random numbers; they advance.
        states: (N, 4) post-strike states.
        draws: (n, 8) on return, disturbances; controls: (n, k) on return, the
            strength with its noise; heights: (n,) on return, m, of the ground
            ahead over the ground under the stance foot; starts: (n, 4) on return, states.
    """
    own = words[walkers]
    draw_normals(own, sizes, draws)
    for i in range(walkers.shape[0]):
        walker = walkers[i]
        words[walker] = own[i]
        for j in range(actions.shape[1]):
            action = min(1.0, max(-1.0, actions[walker, j]))
            controls[i, j] = nominal[j] + action * half_range[j]
        noisy = controls[i, strength] * (1.0 + draws[i, TORQUE])
        controls[i, strength] = max(least, noisy)
        heights[i] = draws[i, GROUND] - levels[walker]
        starts[i] = states[walker]


@threaded_kernel
def end_strides(
    walkers: NDArray[np.int64], kind: int, effort_weight: float, gait: Array, scale: Array,
    packed: Array, results: Array, draws: Array, heights: Array,
    states: Array, levels: Array, observations: NDArray[np.float32],
    rewards: Array, terminated: NDArray[np.bool_], outcomes: NDArray[np.int64], info: Array,
) -> None:  # fmt: skip
    """End n strides: push, reward, next state and observation.

    Args:
        walkers: (n,) which of the N walkers.
        kind: index in `REWARDS`.
        packed: walkers, n or one for all.
        results: (n, ...) of the kernel, by row.
        draws: (n, 8) disturbances; the push on both leg rates follows the heel strike,
            rad/s; sensor noise is in units of the observation.
        heights: (n,) m, steps of the ground.
        states, levels, observations: (N, ...) of the start of the strides; on return, of
            their ends, unless a walker fell: then they stay.
        rewards, terminated, outcomes: (N,) on return.
        info: (N, columns of `STRIDE_INFO`) on return.
    """
    for i in range(walkers.shape[0]):
        walker, fell = walkers[i], results[i, OUTCOME] != WALKED
        stability, effort, fall = 0.0, 0.0, 0.0
        if fell:
            fall = CONTRACTION_FALL if kind == CONTRACTION else 0.0
        else:
            landed = results[i, STATE]
            landed[2] += draws[i, 0]
            landed[3] += draws[i, 1]
            stability = stability_reward(kind, states[walker], landed, gait, scale)
            effort -= effort_weight * cost_of_transport(
                results[i], packed[i if packed.shape[0] > 1 else 0]
            )
            states[walker] = landed
            levels[walker] = draws[i, GROUND]
            observe(states[walker], gait, scale, draws[i, SENSOR], observations[walker])
        rewards[walker] = stability + effort + fall
        terminated[walker] = fell
        outcomes[walker] = int(results[i, OUTCOME])
        info[walker, 0] = results[i, DURATION]
        info[walker, 1] = results[i, STEP_LENGTH]
        info[walker, 2] = heights[i]
        info[walker, 3] = results[i, ENERGY_IN]
        info[walker, 4] = results[i, POSITIVE_WORK]
        info[walker, 5] = results[i, ENERGY_LOST]
        info[walker, 6] = distance_to_gait(states[walker], gait, scale)
        info[walker, 7], info[walker, 8], info[walker, 9] = stability, effort, fall
