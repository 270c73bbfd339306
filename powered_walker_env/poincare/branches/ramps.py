"""Brute-force bifurcation diagrams: walk, change a parameter a little, walk on.

The thesis ramped the stall torque (Camp 1997, section 7). Going up and coming down can
end on different gaits where several attract: that is hysteresis, and the two ramps of
a diagram show it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from powered_walker_env.model.checks import real_number, whole_number
from powered_walker_env.model.phases import Outcome
from powered_walker_env.model.powering import AnyControl, Policy
from powered_walker_env.model.state import PostStrikeState, check_state, natural_units
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.branches.starts import changed, starts_along
from powered_walker_env.poincare.maps import StrideMap
from powered_walker_env.poincare.tolerances import RAMP_RTOL, SAME_STATE
from powered_walker_env.poincare.work.pieces import RunOptions, blocks, run_chains
from powered_walker_env.simulation.arguments import check_rtol
from powered_walker_env.simulation.strides import Array

NO_START = -1  # in `outcome`: nothing stable was found to begin with
LINK = 8  # values of a link: the work lost by an interruption
SUDDEN = 1e-3  # of a return to the returns before it: slower than 0.999 a stride is not seen


@dataclass(frozen=True, eq=False)
class Ramp:
    """The states a walker went through as a parameter changed; rows go with the values."""

    states: Array = field(repr=False)  # (n, keep, 4) after the transient; NaN after a fall
    outcome: NDArray[np.int64]  # (n,) how the last stride ended, values of Outcome; NO_START
    restarted: NDArray[np.bool_]  # (n,) begun afresh: it fell from where the value before ended

    @property
    def walked(self) -> NDArray[np.bool_]:
        """(n,) where the walker did not fall."""
        return self.outcome == int(Outcome.WALKED)


@dataclass(frozen=True, eq=False)
class BifurcationDiagram:
    """What walks at each value of a parameter, ramped up and ramped down."""

    params: WalkerParams
    control: AnyControl | Policy | None
    parameter: str
    values: Array  # (n,) ascending
    transient: int  # strides walked at each value before any is kept
    keep: int
    rtol: float
    up: Ramp
    down: Ramp

    def periods(self, ramp: Ramp, within: float = SAME_STATE) -> NDArray[np.int64]:
        """(n,) strides after which the motion repeats; 0: it does not, −1: fell, −2: no start.

        A motion that alternates as it settles nearly repeats, too: of a period n > 1 the
        return after n strides must be far closer than any before.
        """
        units, shifts = natural_units(self.params), range(1, self.keep // 2 + 1)
        returns = np.array(
            [
                np.abs((ramp.states[:, k:] - ramp.states[:, :-k]) / units).max(axis=(1, 2))
                for k in shifts
            ]
        )
        first = np.argmax(returns <= within, axis=0)
        closest = np.take_along_axis(returns, first[np.newaxis], axis=0)[0]
        earlier = np.minimum.accumulate(returns, axis=0)[
            np.maximum(first - 1, 0), range(len(first))
        ]
        repeats = (closest <= within) & ((first == 0) | (closest <= SUDDEN * earlier))
        fallen = np.where(ramp.outcome == NO_START, -2, -1)
        return np.where(ramp.walked, np.where(repeats, first + 1, 0), fallen)

    @property
    def gap(self) -> Array:
        """(n,) Hausdorff distance of the two ramps' states, natural units: hysteresis shows.

        NaN where both fell or one was never begun, inf where one fell.
        """
        units, pairs = (
            natural_units(self.params),
            zip(self.up.states, self.down.states, strict=True),
        )
        gaps = [_hausdorff(one / units, other / units) for one, other in pairs]
        walked = np.array([self.up.walked, self.down.walked])
        begun = np.array([self.up.outcome, self.down.outcome]) != NO_START
        hysteresis = begun.all(axis=0) & walked.any(axis=0)
        return np.where(walked.all(axis=0), gaps, np.where(hysteresis, np.inf, np.nan))


def bifurcation_diagram(
    params: WalkerParams,
    control: AnyControl | Policy | None,
    parameter: str,
    values: ArrayLike,
    *,
    state: PostStrikeState | Sequence[float] | None = None,
    transient: int = 200,
    keep: int = 64,
    rtol: float = RAMP_RTOL,
    **run: Unpack[RunOptions],
) -> BifurcationDiagram:
    """Ramp a parameter up and down, each value starting where the last one ended.

    Both ramps begin, and where they fall begin again, on something stable (`starts_along`):
    the walker's gait is followed to each value, and where it is not stable, what it becomes
    is. Where there is nothing to begin with, the ramp has `NO_START`, which is no fall.

    Args:
        params, control: the walker; with the parameter's own value in them it has a gait.
        parameter: one of `PARAMETERS`: a number of the control or of the walker.
        values: ascending.
        state: a post-strike state near that gait; searched for if left out.
        transient, keep: strides walked unseen, then kept, at each value.
        run: where it runs, see `run_chains`; each ramp is a chain of a few values each.

    Raises:
        ValueError: an unknown parameter, or one that the walker has no use for; values
            that do not ascend.
        TypeError: strides that are no whole number.
    """
    points = np.atleast_1d(np.asarray(values, np.float64))
    rising = points.ndim == 1 and len(points) > 0 and bool((np.diff(points) > 0).all())
    if not (rising and np.isfinite(points).all()):
        raise ValueError(f"values must be a list of ascending numbers, got {values!r}")
    transient, keep = whole_number("transient", transient, 0), whole_number("keep", keep, 2)
    rtol = check_rtol(real_number("rtol", rtol))
    for end in (points[0], points[-1]):
        changed(params, control, parameter, float(end))
    guess = None if state is None else check_state(state)
    starts = starts_along(params, control, parameter, points, guess)
    rows = np.arange(len(points))
    chains = [
        [
            _Link(params, control, parameter, points[part], starts[part], transient, keep, rtol)
            for part in (ordered[block] for block in blocks(len(points), LINK))
        ]
        for ordered in (rows, rows[::-1])
    ]
    up, down = (_joined(links) for links in run_chains(ramp, chains, **run))
    turned = Ramp(down.states[::-1], down.outcome[::-1], down.restarted[::-1])
    return BifurcationDiagram(params, control, parameter, points, transient, keep, rtol, up, turned)


def _joined(links: list[_Walked]) -> Ramp:
    return Ramp(*(np.concatenate(parts) for parts in zip(*links, strict=True)))


class _Link(NamedTuple):
    """Some successive values of a ramp."""

    params: WalkerParams
    control: AnyControl | Policy | None
    parameter: str
    values: Array  # (n,) in their order
    starts: Array  # (n, 4) where to start or start again; NaN where nothing is known
    transient: int
    keep: int
    rtol: float


_Walked = tuple[Array, NDArray[np.int64], NDArray[np.bool_]]  # states, outcomes, restarted


def ramp(link: _Link, before: _Walked | None) -> _Walked:
    """Walk through the values in their order, on from where the link before ended."""
    count = len(link.values)
    kept = np.full((count, link.keep, 4), np.nan)
    outcomes, restarted = np.full(count, NO_START), np.zeros(count, np.bool_)
    state = np.full(4, np.nan) if before is None else before[0][-1, -1]
    for i, value in enumerate(link.values.tolist()):
        walker = StrideMap(*changed(*link[:3], value), link.rtol)
        for start in (state, link.starts[i]):
            if np.isfinite(start).all() and outcomes[i] != Outcome.WALKED:
                restarted[i] = start is not state and (i > 0 or before is not None)
                kept[i], outcomes[i] = _walk(walker, start, link.transient, link.keep)
        state = kept[i, -1]
    return kept, outcomes, restarted


def _walk(walker: StrideMap, state: Array, transient: int, keep: int) -> tuple[Array, int]:
    """The last `keep` states of a walk, and how it ended; NaN after a fall."""
    states, x = np.full((keep, 4), np.nan), state[np.newaxis]
    for k in range(-transient, keep):
        batch = walker.strides(x)
        if not batch.walked[0]:
            return np.full((keep, 4), np.nan), int(batch.outcome[0])
        x = batch.state
        if k >= 0:
            states[k] = x[0]
    return states, int(Outcome.WALKED)


def _hausdorff(one: Array, other: Array) -> float:
    """The largest distance from a point of one set to the nearest of the other."""
    apart = np.linalg.norm(one[:, np.newaxis] - other, axis=2)
    return float(max(apart.min(axis=0).max(), apart.min(axis=1).max()))
