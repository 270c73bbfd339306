"""First passage: how long a disturbed walker walks before it falls (Byl and Tedrake 2009).

A walker that is disturbed at every step falls for certain, some day, and may walk long before:
it is metastable. Its steps are a Markov chain with one absorbing state, the fall. The second
eigenvalue λ₂ of the transition matrix is the share of the walks under way that goes on at every
stride once the start is forgotten, and 1/(1 − λ₂) the mean first passage time (K. Byl and
R. Tedrake, Metastable walking machines, Int. J. Robotics Research 28 (2009) 1040-1064).

Found on a grid of the section that holds where walks are that go on for a while; who leaves it is
all but lost, and walks some strides more in the mean: `after`, as walked, is added.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from powered_walker_env.model.checks import whole_number
from powered_walker_env.model.powering import AnyControl, Policy
from powered_walker_env.model.state import PostStrikeState, check_state
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.branches.starts import stable_gait
from powered_walker_env.poincare.sections import Section, section_of
from powered_walker_env.poincare.stochastic.checks import check_policy
from powered_walker_env.poincare.stochastic.grid import Grid
from powered_walker_env.poincare.stochastic.law import Law
from powered_walker_env.poincare.stochastic.noise import StepNoise
from powered_walker_env.poincare.stochastic.steps import Progress, Stepper, step_law
from powered_walker_env.poincare.stochastic.walks import MEMORY, Visits, Walks, grid_around, visits
from powered_walker_env.poincare.tolerances import FATE_RTOL
from powered_walker_env.simulation.strides import Array

SETTLED = 1e-10  # change of the eigenvalue from stride to stride, at which it stands
MOST_STRIDES = 5000  # of the iteration
COARSER = 2 / 3  # of the counts of the grid: how far its refinement is looked at
FEWEST = 100  # points of walks well under way that a grid can be placed by


@dataclass(frozen=True, eq=False)
class FirstPassage:
    """How long walks last: from the table, from one coarser, and as walked."""

    params: WalkerParams
    control: AnyControl | Policy | None
    noise: StepNoise
    start: PostStrikeState  # before its first push
    grid: Grid = field(repr=False)
    walks: Walks = field(repr=False)  # plain simulation
    second_eigenvalue: float  # λ₂
    coarser_eigenvalue: float  # the same on a grid of two thirds of the counts
    strides_on_grid: float  # mean, from the start, of those that end on the grid
    coarser_strides: float
    after: float  # mean strides that a walker walks once it has left the grid
    leaving: float  # share of the walks that leave the grid, and do not fall from it
    survival: Array = field(repr=False)  # (n + 1,) probability to stay on the grid n strides
    values: Array = field(repr=False)  # (N,) mean strides from each node, on the grid

    def __repr__(self) -> str:
        mean, error = self.walks.mean
        return (
            f"FirstPassage(second eigenvalue {self.second_eigenvalue:.4f} ± "
            f"{self.eigenvalue_error:.1g}, mean {self.mean_first_passage:.4g} strides; from the "
            f"start {self.mean_strides:.4g}, walked {mean:.4g} ± {error:.2g})"
        )

    @property
    def mean_first_passage(self) -> float:
        """1/(1 − λ₂), strides: of a walker that has forgotten its start."""
        return 1.0 / (1.0 - self.second_eigenvalue)

    @property
    def mean_strides(self) -> float:
        """Mean strides from the start to the fall."""
        return self.strides_on_grid + self.leaving * (1.0 + self.after)

    @property
    def eigenvalue_error(self) -> float:
        """By refinement, from the coarser grid to this one; no less than off what is walked."""
        off = abs(1.0 - self.second_eigenvalue - self.walks.fall_rate()[0])
        refined = abs(self.second_eigenvalue - self.coarser_eigenvalue)
        return max(refined, 0.0 if math.isnan(off) else off)

    @property
    def strides_error(self) -> float:
        """Of the mean strides, by refinement; no less than off what is walked, in proportion.

        Where walks are cut off at their limit the table's are, too, before they are compared.
        """
        cut = float(self.survival[1:].sum()) + self.leaving * (1.0 + self.after)
        mean, _ = self.walks.mean
        off = abs(cut - mean) / cut if cut > 0.0 else math.inf
        return max(abs(self.strides_on_grid - self.coarser_strides), off * self.mean_strides)


def first_passage(
    params: WalkerParams,
    control: AnyControl | Policy | None,
    noise: StepNoise,
    start: PostStrikeState | Sequence[float] | None = None,
    *,
    shape: int = 40,
    walks: int = 4000,
    limit: int = 1000,
    branches: int = 49,
    push_points: int = 11,
    seed: int = 0,
    section: Section | None = None,
    progress: Progress | None = None,
) -> FirstPassage:
    """The mean first passage time to a fall, and the second eigenvalue of the step's law.

    Args:
        params: the walker.
        control: constant, None for a passive walker, or a policy; on a hip angle one that is
            `on_section` (`Policy`), as the optimum's. What decides by four numbers at heel
            strike is walked (`disturbed_walks`).
        noise: what disturbs every step.
        start: post-strike state, before a first push; left out, the most stable gait's.
        shape: nodes along each axis of the grid.
        walks, limit: of the simulation: how many, and strides of each at most.
        branches, push_points: see `step_law`.
        seed: of the simulation.
        section: left out, `section_of` the walker.

    Raises:
        GaitNotFoundError: no start, and no gait.
        ValueError: no noise; walks so short that no grid can be placed; a hip angle, and a policy
            that is not `on_section`.
    """
    shape = whole_number("shape", shape, 6)
    if noise == StepNoise():
        raise ValueError("noise must disturb the walker, or it never falls, got none")
    here = check_state(stable_gait(params, control).state if start is None else start)
    on = disturbed_section(params, control, noise) if section is None else section
    check_policy(on, control)
    found, met = visits(params, control, noise, here, on, strides=limit, walks=walks, seed=seed)
    going = met.ahead >= min(MEMORY, limit)
    if going.sum() < FEWEST:
        raise ValueError(
            f"noise must leave walks of {MEMORY} strides to place a grid by, got {noise}: "
            f"{found.mean[0]:.3g} strides in the mean; take less, or more walks"
        )
    grid = grid_around(met.point[going], on, (shape,) * len(on.coordinates))
    answers = []
    for count in (max(4, round(COARSER * shape)), shape):
        table = grid.resized((count,) * len(on.coordinates))
        law = step_law(
            params, control, table, noise, branches=branches, push_points=push_points,
            progress=progress,
        )  # fmt: skip
        at = start_places(Stepper(params, control, table, noise, FATE_RTOL), np.array(here), law)
        answers.append(_passage(law, *at, limit))
    coarse, fine = answers
    after, leaving = _left(grid, met, found)
    return FirstPassage(
        params, control, noise, here, grid, found, fine[0], coarse[0], fine[1], coarse[1], after,
        leaving, fine[2], fine[3],
    )  # fmt: skip


def disturbed_section(
    params: WalkerParams, control: AnyControl | Policy | None, noise: StepNoise
) -> Section:
    """The section that disturbed strides are looked at on: the feet only where they stay on it."""
    on = section_of(params, control, level=noise.level)
    pushed_off = on.hip_angle is None and noise.push > 0 and len(on.coordinates) < 3
    return section_of(params, control, level=False) if pushed_off else on


def start_places(stepper: Stepper, state: Array, law: Law) -> tuple[Array, Array]:
    """(Q, k) points where a start and its push lead to, and (Q,) their weights; NaN: nowhere."""
    pushed = np.tile(state, (len(law.weights), 1))
    pushed[:, 2:] += stepper.noise.push * law.points
    return stepper.section.points(pushed, stepper.rtol), law.weights


def mean_at(grid: Grid, values: Array, points: Array, weights: Array) -> float:
    """The mean of a table at weighted points; those off the grid, or NaN, count 0."""
    inside = grid.holds(grid.places(np.where(np.isfinite(points), points, np.inf)))
    return float(weights[inside] @ grid.at(values[:, np.newaxis], points[inside])[:, 0])


def _passage(
    law: Law, points: Array, weights: Array, limit: int
) -> tuple[float, float, Array, Array]:
    """(second eigenvalue, mean strides from the start, survival, mean strides from each node)."""
    grid = law.grid
    alive, total = np.ones(grid.size), np.zeros(grid.size)
    survival, last, share = [mean_at(grid, alive, points, weights)], math.nan, 0.0
    for _ in range(MOST_STRIDES):
        after, _ = law.best(alive, gain=0.0)
        total += after
        # A Rayleigh quotient of the survivors: it stands once only the slowest mode is left.
        size = float(alive @ alive)
        share = float(after @ alive) / size if size > 0 else 0.0
        alive = after
        if len(survival) <= limit:
            survival.append(mean_at(grid, alive, points, weights))
        if not alive.any() or (abs(share - last) < SETTLED and len(survival) > MEMORY):
            break
        last = share
    if share < 1.0:
        total += alive * share / (1.0 - share)
    more = survival[-1] * share ** np.arange(1, limit + 2 - len(survival))
    known = np.minimum(np.concatenate([survival, more]), 1.0)  # but for rounding
    return share, mean_at(grid, total, points, weights), known, total


def _left(grid: Grid, met: Visits, found: Walks) -> tuple[float, float]:
    """Mean strides walked after leaving the grid, and the share of the walks that leave it."""
    outside = ~grid.holds(grid.places(met.point))
    gone, first = np.unique(met.walk[outside], return_index=True)
    ended = found.fell[gone]
    ahead = met.ahead[outside][first][ended]
    finished = int(found.fell.sum())
    if not len(ahead) or not finished:
        return 0.0, 0.0
    return float(ahead.mean()), len(ahead) / finished
