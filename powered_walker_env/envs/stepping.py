"""One step of N walkers, compiled: what disturbs them before a stride, what they get after it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.compiled.decorators import kernel, rare
from powered_walker_env.envs.disturbances import GROUND, SENSOR, TORQUE
from powered_walker_env.envs.noise import Words, draw_row
from powered_walker_env.envs.rewards import (
    CONTRACTION,
    CONTRACTION_FALL,
    cost_of_transport,
    distance_to_gait,
    stability_reward,
)
from powered_walker_env.envs.task import OBSERVATION_LIMIT
from powered_walker_env.model.phases import Outcome
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

WALKED = int(Outcome.WALKED)
FIRST_NOISE = SENSOR.start
assert STATE.start == 0  # so that a row of results is read as a state, too

# Arrays are read and written number by number: numba compiles a copy of a row, a `min` or
# an index by an array with their error messages, which takes longer than all of this.


@rare
def observe(
    states: Array, walker: int, gait: Array, scale: Array, draws: Array, i: int,
    observations: NDArray[np.float32],
) -> None:  # fmt: skip
    """Write the deviation from the gait's first point, with its noise; clipped last."""
    for j in range(4):
        seen = (states[walker, j] - gait[0, j]) / scale[j] + draws[i, FIRST_NOISE + j]
        if seen < -OBSERVATION_LIMIT:
            seen = -OBSERVATION_LIMIT
        elif seen > OBSERVATION_LIMIT:
            seen = OBSERVATION_LIMIT
        observations[walker, j] = seen


@kernel
def begin_episodes(
    words: Words, sizes: Array, gait: Array, scale: Array, pushed: bool, draws: Array,
    states: Array, observations: NDArray[np.float32],
) -> None:  # fmt: skip
    """Start N walkers: push their `states` if they are to be pushed, and observe them."""
    for i in range(states.shape[0]):
        words[i] = draw_row(words[i], sizes, draws, i)
        if pushed:
            states[i, 2] += draws[i, 0]
            states[i, 3] += draws[i, 1]
        observe(states, i, gait, scale, draws, i, observations)


@kernel
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
    for i in range(walkers.shape[0]):
        walker = walkers[i]
        words[walker] = draw_row(words[walker], sizes, draws, i)
        for j in range(actions.shape[1]):
            action = actions[walker, j]
            if action < -1.0:
                action = -1.0
            elif action > 1.0:
                action = 1.0
            controls[i, j] = nominal[j] + action * half_range[j]
        noisy = controls[i, strength] * (1.0 + draws[i, TORQUE])
        controls[i, strength] = noisy if noisy > least else least
        heights[i] = draws[i, GROUND] - levels[walker]
        for j in range(4):
            starts[i, j] = states[walker, j]


@kernel
def end_strides(
    walkers: NDArray[np.int64], kind: int, effort_weight: float, gait: Array, scale: Array,
    packed: Array, results: Array, draws: Array, heights: Array,
    states: Array, levels: Array, observations: NDArray[np.float32],
    rewards: Array, outcomes: NDArray[np.int64], info: Array,
) -> None:  # fmt: skip
    """End n strides: push, reward, next state and observation.

    Args:
        walkers: (n,) which of the N walkers.
        kind: index in `REWARDS`.
        packed: walkers, n or one for all.
        results: (n, ...) of the kernel, by row; states get their push.
        draws: (n, 8) disturbances; the push on both leg rates follows the heel strike,
            rad/s; sensor noise is in units of the observation.
        heights: (n,) m, steps of the ground.
        states, levels, observations: (N, ...) of the start of the strides; on return, of
            their ends, unless a walker fell: then they stay.
        rewards, outcomes: (N,) on return.
        info: (columns of `STRIDE_INFO`, N) on return.
    """
    for i in range(walkers.shape[0]):
        walker, fell = walkers[i], results[i, OUTCOME] != WALKED
        stability, effort, fall = 0.0, 0.0, 0.0
        if fell:
            fall = CONTRACTION_FALL if kind == CONTRACTION else 0.0
        else:
            results[i, 2] += draws[i, 0]
            results[i, 3] += draws[i, 1]
            stability = stability_reward(kind, states, walker, results, i, gait, scale)
            shared = packed.shape[0] == 1
            effort -= effort_weight * cost_of_transport(results, i, packed, 0 if shared else i)
            for j in range(4):
                states[walker, j] = results[i, j]
            levels[walker] = draws[i, GROUND]
            observe(states, walker, gait, scale, draws, i, observations)
        rewards[walker] = stability + effort + fall
        outcomes[walker] = np.int64(results[i, OUTCOME])
        info[0, walker] = results[i, DURATION]
        info[1, walker] = results[i, STEP_LENGTH]
        info[2, walker] = heights[i]
        info[3, walker] = results[i, ENERGY_IN]
        info[4, walker] = results[i, POSITIVE_WORK]
        info[5, walker] = results[i, ENERGY_LOST]
        info[6, walker] = distance_to_gait(states, walker, gait, scale)
        info[7, walker], info[8, walker], info[9, walker] = stability, effort, fall
