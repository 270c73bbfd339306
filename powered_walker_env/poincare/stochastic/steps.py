"""The law of a walker's next step, from exact strides: one for each node, choice and branch.

A stride from a node under a control is deterministic up to its landing; what disturbs it before
(the height of the ground, the strength of the control) is a sum over branches, each a stride of
its own. What comes after, the push on both leg rates at the heel strike, carries the walker to
section places that are normal around the landing's own: the swing to the section is differenced
there, twice a row: the one approximation besides the grid's.

Steps of the ground are independent of each other: the rise of each is drawn anew.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.model.checks import real_number, require, whole_number
from powered_walker_env.model.mechanics.packing import pack
from powered_walker_env.model.powering import STRENGTH, AnyControl, Policy, numbers_for, scheme_of
from powered_walker_env.model.state import natural_units
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.stochastic.checks import check_policy, check_section
from powered_walker_env.poincare.stochastic.grid import DIMENSIONS, AnySection, Grid
from powered_walker_env.poincare.stochastic.law import Law, normal_points, turned
from powered_walker_env.poincare.tolerances import FATE_RTOL
from powered_walker_env.simulation.strides import Array, run_batch
from powered_walker_env.simulation.walked import StrideBatch

Progress = Callable[[int, int], None]
#: Expected worth of strides: (M, 4) post-strike states, pushes included, to (M,) numbers.
Reward = Callable[[Array], Array]

CHUNK = 1_000_000  # strides at once: 200 MB
STENCIL = 1e-4  # natural units of a rate, of the differences of the swing
RATES = slice(2, 4)


@dataclass(frozen=True)
class StepNoise:
    """What disturbs every step, as standard deviations of normal draws; 0 is none.

    Raises:
        ValueError: negative or not finite.
    """

    push: float = 0.0  # rad/s, on both leg rates after every heel strike, independent
    step_height: float = 0.0  # m, rise of the ground at every step, independent of the one before
    strength: float = 0.0  # share of the control's strength, at every stride

    def __post_init__(self) -> None:
        for name in ("push", "step_height", "strength"):
            value = real_number(name, getattr(self, name))
            require(value >= 0, name, "not be negative", value)
            object.__setattr__(self, name, value)

    @property
    def level(self) -> bool:
        """Whether the ground is."""
        return self.step_height == 0.0


class Branches(NamedTuple):
    """Draws before the landing, with their shares."""

    height: Array  # (B,) m
    factor: Array  # (B,) of the strength
    share: Array  # (B,)


def branches_of(noise: StepNoise, count: int) -> Branches:
    """The draws that stand for the noise before a landing: `count` of each kind that there is.

    Equal spaces over ±4 standard deviations with the normal law's masses: a fall sets in at a
    height, which Gauss and Hermite's few points would see or miss.
    """
    axes = []
    for size in (noise.step_height, noise.strength):
        n = whole_number("branches", count, 2) if size > 0 else 1
        edges = np.linspace(-4.0, 4.0, n + 1)
        mass = np.diff([0.5 * math.erf(edge / math.sqrt(2.0)) for edge in edges])
        axes.append(
            (size * 0.5 * (edges[1:] + edges[:-1]) if n > 1 else np.zeros(1), mass / mass.sum())
        )
    (heights, first), (factors, second) = axes
    grids = np.meshgrid(heights, 1.0 + factors, indexing="ij")
    return Branches(grids[0].ravel(), grids[1].ravel(), np.outer(first, second).ravel())


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

    def landed(self, states: Array) -> tuple[Array, Array]:
        """(N, 3) straight places of post-strike states, and (N, 3, 2) by a push, in nodes.

        NaN where the swing does not come to the section.
        """
        places = self.grid.straight_places(self.section.points(states, self.rtol))
        gains = np.zeros((len(states), DIMENSIONS, 2))
        if self.noise.push > 0.0:
            steps = STENCIL * natural_units(self.params)[RATES]
            for j in range(2):
                moved = states.copy()
                moved[:, 2 + j] += steps[j]
                beside = self.grid.straight_places(self.section.points(moved, self.rtol))
                gains[:, :, j] = (beside - places) * (self.noise.push / steps[j])
        return places, gains

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
    counts, choice, share, mean, gain, worth = (
        np.concatenate(column) for column in zip(*parts, strict=True)
    )
    begin = np.concatenate([[0], np.cumsum(counts)])
    return Law(grid, begin, choice, share, mean, gain, worth, points, weights)


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
    mean, gain = stepper.landed(landed)
    gain = turned(gain) if turn else gain
    worth = stepper.worth(landed, reward, points, weights)
    # A stride that walked is worth its reward even if nothing follows: its place is off the grid.
    gone = np.isnan(mean).any(axis=1) | np.isnan(gain).any(axis=(1, 2))
    mean[gone], gain[gone] = -1.0, 0.0
    node = rows // (a * b)
    return (
        np.bincount(node, minlength=n),
        (rows // b % a).astype(np.int32),
        drawn.share[rows % b],
        mean.astype(np.float32),
        gain.astype(np.float32),
        worth.astype(np.float32),
    )
