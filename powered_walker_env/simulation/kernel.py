"""The stride kernel: run a cycle of phases from heel strike to heel strike, eight at a time.

Closed: no exception, no print, every loop bounded. It takes the encoded list of
`phases.py` and numbers, and leaves a row of results and an outcome for each stride. A
single stride goes the same way, alone in its lane: it is the same walk, bit for bit, in
any lane of any batch.
"""

from __future__ import annotations

import math

import numpy as np

from powered_walker_env.compiled.decorators import internal, slow_kernel
from powered_walker_env.compiled.lanes import (
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
from powered_walker_env.model.mechanics.constants import lanes_of
from powered_walker_env.model.phases import Outcome
from powered_walker_env.simulation.events import (
    LANDING,
    NOWHERE,
    RELEASE,
    STOP,
    SWITCH_ANGLE,
    aim,
    arrive,
    first_fall,
    landing_lanes,
    planned,
    suspicions,
    watch,
)
from powered_walker_env.simulation.lockstep import (
    FALL,
    GUARDS,
    LOCKSTEP_ROWS,
    Batch,
    blend,
    lockstep,
)
from powered_walker_env.simulation.record import (
    TOTALS_ROWS,
    add_step,
    log_step,
    totals,
    write_log,
)
from powered_walker_env.simulation.runge_kutta import (
    DIMENSION,
    STAGES,
    WORKSPACE_ROWS,
    acting,
    error_norm,
    load_state,
    state_of,
    step,
    step_factor,
    workspace,
)
from powered_walker_env.simulation.sensitivity import (
    DIRECTION_ROWS,
    directions_of,
    propagate,
)
from powered_walker_env.simulation.turns import (
    MAX_PHASES,
    NOT_FINITE,
    STEP_LIMIT,
    begin_phases,
    end_phases,
    next_stride,
)

NO_LANDING = int(Outcome.NO_LANDING)

# All times in units of √(L/g).
TIME_LIMIT = 20.0  # no landing by then is a fall; the nearly simplest walker takes 3.9
LONGEST_STEP = 0.5  # so that no guard can turn twice inside a step
SHORTEST_STEP = 1e-12
LINEAR = 1e-3  # times √rtol: a way to an event that is linear to its square
MAX_STEPS = 20_000
TOLERANCE_SHARE = 0.1  # of rtol for one step: the stride map multiplies errors by about 10
EVERY_LANE = (1 << LANES) - 1
KERNEL_ROWS = LOCKSTEP_ROWS + WORKSPACE_ROWS + TOTALS_ROWS


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
    # A literal 0 is a type of its own to numba, which would compile the callees once more.
    queue, begun = np.int64(0), np.int64(0)
    for lane in range(LANES):
        queue = next_stride(s, w, sums, lane, queue, batch, d)
        begun |= (1 << lane) if s.number[0, lane] >= 0 else 0
    write_log(batch, 0.0, state_of(w.y, 0), 0)
    for _ in range((MAX_STEPS + MAX_PHASES) * batch.strides + 1):
        while begun:  # each round ends a phase, of which a stride has at most MAX_PHASES
            ended = begin_phases(s, w, sums, begun)
            begun = np.int64(0)
            if ended:
                begun, queue = end_phases(s, w, sums, ended, queue, batch, d)
        if not bits(load(s.busy, 0) > 0.0):
            break
        ended = _advance(s, w, sums, batch, d)
        if ended:
            begun, queue = end_phases(s, w, sums, ended, queue, batch, d)


@slow_kernel
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
