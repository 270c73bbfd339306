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

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.model.checks import real_number, require, whole_number
from powered_walker_env.poincare.gaits import Gait
from powered_walker_env.poincare.regulator import regulate
from powered_walker_env.poincare.stochastic.grid import Grid
from powered_walker_env.poincare.stochastic.law import Law
from powered_walker_env.poincare.stochastic.programming import (
    WALKS,
    Problem,
    decided_section,
    placed,
)
from powered_walker_env.poincare.stochastic.steps import (
    Progress,
    Reward,
    StepNoise,
)
from powered_walker_env.poincare.stochastic.tables import (
    TablePolicy,
    controls_between,
    table_policy,
)
from powered_walker_env.poincare.stochastic.walks import (
    disturbed_walks,
)
from powered_walker_env.simulation.strides import Array

COARSER = 2 / 3  # of the counts of nodes


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
    choice: NDArray[np.int16] = field(repr=False)  # (N,) the best control's number; −1: each falls
    values: NDArray[np.float32] = field(repr=False)  # (N,) greatest expected sum
    value: float  # from the gait, pushed once; off the grid nothing comes
    upper: float  # the same, if off the grid came all that could
    coarser: float  # value on a grid of two thirds of the nodes
    fewer: float  # value with every other value of each number of the control only
    walked: tuple[float, float]  # the sum that the policy comes by in plain walks, standard error

    def __repr__(self) -> str:
        mean, error = self.walked
        return (
            f"Optimum({self.value:.5g} ± {self.error:.2g} in {self.horizon} strides, walked "
            f"{mean:.5g} ± {error:.2g}; {'x'.join(map(str, self.grid.shape))} nodes, "
            f"{'x'.join(map(str, self.counts))} controls)"
        )

    @property
    def error(self) -> float:
        """Of the value, by refinement of the grid and of the controls.

        Half as many controls miss the best by twice as much, which costs four times: a third of
        the change is what is left. No less than the walks leave open, three standard errors.
        """
        grid, controls = abs(self.value - self.coarser), abs(self.value - self.fewer) / 3.0
        return max(grid + controls, abs(self.value - self.walked[0]), 3.0 * self.walked[1])

    @property
    def policy(self) -> TablePolicy:
        """The best control of the first of so many strides, as a policy."""
        choices = controls_between(self.low, self.high, self.counts)
        return table_policy(self.grid, self.choice, choices, self.gait, self.high)


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
    on = decided_section(gait, law.high, noise)
    problem = Problem(gait, law, noise, horizon, discount, reward, branches, push_points, progress)
    box = placed(problem, on, seed) if grid is None else grid
    if grid is None:
        box = box.resized((shape,) * len(box.shape))
    choices = controls_between(law.low, law.high, numbers)
    table = problem.table(box, choices)
    values, chosen = problem.solve(table)
    value = problem.start(table, values)
    least = box.resized([max(4, round(COARSER * n)) for n in box.shape])
    coarse = problem.table(least, choices)
    fewer = _every_other(table, numbers)
    best = table_policy(box, chosen, choices, gait, law.high)
    walked = disturbed_walks(
        gait.params, best, noise, gait.state, strides=horizon, walks=WALKS, seed=seed + 100,
        reward=reward,
    )  # fmt: skip
    return Optimum(
        gait, law.low, law.high, noise, horizon, discount, numbers, box,
        chosen.astype(np.int16), values.astype(np.float32), value,
        problem.start(table, problem.solve(table, most)[0], horizon * most),
        problem.start(coarse, problem.solve(coarse)[0]),
        problem.start(fewer, problem.solve(fewer)[0]), walked.mean_reward,
    )  # fmt: skip


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
