"""The stride kernel: run a cycle of phases from heel strike to heel strike, eight at a time.

Closed: no exception, no print, every loop bounded. It takes the encoded list of
`phases.py` and numbers, and leaves a row of results and an outcome for each stride. A
single stride goes the same way, alone in its lane: it is the same walk, bit for bit, in
any lane of any batch.
"""

from __future__ import annotations

import math

import numpy as np

from powered_walker_env.compilation import internal, threaded_kernel
from powered_walker_env.events import (
    LANDING,
    NOWHERE,
    RELEASE,
    STOP,
    SWITCH_ANGLE,
    aim,
    arrive,
    first_fall,
    landing_lanes,
    over_at_once,
    planned,
    suspicions,
    watch,
)
from powered_walker_env.integrator import (
    DIMENSION,
    STAGES,
    WORKSPACE_ROWS,
    acting,
    error_norm,
    load_state,
    state_of,
    step,
    step_factor,
    store_state,
    workspace,
)
from powered_walker_env.lanes import (
    LANES,
    bits,
    eights,
    load,
    mask_of,
    rows_from,
    store,
    table,
    where,
)
from powered_walker_env.lockstep import (
    FALL,
    GUARDS,
    LOCKSTEP_ROWS,
    Batch,
    blend,
    enter,
    lockstep,
    place,
    rest,
    row_of,
)
from powered_walker_env.phases import MAX_EXITS, Outcome, Reset
from powered_walker_env.physics.actuation import flow
from powered_walker_env.physics.constants import lane_of, lanes_of, unpack
from powered_walker_env.physics.ground import name_fall
from powered_walker_env.physics.heel_strike import heel_strike
from powered_walker_env.physics.push_off import push_off, work_after, work_before, work_with
from powered_walker_env.physics.stop import caught
from powered_walker_env.physics.swing import kinetic_energy
from powered_walker_env.record import (
    TOTALS_ROWS,
    add_step,
    clear,
    log_step,
    look,
    totals,
    travel,
    write_log,
    write_row,
)
from powered_walker_env.sensitivity import (
    DIRECTION_ROWS,
    begin,
    directions_of,
    enter_phases,
    leave_phases,
    propagate,
    stop_phases,
    strike,
    write_derivatives,
)

CONTINUE, HEEL_STRIKE = int(Reset.CONTINUE), int(Reset.HEEL_STRIKE)
STOP_RESET = int(Reset.STOP)
PUSH_BEFORE, PUSH_WITH = int(Reset.PUSH_BEFORE), int(Reset.PUSH_WITH)
PUSH_AFTER = int(Reset.PUSH_AFTER)
WALKED, NO_LANDING = int(Outcome.WALKED), int(Outcome.NO_LANDING)
NOT_FINITE, STEP_LIMIT = int(Outcome.NOT_FINITE), int(Outcome.STEP_LIMIT)

# All times in units of √(L/g).
TIME_LIMIT = 20.0  # no landing by then is a fall; the nearly simplest walker takes 3.9
LONGEST_STEP = 0.5  # so that no guard can turn twice inside a step
SHORTEST_STEP = 1e-12
LINEAR = 1e-3  # times √rtol: a way to an event that is linear to its square
MAX_STEPS = 20_000
MAX_PHASES = 16
TOLERANCE_SHARE = 0.1  # of rtol for one step: the stride map multiplies errors by about 10
EVERY_LANE = (1 << LANES) - 1
KERNEL_ROWS = LOCKSTEP_ROWS + WORKSPACE_ROWS + TOTALS_ROWS


@internal
def _next_stride(s, w, sums, lane, queue, batch, d):
    """Place the next stride that can begin in a free lane; the strides begun so far."""
    states = batch.states
    for index in range(queue, batch.strides):
        c = unpack(batch.rows, row_of(index, batch.row_count))
        place(s, w, lane, index, batch, c)
        clear(sums, lane)
        enter(s, w, lane, 0, batch)
        if d is not None:
            begin(d, lane)
        if math.isfinite(states[index, 0] + states[index, 1] + states[index, 2] + states[index, 3]):
            return index + 1
        _finish(s, w, sums, lane, NOT_FINITE, batch, d)
    rest(s, lane)
    return batch.strides


@internal
def _begin_phases(s, w, sums, begun):
    """Slopes, guards and sums where phases begin (bits); those that are over at once."""
    mask, y, c, drive = mask_of(begun), load_state(w.y, 0), lanes_of(w.constants), acting(w)
    locked = load(w.locked, 0) > 0.0
    slope = flow(locked, y, drive, c)
    for i in range(DIMENSION):
        blend(w.slopes, i, mask, slope[i])
    watch(s, locked, y, drive, c, mask, s.value, s.rate)
    look(sums, mask, y, drive, c)
    return over_at_once(s) & begun


@internal
def _impact(s, w):
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


@internal
def _push_work(y, reset, impulse, struck, c):
    """Work of the push-off by when it comes, J; 0 for other resets."""
    before = work_before(y[0], y[1], y[2], impulse, c)
    along = work_with(y[0], y[1], y[2], impulse, struck, c)
    unpushed = heel_strike(y[0], y[1], y[2], y[3], y[4], y[5], c)
    after = work_after(y[0], y[1], y[2], impulse, unpushed, struck, c)
    work = where(reset == PUSH_BEFORE, before, 0.0)
    return where(reset == PUSH_WITH, along, where(reset == PUSH_AFTER, after, work))


@internal
def _way_out(s, w, lane, batch):
    """Where a phase that has ended leads: a phase, or −1 − outcome; notes the reset."""
    ending, phase, cycle = int(s.ending[0, lane]), int(s.phase[0, lane]), batch.cycle
    s.reset[0, lane], s.impulse[0, lane] = 0.0, 0.0
    if ending < 0:
        return ending
    if ending == FALL:
        c = lane_of(w.constants, lane)
        return -1 - name_fall(w.locked[0, lane] > 0.0, state_of(w.y, lane), c)
    for exit in range(MAX_EXITS):
        if cycle[phase, 2 + 3 * exit] == ending:
            to, reset = int(cycle[phase, 4 + 3 * exit]), int(cycle[phase, 3 + 3 * exit])
            s.reset[0, lane] = reset
            if PUSH_BEFORE <= reset <= PUSH_AFTER:
                s.impulse[0, lane] = s.strength[0, lane]
            return to if s.phases[0, lane] < MAX_PHASES or to < 0 else -1 - STEP_LIMIT
    return -1 - STEP_LIMIT  # not reached: only guards of the phase end it


@internal
def _finish(s, w, sums, lane, outcome, batch, d):
    """Write the results of a stride that is over."""
    index = int(s.number[0, lane])
    if outcome == WALKED and not math.isfinite(s.struck[4, lane] + s.struck[5, lane]):
        outcome = NOT_FINITE
    write_row(batch.results, index, s, w, sums, lane, outcome)
    if d is not None:
        write_derivatives(d, index, lane, outcome == WALKED)


@internal
def _end_phases(s, w, sums, ended, queue, batch, d):
    """Pass lanes (bits) on to the next phase or stride.

    Returns those that begin one, and how many strides have been begun.
    """
    stopped, impacts = 0, False
    for lane in range(LANES):
        if ended >> lane & 1:
            s.leads_to[0, lane] = _way_out(s, w, lane, batch)
            impacts |= s.reset[0, lane] != CONTINUE
            stopped |= (1 << lane) if s.reset[0, lane] == STOP_RESET else 0
    if ended & 1:
        write_log(batch, s.t[0, 0], state_of(w.y, 0), s.phase[0, 0])
    if d is not None:
        leave_phases(d, s, w, mask_of(ended))
    if impacts:
        _impact(s, w)
    if d is not None:
        if impacts:
            strike(d, s, w, mask_of(ended))
        if stopped:
            stop_phases(d, s, w, mask_of(stopped))
    begun, continued = 0, 0
    for lane in range(LANES):
        if not ended >> lane & 1:
            continue
        to = int(s.leads_to[0, lane])
        if to < 0:
            _finish(s, w, sums, lane, -1 - to, batch, d)
            queue = _next_stride(s, w, sums, lane, queue, batch, d)
            begun |= (1 << lane) if s.number[0, lane] >= 0 else 0
            continue
        if stopped >> lane & 1:
            sums.lost[0, lane] += s.lost[0, lane]
            for i in range(DIMENSION):
                w.y[i, lane] = s.struck[i, lane]
        enter(s, w, lane, to, batch)
        continued |= 1 << lane
    if continued & 1:
        write_log(batch, s.t[0, 0], state_of(w.y, 0), s.phase[0, 0])
    if d is not None and continued:
        enter_phases(d, s, w, mask_of(continued))
    return begun | continued, queue


@internal
def _look_for_events(s, w, landed, good, suspected, linear):
    """Lanes (bits) whose steps are taken, and lanes whose phases end with them.

    Args:
        good: lanes whose steps are accurate; suspected: for each guard, the lanes in
            which it may have fallen; landed: lanes where touching the floor is a landing.
    """
    stepping = bits(load(s.target, 0) > 0.0) & good
    switched, landed_on, stopped, released, fallen = suspected
    doubtful = (switched | landed_on | stopped | released | fallen) & good
    taken, ended = good & ~stepping & ~doubtful, 0
    for lane in range(LANES):
        if not (stepping | doubtful) >> lane & 1:
            continue
        if doubtful >> lane & 1:
            guards = (
                (switched >> lane & 1) << SWITCH_ANGLE
                | (landed_on >> lane & 1) << LANDING
                | (stopped >> lane & 1) << STOP
                | (released >> lane & 1) << RELEASE
                | (fallen >> lane & 1) << FALL
            )
            guard, fraction = first_fall(s, w, lane, guards)
            if fraction < NOWHERE:
                aim(s, w, lane, guard, fraction)
                continue
            if not stepping >> lane & 1:
                taken |= 1 << lane
                continue
        if arrive(s, w, lane, landed >> lane & 1, linear * s.unit[0, lane]):
            taken |= 1 << lane
            ended |= 1 << lane
    return taken, ended


@internal
def _give_up(s, w, error, good, taken):
    """Lanes (bits) whose strides cannot be brought to an end; notes why in s.ending."""
    unit = load(s.unit, 0)
    late = bits(load(s.t, 0) >= TIME_LIMIT * unit) & taken
    stuck = bits(load(s.h, 0) < SHORTEST_STEP * unit) & ~good
    lost = stuck & ~bits(error < math.inf)
    for lane in range(LANES):
        s.steps[0, lane] += 1
        if s.steps[0, lane] > MAX_STEPS:
            stuck |= 1 << lane
    given_up = (late | stuck) & bits(load(s.busy, 0) > 0.0)
    if given_up:
        for lane in range(LANES):
            if given_up >> lane & 1:
                reason = NOT_FINITE if lost >> lane & 1 else STEP_LIMIT
                s.ending[0, lane] = -1 - (NO_LANDING if late >> lane & 1 else reason)
    return given_up


@internal
def _commit(s, w, mask, taken):
    """Go on from the ends of the steps, where the mask holds."""
    for i in range(DIMENSION):
        blend(w.y, i, mask, load(w.y_new, i))
        blend(w.slopes, i, mask, load(w.slopes, DIMENSION * STAGES + i))
    for guard in range(1, GUARDS):
        blend(s.value, guard, mask, load(s.value_new, guard))
        blend(s.rate, guard, mask, load(s.rate_new, guard))
    blend(s.t, 0, mask, load(s.t, 0) + taken)
    blend(s.elapsed, 0, mask, 1.0)
    blend(s.fresh, 0, mask, 0.0)
    blend(s.scuffed, 0, mask, 0.0)


@internal
def _advance(s, w, sums, batch, d):
    """One step of every lane; the lanes (bits) whose phases have ended with it."""
    unit, c = load(s.unit, 0), lanes_of(w.constants)
    planned(s, w, LONGEST_STEP * unit, (TIME_LIMIT + SHORTEST_STEP) * unit)
    step(w)
    error = error_norm(w, TOLERANCE_SHARE * batch.rtol, 1.0 / unit)
    stepping, busy = load(s.target, 0) > 0.0, load(s.busy, 0) > 0.0
    good = bits((stepping | (error <= 1.0)) & busy)
    factor = step_factor(error)
    factor = where((load(s.refused, 0) > 0.0) & (factor > 1.0), 1.0, factor)
    store(s.refused, 0, where(error <= 1.0, 0.0 * error, 1.0))
    store(s.h, 0, where(stepping, load(s.h, 0), load(w.length, 0) * factor))
    y, y_new = load_state(w.y, 0), load_state(w.y_new, 0)
    locked, every = load(w.locked, 0) > 0.0, mask_of(EVERY_LANE)
    watch(s, locked, y_new, acting(w), c, every, s.value_new, s.rate_new)
    store(s.correction, 0, 0.0 * unit)
    taken, ended = _look_for_events(
        s, w, landing_lanes(w, y_new, c), good, suspicions(s, load(w.length, 0), y, y_new),
        LINEAR * math.sqrt(batch.rtol),
    )  # fmt: skip
    correction, mask = load(s.correction, 0), mask_of(taken)
    for i in range(DIMENSION):
        moved = load(w.y_new, i) + correction * load(w.slopes, DIMENSION * STAGES + i)
        store(w.y_new, i, moved)
    length = load(w.length, 0) + correction
    if d is not None:
        propagate(d, s, w, mask)
    if batch.interval > 0.0 and taken & 1:
        log_step(batch, s, w)
    add_step(sums, s, w, mask, length)
    _commit(s, w, mask, length)
    return ended | (_give_up(s, w, error, good, taken) & ~ended)


@internal
def _run(s, w, sums, batch, d):
    """Run all strides of a batch."""
    queue, begun = 0, 0
    for lane in range(LANES):
        queue = _next_stride(s, w, sums, lane, queue, batch, d)
        begun |= (1 << lane) if s.number[0, lane] >= 0 else 0
    write_log(batch, 0.0, state_of(w.y, 0), 0)
    for _ in range((MAX_STEPS + MAX_PHASES) * batch.strides + 1):
        while begun:  # each round ends a phase, of which a stride has at most MAX_PHASES
            ended = _begin_phases(s, w, sums, begun)
            begun = 0
            if ended:
                begun, queue = _end_phases(s, w, sums, ended, queue, batch, d)
        if not bits(load(s.busy, 0) > 0.0):
            break
        ended = _advance(s, w, sums, batch, d)
        if ended:
            begun, queue = _end_phases(s, w, sums, ended, queue, batch, d)


@threaded_kernel
def run_strides(
    cycle, states, controls, rows, heights, rtol, results, interval, log, changes, derivatives
):
    """N strides; `rows` (packed walkers) and `heights` have N rows or one for all.

    Args:
        cycle: (phases, codes) the encoded phases.
        states: (N, 4) post-strike states; controls: (N, 2) switch angles, stall torques.
        heights: m, of the ground ahead over the ground under the stance foot.
        rtol: tolerance of the post-strike state.
        results: (N, RESULTS) is written.
        interval: s between samples of the first stride in `log`, 0 for its events alone.
        log: (m, LOG_COLUMNS), m = 0 for none.
        changes: None, or (n, 6 + PACKED) directions to differentiate along: changes of the
            post-strike state (4), the control (2) and the packed walker.
        derivatives: (N·n, OUTPUTS) of the post-strike state, duration, step length.

    Returns:
        The number of rows written to `log`.
    """
    logged = np.zeros((1, 1))
    n = 0 if changes is None else changes.shape[0]
    block = np.zeros((KERNEL_ROWS + n * DIRECTION_ROWS + 1) * LANES)
    memory = eights(block)
    s, w = lockstep(memory), workspace(rows_from(memory, LOCKSTEP_ROWS))
    sums = totals(rows_from(memory, LOCKSTEP_ROWS + WORKSPACE_ROWS))
    batch = Batch(
        states.shape[0], table(cycle), table(states), table(controls),
        table(rows), rows.shape[0], table(heights), heights.shape[0],
        rtol, (TOLERANCE_SHARE * rtol) ** 0.125, table(results),
        interval, table(log), log.shape[0], table(logged),
    )  # fmt: skip
    if changes is None:
        _run(s, w, sums, batch, None)
    else:
        more = rows_from(memory, KERNEL_ROWS)
        d = directions_of(more, table(changes), n, table(derivatives))
        _run(s, w, sums, batch, d)
    # What the tables point to must live until here.
    return int(logged[0, 0]) + 0 * len(block)
