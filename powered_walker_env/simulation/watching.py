"""Guards of eight walkers at moving poses: their values, and their rates as tangents."""

from __future__ import annotations

from powered_walker_env.compiled.decorators import internal, rare, small
from powered_walker_env.compiled.lanes import (
    bits,
    blend,
    load,
    load_state,
)
from powered_walker_env.model.mechanics.ground import lands, last_factor
from powered_walker_env.model.mechanics.guards import (
    FIRST_FALL,
    value_of,
)
from powered_walker_env.simulation.lockstep import GUARDS, moving_aims, moving_drive
from powered_walker_env.simulation.poses import held, joined, moving, pose_here
from powered_walker_env.simulation.runge_kutta import (
    chain_duals,
    chain_lanes,
    constants_duals,
    constants_lanes,
)


@small
def still(w):
    """The walkers' constants, which do not change along a stride, as those of moving poses."""
    return constants_duals(constants_lanes(w.constants), w.zeros)


@small
def along(w, pose, moved):
    """A pose with the rates of change as its tangents; moved: the flow of the chain's state."""
    return moving(pose, moved, joined(w), 0.0 * moved[0])


@internal
def guard_along(s, w, guard, pose):
    """A guard's value at a moving pose, its tangent the rate of change."""
    both = (
        chain_duals(chain_lanes(w.locked_chain), w.zeros),
        chain_duals(chain_lanes(w.free_chain), w.zeros),
    )
    zero = load(w.zeros, 0)
    drive, aimed = moving_drive(s, zero), moving_aims(s, zero)
    return value_of(guard, held(w), pose, drive, aimed, both, still(w))


@internal
def watch_here(s, w, first, beyond, pose, mask, values, rates):
    """Write values and rates of the watched guards from `first` to before `beyond`, at a moving
    pose, where the mask holds."""
    watched = int(s.watched[0, 0])
    for guard in range(first, beyond):
        if watched >> guard & 1:
            found = guard_along(s, w, guard, pose)
            blend(values, guard, mask, found.value)
            blend(rates, guard, mask, found.tangent)


@rare
def watch(s, w, first, beyond, pose, mask, values, rates):
    """`watch_here` where it is seldom done."""
    watch_here(s, w, first, beyond, pose, mask, values, rates)


@rare
def watch_falls(s, w, pose, every):
    """Write values and rates of the guards against falls at both ends of the steps.

    They are seldom wanted: see `nearest_fall`.

    Args:
        pose: moving, at the ends; every: a mask that holds.
    """
    before = along(w, pose_here(w), load_state(w.flows, 0))
    watch(s, w, FIRST_FALL, GUARDS, before, every, s.value, s.rate)
    watch(s, w, FIRST_FALL, GUARDS, pose, every, s.value_new, s.rate_new)


@internal
def landing_lanes(w, batch, pose, rate):
    """Lanes, as bits, in which a touch of the floor at a moving pose is a landing.

    Args:
        rate: of the clearance's last factor, 1/s.
    """
    return bits(lands(held(w), pose, rate, batch.together, still(w)))


@small
def factor_rate(w, pose):
    """The rate of the clearance's last factor at a moving pose, 1/s."""
    return last_factor(pose, still(w)).tangent
