"""The differentiable stride: exact gradients, of whatever is asked for and of nothing else."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import torch
from torch.autograd import gradcheck

import powered_walker_env.torch as adapter
from powered_walker_env import (
    PRESETS,
    ToeOff,
    WalkerParams,
    differentiate_batch,
    regulate,
    stride_batch,
)
from powered_walker_env.model.powering import SCHEMES
from powered_walker_env.torch import differentiable_strides
from tests.helpers.published import PASSIVE_GAITS
from tests.helpers.samples import DECIDING
from tests.poincare.test_schemes_laboratory import gait_of, half_range

PARAMS, CONTROL, STATE, _ = PRESETS["round-foot"]
assert CONTROL is not None
UNITS = torch.tensor([0.1, 1000.0], dtype=torch.float64)  # of a control: rad, N m
NOMINAL = torch.tensor([CONTROL.switch_angle, CONTROL.stall_torque], dtype=torch.float64)
FALLEN = torch.tensor([-1.0, 0.2, 0.0, 0.0], dtype=torch.float64)
TIGHT = 1e-13  # so that differences over 1e-5 see the derivative, not the integrator


def states(count: int, seed: int = 0) -> torch.Tensor:
    rng = np.random.default_rng(seed)
    return torch.tensor(STATE + 0.003 * rng.normal(size=(count, 4)))


def actions(count: int) -> torch.Tensor:
    return torch.tensor(np.random.default_rng(1).normal(0.0, 0.02, (count, 2)))


def strides(start: torch.Tensor, action: torch.Tensor, **kwargs: Any) -> tuple[torch.Tensor, ...]:
    """State, duration, step length; controls in units, so that differences suit both."""
    found = differentiable_strides(start, NOMINAL + UNITS * action, PARAMS, rtol=TIGHT, **kwargs)
    assert found.walked.all()
    return found[:3]


@pytest.mark.parametrize("moving", [(True, True), (True, False), (False, True)])
def test_gradients_by_state_and_control_are_exact(moving: tuple[bool, bool]) -> None:
    inputs = states(3), actions(3)
    for tensor, moves in zip(inputs, moving, strict=True):
        tensor.requires_grad_(moves)
    assert gradcheck(strides, inputs, eps=1e-5, atol=1e-7, rtol=1e-5)


def test_gradients_by_the_walker_are_exact_for_one_and_for_many() -> None:
    radius = torch.tensor(PARAMS.foot_radius, dtype=torch.float64, requires_grad=True)
    slopes = torch.tensor([1e-3, -1e-3, 0.0], dtype=torch.float64, requires_grad=True)

    def by_walker(one: torch.Tensor, many: torch.Tensor) -> tuple[torch.Tensor, ...]:
        return strides(states(3), actions(3), parameters={"foot_radius": one, "slope": many})

    assert gradcheck(by_walker, (radius, slopes), eps=1e-5, atol=1e-6, rtol=1e-5)


def test_gradients_through_three_strides_with_feedback_are_exact() -> None:
    gait = torch.tensor(STATE, dtype=torch.float64)

    def walk(gain: torch.Tensor) -> torch.Tensor:
        state = states(2)
        for _ in range(3):
            state, *_ = strides(state, (state - gait) @ gain)
        return state

    gain = torch.tensor(np.random.default_rng(2).normal(0.0, 0.1, (4, 2)), requires_grad=True)
    assert gradcheck(walk, (gain,), eps=1e-6, atol=1e-6, rtol=1e-5)


def test_gradients_of_a_passive_walker_are_exact() -> None:
    gait = PASSIVE_GAITS[0]
    start = torch.tensor([gait.state], dtype=torch.float64, requires_grad=True)
    slope = torch.tensor(gait.params.slope, dtype=torch.float64, requires_grad=True)

    def roll(state: torch.Tensor, incline: torch.Tensor) -> torch.Tensor:
        found = differentiable_strides(
            state, None, gait.params, parameters={"slope": incline}, rtol=TIGHT
        )
        assert found.walked.all()
        return found.state

    assert gradcheck(roll, (start, slope), eps=1e-6, atol=1e-5, rtol=1e-5)


def test_strides_are_those_of_the_batch_with_and_without_gradients() -> None:
    plain = stride_batch(states(20).numpy(), NOMINAL.numpy(), PARAMS)
    for start in (states(20), states(20).requires_grad_()):
        found = differentiable_strides(start, NOMINAL, PARAMS)
        np.testing.assert_array_equal(found.state.detach().numpy(), plain.state)
        np.testing.assert_array_equal(found.duration.detach().numpy(), plain.duration)
        np.testing.assert_array_equal(found.step_length.detach().numpy(), plain.step_length)


def test_single_precision_goes_in_and_comes_out() -> None:
    start = states(4).float().requires_grad_()
    control = NOMINAL.clone().requires_grad_()  # of another precision, and shared by all rows
    found = differentiable_strides(start, control, PARAMS)
    assert {tensor.dtype for tensor in found[:3]} == {torch.float32}
    found.state[:, 2].sum().backward()
    known = differentiate_batch(start.detach().numpy(), NOMINAL.numpy(), PARAMS)
    assert start.grad is not None and control.grad is not None
    assert (start.grad.dtype, control.grad.dtype) == (torch.float32, torch.float64)
    np.testing.assert_allclose(start.grad.numpy(), known.by_state[:, 2], rtol=1e-6)
    np.testing.assert_allclose(control.grad.numpy(), known.by_control[:, 2].sum(0), rtol=1e-12)


def test_a_fall_is_not_a_number_and_passes_no_gradient() -> None:
    start = states(3)
    start[1] = FALLEN
    start.requires_grad_()
    found = differentiable_strides(start, NOMINAL, PARAMS)
    assert found.walked.tolist() == [True, False, True]
    assert found.state[1].isnan().all()
    assert found.step_length[1] == 0
    (found.state.sum() + found.duration.sum()).backward()  # NaN comes back for the fallen row
    assert start.grad is not None
    np.testing.assert_array_equal(start.grad[1], np.zeros(4))
    alone = states(3)[[0, 2]].requires_grad_()
    others = differentiable_strides(alone, NOMINAL, PARAMS)
    (others.state.sum() + others.duration.sum()).backward()
    assert alone.grad is not None
    np.testing.assert_array_equal(start.grad[[0, 2]], alone.grad)


def test_a_loss_that_leaves_the_fallen_out_has_finite_gradients() -> None:
    gain = torch.zeros((4, 2), dtype=torch.float64, requires_grad=True)
    start, gait = states(3), torch.tensor(STATE, dtype=torch.float64)
    start[1] = FALLEN
    for _ in range(2):
        found = differentiable_strides(start, NOMINAL + (start - gait) @ gain * UNITS, PARAMS)
        start = torch.where(found.walked[:, None], found.state, gait)
    start.square().sum().backward()
    assert gain.grad is not None and gain.grad.isfinite().all() and gain.grad.any()


def test_derivatives_are_calculated_only_if_they_are_wanted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    widths, calculate = [], adapter.run_derivatives

    def counted(*args: Any) -> Any:
        widths.append(len(args[-1]))
        return calculate(*args)

    monkeypatch.setattr(adapter, "run_derivatives", counted)
    moving, fixed = states(2).requires_grad_(), states(2)
    control = NOMINAL.clone().requires_grad_()
    assert not differentiable_strides(fixed, NOMINAL, PARAMS).state.requires_grad
    with torch.no_grad():
        differentiable_strides(moving, control, PARAMS)
    assert widths == []
    differentiable_strides(moving, NOMINAL, PARAMS)
    differentiable_strides(fixed, control, PARAMS)
    differentiable_strides(moving, control, PARAMS)
    assert widths == [4, 2, 6]


@pytest.mark.parametrize("name", DECIDING)
def test_gradients_of_every_scheme_are_its_derivatives(name: str) -> None:
    gait = gait_of(name)
    start = torch.tensor([gait.state], dtype=torch.float64, requires_grad=True)
    numbers = [getattr(gait.control, each) for each in SCHEMES[name].numbers]
    control = torch.tensor(numbers, dtype=torch.float64, requires_grad=True)
    found = differentiable_strides(start, control, gait.params, scheme=name, rtol=TIGHT)
    found.state[:, 2].sum().backward()
    known = differentiate_batch([gait.state], gait.control, gait.params, rtol=TIGHT)
    assert start.grad is not None and control.grad is not None
    np.testing.assert_allclose(start.grad.numpy(), known.by_state[:, 2], rtol=1e-12)
    np.testing.assert_allclose(control.grad.numpy(), known.by_control[0, 2], rtol=1e-12)
    same = differentiable_strides(start, gait.control, gait.params, rtol=TIGHT)
    np.testing.assert_array_equal(same.state.detach().numpy(), found.state.detach().numpy())


@pytest.mark.parametrize("name", DECIDING)
def test_gradients_under_a_policy_are_those_of_the_closed_loop(name: str) -> None:
    gait = gait_of(name)
    law = regulate(gait, half_range(gait))
    start = torch.tensor([gait.state], dtype=torch.float64, requires_grad=True)
    differentiable_strides(start, law, gait.params, rtol=TIGHT).state[:, 3].sum().backward()
    known = differentiate_batch([gait.state], law, gait.params, rtol=TIGHT)
    assert start.grad is not None
    np.testing.assert_allclose(start.grad.numpy(), known.by_state[:, 3], rtol=1e-12)
    with torch.no_grad():
        walked = differentiable_strides(start, law, gait.params)
    np.testing.assert_array_equal(
        walked.state.numpy(), stride_batch([gait.state], law, gait.params).state
    )


def test_a_module_is_called_with_the_states() -> None:
    layer = torch.nn.Linear(4, 2).double()
    with torch.no_grad():
        layer.weight.zero_()
        layer.bias.copy_(NOMINAL)
    found = differentiable_strides(states(3), layer, PARAMS)
    np.testing.assert_array_equal(
        found.state.detach().numpy(), differentiable_strides(states(3), NOMINAL, PARAMS).state
    )
    found.state.square().sum().backward()
    assert layer.weight.grad is not None and layer.weight.grad.any()


def test_second_derivatives_are_refused() -> None:
    start = states(1).requires_grad_()
    found = differentiable_strides(start, NOMINAL, PARAMS).state.square().sum()
    (slope,) = torch.autograd.grad(found, start, create_graph=True)
    with pytest.raises(RuntimeError, match="once_differentiable"):
        slope.sum().backward()


@pytest.mark.parametrize(
    ("changes", "error", "message"),
    [
        ({"states": torch.zeros(4)}, ValueError, r"states must have shape \(N, 4\), got \(4,\)"),
        (
            {"states": torch.full((1, 4), torch.nan)},
            ValueError,
            r"states must be finite, .* row 0; put a start .* torch\.where",
        ),
        ({"states": torch.zeros((1, 4), dtype=torch.int64)}, TypeError, "states must be of type"),
        ({"states": np.zeros((1, 4))}, TypeError, "states must be a tensor, got array"),
        ({"controls": torch.zeros((3, 2))}, ValueError, "controls must have one row for each"),
        ({"controls": torch.tensor([7.0, 1.0])}, ValueError, "controls: switch_angle must lie"),
        (
            {"parameters": {"foot_radius": torch.tensor(-1.0)}},
            ValueError,
            "foot_radius must not be negative",
        ),
        (
            {"parameters": {"slope": torch.zeros(3)}},
            ValueError,
            r"parameter slope must have shape \(\) or \(1,\), got \(3,\)",
        ),
        (
            {"parameters": {"stall_torque": torch.tensor(1.0)}},
            ValueError,
            "got 'stall_torque'; pass it in controls",
        ),
        ({"parameters": {"mass": torch.tensor(1.0)}}, ValueError, "parameters are of .*'mass'"),
        ({"rtol": 0.1}, ValueError, "rtol must lie in"),
        ({"rtol": None}, TypeError, "rtol must be a real number, got None"),
        (
            {"params": [WalkerParams()]},
            TypeError,
            "params must be one WalkerParams, got .* goes in",
        ),
        ({"controls": ToeOff(0.1), "scheme": "motor"}, ValueError, "got one of scheme 'toe-off'"),
        ({"scheme": "rocket"}, ValueError, "scheme must be one of"),
    ],
)
def test_bad_input_is_named(changes: dict[str, Any], error: type[Exception], message: str) -> None:
    good: dict[str, Any] = {"states": states(1), "controls": NOMINAL, "params": WalkerParams()}
    with pytest.raises(error, match=message):
        differentiable_strides(**{**good, **changes})
