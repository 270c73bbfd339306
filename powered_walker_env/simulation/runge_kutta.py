"""Runge–Kutta of order 8, eight walkers in step, each with its own length of step.

Dormand and Prince's method with the error estimates of Hairer, Nørsett and Wanner,
Solving Ordinary Differential Equations I, section II.10 (DOP853). The coefficients are
those that scipy ships, their zeros left out. No allocation: the caller brings a
`Workspace`, whose tables end with the lanes.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import DOP853

from powered_walker_env.compiled.decorators import internal, once
from powered_walker_env.compiled.lanes import (
    SIZE,
    Table,
    bits,
    eighth_root,
    load,
    load_like,
    load_state,
    plus,
    scaled,
    store_state,
    where,
    zero,
)
from powered_walker_env.compiled.records import Layout
from powered_walker_env.model.mechanics.actuation import flow
from powered_walker_env.model.mechanics.links import without_second
from powered_walker_env.model.mechanics.packing import CHAIN, CHAIN_SIZE, CONSTANTS, CONSTANTS_SIZE

STAGES = 12
EXTRA_STAGES = len(DOP853.A_EXTRA)  # of the interpolant
FITTED = len(DOP853.D)  # its terms beyond the cubic through both ends

# Step-size control, as in Hairer's code.
STABLE = 5.0  # h|λ|; the method is stable to about 6 on the negative axis
SAFETY, SMALLEST_FACTOR, LARGEST_FACTOR = 0.9, 0.2, 10.0
TINY = 1e-100  # in place of an error of zero: its eighth root is still a number


class Tableau(NamedTuple):
    """Rows of coefficients without their zeros: row k is first[k] <= n < first[k + 1]."""

    first: NDArray[np.int64]
    stage: NDArray[np.int64]
    weight: NDArray[np.float64]


def tableau(rows: list[NDArray[np.float64]]) -> Tableau:
    """The coefficients that are not zero."""
    stages = [np.flatnonzero(row) for row in rows]
    first = np.cumsum([0, *(len(stage) for stage in stages)])
    weights = [row[stage] for row, stage in zip(rows, stages, strict=True)]
    return Tableau(first, np.concatenate(stages), np.concatenate(weights))


#: The rows by which the stages 1 to 11 are reached, then the end of the step.
ADVANCES = tableau([*DOP853.A[1:STAGES], DOP853.B])
_FIRST, _STAGE, _WEIGHT = ADVANCES
#: The two estimates of the error need the same stages.
_ERROR_STAGE = np.flatnonzero(np.abs(DOP853.E5) + np.abs(DOP853.E3))
_ERRORS = len(_ERROR_STAGE)
_WEIGHT_5, _WEIGHT_3 = DOP853.E5[_ERROR_STAGE], DOP853.E3[_ERROR_STAGE]


class Workspace(NamedTuple):
    """What eight walkers are integrated in: tables of lanes, of one row if not said."""

    y: Annotated[Table, SIZE]  # state at the start of the step
    y_new: Annotated[Table, SIZE]  # at its end
    stages: Annotated[Table, (STAGES + 1) * SIZE]  # states: first the start, last the end
    flows: Annotated[Table, (STAGES + 1 + EXTRA_STAGES) * SIZE]  # y' there; of the interpolant
    terms: Annotated[Table, (FITTED + 3) * SIZE]  # coefficients of the interpolant
    length: Table  # s, of the step
    free: Table  # is the ankle free
    bent: Table  # is the swing knee free
    constants: Annotated[Table, CONSTANTS_SIZE]  # of the walkers
    locked_chain: Annotated[Table, CHAIN_SIZE]
    free_chain: Annotated[Table, CHAIN_SIZE]
    bent_chain: Annotated[Table, CHAIN_SIZE]
    chain: Annotated[Table, CHAIN_SIZE]  # of the phase: one of the three
    zeros: Annotated[Table, max(CONSTANTS_SIZE, CHAIN_SIZE)]  # tangents of what does not change


WORKSPACE = Layout(Workspace)
workspace = WORKSPACE.view
constants_lanes, chain_lanes = CONSTANTS.lanes, CHAIN.lanes
constants_duals, chain_duals = CONSTANTS.duals, CHAIN.duals


@internal
def weighted(first, stage, weight, row, flows, like):
    """Σ weight·flow over one row of a tableau, as a state like another."""
    begin = first[row]
    total = scaled(weight[begin], load_like(like, flows, SIZE * stage[begin]))
    for n in range(begin + 1, first[row + 1]):
        total = plus(total, weight[n], load_like(like, flows, SIZE * stage[n]))
    return total


@once
def step(w, acting):
    """One step of each walker from w.y to w.y_new; needs flow 0, fills the others.

    Where no chain has a second link, the numbers of that link are known, and the step is the same,
    bit for bit, in less time.
    """
    start, chain = load_state(w.y, 0), chain_lanes(w.chain)
    if bits(load(w.free, 0) + load(w.bent, 0) > 0.0):
        _step(w, acting, start, chain)
    else:
        first, _, last, first_rate, _, last_rate = start
        two = first, zero(), last, first_rate, zero(), last_rate
        _step(w, acting, two, without_second(chain))


@internal
def _step(w, acting, start, chain):
    h, c = load(w.length, 0), constants_lanes(w.constants)
    store_state(w.stages, 0, start)
    for stage in range(1, STAGES + 1):
        y = plus(start, h, weighted(_FIRST, _STAGE, _WEIGHT, stage - 1, w.flows, start))
        store_state(w.stages, SIZE * stage, y)
        moved = flow(y, acting, chain, c)
        store_state(w.flows, SIZE * stage, moved)
    store_state(w.y_new, 0, load_state(w.stages, SIZE * STAGES))


@internal
def _size(before, after, natural):
    """The size that an error is compared with."""
    before, after = abs(before), abs(after)
    size = where(before < after, after, before)
    return where(size < natural, natural, size)


@internal
def _shares(a, b):
    """1/a and 1/b, by one division."""
    both = 1.0 / (a * b)
    return b * both, a * both


@once
def error_norm(w, tolerance, rate_scale):
    """Each step's estimated error over its tolerance: accept it up to 1.

    Angles are measured in radians and rates in √(g/L) (`rate_scale`), or by their own
    size where that is larger.
    """
    start = load_state(w.flows, SIZE * _ERROR_STAGE[0])
    e5, e3 = scaled(_WEIGHT_5[0], start), scaled(_WEIGHT_3[0], start)
    for n in range(1, _ERRORS):
        moved = load_state(w.flows, SIZE * _ERROR_STAGE[n])
        e5, e3 = plus(e5, _WEIGHT_5[n], moved), plus(e3, _WEIGHT_3[n], moved)
    y, y_new = load_state(w.y, 0), load_state(w.y_new, 0)
    a, b = _shares(_size(y[0], y_new[0], 1.0), _size(y[1], y_new[1], 1.0))
    c, d = _shares(_size(y[2], y_new[2], 1.0), _size(y[3], y_new[3], rate_scale))
    e, f = _shares(_size(y[4], y_new[4], rate_scale), _size(y[5], y_new[5], rate_scale))
    sum5 = _squares(e5[0] * a, e5[1] * b, e5[2] * c, e5[3] * d, e5[4] * e, e5[5] * f)
    sum3 = _squares(e3[0] * a, e3[1] * b, e3[2] * c, e3[3] * d, e3[4] * e, e3[5] * f)
    total = math.sqrt((sum5 + 0.01 * sum3) * SIZE)
    return where(total > 0.0, load(w.length, 0) * sum5 / (total * tolerance), total)


@once
def stability_norm(w):
    """How near each step is to where the method amplifies what should decay: accept it up to 1.

    The fastest rate λ of the flow shows in its last two stages, which are both at the step's end:
    h|λ| = h|f − f'|/|y − y'| (Hairer, Nørsett and Wanner II, section IV.2). A motor near its
    no-load speed holds a light foot so firmly that errors of long steps grow unseen. To the eighth
    power it shortens steps as an error does.
    """
    change = plus(load_state(w.y_new, 0), -1.0, load_state(w.stages, SIZE * (STAGES - 1)))
    moved = plus(load_state(w.flows, SIZE * STAGES), -1.0, load_state(w.flows, SIZE * (STAGES - 1)))
    apart, h = _squares(*change), load(w.length, 0) / STABLE
    rate = where(apart > 0.0, h * h * _squares(*moved) / apart, 0.0)
    fourth = rate * rate
    return fourth * fourth


@internal
def _squares(a, b, c, d, e, f):
    return a * a + b * b + c * c + (d * d + e * e + f * f)


@once
def step_factor(error):
    """How much longer the next step may be, from the error norm of this one.

    An error that is not a number shortens it most.
    """
    factor = SAFETY / eighth_root(where(error > TINY, error, TINY))
    factor = where(factor < LARGEST_FACTOR, factor, LARGEST_FACTOR)
    factor = where(factor > SMALLEST_FACTOR, factor, SMALLEST_FACTOR)
    return where(error >= 0.0, factor, SMALLEST_FACTOR)
