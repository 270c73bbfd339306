"""The law of a walker's next step, from exact strides: one for each node, choice and branch.

A stride from a node under a control is deterministic up to its landing; what disturbs it before
(the height of the ground, the strength of the control) is a sum over branches, each a stride of
its own. What comes after, the push on both leg rates at the heel strike, carries the walker to
the section around the landing's own place there: the swing to the section is taken at seven pushes
a row, and a quadratic through them: the one approximation besides the grid's.

Steps of the ground are independent of each other: the rise of each is drawn anew.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.model.mechanics.packing import pack
from powered_walker_env.model.powering import STRENGTH, AnyControl, Policy, numbers_for, scheme_of
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.stochastic.checks import check_policy, check_section
from powered_walker_env.poincare.stochastic.grid import DIMENSIONS, AnySection, Grid
from powered_walker_env.poincare.stochastic.law import Law, normal_points, turned
from powered_walker_env.poincare.stochastic.noise import Branches, StepNoise, branches_of
from powered_walker_env.poincare.tolerances import FATE_RTOL
from powered_walker_env.simulation.strides import Array, run_batch
from powered_walker_env.simulation.walked import StrideBatch

Progress = Callable[[int, int], None]
#: Expected worth of strides: (M, 4) post-strike states, pushes included, to (M,) numbers.
Reward = Callable[[Array], Array]

CHUNK = 1_000_000  # strides at once: 200 MB
#: Standard deviations of the pushes through whose swings a quadratic is laid; where the farther
#: ones do not come to the section, the nearer.
REACHES = (2.5, 0.1)
RATES = slice(2, 4)


class Stepper(NamedTuple):
    """A walker and what disturbs it, on a grid: turns states and controls into rows."""

    params: WalkerParams
    kind: AnyControl | Policy | None  # a control of the scheme
    grid: Grid
    noise: StepNoise
    rtol: float

    @property
    def section(self) -> AnySection:
        """The grid's."""
        assert self.grid.section is not None
        return self.grid.section

    def strides(self, states: Array, numbers: Array, heights: Array) -> StrideBatch:
        """Strides under these numbers (N, k) of the control onto these heights."""
        scheme, row = scheme_of(self.kind), pack(self.params)[np.newaxis]
        return run_batch(scheme.cycle, states, scheme.rows(numbers), row, heights, self.rtol)

    def landed(self, states: Array) -> tuple[Array, Array, Array]:
        """(N, 3) straight places of post-strike states; (N, 3, 2), (N, 3, 3) by a push, in nodes.

        By a standard deviation of either push, and by their squares and product. NaN where the
        swing does not come to the section.
        """
        places = self._swung(states)
        gain, bend = np.zeros((len(states), DIMENSIONS, 2)), np.zeros((len(states), DIMENSIONS, 3))
        if self.noise.push > 0.0:
            left = np.arange(len(states))
            for reach in REACHES:
                gain[left], bend[left] = self._pushed(states[left], places[left], reach)
                left = left[np.isnan(gain[left]).any(axis=(1, 2))]
        return places, gain, bend

    def _swung(self, states: Array) -> Array:
        return self.grid.straight_places(self.section.points(states, self.rtol))

    def _pushed(self, states: Array, places: Array, reach: float) -> tuple[Array, Array]:
        """The quadratic through the places and those under six pushes of a size."""
        pushes = np.array([(1.0, 0.0), (0.0, 1.0), (math.sqrt(0.5), math.sqrt(0.5))]) * reach
        odd, even = [], []
        for push in pushes * self.noise.push:
            moved = np.tile(states, (2, 1))
            moved[:, RATES] += np.repeat([push, -push], len(states), axis=0)
            ahead, behind = np.split(self._swung(moved), 2)
            odd.append((ahead - behind) / (2.0 * reach))
            even.append((ahead + behind - 2.0 * places) / (2.0 * reach**2))
        (first, second, _), (p, r, across) = odd, even
        return np.stack([first, second], axis=2), np.stack([p, 2.0 * across - p - r, r], axis=2)

    def worth(self, landed: Array, reward: Reward | None, points: Array, weights: Array) -> Array:
        """(N,) expected rewards over the pushes; 1 without a reward."""
        if reward is None:
            return np.ones(len(landed))
        total = np.zeros(len(landed))
        for point, weight in zip(points, weights, strict=True):
            pushed = landed.copy()
            pushed[:, RATES] += self.noise.push * point
            total += weight * reward(pushed)
        return total


def step_law(
    params: WalkerParams,
    control: AnyControl | Policy | None,
    grid: Grid,
    noise: StepNoise,
    *,
    choices: Array | None = None,
    reward: Reward | None = None,
    branches: int = 33,
    push_points: int | tuple[int, int] = 5,
    rtol: float = FATE_RTOL,
    progress: Progress | None = None,
) -> Law:
    """The law of the next step from every node of a grid on the walker's section.

    Args:
        params: the walker.
        control: constant, None for a passive walker, or a policy of the states at the nodes; with
            choices any control of the scheme that they are numbers of.
        grid: on a section (`Section`): a hip angle where the ground is not level.
        noise: what disturbs every step.
        choices: (A, k) numbers of the controls to choose from, or (N, A, k) for each node; left
            out, the control decides.
        reward: of post-strike states, pushes included; a stride walked counts 1 if left out.
        branches: heights, and strengths, that stand for their normal draws.
        push_points: of Gauss and Hermite for each of the two rates pushed; or two counts, along
            the grid's first axis and across it.
        rtol: of the strides.
        progress: called with the strides done and those in all.

    Raises:
        ValueError: a grid of no walker's section, or one on the feet where the noise leaves it; a
            hip angle, and a policy that is not `on_section`.
    """
    check_section(grid, level=noise.level, pushed=noise.push > 0)
    if choices is None and grid.section is not None:
        check_policy(grid.section, control)
    points, weights = (
        normal_points(push_points) if noise.push > 0 else (np.zeros((1, 2)), np.ones(1))
    )
    drawn = branches_of(noise, branches)
    stepper, turn = Stepper(params, control, grid, noise, rtol), isinstance(push_points, tuple)
    states = grid.states
    each = len(drawn.share) * (1 if choices is None else choices.shape[-2])
    size = max(1, CHUNK // each)
    parts = []
    for first in range(0, len(states), size):
        some = states[first : first + size]
        if choices is None:
            numbers = numbers_for(control, some)[:, np.newaxis]
        else:
            numbers = choices[first : first + size] if choices.ndim == 3 else choices
        parts.append(rows_from(stepper, some, numbers, drawn, reward, points, weights, turn))
        if progress is not None:
            progress(min(first + size, len(states)) * each, len(states) * each)
    counts, choice, share, mean, gain, bend, worth = (
        np.concatenate(column) for column in zip(*parts, strict=True)
    )
    begin = np.concatenate([[0], np.cumsum(counts)])
    return Law(grid, begin, choice, share, mean, gain, worth, points, weights, bend)


def rows_from(
    stepper: Stepper, states: Array, numbers: Array, drawn: Branches, reward: Reward | None,
    points: Array, weights: Array, turn: bool,
) -> tuple[NDArray[Any], ...]:  # fmt: skip
    """(counts of rows by node, and the rows' columns) from some nodes.

    Args:
        numbers: (A, k) choices at every node, or (n, A, k) at each its own.
    """
    n, a, b = len(states), numbers.shape[-2], len(drawn.share)
    scheme = scheme_of(stepper.kind)
    full = np.broadcast_to(numbers if numbers.ndim == 3 else numbers[np.newaxis],
                           (n, a, numbers.shape[-1]))  # fmt: skip
    chosen = np.repeat(full.reshape(n * a, -1), b, axis=0)
    if stepper.noise.strength > 0.0 and STRENGTH in scheme.columns:
        place = scheme.columns.index(STRENGTH)
        chosen[:, place] *= np.tile(drawn.factor, n * a)
        if scheme.positive:
            chosen[:, place] = np.maximum(chosen[:, place], 0.0)
    heights = np.tile(drawn.height, n * a)
    batch = stepper.strides(np.repeat(states, a * b, axis=0), chosen, heights)
    rows = np.flatnonzero(batch.walked)
    landed = batch.state[rows]
    mean, gain, bend = stepper.landed(landed)
    gain, bend = turned(gain, bend) if turn else (gain, bend)
    worth = stepper.worth(landed, reward, points, weights)
    # A stride that walked is worth its reward even if nothing follows: its place is off the grid.
    gone = np.isnan(mean).any(axis=1) | np.isnan(gain).any(axis=(1, 2))
    mean[gone], gain[gone], bend[gone] = -1.0, 0.0, 0.0
    node = rows // (a * b)
    return (
        np.bincount(node, minlength=n),
        (rows // b % a).astype(np.int32),
        drawn.share[rows % b],
        mean.astype(np.float32),
        gain.astype(np.float32),
        bend.astype(np.float32),
        worth.astype(np.float32),
    )
