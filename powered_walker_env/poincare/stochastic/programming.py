"""Dynamic programming over the law of the next step, and where its grid is placed."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.model.mechanics.packing import pack
from powered_walker_env.model.powering import scheme_of
from powered_walker_env.model.state import natural_units
from powered_walker_env.poincare.gaits import Gait
from powered_walker_env.poincare.regulator import Regulator
from powered_walker_env.poincare.sections import Section, section_of
from powered_walker_env.poincare.stochastic.alignment import aligned_grid
from powered_walker_env.poincare.stochastic.grid import AnySection, Grid
from powered_walker_env.poincare.stochastic.law import Law
from powered_walker_env.poincare.stochastic.noise import StepNoise
from powered_walker_env.poincare.stochastic.passage import mean_at, start_places
from powered_walker_env.poincare.stochastic.plane import landing_plane
from powered_walker_env.poincare.stochastic.steps import Progress, Reward, Stepper, step_law
from powered_walker_env.poincare.stochastic.tables import (
    TablePolicy,
    controls_about,
    controls_between,
    filled,
    table_policy,
)
from powered_walker_env.poincare.stochastic.walks import visits
from powered_walker_env.poincare.tolerances import FATE_RTOL
from powered_walker_env.simulation.strides import Array, run_batch

ROUNDS = 3  # of placing the grid: where the regulator walks, then where the optimum does
ROUGH_SHAPE, ROUGH_EVEN = (40, 10, 6), 13  # nodes of those rounds, aligned and not
ROUGH_COUNT = 7  # controls of each number
ROUGH_HORIZON, ROUGH_POINTS = 30, (11, 3)
PLACING = 2000  # walks
DITHER = 0.2  # half ranges, of the regulator's control in the first round
SETTLED = 1e-5  # change of values from stride to stride, at which all have fallen
CALM = 0.05  # reward that a whole half range more of a control must be worth


def decided_section(gait: Gait, high: Array, noise: StepNoise) -> Section:
    """The section ahead of every switch up to the upper bounds of the control."""
    on = section_of(gait.params, gait.control, high, level=noise.level)
    if on.hip_angle is None and noise.push > 0 and len(on.coordinates) < 3:
        return section_of(gait.params, gait.control, high, level=False)
    return on


def decided_place(gait: Gait, high: Array, noise: StepNoise) -> AnySection:
    """That section; of knees with a foot that moves, which have none, the plane of landings."""
    if gait.params.knee is not None and scheme_of(gait.control).moves_ankle and noise.level:
        return landing_plane(gait)
    return decided_section(gait, high, noise)


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
    push_points: int | tuple[int, int]
    progress: Progress | None
    calm: float = CALM

    @property
    def roughly(self) -> Problem:
        """The same over fewer strides, with fewer pushes: for controls on the way."""
        horizon = min(self.horizon, ROUGH_HORIZON)
        return replace(self, horizon=horizon, push_points=ROUGH_POINTS)

    def table(self, grid: Grid, choices: Array, quiet: bool = False) -> Law:
        """The law of the next step."""
        return step_law(
            self.gait.params, self.gait.control, grid, self.noise, choices=choices,
            reward=self.reward, branches=self.branches, push_points=self.push_points,
            progress=None if quiet else self.progress,
        )  # fmt: skip

    def solve(self, table: Law, most: float = 0.0) -> tuple[Array, Array]:
        """(N,) greatest expected sums over the horizon, and (N,) over all strides but the first.

        Args:
            most: of the reward of every stride to come, off the grid.
        """
        values = before = np.zeros(table.grid.size)
        left = 0.0  # discounted strides to come
        for _ in range(self.horizon):
            before = values
            values, _ = table.best(values, self.discount, most * left)
            left = 1.0 + self.discount * left
            if most == 0.0 and np.abs(values - before).max() < SETTLED:
                break  # who walks on is too few to count
        return values, before

    def calmest(self, table: Law, before: Array, choices: Array) -> NDArray[np.int32]:
        """(N,) the first choice, a small one where several are about as good; −1: none walks.

        A table is interpolated between its nodes: neighbours must not choose now one end and now
        another of a valley that is flat.

        Args:
            before: of `solve`.
            choices: (A, k), or (N, A, k) for each node.
        """
        law = self.law
        away = (choices - law.nominal) / (0.5 * (law.high - law.low))
        effort = (away**2).sum(axis=-1)
        nodes = np.repeat(np.arange(table.grid.size), np.diff(table.begin))
        each = effort[table.choice] if choices.ndim == 2 else effort[nodes, table.choice]
        calm = replace(table, reward=(table.reward - self.calm * each).astype(np.float32))
        return calm.best(before, self.discount)[1]

    def start(self, table: Law, values: Array, outside: float = 0.0) -> float:
        """The value from the gait, pushed once."""
        stepper = Stepper(self.gait.params, self.gait.control, table.grid, self.noise, FATE_RTOL)
        points, weights = start_places(stepper, np.array(self.gait.state), table)
        known = mean_at(table.grid, np.ones(table.grid.size), points, weights)
        return mean_at(table.grid, values, points, weights) + (1.0 - known) * outside


@dataclass(frozen=True, eq=False)
class Solved:
    """Values and controls at the nodes, of a law with choices about the controls."""

    table: Law
    values: Array  # (N,)
    numbers: Array  # (N, k) best controls of the first stride
    value: float  # from the start


def solved(problem: Problem, grid: Grid, choices: Array, quiet: bool = False) -> Solved:
    """The best among choices (A, k), or (N, A, k) for each node."""
    table = problem.table(grid, choices, quiet)
    values, before = problem.solve(table)
    chosen = problem.calmest(table, before, choices)
    each = np.broadcast_to(choices, (grid.size, *choices.shape[-2:]))
    numbers = each[np.arange(grid.size), np.maximum(chosen, 0)]
    numbers = filled(grid, chosen >= 0, numbers)
    return Solved(table, values, numbers, problem.start(table, values))


def about(problem: Problem, numbers: Array, step: float, fixed: Array) -> Array:
    """(N, A, k) controls about those of the nodes, and fixed ones (B, k) at all.

    Args:
        numbers: (N, k), which are among them.
        step: how far from them, in half ranges.
    """
    local = controls_about(numbers, step, problem.law.low, problem.law.high)
    everywhere = np.broadcast_to(fixed, (len(numbers), *fixed.shape))
    return np.concatenate([local, everywhere], axis=1)


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


def led_under(gait: Gait, on: AnySection, points: Array) -> Array:
    """(N, 4) where strides from points of a section lead under the gait's own control.

    In natural units; NaN where they fall.
    """
    scheme, row = scheme_of(gait.control), pack(gait.params)[np.newaxis]
    controls = np.tile(scheme.row(gait.control), (len(points), 1))
    batch = run_batch(scheme.cycle, on.states(points), controls, row, np.zeros(1), FATE_RTOL)
    landed = batch.state / natural_units(gait.params)
    landed[~batch.walked] = np.nan
    return landed


def placed(problem: Problem, on: AnySection, seed: int) -> Grid:
    """A grid that holds where the optimum walks: a rough one is solved and walked, repeatedly."""
    gait, k = problem.gait, len(on.coordinates)
    rough = problem.roughly
    policy: _Dithered | TablePolicy = _Dithered(problem.law, np.random.default_rng(seed))
    counts = (ROUGH_COUNT,) * len(problem.law.low)
    choices = controls_between(problem.law.low, problem.law.high, counts)
    for number in range(ROUNDS + 1):
        _, met = visits(
            gait.params, policy, problem.noise, gait.state, on, walks=PLACING, seed=seed + number
        )
        grid = aligned_grid(
            met.point[met.ahead > 0],
            lambda points: led_under(gait, on, points),
            ROUGH_SHAPE[:k],
            on,
        )
        if number < ROUNDS:
            grid = grid if grid.aligned else grid.resized((ROUGH_EVEN,) * k)
            best = solved(rough, grid, choices, quiet=True)
            best = solved(rough, grid, about(rough, best.numbers, 0.5 / ROUGH_COUNT, choices), True)
            policy = table_policy(grid, best.numbers, gait, problem.law.high)
    return grid
