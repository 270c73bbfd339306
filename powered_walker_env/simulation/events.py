"""Events: has a guard fallen through zero inside a step, and exactly where?

A guard (`mechanics/guards.py`) is looked at through its values and rates at both ends of
the step. Where those allow a fall through zero, also one that is over again before the
step ends, its place is guessed; the step is then taken again so that it ends on the
event, Newton's way, each try being a full step of the method, until what is left is
linear to the accuracy asked for.
"""

from __future__ import annotations

from powered_walker_env.compiled.decorators import once, rare
from powered_walker_env.compiled.lanes import (
    LANES,
    bits,
    blend,
    load,
    mask_of,
    store,
    where,
)
from powered_walker_env.model.mechanics.ground import apart
from powered_walker_env.model.mechanics.guards import (
    FIRST_FALL,
    KNEE_STRIKE,
    LANDING,
    RELEASE,
    nearest_fall,
)
from powered_walker_env.model.mechanics.guards import SWITCH_ANGLE as SWITCH
from powered_walker_env.model.phases import Outcome
from powered_walker_env.simulation.lockstep import GUARDS
from powered_walker_env.simulation.poses import held
from powered_walker_env.simulation.roots import NOWHERE, cubic_fall, hidden_fall
from powered_walker_env.simulation.watching import (
    landing_lanes,
    still,
    watch,
    watch_falls,
    watch_here,
)

TRIES = 8  # steps towards one event
EVERY_LANE = (1 << LANES) - 1
ALREADY_LANDED = int(Outcome.ALREADY_LANDED)
KNEE_STAYED_STRAIGHT = int(Outcome.KNEE_STAYED_STRAIGHT)
SMALLEST = 1e-300  # the least that a guard can be up


@once
def may_fall_through(value, rate, value_end, rate_end, h):
    """Whether a guard, smooth between the ends, can go from positive to not positive.

    Where it turns inside the step, it lies within its tangents at the ends; twice their
    slope is allowed for.
    """
    reach, reach_end = 2.0 * h * rate, 2.0 * h * rate_end
    down = (value > 0.0) & (value_end <= 0.0)
    dip = (value > 0.0) & (value + reach <= 0.0) & (value_end > 0.0) & (value_end <= reach_end)
    hump = (value <= 0.0) & (value + reach > 0.0) & (value_end <= 0.0) & (value_end > reach_end)
    return down | dip | hump


@once
def suspicions(s, w, pose, pose_new, good):
    """Lanes (bits) in which some guard may have fallen through zero; which, in s.suspected.

    Args:
        pose, pose_new: the ends of the steps, the last one moving; good: lanes (bits) whose
            steps are accurate.
    """
    h, target = load(w.length, 0), load(s.target, 0)
    watch_here(s, w, 1, FIRST_FALL, pose_new, h == h, s.value_new, s.rate_new)
    found, beyond, watched = 0, FIRST_FALL, int(s.watched[0, 0])
    near = nearest_fall(held(w), pose_new, h, still(w))
    if (~bits(near > 0.0) & good) | bits(target >= FIRST_FALL):  # those stepped onto, too
        watch_falls(s, w, pose_new, h == h)
        beyond = GUARDS
    ahead = (apart(pose) > 0.0) | (apart(pose_new) > 0.0)
    ahead = bits(ahead & (load(s.scuffed, 0) == 0.0))
    for guard in range(1, beyond):
        suspected = 0
        if watched >> guard & 1:
            active = bits((load(s.active, guard) > 0.0) & ~(target == guard)) & good
            doubt = may_fall_through(
                load(s.value, guard), load(s.rate, guard),
                load(s.value_new, guard), load(s.rate_new, guard), h,
            )  # fmt: skip
            suspected = bits(doubt) & active
            if guard == LANDING:
                suspected &= ahead
        s.suspected[guard, 0] = suspected
        found |= suspected
    for guard in range(beyond, GUARDS):
        s.suspected[guard, 0] = 0.0
    return found


@once
def over_at_once(s, w, batch, pose):
    """Lanes, as bits, whose phase is over as it begins; notes why in s.ending.

    A hip already past the switch and closing starts the motor at once, a stop with
    nothing to hold lets go at once, and a walker that is already down has fallen. A
    landing must be a fall through the floor, and a stop be met: a swing foot that is on the
    ground ahead before the stride begins is no landing. A straight knee must begin to bend.

    Args:
        pose: moving.
    """
    switching = (load(s.active, SWITCH) > 0.0) & (load(s.rate, SWITCH) < 0.0)
    switched = bits(switching & (load(s.value, SWITCH) <= 0.0))
    loose = bits((load(s.active, RELEASE) > 0.0) & (load(s.value, RELEASE) <= 0.0))
    first = (load(s.phases, 0) == 1.0) & (load(s.active, LANDING) > 0.0)
    touching = bits(first & (abs(load(s.value, LANDING)) <= batch.rtol))
    if touching:
        touching &= landing_lanes(w, batch, pose, -1.0)
    stiff = _begin_to_bend(s, pose)
    over = switched | loose | touching | stiff
    for lane in range(LANES):
        if over >> lane & 1:
            s.ending[0, lane] = SWITCH if switched >> lane & 1 else RELEASE
            if stiff >> lane & 1:
                s.ending[0, lane] = -1 - KNEE_STAYED_STRAIGHT
            if touching >> lane & 1:
                s.ending[0, lane] = -1 - ALREADY_LANDED
    return over | _down(s, w, pose)


@once
def _begin_to_bend(s, pose):
    """Lanes, as bits, whose straight knee is let go and does not begin to bend.

    Thigh and shank turn together then, and the guard is neither up nor falling but for
    rounding: that is taken from it.
    """
    let_go = (load(s.active, KNEE_STRIKE) > 0.0) & (pose.beta.value == pose.theta.value)
    blend(s.value, KNEE_STRIKE, let_go, SMALLEST)
    blend(s.rate, KNEE_STRIKE, let_go, 0.0)
    bending = pose.dbeta.tangent - pose.dtheta.tangent
    return bits(let_go & (bending <= 0.0))


@rare
def _down(s, w, pose):
    """Lanes, as bits, that are down as a phase begins; notes the fall in s.ending."""
    h = 0.0 * load(s.h, 0)
    down = ~bits(nearest_fall(held(w), pose, h, still(w)) > 0.0) & EVERY_LANE
    if down:
        watch(s, w, FIRST_FALL, GUARDS, pose, h == h, s.value, s.rate)
        for guard in range(GUARDS - 1, FIRST_FALL - 1, -1):
            fallen = (load(s.active, guard) > 0.0) & (load(s.value, guard) <= 0.0)
            blend(s.ending, 0, fallen & mask_of(down), 1.0 * guard)
    return down


@rare
def _fall_fraction(s, w, batch, guard, suspected):
    """Fractions of the steps at which a guard falls in the suspected lanes (bits)."""
    h, value, value_end = load(w.length, 0), load(s.value, guard), load(s.value_new, guard)
    rate, rate_end = load(s.rate, guard), load(s.rate_new, guard)
    down = (value > 0.0) & (value_end <= 0.0)
    store(s.fraction, 0, where(down, cubic_fall(value, rate * h, value_end, rate_end * h), NOWHERE))
    hidden = suspected & ~bits(down)
    if hidden:
        for lane in range(LANES):
            if hidden >> lane & 1:
                s.fraction[0, lane] = hidden_fall(s, w, batch, lane, guard)
    return where(mask_of(suspected), load(s.fraction, 0), NOWHERE)


@once
def aim(s, w, batch):
    """Step onto the first of the suspected falls from now on; the lanes (bits) that do."""
    h, target = load(w.length, 0), load(s.target, 0)
    first, earliest = 0.0 * h, 0.0 * h + NOWHERE
    for guard in range(1, GUARDS):
        suspected = int(s.suspected[guard, 0])
        if suspected:
            fraction = _fall_fraction(s, w, batch, guard, suspected)
            first = where(fraction < earliest, 1.0 * guard, first)
            earliest = where(fraction < earliest, fraction, earliest)
    found = earliest < NOWHERE
    begun = found & (target == 0.0)
    blend(s.whole, 0, begun, h)
    blend(s.tries, 0, begun, 0.0)
    blend(s.target, 0, found, first)
    blend(w.length, 0, found, h * earliest)
    return bits(found)


@once
def arrive(s, w, stepping, landed, linear):
    """Steps towards events have been made: are they there? The lanes (bits) that are.

    Args:
        stepping: lanes (bits) that have made one; landed: those where a touch of the floor, at
            its end, is a landing.
        linear: times √(L/g): below it the rest of the way is linear.
    """
    here, h, target = mask_of(stepping), load(w.length, 0), load(s.target, 0)
    value, rate = 0.0 * h, 0.0 * h
    for guard in range(1, GUARDS):
        if bits(target == guard):
            value = where(target == guard, load(s.value_new, guard), value)
            rate = where(target == guard, load(s.rate_new, guard), rate)
    change = where(rate == 0.0, 0.0, -value / rate)
    rising = (value > 0.0) & (rate > 0.0)  # it falls further on, as a knee that was just let go
    change = where(rising, 0.5 * (load(s.whole, 0) - h), change)
    tries = load(s.tries, 0) + 1.0
    near = (abs(change) < linear * load(s.unit, 0)) & ~rising
    over = here & (near | (tries >= TRIES))
    scuffed = over & (target == LANDING) & ~mask_of(landed)
    arrived, again = over & ~scuffed, here & ~over
    blend(s.tries, 0, here, tries)
    blend(s.scuffed, 0, scuffed, 1.0)  # take the whole step after all
    blend(s.target, 0, scuffed, 0.0)
    blend(s.h, 0, scuffed, load(s.whole, 0))
    back = where(change > -h, change, -h)  # time runs forward
    blend(s.correction, 0, arrived, where(near, back, 0.0))
    blend(s.ending, 0, arrived, target)
    there = where(h + change > 0.0, h + change, 0.0)
    blend(w.length, 0, again, where(there < load(s.whole, 0), there, load(s.whole, 0)))
    return bits(arrived)


@once
def planned(s, w, longest, latest):
    """Set the lengths of the steps: towards an event as aimed, else as the control proposes.

    Args:
        longest: s; latest: s, when the stride is given up.
    """
    h = load(s.h, 0)
    h = where(h < longest, h, longest)
    left = latest - load(s.t, 0)
    h = where(h < left, h, left)
    store(w.length, 0, where(load(s.target, 0) > 0.0, load(w.length, 0), h))
