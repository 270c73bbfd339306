"""Long checks: cascades of doublings to their limit, and where walking ends."""

from __future__ import annotations

import functools

import numpy as np

from powered_walker_env.poincare import Gait
from powered_walker_env.poincare.branches.cascades import DELTA, Cascade, doubling_cascade
from powered_walker_env.poincare.families import Bounds, Family

DOUBLINGS = 6
STEP = 0.05  # of the branches: these are long and bend little
STRIDES = 2000  # that a walker must survive at each slope
PACE = 1e-5  # rad, from one slope to the next


@functools.cache
def cascade(gait: Gait, parameter: str, bounds: Bounds, doublings: int = DOUBLINGS) -> Cascade:
    """The cascade from a gait, computed once."""
    return doubling_cascade(gait, parameter, bounds, doublings=doublings, step=STEP)


def last_ratio(gait: Gait, parameter: str, bounds: Bounds) -> float:
    """The last two intervals of the cascade, the one over the other; NaN without three."""
    return (np.nan, *cascade(gait, parameter, bounds).ratios)[-1]


def limit(gait: Gait, parameter: str, bounds: Bounds) -> float:
    """Where the doublings pile up: the intervals to come sum up like a geometric series."""
    *_, before, last = cascade(gait, parameter, bounds).values
    return last + (last - before) / (DELTA - 1.0)


def slope_of_the_end(gait: Gait, bounds: Bounds) -> float:
    """The slope at which a walker falls that has walked through all below it; NaN if none."""
    family = Family(gait.params, gait.control, ("slope",), np.ones(1))
    state = np.array(gait.state)[np.newaxis]
    for slope in np.arange(gait.params.slope, bounds[0], 50 * PACE).tolist():
        state = family.stride_map(np.array([slope]))(state, 100)
    for slope in np.arange(*bounds, PACE).tolist():
        state = family.stride_map(np.array([slope]))(state, STRIDES)
        if not np.isfinite(state).all():
            return float(slope)
    return float(np.nan)
