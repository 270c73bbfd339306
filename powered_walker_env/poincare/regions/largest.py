"""The largest single disturbance that a walker survives: one step of the ground, one push.

It meets a walker on its gait once; then the ground is level (sloping as before) and nothing pushes.
Survived is what is followed by so many strides without a fall. Sizes are tried side by side from
small to large, and the first that makes it fall is closed in on: every smaller one tried is
survived. What lies beyond may be survived again; that is not looked for.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.model.checks import real_number, require, whole_number
from powered_walker_env.model.mechanics.packing import pack
from powered_walker_env.model.powering import AnyControl, Policy
from powered_walker_env.model.state import PostStrikeState, check_state, natural_units
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.branches.starts import stable_gait
from powered_walker_env.poincare.maps import StrideMap
from powered_walker_env.poincare.tolerances import FATE_RTOL
from powered_walker_env.simulation.strides import Array, run_batch

TRIED = 64  # sizes side by side
FINEST = 1e-9  # of the largest size looked at: how near the edge is closed in on
HIGHEST = 0.5  # leg lengths, of a step; √(g/L), of a push
FIRST = 1e-6  # of the largest size: the smallest tried


@dataclass(frozen=True, eq=False)
class Largest:
    """The largest disturbance survived, to either side."""

    params: WalkerParams
    control: AnyControl | Policy | None
    start: PostStrikeState
    kind: str  # "step, m" or "push, rad/s"
    strides: int  # walked after it
    up: float  # positive: a step up, or a push forwards
    down: float  # negative
    reach: float  # sizes beyond were not looked at

    def __repr__(self) -> str:
        return f"Largest({self.kind}: {self.up:+.6g}, {self.down:+.6g})"


def largest_step(
    params: WalkerParams,
    control: AnyControl | Policy | None,
    start: PostStrikeState | Sequence[float] | None = None,
    *,
    strides: int = 50,
) -> Largest:
    """The largest single step, up and down, that a walker survives, m.

    Args:
        params, control: the walker; a control, None or a policy (a closed loop).
        start: post-strike state before the step; left out, the most stable gait's.
        strides: on level ground after it, without a fall.

    Raises:
        GaitNotFoundError: no start, and no gait; ValueError: a start that falls by itself.
    """
    here, stride_map, strides = _asked(params, control, start, strides)
    row = pack(params)[np.newaxis]

    def survives(sizes: Array) -> NDArray[np.bool_]:
        states = np.tile(here, (len(sizes), 1))
        controls = stride_map.controls(states)
        batch = run_batch(stride_map.cycle, states, controls, row, sizes, FATE_RTOL)
        return _walks(stride_map, batch.state, strides)

    reach = HIGHEST * params.leg_length
    up, down = _edge(survives, reach), -_edge(lambda sizes: survives(-sizes), reach)
    return Largest(params, control, PostStrikeState(*here), "step, m", strides, up, down, reach)


def largest_push(
    params: WalkerParams,
    control: AnyControl | Policy | None,
    start: PostStrikeState | Sequence[float] | None = None,
    *,
    direction: Sequence[float] = (1.0, 0.0),
    strides: int = 50,
) -> Largest:
    """The largest single push after a heel strike, to either side, that a walker survives, rad/s.

    Args:
        params, control, start, strides: as in `largest_step`.
        direction: on stance and swing rate, of any length but 0; made a unit vector.

    Raises:
        As `largest_step`; ValueError: no direction.
    """
    here, stride_map, strides = _asked(params, control, start, strides)
    way = np.array([real_number("direction", each) for each in direction])
    good = way.shape == (2,) and bool(np.linalg.norm(way) > 0)
    require(good, "direction", "be two numbers, on stance and swing rate, not both 0", direction)
    way /= np.linalg.norm(way)

    def survives(sizes: Array) -> NDArray[np.bool_]:
        states = np.tile(here, (len(sizes), 1))
        states[:, 2:] += sizes[:, np.newaxis] * way
        return _walks(stride_map, states, strides)

    reach = HIGHEST * float(natural_units(params)[2])
    up, down = _edge(survives, reach), -_edge(lambda sizes: survives(-sizes), reach)
    return Largest(params, control, PostStrikeState(*here), "push, rad/s", strides, up, down, reach)


def _asked(
    params: WalkerParams, control: AnyControl | Policy | None,
    start: PostStrikeState | Sequence[float] | None, strides: int,
) -> tuple[Array, StrideMap, int]:  # fmt: skip
    strides = whole_number("strides", strides, 1)
    stride_map = StrideMap(params, control, FATE_RTOL)
    here = np.array(check_state(stable_gait(params, control).state if start is None else start))
    if not _walks(stride_map, here[np.newaxis], strides)[0]:
        raise ValueError(f"start must walk {strides} strides undisturbed, got {here.tolist()}")
    return here, stride_map, strides


def _walks(stride_map: StrideMap, states: Array, strides: int) -> NDArray[np.bool_]:
    """Which of the states (N, 4) walk so many strides; NaN has fallen already."""
    good: NDArray[np.bool_] = np.all(np.isfinite(states), axis=1)
    rows, states = np.flatnonzero(good), states[good]
    for _ in range(strides):
        batch = stride_map.strides(states)
        good[rows[~batch.walked]] = False
        rows, states = rows[batch.walked], batch.state[batch.walked]
    return good


def _edge(survives: Callable[[Array], NDArray[np.bool_]], reach: float) -> float:
    """The size up to which all that are tried are survived, closed in on."""
    sizes = np.geomspace(FIRST * reach, reach, 4 * TRIED)
    low = 0.0
    while True:
        bad = np.flatnonzero(~survives(sizes))
        if not len(bad):
            return float(sizes[-1])
        first = int(bad[0])
        low, high = (low if first == 0 else float(sizes[first - 1])), float(sizes[first])
        if high - low <= FINEST * reach:
            return low
        sizes = np.linspace(low, high, TRIED + 1)[1:]
