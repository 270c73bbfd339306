"""N walkers at the same task: what the single and the vector environments share.

Each walker has its own random numbers, so that walker i of a batch meets exactly what
a single environment with its seed meets.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.envs.disturbances import EPISODE_DRAWS, STEP_DRAWS, episode_params
from powered_walker_env.envs.noise import draw_normals, first_word
from powered_walker_env.envs.rewards import REWARDS, own_rewards
from powered_walker_env.envs.saved import Saved
from powered_walker_env.envs.stepping import begin_episodes, begin_strides, end_strides
from powered_walker_env.envs.task import EFFORT, OBSERVATION_LIMIT, STABILITY, STRIDE_INFO, Task
from powered_walker_env.model.mechanics.constants import OWN, pack, pack_all, rows_from_own
from powered_walker_env.model.phases import Outcome, encode
from powered_walker_env.model.powering import MOTOR
from powered_walker_env.model.state import PostStrikeState
from powered_walker_env.simulation.record import RESULTS
from powered_walker_env.simulation.strides import Array, StrideBatch, run_rows
from powered_walker_env.simulation.threads import run_in_slices

Rows = slice | NDArray[np.intp]
EVERY = slice(None)
WALKED = int(Outcome.WALKED)
UNIT_DEVIATIONS = np.ones(EPISODE_DRAWS)


@dataclass(frozen=True, eq=False)
class Step:
    """The result of one stride of N walkers; the arrays are the caller's own."""

    observation: NDArray[np.float32]  # (N, 4)
    reward: Array  # (N,)
    terminated: NDArray[np.bool_]  # (N,)
    info: dict[str, NDArray[Any]]  # (N,) or (N, k) each


class Walkers:
    """The state of N walkers and their step: under 200 bytes each."""

    def __init__(self, task: Task, count: int, rtol: float) -> None:
        self.task, self.count, self.rtol = task, count, rtol
        disturbance = task.disturbance
        self.words = np.zeros(count, np.uint64)  # of their random numbers
        self.states = np.tile(task.gait[0], (count, 1))
        self.observations = np.zeros((count, 4), np.float32)
        self.levels = np.zeros(count)  # m, height of the ground under each stance foot
        self.outcomes = np.full(count, WALKED, np.int64)  # of the last stride
        self.controls = np.tile(task.nominal, (count, 1))  # (N, k) of the last stride
        self.heights = np.zeros(count)  # m, steps of the ground in the last stride
        # Packed walkers: one for all, unless every episode has its own.
        self._differ = disturbance.slope > 0 or disturbance.parameters > 0
        self.rows = np.tile(pack(task.params), (count if self._differ else 1, 1))
        self._gait, self._scale = task.gait, task.scale
        self._nominal, self._half_range = task.nominal, task.half_range
        self._own = task.reward if callable(task.reward) else None
        self._kind = 0 if callable(task.reward) else list(REWARDS).index(task.reward)
        self._sizes = disturbance.sizes(task.params)
        self._scheme, self._code = task.scheme, encode(task.scheme.cycle)
        # Room that every step writes anew; new memory would cost more than what fills it.
        self._draws, self._results = np.empty((count, STEP_DRAWS)), np.empty((count, RESULTS))
        self._every = np.arange(count)
        self._strength = self._scheme.strength or 0
        self._least = 0.0 if self._scheme.positive else -math.inf
        # Version 0 of the motor's environments knows its control as one array only.
        self._named = () if self._scheme is MOTOR else self._scheme.numbers

    def seed(self, i: int, generator: np.random.Generator) -> None:
        """Draw where the random numbers of walker i begin."""
        self.words[i] = first_word(generator)

    def row(self, i: int) -> Array:
        """Walker i, packed."""
        found: Array = self.rows[i if self._differ else 0]
        return found

    def reset(self, rows: Rows = EVERY, state: PostStrikeState | None = None) -> None:
        """Start walkers anew: on the gait, just after a heel strike and its push.

        Args:
            rows: which ones.
            state: a post-strike state to start from exactly.
        """
        start = self._gait[0] if state is None else np.array(state)
        words = self.words[rows]
        count = len(words)
        if self._differ:
            draws = np.empty((count, EPISODE_DRAWS))
            draw_normals(words, UNIT_DEVIATIONS, draws)
            chosen = [episode_params(self.task.params, self.task.disturbance, d) for d in draws]
            self.rows[rows] = pack_all(chosen)
        states = np.tile(start, (count, 1))
        observations = np.empty((count, 4), np.float32)
        begin_episodes(
            words,
            self._sizes,
            self._gait,
            self._scale,
            state is None,
            self._draws[:count],
            states,
            observations,
        )
        self.words[rows], self.states[rows], self.observations[rows] = words, states, observations
        self.controls[rows] = self._nominal
        self.levels[rows] = self.heights[rows] = 0.0
        self.outcomes[rows] = WALKED

    def step(self, actions: Array, active: NDArray[np.bool_] | None = None) -> Step:
        """One stride under (N, k) actions, of every walker or of the active ones only.

        A walker left out draws no random numbers and keeps its state; its entries of the
        result are those of a start, or of one that lies where it fell.
        """
        chosen = self._every if active is None else np.flatnonzero(active)
        actions = np.ascontiguousarray(actions, np.float64)
        rewards, outcomes, table = np.zeros(self.count), self.outcomes.copy(), self._nothing()
        before = None if self._own is None else self.states[chosen]

        def walk(part: slice) -> None:
            rows, draws, results = chosen[part], self._draws[part], self._results[part]
            count = len(rows)
            controls, heights = np.empty((count, actions.shape[1])), np.empty(count)
            starts, packed = np.empty((count, 4)), self.rows[rows] if self._differ else self.rows
            begin_strides(
                rows,
                actions,
                self._nominal,
                self._half_range,
                self._strength,
                self._least,
                self._sizes,
                self.levels,
                self.words,
                self.states,
                draws,
                controls,
                heights,
                starts,
            )
            acting = self._scheme.rows(controls)  # as the kernel takes them
            run_rows(self._code, starts, acting, packed, heights, self.rtol, results)
            end_strides(
                rows,
                self._kind,
                self.task.effort_weight,
                self._gait,
                self._scale,
                packed,
                results,
                draws,
                heights,
                self.states,
                self.levels,
                self.observations,
                rewards,
                outcomes,
                table,
            )
            self.controls[rows], self.heights[rows] = controls, heights

        run_in_slices(walk, len(chosen))
        if before is not None and len(chosen):
            self._reward(chosen, before, outcomes, rewards, table)
        self.outcomes[:] = outcomes
        info = self._info(outcomes, table)
        return Step(self.observations.copy(), rewards, outcomes != WALKED, info)

    def push(self, i: int, rate: float) -> None:
        """Add to both leg rates of walker i, rad/s; its observation feels it."""
        felt = self.observations[i, 2:] + rate / self._scale[2:]
        self.states[i, 2:] += rate
        self.observations[i, 2:] = np.clip(felt, -OBSERVATION_LIMIT, OBSERVATION_LIMIT)

    def _reward(
        self,
        chosen: NDArray[np.intp],
        before: Array,
        outcomes: NDArray[np.int64],
        rewards: Array,
        table: Array,
    ) -> None:
        """Put a reward of one's own in the place of the formula's."""
        assert self._own is not None
        strides = StrideBatch(outcomes[chosen], self._results[: len(chosen)].copy())
        own = own_rewards(self._own, before, self.states[chosen], strides)
        table[chosen, STABILITY] = own
        rewards[chosen] = own + table[chosen, EFFORT]

    def start_info(self) -> dict[str, NDArray[Any]]:
        """What `Step.info` holds, at a start: nothing walked yet, nothing earned."""
        return self._info(self.outcomes.copy(), self._nothing())

    def _nothing(self) -> Array:
        return np.zeros((self.count, len(STRIDE_INFO)))

    def _info(self, outcomes: NDArray[np.int64], table: Array) -> dict[str, NDArray[Any]]:
        info = {"state": self.states.copy(), "control": self.controls.copy(), "outcome": outcomes}
        info |= {name: self.controls[:, i].copy() for i, name in enumerate(self._named)}
        return info | dict(zip(STRIDE_INFO, table.T.copy(), strict=True))

    def get_state(self, i: int) -> dict[str, Any]:
        """Everything about walker i that its future depends on: JSON-able numbers."""
        return {
            "state": self.states[i].tolist(),
            "observation": self.observations[i].tolist(),
            "level": float(self.levels[i]),
            "outcome": int(self.outcomes[i]),
            "walker": self.row(i)[:OWN].tolist(),
            "random": int(self.words[i]),
        }

    def set_state(self, i: int, saved: Mapping[str, Any]) -> None:
        """The inverse of `get_state`.

        Raises:
            ValueError: something that `get_state` has not given.
        """
        self.put(i, Saved.of(saved, OWN))

    def put(self, i: int, saved: Saved) -> None:
        """The same with what has been checked."""
        self.states[i], self.observations[i] = saved.state, saved.observation
        self.levels[i], self.outcomes[i] = saved.level, saved.outcome
        self.rows[i if self._differ else 0] = rows_from_own(saved.walker[np.newaxis])[0]
        self.words[i] = saved.random
