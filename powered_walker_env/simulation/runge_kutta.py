"""Runge–Kutta of order 8, eight walkers in step, each with its own length of step.

Dormand and Prince's method with the error estimates of Hairer, Nørsett and Wanner,
Solving Ordinary Differential Equations I, section II.10 (DOP853). The coefficients are
those that scipy ships, their zeros left out. No allocation: the caller brings a
`Workspace`, whose last axis is the lanes.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.integrate import DOP853

from powered_walker_env.compiled.decorators import internal
from powered_walker_env.compiled.lanes import Table, at_lane_0, load, rows_from, store, where
from powered_walker_env.model.mechanics.actuation import Drive, flow
from powered_walker_env.model.mechanics.constants import LANE_ROWS, lanes_of

DIMENSION = 6  # φ, α, β and their rates
STAGES = 12

# Step-size control, as in Hairer's code.
SAFETY, SMALLEST_FACTOR, LARGEST_FACTOR = 0.9, 0.2, 10.0
TINY = 1e-100  # in place of an error of zero: its eighth root is still a number


class _Tableau(NamedTuple):
    """Rows of coefficients without their zeros: row k is first[k] <= n < first[k + 1]."""

    first: np.ndarray
    stage: np.ndarray
    weight: np.ndarray


def sparse(rows: list[np.ndarray]) -> _Tableau:
    """The coefficients that are not zero."""
    stages = [np.flatnonzero(row) for row in rows]
    first = np.cumsum([0, *(len(stage) for stage in stages)])
    weights = [row[stage] for row, stage in zip(rows, stages, strict=True)]
    return _Tableau(first, np.concatenate(stages), np.concatenate(weights))


#: The rows by which the stages 1 to 11 are reached, then the end of the step.
ADVANCES = sparse([*DOP853.A[1:STAGES], DOP853.B])
_FIRST, _STAGE, _WEIGHT = ADVANCES
_ERRORS = sparse([DOP853.E5, DOP853.E3])
_ERROR_FIRST, _ERROR_STAGE, _ERROR_WEIGHT = _ERRORS


class Workspace(NamedTuple):
    """What eight walkers are integrated in: tables of lanes, with so many rows."""

    y: Table  # 6, state at the start of the step
    y_new: Table  # 6, state at its end
    stages: Table  # 13 times 6, states at the stages: first the start, last the end
    slopes: Table  # 16 times 6, y' at the stages, then at those of the interpolant
    terms: Table  # 7 times 6, coefficients of the interpolant
    length: Table  # 1, s, of the step
    drive: Table  # 5, what acts at ankle and hip
    locked: Table  # 1, 1 where the ankle is
    constants: Table  # LANE_ROWS, of the walkers


STAGE_ROWS = (STAGES + 1) * DIMENSION
EXTRA_STAGES = len(DOP853.A_EXTRA)
_SLOPE_ROWS = (STAGES + 1 + EXTRA_STAGES) * DIMENSION
_TERM_ROWS = (len(DOP853.D) + 3) * DIMENSION
_SLOPES = 2 * DIMENSION + STAGE_ROWS
_TERMS = _SLOPES + _SLOPE_ROWS
_SINGLE = _TERMS + _TERM_ROWS
WORKSPACE_ROWS = _SINGLE + 7 + LANE_ROWS


@internal
def workspace(rows):
    """A workspace in the first WORKSPACE_ROWS of a table of lanes."""
    return Workspace(
        rows,
        rows_from(rows, DIMENSION),
        rows_from(rows, 2 * DIMENSION),
        rows_from(rows, _SLOPES),
        rows_from(rows, _TERMS),
        rows_from(rows, _SINGLE),
        rows_from(rows, _SINGLE + 1),
        rows_from(rows, _SINGLE + 6),
        rows_from(rows, _SINGLE + 7),
    )


@internal
def first_lane(y):
    """The state of the first of the walkers."""
    return (
        at_lane_0(y[0]), at_lane_0(y[1]), at_lane_0(y[2]),
        at_lane_0(y[3]), at_lane_0(y[4]), at_lane_0(y[5]),
    )  # fmt: skip


@internal
def store_state(array, row, y):
    """The inverse of `load_state`."""
    store(array, row, y[0])
    store(array, row + 1, y[1])
    store(array, row + 2, y[2])
    store(array, row + 3, y[3])
    store(array, row + 4, y[4])
    store(array, row + 5, y[5])


@internal
def load_state(array, row):
    """Six rows as (φ, α, β, φ', α', β')."""
    return (
        load(array, row),
        load(array, row + 1),
        load(array, row + 2),
        load(array, row + 3),
        load(array, row + 4),
        load(array, row + 5),
    )


@internal
def state_of(rows, lane):
    """The state of one of the walkers, from the first six rows."""
    return (
        rows[0, lane], rows[1, lane], rows[2, lane], rows[3, lane], rows[4, lane], rows[5, lane]
    )  # fmt: skip


@internal
def plus(a, factor, b):
    """a + factor·b, component by component."""
    return (
        a[0] + factor * b[0],
        a[1] + factor * b[1],
        a[2] + factor * b[2],
        a[3] + factor * b[3],
        a[4] + factor * b[4],
        a[5] + factor * b[5],
    )


@internal
def acting(w):
    """The `Drive`s of the eight walkers."""
    return Drive(
        load(w.drive, 0), load(w.drive, 1), load(w.drive, 2), load(w.drive, 3), load(w.drive, 4)
    )


@internal
def weighted(first, stage, weight, row, slopes):
    """Σ weight·slope over one row of a tableau, for all six components."""
    zero = 0.0 * load(slopes, 0)
    a, b, c, d, e, f = zero, zero, zero, zero, zero, zero
    for n in range(first[row], first[row + 1]):
        factor, at = weight[n], DIMENSION * stage[n]
        a = a + factor * load(slopes, at)
        b = b + factor * load(slopes, at + 1)
        c = c + factor * load(slopes, at + 2)
        d = d + factor * load(slopes, at + 3)
        e = e + factor * load(slopes, at + 4)
        f = f + factor * load(slopes, at + 5)
    return a, b, c, d, e, f


@internal
def advanced(row, y, slopes, h):
    """y + h Σ weights·slopes for one row of the method."""
    return plus(load_state(y, 0), h, weighted(_FIRST, _STAGE, _WEIGHT, row, slopes))


@internal
def step(w):
    """One step of each walker from w.y to w.y_new; needs slope 0, fills the others."""
    h, locked = load(w.length, 0), load(w.locked, 0) > 0.0
    store_state(w.stages, 0, load_state(w.y, 0))
    for stage in range(1, STAGES + 1):
        y = advanced(stage - 1, w.y, w.slopes, h)
        store_state(w.stages, DIMENSION * stage, y)
        slope = flow(locked, y, acting(w), lanes_of(w.constants))
        store_state(w.slopes, DIMENSION * stage, slope)
    store_state(w.y_new, 0, load_state(w.stages, DIMENSION * STAGES))


@internal
def _share(before, after, natural):
    """One over the size that an error is compared with."""
    before, after = abs(before), abs(after)
    size = where(before < after, after, before)
    return 1.0 / where(size < natural, natural, size)


@internal
def error_norm(w, tolerance, rate_scale):
    """Each step's estimated error over its tolerance: accept it up to 1.

    Angles are measured in radians and rates in √(g/L) (`rate_scale`), or by their own
    size where that is larger.
    """
    a5, b5, c5, d5, e5, f5 = weighted(_ERROR_FIRST, _ERROR_STAGE, _ERROR_WEIGHT, 0, w.slopes)
    a3, b3, c3, d3, e3, f3 = weighted(_ERROR_FIRST, _ERROR_STAGE, _ERROR_WEIGHT, 1, w.slopes)
    a = _share(load(w.y, 0), load(w.y_new, 0), 1.0)
    b = _share(load(w.y, 1), load(w.y_new, 1), 1.0)
    c = _share(load(w.y, 2), load(w.y_new, 2), 1.0)
    d = _share(load(w.y, 3), load(w.y_new, 3), rate_scale)
    e = _share(load(w.y, 4), load(w.y_new, 4), rate_scale)
    f = _share(load(w.y, 5), load(w.y_new, 5), rate_scale)
    sum5 = _squares(a5 * a, b5 * b, c5 * c, d5 * d, e5 * e, f5 * f)
    sum3 = _squares(a3 * a, b3 * b, c3 * c, d3 * d, e3 * e, f3 * f)
    total = math.sqrt((sum5 + 0.01 * sum3) * DIMENSION)
    return where(total > 0.0, load(w.length, 0) * sum5 / total, total) / tolerance


@internal
def _squares(a, b, c, d, e, f):
    return a * a + b * b + c * c + (d * d + e * e + f * f)


@internal
def step_factor(error):
    """How much longer the next step may be, from the error norm of this one.

    An error that is not a number shortens it most.
    """
    root = math.sqrt(math.sqrt(math.sqrt(where(error > TINY, error, TINY))))
    factor = SAFETY / root
    factor = where(factor < LARGEST_FACTOR, factor, LARGEST_FACTOR)
    factor = where(factor > SMALLEST_FACTOR, factor, SMALLEST_FACTOR)
    return where(error >= 0.0, factor, SMALLEST_FACTOR)
