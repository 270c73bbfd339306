"""The stride map on the Poincaré section, and its exact derivatives.

The section of the package is the instant just after heel strike: (α, s, α', β'), four
numbers. The thesis's is the instant the motor starts (section 7): (q1, u1, u3), three
numbers, since there the hip angle is the switch angle and the foot is locked. Both
maps have the same multipliers, but for a zero that the larger section adds.

A map is a walker with a constant control, with none (passive), or with a policy: a
closed loop is a map like any other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from powered_walker_env.model.knees import encode
from powered_walker_env.model.mechanics.packing import pack
from powered_walker_env.model.phases import BENT, Cycle, Joints, Outcome
from powered_walker_env.model.powering import (
    AnyControl,
    Policy,
    Scheme,
    as_policy,
    check_walkable,
    numbers_for,
    scheme_of,
)
from powered_walker_env.model.state import PostStrikeState, natural_units
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.tolerances import GAIT_RTOL
from powered_walker_env.simulation import record
from powered_walker_env.simulation.arguments import check_rtol
from powered_walker_env.simulation.derivatives import (
    STATE_SIZE,
    closed_loop,
    directions,
    names_of,
    policy_derivative,
    run_derivatives,
)
from powered_walker_env.simulation.strides import Array, run_batch
from powered_walker_env.simulation.trajectory import log_stride
from powered_walker_env.simulation.walked import StrideBatch


class MapPoint(NamedTuple):
    """Where the map takes a state, with derivatives; NaN after a fall.

    The last axis of each derivative counts what it is by, named in `names`: the state (4),
    the k numbers of the scheme's control, then the parameters asked for. Under a policy the
    derivatives by the control are by what is added to the policy's numbers.
    """

    state: Array  # (4,) after the strides
    duration: float  # s, of all of them
    step_length: float  # m
    by: Array  # (4, n) derivatives of the state
    duration_by: Array  # (n,)
    step_length_by: Array  # (n,)
    outcome: Outcome  # of the last stride walked
    names: tuple[str, ...] = ()  # (n,)
    controls: int = 0  # k

    def __repr__(self) -> str:
        return f"MapPoint({self.state.tolist()}, by {', '.join(self.names)}; {self.outcome.label})"

    @property
    def by_state(self) -> Array:
        """(4, 4) the Jacobian of the map."""
        return self.by[:, :STATE_SIZE]

    @property
    def by_control(self) -> Array:
        """(4, k) by the control's numbers; of the motor: switch angle, rad, stall torque, N m."""
        return self.by[:, STATE_SIZE : STATE_SIZE + self.controls]

    @property
    def by_parameters(self) -> Array:
        """(4, p) by the parameters asked for."""
        return self.by[:, STATE_SIZE + self.controls :]


@dataclass(frozen=True, eq=False)
class StrideMap:
    """A walker under a constant control, none, or a policy, as a map of post-strike states.

    Raises:
        ValueError, TypeError: a walker that the control cannot power, a tolerance out of bounds.
    """

    params: WalkerParams
    control: AnyControl | Policy | None
    rtol: float = GAIT_RTOL

    def __post_init__(self) -> None:
        object.__setattr__(self, "control", as_policy(self.control))
        object.__setattr__(self, "rtol", check_rtol(self.rtol))
        check_walkable(self.params, self.control)

    @property
    def scheme(self) -> Scheme:
        """What powers the walker."""
        return scheme_of(self.control)

    @property
    def cycle(self) -> Cycle:
        """The phases of its strides."""
        return self.scheme.cycle

    def controls(self, states: Array) -> Array:
        """(N, 2) the kernel's rows of the controls of the strides from these states (N, 4)."""
        return self.scheme.rows(numbers_for(self.control, states))

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
            by: parameters to differentiate by: fields of the walker, numbers of the control.

        Raises:
            ValueError: an unknown parameter.
        """
        changes = directions(self.scheme, by)
        x = np.array(state, dtype=np.float64)
        moved = np.eye(STATE_SIZE, len(changes))
        duration, length = 0.0, 0.0
        totals = np.zeros((2, len(changes)))
        outcome = Outcome.WALKED
        for _ in range(period):
            row, derivative, outcome = self._stride_derivative(x, changes)
            x = row[record.STATE]
            duration += float(row[record.DURATION])
            length += float(row[record.STEP_LENGTH])
            full = derivative[:, :STATE_SIZE] @ moved
            full[:, STATE_SIZE:] += derivative[:, STATE_SIZE:]
            moved = full[:STATE_SIZE]
            totals += full[STATE_SIZE:]
            if outcome != Outcome.WALKED:
                break
        names = names_of(self.scheme, by)
        count = len(self.scheme.numbers)
        return MapPoint(x, duration, length, moved, totals[0], totals[1], outcome, names, count)

    def _stride_derivative(self, x: Array, changes: Array) -> tuple[Array, Array, Outcome]:
        """One stride's results, and (6, n) its derivatives, of the loop if it is closed."""
        start, walker = np.ascontiguousarray(x)[np.newaxis], pack(self.params)[np.newaxis]
        strides, found = run_derivatives(
            self.cycle, start, self.controls(start), walker, self.rtol, changes
        )
        if callable(self.control):
            gains = policy_derivative(self.control, start, natural_units(self.params))
            found = closed_loop(found, gains)
        return strides.results[0], found[0], Outcome(int(strides.outcome[0]))


def switch_section(
    state: PostStrikeState, control: AnyControl, params: WalkerParams
) -> tuple[float, float, float] | None:
    """(q1, u1, u3) where the motor starts in the stride from `state`; None if it does not.

    None, too, where the hip passes the switch on a bent knee: that takes five numbers.
    """
    logged, scheme = log_stride(state, control, params, 0.0, GAIT_RTOL, 0.0), scheme_of(control)
    first = {0, int(encode(scheme.cycle)[0, BENT])}
    phases = logged.log[:, record.LOG_PHASE].astype(np.int64)
    later = np.flatnonzero(~np.isin(phases, list(first)))
    if not len(later) or scheme.phases[phases[later[0]]].joints == Joints.KNEE_FREE:
        return None
    phi, _, _, dphi, dalpha, dbeta = logged.log[later[0], record.LOG_POSE].tolist()
    return phi, dphi, dbeta - dalpha
