"""The stride map on the Poincaré section, and its exact derivatives.

The section of the package is the instant just after heel strike: (α, s, α', β'), four
numbers. The thesis's is the instant the motor starts (section 7): (q1, u1, u3), three
numbers, since there the hip angle is the switch angle and the foot is locked. Both
maps have the same multipliers, but for a zero that the larger section adds.

A map is a walker with a constant control, with none (passive), or with a policy: a
closed loop is a map like any other.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from powered_walker_env.model.mechanics.constants import pack
from powered_walker_env.model.phases import Cycle, Outcome
from powered_walker_env.model.powering import (
    MOTOR,
    AnyControl,
    Scheme,
    check_walkable,
    scheme,
    scheme_of,
)
from powered_walker_env.model.state import PostStrikeState
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.simulation import record
from powered_walker_env.simulation.derivatives import directions, run_derivatives
from powered_walker_env.simulation.strides import Array, StrideBatch, run_batch
from powered_walker_env.simulation.trajectory import log_stride

SECTION_RTOL = 1e-13  # of the strides behind a gait
POLICY_DIFFERENCE = 1e-4  # step of the differences of a policy without derivatives, natural units
_STATE, _CONTROL = slice(0, 4), slice(4, 6)


class Policy(Protocol):
    """A control law: post-strike states (N, 4) to switch angles and stall torques (N, 2).

    A policy of another way to power the walker has an attribute `scheme`, the name of one of
    `SCHEMES`, and gives the k numbers of its control, (N, k).

    A policy that knows its derivative, or calculates in less than double precision, has
    a method `derivative(states)`, (N, 4) to (N, k, 4): it is used in place of differences.
    """

    def __call__(self, states: Array, /) -> Array:
        """The controls of the strides that begin at these states."""


class MapPoint(NamedTuple):
    """Where the map takes a state, with derivatives; NaN after a fall.

    The directions are the state (4), the constant control (2) and the parameters asked
    for; under a policy the two control directions move what the policy puts out.
    """

    state: Array  # (4,) after the strides
    duration: float  # s, of all of them
    step_length: float  # m
    by: Array  # (4, 6 + k) derivatives of the state
    duration_by: Array  # (6 + k,)
    step_length_by: Array  # (6 + k,)
    outcome: Outcome  # of the last stride walked

    @property
    def by_state(self) -> Array:
        """(4, 4) the Jacobian of the map."""
        return self.by[:, _STATE]

    @property
    def by_control(self) -> Array:
        """(4, 2) by switch angle, rad, and strength (of the motor: stall torque), SI units."""
        return self.by[:, _CONTROL]

    @property
    def by_parameters(self) -> Array:
        """(4, k) by the parameters asked for."""
        return self.by[:, 6:]


@dataclass(frozen=True, eq=False)
class StrideMap:
    """A walker under a constant control, none, or a policy, as a map of post-strike states.

    Raises:
        ValueError, TypeError: a walker that the control cannot power.
    """

    params: WalkerParams
    control: AnyControl | Policy | None
    rtol: float = SECTION_RTOL

    def __post_init__(self) -> None:
        constant = self.scheme.control_of((1.0, 0.0)) if callable(self.control) else self.control
        check_walkable(self.params, constant)

    @property
    def scheme(self) -> Scheme:
        """What powers the walker."""
        return control_scheme(self.control)

    @property
    def cycle(self) -> Cycle:
        """The phases of its strides."""
        return self.scheme.cycle

    def controls(self, states: Array) -> Array:
        """(N, 2) the kernel's rows of the controls of the strides from these states (N, 4)."""
        if callable(self.control):
            chosen = np.asarray(self.control(states), dtype=np.float64)
            wanted = (len(states), len(self.scheme.columns))
            if chosen.shape != wanted:
                raise ValueError(
                    f"a policy must return controls of shape {wanted}, got {chosen.shape}"
                )
            return self.scheme.rows(chosen)
        return np.tile(self.scheme.row(self.control), (len(states), 1))

    def strides(self, states: Array) -> StrideBatch:
        """One stride from each of the states (N, 4)."""
        starts, row = np.ascontiguousarray(states), pack(self.params)[np.newaxis]
        return run_batch(self.cycle, starts, self.controls(starts), row, np.zeros(1), self.rtol)

    def __call__(self, states: Array, strides: int = 1) -> Array:
        """The states (N, 4) after some strides; NaN for walkers that fell."""
        for _ in range(strides):
            states = self.strides(states).state
        return states

    def differentiate(
        self, state: Sequence[float] | Array, period: int = 1, by: Sequence[str] = ()
    ) -> MapPoint:
        """The map over `period` strides and its derivatives.

        Exact to the integrator's accuracy: the variational equations are carried along
        (`sensitivity.py`), the chain rule joins strides, and a policy adds its own
        derivative, or fourth-order differences of the policy alone.

        Args:
            by: names out of `PARAMETERS`, the parameters to differentiate by.

        Raises:
            ValueError: an unknown parameter.
        """
        changes = directions(by)
        x = np.array(state, dtype=np.float64)
        moved = np.eye(4, len(changes))
        duration, length = 0.0, 0.0
        totals = np.zeros((2, len(changes)))
        outcome = Outcome.WALKED
        for _ in range(period):
            row, derivative, outcome = self._stride_derivative(x, changes)
            x, full = row[record.STATE], derivative @ self._chain(x, moved)
            duration += float(row[record.DURATION])
            length += float(row[record.STEP_LENGTH])
            moved = full[:4]
            totals += full[4:]
            if outcome != Outcome.WALKED:
                break
        return MapPoint(x, duration, length, moved, totals[0], totals[1], outcome)

    def _chain(self, x: Array, moved: Array) -> Array:
        """How this stride's directions move when those of the first one do."""
        chained = np.eye(moved.shape[1])
        chained[_STATE] = moved
        if callable(self.control):
            chained[_CONTROL] += policy_derivative(self, x) @ moved
        return chained

    def _stride_derivative(self, x: Array, changes: Array) -> tuple[Array, Array, Outcome]:
        start, walker = np.ascontiguousarray(x)[np.newaxis], pack(self.params)[np.newaxis]
        strides, derivatives = run_derivatives(
            self.cycle, start, self.controls(start), walker, self.rtol, changes
        )
        return strides.results[0], derivatives[0], Outcome(int(strides.outcome[0]))


def control_scheme(control: AnyControl | Policy | None) -> Scheme:
    """The scheme of a constant control, of none, or of a policy (by its `scheme`; the motor).

    Raises:
        TypeError: something that is no control.
        ValueError: a policy whose scheme does not exist, or has nothing to decide.
    """
    if not callable(control):
        return scheme_of(control)
    found = scheme(getattr(control, "scheme", MOTOR.name))
    if found.control is None:
        raise ValueError(f"a policy's scheme must have a control, got {found.name!r}")
    return found


def policy_derivative(stride_map: StrideMap, state: Array) -> Array:
    """(2, 4) derivative of a policy's control by the state: its own, or by differences."""
    own = getattr(stride_map.control, "derivative", None)
    if own is not None:
        known: Array = np.zeros((2, 4))
        known[list(stride_map.scheme.columns)] = np.asarray(own(state[np.newaxis]), np.float64)[0]
        return known
    steps = POLICY_DIFFERENCE * natural_units(stride_map.params)
    offsets = np.array([-2.0, -1.0, 1.0, 2.0])
    weights = np.array([1.0, -8.0, 8.0, -1.0]) / 12.0
    points = state + (offsets[:, np.newaxis, np.newaxis] * np.diag(steps)).reshape(-1, 4)
    controls = stride_map.controls(points).reshape(4, 4, 2)
    derivative: Array = (np.tensordot(weights, controls, axes=1) / steps[:, np.newaxis]).T
    return derivative


def natural_units(params: WalkerParams) -> Array:
    """Units of a post-strike state, (4,): radians, and radians per √(L/g)."""
    rate = math.sqrt(params.gravity / params.leg_length)
    return np.array([1.0, 1.0, rate, rate])


def switch_section(
    state: PostStrikeState, control: AnyControl, params: WalkerParams
) -> tuple[float, float, float] | None:
    """(q1, u1, u3) where the motor starts in the stride from `state`; None if it does not."""
    logged = log_stride(state, control, params, 0.0, SECTION_RTOL, 0.0)
    powered = np.flatnonzero(logged.log[:, 7] > 0)
    if not len(powered):
        return None
    phi, _, _, dphi, dalpha, dbeta = logged.log[powered[0], 1:7].tolist()
    return phi, dphi, dbeta - dalpha
