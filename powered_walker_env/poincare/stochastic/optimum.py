"""The best that any control within bounds can do, by dynamic programming on the section.

With V₀ = 0, V_{n+1}(p) = max_u E[reward + discount · V_n(p')]: the greatest expected reward, or
strides, of n + 1 strides, and the best control of the first of them (R. Bellman, Dynamic
Programming, 1957). p is on the section ahead of every switch (`sections.py`): three numbers that
say all that a decision can know, if the state is seen as it is.

Three things are not exact, and each is measured: the grid between its nodes (a coarser one
beside it), the controls between those tried (fewer beside them), and what lies off the grid
(nothing comes of it, or the best that could: two bounds). The policy's own walks are plain
simulation.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import scipy.ndimage
from numpy.typing import NDArray

from powered_walker_env.model.checks import real_number, require, whole_number
from powered_walker_env.model.powering import scheme_of
from powered_walker_env.poincare.gaits import Gait
from powered_walker_env.poincare.regulator import Regulator, regulate
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
from powered_walker_env.poincare.stochastic.walks import grid_around, visits
from powered_walker_env.poincare.tolerances import FATE_RTOL
from powered_walker_env.simulation.strides import Array

ROUNDS = 3  # of placing the grid: where the regulator walks, then where the optimum does
ROUGHLY = (12, 7)  # nodes along each axis, and controls of each number, of those rounds
DITHER = 0.2  # half ranges, of the regulator's control in the first round
REACH_TAIL, REACH_MARGIN = 1e-4, 1.25  # of the box over where the optimum walks
COARSER = 2 / 3  # of the counts of nodes


@dataclass(frozen=True, eq=False)
class TablePolicy:
    """A table of controls over a grid of the section, linear in between: a policy.

    A state is carried to the section first; beyond the grid the nearest control holds.
    """

    grid: Grid = field(repr=False)
    numbers: Array = field(repr=False)  # (N, k) of the controls at the nodes
    scheme: str
    high: Array  # (k,) upper bounds of the numbers

    def __repr__(self) -> str:
        return f"TablePolicy({self.scheme}, {self.grid.shape} nodes)"

    def __call__(self, states: Array) -> Array:
        """(N, k) numbers of the controls."""
        assert self.grid.section is not None
        points = self.grid.section.points(states, FATE_RTOL)
        lost = np.isnan(points).any(axis=1)  # they fall whatever is done
        points[lost] = self.grid.centre
        return self.grid.at(self.numbers, points)


@dataclass(frozen=True, eq=False)
class Optimum:
    """The greatest expected strides or reward from every node, and how to come by them."""

    gait: Gait  # under its constant control, the middle of the bounds
    low: Array  # (k,) bounds of the control; of the motor: switch angle, stall torque
    high: Array
    noise: StepNoise
    horizon: int  # strides
    discount: float
    counts: tuple[int, ...]  # (k,) values of each number tried
    grid: Grid = field(repr=False)
    choice: NDArray[np.float32] = field(repr=False)  # (N, k) the best control, counted in values
    # of each number from 0, in between where a parabola has its peak; −1: each falls
    values: NDArray[np.float32] = field(repr=False)  # (N,) greatest expected sum
    value: float  # from the gait, pushed once; off the grid nothing comes
    upper: float  # the same, if off the grid came all that could
    coarser: float  # value on a grid of two thirds of the nodes
    fewer: float  # value with every other control only

    def __repr__(self) -> str:
        return (
            f"Optimum({self.value:.5g} ± {self.error:.2g} in {self.horizon} strides, at most "
            f"{self.upper:.5g} off the grid; {self.grid.shape} nodes, {math.prod(self.counts)} controls)"
        )

    @property
    def error(self) -> float:
        """Of the value, by refinement of the grid, of the controls, and what lies off the grid."""
        return float(
            abs(self.value - self.coarser) + abs(self.value - self.fewer) + self.upper - self.value
        )

    @property
    def policy(self) -> TablePolicy:
        """The best control of the first of so many strides, as a policy."""
        shape = self.grid.table_shape
        bad = (self.choice[:, 0] < 0).reshape(shape)
        chosen = self.choice.reshape(*shape, -1).astype(np.float64)
        if bad.any() and not bad.all():  # what falls anyway is controlled as its neighbour is
            nearest = scipy.ndimage.distance_transform_edt(
                bad, return_distances=False, return_indices=True
            )
            chosen = chosen[tuple(nearest)]
        share = np.maximum(chosen.reshape(self.grid.size, -1), 0.0) / (np.array(self.counts) - 1)
        numbers = self.low + share * (self.high - self.low)
        return TablePolicy(self.grid, numbers, scheme_of(self.gait.control).name, self.high)


def optimum(
    gait: Gait,
    half_range: Sequence[float],
    noise: StepNoise,
    *,
    horizon: int = 100,
    discount: float = 1.0,
    reward: Reward | None = None,
    most: float = 1.0,
    shape: int = 24,
    counts: int | Sequence[int] = 9,
    branches: int = 9,
    push_points: int = 5,
    grid: Grid | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> Optimum:
    """The greatest expected strides, or reward, by any control within bounds.

    Args:
        gait: of one stride under a constant control; walks begin on it, pushed once.
        half_range: (k,) how far the numbers of the control may go from the gait's own.
        noise: what disturbs every step.
        horizon: strides.
        discount: of each stride against the one before, in (0, 1].
        reward: of post-strike states (N, 4), pushes included, for each stride walked; the
            strides are counted if left out.
        most: that the reward of a stride can be, for the upper bound.
        shape: nodes along each axis of the grid.
        counts: values of each number of the control tried, the bounds included; odd, so that
            the nominal one is among them, and every other makes sense.
        branches, push_points: see `step_law`.
        grid: on a section ahead of every switch; placed where the optimum walks if left out.
        seed: of the walks that place it.
        progress: called with the strides done and those in all, for each table.

    Raises:
        ValueError: a gait of several strides or without a constant control, bad bounds or counts.
    """
    horizon, shape = whole_number("horizon", horizon, 1), whole_number("shape", shape, 6)
    discount = real_number("discount", discount)
    require(0.0 < discount <= 1.0, "discount", "lie in (0, 1]", discount)
    law = regulate(gait, half_range)
    numbers = _counts(counts, len(law.nominal))
    on = _section(gait, law, noise)
    problem = _Problem(
        gait, law, noise, numbers, horizon, discount, reward, branches, push_points, progress
    )
    box = _placed(problem, on, seed) if grid is None else grid
    if grid is None:
        box = box.resized((shape,) * len(box.shape))
    choices = controls_between(law.low, law.high, numbers)
    table = problem.table(box, choices)
    values, places = problem.solve(table)
    chosen = places[:, : len(numbers)].astype(np.float32)
    value = problem.start(table, values)
    least = box.resized([max(4, round(COARSER * n)) for n in box.shape])
    coarse = problem.table(least, choices)
    few = dataclasses.replace(problem, counts=tuple((n + 1) // 2 for n in numbers))
    fewer = _every_other(table, numbers)
    return Optimum(
        gait, law.low, law.high, noise, horizon, discount, numbers, box, chosen, values.astype(np.float32), value,
        problem.start(table, problem.solve(table, most)[0], horizon * most),
        problem.start(coarse, problem.solve(coarse)[0]),
        few.start(fewer, few.solve(fewer)[0]),
    )  # fmt: skip


def controls_between(low: Array, high: Array, counts: Sequence[int]) -> Array:
    """(A, k) the controls of a grid between bounds, the last number running fastest."""
    axes = [np.linspace(*ends) for ends in zip(low, high, counts, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))


def _counts(counts: int | Sequence[int], numbers: int) -> tuple[int, ...]:
    given = tuple(counts) if isinstance(counts, Sequence | np.ndarray) else (counts,) * numbers
    if len(given) != numbers or any(whole_number("counts", n, 3) % 2 == 0 for n in given):
        raise ValueError(f"counts must be odd, one or {numbers}, got {counts!r}")
    return given


def _every_other(law: Law, counts: Sequence[int]) -> Law:
    """The law with every other value of each number of the control."""
    kept = np.zeros(counts, np.bool_)
    kept[tuple(slice(None, None, 2) for _ in counts)] = True
    return law.among(kept.ravel())


def _section(gait: Gait, law: Regulator, noise: StepNoise) -> Section:
    on = section_of(gait.params, gait.control, law.high, level=noise.level)
    if on.hip_angle is None and noise.push > 0 and len(on.coordinates) < 3:
        return section_of(gait.params, gait.control, law.high, level=False)
    return on


@dataclass(frozen=True)
class _Problem:
    """What is asked, but for the grid and the controls."""

    gait: Gait
    law: Regulator
    noise: StepNoise
    counts: tuple[int, ...]
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

    def solve(self, table: Law, most: float = 0.0) -> tuple[Array, Array]:
        """(N,) greatest expected sums over the horizon, and (N, 2) the first choice.

        Args:
            most: of the reward of every stride to come, off the grid.
        """
        values, chosen = np.zeros(table.grid.size), np.zeros((table.grid.size, 2))
        left = 0.0  # discounted strides to come
        for _ in range(self.horizon):
            values, chosen = table.best(values, self.discount, most * left, between=self.counts)
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


def _placed(problem: _Problem, on: Section, seed: int) -> Grid:
    """A grid that holds where the optimum walks: a rough one, solved and walked, again and again."""
    params, start = problem.gait.params, problem.gait.state
    nodes, each = ROUGHLY
    policy: _Dithered | TablePolicy = _Dithered(problem.law, np.random.default_rng(seed))
    rough = dataclasses.replace(problem, counts=(each,) * len(problem.law.low))
    choices = controls_between(problem.law.low, problem.law.high, rough.counts)
    shape = (nodes,) * len(on.coordinates)
    for number in range(ROUNDS + 1):
        _, met = visits(params, policy, problem.noise, start, on, walks=4000, seed=seed + number)
        grid = grid_around(met.point, on, shape, REACH_TAIL, REACH_MARGIN)
        if number < ROUNDS:
            values, chosen = rough.solve(rough.table(grid, choices, quiet=True))
            policy = Optimum(
                problem.gait, problem.law.low, problem.law.high, problem.noise, problem.horizon,
                problem.discount, rough.counts, grid, chosen[:, : len(rough.counts)], values,
                0.0, 0.0, 0.0, 0.0,
            ).policy  # fmt: skip
    return grid
