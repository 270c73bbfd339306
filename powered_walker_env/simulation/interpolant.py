"""The inside of a step: the method's interpolant of order 7, for eight walkers.

Hairer, Nørsett and Wanner (see `integrator.py`), section II.10. Three more slopes make
it; it is wanted for samples of a walk, for the swing foot's lowest point, and for events
that the ends of a step only hint at.
"""

from __future__ import annotations

from scipy.integrate import DOP853

from powered_walker_env.compiled.decorators import internal, rare
from powered_walker_env.compiled.lanes import load
from powered_walker_env.model.mechanics.actuation import flow
from powered_walker_env.model.mechanics.constants import lanes_of
from powered_walker_env.simulation.runge_kutta import (
    DIMENSION,
    EXTRA_STAGES,
    STAGES,
    acting,
    load_state,
    plus,
    sparse,
    store_state,
    weighted,
)

_FIRST, _STAGE, _WEIGHT = sparse([*DOP853.A_EXTRA])
_TERM_FIRST, _TERM_STAGE, _TERM_WEIGHT = sparse([*DOP853.D])
FITTED = len(DOP853.D)  # terms beyond the cubic through both ends
POLYNOMIALS = FITTED + 3


@rare
def interpolate(w):
    """Prepare the interpolant of the steps just made: w.terms."""
    h, locked = load(w.length, 0), load(w.locked, 0) > 0.0
    y, y_new = load_state(w.y, 0), load_state(w.y_new, 0)
    for extra in range(EXTRA_STAGES):
        rise = weighted(_FIRST, _STAGE, _WEIGHT, extra, w.slopes)
        slope = flow(locked, plus(y, h, rise), acting(w), lanes_of(w.constants))
        store_state(w.slopes, DIMENSION * (STAGES + 1 + extra), slope)
    first, last = load_state(w.slopes, 0), load_state(w.slopes, DIMENSION * STAGES)
    change = plus(y_new, -1.0, y)
    zero = plus(change, -1.0, change)
    store_state(w.terms, 0, change)
    store_state(w.terms, DIMENSION, plus(plus(zero, h, first), -1.0, change))
    bend = plus(plus(zero, 2.0, change), -1.0 * h, plus(last, 1.0, first))
    store_state(w.terms, 2 * DIMENSION, bend)
    for k in range(FITTED):
        fitted = weighted(_TERM_FIRST, _TERM_STAGE, _TERM_WEIGHT, k, w.slopes)
        store_state(w.terms, (3 + k) * DIMENSION, plus(zero, h, fitted))


@internal
def look_inside(w, fraction):
    """The states at fractions of the steps (0 to 1)."""
    rest = 1.0 - fraction
    value = load_state(w.terms, 0)
    value = plus(value, -1.0, value)
    for k in range(POLYNOMIALS - 1, -1, -1):
        share = fraction if k % 2 == 0 else rest
        value = _times(share, plus(value, 1.0, load_state(w.terms, DIMENSION * k)))
    return plus(load_state(w.y, 0), 1.0, value)


@internal
def _times(factor, a):
    return (
        factor * a[0], factor * a[1], factor * a[2], factor * a[3], factor * a[4], factor * a[5]
    )  # fmt: skip
