"""The best that any control within bounds can do, by dynamic programming on the section.

With V₀ = 0, V_{n+1}(p) = max_u E[reward + discount · V_n(p')]: the greatest expected reward, or
strides, of n + 1 strides, and the best control of the first of them (R. Bellman, Dynamic
Programming, 1957). p is on the section ahead of every switch (`sections.py`): three numbers that
say all that a decision can know, if the state is seen as it is.

The grid is aligned with what decides where a step leads (`alignment.py`). Controls are tried all
over their bounds first, then about the best of each node, nearer and nearer.

Three things are not exact, and each is measured: the grid between its nodes (a coarser one
beside it), the controls between those tried (the round before beside the last), and what lies
off the grid (nothing comes of it, or the best that could: two bounds). The policy's own walks are
plain simulation: what they come by is a lower bound, whatever the grid.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.model.checks import real_number, require, whole_number
from powered_walker_env.poincare.gaits import Gait
from powered_walker_env.poincare.regulator import regulate
from powered_walker_env.poincare.stochastic.grid import DIMENSIONS, Grid
from powered_walker_env.poincare.stochastic.law import ACROSS, push_counts
from powered_walker_env.poincare.stochastic.noise import StepNoise
from powered_walker_env.poincare.stochastic.programming import (
    CALM,
    Problem,
    about,
    decided_place,
    placed,
    solved,
)
from powered_walker_env.poincare.stochastic.rollout import LookAhead
from powered_walker_env.poincare.stochastic.steps import Progress, Reward
from powered_walker_env.poincare.stochastic.tables import (
    TablePolicy,
    controls_between,
    table_policy,
)
from powered_walker_env.poincare.stochastic.walks import disturbed_walks
from powered_walker_env.simulation.strides import Array

COARSER = 2 / 3  # of the counts of nodes
SHAPE, EVEN = (48, 20, 6), (18, 18, 18)  # of a grid that is aligned, and of one that need not be
UNITS = 32767  # of the stored controls in a half range
WALKS, FEWER, TRIAL = 10_000, 1000, 200  # plain ones: of a table, looking ahead, to choose
WORTH = 0.02  # of the sum, that looking ahead must bring more
RESOLVED = 0.1  # of the value, that its error may be


@dataclass(frozen=True, eq=False)
class Optimum:
    """The greatest expected strides or reward from every node, and how to come by them."""

    gait: Gait  # under its constant control, the middle of the bounds
    low: Array  # (k,) bounds of the control; of the motor: switch angle, stall torque
    high: Array
    noise: StepNoise
    horizon: int  # strides
    discount: float
    counts: tuple[int, ...]  # (k,) values of each number tried at first
    grid: Grid = field(repr=False)
    controls: NDArray[np.int16] = field(repr=False)  # (N, k) the best, 0 to ±UNITS: the bounds
    values: NDArray[np.float16] = field(repr=False)  # (N,) greatest expected sum
    value: float  # from the gait, pushed once; off the grid nothing comes
    upper: float  # the same, if off the grid came all that could
    coarser: float  # value on a grid of two thirds of the nodes
    fewer: float  # value with controls tried twice as far apart
    walked: tuple[float, float]  # the sum that its policy comes by in plain walks, standard error
    looks_ahead: bool = False  # whether its policy does, by a stride, or is the table
    rewarded: bool = True  # by a function; if not, strides are counted

    def __repr__(self) -> str:
        mean, error = self.walked
        return (
            f"Optimum({self.value:.5g} ± {self.error:.2g} in {self.horizon} strides, walked "
            f"{mean:.5g} ± {error:.2g}; {'x'.join(map(str, self.grid.shape))} nodes)"
        )

    @property
    def error(self) -> float:
        """Of the value, by refinement of the grid and of the controls.

        Controls twice as far apart miss the best by twice as much, which costs four times: a third
        of the change is what is left. No less than the walks leave open, three standard errors.
        """
        grid, controls = abs(self.value - self.coarser), abs(self.value - self.fewer) / 3.0
        return max(grid + controls, abs(self.value - self.walked[0]), 3.0 * self.walked[1])

    @property
    def resolved(self) -> bool:
        """Whether the value is known to a tenth; if not, what was walked is a lower bound."""
        return self.error <= RESOLVED * abs(self.value)

    @property
    def table(self) -> TablePolicy:
        """The best control of the first of so many strides, between the nodes: a policy."""
        middle, half = 0.5 * (self.low + self.high), 0.5 * (self.high - self.low)
        numbers = middle + half * (self.controls / UNITS)
        return table_policy(self.grid, numbers, self.gait, self.high)

    def policy(self, reward: Reward | None = None) -> TablePolicy | LookAhead:
        """What walked: the table, or the best by one stride more and the values after it.

        Args:
            reward: the one that the optimum was found for.

        Raises:
            ValueError: a policy that looks ahead, to rewards, and no reward.
        """
        if not self.looks_ahead:
            return self.table
        if self.rewarded and reward is None:
            raise ValueError("reward must be the optimum's for a policy that looks ahead, got none")
        fixed = controls_between(self.low, self.high, [(n + 1) // 2 for n in self.counts])
        return LookAhead(
            self.gait, self.noise, self.table, self.values.astype(np.float64), self.low, self.high,
            fixed, self.discount, reward,
        )  # fmt: skip


def optimum(
    gait: Gait,
    half_range: Sequence[float],
    noise: StepNoise,
    *,
    horizon: int = 100,
    discount: float = 1.0,
    reward: Reward | None = None,
    most: float = 1.0,
    shape: int | Sequence[int] | None = None,
    counts: int | Sequence[int] = 9,
    refinements: int = 3,
    branches: int = 9,
    push_points: int | tuple[int, int] | None = None,
    calm: float = CALM,
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
        shape: nodes along the axes of the grid, the one that decides where a step leads first;
            or along each. Left out, as many along the first as the map wants.
        counts: values of each number of the control tried at first, the bounds included; odd, so
            that the nominal one is among them.
        refinements: rounds after that, two or more, each with the controls about the best at half
            the distance.
        branches, push_points: see `step_law`; left out, `push_counts` of the grid.
        calm: reward that a half range more of a control must be worth for the policy: smooth
            tables walk better between their nodes. The values know nothing of it.
        grid: on a section ahead of every switch; placed where the optimum walks if left out.
        seed: of the walks that place it.
        progress: called with the strides done and those in all, for each table.

    Raises:
        ValueError: a gait of several strides or without a constant control, bad bounds or counts.
    """
    horizon = whole_number("horizon", horizon, 1)
    refinements = whole_number("refinements", refinements, 2)
    discount = real_number("discount", discount)
    require(0.0 < discount <= 1.0, "discount", "lie in (0, 1]", discount)
    law = regulate(gait, half_range)
    numbers, nodes = _counts(counts, len(law.nominal)), _shape(shape)
    on = decided_place(gait, law.high, noise)
    problem = Problem(gait, law, noise, horizon, discount, reward, branches, push_points or ACROSS,
                      progress, calm)  # fmt: skip
    box = placed(problem, on, seed) if grid is None else grid
    problem = replace(problem, push_points=push_points or push_counts(box))
    if grid is None:
        usual = SHAPE if box.aligned else EVEN
        box = box.resized((usual if nodes is None else nodes)[: len(box.shape)])
    choices = controls_between(law.low, law.high, numbers)
    fixed = controls_between(law.low, law.high, [(n + 1) // 2 for n in numbers])
    best = solved(problem.roughly, box, choices)
    step, before = 2.0 / (max(numbers) - 1), best.value
    for number in range(refinements):
        before = best.value
        last = number + 2 >= refinements  # two: the one before the last is held against it
        best = solved(
            problem if last else problem.roughly, box, about(problem, best.numbers, step, fixed)
        )
        step *= 0.5
    least = box.coarser(COARSER)
    known = about(problem, box.at(best.numbers, least.points), 2.0 * step, fixed)
    coarse = solved(problem, least, known)
    controls = np.rint(UNITS * (best.numbers - 0.5 * (law.low + law.high))
                       / (0.5 * (law.high - law.low))).astype(np.int16)  # fmt: skip
    found = Optimum(
        gait, law.low, law.high, noise, horizon, discount, numbers, box, controls,
        best.values.astype(np.float16), best.value,
        problem.start(best.table, problem.solve(best.table, most)[0], horizon * most),
        coarse.value, before, (0.0, 0.0), rewarded=reward is not None,
    )  # fmt: skip
    return _walked(found, reward, seed + 100)


def _walked(found: Optimum, reward: Reward | None, seed: int) -> Optimum:
    """The optimum with what its policy walks: the table's or, where that is clearly more, ahead."""
    kinds = [replace(found, looks_ahead=ahead) for ahead in (False, True)]
    tried = [_sums(each, reward, TRIAL, seed + 1)[0] for each in kinds]
    best = kinds[int(tried[1] > (1.0 + WORTH) * tried[0])]
    walks = FEWER if best.looks_ahead else WALKS
    return replace(best, walked=_sums(best, reward, walks, seed))


def _sums(found: Optimum, reward: Reward | None, walks: int, seed: int) -> tuple[float, float]:
    """Mean and standard error of the sums in plain walks."""
    return disturbed_walks(
        found.gait.params, found.policy(reward), found.noise, found.gait.state,
        strides=found.horizon, walks=walks, seed=seed, reward=reward,
    ).mean_reward  # fmt: skip


def _counts(counts: int | Sequence[int], numbers: int) -> tuple[int, ...]:
    given = tuple(counts) if isinstance(counts, Sequence | np.ndarray) else (counts,) * numbers
    if len(given) != numbers or any(whole_number("counts", n, 3) % 2 == 0 for n in given):
        raise ValueError(f"counts must be odd, one or {numbers}, got {counts!r}")
    return given


def _shape(shape: int | Sequence[int] | None) -> tuple[int, ...] | None:
    """Counts of nodes along three axes, or None as given."""
    if shape is None:
        return None
    given = tuple(shape) if isinstance(shape, Sequence | np.ndarray) else (shape,) * DIMENSIONS
    if len(given) != DIMENSIONS:
        raise ValueError(f"shape must be one count or {DIMENSIONS}, got {shape!r}")
    return tuple(whole_number("shape", n, 4) for n in given)
