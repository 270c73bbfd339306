"""Dynamic programming over the law of the next step, and where its grid is placed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.poincare.gaits import Gait
from powered_walker_env.poincare.regulator import Regulator
from powered_walker_env.poincare.sections import Section, section_of
from powered_walker_env.poincare.stochastic.grid import Grid
from powered_walker_env.poincare.stochastic.law import Law
from powered_walker_env.poincare.stochastic.passage import mean_at, start_places
from powered_walker_env.poincare.stochastic.steps import (
    Progress,
    Reward,
    StepNoise,
    Stepper,
    step_law,
)
from powered_walker_env.poincare.stochastic.tables import (
    TablePolicy,
    controls_between,
    table_policy,
)
from powered_walker_env.poincare.stochastic.walks import grid_around, visits
from powered_walker_env.poincare.tolerances import FATE_RTOL
from powered_walker_env.simulation.strides import Array

ROUNDS = 3  # of placing the grid: where the regulator walks, then where the optimum does
ROUGHLY = (12, 7)  # nodes along each axis, and controls of each number, of those rounds
WALKS = 4000  # plain ones, of the policy
DITHER = 0.2  # half ranges, of the regulator's control in the first round
REACH_TAIL, REACH_MARGIN = 1e-4, 1.25  # of the box over where the optimum walks


def decided_section(gait: Gait, high: Array, noise: StepNoise) -> Section:
    """The section ahead of every switch up to the upper bounds of the control."""
    on = section_of(gait.params, gait.control, high, level=noise.level)
    if on.hip_angle is None and noise.push > 0 and len(on.coordinates) < 3:
        return section_of(gait.params, gait.control, high, level=False)
    return on


@dataclass(frozen=True)
class Problem:
    """What is asked, but for the grid and the controls."""

    gait: Gait
    law: Regulator
    noise: StepNoise
    horizon: int
    discount: float
    reward: Reward | None
    branches: int
    push_points: int
    progress: Progress | None

    def table(self, grid: Grid, choices: Array, quiet: bool = False) -> Law:
        """The law of the next step."""
        return step_law(
            self.gait.params, self.gait.control, grid, self.noise, choices=choices,
            reward=self.reward, branches=self.branches, push_points=self.push_points,
            progress=None if quiet else self.progress,
        )  # fmt: skip

    def solve(self, table: Law, most: float = 0.0) -> tuple[Array, NDArray[np.int32]]:
        """(N,) greatest expected sums over the horizon, and (N,) the first choice.

        Args:
            most: of the reward of every stride to come, off the grid.
        """
        values, chosen = np.zeros(table.grid.size), np.zeros(table.grid.size, np.int32)
        left = 0.0  # discounted strides to come
        for _ in range(self.horizon):
            values, chosen = table.best(values, self.discount, most * left)
            left = 1.0 + self.discount * left
        return values, chosen

    def start(self, table: Law, values: Array, outside: float = 0.0) -> float:
        """The value from the gait, pushed once."""
        stepper = Stepper(self.gait.params, self.gait.control, table.grid, self.noise, FATE_RTOL)
        points, weights = start_places(stepper, np.array(self.gait.state), table)
        known = mean_at(table.grid, np.ones(table.grid.size), points, weights)
        return mean_at(table.grid, values, points, weights) + (1.0 - known) * outside


@dataclass(frozen=True)
class _Dithered:
    """A regulator whose controls are varied, to see more of the states."""

    law: Regulator
    rng: np.random.Generator

    @property
    def scheme(self) -> str:
        return self.law.scheme

    def __call__(self, states: Array) -> Array:
        wanted = self.law(states)
        wanted += DITHER * 0.5 * (self.law.high - self.law.low) * self.rng.normal(size=wanted.shape)
        return np.clip(wanted, self.law.low, self.law.high)


def placed(problem: Problem, on: Section, seed: int) -> Grid:
    """A grid that holds where the optimum walks: a rough one is solved and walked, repeatedly."""
    params, start = problem.gait.params, problem.gait.state
    nodes, each = ROUGHLY
    policy: _Dithered | TablePolicy = _Dithered(problem.law, np.random.default_rng(seed))
    counts = (each,) * len(problem.law.low)
    choices = controls_between(problem.law.low, problem.law.high, counts)
    shape = (nodes,) * len(on.coordinates)
    for number in range(ROUNDS + 1):
        _, met = visits(params, policy, problem.noise, start, on, walks=WALKS, seed=seed + number)
        grid = grid_around(met.point, on, shape, REACH_TAIL, REACH_MARGIN)
        if number < ROUNDS:
            _, chosen = problem.solve(problem.table(grid, choices, quiet=True))
            policy = table_policy(grid, chosen, choices, problem.gait, problem.law.high)
    return grid
