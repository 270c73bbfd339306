"""One stride, or many at once: from just after heel strike to just after the next."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from powered_walker_env.model.knees import encode
from powered_walker_env.model.mechanics.packing import packed
from powered_walker_env.model.phases import Cycle
from powered_walker_env.model.powering import (
    AnyControl,
    Policy,
    as_policy,
    check_walkable,
)
from powered_walker_env.model.state import PostStrikeState, check_state
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.simulation import kernel, record
from powered_walker_env.simulation.arguments import Array as Array
from powered_walker_env.simulation.arguments import check_batch, check_heights, check_rtol, rows_of
from powered_walker_env.simulation.desk import DESKS, WORKSPACES
from powered_walker_env.simulation.threads import run_in_slices
from powered_walker_env.simulation.walked import Stride, StrideBatch, stride_of

NO_ROWS = np.empty((0, 0))  # no log, no directions to differentiate along


def stride(
    state: PostStrikeState | Sequence[float],
    control: AnyControl | Policy | None,
    params: WalkerParams,
    *,
    step_height: float = 0.0,
    rtol: float = 1e-9,
) -> Stride:
    """Walk one stride.

    Args:
        state: post-strike state (α, s, α', β'), rad and rad/s.
        control: switch angle and stall torque, or the control of another scheme
            (`model/powering/`); None for a passive walker, whose foot stays locked; or a policy.
        params: the walker.
        step_height: m, height of the ground ahead over the ground under the stance foot.
        rtol: accuracy asked of the post-strike state, 1e-13 to 1e-3.

    Returns:
        The stride. A fall is an outcome, not an exception.

    Raises:
        ValueError: a state that is not finite, a walker that cannot be powered, a
            tolerance out of bounds; TypeError: an argument of the wrong type.
    """
    checked = check_state(state)
    control = as_policy(control, checked)
    powered, rtol = check_walkable(params, control), check_rtol(rtol)
    heights = check_heights(step_height, 1)
    if callable(control):
        angle, strength = rows_of(control, np.array([checked]))[0].tolist()
    else:
        angle, strength = powered.row(control)
    code, walker, desk = encode(powered.cycle), packed(params), DESKS.take()
    desk.lay(*checked, angle, strength)
    _walk(desk.workspace, code, desk.states, desk.controls, walker, heights, rtol, desk.results)
    found = stride_of(desk.row)
    DESKS.put_back(desk)
    return found


def stride_batch(
    states: ArrayLike,
    controls: ArrayLike | AnyControl | Policy | None,
    params: WalkerParams | Sequence[WalkerParams],
    *,
    step_height: ArrayLike = 0.0,
    rtol: float = 1e-9,
    scheme: str | None = None,
) -> StrideBatch:
    """N strides at once, on all cores; each bit-equal to the same call of `stride`.

    Args:
        states: (N, 4) post-strike states, rad and rad/s.
        controls: (N, k) or (k,) numbers of the scheme's control, for the motor k = 2
            switch angles (rad) and stall torques (N m); or a control or a policy, as in
            `stride`; None for passive walkers.
        params: one walker, or N of them.
        step_height: m, one height or N of them.
        rtol: as in `stride`.
        scheme: what the numbers control, by name (`SCHEMES`); the motor if left out. A
            control or a policy knows its own.

    Raises:
        ValueError: wrong shapes, or a value out of its domain, naming the row; a scheme that
            is not the control's.
    """
    batch = check_batch(states, controls, params, scheme)
    heights = check_heights(step_height, len(batch.states))
    return run_batch(
        batch.scheme.cycle, batch.states, batch.controls, batch.rows, heights, check_rtol(rtol)
    )


def run_batch(
    cycle: Cycle, states: Array, controls: Array, rows: Array, heights: Array, rtol: float
) -> StrideBatch:
    """`stride_batch` on arrays that are known to be good (rows: packed walkers, N or 1)."""
    results, outcomes = _run(cycle, states, controls, rows, heights, rtol)
    return StrideBatch(outcomes, results)


def _run(
    cycle: Cycle, states: Array, controls: Array, rows: Array, heights: Array, rtol: float
) -> tuple[Array, NDArray[np.int64]]:
    results = np.empty((len(states), record.RESULTS))
    code = encode(cycle)

    def work(part: slice) -> None:
        run_rows(
            code,
            states[part],
            controls[part],
            rows if len(rows) == 1 else rows[part],
            heights if len(heights) == 1 else heights[part],
            rtol,
            results[part],
        )

    run_in_slices(work, len(states))
    return results, outcomes_of(results)


def run_rows(
    code: Array, states: Array, controls: Array, rows: Array, heights: Array, rtol: float,
    results: Array,
) -> None:  # fmt: skip
    """The strides of one slice on this thread, without the interpreter's lock.

    Args:
        code: of the cycle (`phases.encode`); the rest as in `run_batch`.
        results: (N, record.RESULTS) is written.
    """
    workspace = WORKSPACES.take()
    _walk(workspace, code, states, controls, rows, heights, rtol, results)
    WORKSPACES.put_back(workspace)


def _walk(
    workspace: Array, code: Array, states: Array, controls: Array, rows: Array, heights: Array,
    rtol: float, results: Array,
) -> None:  # fmt: skip
    kernel.run_strides(
        workspace, code, states, controls, rows, heights, rtol, results,
        0.0, NO_ROWS, NO_ROWS, NO_ROWS, NO_ROWS,
    )  # fmt: skip


def outcomes_of(results: Array) -> NDArray[np.int64]:
    """(N,) the outcomes in the kernel's rows."""
    return results[:, record.OUTCOME].astype(np.int64)
