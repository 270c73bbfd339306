"""Resets: what happens to the state where a phase ends, for eight walkers at once."""

from __future__ import annotations

from powered_walker_env.compiled.decorators import internal, rare
from powered_walker_env.compiled.lanes import bits, load, store, where
from powered_walker_env.model.mechanics.constants import lanes_of
from powered_walker_env.model.mechanics.heel_strike import heel_strike
from powered_walker_env.model.mechanics.push_off import push_off, work_after, work_before, work_with
from powered_walker_env.model.mechanics.stop import caught
from powered_walker_env.model.mechanics.swing import kinetic_energy
from powered_walker_env.model.phases import Reset
from powered_walker_env.simulation.lockstep import blend
from powered_walker_env.simulation.record import travel
from powered_walker_env.simulation.runge_kutta import DIMENSION, load_state, store_state

CONTINUE, HEEL_STRIKE = int(Reset.CONTINUE), int(Reset.HEEL_STRIKE)
STOP_RESET = int(Reset.STOP)
PUSH_BEFORE, PUSH_WITH = int(Reset.PUSH_BEFORE), int(Reset.PUSH_WITH)
PUSH_AFTER = int(Reset.PUSH_AFTER)


@internal
def impact(s, w):
    """Heel strikes of all eight, with or without a push, or their ankles' stops: from w.y to
    s.struck; energy lost, work of the push and way travelled."""
    y, c = load_state(w.y, 0), lanes_of(w.constants)
    reset, impulse = load(s.reset, 0), load(s.impulse, 0)
    struck = push_off(y[0], y[1], y[2], y[3], y[4], y[5], impulse, c)
    store_state(s.struck, 0, struck)
    work = 0.0 * impulse
    if bits(reset > HEEL_STRIKE):
        work = _push_work(y, reset, impulse, struck, c)
    if bits(reset == STOP_RESET):
        stopped = caught(y, c)
        for i in range(DIMENSION):
            blend(s.struck, i, reset == STOP_RESET, stopped[i])
        struck = load_state(s.struck, 0)
    before = kinetic_energy(y[0], y[1], y[2], y[3], y[4], y[5], c)
    after = kinetic_energy(struck[0], struck[1], struck[2], struck[3], struck[4], struck[5], c)
    store(s.pushed, 0, work)
    store(s.lost, 0, before + work - after)
    store(s.travelled, 0, travel(s, y, c))


@rare
def _push_work(y, reset, impulse, struck, c):
    """Work of the push-off by when it comes, J; 0 for other resets."""
    before = work_before(y[0], y[1], y[2], impulse, c)
    along = work_with(y[0], y[1], y[2], impulse, struck, c)
    unpushed = heel_strike(y[0], y[1], y[2], y[3], y[4], y[5], c)
    after = work_after(y[0], y[1], y[2], impulse, unpushed, struck, c)
    work = where(reset == PUSH_BEFORE, before, 0.0)
    return where(reset == PUSH_WITH, along, where(reset == PUSH_AFTER, after, work))
