"""Basins of attraction: what becomes of a walker from each start.

Every start walks until it falls, until it enters the trapping region of a gait
(`trapping.py`), or for as many strides as are asked for; walkers leave the batch as
their fate is known. Slices show two of the four coordinates of the post-strike state;
the volume in all four is estimated by Monte Carlo with an exact (Clopper–Pearson)
confidence interval.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Unpack

import numpy as np
import scipy.special
from numpy.typing import ArrayLike, NDArray

from powered_walker_env.model.phases import Outcome
from powered_walker_env.model.powering import AnyControl
from powered_walker_env.model.state import check_state
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.gaits import Gait, GaitNotFoundError, find_gait
from powered_walker_env.poincare.maps import Policy, StrideMap, natural_units
from powered_walker_env.poincare.regions.slices import COORDINATES, Slice, starts_of
from powered_walker_env.poincare.stability.trapping import Trap, traps_of
from powered_walker_env.poincare.work.pieces import RunOptions, blocks, run_pieces
from powered_walker_env.simulation.strides import Array

FELL, WALKING = -2, -1  # in `attractor`, besides the gaits' numbers
LONGEST_PERIOD = 8  # looked for in walkers that no gait of the list attracts
SAME = 1e-4  # natural units within which a walker has come back
ROWS = 2000  # starts of a piece
RTOL = 1e-8  # of the strides


@dataclass(frozen=True, eq=False)
class Basin:
    """What became of each start."""

    params: WalkerParams
    control: AnyControl | Policy | None
    grid: Slice | None  # None: a list of states
    limit: int  # strides walked at most
    rtol: float
    gaits: tuple[Gait, ...]  # what the numbers in `attractor` stand for
    states: Array = field(repr=False)  # (N, 4) the starts
    strides: NDArray[np.int64] = field(repr=False)  # (N,) walked before a fall; `limit` if none
    attractor: NDArray[np.int64] = field(repr=False)  # (N,) gait's number; FELL −2, WALKING −1
    settled: NDArray[np.int64] = field(repr=False)  # (N,) strides to the trapping region, else −1
    period: NDArray[np.int64] = field(repr=False)  # (N,) of a walker that still walks; 0: none
    outcome: NDArray[np.int64] = field(repr=False)  # (N,) of the last stride, values of Outcome

    @property
    def attracted_share(self) -> float:
        """Share of the starts that end on a gait of the list."""
        return float(np.mean(self.attractor >= 0))

    @property
    def walking_share(self) -> float:
        """Share of the starts that do not fall within the limit."""
        return float(np.mean(self.attractor != FELL))

    def picture(self, name: str) -> NDArray[Any]:
        """One of the arrays above as (up, across).

        Raises:
            ValueError: a basin of a list of states, which has no picture.
        """
        if self.grid is None:
            raise ValueError("picture needs a basin over a Slice, got one over a list of states")
        values: NDArray[Any] = getattr(self, name)
        return values.reshape(self.grid.shape[::-1])


@dataclass(frozen=True, eq=False)
class BasinVolume:
    """The share of a box in four dimensions from which the walker converges to a gait."""

    basin: Basin = field(repr=False)  # of the random starts
    low: Array  # (4,) corners of the box, rad and rad/s
    high: Array
    seed: int
    confidence: float
    share: float  # of the box
    share_low: float  # Clopper–Pearson bounds
    share_high: float

    @property
    def box_volume(self) -> float:
        """Of the box, rad⁴/s²."""
        return float(np.prod(self.high - self.low))

    @property
    def volume(self) -> tuple[float, float, float]:
        """Estimate, lower and upper bound, rad⁴/s²."""
        box = self.box_volume
        return self.share * box, self.share_low * box, self.share_high * box


def basin(
    params: WalkerParams,
    control: AnyControl | Policy | None,
    grid: Slice | ArrayLike,
    *,
    strides: int = 100,
    gaits: Sequence[Gait] | None = None,
    rtol: float = RTOL,
    **run: Unpack[RunOptions],
) -> Basin:
    """What happens from each start: strides survived, attractor.

    Args:
        params: the walker.
        control: a constant control, None for a passive walker, or a policy.
        grid: a `Slice`, or states (N, 4).
        strides: walked at most.
        gaits: stable gaits that may attract; found (`find_gait`) if left out.
        rtol: of the strides.
        run: where it runs, see `run_pieces`.

    Raises:
        ValueError: an unstable gait in the list, states of a wrong shape.
    """
    states = starts_of(grid)
    if strides < 1:
        raise ValueError(f"strides must be at least 1, got {strides!r}")
    stable = _default_gaits(params, control) if gaits is None else tuple(gaits)
    stride_map, traps = StrideMap(params, control, rtol), traps_of(stable)
    work = [_Work(stride_map, states[part], traps, strides) for part in blocks(len(states), ROWS)]
    fates = run_pieces(fate, work, **run)
    arrays = [np.concatenate(parts) for parts in zip(*fates, strict=True)]
    shape = grid if isinstance(grid, Slice) else None
    return Basin(params, control, shape, strides, rtol, stable, states, *arrays)


def basin_volume(
    params: WalkerParams,
    control: AnyControl | Policy | None,
    low: Sequence[float],
    high: Sequence[float],
    *,
    samples: int = 10_000,
    seed: int = 0,
    confidence: float = 0.95,
    strides: int = 100,
    gaits: Sequence[Gait] | None = None,
    **run: Unpack[RunOptions],
) -> BasinVolume:
    """Share of a box of starts that converge to a gait, by seeded Monte Carlo.

    Args:
        low, high: (4,) corners of the box, rad and rad/s.
        samples: uniform random starts.
        confidence: of the exact binomial interval (Clopper and Pearson 1934), which
            covers at least that often. It covers chance, not the limit of strides: a
            walker still under way counts as not converged.
        The rest as in `basin`.
    """
    bottom, top = np.array(check_state(low)), np.array(check_state(high))
    if (bottom >= top).any():
        raise ValueError(f"low must be below high in all four, got {low!r} and {high!r}")
    if not (samples >= 1 and 0 < confidence < 1):
        raise ValueError(
            f"samples must be at least 1 and confidence in (0, 1), got {samples!r}, {confidence!r}"
        )
    starts = np.random.default_rng(seed).uniform(bottom, top, (samples, 4))
    found = basin(params, control, starts, strides=strides, gaits=gaits, **run)
    hits = int(np.count_nonzero(found.attractor >= 0))
    bounds = clopper_pearson(hits, samples, confidence)
    return BasinVolume(found, bottom, top, seed, confidence, hits / samples, *bounds)


def clopper_pearson(hits: int, samples: int, confidence: float) -> tuple[float, float]:
    """Exact confidence bounds of a share, from hits out of samples."""
    tail = 0.5 * (1.0 - confidence)
    inverse = scipy.special.betaincinv
    low = inverse(hits, samples - hits + 1, tail) if hits else 0.0
    high = inverse(hits + 1, samples - hits, 1.0 - tail) if hits < samples else 1.0
    return float(low), float(high)


class _Work(NamedTuple):
    """A piece: some starts, and all that decides their fate."""

    stride_map: StrideMap
    states: Array
    traps: tuple[Trap, ...]
    strides: int


def fate(work: _Work) -> tuple[NDArray[np.int64], ...]:
    """(strides, attractor, settled, period, outcome) of the starts of a piece."""
    stride_map, states, traps, limit = work
    count = len(states)
    walked, attractor = np.full(count, limit), np.full(count, WALKING)
    settled, outcome = np.full(count, -1), np.full(count, int(Outcome.WALKED))
    rows = np.arange(count)
    recent: list[Array] = []  # the last states of the walkers still under way
    for k in range(limit + 1):
        for number, trap in enumerate(traps):
            caught = trap.holds(states)
            attractor[rows[caught]], settled[rows[caught]] = number, k
            keep = ~caught
            rows, states, recent = rows[keep], states[keep], [old[keep] for old in recent]
        if k == limit or not len(rows):
            break
        recent = [*recent[-LONGEST_PERIOD + 1 :], states]
        batch = stride_map.strides(states)
        fell = rows[~batch.walked]
        walked[fell], attractor[fell] = k, FELL
        outcome[rows] = batch.outcome
        keep = batch.walked
        rows, states = rows[keep], batch.state[keep]
        recent = [old[keep] for old in recent]
    period = np.zeros(count, np.int64)
    period[rows] = _periods(stride_map.params, states, recent)
    return walked, attractor, settled, period, outcome


def _periods(params: WalkerParams, states: Array, recent: list[Array]) -> NDArray[np.int64]:
    """After how many strides, at least, each walker comes back to where it is; 0 if never."""
    period = np.zeros(len(states), np.int64)
    for back, old in enumerate(reversed(recent), start=1):
        moved = np.linalg.norm((states - old) / natural_units(params), axis=1)
        period[(period == 0) & (moved <= SAME)] = back
    return period


def _default_gaits(params: WalkerParams, control: AnyControl | Policy | None) -> tuple[Gait, ...]:
    try:
        gait = find_gait(params, control)
    except GaitNotFoundError:
        return ()
    return (gait,) if gait.stable else ()


__all__ = [
    "COORDINATES",
    "FELL",
    "WALKING",
    "Basin",
    "BasinVolume",
    "Slice",
    "basin",
    "basin_volume",
    "clopper_pearson",
]
