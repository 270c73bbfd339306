"""One stride looked ahead on the exact map, with a table's values after it: a rollout policy.

Where values fall off steeply between nodes a table of controls, linear in between, is worse than
its values promise. Here the table's control is but the middle of those tried, each by an exact
stride from where the walker is, and its pushes summed over (D. Bertsekas, Rollout, Policy
Iteration, and Distributed Reinforcement Learning, 2020, section 2.1).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from powered_walker_env.poincare.gaits import Gait
from powered_walker_env.poincare.stochastic.law import (
    normal_points,
    push_counts,
    second_differences,
)
from powered_walker_env.poincare.stochastic.noise import StepNoise, branches_of
from powered_walker_env.poincare.stochastic.steps import Reward, Stepper, rows_from
from powered_walker_env.poincare.stochastic.sums import best_choices
from powered_walker_env.poincare.stochastic.tables import TablePolicy, controls_about
from powered_walker_env.poincare.tolerances import FATE_RTOL
from powered_walker_env.simulation.strides import Array

STEP = 0.2  # half ranges about the table's control
BRANCHES = 9
CHUNK = 20_000  # decisions at once


@dataclass(frozen=True, eq=False)
class LookAhead:
    """The best of some controls by one exact stride and a table's values after it."""

    gait: Gait
    noise: StepNoise
    table: TablePolicy
    values: Array = field(repr=False)  # (N,) at the table's nodes
    low: Array
    high: Array
    fixed: Array = field(repr=False)  # (B, k) controls tried everywhere
    discount: float
    reward: Reward | None
    on_section: ClassVar[bool] = True  # strides from one orbit are the same

    @property
    def scheme(self) -> str:
        """The name of the scheme whose numbers it gives."""
        return self.table.scheme

    def __call__(self, states: Array) -> Array:
        """(N, k) numbers of the controls."""
        parts = [states[i : i + CHUNK] for i in range(0, len(states), CHUNK)]
        return np.concatenate([self._best(part) for part in parts])

    def _best(self, states: Array) -> Array:
        near = controls_about(self.table(states), STEP, self.low, self.high)
        everywhere = np.broadcast_to(self.fixed, (len(states), *self.fixed.shape))
        choices = np.concatenate([near, everywhere], axis=1)
        grid = self.table.grid
        stepper = Stepper(self.gait.params, self.gait.control, grid, self.noise, FATE_RTOL)
        pushes = (
            normal_points(push_counts(grid))
            if self.noise.push > 0
            else (np.zeros((1, 2)), np.ones(1))
        )
        drawn = branches_of(self.noise, BRANCHES)
        counts, choice, share, mean, gain, bend, worth = rows_from(
            stepper, states, choices, drawn, self.reward, *pushes, turn=True
        )
        best, chosen = np.zeros(len(states)), np.full(len(states), -1, np.int32)
        begin = np.concatenate([[0], np.cumsum(counts)])
        bends = second_differences(self.values, grid.table_shape)
        best_choices(
            0, len(states), self.values, bends, np.array(grid.table_shape), grid.counted_curve,
            begin, choice, share, mean, gain, bend, worth, *pushes, self.discount, 0.0, 1.0, best,
            chosen,
        )  # fmt: skip
        # Who falls under all goes by the table: its control is the middle of those about it.
        chosen[chosen < 0] = near.shape[1] // 2
        numbers: Array = choices[np.arange(len(states)), chosen]
        return numbers
