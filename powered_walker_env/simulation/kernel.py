"""The stride kernel: run a cycle of phases from heel strike to heel strike, eight at a time.

Closed: no exception, no print, every loop bounded. It takes the encoded list of
`phases.py` and numbers, and leaves a row of results and an outcome for each stride. A
single stride goes the same way, alone in its lane: it is the same walk, bit for bit, in
any lane of any batch, with derivatives or without.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.compiled.decorators import internal, once, slow_kernel
from powered_walker_env.compiled.lanes import (
    LANES,
    SIZE,
    bits,
    blend,
    blend_state,
    eights,
    load,
    load_state,
    mask_of,
    plus,
    rows_from,
    store,
    store_state,
    table,
    where,
)
from powered_walker_env.model.mechanics.guards import FIRST_FALL
from powered_walker_env.model.phases import Outcome
from powered_walker_env.simulation.directions import DIRECTION_SIZE, Directions
from powered_walker_env.simulation.events import EVERY_LANE, aim, arrive, planned, suspicions
from powered_walker_env.simulation.hand_over import (
    MAX_PHASES,
    NOT_FINITE,
    STEP_LIMIT,
    begin_phases,
    end_phases,
    fill,
)
from powered_walker_env.simulation.lockstep import LOCKSTEP, Batch, acting, lockstep
from powered_walker_env.simulation.poses import joined, pose_here, posed
from powered_walker_env.simulation.record import log_step
from powered_walker_env.simulation.runge_kutta import (
    STAGES,
    WORKSPACE,
    chain_lanes,
    constants_lanes,
    error_norm,
    stability_norm,
    step,
    step_factor,
    workspace,
)
from powered_walker_env.simulation.sensitivity import propagate
from powered_walker_env.simulation.totals import TOTALS, add_step, totals
from powered_walker_env.simulation.waiting import waited_enough
from powered_walker_env.simulation.watching import along, factor_rate, landing_lanes

NO_LANDING, NO_KNEE_STRIKE = int(Outcome.NO_LANDING), int(Outcome.NO_KNEE_STRIKE)

# All times in units of √(L/g).
TIME_LIMIT = 20.0  # no landing by then is a fall; the nearly simplest walker takes 3.9
LONGEST_STEP = 0.5  # so that no guard can turn twice inside a step
SHORTEST_STEP = 1e-12
LINEAR = 1e-3  # times √rtol: a way to an event that is linear to its square
MAX_STEPS = 20_000
DOUBT = 0.3  # of the error that the last step lets expect: an estimate is not believed below
TOLERANCE_SHARE = 0.1  # of rtol for one step: the stride map multiplies errors by about 10
#: Foot to foot, over L, up to which the feet stand together and no touch is a landing: at most,
#: and otherwise √rtol.
TOGETHER = 1e-4
LOCKSTEP_ROWS, WORKSPACE_ROWS = LOCKSTEP.size, WORKSPACE.size
KERNEL_ROWS = LOCKSTEP_ROWS + WORKSPACE_ROWS + TOTALS.size


@once
def _look_for_events(s, w, batch, landed, good, doubtful):
    """Lanes (bits) whose steps are taken, and lanes whose phases end with them.

    Args:
        good: lanes whose steps are accurate; doubtful: those in which some guard may have
            fallen; landed: lanes where touching the floor is a landing.
    """
    stepping, aimed, arrived = bits(load(s.target, 0) > 0.0) & good, 0, 0
    if doubtful:
        aimed = aim(s, w, batch)
    if stepping & ~aimed:
        arrived = arrive(s, w, stepping & ~aimed, landed, LINEAR * math.sqrt(batch.rtol))
    return (good & ~stepping & ~aimed) | arrived, arrived


@once
def _give_up(s, w, error, good, taken):
    """Lanes (bits) whose strides cannot be brought to an end; notes why in s.ending."""
    unit = load(s.unit, 0)
    late = bits(load(s.t, 0) >= TIME_LIMIT * unit) & taken
    stuck = bits(load(s.h, 0) < SHORTEST_STEP * unit) & ~good
    lost = stuck & ~bits(error < math.inf)
    store(s.steps, 0, load(s.steps, 0) + load(s.busy, 0))
    stuck |= bits(load(s.steps, 0) > MAX_STEPS)
    given_up = (late | stuck) & bits(load(s.busy, 0) > 0.0)
    if given_up:
        for lane in range(LANES):
            if given_up >> lane & 1:
                reason = NOT_FINITE if lost >> lane & 1 else STEP_LIMIT
                if late >> lane & 1:
                    reason = NO_KNEE_STRIKE if w.bent[0, lane] > 0.0 else NO_LANDING
                s.ending[0, lane] = -1 - reason
    return given_up


@once
def _commit(s, w, mask, taken):
    """Go on from the ends of the steps, where the mask holds."""
    blend_state(w.y, 0, mask, load_state(w.y_new, 0))
    blend_state(w.flows, 0, mask, load_state(w.flows, SIZE * STAGES))
    watched = int(s.watched[0, 0])
    for guard in range(1, FIRST_FALL):
        if watched >> guard & 1:
            blend(s.value, guard, mask, load(s.value_new, guard))
            blend(s.rate, guard, mask, load(s.rate_new, guard))
    blend(s.t, 0, mask, load(s.t, 0) + taken)
    blend(s.elapsed, 0, mask, 1.0)
    blend(s.fresh, 0, mask, 0.0)
    blend(s.scuffed, 0, mask, 0.0)


@once
def _control_steps(s, w, error):
    """Propose the next steps' lengths; the lanes (bits) whose steps are accurate enough.

    An estimate far below what the last step lets expect, with the eighth power of the length, is
    not believed: estimates pass through zero where errors do not.
    """
    stepping, busy = load(s.target, 0) > 0.0, load(s.busy, 0) > 0.0
    square = load(w.length, 0) * load(w.length, 0)
    eighth, expected = square * square * (square * square), load(s.expected, 0)
    doubted = DOUBT * expected * eighth
    error = where(error < doubted, doubted, error)
    accurate = error <= 1.0
    store(s.expected, 0, where(accurate & ~stepping, error / eighth, expected))
    factor = step_factor(error)
    factor = where((load(s.refused, 0) > 0.0) & (factor > 1.0), 1.0, factor)
    store(s.refused, 0, where(accurate, 0.0 * error, 1.0))
    store(s.h, 0, where(stepping, load(s.h, 0), load(w.length, 0) * factor))
    return bits((stepping | accurate) & busy)


@internal
def _advance(s, w, sums, batch, d):
    """One step of every lane; the lanes (bits) whose phases have ended with it."""
    unit, c, links = load(s.unit, 0), constants_lanes(w.constants), joined(w)
    planned(s, w, LONGEST_STEP * unit, (TIME_LIMIT + SHORTEST_STEP) * unit)
    step(w, acting(s))
    error, stiff = error_norm(w, TOLERANCE_SHARE * batch.rtol, 1.0 / unit), stability_norm(w)
    error = where(stiff > error, stiff, error)
    good = _control_steps(s, w, error)
    pose, last = pose_here(w), load_state(w.flows, SIZE * STAGES)
    pose_new = posed(load_state(w.y_new, 0), links, c)
    going = along(w, pose_new, last)
    store(s.correction, 0, 0.0 * unit)
    taken, ended = _look_for_events(
        s, w, batch, landing_lanes(w, batch, going, factor_rate(w, going)), good,
        suspicions(s, w, pose, going, good),
    )  # fmt: skip
    correction, mask = load(s.correction, 0), mask_of(taken)
    if ended:
        store_state(w.y_new, 0, plus(load_state(w.y_new, 0), correction, last))
        pose_new = posed(load_state(w.y_new, 0), links, c)
    length = load(w.length, 0) + correction
    if d.n > 0:
        propagate(d, s, w, mask)
    if batch.interval > 0.0 and taken & 1:
        log_step(batch, s, w)
    add_step(sums, s, w, mask, length, pose, pose_new, chain_lanes(w.chain), c)
    _commit(s, w, mask, length)
    return ended | (_give_up(s, w, error, good, taken) & ~ended)


@once
def _clear(memory, w):
    """No lane has had a stride."""
    for lane in range(LANES):
        for row in range(LOCKSTEP_ROWS):
            memory[row, lane] = 0.0
        w.free[0, lane] = w.bent[0, lane] = 0.0


@slow_kernel
def run_strides(
    block, cycle, states, controls, rows, heights, rtol, results, interval, log,
    changes, walker_changes, derivatives,
):  # fmt: skip
    """N strides; `rows` (packed walkers) and `heights` have N rows or one for all.

    Args:
        cycle: (phases, codes) the encoded phases.
        states: (N, 4) post-strike states; controls: (N, 2) switch angles, strengths.
        heights: m, of the ground ahead over the ground under the stance foot.
        rtol: tolerance of the post-strike state.
        results: (N, RESULTS) is written.
        interval: s between samples of the first stride in `log`, 0 for its events alone.
        log: (m, LOG_COLUMNS), m = 0 for none.
        changes: (n, CHANGES) directions to differentiate along, n = 0 for none: changes of the
            post-strike state (4) and the control (2), and
        walker_changes: (n·rows, ROW) of the packed walkers, n for each.
        derivatives: (N·n, OUTPUTS) of the post-strike state, duration, step length.
        block: `workspace_for(n)`; for n = 0 it may have been used before.

    Returns:
        The number of rows written to `log`.
    """
    n, logged = changes.shape[0], eights(block)
    memory = rows_from(logged, 1)
    s, w = lockstep(memory), workspace(rows_from(memory, LOCKSTEP_ROWS))
    sums = totals(rows_from(memory, LOCKSTEP_ROWS + WORKSPACE_ROWS))
    _clear(memory, w)
    batch = Batch(
        states.shape[0], cycle.shape[0], table(cycle), table(states), table(controls),
        table(rows), rows.shape[0], table(heights), heights.shape[0],
        rtol, min(TOGETHER, math.sqrt(rtol)), (TOLERANCE_SHARE * rtol) ** 0.125, table(results),
        interval, table(log), log.shape[0], logged,
    )  # fmt: skip
    d = Directions(
        n, rows_from(memory, KERNEL_ROWS), table(changes), table(walker_changes),
        table(derivatives),
    )  # fmt: skip
    # A literal is a type of its own to numba, which would compile the callees once more.
    begun, ended = fill(s, w, sums, np.int64(EVERY_LANE), batch, d), np.int64(0)
    for _ in range((MAX_STEPS + MAX_PHASES) * batch.strides + 1):
        if begun:
            ended = begin_phases(s, w, sums, begun, batch, d)
        elif bits(load(s.busy, 0) > 0.0):
            ended |= _advance(s, w, sums, batch, d)
        else:
            break
        begun = np.int64(0)
        if ended and waited_enough(s, ended):
            begun, ended = end_phases(s, w, sums, ended, batch, d), np.int64(0)
    # What the tables point to must live until here.
    return int(logged[0, 0]) + 0 * len(block)


def workspace_for(directions: int = 0) -> NDArray[np.float64]:
    """Memory for `run_strides`: the rows of its tables, and the count of rows in the log."""
    return np.zeros((KERNEL_ROWS + directions * DIRECTION_SIZE + 2) * LANES)
