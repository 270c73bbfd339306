"""One stride, or many at once: from just after heel strike to just after the next."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from powered_walker_env.model.knees import encode
from powered_walker_env.model.mechanics.constants import pack
from powered_walker_env.model.phases import Cycle, Outcome
from powered_walker_env.model.powering import (
    AnyControl,
    Policy,
    as_policy,
    check_walkable,
    scheme_of,
)
from powered_walker_env.model.state import PostStrikeState, check_state
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.simulation import kernel, record
from powered_walker_env.simulation.arguments import Array as Array
from powered_walker_env.simulation.arguments import check_batch, check_heights, check_rtol, rows_of
from powered_walker_env.simulation.threads import run_in_slices

NO_ROWS = np.empty((0, 0))  # no log, no directions to differentiate along


class Final(NamedTuple):
    """The walker where a stride ended, before any heel strike; relative angles."""

    q: tuple[float, float, float]  # rad: foot to vertical, ankle, hip
    u: tuple[float, float, float]  # rad/s
    knee: tuple[float, float]  # rad, rad/s: flexion of the swing knee; 0 if it is straight


@dataclass(frozen=True)
class Stride:
    """One stride and how it ended."""

    state: PostStrikeState  # after the heel strike; NaN after a fall
    final: Final  # at the end, whatever happened
    outcome: Outcome
    duration: float  # s
    step_length: float  # m, travel of the contact point (rolling included); 0 after a fall
    energy_in: float  # J, net work of motor, hip or push
    positive_work: float  # J, its positive part
    energy_lost: float  # J, at the heel strike and at the ankle's stop; below 0 only for a push
    # at once with the strike, see `ToeOffAtStrike`
    min_clearance: float  # m, lowest of the swing foot once the legs have passed, its ground
    # at 0: 0 is a clean step, less is scuffing; NaN if they did not pass
    electrical_energy: float  # J, voltage times current of the ankle motor: ω_noload ∫τ dt


@dataclass(frozen=True, eq=False)
class StrideBatch:
    """N strides as arrays; the fields are those of `Stride`."""

    outcome: NDArray[np.int64]  # (N,), values of `Outcome`
    results: Array = field(repr=False)  # (N, record.RESULTS): the kernel's rows

    def __repr__(self) -> str:
        return f"StrideBatch({len(self.outcome)} strides, {int(self.walked.sum())} walked)"

    @property
    def state(self) -> Array:
        """(N, 4) after the heel strikes; NaN after a fall."""
        return self.results[:, record.STATE]

    @property
    def final(self) -> Array:
        """(N, 6) (φ, α, β) and their rates at the ends, before any heel strike; β is the shank's
        where the knee is bent."""
        return self.results[:, record.FINAL]

    @property
    def final_q(self) -> Array:
        """(N, 3) rad, relative angles at the ends, before any heel strike."""
        return self._motion[0]

    @property
    def final_u(self) -> Array:
        """(N, 3) rad/s, their rates."""
        return self._motion[1]

    @property
    def final_knee(self) -> Array:
        """(N, 2) rad and rad/s, flexion of the swing knee at the ends; 0 if it is straight."""
        return self._motion[2]

    @property
    def _motion(self) -> tuple[Array, Array, Array]:
        return joint_motion(self.final, self.results[:, record.FINAL_THIGH])

    @property
    def walked(self) -> NDArray[np.bool_]:
        """(N,) which strides ended in a heel strike."""
        return self.outcome == int(Outcome.WALKED)

    @property
    def duration(self) -> Array:
        """(N,) s."""
        return self.results[:, record.DURATION]

    @property
    def step_length(self) -> Array:
        """(N,) m."""
        return self.results[:, record.STEP_LENGTH]

    @property
    def energy_in(self) -> Array:
        """(N,) J."""
        return self.results[:, record.ENERGY_IN]

    @property
    def positive_work(self) -> Array:
        """(N,) J."""
        return self.results[:, record.POSITIVE_WORK]

    @property
    def energy_lost(self) -> Array:
        """(N,) J."""
        return self.results[:, record.ENERGY_LOST]

    @property
    def min_clearance(self) -> Array:
        """(N,) m."""
        return self.results[:, record.MIN_CLEARANCE]

    @property
    def electrical_energy(self) -> Array:
        """(N,) J."""
        return self.results[:, record.ELECTRICAL_ENERGY]


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
    check_walkable(params, control)
    powered, start = scheme_of(control), np.array([checked])
    row = rows_of(control, start) if callable(control) else np.array([powered.row(control)])
    results, outcomes = _run(
        powered.cycle,
        start,
        row,
        pack(params)[np.newaxis],
        check_heights(step_height, 1),
        check_rtol(rtol),
    )
    return _stride_of(results[0], Outcome(int(outcomes[0])))


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


def joint_motion(pose: Array, thigh: Array) -> tuple[Array, Array, Array]:
    """Relative angles (q1, q2, q3), their rates, and the swing knee's flexion with its rate.

    Args:
        pose: (..., 6) φ, α, β and their rates; thigh: (..., 2) θ and its rate.
    """
    leg = np.stack([pose[..., 2], pose[..., 5]], axis=-1) - thigh
    absolute = pose.copy()
    absolute[..., 2], absolute[..., 5] = thigh[..., 0], thigh[..., 1]
    absolute[..., 1:3] -= pose[..., :2]
    absolute[..., 4:6] -= pose[..., 3:5]
    return absolute[..., :3], absolute[..., 3:], leg


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
    kernel.run_strides(
        kernel.workspace_for(),
        code,
        states,
        controls,
        rows,
        heights,
        rtol,
        results,
        0.0,
        NO_ROWS,
        NO_ROWS,
        NO_ROWS,
        NO_ROWS,
    )


def outcomes_of(results: Array) -> NDArray[np.int64]:
    """(N,) the outcomes in the kernel's rows."""
    return results[:, record.OUTCOME].astype(np.int64)


def _stride_of(row: Array, outcome: Outcome) -> Stride:
    values = row.tolist()
    phi, alpha, beta, dphi, dalpha, dbeta = values[record.FINAL]
    theta, dtheta = values[record.FINAL_THIGH]
    return Stride(
        PostStrikeState(*values[record.STATE]),
        Final(
            (phi, alpha - phi, theta - alpha),
            (dphi, dalpha - dphi, dtheta - dalpha),
            (beta - theta, dbeta - dtheta),
        ),
        outcome,
        *values[record.DURATION : record.OUTCOME],
    )
