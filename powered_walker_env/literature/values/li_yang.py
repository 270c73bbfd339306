"""The simplest walker's gaits of three and four strides (Li and Yang 2012).

Both lie beside the single steps of Garcia et al. (1998) and come from no doubling of them: a
multistart finds them, and continuation where they are stable.
"""

from __future__ import annotations

import functools
from collections.abc import Callable

import numpy as np

from powered_walker_env.model.presets import PRESETS
from powered_walker_env.poincare import (
    Gait,
    GaitNotFoundError,
    SpecialKind,
    StrideMap,
    continue_gait,
    find_gaits,
)

SLOPES = {3: (0.0121, 0.01245, 0.0128), 4: (0.0100, 0.01011, 0.0102)}  # search between bounds
STARTS = 4096  # of the multistart; 1024 miss the gait of four strides
STEP = 0.05  # of the branches
RETURNED = 1e-9  # rad, rad/s: nearer than this, a state is the one it was


@functools.cache
def stable_gait(period: int) -> Gait:
    """The stable gait of so many strides.

    Raises:
        GaitNotFoundError: none is found.
    """
    params = PRESETS["simplest"].params.replace(slope=SLOPES[period][1])
    for gait in find_gaits(params, None, period=period, starts=STARTS):
        if gait.stable:
            return gait
    raise GaitNotFoundError(f"no stable gait of {period} strides at slope {params.slope}")


def least_period(gait: Gait) -> int:
    """Strides after which the gait first returns to its state; 0 if it does not in its period."""
    start = state = np.array(gait.state)
    for strides in range(1, gait.period + 1):
        state = StrideMap(gait.params, gait.control)(state[np.newaxis])[0]
        if np.abs(state - start).max() < RETURNED:
            return strides
    return 0


@functools.cache
def _limits(period: int) -> dict[SpecialKind, float]:
    """The slopes between which the gait is stable, by what happens there."""
    low, _, high = SLOPES[period]
    branch = continue_gait(stable_gait(period), "slope", (low, high), step=STEP)
    return {point.kind: point.value for point in branch.special_points if point.limits_stability}


def measures(period: int) -> dict[str, Callable[[], complex]]:
    """What is checked of the gait of so many strides; NaN for a limit that is not there."""
    return {
        f"period_{period}": lambda: least_period(stable_gait(period)),
        f"period_{period}_born": lambda: _limits(period).get(SpecialKind.FOLD, np.nan),
        f"period_{period}_doubles": lambda: _limits(period).get(
            SpecialKind.PERIOD_DOUBLING, np.nan
        ),
    }
