"""Many strides with their exact derivatives, on all cores.

The variational equations are carried along with every stride, with the saltation at its
events (`sensitivity.py`): a derivative is that of the very stride walked, to the
integrator's accuracy. A stride with the derivatives by state and control costs about as
much as six without.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from powered_walker_env.model.mechanics.constants import NUMBERS, OWN, ROW, row_tangents
from powered_walker_env.model.phases import Cycle, encode
from powered_walker_env.model.powering import CONTROL_NUMBERS
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.simulation import kernel, record
from powered_walker_env.simulation.sensitivity import CHANGES, OUTPUTS
from powered_walker_env.simulation.strides import (
    NO_ROWS,
    Array,
    StrideBatch,
    check_batch,
    check_rtol,
    outcomes_of,
)
from powered_walker_env.simulation.threads import run_in_slices

#: What a stride can be differentiated by besides its state: numbers of controls, of walkers.
WALKER_NUMBERS = NUMBERS[:-1]  # the last is the physics, which is no number
PARAMETERS = (*CONTROL_NUMBERS, *WALKER_NUMBERS)
_STATE, _CONTROL = 4, 2
_ALL = _STATE + _CONTROL + OWN
_COLUMNS = {name: _STATE + column for name, column in CONTROL_NUMBERS.items()} | {
    name: _STATE + _CONTROL + column for column, name in enumerate(WALKER_NUMBERS)
}
_FLAT = np.zeros(1)


@dataclass(frozen=True, eq=False)
class BatchDerivatives:
    """N strides and their derivatives; those of a walker that fell are NaN.

    The last axis of each derivative counts the directions: the state (4), the control
    (2), then the parameters asked for; SI units over SI units.
    """

    strides: StrideBatch
    by: Array = field(repr=False)  # (N, 6, 6 + k) of the state (4), duration and step length

    @property
    def by_state(self) -> Array:
        """(N, 4, 4) of the post-strike states by the states."""
        return self.by[:, :4, :4]

    @property
    def by_control(self) -> Array:
        """(N, 4, 2) of them by switch angle, rad, and stall torque, N m."""
        return self.by[:, :4, 4:6]

    @property
    def by_parameters(self) -> Array:
        """(N, 4, k) of them by the parameters asked for."""
        return self.by[:, :4, 6:]

    @property
    def duration_by(self) -> Array:
        """(N, 6 + k) of the durations."""
        return self.by[:, 4]

    @property
    def step_length_by(self) -> Array:
        """(N, 6 + k) of the step lengths."""
        return self.by[:, 5]


def differentiate_batch(
    states: ArrayLike,
    controls: ArrayLike | None,
    params: WalkerParams | Sequence[WalkerParams],
    *,
    by: Sequence[str] = (),
    rtol: float = 1e-9,
) -> BatchDerivatives:
    """N strides on flat ground with their derivatives.

    Args:
        states, controls, params, rtol: as in `stride_batch`, which walks the same strides
            bit for bit. A passive walker's derivatives by the control are zero.
        by: names out of `PARAMETERS`, what else to differentiate by.

    Raises:
        ValueError: wrong shapes, a value out of its domain, an unknown parameter.
    """
    changes = directions(by)
    cycle, start, angles, rows = check_batch(states, controls, params)
    return BatchDerivatives(*run_derivatives(cycle, start, angles, rows, check_rtol(rtol), changes))


def run_derivatives(
    cycle: Cycle, states: Array, controls: Array, rows: Array, rtol: float, changes: Array
) -> tuple[StrideBatch, Array]:
    """The strides and their derivatives, (N, 6, n), on arrays that are known to be good.

    Args:
        rows: packed walkers, N or one for all.
        changes: (n, 6 + OWN) the directions: of state (4), control (2) and the walker's own numbers.
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


def directions(by: Sequence[str] = ()) -> Array:
    """(6 + k, 6 + OWN) the kernel's directions: state, control, then the parameters named.

    Raises:
        ValueError: an unknown parameter.
    """
    wanted = list(range(_STATE + _CONTROL))
    for name in by:
        if name not in PARAMETERS:
            raise ValueError(f"parameter must be one of {', '.join(PARAMETERS)}, got {name!r}")
        wanted.append(_COLUMNS[name])
    every: Array = np.eye(_ALL)
    return every[wanted]
