"""Many strides with their exact derivatives, on all cores.

The variational equations are carried along with every stride, with the saltation at its
events (`sensitivity.py`): a derivative is that of the very stride walked, to the
integrator's accuracy. A stride with the derivatives by state and control costs about as
much as six without.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from powered_walker_env.model.knee import Knee
from powered_walker_env.model.knees import encode
from powered_walker_env.model.mechanics.packing import NUMBERS, OWN, ROW, row_tangents
from powered_walker_env.model.phases import Cycle
from powered_walker_env.model.powering import (
    CONTROL_NUMBERS,
    AnyControl,
    Policy,
    Scheme,
    numbers_for,
    scheme_of,
)
from powered_walker_env.model.quantities import quantities
from powered_walker_env.model.state import PostStrikeState, natural_units
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.simulation import kernel, record
from powered_walker_env.simulation.arguments import Array, check_batch, check_rtol
from powered_walker_env.simulation.differences import differences
from powered_walker_env.simulation.directions import CHANGES, OUTPUTS
from powered_walker_env.simulation.strides import NO_ROWS, outcomes_of
from powered_walker_env.simulation.threads import run_in_slices
from powered_walker_env.simulation.walked import StrideBatch

WALKER_NUMBERS = NUMBERS[:-1]  # the last is the physics, which is no number


class Parameters(Sequence[str]):
    """Names of the numbers of all schemes' controls, those registered later included, and of
    walkers."""

    def __len__(self) -> int:
        return len(CONTROL_NUMBERS) + len(WALKER_NUMBERS)

    def __getitem__(self, index: Any) -> Any:
        return (*CONTROL_NUMBERS, *WALKER_NUMBERS)[index]


#: What a stride can be differentiated by besides its state. One walker has the numbers of its
#: own scheme only (`parameters_of`).
PARAMETERS = Parameters()
STATE_SIZE, _CONTROL = 4, 2
_ALL = STATE_SIZE + _CONTROL + OWN
_FLAT = np.zeros(1)
POLICY_STEP = 1e-4  # natural units, of the differences of a policy in double precision


@dataclass(frozen=True, eq=False)
class BatchDerivatives:
    """N strides and their derivatives; those of a walker that fell are NaN.

    The last axis of each derivative counts what it is by, named in `names`: the state (4),
    the k numbers of the scheme's control, then the parameters asked for; SI units over SI
    units. Under a policy the derivatives by the state are the closed loop's, and those by
    the control are by what is added to the policy's numbers.
    """

    strides: StrideBatch
    by: Array = field(repr=False)  # (N, 6, n) of the state (4), duration and step length
    names: tuple[str, ...]  # (n,)
    controls: int  # k

    def __repr__(self) -> str:
        return f"BatchDerivatives({self.strides!r} by {', '.join(self.names)})"

    @property
    def by_state(self) -> Array:
        """(N, 4, 4) of the post-strike states by the states."""
        return self.by[:, :4, :STATE_SIZE]

    @property
    def by_control(self) -> Array:
        """(N, 4, k) of them by the control's numbers; the motor's: switch angle, stall torque."""
        return self.by[:, :4, STATE_SIZE : STATE_SIZE + self.controls]

    @property
    def by_parameters(self) -> Array:
        """(N, 4, p) of them by the parameters asked for."""
        return self.by[:, :4, STATE_SIZE + self.controls :]

    @property
    def duration_by(self) -> Array:
        """(N, n) of the durations."""
        return self.by[:, 4]

    @property
    def step_length_by(self) -> Array:
        """(N, n) of the step lengths."""
        return self.by[:, 5]


def differentiate_batch(
    states: ArrayLike,
    controls: ArrayLike | AnyControl | Policy | None,
    params: WalkerParams | Sequence[WalkerParams],
    *,
    by: Sequence[str] = (),
    rtol: float = 1e-9,
    scheme: str | None = None,
) -> BatchDerivatives:
    """N strides on flat ground with their derivatives.

    Args:
        states, controls, params, rtol, scheme: as in `stride_batch`, which walks the same
            strides bit for bit.
        by: what else to differentiate by: fields of `WalkerParams`, or numbers of the
            scheme's control (which `by_control` has anyway).

    Raises:
        ValueError: wrong shapes, a value out of its domain, a parameter that such a walker
            has not.
    """
    batch = check_batch(states, controls, params, scheme)
    changes = directions(batch.scheme, by)
    for walker in (params,) if isinstance(params, WalkerParams) else params:
        refuse_missing(walker, by)
    strides, found = run_derivatives(
        batch.scheme.cycle, batch.states, batch.controls, batch.rows, check_rtol(rtol), changes
    )
    if batch.policy is not None:
        walker = params if isinstance(params, WalkerParams) else next(iter(params))
        gains = policy_derivative(batch.policy, batch.states, natural_units(walker))
        found = closed_loop(found, gains)
    return BatchDerivatives(strides, found, names_of(batch.scheme, by), len(batch.scheme.numbers))


def policy_derivative(policy: Policy, states: Array, units: Array) -> Array:
    """(N, k, 4) derivative of a policy's numbers by the states: its own, or by differences.

    Args:
        units: (4,) natural units of the states.

    Raises:
        ValueError: a derivative of its own that has another shape.
    """
    own = getattr(policy, "derivative", None)
    if own is None:
        return differences(lambda x: numbers_for(policy, x), states, POLICY_STEP * units)
    known = np.asarray(own(states), np.float64)
    wanted = (len(states), len(scheme_of(policy).numbers), STATE_SIZE)
    if known.shape != wanted:
        raise ValueError(f"a policy's derivative must have shape {wanted}, got {known.shape}")
    return known


def closed_loop(by: Array, gains: Array) -> Array:
    """(N, m, n) derivatives under a policy from those under its controls held constant."""
    closed = by.copy()
    by_control = by[..., STATE_SIZE : STATE_SIZE + gains.shape[1]]
    closed[..., :STATE_SIZE] += by_control @ gains
    return closed


def run_derivatives(
    cycle: Cycle, states: Array, controls: Array, rows: Array, rtol: float, changes: Array
) -> tuple[StrideBatch, Array]:
    """The strides and their derivatives, (N, 6, n), on arrays that are known to be good.

    Args:
        rows: packed walkers, N or one for all.
        changes: (n, 6 + OWN) the directions: state (4), control (2), the walker's own numbers.
    """
    results = np.empty((len(states), record.RESULTS))
    derivatives = np.empty((len(states), len(changes), OUTPUTS))
    code = encode(cycle)
    along = np.ascontiguousarray(changes[:, :CHANGES])
    own = rows[:, :OWN]
    walkers = np.stack([row_tangents(own, change) for change in changes[:, CHANGES:]], axis=1)

    def work(part: slice) -> None:
        kernel.run_strides(
            kernel.workspace_for(len(along)),
            code,
            states[part],
            controls[part],
            rows if len(rows) == 1 else rows[part],
            _FLAT,
            rtol,
            results[part],
            0.0,
            NO_ROWS,
            along,
            (walkers if len(rows) == 1 else walkers[part]).reshape(-1, ROW),
            derivatives[part].reshape(-1, OUTPUTS),
        )

    run_in_slices(work, len(states))
    return StrideBatch(outcomes_of(results), results), derivatives.swapaxes(1, 2)


def parameters_of(scheme: Scheme) -> tuple[str, ...]:
    """What a walker so powered can be differentiated by, besides its state."""
    return (*scheme.numbers, *WALKER_NUMBERS)


def refuse_missing(params: WalkerParams, by: Sequence[str]) -> None:
    """Reject numbers of a knee that a walker has not.

    Raises:
        ValueError: naming the number.
    """
    for name in by:
        if name in quantities(Knee):
            params.number(name)


def names_of(scheme: Scheme, by: Sequence[str] = ()) -> tuple[str, ...]:
    """What the derivatives are by, in their order."""
    return (*PostStrikeState._fields, *scheme.numbers, *by)


def directions(scheme: Scheme, by: Sequence[str] = ()) -> Array:
    """(4 + k + p, 6 + OWN) the kernel's directions: state, control, the parameters named.

    Raises:
        ValueError: a parameter that a walker so powered has not.
    """
    if isinstance(by, str):
        raise TypeError(f"by must be a list of names, got {by!r}")
    columns = {n: STATE_SIZE + c for n, c in zip(scheme.numbers, scheme.columns, strict=True)}
    columns |= {name: STATE_SIZE + _CONTROL + i for i, name in enumerate(WALKER_NUMBERS)}
    for name in by:
        if name not in columns:
            raise ValueError(
                f"parameter must be one of {', '.join(columns)} for scheme {scheme.name!r}, "
                f"got {name!r}"
            )
    wanted = [*range(STATE_SIZE), *(columns[name] for name in (*scheme.numbers, *by))]
    every: Array = np.eye(_ALL)
    return every[wanted]
