"""Basins of attraction: what becomes of a walker from each start.

Every start walks until it falls, until it enters the trapping region of a gait
(`trapping.py`), or for as many strides as are asked for; walkers leave the batch as
their fate is known.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from powered_walker_env.model.checks import real_number, whole_number
from powered_walker_env.model.phases import Outcome
from powered_walker_env.model.powering import AnyControl, Policy
from powered_walker_env.model.state import natural_units
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.branches.starts import stable_gait
from powered_walker_env.poincare.gaits import Gait, GaitNotFoundError
from powered_walker_env.poincare.maps import StrideMap
from powered_walker_env.poincare.regions.slices import Slice, slice_through, starts_of
from powered_walker_env.poincare.stability.trapping import Trap, traps_of
from powered_walker_env.poincare.tolerances import FATE_RTOL, NEARLY_BACK
from powered_walker_env.poincare.work.pieces import RunOptions, blocks, run_pieces
from powered_walker_env.simulation.arguments import check_rtol
from powered_walker_env.simulation.strides import Array

FELL, WALKING = -2, -1  # in `attractor`, besides the gaits' numbers
LONGEST_CYCLE = 8  # strides, looked for in walkers that no gait of the list attracts
ROWS = 2000  # starts of a piece


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


def basin(
    params: WalkerParams,
    control: AnyControl | Policy | None,
    grid: Slice | ArrayLike | None = None,
    *,
    strides: int = 100,
    gaits: Sequence[Gait] | None = None,
    rtol: float = FATE_RTOL,
    **run: Unpack[RunOptions],
) -> Basin:
    """What happens from each start: strides survived, attractor.

    Args:
        params: the walker.
        control: a constant control, None for a passive walker, or a policy.
        grid: a `Slice`, or states (N, 4); left out, the plane through the gait on the
            section that strides end on, if the walker has one (`slice_through`).
        strides: walked at most.
        gaits: stable gaits that may attract; found (`stable_gait`) if left out.
        rtol: of the strides.
        run: where it runs, see `run_pieces`.

    Raises:
        ValueError: an unstable gait in the list, states of a wrong shape, a tolerance out
            of bounds.
        TypeError: strides that are no whole number.
        GaitNotFoundError: no grid, and no gait to put one around.
    """
    strides = whole_number("strides", strides, 1)
    rtol = check_rtol(real_number("rtol", rtol))
    known = gaits_of(params, control, gaits)
    if grid is None:
        around = known or gaits_of(params, control, None)
        if not around:
            raise GaitNotFoundError("grid must be given for a walker without a gait to look around")
        grid = slice_through(around[0])
    stable = known if gaits is not None else tuple(gait for gait in known if gait.stable)
    states = starts_of(grid)
    stride_map, traps = StrideMap(params, control, rtol), traps_of(stable)
    work = [_Work(stride_map, states[part], traps, strides) for part in blocks(len(states), ROWS)]
    fates = run_pieces(fate, work, **run)
    arrays = [np.concatenate(parts) for parts in zip(*fates, strict=True)]
    shape = grid if isinstance(grid, Slice) else None
    return Basin(params, control, shape, strides, rtol, stable, states, *arrays)


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
        recent = [*recent[-LONGEST_CYCLE + 1 :], states]
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


def gaits_of(
    params: WalkerParams, control: AnyControl | Policy | None, gaits: Sequence[Gait] | None
) -> tuple[Gait, ...]:
    """The gaits given, else the most stable one that is found, if any."""
    if gaits is not None:
        return tuple(gaits)
    try:
        return (stable_gait(params, control),)
    except GaitNotFoundError:
        return ()


def _periods(params: WalkerParams, states: Array, recent: list[Array]) -> NDArray[np.int64]:
    """After how many strides, at least, each walker comes back to where it is; 0 if never."""
    period = np.zeros(len(states), np.int64)
    for back, old in enumerate(reversed(recent), start=1):
        moved = np.linalg.norm((states - old) / natural_units(params), axis=1)
        period[(period == 0) & (moved <= NEARLY_BACK)] = back
    return period
