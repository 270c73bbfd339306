"""Plain simulation of disturbed walks: what the tables are checked against, and placed by."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.model.checks import whole_number
from powered_walker_env.model.mechanics.packing import pack
from powered_walker_env.model.powering import STRENGTH, AnyControl, Policy, numbers_for, scheme_of
from powered_walker_env.model.state import check_state
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.stochastic.grid import AnySection, Grid
from powered_walker_env.poincare.stochastic.noise import StepNoise
from powered_walker_env.poincare.stochastic.steps import RATES, Reward
from powered_walker_env.poincare.tolerances import FATE_RTOL
from powered_walker_env.simulation.strides import Array, run_batch
from powered_walker_env.simulation.walked import StrideBatch

MEMORY = 8  # strides after which a walk that goes on counts as well under way
TAIL = 5e-4  # share of the points along each axis that a grid may leave out on either side
MARGIN = 1.1  # of a grid's box over what it must hold


@dataclass(frozen=True, eq=False)
class Walks:
    """Disturbed walks from one start."""

    limit: int  # strides walked at most
    seed: int
    strides: NDArray[np.int64] = field(repr=False)  # (N,) walked before a fall; `limit` if none
    fell: NDArray[np.bool_] = field(repr=False)  # (N,)
    rewards: Array = field(repr=False)  # (N,) summed; the strides, if no reward was asked for

    @property
    def mean(self) -> tuple[float, float]:
        """Mean strides, and its standard error; of at most `limit`."""
        return _mean(self.strides)

    @property
    def mean_reward(self) -> tuple[float, float]:
        """Mean of the summed rewards, and its standard error."""
        return _mean(self.rewards)

    def survival(self, strides: int) -> Array:
        """(strides + 1,) shares that walked so many strides or more."""
        counts = np.arange(min(strides, self.limit) + 1)
        share: Array = (self.strides >= counts[:, np.newaxis]).mean(axis=1)
        return share

    def fall_rate(self, after: int = MEMORY) -> tuple[float, float]:
        """Falls by stride once the start is forgotten, and their standard error."""
        late = self.strides >= after
        tries = int((self.strides[late] - after).sum() + self.fell[late].sum())
        rate = float(self.fell[late].sum()) / tries if tries else float("nan")
        return rate, float(np.sqrt(rate * (1.0 - rate) / tries)) if tries else float("nan")


class Visits(NamedTuple):
    """Where decisions were made: walks' points on a section, in the order of the strides."""

    point: Array  # (M, k)
    walk: NDArray[np.int64]  # (M,) number of the walk
    ahead: NDArray[np.int64]  # (M,) strides that it still walked; those beyond the limit unseen


def disturbed_walks(
    params: WalkerParams,
    control: AnyControl | Policy | None,
    noise: StepNoise,
    start: Sequence[float],
    *,
    strides: int = 100,
    walks: int = 2000,
    seed: int = 0,
    reward: Reward | None = None,
    rtol: float = FATE_RTOL,
) -> Walks:
    """Walk from one state again and again, disturbed at every step; the first push comes at once.

    Args:
        params, control: the walker; a control, none, or a policy.
        noise: what disturbs every step.
        start: post-strike state.
        strides: of each walk, at most.
        walks: how many.
        reward: of post-strike states (N, 4), summed over the strides walked.

    Raises:
        ValueError, TypeError: counts that make no sense, a state that is none.
    """
    found, _ = _walk(params, control, noise, start, strides, walks, seed, reward, rtol, None)
    return found


def visits(
    params: WalkerParams, control: AnyControl | Policy | None, noise: StepNoise,
    start: Sequence[float], section: AnySection, *, strides: int = 100, walks: int = 2000,
    seed: int = 0, rtol: float = FATE_RTOL,
) -> tuple[Walks, Visits]:  # fmt: skip
    """The same walks, and where they were on a section at every decision."""
    found, met = _walk(params, control, noise, start, strides, walks, seed, None, rtol, section)
    points, numbers, counts = (np.concatenate(column) for column in zip(*met, strict=True))
    good = np.isfinite(points).all(axis=1)
    ahead = found.strides[numbers] - counts
    return found, Visits(points[good], numbers[good], ahead[good])


def _walk(
    params: WalkerParams, control: AnyControl | Policy | None, noise: StepNoise,
    start: Sequence[float], strides: int, walks: int, seed: int, reward: Reward | None,
    rtol: float, section: AnySection | None,
) -> tuple[Walks, list[tuple[Array, NDArray[np.int64], NDArray[np.int64]]]]:  # fmt: skip
    strides, walks = whole_number("strides", strides, 1), whole_number("walks", walks, 1)
    rng = np.random.default_rng(seed)
    states = np.tile(np.array(check_state(start)), (walks, 1))
    states[:, RATES] += rng.normal(0.0, 1.0, (walks, 2)) * noise.push
    going, walked = np.arange(walks), np.full(walks, strides)
    rewards, met = np.zeros(walks), []
    for k in range(strides):
        if section is not None:
            met.append((section.points(states, rtol), going, np.full(len(going), k)))
        batch = disturbed_strides(params, control, noise, states, rng, rtol)
        walked[going[~batch.walked]] = k
        going, states = going[batch.walked], batch.state[batch.walked]
        states[:, RATES] += rng.normal(0.0, 1.0, (len(states), 2)) * noise.push
        rewards[going] += 1.0 if reward is None else reward(states)
        if not len(going):
            break
    fell = np.ones(walks, np.bool_)
    fell[going] = False
    return Walks(strides, seed, walked, fell, rewards), met


def disturbed_strides(
    params: WalkerParams, control: AnyControl | Policy | None, noise: StepNoise, states: Array,
    rng: np.random.Generator, rtol: float,
) -> StrideBatch:  # fmt: skip
    """One stride from each state, disturbed up to its landing."""
    scheme, numbers = scheme_of(control), numbers_for(control, states)
    heights = rng.normal(0.0, 1.0, len(states)) * noise.step_height
    if noise.strength > 0.0 and STRENGTH in scheme.columns:
        place = scheme.columns.index(STRENGTH)
        numbers = numbers.copy()
        numbers[:, place] *= 1.0 + rng.normal(0.0, noise.strength, len(states))
        if scheme.positive:
            numbers[:, place] = np.maximum(numbers[:, place], 0.0)
    row = pack(params)[np.newaxis]
    return run_batch(scheme.cycle, states, scheme.rows(numbers), row, heights, rtol)


def grid_around(
    points: Array, section: AnySection | None, shape: Sequence[int], tail: float = TAIL,
    margin: float = MARGIN,
) -> Grid:  # fmt: skip
    """The grid whose box, along the cloud's own axes, holds all points but the tails.

    Args:
        points: (M, k) on the section.
        shape: (k,) nodes along the axes, the cloud's shortest first.
        tail: share of the points left out on either side of each axis.
        margin: of the box over what it holds.
    """
    scale = points.std(axis=0) + 1e-12
    _, axes = np.linalg.eigh(np.cov((points / scale).T).reshape(len(scale), -1))
    frame = scale[:, np.newaxis] * axes
    z = np.linalg.solve(frame, points.T).T
    low, high = np.quantile(z, [tail, 1.0 - tail], axis=0)
    half = np.maximum(0.5 * margin * (high - low), 1e-9)
    return Grid(frame @ (0.5 * (low + high)), frame * half, tuple(shape), section)


def _mean(values: Array | NDArray[np.int64]) -> tuple[float, float]:
    count = len(values)
    error = float(np.std(values, ddof=1)) / count**0.5 if count > 1 else float("nan")
    return float(np.mean(values)), error
