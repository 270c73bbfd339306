"""How a stride is computed, from heel strike to heel strike, with its derivatives.

- `strides`, `derivatives`, `trajectory`: what Python calls: one stride, many, many with their
  derivatives, a walk sampled in time; `arguments` checks what they are given, `desk` keeps
  memory for them;
- `kernel`: eight walkers abreast; `lockstep`: where each is in its stride; `runge_kutta` and
  `interpolant`: its steps; `watching`, `roots`, `events`: guards, where they fall through zero, and
  the way there; `hand_over` and `resets`: where phases and strides end and begin; `waiting`: which
  stride comes next, and when; `totals` and `record`: what is summed up and noted down;
  `sensitivity`: the variational equations.

One landing: the guard falls in `events`, `hand_over.end_phases` applies the reset and writes the
result, and the reset's formula is `model/mechanics/heel_strike.py`.
"""

from powered_walker_env.simulation.derivatives import (
    PARAMETERS,
    BatchDerivatives,
    differentiate_batch,
)
from powered_walker_env.simulation.strides import stride, stride_batch
from powered_walker_env.simulation.trajectory import Event, Trajectory, walk
from powered_walker_env.simulation.walked import Stride, StrideBatch

__all__ = [
    "PARAMETERS",
    "BatchDerivatives",
    "Event",
    "Stride",
    "StrideBatch",
    "Trajectory",
    "differentiate_batch",
    "stride",
    "stride_batch",
    "walk",
]
