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

from powered_walker_env.envs.disturbances import EPISODE_DRAWS, episode_params
from powered_walker_env.envs.noise import draw_normals, first_word
from powered_walker_env.envs.rewards import REWARDS, own_rewards
from powered_walker_env.envs.room import Room, room_for
from powered_walker_env.envs.saved import Saved
from powered_walker_env.envs.stepping import begin_episodes, begin_strides, end_strides
from powered_walker_env.envs.task import (
    EFFORT,
    OBSERVATION_LIMIT,
    STABILITY,
    STRIDE_INFO,
    Task,
)
from powered_walker_env.model.knees import encode
from powered_walker_env.model.mechanics.packing import OWN, pack, pack_all, rows_from_own
from powered_walker_env.model.phases import Outcome
from powered_walker_env.model.powering import MOTOR
from powered_walker_env.model.state import PostStrikeState
from powered_walker_env.simulation.strides import Array, run_rows
from powered_walker_env.simulation.threads import run_in_slices
from powered_walker_env.simulation.walked import StrideBatch

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
    """The state of N walkers and their step."""

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
        self._effort_weight = float(task.effort_weight)
        self._kind = 0 if callable(task.reward) else list(REWARDS).index(task.reward)
        self._sizes = disturbance.sizes(task.params)
        self._scheme = task.scheme
        self._whole = room_for(self.rows, self.states, self.controls, self.heights)
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
            words, self._sizes, self._gait, self._scale, state is None, self._whole.draws[:count],
            states, observations,
        )  # fmt: skip
        self.words[rows], self.states[rows], self.observations[rows] = words, states, observations
        self.controls[rows] = self._nominal
        self.levels[rows] = self.heights[rows] = 0.0
        self.outcomes[rows] = WALKED

    def step(self, actions: Array, active: NDArray[np.bool_] | None = None) -> Step:
        """One stride under (N, k) actions, of every walker or of the active ones only.

        A walker left out draws no random numbers and keeps its state; its entries of the
        result are those of a start, or of one that lies where it fell.
        """
        rewards, table = np.zeros(self.count), self.nothing()
        self.walk(np.ascontiguousarray(actions, np.float64), active, rewards, table)
        terminated = self.outcomes != WALKED
        return Step(self.observations.copy(), rewards, terminated, self.info(table))

    def walk(
        self, actions: Array, active: NDArray[np.bool_] | None, rewards: Array, table: Array
    ) -> None:
        """`step` into arrays; the entries of walkers left out stay as they are.

        Args:
            actions: (N, k), contiguous.
            rewards: (N,) is written; table: (columns, N) is written, the numbers of
                `STRIDE_INFO`.
        """
        room = self._whole
        if active is not None:
            room = room.of(np.flatnonzero(active))
        before = None if self._own is None else self.states[room.rows]
        # Not kept: a copy that was sent to another process can be written to, which is another
        # type to the kernel, and compiled anew.
        code = encode(self._scheme.cycle)

        def stride(part: slice) -> None:
            some = room.part(part)
            rows, packed, starts, draws, controls, heights, results = some
            begin_strides(
                rows, actions, self._nominal, self._half_range, self._strength, self._least,
                self._sizes, self.levels, self.words, self.states, draws, controls, heights,
                starts,
            )  # fmt: skip
            acting = self._scheme.rows(controls)  # as the kernel takes them
            run_rows(code, starts, acting, packed, heights, self.rtol, results)
            end_strides(
                rows, self._kind, self._effort_weight, self._gait, self._scale, packed, results,
                draws, heights, self.states, self.levels, self.observations, rewards,
                self.outcomes, table,
            )  # fmt: skip

        run_in_slices(stride, len(room.rows))
        if active is not None:
            self.controls[room.rows], self.heights[room.rows] = room.controls, room.heights
        if before is not None and len(before):
            self._reward(room, before, rewards, table)

    def push(self, i: int, rate: float) -> None:
        """Add to both leg rates of walker i, rad/s; its observation feels it."""
        felt = self.observations[i, 2:] + rate / self._scale[2:]
        self.states[i, 2:] += rate
        self.observations[i, 2:] = np.clip(felt, -OBSERVATION_LIMIT, OBSERVATION_LIMIT)

    def _reward(self, room: Room, before: Array, rewards: Array, table: Array) -> None:
        """Put a reward of one's own in the place of the formula's."""
        assert self._own is not None
        chosen = room.rows
        strides = StrideBatch(self.outcomes[chosen], room.results.copy())
        own = own_rewards(self._own, before, self.states[chosen], strides)
        table[STABILITY, chosen] = own
        rewards[chosen] = own + table[EFFORT, chosen]

    def nothing(self) -> Array:
        """(columns, N) the numbers of `STRIDE_INFO` at a start: nothing walked, nothing earned."""
        return np.zeros((len(STRIDE_INFO), self.count))

    def info(self, table: Array) -> dict[str, NDArray[Any]]:
        """`Step.info`, of which the rows of `table` become a part."""
        info = {
            "state": self.states.copy(),
            "control": self.controls.copy(),
            "outcome": self.outcomes.copy(),
        }
        info |= {name: self.controls[:, i].copy() for i, name in enumerate(self._named)}
        return info | dict(zip(STRIDE_INFO, table, strict=True))

    def info_of_first(self, numbers: Array) -> dict[str, Any]:
        """The entries of walker 0 in `info`: NumPy's numbers and arrays.

        Args:
            numbers: (columns,) its part of `table`.
        """
        state, control = self.states[0].copy(), self.controls[0].copy()
        info = {"state": state, "control": control, "outcome": self.outcomes[0]}
        if self._named:
            info |= zip(self._named, control, strict=True)
        info |= zip(STRIDE_INFO, numbers)  # noqa: B905 # `strict` takes as long again
        return info

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
