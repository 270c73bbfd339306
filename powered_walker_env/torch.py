"""The stride map as a differentiable function of torch (import it on demand: needs torch).

The derivatives are those of the gait laboratory, carried along with the stride by the
variational equations (`derivatives.py`), not of a surrogate: gradients of whatever
follows the strides are exact to the integrator's accuracy. Policies and walkers can be
optimised through walks of many strides.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import torch
from torch.autograd.function import once_differentiable

from powered_walker_env.model.phases import Cycle
from powered_walker_env.model.powering import CONTROL_NUMBERS, AnyControl, Policy, numbers_for
from powered_walker_env.model.state import natural_units
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.simulation import record
from powered_walker_env.simulation.arguments import Array, check_batch, check_rtol
from powered_walker_env.simulation.derivatives import (
    WALKER_NUMBERS,
    directions,
    policy_derivative,
    run_derivatives,
)
from powered_walker_env.simulation.strides import run_batch

_FLAT = np.zeros(1)  # m, step of the ground: the kernel differentiates strides on flat ground
_PRECISIONS = (torch.float32, torch.float64)


class Strides(NamedTuple):
    """N strides as tensors, of the type and on the device of the states they began at."""

    state: torch.Tensor  # (N, 4) after the heel strikes; NaN after a fall
    duration: torch.Tensor  # (N,) s, to the heel strike or to the fall
    step_length: torch.Tensor  # (N,) m, 0 after a fall
    walked: torch.Tensor  # (N,) bool, which strides ended in a heel strike


def differentiable_strides(
    states: torch.Tensor,
    controls: torch.Tensor | AnyControl | Policy | None,
    params: WalkerParams,
    *,
    parameters: Mapping[str, torch.Tensor] | None = None,
    rtol: float = 1e-9,
    scheme: str | None = None,
) -> Strides:
    """N strides on flat ground, as `stride_batch` walks them, with exact gradients.

    Derivatives are calculated, in the same run, only if gradients are enabled and an
    input requires them, and only by such inputs: by state and control, a stride costs
    about as much as six without. The calculation is in double precision on the CPU,
    whatever the type and the device of the inputs.

    A walker that fell has the state NaN, and the gradient through its stride is zero,
    whatever comes back from it: a batch with falls can be trained. Choose with
    `torch.where(strides.walked[:, None], strides.state, start)`, not by multiplication:
    zero times NaN is NaN. Derivatives of derivatives are not defined.

    Args:
        states: (N, 4) post-strike states, rad and rad/s, float32 or float64.
        controls: (N, k) or (k,) numbers of the scheme's control, of the motor switch angles
            (rad) and stall torques (N m); a control, which has no gradient; None for passive
            walkers; or a policy. A `torch.nn.Module` is called with the states; another
            policy is one of numpy arrays, as everywhere, and its derivative counts.
        params: the walker.
        parameters: fields of the walker by name, () or (N,) each, in place of those of
            `params`.
        rtol: accuracy asked of the post-strike states, 1e-13 to 1e-3.
        scheme: what the numbers control, by name; the motor if left out.

    Raises:
        ValueError: wrong shapes, a value that is not finite or out of its domain, an
            unknown parameter.
        TypeError: something else than tensors of real numbers.
    """
    if not isinstance(params, WalkerParams):
        raise TypeError(
            f"params must be one WalkerParams, got {params!r}; what differs from row to row goes "
            "in parameters"
        )
    if isinstance(controls, torch.nn.Module):
        _check_tensor("states", states)
        controls = controls(states)
    fixed = controls is None or callable(controls) or hasattr(controls, "__dataclass_fields__")
    tensors: dict[str, Any] = {"states": states, **({} if fixed else {"controls": controls})}
    tensors |= parameters or {}
    for name, tensor in tensors.items():
        _check_tensor(name, tensor)
    if states.ndim != 2 or states.shape[1] != 4:
        raise ValueError(f"states must have shape (N, 4), got {tuple(states.shape)}")
    count = len(states)
    # The way to double precision on the CPU and back is torch's own, gradients included.
    given = {name: tensor.to("cpu", torch.float64) for name, tensor in tensors.items()}
    named = {name: given[name] for name in parameters or {}}
    walkers = _walkers(params, named, count)
    plain: Any = given["controls"].detach().numpy() if not fixed else controls
    start = given["states"].detach().numpy()
    problem, policy = _problem(start, plain, walkers, rtol, list(named), scheme)
    if policy is not None:
        units = natural_units(walkers[0])
        actions = _PolicyNumbers.apply(policy, units, given["states"])
    elif not fixed:
        actions = given["controls"]
    else:
        actions = torch.from_numpy(problem.controls[:, problem.columns])
    inputs = [given["states"], actions.expand(count, len(problem.columns))]
    inputs += [value.expand(count) for value in named.values()]
    wanted = torch.is_grad_enabled() and any(tensor.requires_grad for tensor in inputs)
    outputs = _DifferentiableStrides.apply(problem, wanted, *inputs)
    *results, walked = outputs
    back = [tensor.to(states.device, states.dtype) for tensor in results]
    return Strides(back[0], back[1], back[2], walked.to(states.device))


class _Problem(NamedTuple):
    """Strides to walk, as the kernel takes them: checked."""

    cycle: Cycle
    columns: list[int]  # (k,) where the scheme's numbers go
    states: Array  # (N, 4)
    controls: Array  # (N, 2) the kernel's rows
    rows: Array  # packed walkers, N or 1
    rtol: float
    changes: Array  # (4 + k + p, 6 + OWN) every direction that there is


class _PolicyNumbers(torch.autograd.Function):
    """A policy of numpy arrays as a function of the states (N, 4), with its derivative."""

    @staticmethod
    def forward(ctx: Any, policy: Policy, units: Array, states: torch.Tensor) -> torch.Tensor:
        """(N, k) numbers of the control."""
        start = states.detach().numpy()
        if ctx.needs_input_grad[2]:
            ctx.save_for_backward(torch.from_numpy(policy_derivative(policy, start, units)))
        return torch.from_numpy(numbers_for(policy, start))

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, *grads: torch.Tensor) -> tuple[torch.Tensor | None, ...]:
        """The gradient by the states."""
        (by_states,) = ctx.saved_tensors
        return None, None, torch.einsum("nk,nkd->nd", grads[0], by_states)


class _DifferentiableStrides(torch.autograd.Function):
    """Strides by state (N, 4), control (N, k) and p parameters (N,), double precision, CPU."""

    @staticmethod
    def forward(
        ctx: Any, problem: _Problem, wanted: bool, *inputs: torch.Tensor
    ) -> tuple[torch.Tensor, ...]:
        """State, duration, step length, and which ones walked."""
        cycle, numbers, states, controls, rows, rtol, changes = problem
        if wanted:
            columns = [4, len(numbers)] + [1] * (len(inputs) - 2)
            ctx.columns = [
                size if needed else 0
                for size, needed in zip(columns, ctx.needs_input_grad[2:], strict=True)
            ]
            used = np.repeat(ctx.needs_input_grad[2:], columns)
            strides, by = run_derivatives(cycle, states, controls, rows, rtol, changes[used])
            ctx.save_for_backward(torch.from_numpy(by), torch.from_numpy(strides.walked))
        else:
            strides = run_batch(cycle, states, controls, rows, _FLAT, rtol)
        walked = torch.from_numpy(strides.walked)
        ctx.mark_non_differentiable(walked)
        return (
            torch.from_numpy(strides.results[:, record.STATE].copy()),
            torch.from_numpy(strides.duration.copy()),
            torch.from_numpy(strides.step_length.copy()),
            walked,
        )

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, *grads: torch.Tensor) -> tuple[torch.Tensor | None, ...]:
        """The gradients by the inputs: those by the outputs times the derivatives."""
        by, walked = ctx.saved_tensors
        by_outputs = torch.cat([grads[0], grads[1][:, None], grads[2][:, None]], dim=1)
        product = torch.einsum("no,nod->nd", by_outputs, by)
        product = torch.where(walked[:, None], product, 0.0)  # a fall has no derivatives
        parts = torch.split(product, ctx.columns, dim=1)
        found = [
            None if not size else (part if k < 2 else part[:, 0])
            for k, (part, size) in enumerate(zip(parts, ctx.columns, strict=True))
        ]
        return (None, None, *found)


def _check_tensor(name: str, tensor: Any) -> None:
    if not isinstance(tensor, torch.Tensor):
        raise TypeError(f"{name} must be a tensor, got {tensor!r}; torch.as_tensor makes one")
    if tensor.dtype not in _PRECISIONS:
        raise TypeError(
            f"{name} must be of type torch.float64 or torch.float32, got {tensor.dtype}"
        )


def _walkers(
    params: WalkerParams, values: Mapping[str, torch.Tensor], count: int
) -> list[WalkerParams]:
    """The walkers that the parameters make of `params`: one, or N."""
    for name, value in values.items():
        if name not in WALKER_NUMBERS:
            others = "; pass it in controls" if name in CONTROL_NUMBERS else ""
            raise ValueError(f"parameters are of {', '.join(WALKER_NUMBERS)}, got {name!r}{others}")
        if tuple(value.shape) not in ((), (count,)):
            raise ValueError(
                f"parameter {name} must have shape () or ({count},), got {tuple(value.shape)}"
            )
    if all(value.ndim == 0 for value in values.values()):
        return [params.replace(**{name: value.item() for name, value in values.items()})]
    columns = {name: value.expand(count).tolist() for name, value in values.items()}
    return [
        params.replace(**{name: column[i] for name, column in columns.items()})
        for i in range(count)
    ]


def _problem(
    states: Array, controls: Any, walkers: list[WalkerParams], rtol: float, by: list[str],
    scheme: str | None,
) -> tuple[_Problem, Policy | None]:  # fmt: skip
    """Everything checked, and the policy if there is one.

    Raises:
        ValueError: as `differentiable_strides` has it.
    """
    if not np.isfinite(states).all():
        row = int(np.argmin(np.isfinite(states).all(axis=1)))
        raise ValueError(
            f"states must be finite, got {states[row].tolist()} in row {row}; put a start in "
            "place of a walker that fell: torch.where(strides.walked[:, None], strides.state, "
            "start)"
        )
    batch = check_batch(states, controls, walkers, scheme)
    changes, powered = directions(batch.scheme, by), batch.scheme
    problem = _Problem(
        powered.cycle, list(powered.columns), batch.states, batch.controls, batch.rows,
        check_rtol(rtol), changes,
    )  # fmt: skip
    return problem, batch.policy
