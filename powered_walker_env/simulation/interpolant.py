"""The inside of a step: the method's interpolant of order 7, for eight walkers.

Hairer, Nørsett and Wanner (see `runge_kutta.py`), section II.10. Three more slopes make
it; it is wanted for samples of a walk, for the swing foot's lowest point, and for events
that the ends of a step only hint at.
"""

from __future__ import annotations

from scipy.integrate import DOP853

from powered_walker_env.compiled.decorators import internal, rare, small
from powered_walker_env.compiled.lanes import SIZE, load, load_state, plus, scaled, store_state
from powered_walker_env.simulation.lockstep import constants_lanes, flow_at
from powered_walker_env.simulation.poses import joined, posed
from powered_walker_env.simulation.runge_kutta import (
    EXTRA_STAGES,
    FITTED,
    STAGES,
    tableau,
    weighted,
)

_FIRST, _STAGE, _WEIGHT = tableau([*DOP853.A_EXTRA])
_TERM_FIRST, _TERM_STAGE, _TERM_WEIGHT = tableau([*DOP853.D])
POLYNOMIALS = FITTED + 3


@rare
def interpolate(s, w):
    """Prepare the interpolant of the steps just made: w.terms."""
    h, y, y_new = load(w.length, 0), load_state(w.y, 0), load_state(w.y_new, 0)
    for extra in range(EXTRA_STAGES):
        moved = plus(y, h, weighted(_FIRST, _STAGE, _WEIGHT, extra, w.flows, y))
        moved = flow_at(s, w, moved)
        store_state(w.flows, SIZE * (STAGES + 1 + extra), moved)
    first, last = load_state(w.flows, 0), load_state(w.flows, SIZE * STAGES)
    change = plus(y_new, -1.0, y)
    store_state(w.terms, 0, change)
    store_state(w.terms, SIZE, plus(scaled(h, first), -1.0, change))
    bend = plus(scaled(2.0, change), -1.0 * h, plus(last, 1.0, first))
    store_state(w.terms, 2 * SIZE, bend)
    for k in range(FITTED):
        fitted = weighted(_TERM_FIRST, _TERM_STAGE, _TERM_WEIGHT, k, w.flows, y)
        store_state(w.terms, (3 + k) * SIZE, scaled(h, fitted))


@internal
def look_inside(w, fraction):
    """The states at fractions of the steps (0 to 1)."""
    rest = 1.0 - fraction
    last = POLYNOMIALS - 1
    value = scaled(fraction if last % 2 == 0 else rest, load_state(w.terms, SIZE * last))
    for k in range(last - 1, -1, -1):
        share = fraction if k % 2 == 0 else rest
        value = scaled(share, plus(value, 1.0, load_state(w.terms, SIZE * k)))
    return plus(load_state(w.y, 0), 1.0, value)


@small
def pose_inside(w, fraction):
    """The pose at fractions of the steps (0 to 1); needs `interpolate`."""
    y, c = look_inside(w, fraction), constants_lanes(w.constants)
    return posed(y, joined(w), c)
