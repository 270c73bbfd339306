"""What is summed up along strides: work, the motor's torque, the swing foot's clearance."""

from __future__ import annotations

import math
from typing import NamedTuple

from powered_walker_env.compiled.decorators import internal, once, rare
from powered_walker_env.compiled.lanes import (
    Table,
    bits,
    blend,
    load,
    where,
)
from powered_walker_env.compiled.records import Layout
from powered_walker_env.model.mechanics.actuation import ankle_torque, power
from powered_walker_env.model.mechanics.chain import energy
from powered_walker_env.model.mechanics.ground import apart, clearance
from powered_walker_env.simulation.interpolant import interpolate, look_inside, pose_inside
from powered_walker_env.simulation.lockstep import acting, flow_at, torques_act
from powered_walker_env.simulation.poses import joined, moving, posed
from powered_walker_env.simulation.runge_kutta import (
    chain_lanes,
    constants_duals,
    constants_lanes,
)

NEWTON_STEPS = 2  # towards a minimum, from the cubic's: what is left counts squared


class Totals(NamedTuple):
    """Sums over the strides of eight walkers, and what the next step adds to them; a row each."""

    energy: Table  # J, where the step begins
    power: Table  # W, of the torques
    torque: Table  # N m, of the ankle's motor
    height: Table  # m, of the swing foot above flat ground
    descent: Table  # m/s, its rate
    energy_in: Table  # J
    positive_work: Table  # J
    impulse: Table  # N m s, of the motor's torque
    lost: Table  # J, in the impacts before the last
    lowest: Table  # m, of the swing foot since the legs passed


TOTALS = Layout(Totals)
totals = TOTALS.view


@once
def clear(sums, lane):
    """Nothing has been added up for this lane's stride."""
    sums.energy_in[0, lane], sums.positive_work[0, lane] = 0.0, 0.0
    sums.impulse[0, lane], sums.lost[0, lane] = 0.0, 0.0
    sums.lowest[0, lane] = math.inf


@internal
def begin_sums(s, w, sums, mask, pose):
    """Look at the poses where phases begin; where strides begin nothing has been added up."""
    starting = mask & (load(s.phases, 0) == 1.0)
    for row in (sums.energy_in, sums.positive_work, sums.impulse, sums.lost):
        blend(row, 0, starting, 0.0)
    blend(sums.lowest, 0, starting, math.inf)
    look(
        sums, mask, torques_act(s), pose, acting(s),
        chain_lanes(w.chain), constants_lanes(w.constants),
    )  # fmt: skip


@internal
def look(sums, mask, powered, pose, drive, chain, c):
    """Take clearance, and where torques act energy and power, as those where the step begins."""
    height, descent = clearance(pose, c)
    blend(sums.height, 0, mask, height)
    blend(sums.descent, 0, mask, descent)
    if bits(powered & mask):
        blend(sums.energy, 0, mask, energy(pose, chain, c))
        blend(sums.power, 0, mask, power(pose, drive, c))
        blend(sums.torque, 0, mask, ankle_torque(pose.dalpha - pose.dphi, drive, c))


@internal
def cubic_minimum(value, slope, value_end, slope_end):
    """Where in (0, 1) the cubic with these ends (slopes per step) has its minimum, and how low.

    The place is 2 if it has none inside.
    """
    a = 2.0 * (value - value_end) + slope + slope_end
    b = 3.0 * (value_end - value) - 2.0 * slope - slope_end
    root = b * b - 3.0 * a * slope
    width = math.sqrt(where(root > 0.0, root, 0.0))
    # Of the two forms of the root of the slope, the one that does not cancel.
    x = where(b > 0.0, -slope / (b + width), (width - b) / (3.0 * a))
    inside = (root >= 0.0) & (x > 0.0) & (x < 1.0)
    low = value + x * (slope + x * (b + x * a))
    return where(inside, x, 2.0), where(inside, low, math.inf)


@internal
def _gain(value, slope, value_end, slope_end):
    """How much a quantity rises over a step, its falls left out (at most one turn inside)."""
    gain = where(value_end > value, value_end - value, 0.0)
    dips, peaks = (slope < 0.0) & (slope_end > 0.0), (slope > 0.0) & (slope_end < 0.0)
    if bits(dips | peaks):
        _, bottom = cubic_minimum(value, slope, value_end, slope_end)
        _, top = cubic_minimum(-value, -slope, -value_end, -slope_end)
        bottom = where(bottom < value_end, bottom, value_end)
        top = where(top < -value, -top, value)
        gain = where(dips, value_end - bottom, where(peaks, top - value, gain))
    return gain


@once
def add_step(sums, s, w, mask, taken, pose, pose_new, chain, c):
    """Add the work of the step just taken, and where the swing foot was lowest in it.

    Args:
        taken: s, the length of the step, its correction included.
        pose, pose_new: where it begins and ends; chain: of the phase.
    """
    height, descent = load(sums.height, 0), load(sums.descent, 0)
    before, rising, torque = load(sums.energy, 0), load(sums.power, 0), load(sums.torque, 0)
    drive, powered = acting(s), mask & torques_act(s)
    look(sums, mask, powered, pose_new, drive, chain, c)
    if bits(powered):
        after = load(sums.energy, 0)
        gain = _gain(before, rising * taken, after, load(sums.power, 0) * taken)
        given = _torque_impulse(pose, pose_new, drive, torque, load(sums.torque, 0), taken, c)
        blend(sums.energy_in, 0, powered, load(sums.energy_in, 0) + (after - before))
        blend(sums.positive_work, 0, powered, load(sums.positive_work, 0) + gain)
        blend(sums.impulse, 0, powered, load(sums.impulse, 0) + given)
    ahead = mask & (apart(pose_new) > 0.0)
    turning = ahead & (descent < 0.0) & (load(sums.descent, 0) > 0.0)
    if bits(turning):
        _dip(sums, s, w, turning, taken, pose, pose_new, height, descent)


@rare
def _dip(sums, s, w, turning, taken, pose, pose_new, height, descent):
    """The lowest clearance where it turns inside the step, after the legs have passed."""
    end, descent_end = load(sums.height, 0), load(sums.descent, 0)
    x, _ = cubic_minimum(height, descent * taken, end, descent_end * taken)
    between, between_end = apart(pose), apart(pose_new)
    passed = where(between > 0.0, 0.0, between / (between - between_end))
    dips = turning & (x > passed) & (x < 1.0)
    if bits(dips):
        _lower(sums, s, dips, _lowest_inside(s, w, x, passed))


@internal
def _lower(sums, s, mask, height):
    """Take a height of the swing foot as the lowest, over its own ground, if it is lower."""
    low, lowest = height - load(s.height, 0), load(sums.lowest, 0)
    blend(sums.lowest, 0, mask & (low < lowest), low)


@once
def end_clearance(sums, s, mask, pose, c):
    """Where a phase ends with the legs passed, the swing foot may be lowest, too."""
    height, _ = clearance(pose, c)
    _lower(sums, s, mask & (apart(pose) > 0.0), height)


@once
def _torque_impulse(pose, pose_new, drive, torque, torque_end, taken, c):
    """∫τ dt of the motor over the step, N m s: its line exactly, its limit as the mean."""
    bent = (pose_new.alpha - pose_new.phi) - (pose.alpha - pose.phi)
    line = drive.stall * (taken + c.droop * bent)
    bounded = (abs(torque) >= c.torque_limit) | (abs(torque_end) >= c.torque_limit)
    return where(bounded, 0.5 * (torque + torque_end) * taken, line)


@rare
def _lowest_inside(s, w, x, earliest):
    """The lowest clearance near fraction x of the step: Newton on the interpolant."""
    c, links = constants_lanes(w.constants), joined(w)
    interpolate(s, w)
    h = load(w.length, 0)
    for _ in range(NEWTON_STEPS):
        y = look_inside(w, x)
        moved, still = flow_at(s, w, y), constants_duals(c, w.zeros)
        _, descent = clearance(moving(posed(y, links, c), moved, links, 0.0 * x), still)
        bend = h * descent.tangent
        x = where(bend > 0.0, x - descent.value / bend, x)
        x = where(x > earliest, x, earliest)
        x = where(x < 1.0, x, 1.0)
    height, _ = clearance(pose_inside(w, x), c)
    return height
