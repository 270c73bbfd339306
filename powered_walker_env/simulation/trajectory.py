"""A walk as a trajectory: the same kernel, with its log switched on."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.model.checks import whole_number
from powered_walker_env.model.knees import encode, encoded
from powered_walker_env.model.mechanics.packing import pack
from powered_walker_env.model.phases import Cycle, Outcome, Torque
from powered_walker_env.model.powering import (
    AnyControl,
    Policy,
    as_policy,
    check_walkable,
    scheme_of,
)
from powered_walker_env.model.state import PostStrikeState, check_state
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.simulation import hand_over, kernel, record
from powered_walker_env.simulation.arguments import Array, check_rtol, rows_of
from powered_walker_env.simulation.strides import NO_ROWS
from powered_walker_env.simulation.walked import joint_motion

EVENT_ROWS = 4 * hand_over.MAX_PHASES  # rows that the events of a stride can need


class Event(NamedTuple):
    """Where a phase ended."""

    t: float  # s from the start of the walk
    phase: str  # the phase that ended
    stride: int
    q: tuple[float, float, float]  # rad, before any reset
    u: tuple[float, float, float]  # rad/s


@dataclass(frozen=True, eq=False)
class Trajectory:
    """A walk of one or more strides; both sides of every event are samples.

    Positions are measured along and normal to the floor, forward and up, from the
    first contact point.
    """

    params: WalkerParams
    t: Array  # (n,) s
    q: Array  # (n, 3) rad: foot to vertical q1, ankle q2, hip q3
    u: Array  # (n, 3) rad/s
    knee: Array  # (n, 2) rad and rad/s, flexion of the swing knee; 0 while it is straight
    phase: NDArray[np.int64]  # (n,) index of the phase (`knees.encoded` lists them)
    foot: Array  # (n, 2) m, centre of the stance foot
    stride: NDArray[np.int64]  # (n,) number of the stride
    ground: Array  # (m+1,) m, height of the ground under each stance foot, and the last landing
    landings: Array  # (m+1,) m, forward position of each contact point as its stride begins
    events: tuple[Event, ...]
    states: Array  # (m+1, 4) post-strike states; the last is NaN after a fall
    outcome: Outcome  # of the last stride
    motor_on: NDArray[np.bool_]  # (n,) whether the ankle's motor runs

    def __repr__(self) -> str:
        strides = len(self.landings) - 1
        return (
            f"Trajectory({strides} stride{'s' * (strides != 1)}, {self.t[-1]:.4g} s, "
            f"{self.landings[-1]:.4g} m, {len(self.t)} samples, {self.outcome.label})"
        )


class LoggedStride(NamedTuple):
    """One stride with its samples."""

    log: Array  # (n, record.LOG_COLUMNS): time, pose, thigh, phase
    result: Array  # (record.RESULTS,)
    outcome: Outcome


def log_stride(
    state: Sequence[float],
    control: AnyControl | None,
    params: WalkerParams,
    step_height: float,
    rtol: float,
    interval: float,
) -> LoggedStride:
    """One stride with a sample every `interval` seconds (0: events only); inputs known good."""
    longest = kernel.TIME_LIMIT * math.sqrt(params.leg_length / params.gravity)
    samples = 0 if interval == 0 else math.ceil(longest / interval)
    log = np.empty((EVENT_ROWS + samples, record.LOG_COLUMNS))
    results = np.empty((1, record.RESULTS))
    powered = scheme_of(control)
    logged = kernel.run_strides(
        kernel.workspace_for(),
        encode(powered.cycle),
        np.array([state], dtype=np.float64),
        np.array([powered.row(control)]),
        pack(params)[np.newaxis],
        np.array([step_height], dtype=np.float64),
        rtol,
        results,
        float(interval),
        log,
        NO_ROWS,
        NO_ROWS,
        NO_ROWS,
    )
    return LoggedStride(log[:logged], results[0], Outcome(int(results[0, record.OUTCOME])))


def walk(
    state: PostStrikeState | Sequence[float],
    control: AnyControl | Policy | None,
    params: WalkerParams,
    strides: int,
    *,
    step_heights: Sequence[float] | None = None,
    sample_interval: float = 0.02,
    rtol: float = 1e-9,
) -> Trajectory:
    """Walk until `strides` are done or the walker falls.

    Args:
        state: post-strike state to start from, rad and rad/s.
        control: a constant control, None for a passive walker, or a policy (of states, or a
            function from one post-strike state to the control of the stride; see `Policy`).
        params: the walker.
        strides: how many at most, at least 1.
        step_heights: m, rise of the ground at each stride; flat if left out.
        sample_interval: s between samples; 0 keeps the events only.
        rtol: accuracy asked of each post-strike state.

    Raises:
        ValueError: a state, count, height or interval out of its domain; a policy that
            returns no numbers of its scheme.
        TypeError: an argument of the wrong type.
    """
    checked = check_state(state)
    strides = whole_number("strides", strides, 1)
    if not (math.isfinite(sample_interval) and sample_interval >= 0):
        raise ValueError(f"sample_interval must not be negative, got {sample_interval!r}; seconds")
    heights = np.zeros(strides) if step_heights is None else np.asarray(step_heights, float)
    if heights.shape != (strides,) or not np.isfinite(heights).all():
        raise ValueError(f"step_heights must be {strides} finite heights, got {step_heights!r}")
    rtol = check_rtol(rtol)
    control = as_policy(control, checked)
    check_walkable(params, control)
    powered = scheme_of(control)
    builder = TrajectoryBuilder(params, checked)
    for height in heights:
        chosen = powered.control_of(rows_of(control, np.array([checked]))[0])
        logged = log_stride(checked, chosen, params, float(height), rtol, sample_interval)
        builder.add(logged, powered.cycle, float(height))
        if logged.outcome != Outcome.WALKED:
            break
        checked = PostStrikeState(*logged.result[record.STATE].tolist())
    return builder.build()


class TrajectoryBuilder:
    """Puts logged strides one after another in one world frame."""

    def __init__(
        self,
        params: WalkerParams,
        state: PostStrikeState,
        *,
        start: float = 0.0,
        ground: float = 0.0,
        landing: float = 0.0,
    ) -> None:
        """Begin at time `start` with the contact point at (`landing`, `ground`)."""
        self.params = params
        self._t, self._outcome = start, Outcome.WALKED
        self._ground, self._landings = [ground], [landing]
        self._states = [np.array(state)]
        self._pieces: list[tuple[Array, Array, Array, int]] = []
        self._motor: list[NDArray[np.bool_]] = []
        self._events: list[Event] = []

    def add(self, logged: LoggedStride, cycle: Cycle, height: float) -> None:
        """Append a stride of a scheme's cycle that walked onto ground `height` higher."""
        params, number, phases = self.params, len(self._pieces), encoded(cycle).phases
        log = logged.log
        t = self._t + log[:, 0]
        rolled = params.foot_radius * (log[:, 1] - log[0, 1])
        up = np.full(len(log), self._ground[-1] + params.foot_radius)
        self._pieces.append((t, log, np.stack([self._landings[-1] + rolled, up], 1), number))
        on = np.array([phase.torque == Torque.MOTOR for phase in phases])
        self._motor.append(on[log[:, record.LOG_PHASE].astype(np.int64)])
        self._note_events(t, log, phases, number)
        self._t = float(t[-1])
        if logged.outcome == Outcome.WALKED:
            self._landings.append(self._landings[-1] + float(logged.result[record.STEP_LENGTH]))
            self._ground.append(self._ground[-1] + height)
        else:
            self._landings.append(self._landings[-1])
            self._ground.append(self._ground[-1])
        self._states.append(logged.result[record.STATE].copy())
        self._outcome = logged.outcome

    def _note_events(self, t: Array, log: Array, phases: Cycle, number: int) -> None:
        index = log[:, record.LOG_PHASE].astype(np.int64)
        last_rows = [*np.flatnonzero(np.diff(index)), len(log) - 1]
        for row in last_rows:
            q, u, _ = joint_motion(log[row, record.LOG_POSE], log[row, record.LOG_THIGH])
            name = phases[index[row]].name
            self._events.append(
                Event(float(t[row]), name, number, tuple(q.tolist()), tuple(u.tolist()))
            )

    def build(self) -> Trajectory:
        """The walk so far."""
        log = np.concatenate([piece[1] for piece in self._pieces])
        q, u, knee = joint_motion(log[:, record.LOG_POSE], log[:, record.LOG_THIGH])
        return Trajectory(
            params=self.params,
            t=np.concatenate([piece[0] for piece in self._pieces]),
            q=q,
            u=u,
            knee=knee,
            phase=log[:, record.LOG_PHASE].astype(np.int64),
            foot=np.concatenate([piece[2] for piece in self._pieces]),
            stride=np.concatenate([np.full(len(p[0]), p[3]) for p in self._pieces]),
            ground=np.array(self._ground),
            landings=np.array(self._landings),
            events=tuple(self._events),
            states=np.array(self._states),
            outcome=self._outcome,
            motor_on=np.concatenate(self._motor),
        )
