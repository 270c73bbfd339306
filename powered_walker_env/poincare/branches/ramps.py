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

from powered_walker_env.model.phases import Outcome
from powered_walker_env.model.powering import CONTROL_NUMBERS, AnyControl
from powered_walker_env.model.state import PostStrikeState, check_state
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.families import numbers_of, replaced
from powered_walker_env.poincare.gaits import GaitNotFoundError, find_gait
from powered_walker_env.poincare.maps import Policy, StrideMap, natural_units
from powered_walker_env.poincare.work.pieces import RunOptions, run_pieces
from powered_walker_env.simulation.derivatives import PARAMETERS
from powered_walker_env.simulation.strides import Array

RTOL = 1e-9  # of the strides
SAME = 1e-6  # natural units within which a kept state has come back
SETTLED = 1e-3  # of a return to the returns before it: slower than 0.999 a stride is not seen


@dataclass(frozen=True, eq=False)
class Ramp:
    """The states a walker went through as a parameter changed; rows go with the values."""

    states: Array = field(repr=False)  # (n, keep, 4) after the transient; NaN after a fall
    outcome: NDArray[np.int64]  # (n,) how the last stride ended, values of Outcome
    restarted: NDArray[np.bool_]  # (n,) begun from the gait found there: the walker had fallen

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

    def periods(self, ramp: Ramp, within: float = SAME) -> NDArray[np.int64]:
        """(n,) strides after which the motion repeats; 0 if it does not, −1 after a fall.

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
        repeats = (closest <= within) & ((first == 0) | (closest <= SETTLED * earlier))
        return np.where(ramp.walked, np.where(repeats, first + 1, 0), -1)

    @property
    def gap(self) -> Array:
        """(n,) Hausdorff distance of the two ramps' states, natural units: hysteresis shows.

        NaN where both fell, inf where one did.
        """
        units, pairs = (
            natural_units(self.params),
            zip(self.up.states, self.down.states, strict=True),
        )
        gaps = [_hausdorff(one / units, other / units) for one, other in pairs]
        both, neither = self.up.walked & self.down.walked, ~(self.up.walked | self.down.walked)
        return np.where(both, gaps, np.where(neither, np.nan, np.inf))


def bifurcation_diagram(
    params: WalkerParams,
    control: AnyControl | Policy | None,
    parameter: str,
    values: ArrayLike,
    *,
    state: PostStrikeState | Sequence[float] | None = None,
    transient: int = 200,
    keep: int = 64,
    rtol: float = RTOL,
    **run: Unpack[RunOptions],
) -> BifurcationDiagram:
    """Ramp a parameter up and down, each value starting where the last one ended.

    After a fall the walker starts again from the gait found at the next value, or, where
    none is found, from `state`.

    Args:
        params, control: the walker; the parameter's own value in them does not matter.
        parameter: one of `PARAMETERS`: a number of the control or of the walker.
        values: ascending.
        state: where both ramps begin and begin again; the gaits found at their first
            values if left out.
        transient, keep: strides walked unseen, then kept, at each value.
        run: where it runs, see `run_pieces`; the two ramps are two pieces.

    Raises:
        ValueError: an unknown parameter, or one that the walker has no use for; values
            that do not ascend.
    """
    points = np.atleast_1d(np.asarray(values, np.float64))
    if points.ndim != 1 or not len(points) or (np.diff(points) <= 0).any():
        raise ValueError(f"values must be a list of ascending numbers, got {values!r}")
    if transient < 0 or keep < 2:
        raise ValueError(
            f"transient must be at least 0 and keep at least 2, got {transient!r} and {keep!r}"
        )
    changed(params, control, parameter, float(points[0]))
    start = None if state is None else np.array(check_state(state))
    pieces = [
        _Piece(params, control, parameter, ordered, start, transient, keep, rtol)
        for ordered in (points, points[::-1])
    ]
    up, down = run_pieces(ramp, pieces, **run)
    turned = Ramp(down.states[::-1], down.outcome[::-1], down.restarted[::-1])
    return BifurcationDiagram(params, control, parameter, points, transient, keep, rtol, up, turned)


def changed(
    params: WalkerParams, control: AnyControl | Policy | None, parameter: str, value: float
) -> tuple[WalkerParams, AnyControl | Policy | None]:
    """The walker and its control with one number replaced.

    Raises:
        ValueError: not one of `PARAMETERS`, or a number of a control that is not constant.
    """
    if parameter not in PARAMETERS:
        raise ValueError(f"parameter must be one of {', '.join(PARAMETERS)}, got {parameter!r}")
    if parameter not in CONTROL_NUMBERS:
        return params.replace(**{parameter: value}), control
    if parameter not in numbers_of(control):
        raise ValueError(
            f"parameter {parameter!r} is no number of a constant control, got control={control!r}; "
            "ramp a parameter of the walker instead"
        )
    return params, replaced(control, parameter, value)


class _Piece(NamedTuple):
    params: WalkerParams
    control: AnyControl | Policy | None
    parameter: str
    values: Array
    start: Array | None
    transient: int
    keep: int
    rtol: float


def ramp(piece: _Piece) -> Ramp:
    """Walk through the values in their order."""
    count = len(piece.values)
    kept = np.full((count, piece.keep, 4), np.nan)
    outcomes, restarted = np.zeros(count, np.int64), np.zeros(count, np.bool_)
    state = piece.start
    for i, value in enumerate(piece.values.tolist()):
        walker = StrideMap(*changed(*piece[:3], value), piece.rtol)
        if state is None:
            restarted[i] = i > 0
            state = _restart(walker, piece.start)
        if state is None:
            outcomes[i] = int(Outcome.NOT_FINITE)
            continue
        states, outcomes[i] = _walk(walker, state, piece.transient, piece.keep)
        if outcomes[i] == Outcome.WALKED:
            kept[i], state = states, states[-1]
        else:
            state = None
    return Ramp(kept, outcomes, restarted)


def _walk(walker: StrideMap, state: Array, transient: int, keep: int) -> tuple[Array, int]:
    """The last `keep` states of a walk, and how it ended."""
    states, x = np.full((keep, 4), np.nan), state[np.newaxis]
    for k in range(-transient, keep):
        batch = walker.strides(x)
        if not batch.walked[0]:
            return states, int(batch.outcome[0])
        x = batch.state
        if k >= 0:
            states[k] = x[0]
    return states, int(Outcome.WALKED)


def _restart(walker: StrideMap, start: Array | None) -> Array | None:
    """The gait at this value, or the start given; None if there is neither."""
    try:
        guess = None if start is None else start.tolist()
        return np.array(find_gait(walker.params, walker.control, guess).state)
    except GaitNotFoundError:
        return start


def _hausdorff(one: Array, other: Array) -> float:
    """The largest distance from a point of one set to the nearest of the other."""
    apart = np.linalg.norm(one[:, np.newaxis] - other, axis=2)
    return float(max(apart.min(axis=0).max(), apart.min(axis=1).max()))
